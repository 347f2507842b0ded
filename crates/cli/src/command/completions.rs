//! `sheer completions`: what a shell needs to complete the command line.

use clap_complete::generate;

use crate::{args::CompletionsArguments, help, output};

pub(crate) fn run(arguments: &CompletionsArguments) -> anyhow::Result<()> {
    // Whole, so that a reader who leaves early is met in one place.
    let mut script = Vec::new();
    generate(arguments.shell, &mut help::parser(), "sheer", &mut script);
    output::print(&String::from_utf8(script)?)
}
