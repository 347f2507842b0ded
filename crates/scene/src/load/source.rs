//! A file of one of the plainer formats while it is read: where it lies, how it is to be read, and what there
//! was to say about it.

use std::{
    cell::{Cell, RefCell},
    fmt::Display,
    path::Path,
};

use super::{Contents, LoadOptions, LoadWarning, Loaded};
use crate::{SceneError, model::SceneParts, scene::Scene};

/// Triangles that a file may draw: every frame holds all of them, at some 200 bytes each with its hierarchy.
pub(super) const MAX_TRIANGLES: usize = 1 << 26;

/// Warnings that anyone reads; the rest are counted.
const MOST_WARNINGS: usize = 50;

/// The file, and what was said of it.
pub(super) struct Source<'a> {
    format: &'static str,
    pub(super) path: &'a Path,
    pub(super) options: &'a LoadOptions,
    warnings: RefCell<Vec<LoadWarning>>,
    /// How many more there would have been.
    unsaid: Cell<usize>,
}

impl<'a> Source<'a> {
    /// A file of a format that leaves no choice.
    pub(super) fn new(
        format: &'static str,
        path: &'a Path,
        options: &'a LoadOptions,
    ) -> Result<Self, SceneError> {
        options.check_without_choices(path)?;
        Ok(Self { format, path, options, warnings: RefCell::default(), unsaid: Cell::new(0) })
    }

    /// An error at a place in the file.
    pub(super) fn fault(&self, place: impl Display, problem: impl Into<String>) -> SceneError {
        SceneError::File { path: self.path.to_owned(), place: place.to_string(), problem: problem.into() }
    }

    /// Warns of something that was wrong in the file and has been put right, once; counts it where enough has
    /// been said.
    pub(super) fn repaired(&self, place: impl Display, what: impl Into<String>) {
        let warning = LoadWarning::Repaired { place: place.to_string(), what: what.into() };
        let mut warnings = self.warnings.borrow_mut();
        if warnings.len() == MOST_WARNINGS {
            self.unsaid.set(self.unsaid.get() + 1);
        } else if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }

    /// Goes on without a part of the file that is not sound, and names it.
    pub(super) fn lost(&self, place: impl Display, what: impl Into<String>) -> Result<(), SceneError> {
        let what = what.into();
        if self.options.strict {
            return Err(self.fault(place, format!("{what}; without --strict the rest is drawn")));
        }
        self.repaired(place, what);
        Ok(())
    }

    /// The triangles of a file, if there are not too many.
    pub(super) fn check_triangle_count(&self, count: usize, place: &str) -> Result<(), SceneError> {
        if count <= MAX_TRIANGLES {
            return Ok(());
        }
        let problem = format!("{count} triangles are more than {MAX_TRIANGLES}; reduce or split the file");
        Err(SceneError::Limit { path: self.path.to_owned(), place: place.to_owned(), problem })
    }

    /// An empty scene, named after the file.
    pub(super) fn parts(&self) -> SceneParts {
        SceneParts {
            name: self.path.file_stem().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned(),
            exposure: 1.0,
            ..SceneParts::default()
        }
    }

    /// Validates what was read.
    pub(super) fn finish(self, parts: SceneParts) -> Result<Loaded, SceneError> {
        let scene = Scene::new(parts).map_err(|error| match error {
            SceneError::Invalid { place, problem, .. } => self.fault(place, problem),
            other => other,
        })?;
        let contents = Contents { format: self.format.to_owned(), ..Contents::default() };
        let mut warnings = self.warnings.into_inner();
        let unsaid = self.unsaid.get();
        if unsaid > 0 {
            warnings.push(LoadWarning::More { count: unsaid });
        }
        Ok(Loaded { scene, warnings, contents })
    }
}
