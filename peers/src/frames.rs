//! Whole frames of our own, by `sheer bench`: what they cost, how that grows with the number of particles,
//! what a second thread brings, and the slowest frame of a path.

use std::{path::Path, process::Command};

use anyhow::{Context as _, ensure};
use serde::{Deserialize, Serialize};

/// How often 1 and 2 threads take turns.
const THREAD_ROUNDS: usize = 7;

/// What was measured; beside each part the command that did it.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct FrameTimes {
    pub(crate) whole: Vec<Run>,
    pub(crate) growth: Vec<Growth>,
    /// Of each turn, milliseconds of a frame with 1 and with 2 threads.
    pub(crate) threads: Vec<[f64; 2]>,
    pub(crate) threads_command: String,
    pub(crate) path: Run,
}

/// Frames of a cloud with so many particles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Growth {
    pub(crate) particles: u32,
    /// Of the picture.
    pub(crate) size: String,
    pub(crate) run: Run,
}

/// One call of `sheer bench`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Run {
    pub(crate) command: String,
    pub(crate) rows: Vec<FrameRow>,
}

/// A method's frames.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct FrameRow {
    pub(crate) method: String,
    pub(crate) aa: String,
    /// Milliseconds of each frame, without adding up over time.
    pub(crate) ms: Vec<f64>,
    /// With it.
    pub(crate) whole_ms_median: f64,
}

impl FrameRow {
    /// `joint, layered`.
    pub(crate) fn name(&self) -> String {
        let aa = self.aa.split(':').next().unwrap_or_default();
        if aa == "none" { self.method.clone() } else { format!("{}, {aa}", self.method) }
    }
}

/// A frame of the square is this large where it is compared with what was before.
const WHOLE: [&str; 5] = ["smoke-square", "--time", "3", "--size", "960x540"];
/// How many particles the cloud has, for the law of growth.
const PARTICLES: [u32; 4] = [1_000, 10_000, 100_000, 1_000_000];
/// Size, frames and contestants. Building takes as long for a small picture as for a large one, so methods
/// that stop early have a large one; all layers of a million particles are many, so `baseline` has a small
/// one.
const GROWTH: [(&str, &str, &[&str]); 3] = [
    ("960x540", "3", &["-m", "std", "-m", "joint"]),
    ("960x540", "3", &["-m", "joint", "-a", "layered"]),
    ("96x54", "1", &["-m", "baseline"]),
];
const THREADS: [&str; 9] = ["smoke-square", "--time", "3", "--size", "480x270", "--frames", "5", "-m", "std"];
/// The whole path, 12 s at 30 frames a second.
const PATH: [&str; 9] =
    ["smoke-square", "--camera", "path", "--size", "240x135", "--frames", "360", "-m", "std"];

/// Measures all of it.
pub(crate) fn measure(sheer: &Path) -> anyhow::Result<FrameTimes> {
    let mut times = FrameTimes::default();
    for contestants in [
        &["--frames", "5", "-m", "std", "-m", "joint"][..],
        &["--frames", "5", "-m", "std", "-m", "joint", "-a", "layered"],
        &["--frames", "3", "-m", "baseline"],
    ] {
        times.whole.push(bench(sheer, &[&WHOLE, contestants].concat())?);
    }
    for (size, frames, contestants) in GROWTH {
        for particles in PARTICLES {
            let scene = format!("smoke-square:particles={particles}");
            let common = [scene.as_str(), "--time", "3", "--size", size, "--frames", frames];
            let run = bench(sheer, &[&common, contestants].concat())?;
            times.growth.push(Growth { particles, size: size.to_owned(), run });
        }
    }
    for _ in 0..THREAD_ROUNDS {
        let mut pair = [0.0; 2];
        for (ms, threads) in pair.iter_mut().zip(["1", "2"]) {
            let run = bench(sheer, &[&THREADS[..], &["--threads", threads]].concat())?;
            *ms = run.rows.first().context("bench reports no method")?.whole_ms_median;
        }
        times.threads.push(pair);
    }
    times.threads_command = format!("sheer bench {} --threads 1|2", THREADS.join(" "));
    times.path = bench(sheer, &PATH)?;
    Ok(times)
}

/// What `sheer bench --json` writes, as far as it is of use here.
#[derive(Deserialize)]
struct Report {
    rows: Vec<FrameRow>,
}

fn bench(sheer: &Path, arguments: &[&str]) -> anyhow::Result<Run> {
    let command = format!("sheer bench {}", arguments.join(" "));
    eprintln!("$ {command}");
    let mut program = Command::new(sheer);
    program.arg("bench").args(arguments).args(["--json", "-", "--quiet"]);
    let output = program.output().with_context(|| format!("cannot run {}", sheer.display()))?;
    ensure!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr).trim());
    let report: Report =
        serde_json::from_slice(&output.stdout).with_context(|| format!("report of {command}"))?;
    Ok(Run { command, rows: report.rows })
}
