//! `cargo xtask rules`: what the compiler cannot check.

use std::{fs, path::Path, process::Command};

use anyhow::{Context as _, bail, ensure};

use crate::root;

/// Words that confess that one thing was written twice.
const CONFESSIONS: [[&str; 2]; 2] = [["keep in", "sync"], ["must", "match"]];

pub(crate) fn run() -> anyhow::Result<()> {
    let architecture = fs::read_to_string(root().join("ARCHITECTURE.md")).context("ARCHITECTURE.md")?;
    let missing = missing_paths(&architecture, &root());
    ensure!(missing.is_empty(), "ARCHITECTURE.md names paths that do not exist: {}", missing.join(", "));

    let listing = Command::new("git").args(["ls-files", "*.rs", "*.wgsl"]).current_dir(root()).output()?;
    let listing = String::from_utf8(listing.stdout)?;
    ensure!(!listing.is_empty(), "git lists no sources");
    for file in listing.lines() {
        // A file that is deleted but not yet committed is listed too.
        let Ok(text) = fs::read_to_string(root().join(file)) else { continue };
        if let Some(line) = confession(&text) {
            bail!("{file}:{line}: a value that has to be kept equal by hand; derive one from the other");
        }
    }
    Ok(())
}

/// Paths in backticks that contain a slash and do not exist.
fn missing_paths<'a>(text: &'a str, root: &Path) -> Vec<&'a str> {
    let quoted = text.split('`').skip(1).step_by(2);
    let paths = quoted.filter(|word| word.contains('/') && !word.contains([' ', '<', '*', ':', '{']));
    paths.filter(|path| !root.join(path).exists()).collect()
}

/// Number of the first line that confesses.
fn confession(text: &str) -> Option<usize> {
    let phrases = CONFESSIONS.map(|words| words.join(" "));
    let found = |line: &str| phrases.iter().any(|phrase| line.to_ascii_lowercase().contains(phrase));
    text.lines().position(found).map(|index| index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_that_does_not_exist_is_found() {
        let text = "see `crates/core` and `crates/cake`, run `cargo xtask test`, read `method/<name>.rs`";
        assert_eq!(missing_paths(text, &root()), ["crates/cake"]);
    }

    #[test]
    fn a_confession_is_found_with_its_line() {
        let text = format!("let a = 1;\n// {} with b\n", CONFESSIONS[0].join(" "));
        assert_eq!(confession(&text), Some(2));
        assert_eq!(confession("// derived from b"), None);
    }
}
