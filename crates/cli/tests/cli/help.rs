//! Help that teaches: examples that run, completions, manual pages.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use crate::run::{names_in, sheer, stand_in, succeed};

/// Examples that take long. The tests of `verify` run the second, which does what the first does, and hold a
/// GPU against the processor as the third does.
const RUN_ELSEWHERE: [&str; 3] =
    ["sheer verify", "sheer verify --json figures.json", "sheer verify layers -m joint --backend gpu"];

/// The commands that help lists.
fn commands(folder: &Path) -> Vec<String> {
    let help = succeed(folder, "--help").stdout;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    // A description may go on in the next line, further in.
    let named = listed.take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("   "));
    let names = named.map(|line| line.split_whitespace().next().unwrap().to_owned());
    names.filter(|name| name != "help").collect()
}

/// The lines below `Examples:` that are typed.
fn examples(help: &str) -> Vec<String> {
    let below = help.lines().skip_while(|line| *line != "Examples:");
    below.filter_map(|line| line.strip_prefix("    ")).map(str::to_owned).collect()
}

/// The same line for a small picture and few frames, as far as its command has such things.
fn quick(line: &str) -> String {
    let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
    let at = words.iter().position(|word| word == "sheer").unwrap();
    let command = words[at + 1].clone();
    let is = |among: &[&str]| among.contains(&command.as_str());
    let has_frames = is(&["render", "compare", "bench", "calibrate"]);
    let has_size = has_frames || is(&["experiments"]);
    let mut set = |option: &str, value: &str, is_taken: bool| {
        let given = words.iter().position(|word| word == option);
        match given {
            Some(at) => value.clone_into(&mut words[at + 1]),
            None if is_taken => words.extend([option.to_owned(), value.to_owned()]),
            None => {}
        }
    };
    // Ten columns of opacities want more pixels; experiments have as many frames as their figures.
    let size = match command.as_str() {
        "calibrate" => "160x90",
        "experiments" => "32x18",
        _ => "64x36",
    };
    set("--size", size, has_size);
    set("--frames", "4", has_frames);
    set("--samples", "4", false);
    set("--sample-range", "0..1", false);
    set("--seeds", "1", false);
    words.join(" ")
}

/// Runs a line in a shell that finds the program, what stands in for others in `bin`, and a home in the
/// folder.
fn shell(folder: &Path, line: &str) -> Output {
    let program = PathBuf::from(env!("CARGO_BIN_EXE_sheer"));
    let path = env::join_paths(
        [program.parent().unwrap().to_owned(), folder.join("bin")]
            .into_iter()
            .chain(env::split_paths(&env::var_os("PATH").unwrap())),
    );
    let mut shell = Command::new("sh");
    shell.args(["-c", line]).current_dir(folder).env("HOME", folder).env("PATH", path.unwrap());
    shell.output().unwrap()
}

/// A triangle of which half is seen through, by itself in a file.
const MODEL: &str = r#"{"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "materials": [{"alphaMode": "BLEND", "doubleSided": true,
                   "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.3, 0.2, 0.5]}}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3,
                   "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

#[test]
fn every_command_ends_its_help_with_three_examples_that_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // What the examples name.
    fs::write(folder.join("model.glb"), MODEL).unwrap();
    for made in [
        "truth",
        "theirs",
        "ours",
        ".local/share/bash-completion/completions",
        ".zfunc",
        ".config/fish/completions",
    ] {
        fs::create_dir_all(folder.join(made)).unwrap();
    }
    stand_in(folder, "ffmpeg", "for file; do :; done; cat > \"$file\"");
    let clip = "render model.glb --camera orbit --size 64x36 --frames 3 -a none";
    succeed(folder, &format!("{clip} -m baseline -o truth/####.exr"));
    succeed(folder, &format!("{clip} -m joint -o ours/####.exr"));
    succeed(folder, &format!("{clip} -m std -o theirs/####.png"));
    let still = "render model.glb --size 64x36";
    succeed(folder, &format!("{still} -m baseline -a none -o reference.png"));
    for part in 2..=4 {
        let range = format!("--samples 4 --sample-range {}..{part}", part - 1);
        succeed(folder, &format!("{still} {range} -o part-{part}.exr"));
    }
    for (half, crop) in [("left", "0,0,32,36"), ("right", "32,0,32,36")] {
        succeed(folder, &format!("{still} --samples 4 --crop {crop} -o {half}.exr"));
    }

    let mut run_elsewhere = 0;
    for command in commands(folder) {
        let lines = examples(&succeed(folder, &format!("{command} --help")).stdout);
        assert_eq!(lines.len(), 3, "{command}: {lines:?}");
        assert!(examples(&succeed(folder, &format!("{command} -h")).stdout).is_empty(), "{command}");
        for line in &lines {
            if RUN_ELSEWHERE.contains(&line.as_str()) {
                run_elsewhere += 1;
                continue;
            }
            let output = shell(folder, &quick(line));
            assert!(output.status.success(), "{line}: {output:?}");
        }
    }
    assert_eq!(run_elsewhere, RUN_ELSEWHERE.len());
    // The check is not blind.
    assert!(!shell(folder, &quick("sheer render model.glb --sise 8x8 -o b.png")).status.success());
    assert!(fs::read_to_string(folder.join(".zfunc/_sheer")).unwrap().contains("--warm-up"));
}

#[test]
fn every_shell_has_completions_and_another_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = succeed(folder.path(), &format!("completions {shell}")).stdout;
        assert!(script.contains("skip-existing") && script.contains("calibrate"), "{shell}: {script}");
    }
    assert_eq!(sheer(folder.path(), "completions tcsh").code, Some(2));
}

#[test]
fn the_manual_has_a_page_for_each_command() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "man pages");
    let pages = folder.path().join("pages");
    let mut expected: Vec<String> = (commands(folder.path()).iter())
        .map(|command| format!("sheer-{command}.1"))
        .chain(["sheer.1".to_owned()])
        .collect();
    expected.sort();
    assert_eq!(names_in(&pages), expected);
    let page = fs::read_to_string(pages.join("sheer-render.1")).unwrap();
    assert!(page.contains(".TH sheer-render 1") && page.contains("orbit"), "{page}");
    let example = "\n.nf\nsheer render model.glb \\-o picture.png\n.fi\n";
    assert!(page.contains(".SH EXAMPLES\n") && page.contains(example) && !page.contains("EXTRA"), "{page}");
}
