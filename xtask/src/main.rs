//! The project's own tasks, one file each: `cargo xtask TASK`.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod apt;
mod binaries;
mod driver;
mod gallery;
mod graph;
mod man;
mod peers;
mod python;
mod results;
mod rules;
mod setup;
mod test;
mod wheel;
mod workspace;

#[derive(Parser)]
#[command(name = "cargo xtask", about = "The project's own tasks")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Install what the tests need: rustfmt and clippy; where there is apt, a browser and a Vulkan driver; a
    /// runner of Open Job Description; what builds and tests the wheel for Python.
    Setup,
    /// Set up, then check format, rules and lints, build and test everything, documentation included.
    Test,
    /// Check the rules that the compiler cannot: ARCHITECTURE.md says what is, values are written once, files
    /// use each other one way.
    Rules,
    /// Print which file of a crate uses which, and the circles in that.
    Graph(graph::Graph),
    /// Measure what README and docs claim and write it there: half an hour, on a machine that does nothing
    /// else.
    Results(results::Results),
    /// Measure other tracers and renderers beside ours and write docs/performance.md: some minutes, on a
    /// machine that does nothing else.
    BenchPeers(peers::Peers),
    /// Build the wheel for Python as the tests have it, and run its tests.
    Python,
    /// Write the manual pages of the program, one a command.
    Man(man::Man),
    /// Render every .gltf and .glb file below a folder and write a contact sheet.
    Gallery(gallery::Gallery),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().task {
        Task::Setup => setup::run(),
        Task::Test => test::run(),
        Task::Rules => rules::run(),
        Task::Graph(graph) => graph.run(),
        Task::Results(results) => results.run(),
        Task::BenchPeers(peers) => peers.run(),
        Task::Python => wheel::run(),
        Task::Man(man) => man.run(),
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
