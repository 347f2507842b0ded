//! `cargo xtask bench-peers`: other tracers and renderers beside ours, and docs/performance.md.
//!
//! What it takes comes from a workspace of its own, `peers`, and from Python wheels below the target folder,
//! so that nobody else builds or installs any of it.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::Context as _;
use clap::Args;

use crate::{
    python,
    workspace::{call, release_binary, root, target},
};

/// Measure peers.
#[derive(Args)]
pub(crate) struct Peers {
    /// rays, frames or mitsuba; all if none is given. The rest of the page stays as it was measured before.
    parts: Vec<String>,
}

impl Peers {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let folder = target().join("peers");
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let python = python(&folder);
        call("cargo", &["build", "--release", "--package", "sheer", "--locked"])?;
        let manifest = root().join("peers/Cargo.toml").display().to_string();
        let build = folder.join("build").display().to_string();
        let [sheer, python, folder, page] =
            [release_binary(), python, folder, root().join("docs/performance.md")]
                .map(|path| path.display().to_string());
        let mut arguments = vec!["run", "--release", "--locked", "--manifest-path", &manifest];
        arguments.extend(["--target-dir", &build, "--", "--sheer", &sheer, "--python", &python]);
        arguments.extend(["--folder", &folder, "--out", &page]);
        arguments.extend(self.parts.iter().map(String::as_str));
        call("cargo", &arguments)
    }
}

/// Python with the wheels. Where they cannot be had the measurement says which peer it leaves out.
fn python(folder: &Path) -> PathBuf {
    let environment = folder.join("python");
    python::with_packages(&environment, &root().join("peers/requirements.txt")).unwrap_or_else(|error| {
        eprintln!(
            "bench-peers: the wheels of peers/requirements.txt are not installed ({error:#}); \
             Python 3 with venv and pip, and a way to its package index, are what it takes"
        );
        environment.join("bin/python")
    })
}
