//! `cargo xtask graph`: which file of a crate uses which, and whether that goes round in a circle.
//!
//! An edge leads from a file whose code names an item to the file that defines it: by `use`, by a path in
//! code, by a macro's name. Declarations of modules and re-exports are no edges; who goes through them
//! reaches the definition. Tests are left out. Methods are not seen: they are called on a value, without a
//! name of the file that implements them.

mod circle;
mod resolve;
mod source;

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt, fs,
    io::{self, Write as _},
    path::{Path, PathBuf},
};

use anyhow::{Context as _, bail, ensure};
use clap::Args;

use self::{
    resolve::Resolver,
    source::{Source, Texts},
};
use crate::workspace;

/// Print the graph of files of each crate.
#[derive(Args)]
pub(crate) struct Graph {
    /// Folders of crates below `crates`, or `xtask`; all if none is given.
    crates: Vec<String>,
}

impl Graph {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let known = workspace::crates()?;
        for name in &self.crates {
            ensure!(known.contains_key(name), "there is no crate {name}");
        }
        for (name, folder) in
            known.iter().filter(|(name, _)| self.crates.is_empty() || self.crates.contains(name))
        {
            writeln!(io::stdout(), "{name}\n{}", FileGraph::of_crate(folder)?)?;
        }
        Ok(())
    }
}

/// The files of a crate and what they use of each other.
pub(crate) struct FileGraph {
    files: Vec<PathBuf>,
    edges: Vec<BTreeSet<usize>>,
    /// The first line of each edge, and the path that it names.
    witnesses: BTreeMap<(usize, usize), (usize, String)>,
}

impl FileGraph {
    /// Reads the crate in a folder: its library, or its program where it has no library.
    pub(crate) fn of_crate(folder: &Path) -> anyhow::Result<Self> {
        let mut texts = Texts::new();
        collect(&folder.join("src"), Path::new(""), &mut texts)?;
        let roots = ["lib.rs", "main.rs"].map(Path::new);
        let Some(root) = roots.into_iter().find(|root| texts.contains_key(*root)) else {
            bail!("{} has neither src/lib.rs nor src/main.rs", folder.display());
        };
        Self::new(&texts, root).with_context(|| folder.display().to_string())
    }

    fn new(texts: &Texts, root: &Path) -> anyhow::Result<Self> {
        let source = Source::read(texts, root)?;
        let files = source.files();
        let resolver = Resolver { source: &source };
        let number = |file: &Path| files.iter().position(|known| known == file);
        let mut edges = vec![BTreeSet::new(); files.len()];
        let mut witnesses = BTreeMap::new();
        for mention in &source.mentions {
            let user = number(&source.modules[mention.module].file);
            let definer = resolver.definition(mention).and_then(number);
            let (Some(user), Some(definer)) = (user, definer) else { continue };
            if user != definer {
                edges[user].insert(definer);
                witnesses.entry((user, definer)).or_insert_with(|| (mention.line, mention.path.join("::")));
            }
        }
        Ok(Self { files, edges, witnesses })
    }

    /// The circles, each as text: a shortest way round with the lines that make it, and what else is part of
    /// it.
    pub(crate) fn circles(&self) -> Vec<String> {
        circle::circles(&self.edges).iter().map(|circle| self.describe(circle)).collect()
    }

    fn describe(&self, circle: &circle::Circle) -> String {
        let way = &circle.shortest;
        let name = |file: usize| self.files[file].display();
        let mut text = String::new();
        for (at, &user) in way.iter().enumerate() {
            let definer = way[(at + 1) % way.len()];
            if let Some((line, path)) = self.witnesses.get(&(user, definer)) {
                text += &format!("    {}:{line} uses {path} of {}\n", name(user), name(definer));
            }
        }
        let others: Vec<String> = circle
            .nodes
            .iter()
            .filter(|node| !way.contains(node))
            .map(|&node| name(node).to_string())
            .collect();
        if !others.is_empty() {
            text += &format!("    and in the same knot: {}\n", others.join(", "));
        }
        text
    }
}

impl fmt::Display for FileGraph {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (file, used) in self.files.iter().zip(&self.edges) {
            let used: Vec<String> = used.iter().map(|&file| self.files[file].display().to_string()).collect();
            let arrow = if used.is_empty() { "" } else { " → " };
            writeln!(out, "  {}{arrow}{}", file.display(), used.join(", "))?;
        }
        let circles = self.circles();
        for circle in &circles {
            write!(out, "  a circle:\n{circle}")?;
        }
        if circles.is_empty() {
            writeln!(out, "  no circle")?;
        }
        Ok(())
    }
}

/// Reads all sources below a folder.
fn collect(folder: &Path, inside: &Path, texts: &mut Texts) -> anyhow::Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        let name = inside.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            collect(&path, &name, texts)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            texts.insert(name, text);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(files: &[(&str, &str)]) -> FileGraph {
        let texts = files.iter().map(|(name, text)| (PathBuf::from(name), (*text).to_owned())).collect();
        FileGraph::new(&texts, Path::new(files[0].0)).unwrap()
    }

    /// Edges as `from>to`, by stem.
    fn edges(graph: &FileGraph) -> Vec<String> {
        let stem = |file: usize| graph.files[file].with_extension("").display().to_string();
        graph.witnesses.keys().map(|&(from, to)| format!("{}>{}", stem(from), stem(to))).collect()
    }

    #[test]
    fn a_circle_is_found_and_named_with_its_lines() {
        let graph = graph(&[
            ("lib.rs", "mod low; mod high; mod apart;"),
            ("low.rs", "//! Low.\npub struct Low;\npub fn up(low: &super::high::High) {}"),
            ("high.rs", "use crate::low::Low;\npub struct High(Low);"),
            ("apart.rs", "use crate::high::High;"),
        ]);
        let circles = graph.circles();
        assert_eq!(circles.len(), 1);
        for line in ["low.rs:3 uses super::high::High of high.rs", "high.rs:1 uses crate::low::Low of low.rs"]
        {
            assert!(circles[0].contains(line), "{}", circles[0]);
        }
        assert!(!circles[0].contains("apart"), "{}", circles[0]);
    }

    #[test]
    fn without_the_way_back_there_is_no_circle() {
        let graph = graph(&[
            ("lib.rs", "mod low; mod high;"),
            ("low.rs", "pub struct Low;"),
            ("high.rs", "use crate::low::Low; pub struct High(Low);"),
        ]);
        assert_eq!(edges(&graph), ["high>low"]);
        assert_eq!(graph.circles(), [""; 0]);
    }

    #[test]
    fn re_exports_lead_to_the_definition_and_are_no_edges() {
        let graph = graph(&[
            ("lib.rs", "mod room; mod user; pub use room::Thing;"),
            ("room/mod.rs", "mod inner; pub use self::inner::*; pub(crate) use inner::Thing as Other;"),
            ("room/inner.rs", "pub struct Thing;"),
            ("user.rs", "use crate::{Thing, room::{self, Other}}; fn f(_: room::Thing) {}"),
        ]);
        assert_eq!(edges(&graph), ["user>room/inner"]);
    }

    #[test]
    fn a_re_exported_name_that_is_used_beside_is_an_edge() {
        let graph = graph(&[
            ("lib.rs", "mod inner; pub use inner::{Thing, make}; fn f() -> Thing { make() }"),
            ("inner.rs", "pub struct Thing; pub fn make() -> Thing { Thing }"),
        ]);
        assert_eq!(edges(&graph), ["lib>inner"]);
    }

    #[test]
    fn paths_in_code_and_in_arguments_of_macros_are_edges() {
        let graph = graph(&[
            ("main.rs", "mod a; mod b; mod c; fn main() { a::run(); assert_eq!(b::NUMBER, 1); }"),
            ("a.rs", "pub fn run() { let x = 0..super::b::NUMBER; x.run::<crate::c::Kind>(); }"),
            ("b.rs", "pub const NUMBER: u32 = 1;"),
            ("c.rs", "pub enum Kind { One } use std::fmt; use self::Kind::One;"),
        ]);
        assert_eq!(edges(&graph), ["main>a", "main>b", "a>b", "a>c"]);
    }

    #[test]
    fn what_tests_use_is_left_out() {
        let graph = graph(&[
            (
                "lib.rs",
                "mod a; #[cfg(test)] mod tests; #[cfg(all(test, unix))] use a::A; #[cfg(test)] fn f(_: a::A) {} pub struct B;",
            ),
            (
                "a.rs",
                "pub struct A; #[cfg(test)] mod tests { use crate::B; } #[cfg(feature = \"x\")] use crate::C;",
            ),
            ("tests.rs", "use crate::a::A;"),
        ]);
        assert_eq!(edges(&graph), ["a>lib"]);
        let witness = &graph.witnesses.values().next().unwrap().1;
        assert_eq!(
            witness, "crate::C",
            "a name that the text does not define counts for the module that is asked"
        );
    }

    #[test]
    fn modules_that_a_macro_declares_belong_to_the_crate() {
        let table = "macro_rules! table { ($($name:ident),*) => { $(mod $name;)* const ALL: &[u32] = &[$($name::ID),*]; } } table! { one, two }";
        let graph = graph(&[
            ("lib.rs", "mod table;"),
            ("table/mod.rs", table),
            ("table/one.rs", "pub const ID: u32 = 1;"),
            ("table/two.rs", "pub const ID: u32 = super::ALL.len() as u32;"),
        ]);
        assert_eq!(edges(&graph), ["table/mod>table/one", "table/mod>table/two", "table/two>table/mod"]);
        assert_eq!(graph.circles().len(), 1);
    }

    #[test]
    fn a_macro_used_elsewhere_is_an_edge() {
        let graph = graph(&[
            ("lib.rs", "#[macro_use] mod row; mod table;"),
            ("row.rs", "macro_rules! row { () => { $crate::table::Table } }"),
            ("table.rs", "pub struct Table; fn f() -> Table { row!() }"),
        ]);
        assert_eq!(edges(&graph), ["row>table", "table>row"]);
    }

    #[test]
    fn a_file_that_is_missing_is_named() {
        let texts = Texts::from([(PathBuf::from("lib.rs"), "mod gone;".to_owned())]);
        let error = FileGraph::new(&texts, Path::new("lib.rs")).err().unwrap();
        assert!(error.to_string().contains("gone"), "{error}");
    }
}
