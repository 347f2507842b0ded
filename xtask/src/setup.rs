//! `cargo xtask setup`: installs what the tests need and a machine with only Rust lacks.

use std::{
    env,
    process::{Command, Stdio},
};

use crate::{
    apt::{self, apt_get},
    driver, python, wheel,
    workspace::{call, root, target},
};

/// Browsers that can look at the pages, a name a line, as the tests look for them.
const BROWSERS: &str = include_str!("../../crates/cli/tests/cli/page/browsers.txt");

/// Installs what is missing and says of each thing whether it was there.
pub(crate) fn run() -> anyhow::Result<()> {
    toolchain()?;
    programs()
}

/// Asks for the administrator's password, should one be needed, before anything is installed beside other
/// work whose output would hide the question.
pub(crate) fn authorise() -> anyhow::Result<()> {
    let are_there = has_browser() && driver::is_there() && python::is_there();
    if answers("apt-get") && !are_there { apt::authorise() } else { Ok(()) }
}

/// What checks the sources.
pub(crate) fn toolchain() -> anyhow::Result<()> {
    for (tool, component) in [("cargo-fmt", "rustfmt"), ("cargo-clippy", "clippy")] {
        if answers(tool) {
            eprintln!("setup: {component} is there");
        } else {
            call("rustup", &["component", "add", component])?;
            eprintln!("setup: {component} is installed");
        }
    }
    Ok(())
}

/// What the tests look at pages and render with, and what runs the template of a farm.
pub(crate) fn programs() -> anyhow::Result<()> {
    if answers("apt-get") {
        packages()?;
    } else {
        eprintln!(
            "setup: no apt-get here; a browser, a Vulkan driver and Python 3 with venv have to be there, or the tests say what they miss"
        );
    }
    python::with_packages(&target().join("python"), &root().join("farm/requirements.txt"))?;
    eprintln!("setup: Open Job Description is there");
    wheel::set_up()?;
    eprintln!("setup: what builds and tests the wheel for Python is there");
    Ok(())
}

fn packages() -> anyhow::Result<()> {
    if has_browser() && python::is_there() {
        eprintln!("setup: a browser and Python are there");
    } else {
        // Recommended packages would bring a desktop; letters are needed all the same.
        apt_get(&["update"])?;
        let packages = ["chromium", "fonts-dejavu-core", "python3-venv"];
        apt_get(&[&["install", "--yes", "--no-install-recommends"][..], &packages].concat())?;
        eprintln!("setup: a browser and Python are installed");
    }
    let installed = driver::install()?;
    eprintln!("setup: a Vulkan driver that traces rays is {}", if installed { "installed" } else { "there" });
    Ok(())
}

fn has_browser() -> bool {
    env::var_os("CHROME").is_some() || BROWSERS.lines().any(answers)
}

/// Whether a program is there and runs.
fn answers(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}
