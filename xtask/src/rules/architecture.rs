//! ARCHITECTURE.md says what is: the paths that it names exist, and the graph of crates that it draws is the
//! one of the manifests.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// What each crate uses of ours, by name.
pub(super) type Uses = BTreeMap<String, BTreeSet<String>>;

/// Paths in backticks that contain a slash and do not exist.
pub(super) fn missing_paths<'a>(text: &'a str, root: &Path) -> Vec<&'a str> {
    let quoted = text.split('`').skip(1).step_by(2);
    let paths = quoted.filter(|word| word.contains('/') && !word.contains([' ', '<', '*', ':', '{']));
    paths.filter(|path| !root.join(path).exists()).collect()
}

/// The arrows of a drawn graph, as `[used, user]`: chains `a → b → c` in indented lines, apart by two blanks
/// or more. Each side of an arrow may be several crates, `a, b → c`.
pub(super) fn drawn(text: &str) -> BTreeSet<[String; 2]> {
    let mut arrows = BTreeSet::new();
    let lines = text.lines().filter(|line| line.starts_with("    ") && line.contains('→'));
    for chain in lines.flat_map(|line| line.trim().split("  ")) {
        let rooms: Vec<Vec<&str>> =
            chain.split('→').map(|room| room.split(',').map(str::trim).collect()).collect();
        for pair in rooms.windows(2) {
            for used in &pair[0] {
                arrows.extend(pair[1].iter().map(|user| [(*used).to_owned(), (*user).to_owned()]));
            }
        }
    }
    arrows
}

/// Our crates that a manifest depends on, tests aside: lines `sheer-NAME.workspace = true` or `sheer-NAME =
/// …` of its `[dependencies]`.
pub(super) fn used_by(manifest: &str) -> BTreeSet<String> {
    let mut used = BTreeSet::new();
    let mut in_dependencies = false;
    for line in manifest.lines() {
        if line.starts_with('[') {
            in_dependencies = line.trim() == "[dependencies]";
        } else if let Some(rest) = line.strip_prefix("sheer-").filter(|_| in_dependencies) {
            used.extend(rest.split(['.', ' ', '=']).next().map(str::to_owned));
        }
    }
    used
}

/// What is drawn and not so, or is so and not drawn. An arrow must be a dependency; a dependency must be an
/// arrow or follow from several.
pub(super) fn differences(arrows: &BTreeSet<[String; 2]>, uses: &Uses) -> Vec<String> {
    let is_used = |used: &String, user: &String| uses.get(user).is_some_and(|all| all.contains(used));
    let false_arrows = arrows.iter().filter(|[used, user]| !is_used(used, user));
    let false_arrows =
        false_arrows.map(|[used, user]| format!("{used} → {user} is drawn, but {user} does not use {used}"));
    let pairs = uses.iter().flat_map(|(user, all)| all.iter().map(move |used| (used, user)));
    let missing = pairs.filter(|(used, user)| !leads(arrows, used, user));
    let missing = missing.map(|(used, user)| format!("{user} uses {used}, but no arrow leads there"));
    false_arrows.chain(missing).collect()
}

/// Whether arrows lead from one crate to another.
fn leads(arrows: &BTreeSet<[String; 2]>, from: &str, to: &str) -> bool {
    let mut reached = BTreeSet::from([from]);
    loop {
        let next = arrows
            .iter()
            .filter(|[used, user]| reached.contains(used.as_str()) && !reached.contains(user.as_str()));
        let next: Vec<&str> = next.map(|[_, user]| user.as_str()).collect();
        if next.is_empty() {
            return reached.contains(to);
        }
        reached.extend(next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWING: &str =
        "Data flows one way → down:\n\n    core, accel → render → cli        core → metrics → cli\n";

    fn uses(pairs: &[(&str, &[&str])]) -> Uses {
        let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        pairs.iter().map(|&(user, used)| (user.to_owned(), owned(used))).collect()
    }

    #[test]
    fn a_path_that_does_not_exist_is_found() {
        let text = "see `crates/core` and `crates/cake`, run `cargo xtask test`, read `method/<name>.rs`";
        assert_eq!(missing_paths(text, &crate::workspace::root()), ["crates/cake"]);
    }

    #[test]
    fn a_drawing_of_what_is_has_no_differences() {
        let manifests = uses(&[
            ("render", &["core", "accel"]),
            ("metrics", &["core"]),
            ("cli", &["core", "render", "metrics"]),
        ]);
        assert_eq!(differences(&drawn(DRAWING), &manifests), [""; 0]);
    }

    #[test]
    fn false_and_missing_arrows_are_named() {
        let manifests =
            uses(&[("render", &["core"]), ("metrics", &["core", "render"]), ("cli", &["render", "metrics"])]);
        let found = differences(&drawn(DRAWING), &manifests);
        assert_eq!(
            found,
            [
                "accel → render is drawn, but render does not use accel",
                "metrics uses render, but no arrow leads there"
            ]
        );
    }

    #[test]
    fn a_manifest_is_read_without_what_tests_use() {
        let manifest = "[package]\nname = \"sheer-gpu\"\n[dependencies]\nsheer-core.workspace = true\nsheer-render = { path = \"x\" }\nglam = \"1\"\n\
            [dev-dependencies]\nsheer-metrics.workspace = true\n";
        assert_eq!(used_by(manifest), BTreeSet::from(["core".to_owned(), "render".to_owned()]));
    }
}
