//! The project's own tasks, one file each: `cargo xtask TASK`.

use std::{
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

use anyhow::{Context as _, ensure};
use clap::{Parser, Subcommand};

mod driver;
mod gallery;
mod results;
mod rules;
mod test;

#[derive(Parser)]
#[command(name = "cargo xtask", about = "The project's own tasks")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Install what the tests need, then format, lint, build and test everything, documentation included.
    Test,
    /// Check the rules that the compiler cannot: paths in ARCHITECTURE.md exist, values are written once.
    Rules,
    /// Measure what README and docs claim and write it there: half an hour, on a machine that does nothing else.
    Results(results::Results),
    /// Render every .gltf and .glb file below a folder and write a contact sheet.
    Gallery(gallery::Gallery),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().task {
        Task::Test => test::run(),
        Task::Rules => rules::run(),
        Task::Results(results) => results.run(),
        Task::Gallery(gallery) => gallery.run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The root of the workspace.
fn root() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own).to_owned()
}

/// Runs a program in the root of the workspace and fails if it fails.
fn call(program: &str, arguments: &[&str]) -> anyhow::Result<()> {
    call_with(program, arguments, &[])
}

/// The same with environment variables.
fn call_with(program: &str, arguments: &[&str], environment: &[(&str, &str)]) -> anyhow::Result<()> {
    eprintln!("$ {program} {}", arguments.join(" "));
    let mut command = Command::new(program);
    command.args(arguments).envs(environment.iter().copied()).current_dir(root());
    let status = command.status().with_context(|| format!("cannot run {program}"))?;
    ensure!(status.success(), "{program} {} failed", arguments.join(" "));
    Ok(())
}
