//! `cargo xtask results`: measures what the README claims, and writes it there with the commands that did it.

use std::{fs, process::Command, thread};

use anyhow::{Context as _, ensure};

use crate::{call, gallery::jpeg_from_png, root};

const BEGIN: &str = "<!-- results:begin -->";
const END: &str = "<!-- results:end -->";
/// Turns of 1 thread and all threads, one after the other, so that a drifting machine meets both.
const SCALING_ROUNDS: usize = 5;

pub(crate) fn run() -> anyhow::Result<()> {
    call("cargo", &["build", "--release", "--package", "sheer", "--locked"])?;
    picture()?;
    let cores = thread::available_parallelism()?.get();
    let mut section = format!(
        "## Results\n\nMade by `cargo xtask results` on {cores} cores{}. Time is that of a whole frame without temporal anti-aliasing; SSIM, PSNR and FLIP are \
         taken on the displayed picture against `baseline`, RMS and bias in linear light.\n",
        processor().map(|name| format!(" ({name})")).unwrap_or_default()
    );
    let experiments: [(&str, &[&str]); 4] = [
        ("Moving through the square, temporal anti-aliasing:", &["compare", "-o", "sheer-out/results"]),
        (
            "One still pane, still camera:",
            &["compare", "pane", "--size", "480x270", "--frames", "48", "-o", "sheer-out/results-pane"],
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
            "Along the whole path through the cloud:",
            &["bench", "smoke-square", "--size", "192x108", "--frames", "360", "-m", "std", "-m", "roulette"],
        ),
    ];
    for (title, arguments) in experiments {
        let table = sheer(arguments)?;
        section += &format!("\n{title}\n\n```text\n$ sheer {}\n{}```\n", arguments.join(" "), table);
    }
    section += "\nShading one fragment keeps the shading constant along that path. What still grows inside the cloud is the number of hits that each camera and \
                shadow ray tests: a GPU hides it, a CPU pays for every one, and so the slowest frame takes more than the median.\n";
    section += &format!("\n{}\n", scaling(cores)?);
    insert(&section)
}

/// The picture at the top of the README.
fn picture() -> anyhow::Result<()> {
    let png = root().join("docs/smoke-square.png");
    let out = png.display().to_string();
    sheer(&[
        "render",
        "smoke-square",
        "--camera",
        "static",
        "-m",
        "std",
        "-a",
        "taa",
        "--frames",
        "64",
        "-o",
        &out,
    ])?;
    jpeg_from_png(&png, &root().join("docs/smoke-square.jpg"))
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
    let mut command = Command::new(root().join("target/release/sheer"));
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
