//! `cargo xtask results`: makes docs/results.md, the README's pictures and its tables, with the commands that
//! did it.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    thread,
};

use anyhow::{Context as _, ensure};
use clap::Args;

use crate::{
    gallery::jpeg_from_png,
    workspace::{call, release_binary, root},
};

/// What the pictures and tables of the README are asked for by.
const README: &str = "readme";
const BEGIN: &str = "<!-- results:begin -->";
const END: &str = "<!-- results:end -->";
/// Turns of 1 thread and all threads, one after the other, so that a drifting machine meets both.
const SCALING_ROUNDS: usize = 5;

/// Measure the claims.
#[derive(Args)]
pub(crate) struct Results {
    /// Experiments to make again, or `readme` for its pictures and tables; all if none is given. The rest
    /// stays as it is.
    names: Vec<String>,
    /// Keep what this commit has measured already: goes on where a run was interrupted.
    #[arg(long)]
    resume: bool,
    /// A scene file to take part in the experiments.
    #[arg(long = "file", value_name = "FILE")]
    files: Vec<String>,
}

/// The scenes of the README: name, camera, time of the first frame and frames that are played, of which the
/// last is shown.
const PICTURES: [(&str, &str, &str, &str); 5] = [
    ("smoke-square", "path", "0", "48"),
    ("arena", "static", "6", "24"),
    ("motor", "orbit", "0", "24"),
    ("windy-hill", "static", "0", "24"),
    ("hairball", "orbit", "0", "24"),
];

impl Results {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        call("cargo", &["build", "--release", "--package", "sheer", "--locked"])?;
        self.experiments()?;
        if self.is_wanted(README) {
            pictures()?;
            readme()?;
        }
        Ok(())
    }

    fn is_wanted(&self, name: &str) -> bool {
        self.names.is_empty() || self.names.iter().any(|wanted| wanted == name)
    }

    /// Makes docs/results.md and the pictures and charts that it shows, a section after the other, so that an
    /// interrupted run has lost one.
    fn experiments(&self) -> anyhow::Result<()> {
        let listing = sheer(&["experiments", "--list"])?;
        let known = listing.lines().map(Listed::new).collect::<anyhow::Result<Vec<_>>>()?;
        for name in self.names.iter().filter(|name| *name != README) {
            ensure!(known.iter().any(|experiment| experiment.id == name), "there is no experiment '{name}'");
        }
        for experiment in known.iter().filter(|experiment| self.is_wanted(experiment.id)) {
            self.section(experiment, &known)?;
        }
        Ok(())
    }

    /// Makes one section, its pictures and charts, and puts it in its place.
    fn section(&self, experiment: &Listed<'_>, known: &[Listed<'_>]) -> anyhow::Result<()> {
        let id = experiment.id;
        let out = root().join("sheer-out/experiments").join(id);
        let written = out.join("results.md");
        if !(self.resume && is_of_this_commit(&written)?) {
            if out.exists() {
                fs::remove_dir_all(&out)?;
            }
            let out_text = out.display().to_string();
            let mut arguments = vec!["experiments", id, "-o", &out_text];
            arguments.extend(self.files.iter().flat_map(|file| ["--file", file]));
            sheer(&arguments)?;
        }

        // Pictures and charts are named after the experiment and numbered.
        let shown = root().join("docs/results");
        fs::create_dir_all(&shown)?;
        for old in files(&shown)? {
            if stem(&old).rsplit_once('-').is_some_and(|(of, _)| of == id) {
                fs::remove_file(old)?;
            }
        }
        for path in files(&out)? {
            let target = shown.join(stem(&path));
            match path.extension().and_then(|ending| ending.to_str()) {
                Some("png") => jpeg_from_png(&path, &target.with_extension("jpg"))?,
                Some("svg") => drop(fs::copy(&path, target.with_extension("svg"))?),
                _ => {}
            }
        }

        let document = root().join("docs/results.md");
        let before = if document.exists() { fs::read_to_string(&document)? } else { String::new() };
        let text = fs::read_to_string(written)?.replace("](./", "](results/").replace(".png)", ".jpg)");
        fs::write(document, with_section(&before, known, &text)?)?;
        Ok(())
    }
}

/// An experiment as `sheer experiments --list` has it.
struct Listed<'a> {
    id: &'a str,
    title: &'a str,
}

impl<'a> Listed<'a> {
    /// From a line `ID TITLE (SOURCE)`.
    fn new(line: &'a str) -> anyhow::Result<Self> {
        let (id, rest) = line.split_once(' ').with_context(|| format!("no experiment: {line}"))?;
        let (title, _) = rest.rsplit_once(" (").with_context(|| format!("no source: {line}"))?;
        Ok(Self { id, title: title.trim() })
    }
}

/// The document with a section made anew from the report of its experiment, and all sections in the order of
/// the list. Each says at its end what it was made by.
fn with_section(document: &str, known: &[Listed<'_>], report: &str) -> anyhow::Result<String> {
    // A report has its heading, what it was made by, how it is to be read, and sections, here one.
    let mut paragraphs = report.splitn(4, "\n\n").skip(1);
    let mut next = || paragraphs.next().context("the report is cut short");
    let (origin, guide, section) = (next()?, next()?, next()?);
    let heading = section.lines().next().unwrap_or_default();
    let made = format!("{}\n\n{origin}\n", section.trim_end());

    let mut text = format!(
        "# Results\n\nMade by `cargo xtask results`; each section says at its end of which commit. {guide}\n"
    );
    let old: Vec<String> =
        document.split("\n## ").skip(1).map(|section| format!("## {}\n", section.trim_end())).collect();
    for experiment in known {
        let wanted = format!("## {}", experiment.title);
        let kept = old.iter().find(|section| section.lines().next() == Some(&wanted));
        if let Some(section) = if heading == wanted { Some(&made) } else { kept } {
            text += &format!("\n{section}");
        }
    }
    Ok(text)
}

/// Whether a report was made by the commit that is checked out.
fn is_of_this_commit(report: &Path) -> anyhow::Result<bool> {
    if !report.exists() {
        return Ok(false);
    }
    let output =
        Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).current_dir(root()).output()?;
    let commit = String::from_utf8(output.stdout)?;
    Ok(fs::read_to_string(report)?.contains(&format!("commit `{}`", commit.trim())))
}

fn files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect()
}

fn stem(path: &Path) -> &str {
    path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default()
}

/// The README's tables.
fn readme() -> anyhow::Result<()> {
    let cores = thread::available_parallelism()?.get();
    let mut section = format!(
        "## Results\n\n[docs/results.md](docs/results.md) has the figures of both papers, measured, and says of each claim whether it held. What follows was \
         made by `cargo xtask results` on {cores} cores{}. Time is that of a whole frame without temporal anti-aliasing; SSIM, PSNR and FLIP are \
         taken on the displayed picture, against `baseline` under the same anti-aliasing where the table does not say truth; RMS and bias in linear light.\n",
        processor().map(|name| format!(" ({name})")).unwrap_or_default()
    );
    let experiments: [(&str, &str); 4] = [
        ("What the first command of this page prints, layered accumulation:", "compare -o sheer-out/results"),
        (
            "The same under plain temporal anti-aliasing, and both held against the truth, 32 samples a pixel at the moment of each frame:",
            "compare --size 240x135 -a layered -a taa -m baseline -m joint -m std -m stbn --reference truth -o sheer-out/results-truth",
        ),
        (
            "Inside the smoke, time of a frame:",
            "bench smoke-square --time 5 --size 240x135 --frames 3 -m baseline -m baseline:trace=continuation -m std -m joint -m roulette",
        ),
        (
            "An engine of 322,000 transparent triangles, by what composites them:",
            "compare motor --size 480x270 --frames 4 -a none -m std -m stochastic -m weighted -m moments -m mlab -m kbuffer -m peel:layers=4 \
             -o sheer-out/results-motor",
        ),
    ];
    for (title, arguments) in experiments {
        let table = sheer(&arguments.split(' ').collect::<Vec<_>>())?;
        section += &format!("\n{title}\n\n```text\n$ sheer {arguments}\n{table}```\n");
    }
    section += &format!("\n{}\n", scaling(cores)?);
    insert(&section)
}

/// The pictures of the README.
fn pictures() -> anyhow::Result<()> {
    for (scene, camera, time, frames) in PICTURES {
        let png = root().join(format!("docs/{scene}.png"));
        let out = png.display().to_string();
        let clip = ["--camera", camera, "--time", time, "--frames", frames];
        sheer(&[&["render", scene, "-m", "joint", "-a", "layered", "-o", &out][..], &clip].concat())?;
        jpeg_from_png(&png, &png.with_extension("jpg"))?;
    }
    Ok(())
}

/// How much faster all cores are than one.
fn scaling(cores: usize) -> anyhow::Result<String> {
    let median = |threads: usize| -> anyhow::Result<f64> {
        let threads = threads.to_string();
        let table = sheer(&[
            "bench",
            "smoke-square",
            "--time",
            "3",
            "--size",
            "480x270",
            "--frames",
            "5",
            "-m",
            "std",
            "--threads",
            &threads,
        ])?;
        let row = table.lines().last().context("bench printed no row")?;
        let ms = row.split_whitespace().nth(1).context("bench printed no time")?;
        Ok(ms.parse()?)
    };
    let mut ratios = Vec::new();
    for _ in 0..SCALING_ROUNDS {
        ratios.push(median(1)? / median(cores)?);
    }
    ratios.sort_by(f64::total_cmp);
    let (low, middle, high) = (ratios[0], ratios[SCALING_ROUNDS / 2], ratios[SCALING_ROUNDS - 1]);
    Ok(format!(
        "{cores} threads render a frame of `smoke-square` {middle:.2} times as fast as one (median of {SCALING_ROUNDS} pairs, {low:.2} to \
         {high:.2}), with the same bits."
    ))
}

/// Runs the program and returns what it prints on stdout.
fn sheer(arguments: &[&str]) -> anyhow::Result<String> {
    eprintln!("$ sheer {}", arguments.join(" "));
    let mut command = Command::new(release_binary());
    let output = command.args(arguments).arg("--quiet").current_dir(root()).output()?;
    ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Ok(String::from_utf8(output.stdout)?)
}

/// The processor's name, where the system tells it.
fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn insert(section: &str) -> anyhow::Result<()> {
    let path = root().join("README.md");
    let text = fs::read_to_string(&path)?;
    let (before, rest) = text.split_once(BEGIN).context("README.md has no results:begin")?;
    let (_, after) = rest.split_once(END).context("README.md has no results:end")?;
    fs::write(path, format!("{before}{BEGIN}\n{section}{END}{after}"))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPORT: &str = "# Results\n\nMade of commit `new`.\n\nA cross is a miss.\n\n## Smoke\n\n*Source.* What is done.\n\n* held\n";

    fn known() -> [Listed<'static>; 3] {
        [("fight", "A fight"), ("smoke", "Smoke"), ("pane", "A pane")].map(|(id, title)| Listed { id, title })
    }

    #[test]
    fn a_line_of_the_list_is_name_and_title() {
        let listed = Listed::new("fight          A fight (full of effects) (STD Fig. 1, 8 and 14)").unwrap();
        assert_eq!((listed.id, listed.title), ("fight", "A fight (full of effects)"));
        assert!(Listed::new("fight").is_err() && Listed::new("fight A fight").is_err());
    }

    #[test]
    fn a_section_takes_the_place_of_its_old_one() {
        let first = with_section("", &known(), REPORT).unwrap();
        let section = "## Smoke\n\n*Source.* What is done.\n\n* held\n\nMade of commit `new`.\n";
        assert!(first.ends_with(&format!("A cross is a miss.\n\n{section}")), "{first}");

        let old = "# Results\n\nOld.\n\n## A pane\n\nold pane\n\n## Smoke\n\nold smoke\n\n## A fight\n\nold fight\n";
        let text = with_section(old, &known(), REPORT).unwrap();
        let sections = format!("\n## A fight\n\nold fight\n\n{section}\n## A pane\n\nold pane\n");
        assert!(text.ends_with(&sections) && !text.contains("old smoke"), "{text}");
        assert_eq!(with_section(&text, &known(), REPORT).unwrap(), text);
    }

    #[test]
    fn a_report_that_is_cut_short_is_refused() {
        assert!(with_section("", &known(), "# Results\n\nMade of commit `new`.\n").is_err());
    }
}
