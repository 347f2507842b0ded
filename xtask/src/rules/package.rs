//! What is published stands by itself: no file of a crate includes one from outside of it.

use std::path::{Component, Path, PathBuf};

/// The macros that put a file into a program.
const MACROS: [&str; 2] = ["include_str!(", "include_bytes!("];

/// Lines of a source that include a file from outside the folder of its crate, and that file. Tests may: they
/// are not built by those who use the crate.
pub(super) fn foreign_files(file: &Path, crate_folder: &Path, text: &str) -> Vec<(usize, PathBuf)> {
    let mut found = Vec::new();
    let mut before = "";
    for (index, line) in text.lines().enumerate() {
        if line.trim() == "#[cfg(test)]" {
            break;
        }
        let is_for_tests = before.trim() == "#[cfg(doctest)]";
        before = line;
        let Some(macro_end) = MACROS.iter().find_map(|name| line.find(name).map(|at| at + name.len())) else {
            continue;
        };
        let Some(path) = line[macro_end..].split('"').find(|part| part.contains('/')) else { continue };
        // What is put together from the folder of the manifest begins with a slash.
        let base = if path.starts_with('/') { crate_folder } else { file.parent().unwrap_or(file) };
        let path = normal(&base.join(path.trim_start_matches('/')));
        if !is_for_tests && !path.starts_with(crate_folder) {
            found.push((index + 1, path));
        }
    }
    found
}

/// A path without `..`, by its words alone.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        if component == Component::ParentDir {
            normal.pop();
        } else {
            normal.push(component);
        }
    }
    normal
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<(usize, PathBuf)> {
        foreign_files(Path::new("/p/crates/lab/src/a/b.rs"), Path::new("/p/crates/lab"), text)
    }

    #[test]
    fn a_file_from_outside_is_found_with_its_line() {
        let relative = "use x;\nconst A: &str = include_str!(\"../../../other/a.txt\");\n";
        assert_eq!(found(relative), [(2, "/p/crates/other/a.txt".into())]);
        let whole = "include_bytes!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/../../assets/\", $name)),";
        assert_eq!(found(whole), [(1, "/p/assets".into())]);
    }

    #[test]
    fn what_lies_inside_or_is_for_tests_is_none() {
        for text in [
            "include_str!(\"page.css\")",
            "include_str!(\"../../assets/a.txt\")",
            "include_bytes!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/assets/\", $name))",
            "#[cfg(doctest)]\n#[doc = include_str!(\"../../../../README.md\")]",
            "#[cfg(test)]\nmod tests {\n    include_str!(\"../../../../README.md\");\n}",
        ] {
            assert_eq!(found(text), [], "{text}");
        }
    }
}
