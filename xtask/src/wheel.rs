//! The wheel for Python, built from what the tests have compiled already, and its own tests.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context as _, ensure};

use crate::{
    python,
    workspace::{call, root, target},
};

/// What builds the wheel and tests it.
const REQUIREMENTS: &str = "crates/python/requirements.txt";

/// The feature of its crate with which it is made of what the tests have compiled already.
const AS_TESTED: &str = "as-tested";

/// Where the packages of [`REQUIREMENTS`] are, and the wheel beside them.
fn environment() -> PathBuf {
    target().join("python-wheel")
}

/// Installs what builds the wheel and tests it, where it is not there.
pub(crate) fn set_up() -> anyhow::Result<()> {
    python::with_packages(&environment(), &root().join(REQUIREMENTS)).map(drop)
}

/// Builds the wheel as the tests are built, and installs it as its users do.
pub(crate) fn install() -> anyhow::Result<()> {
    set_up()?;
    // Of several versions none is meant.
    let folder = target().join("wheels");
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())?;
    }
    let [maturin, python, manifest, out] = [
        environment().join("bin/maturin"),
        environment().join("bin/python"),
        root().join("crates/python/Cargo.toml"),
        folder.clone(),
    ]
    .map(|path| path.display().to_string());
    let how =
        ["--profile", "dev", "--features", AS_TESTED, "--locked", "--strip", "--compatibility", "linux"];
    call(&maturin, &[&["build", "--manifest-path", &manifest, "--out", &out][..], &how].concat())?;
    let wheel = the_wheel(&folder)?.display().to_string();
    let arguments = ["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps", &wheel];
    call(&python, &arguments)?;
    // What the wheel says that it needs is what is there.
    call(&python, &["-m", "pip", "check"])
}

fn the_wheel(folder: &Path) -> anyhow::Result<PathBuf> {
    let entry = fs::read_dir(folder)?.next().context("maturin has left no wheel")?;
    Ok(entry?.path())
}

/// Builds the wheel, and what its tests hold it against, and runs them.
pub(crate) fn run() -> anyhow::Result<()> {
    call("cargo", &["test", "--workspace", "--locked", "--test", "cli", "--no-run"])?;
    install()?;
    let status = tests().status().context("cannot run the tests of the wheel")?;
    ensure!(status.success(), "tests of the wheel failed");
    Ok(())
}

/// The tests of what [`install`] has installed.
pub(crate) fn tests() -> Command {
    let mut pytest = Command::new(environment().join("bin/python"));
    pytest
        .args(["-m", "pytest", "--quiet", "-p", "no:cacheprovider"])
        .current_dir(root().join("crates/python"));
    // The command line does the same things.
    pytest.env("SHEER", target().join("debug/sheer")).env("PYTHONDONTWRITEBYTECODE", "1");
    pytest
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Packages with their features, as these arguments of `cargo tree` select them.
    fn packages(arguments: &[&str]) -> BTreeSet<String> {
        let mut tree = Command::new("cargo");
        tree.args(["tree", "--locked", "--offline", "--prefix", "none", "--format", "{p} has {f}"]);
        let output = tree.args(arguments).current_dir(root()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        // A package that came before is marked.
        let lines = text.lines().map(|line| line.trim_end_matches(" (*)").to_owned());
        lines.filter(|line| !line.is_empty() && !line.starts_with("sheer-python ")).collect()
    }

    #[test]
    fn the_wheel_is_made_of_what_the_tests_have_compiled() {
        let of_tests = packages(&["--workspace", "--edges", "normal,build,dev"]);
        let wheel = ["--package", "sheer-python", "--edges", "normal,build"];
        let others = |features: &[&str]| {
            let of_wheel = packages(&[&wheel[..], features].concat());
            of_wheel.difference(&of_tests).cloned().collect::<Vec<_>>()
        };
        let compiled_again = others(&["--features", AS_TESTED]);
        assert!(
            compiled_again.is_empty(),
            "the tests compile these with other features, so that the wheel and all that uses them is compiled again; \
             ask for the same ones in the feature {AS_TESTED} of crates/python/Cargo.toml: {compiled_again:#?}"
        );
        assert!(!others(&[]).is_empty(), "the feature {AS_TESTED} is of no use any more: remove it");
    }
}
