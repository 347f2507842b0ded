//! A file of one of the plainer formats while it is read: where it lies, how it is to be read, what it may
//! still take, and what there was to say about it.

use std::{
    cell::{Cell, RefCell},
    fmt::Display,
    path::Path,
};

use sheer_core::text::{MemorySize, beginning};
use sheer_scene::{FrameSize, Scene, model::SceneParts};

use super::{
    Contents, LoadOptions, LoadWarning, Loaded,
    loaded::{LONGEST_MESSAGE, LONGEST_NAME},
};
use crate::{
    LoadError,
    error::{beyond_limit, invalid_part},
};

/// Triangles that a file may draw: every frame holds all of them, at some 200 bytes each with its hierarchy.
pub(super) const MAX_TRIANGLES: usize = 1 << 26;

/// Warnings that anyone reads; the rest are counted.
const MOST_WARNINGS: usize = 50;

/// The file, and what was said of it.
pub(super) struct Source<'a> {
    format: &'static str,
    pub(super) path: &'a Path,
    pub(super) options: &'a LoadOptions,
    /// Bytes that the scene may still take.
    memory_left: Cell<u64>,
    warnings: RefCell<Vec<LoadWarning>>,
    /// How many more there would have been.
    unsaid: Cell<usize>,
    /// Place and problem of the first part that was lost.
    first_loss: RefCell<Option<(String, String)>>,
}

impl<'a> Source<'a> {
    /// A file of so many bytes, of a format that leaves no choice.
    pub(super) fn new(
        format: &'static str,
        bytes: usize,
        path: &'a Path,
        options: &'a LoadOptions,
    ) -> Result<Self, LoadError> {
        options.check_without_choices(path)?;
        let source = Self {
            format,
            path,
            options,
            memory_left: Cell::new(options.memory_limit.map_or(u64::MAX, |limit| limit.0)),
            warnings: RefCell::default(),
            unsaid: Cell::new(0),
            first_loss: RefCell::default(),
        };
        source.take(bytes, "file")?;
        Ok(source)
    }

    /// An error at a place in the file.
    pub(super) fn fault(&self, place: impl Display, problem: impl Into<String>) -> LoadError {
        let problem = beginning(&problem.into(), LONGEST_MESSAGE);
        LoadError::File { path: self.path.to_owned(), place: place.to_string(), problem }
    }

    /// Warns of something that was wrong in the file and has been put right, once; counts it where enough has
    /// been said.
    pub(super) fn repaired(&self, place: impl Display, what: impl Into<String>) {
        let mut warnings = self.warnings.borrow_mut();
        if warnings.len() == MOST_WARNINGS {
            self.unsaid.set(self.unsaid.get() + 1);
            return;
        }
        let what = beginning(&what.into(), LONGEST_MESSAGE);
        let warning = LoadWarning::Repaired { place: place.to_string(), what };
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }

    /// Goes on without a part of the file that is not sound, and names it.
    pub(super) fn lost(&self, place: impl Display, what: impl Into<String>) -> Result<(), LoadError> {
        let (place, what) = (place.to_string(), what.into());
        if self.options.strict {
            return Err(self.fault(place, format!("{what}; without --strict the rest is drawn")));
        }
        self.first_loss.borrow_mut().get_or_insert_with(|| (place.clone(), what.clone()));
        self.repaired(place, what);
        Ok(())
    }

    /// Takes memory from what the scene may take in all, before it is allocated.
    pub(super) fn take(&self, bytes: usize, place: &str) -> Result<(), LoadError> {
        let Some(MemorySize(limit)) = self.options.memory_limit else { return Ok(()) };
        let left = self.memory_left.get();
        let rest = left.checked_sub(bytes as u64);
        let rest = rest.ok_or_else(|| self.limit(place, beyond_limit(bytes as u64, left, limit)))?;
        self.memory_left.set(rest);
        Ok(())
    }

    /// Bytes that the scene may still take.
    pub(super) fn memory_left(&self) -> u64 {
        self.memory_left.get()
    }

    /// An error at a place that asks for more than the file may take.
    pub(super) fn limit(&self, place: &str, problem: String) -> LoadError {
        LoadError::Limit { path: self.path.to_owned(), place: place.to_owned(), problem }
    }

    /// The triangles of a file, if there are not too many.
    pub(super) fn check_triangle_count(&self, count: usize, place: &str) -> Result<(), LoadError> {
        if count <= MAX_TRIANGLES {
            return Ok(());
        }
        let problem = format!("{count} triangles are more than {MAX_TRIANGLES}; reduce or split the file");
        Err(self.limit(place, problem))
    }

    /// An empty scene, named after the file.
    pub(super) fn parts(&self) -> SceneParts {
        SceneParts {
            name: self.path.file_stem().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned(),
            exposure: 1.0,
            ..SceneParts::default()
        }
    }

    /// Validates what was read, if its frames fit into what is left of the memory. A file of which nothing is
    /// left is an error.
    pub(super) fn finish(self, parts: SceneParts) -> Result<Loaded, LoadError> {
        if parts.meshes.iter().all(|mesh| mesh.indices.is_empty())
            && let Some((place, problem)) = self.first_loss.take()
        {
            return Err(self.fault(place, problem));
        }
        let frame = FrameSize::of(&parts);
        self.take(usize::try_from(frame.bytes).unwrap_or(usize::MAX), "triangles")?;
        let scene = Scene::new(parts).map_err(|error| {
            let (place, problem) = invalid_part(error);
            self.fault(place, problem)
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

/// A name of a file's, as long as anyone reads: it is copied to whatever bears it.
pub(super) fn name(text: &str) -> String {
    text.chars().take(LONGEST_NAME).collect()
}
