//! `cargo xtask rules`: what the compiler cannot check.

mod architecture;
mod package;
mod width;

use std::{fs, path::Path};

use anyhow::{Context as _, ensure};

use crate::{graph::FileGraph, workspace};

/// Words that confess that one thing was written twice.
const CONFESSIONS: [[&str; 2]; 2] = [["keep in", "sync"], ["must", "match"]];

pub(crate) fn run() -> anyhow::Result<()> {
    let mut broken = Vec::new();
    let architecture = read("ARCHITECTURE.md")?;
    for path in architecture::missing_paths(&architecture, &workspace::root()) {
        broken.push(format!("ARCHITECTURE.md names {path}, which does not exist"));
    }
    let mut uses = architecture::Uses::new();
    for (name, folder) in workspace::crates()? {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).with_context(|| name.clone())?;
        uses.insert(name.clone(), architecture::used_by(&manifest));
        let circles = FileGraph::of_crate(&folder)?.circles();
        broken.extend(
            circles
                .iter()
                .map(|circle| format!("files of {name} use each other in a circle:\n{}", circle.trim_end())),
        );
    }
    for difference in architecture::differences(&architecture::drawn(&architecture), &uses) {
        broken.push(format!("the graph of crates in ARCHITECTURE.md: {difference}"));
    }
    let width = width::set_width(&read("rustfmt.toml")?).context("rustfmt.toml sets no max_width")?;
    for file in workspace::sources(&["*.rs", "*.wgsl"])? {
        let text = read(&file)?;
        if let Some(folder) = published_crate(&file) {
            for (line, foreign) in package::foreign_files(Path::new(&file), folder, &text) {
                broken.push(format!(
                    "{file}:{line}: {} is outside its crate, which cannot be published so",
                    foreign.display()
                ));
            }
        }
        if let Some(line) = confession(&text) {
            broken.push(format!(
                "{file}:{line}: a value that has to be kept equal by hand; derive one from the other"
            ));
        }
        for line in width::too_wide(&text, width) {
            broken.push(format!("{file}:{line}: a comment beyond {width} columns"));
        }
    }
    ensure!(broken.is_empty(), "{}", broken.join("\n"));
    Ok(())
}

/// The folder of the crate that a source belongs to, if that is published and those who use it build the
/// file.
fn published_crate(file: &str) -> Option<&Path> {
    let path = Path::new(file);
    let folder = path.ancestors().nth(path.components().count().checked_sub(2)?)?;
    (path.starts_with("crates") && path.strip_prefix(folder).ok()?.starts_with("src")).then_some(folder)
}

fn read(name: &str) -> anyhow::Result<String> {
    fs::read_to_string(workspace::root().join(name)).with_context(|| name.to_owned())
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
    fn only_what_users_build_is_asked_to_stand_alone() {
        assert_eq!(published_crate("crates/lab/src/a/b.rs"), Some(Path::new("crates/lab")));
        for other in ["crates/lab/tests/a.rs", "xtask/src/main.rs", "README.md"] {
            assert_eq!(published_crate(other), None, "{other}");
        }
    }

    #[test]
    fn a_confession_is_found_with_its_line() {
        let text = format!("let a = 1;\n// {} with b\n", CONFESSIONS[0].join(" "));
        assert_eq!(confession(&text), Some(2));
        assert_eq!(confession("// derived from b"), None);
    }
}
