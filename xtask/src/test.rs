//! `cargo xtask test`: the one command that says whether the project is sound. CI runs it and nothing else.

use std::{
    env,
    process::{Command, Stdio},
};

use anyhow::ensure;

use crate::{call, call_with, driver, rules};

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
    if !answers("apt-get") {
        // The tests say what they miss.
        return Ok(());
    }
    let has_browser = env::var_os("CHROME").is_some() || BROWSERS.into_iter().any(answers);
    if !has_browser {
        // Recommended packages would bring a desktop; letters are needed all the same.
        apt_get(&["update"])?;
        apt_get(&["install", "--yes", "--no-install-recommends", "chromium", "fonts-dejavu-core"])?;
    }
    driver::install()
}

/// Runs apt-get without questions, with the rights that it takes.
pub(crate) fn apt_get(arguments: &[&str]) -> anyhow::Result<()> {
    eprintln!("$ apt-get {}", arguments.join(" "));
    let mut command = as_root("env")?;
    let status = command.args(["DEBIAN_FRONTEND=noninteractive", "apt-get"]).args(arguments).status()?;
    ensure!(status.success(), "apt-get {} failed", arguments.join(" "));
    Ok(())
}

/// A program with the rights of the administrator.
pub(crate) fn as_root(program: &str) -> anyhow::Result<Command> {
    let id = Command::new("id").arg("-u").output()?;
    if id.stdout == b"0\n" {
        return Ok(Command::new(program));
    }
    let mut command = Command::new("sudo");
    command.arg(program);
    Ok(command)
}

/// Whether a program is there and runs.
fn answers(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}
