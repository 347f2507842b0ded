//! Order-independent transparency: render, compare, measure.
//!
//! Each verb is a file in `command`; what it reports goes through `report`. Console goes to stderr, machine
//! output to stdout. Exit codes: 0 done, 1 failed, 2 wrong use, 130 interrupted.

use std::{env, process::ExitCode};

use args::{Arguments, Command};
use clap::FromArgMatches as _;

mod allocator;
mod args;
mod backend;
mod command;
mod console;
mod failure;
mod graphics;
mod help;
mod input;
mod memory;
mod output;
mod report;
mod schedule;
mod setup;
mod version;
mod video;

fn main() -> ExitCode {
    output::finish_writing_when_interrupted();
    sheer_core::caught_panic::silence();
    memory::end_when_exhausted();
    if env::var_os("RUST_LOG").is_some() {
        env_logger::init();
    }
    let parsed = help::parser().try_get_matches().and_then(|matches| Arguments::from_arg_matches(&matches));
    let outcome = match parsed {
        Ok(arguments) => setup::check_environment().and_then(|()| run(&arguments.command)),
        Err(usage) => failure::from_usage(&usage),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure::report(&error),
    }
}

fn run(command: &Command) -> anyhow::Result<()> {
    match command {
        Command::Scenes(arguments) => command::scenes::run(arguments),
        Command::Methods(arguments) => command::methods::run(arguments),
        Command::Devices(arguments) => command::devices::run(arguments),
        Command::Inspect(arguments) => command::inspect::run(arguments),
        Command::Render(arguments) => command::render::run(arguments),
        Command::Merge(arguments) => command::merge::run(arguments),
        Command::Compare(arguments) => command::compare::run(arguments),
        Command::Metrics(arguments) => command::metrics::run(arguments),
        Command::Bench(arguments) => command::bench::run(arguments),
        Command::Calibrate(arguments) => command::calibrate::run(arguments),
        Command::Experiments(arguments) => command::experiments::run(arguments),
        Command::Verify(arguments) => command::verify::run(arguments),
        Command::Completions(arguments) => command::completions::run(arguments),
        Command::Man(arguments) => command::man::run(arguments),
    }
}
