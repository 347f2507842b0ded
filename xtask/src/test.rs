//! `cargo xtask test`: the one command that says whether the project is sound. CI runs it and nothing else.

use std::{
    env,
    process::{Command, Stdio},
};

use crate::{call, call_with, rules};

/// Browsers that can look at the pages, as the library that drives them finds them.
const BROWSERS: [&str; 4] = ["google-chrome-stable", "chromium", "chromium-browser", "chrome"];

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
    let has_browser = env::var_os("CHROME").is_some() || BROWSERS.into_iter().any(answers);
    if !has_browser && answers("apt-get") {
        // Recommended packages would bring a desktop; letters are needed all the same.
        apt_get(&["update"])?;
        apt_get(&["install", "--yes", "--no-install-recommends", "chromium", "fonts-dejavu-core"])?;
    }
    // Elsewhere the tests say what they miss.
    Ok(())
}

/// Runs apt-get without questions, with the rights that it takes.
fn apt_get(arguments: &[&str]) -> anyhow::Result<()> {
    let id = Command::new("id").arg("-u").output()?;
    let quiet = ["env", "DEBIAN_FRONTEND=noninteractive", "apt-get"];
    let (program, quiet) = if id.stdout == b"0\n" { (quiet[0], &quiet[1..]) } else { ("sudo", &quiet[..]) };
    call(program, &[quiet, arguments].concat())
}

/// Whether a program is there and runs.
fn answers(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}
