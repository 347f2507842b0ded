//! Other tracers on the same rays as ours, other renderers on the same scene: measures, and writes
//! docs/performance.md. `cargo xtask bench-peers` builds what this needs and starts it.

mod document;
mod embree;
mod export;
mod frames;
mod mitsuba;
mod obvhs;
mod plot;
mod rays;
#[path = "../../crates/accel/benches/scenes/mod.rs"]
mod scenes;
mod sheer;
mod statistics;

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{Command, ExitCode},
    thread,
};

use anyhow::Context as _;
use clap::{Parser, ValueEnum};
use embree::Embree;
use serde::{Deserialize, Serialize};

#[derive(Parser)]
#[command(about = "Measures peers and writes the page about performance")]
struct Arguments {
    /// What to measure, all if not given; the rest of the page stays as it was measured before.
    #[arg(value_enum)]
    parts: Vec<Part>,
    /// The program whose frames are measured.
    #[arg(long)]
    sheer: PathBuf,
    /// Python with the wheels of requirements.txt.
    #[arg(long)]
    python: PathBuf,
    /// Folder for what is exported and rendered, and below which Embree is looked for.
    #[arg(long)]
    folder: PathBuf,
    /// The page; figures and chart go beside it.
    #[arg(long)]
    out: PathBuf,
    /// How often engines take turns.
    #[arg(long, default_value_t = 7)]
    rounds: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Part {
    /// Embree and obvhs on the same rays.
    Rays,
    /// Our own frames.
    Frames,
    /// Mitsuba on the same scene.
    Mitsuba,
}

/// All that the page tells.
#[derive(Default, Serialize, Deserialize)]
struct Measured {
    rays: Option<Taken<rays::RayTimes>>,
    frames: Option<Taken<frames::FrameTimes>>,
    mitsuba: Option<Taken<mitsuba::MitsubaTimes>>,
}

/// Figures, and how they came about.
#[derive(Serialize, Deserialize)]
struct Taken<T> {
    commit: String,
    processor: String,
    cores: usize,
    /// Processes that ran beside, on average over the minute before; where the system tells it.
    load: Option<f32>,
    command: String,
    values: T,
}

impl<T> Taken<T> {
    fn measure(part: Part, measure: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<Self> {
        let load = fs::read_to_string("/proc/loadavg").ok();
        let load = load.and_then(|text| text.split_whitespace().next()?.parse().ok());
        let values = measure()?;
        let name = part.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
        Ok(Self {
            commit: commit()?,
            processor: processor(),
            cores: thread::available_parallelism()?.get(),
            load,
            command: format!("cargo xtask bench-peers {name}"),
            values,
        })
    }
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bench-peers: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let figures = arguments.out.with_extension("json");
    let mut measured = match fs::read(&figures) {
        Ok(bytes) => serde_json::from_slice(&bytes).with_context(|| figures.display().to_string())?,
        Err(_) => Measured::default(),
    };
    let is_asked = |part| arguments.parts.is_empty() || arguments.parts.contains(&part);

    if is_asked(Part::Rays) {
        let embree = optional("Embree", Embree::load(&arguments.folder));
        let times = Taken::measure(Part::Rays, || rays::measure(embree.as_ref(), arguments.rounds))?;
        measured.rays = Some(times);
    }
    if is_asked(Part::Frames) {
        measured.frames = Some(Taken::measure(Part::Frames, || frames::measure(&arguments.sheer))?);
    }
    if is_asked(Part::Mitsuba) {
        let scene = export::write(&arguments.folder)?;
        let Arguments { python, sheer, folder, rounds, .. } = arguments;
        let times =
            Taken::measure(Part::Mitsuba, || mitsuba::measure(python, sheer, &scene, folder, *rounds));
        if let Some(times) = optional("Mitsuba", times) {
            measured.mitsuba = Some(times);
        }
    }

    write(&figures, &(serde_json::to_string_pretty(&measured)? + "\n"))?;
    if let Some(chart) = document::chart(&measured) {
        write(&arguments.out.with_extension("svg"), &chart)?;
    }
    let page = document::text(&measured);
    write(&arguments.out, &page)?;
    println!("{page}");
    Ok(())
}

/// A peer that may be missing: says why it is, and goes on.
fn optional<T>(peer: &str, result: anyhow::Result<T>) -> Option<T> {
    result.inspect_err(|error| eprintln!("bench-peers: {peer} is left out: {error:#}")).ok()
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// The commit that is checked out; `-dirty` if there is more than it holds.
fn commit() -> anyhow::Result<String> {
    let folder = env!("CARGO_MANIFEST_DIR");
    let output = Command::new("git")
        .args(["-C", folder, "describe", "--always", "--dirty", "--exclude", "*"])
        .output()?;
    let text = String::from_utf8(output.stdout)?.trim().to_owned();
    Ok(if text.is_empty() { "unknown".to_owned() } else { text })
}

/// The processor's name, where the system tells it, or its architecture.
fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    let name = line.and_then(|line| line.split_once(':')).map(|(_, name)| name.trim().to_owned());
    name.unwrap_or_else(|| env::consts::ARCH.to_owned())
}
