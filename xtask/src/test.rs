//! `cargo xtask test`: the one command that says whether the project is sound. CI runs it and nothing else.

use std::process::{Command, Stdio};

use anyhow::bail;

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

/// Brings what a machine with only Rust and a package manager may lack: rustfmt, clippy, and a C++ compiler for the texture and mesh codecs.
fn install() -> anyhow::Result<()> {
    for (tool, component) in [("cargo-fmt", "rustfmt"), ("cargo-clippy", "clippy")] {
        if !answers(tool) {
            call("rustup", &["component", "add", component])?;
        }
    }
    if !answers("c++") {
        install_compiler()?;
    }
    Ok(())
}

fn install_compiler() -> anyhow::Result<()> {
    let managers: [(&str, &[&[&str]]); 4] = [
        ("apt-get", &[&["update"], &["install", "--yes", "--no-install-recommends", "g++"]]),
        ("dnf", &[&["install", "--assumeyes", "gcc-c++"]]),
        ("pacman", &[&["-Sy", "--noconfirm", "gcc"]]),
        ("brew", &[&["install", "gcc"]]),
    ];
    for (manager, calls) in managers {
        if answers(manager) {
            return calls.iter().try_for_each(|arguments| call(manager, arguments));
        }
    }
    bail!(
        "there is no C++ compiler `c++` and no package manager known here; install one (Debian: g++) and try again"
    )
}

/// Whether a program is there and runs.
fn answers(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}
