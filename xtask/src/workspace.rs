//! The workspace: where it lies, what crates it has, and programs run in its root.

use std::{
    collections::BTreeMap,
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context as _, ensure};

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own).to_owned()
}

/// The folder that cargo builds into.
pub(crate) fn target() -> PathBuf {
    root().join(env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from))
}

/// The program as `cargo build --release` has left it.
pub(crate) fn release_binary() -> PathBuf {
    target().join("release/sheer")
}

/// The folders of all crates by their names below `crates`, and this one.
pub(crate) fn crates() -> anyhow::Result<BTreeMap<String, PathBuf>> {
    let mut crates = BTreeMap::from([("xtask".to_owned(), root().join("xtask"))]);
    for entry in fs::read_dir(root().join("crates")).context("crates")? {
        let entry = entry?;
        if entry.path().join("Cargo.toml").is_file() {
            crates.insert(entry.file_name().to_string_lossy().into_owned(), entry.path());
        }
    }
    Ok(crates)
}

/// All sources that git knows whose names fit one of the patterns, relative to the root.
pub(crate) fn sources(patterns: &[&str]) -> anyhow::Result<Vec<String>> {
    let listing = Command::new("git").arg("ls-files").args(patterns).current_dir(root()).output()?;
    let listing = String::from_utf8(listing.stdout)?;
    ensure!(!listing.is_empty(), "git lists no sources");
    // A file that is deleted but not yet committed is listed too.
    Ok(listing.lines().filter(|file| root().join(file).is_file()).map(str::to_owned).collect())
}

/// Runs a program in the root of the workspace and fails if it fails.
pub(crate) fn call(program: &str, arguments: &[&str]) -> anyhow::Result<()> {
    call_with(program, arguments, &[])
}

/// Runs a program in the root of the workspace with environment variables of its own and fails if it fails.
pub(crate) fn call_with(
    program: &str,
    arguments: &[&str],
    environment: &[(&str, &str)],
) -> anyhow::Result<()> {
    eprintln!("$ {program} {}", arguments.join(" "));
    let mut command = Command::new(program);
    command.args(arguments).envs(environment.iter().copied()).current_dir(root());
    let status = command.status().with_context(|| format!("cannot run {program}"))?;
    ensure!(status.success(), "{program} {} failed", arguments.join(" "));
    Ok(())
}
