//! `cargo xtask results`: makes docs/results.md, the README's pictures and its tables, with the commands that
//! did it.

use std::{fs, process::Command, thread};

use anyhow::{Context as _, ensure};
use clap::Args;

use crate::{
    gallery::jpeg_from_png,
    workspace::{call, release_binary, root},
};

const BEGIN: &str = "<!-- results:begin -->";
const END: &str = "<!-- results:end -->";
/// Turns of 1 thread and all threads, one after the other, so that a drifting machine meets both.
const SCALING_ROUNDS: usize = 5;

/// Measure the claims.
#[derive(Args)]
pub(crate) struct Results {
    /// Experiments to make again, all if none is given; with a name, pictures and README stay as they are.
    names: Vec<String>,
    /// A scene file to take part in the experiments.
    #[arg(long = "file", value_name = "FILE")]
    files: Vec<String>,
}

/// The scenes of the README: name, time and frames that are added up.
const PICTURES: [(&str, &str, &str); 5] = [
    ("smoke-square", "0", "64"),
    ("arena", "6.4", "48"),
    ("motor", "0", "48"),
    ("windy-hill", "0", "64"),
    ("hairball", "0", "64"),
];

impl Results {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        call("cargo", &["build", "--release", "--package", "sheer", "--locked"])?;
        self.experiments()?;
        if !self.names.is_empty() {
            return Ok(());
        }
        pictures()?;
        readme()
    }

    /// Makes docs/results.md and the pictures and charts that it shows.
    fn experiments(&self) -> anyhow::Result<()> {
        let out = root().join("sheer-out/experiments");
        let shown = root().join("docs/results");
        if out.exists() {
            fs::remove_dir_all(&out)?;
        }
        let out_text = out.display().to_string();
        let mut arguments: Vec<&str> = vec!["experiments", "-o", &out_text];
        arguments.extend(self.names.iter().map(String::as_str));
        arguments.extend(self.files.iter().flat_map(|file| ["--file", file]));
        sheer(&arguments)?;
        if self.names.is_empty() && shown.exists() {
            fs::remove_dir_all(&shown)?;
        }
        fs::create_dir_all(&shown)?;
        for entry in fs::read_dir(&out)? {
            let path = entry?.path();
            let (Some(stem), Some(ending)) = (path.file_stem(), path.extension()) else { continue };
            let target = shown.join(stem);
            if ending == "png" {
                jpeg_from_png(&path, &target.with_extension("jpg"))?;
            } else if ending == "svg" {
                fs::copy(&path, target.with_extension("svg"))?;
            }
        }
        if self.names.is_empty() {
            let text = fs::read_to_string(out.join("results.md"))?;
            let text = text.replace("](./", "](results/").replace(".png)", ".jpg)");
            fs::write(root().join("docs/results.md"), text)?;
        }
        Ok(())
    }
}

/// The README's tables.
fn readme() -> anyhow::Result<()> {
    let cores = thread::available_parallelism()?.get();
    let mut section = format!(
        "## Results\n\n[docs/results.md](docs/results.md) has the figures of both papers, measured, and says of each claim whether it held. What follows was \
         made by `cargo xtask results` on {cores} cores{}. Time is that of a whole frame without temporal anti-aliasing; SSIM, PSNR and FLIP are \
         taken on the displayed picture against `baseline`, RMS and bias in linear light.\n",
        processor().map(|name| format!(" ({name})")).unwrap_or_default()
    );
    let experiments: [(&str, &[&str]); 3] = [
        (
            "Moving through the square, temporal anti-aliasing:",
            &[
                "compare",
                "--size",
                "480x270",
                "-a",
                "taa",
                "-m",
                "baseline",
                "-m",
                "roulette",
                "-m",
                "std",
                "-m",
                "dtaa",
                "-m",
                "dtaa-unique",
                "-m",
                "stbn",
                "-o",
                "sheer-out/results",
            ],
        ),
        (
            "Inside the smoke, time of a frame:",
            &[
                "bench",
                "smoke-square",
                "--time",
                "5",
                "--size",
                "240x135",
                "--frames",
                "3",
                "-m",
                "baseline",
                "-m",
                "baseline:trace=continuation",
                "-m",
                "std",
                "-m",
                "roulette",
            ],
        ),
        (
            "An engine of 322,000 transparent triangles, by what composites them:",
            &[
                "compare",
                "motor",
                "--size",
                "480x270",
                "--frames",
                "4",
                "-a",
                "none",
                "-m",
                "std",
                "-m",
                "stochastic",
                "-m",
                "weighted",
                "-m",
                "moments",
                "-m",
                "mlab",
                "-m",
                "kbuffer",
                "-m",
                "peel:layers=4",
                "-o",
                "sheer-out/results-motor",
            ],
        ),
    ];
    for (title, arguments) in experiments {
        let table = sheer(arguments)?;
        section += &format!("\n{title}\n\n```text\n$ sheer {}\n{}```\n", arguments.join(" "), table);
    }
    section += &format!("\n{}\n", scaling(cores)?);
    insert(&section)
}

/// The pictures of the README.
fn pictures() -> anyhow::Result<()> {
    for (scene, time, frames) in PICTURES {
        let png = root().join(format!("docs/{scene}.png"));
        let out = png.display().to_string();
        let aa = if scene == "smoke-square" { "taa" } else { "accumulate" };
        let camera = ["--camera", "static", "--time", time];
        let how = ["-m", "std", "-a", aa, "--frames", frames, "-o", &out];
        sheer(&[&["render", scene][..], &camera, &how].concat())?;
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
