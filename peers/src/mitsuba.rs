//! Whole frames against Mitsuba 3, by a Python script that renders with both.

use std::{
    path::Path,
    process::{Command, Stdio},
};

use anyhow::{Context as _, bail, ensure};
use serde::{Deserialize, Serialize};

/// What the script writes.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct MitsubaTimes {
    pub(crate) version: String,
    pub(crate) variant: String,
    /// Width and height, pixels.
    pub(crate) size: [u32; 2],
    /// A pixel, of Mitsuba.
    pub(crate) samples: u32,
    /// Of `baseline`, against which errors are taken.
    pub(crate) reference_frames: u32,
    /// The most that were tried of a method.
    pub(crate) most_frames: u32,
    /// Milliseconds of each turn's picture.
    pub(crate) ms: Vec<f64>,
    /// Root of the mean square error of a picture, linear light.
    pub(crate) rms: f64,
    /// How likely a difference such as that of both pictures is, if they show the same.
    pub(crate) p: f64,
    pub(crate) rows: Vec<EqualError>,
}

/// What one of our methods needs for an error no larger; its error then, or with the most frames.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct EqualError {
    pub(crate) method: String,
    /// None if the most that were tried do not suffice.
    pub(crate) frames: Option<u32>,
    pub(crate) rms: f64,
    /// Milliseconds of a frame in each turn.
    pub(crate) frame_ms: Vec<f64>,
}

/// Mitsuba's variants, the fastest first. `llvm` needs an LLVM that knows all instructions that Dr.Jit
/// writes, or it ends the process.
const VARIANTS: [&str; 2] = ["llvm_ad_rgb", "scalar_rgb"];

/// Runs the script on an exported scene.
pub(crate) fn measure(
    python: &Path,
    sheer: &Path,
    scene: &Path,
    folder: &Path,
    rounds: usize,
) -> anyhow::Result<MitsubaTimes> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("mitsuba_frames.py");
    for variant in VARIANTS {
        let mut command = Command::new(python);
        command.arg(&script).arg("--sheer").arg(sheer).arg("--scene").arg(scene).arg("--folder").arg(folder);
        command.args(["--variant", variant, "--rounds", &rounds.to_string()]);
        let output = command
            .stderr(Stdio::inherit())
            .output()
            .with_context(|| format!("cannot run {}", python.display()))?;
        if output.status.success() {
            return serde_json::from_slice(&output.stdout).context("report of mitsuba_frames.py");
        }
        // An exit code is the script's own: it has said what is wrong.
        ensure!(output.status.code().is_none(), "Mitsuba could not be measured");
        eprintln!(
            "bench-peers: Mitsuba died as {variant}: it needs LLVM 19 or so (Debian: libllvm19), and \
             DRJIT_LIBLLVM_PATH names the library if there are several"
        );
    }
    bail!("Mitsuba could not be measured")
}
