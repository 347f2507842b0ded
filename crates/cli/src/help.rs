//! The parser, with help that teaches: the long help of every command ends with worked examples.

use std::fmt::Write as _;

use clap::CommandFactory as _;

use crate::args::Arguments;

/// A line that does something worth doing.
pub(crate) struct Example {
    /// What it does, in a few words.
    pub(crate) what: &'static str,
    /// As it is typed, within 76 characters: a terminal of 80 shows it whole. `crates/cli/tests/cli/help.rs`
    /// reads it from the help and runs it, and has the files that it names.
    pub(crate) line: &'static str,
}

const fn example(what: &'static str, line: &'static str) -> Example {
    Example { what, line }
}

/// The examples of each command, the plainest first; one may use what those before it in the list have made.
const EXAMPLES: &[(&str, [Example; 3])] = &[
    (
        "scenes",
        [
            example("What there is", "sheer scenes"),
            example("With the parameters of each", "sheer scenes --long"),
            example("One of them, with a parameter", "sheer render layers:count=3 -o layers.png"),
        ],
    ),
    (
        "methods",
        [
            example("What there is", "sheer methods"),
            example("With their keys, and with anti-aliasing and shadow techniques", "sheer methods --long"),
            example("One of them, with a key", "sheer render model.glb -m std:hybrid=0.5 -o picture.png"),
        ],
    ),
    (
        "devices",
        [
            example("What there is", "sheer devices"),
            example("The same for a program", "sheer devices --json devices.json"),
            example("With what the graphics library has to say", "RUST_LOG=warn sheer devices"),
        ],
    ),
    (
        "inspect",
        [
            example("What a file holds, asks for, and what becomes of it", "sheer inspect model.glb"),
            example("The same for a program", "sheer inspect model.glb --json model.json"),
            example("The views of a built-in scene, as --eye and --target take them", "sheer inspect pane"),
        ],
    ),
    (
        "render",
        [
            example("A picture of a file", "sheer render model.glb -o picture.png"),
            example(
                "A final still for a slide: transparent, from a place of your own",
                "sheer render model.glb --eye 2,1,3 --samples 256 --background none -o a.png",
            ),
            example(
                "A turntable of twelve seconds, as a video",
                "sheer render model.glb --camera orbit --frames 360 -o turn.mp4",
            ),
        ],
    ),
    (
        "merge",
        [
            example(
                "The first quarter of the samples of a final still, on one of four machines",
                "sheer render model.glb --samples 256 --sample-range 0..64 -o part-1.exr",
            ),
            example("What the four have rendered", "sheer merge part-*.exr -o final.png"),
            example(
                "Two halves of a picture, of --crop 0,0,480,540 and 480,0,480,540",
                "sheer merge left.exr right.exr -o final.exr",
            ),
        ],
    ),
    (
        "compare",
        [
            example("The methods of the STD paper and our own, in a built-in scene", "sheer compare pane"),
            example(
                "Two methods and the exact one on your file, with figures for a spreadsheet",
                "sheer compare model.glb --alpha 0.3 -m std -m joint --csv a.csv -o report",
            ),
            example(
                "Against the truth, with a table for a paper",
                "sheer compare model.glb -m joint --reference truth --latex a.tex -o report",
            ),
        ],
    ),
    (
        "metrics",
        [
            example("Two pictures", "sheer metrics reference.png picture.png"),
            example(
                "Clips from elsewhere, with a page to look at",
                "sheer metrics truth a=theirs b=ours --html page",
            ),
            example(
                "As an observer would see them, for a program",
                "sheer metrics \"truth/####.exr\" \"theirs/####.png\" --vdp --json -",
            ),
        ],
    ),
    (
        "bench",
        [
            example(
                "What two methods cost beside the exact one",
                "sheer bench model.glb -m baseline -m std -m joint",
            ),
            example(
                "With what adding up over time costs, as page and figures",
                "sheer bench model.glb -a layered -m joint --html b.html --json b.json",
            ),
            example("On one thread, for a spreadsheet", "sheer bench model.glb --threads 1 --csv bench.csv"),
        ],
    ),
    (
        "calibrate",
        [
            example("What a method shows of ten opacities", "sheer calibrate -m std"),
            example(
                "The correction as a file, with a page to look at",
                "sheer calibrate -m std -o correction.json --html correction.html",
            ),
            example("Put to use", "sheer render model.glb -m std:correction=correction.json -a taa -o a.png"),
        ],
    ),
    (
        "experiments",
        [
            example("What there is", "sheer experiments --list"),
            example("One figure", "sheer experiments visibility -o report"),
            example(
                "Another, in larger pictures, with claims that rest on five seeds",
                "sheer experiments moving-pane --size 480x270 --seeds 5 -o report",
            ),
        ],
    ),
    (
        "verify",
        [
            example("All that the papers print and the methods promise", "sheer verify"),
            example("With the figures for a program", "sheer verify --json figures.json"),
            example(
                "Your GPU against the processor, in one scene",
                "sheer verify layers -m joint --backend gpu",
            ),
        ],
    ),
    (
        "completions",
        [
            example("Bash", "sheer completions bash > ~/.local/share/bash-completion/completions/sheer"),
            example("Zsh, with ~/.zfunc in fpath", "sheer completions zsh > ~/.zfunc/_sheer"),
            example("Fish", "sheer completions fish > ~/.config/fish/completions/sheer.fish"),
        ],
    ),
];

/// The command line with its help.
pub(crate) fn parser() -> clap::Command {
    Arguments::command().mut_subcommands(|command| match examples(command.get_name()) {
        [] => command,
        examples => command.after_long_help(text(examples)),
    })
}

/// The examples of a command; none of one that help does not list.
pub(crate) fn examples(command: &str) -> &'static [Example] {
    EXAMPLES.iter().find(|(name, _)| *name == command).map_or(&[], |(_, examples)| examples)
}

fn text(examples: &[Example]) -> String {
    examples.iter().fold("Examples:".to_owned(), |mut text, Example { what, line }| {
        let _ = write!(text, "\n  {what}:\n    {line}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_argument_table_is_consistent() {
        parser().debug_assert();
    }

    #[test]
    fn every_command_has_examples_and_no_other() {
        let parser = parser();
        let visible = parser.get_subcommands().filter(|command| !command.is_hide_set());
        let names: Vec<&str> = visible.map(clap::Command::get_name).collect();
        assert_eq!(EXAMPLES.iter().map(|(name, _)| *name).collect::<Vec<_>>(), names);
    }

    /// Of the line, without variables and shell.
    fn words(line: &str) -> Vec<String> {
        let line = line.split(" > ").next().unwrap_or_default().replace('"', "");
        line.split(' ').skip_while(|word| *word != "sheer").map(str::to_owned).collect()
    }

    #[test]
    fn examples_are_right_use_and_short() {
        for Example { line, .. } in EXAMPLES.iter().flat_map(|(_, examples)| examples) {
            assert!(line.len() <= 76, "{line}: {}", line.len());
            // A correction is read as it is parsed, and here there is none.
            let line = line.replace("correction=correction.json", "correction=dlss");
            let parsed = parser().try_get_matches_from(words(&line));
            assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
        }
        assert!(parser().try_get_matches_from(words("sheer render --sise 8x8")).is_err());
    }

    #[test]
    fn the_commands_of_the_guide_are_right_use() {
        let guide = include_str!("../../../docs/how-to.md");
        let commands: Vec<&str> = guide.split('`').filter(|span| span.starts_with("sheer ")).collect();
        assert!(commands.len() > 15, "{commands:?}");
        for command in commands {
            let parsed = parser().try_get_matches_from(words(command));
            assert!(parsed.is_ok(), "{command}: {}", parsed.unwrap_err());
        }
    }
}
