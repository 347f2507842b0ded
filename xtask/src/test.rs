//! `cargo xtask test`: the one command that says whether the project is sound. CI runs it and nothing else.

use std::process::{Command, Stdio};

use crate::{call, call_with, rules};

pub(crate) fn run() -> anyhow::Result<()> {
    install()?;
    check()
}

fn check() -> anyhow::Result<()> {
    call("cargo", &["fmt", "--all", "--check"])?;
    rules::run()?;
    call("cargo", &["clippy", "--workspace", "--all-targets", "--locked", "--", "-D", "warnings"])?;
    call("cargo", &["test", "--workspace", "--locked", "--no-fail-fast"])?;
    call_with("cargo", &["doc", "--workspace", "--no-deps", "--locked"], &[("RUSTDOCFLAGS", "-D warnings")])
}

/// Brings what a machine with only Rust may lack.
fn install() -> anyhow::Result<()> {
    for (tool, component) in [("cargo-fmt", "rustfmt"), ("cargo-clippy", "clippy")] {
        if !answers(tool) {
            call("rustup", &["component", "add", component])?;
        }
    }
    Ok(())
}

/// Whether a program is there and runs.
fn answers(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}
