//! A parsed file: its JSON, its bytes, what it may still cost, and what there was to say about it.

use std::{
    cell::{Cell, OnceCell, RefCell},
    collections::HashSet,
    path::Path,
};

use super::{
    lenient,
    limits::{BASE_BYTES, BYTES_PER_INPUT_BYTE},
    meshopt,
    resource::{self, UriError},
    schema::{Asset, Index, Root},
};
use crate::{
    SceneError,
    load::{LoadOptions, LoadWarning},
};

/// Warnings of a file that are said: a file in which everything is wrong would say it of everything.
const MOST_WARNINGS: usize = 100;
/// Of a name that a message quotes, characters.
const LONGEST_NAME: usize = 60;

/// The file while it is being read. Buffers are read when first asked for.
pub(super) struct Document<'a> {
    pub root: Root,
    pub options: &'a LoadOptions,
    path: &'a Path,
    binary_chunk: Option<&'a [u8]>,
    buffers: Vec<OnceCell<Vec<u8>>>,
    /// Buffer views that are compressed, each decompressed when it is first asked for.
    views: Vec<OnceCell<Vec<u8>>>,
    bytes_left: Cell<u64>,
    warnings: RefCell<Vec<LoadWarning>>,
    /// Texts of the warnings given.
    warned: RefCell<HashSet<String>>,
    /// Place and problem of the first part that was lost.
    first_loss: RefCell<Option<(String, String)>>,
}

impl<'a> Document<'a> {
    pub(super) fn parse(
        bytes: &'a [u8],
        path: &'a Path,
        options: &'a LoadOptions,
    ) -> Result<Self, SceneError> {
        let fault = |place: &str, problem: String| SceneError::File {
            path: path.to_owned(),
            place: place.to_owned(),
            problem,
        };
        let (json, binary_chunk) =
            resource::split_container(bytes).map_err(|problem| fault("container", problem))?;
        let strict: Option<Root> = serde_json::from_slice(json).ok();
        let lenient::Parsed { root, is_straightened, left_out } = match strict {
            Some(root) => lenient::Parsed { root, is_straightened: false, left_out: Vec::new() },
            None => lenient::parse(json, |only| version_problem(&only.asset))
                .map_err(|lenient::Fault { place, problem }| fault(&place, problem))?,
        };
        if let Some(problem) = version_problem(&root.asset) {
            return Err(fault("asset", problem));
        }
        let (buffer_count, view_count) = (root.buffers.len(), root.buffer_views.len());
        let document = Self {
            root,
            options,
            path,
            binary_chunk,
            buffers: (0..buffer_count).map(|_| OnceCell::new()).collect(),
            views: (0..view_count).map(|_| OnceCell::new()).collect(),
            bytes_left: Cell::new(BASE_BYTES + BYTES_PER_INPUT_BYTE * bytes.len() as u64),
            warnings: RefCell::default(),
            warned: RefCell::default(),
            first_loss: RefCell::default(),
        };
        if is_straightened {
            document
                .repaired("JSON", "whole numbers with a point or null in place of nothing were understood");
        }
        for lenient::Fault { place, problem } in left_out {
            document.lose(document.fault(place, problem), "left out")?;
        }
        Ok(document)
    }

    /// An error at a place in this file, given as a path such as `meshes[3].primitives[0]`.
    pub(super) fn fault(&self, place: impl AsRef<str>, problem: impl Into<String>) -> SceneError {
        let place = self.titled(place.as_ref());
        SceneError::File { path: self.path.to_owned(), place, problem: problem.into() }
    }

    /// An error at a place that asks for more than the file may take.
    pub(super) fn limit(&self, place: impl AsRef<str>, problem: impl Into<String>) -> SceneError {
        let place = self.titled(place.as_ref());
        SceneError::Limit { path: self.path.to_owned(), place, problem: problem.into() }
    }

    /// A part of the file, or nothing where it is broken: then `outcome` says in the warning what became of
    /// it. It stays an error for callers who are strict, and where the file asks for too much.
    pub(super) fn salvage<T>(
        &self,
        part: Result<T, SceneError>,
        outcome: &str,
    ) -> Result<Option<T>, SceneError> {
        match part {
            Err(SceneError::File { place, problem, .. }) if !self.options.strict => {
                self.first_loss.borrow_mut().get_or_insert_with(|| (place.clone(), problem.clone()));
                self.warn(LoadWarning::Lost { place, problem, outcome: outcome.to_owned() });
                Ok(None)
            }
            part => part.map(Some),
        }
    }

    /// Warns of a broken part and what became of it, or fails, as [`Self::salvage`] does.
    pub(super) fn lose(&self, fault: SceneError, outcome: &str) -> Result<(), SceneError> {
        self.salvage::<()>(Err(fault), outcome).map(|_| ())
    }

    /// The first part that was lost, as an error.
    pub(super) fn first_loss(&self) -> Option<SceneError> {
        let loss = self.first_loss.take();
        loss.map(|(place, problem)| SceneError::File { path: self.path.to_owned(), place, problem })
    }

    /// A place with the author's name for the part of the root that it begins with, if it has one:
    /// `meshes[3].primitives[0] ('Body')`.
    pub(super) fn titled(&self, place: &str) -> String {
        match self.name_of(place) {
            Some(name) if !name.is_empty() => format!("{place} ('{}')", shown(name)),
            _ => place.to_owned(),
        }
    }

    fn name_of(&self, place: &str) -> Option<&str> {
        let path = place.strip_prefix("extensions.KHR_lights_punctual.").unwrap_or(place);
        let (array, rest) = path.split_once('[')?;
        let index: Index = rest.split_once(']')?.0.parse().ok()?;
        let root = &self.root;
        match array {
            "animations" => root.animations.get(index)?.name.as_deref(),
            "cameras" => root.cameras.get(index)?.name.as_deref(),
            "images" => {
                let image = root.images.get(index)?;
                let file = image.uri.as_deref().filter(|uri| !resource::is_data(uri));
                image.name.as_deref().filter(|name| !name.is_empty()).or(file)
            }
            "lights" => root.extensions.lights_punctual.lights.get(index)?.name.as_deref(),
            "materials" => root.materials.get(index)?.name.as_deref(),
            "meshes" => root.meshes.get(index)?.name.as_deref(),
            "nodes" => root.nodes.get(index)?.name.as_deref(),
            "skins" => root.skins.get(index)?.name.as_deref(),
            "textures" => root.textures.get(index)?.name.as_deref(),
            _ => None,
        }
    }

    /// Adds a warning unless the same one is there already.
    pub(super) fn warn(&self, warning: LoadWarning) {
        if self.warned.borrow_mut().insert(warning.to_string()) {
            self.warnings.borrow_mut().push(warning);
        }
    }

    /// Warns of something that was wrong in the file and has been put right.
    pub(super) fn repaired(&self, place: &str, what: &str) {
        self.warn(LoadWarning::Repaired { place: self.titled(place), what: what.to_owned() });
    }

    /// All warnings, or as many as anyone reads.
    pub(super) fn into_warnings(self) -> Vec<LoadWarning> {
        let mut warnings = self.warnings.into_inner();
        if warnings.len() > MOST_WARNINGS {
            let count = warnings.len() - (MOST_WARNINGS - 1);
            warnings.truncate(MOST_WARNINGS - 1);
            warnings.push(LoadWarning::More { count });
        }
        warnings
    }

    /// `list[index]`, or an error that says who referred to it.
    pub(super) fn get<'l, T>(
        &self,
        list: &'l [T],
        index: Index,
        what: &str,
        place: &str,
    ) -> Result<&'l T, SceneError> {
        list.get(index).ok_or_else(|| {
            let problem = format!(
                "{what} {index} is referred to, but there are only {}; export the file again",
                list.len()
            );
            self.fault(place, problem)
        })
    }

    /// Takes memory for `count` values of `bytes_each` from what the file may cost.
    pub(super) fn charge(&self, count: usize, bytes_each: usize, place: &str) -> Result<(), SceneError> {
        let cost = (count as u64).saturating_mul(bytes_each as u64);
        let left = self.bytes_left.get().checked_sub(cost).ok_or_else(|| {
            let problem = format!(
                "{count} elements of {bytes_each} bytes are more than a file of this size may hold; check the count, or split the file"
            );
            self.limit(place, problem)
        })?;
        self.bytes_left.set(left);
        Ok(())
    }

    /// The bytes of a URI, which count as bytes read.
    pub(super) fn read_uri(&self, uri: &str, place: &str) -> Result<Vec<u8>, SceneError> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let bytes =
            resource::read_uri(uri, folder, &self.options.allowed_folders).map_err(|error| match error {
                UriError::Refused(problem) => self.fault(place, problem),
                UriError::Unreadable(error) => {
                    self.fault(place, format!("{error}; put it there or correct the name"))
                }
            })?;
        self.bytes_left.set(self.bytes_left.get() + BYTES_PER_INPUT_BYTE * bytes.len() as u64);
        Ok(bytes)
    }

    /// A buffer, as long as the file says or longer.
    fn buffer(&self, index: Index, place: &str) -> Result<&[u8], SceneError> {
        let buffer = self.get(&self.root.buffers, index, "buffer", place)?;
        let place = format!("buffers[{index}]");
        let bytes = match (&buffer.uri, self.binary_chunk) {
            (Some(uri), _) => match self.buffers[index].get() {
                Some(bytes) => bytes.as_slice(),
                None => {
                    let bytes = self.read_uri(uri, &place)?;
                    self.buffers[index].get_or_init(|| bytes)
                }
            },
            (None, Some(chunk)) if index == 0 => chunk,
            (None, _) => {
                let problem = "it has neither a URI nor a binary chunk; export the file again";
                return Err(self.fault(place, problem));
            }
        };
        if let Some(whole) = bytes.get(..buffer.byte_length) {
            return Ok(whole);
        }
        let problem = format!(
            "it should hold {} bytes but holds {}; the data is cut short, copy or export it again",
            buffer.byte_length,
            bytes.len()
        );
        self.lose(self.fault(place, problem), "what lies beyond is lost")?;
        Ok(bytes)
    }

    /// Part of a buffer.
    fn buffer_range(
        &self,
        buffer: Index,
        offset: usize,
        length: usize,
        place: &str,
    ) -> Result<&[u8], SceneError> {
        let bytes = self.buffer(buffer, place)?;
        offset.checked_add(length).and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
            let problem = format!(
                "bytes {offset} to {offset}+{length} are asked for, but buffer {buffer} has only {}; export the file again",
                bytes.len()
            );
            self.fault(place, problem)
        })
    }

    /// The bytes of a buffer view, decompressed, and the stride it prescribes.
    pub(super) fn view(&self, index: Index, place: &str) -> Result<(&[u8], Option<usize>), SceneError> {
        let view = self.get(&self.root.buffer_views, index, "buffer view", place)?;
        let view_place = format!("bufferViews[{index}]");
        let Some(compressed) = &view.extensions.meshopt else {
            let bytes = self.buffer_range(view.buffer, view.byte_offset, view.byte_length, &view_place)?;
            return Ok((bytes, view.byte_stride));
        };
        if let Some(bytes) = self.views[index].get() {
            return Ok((bytes, view.byte_stride));
        }
        let data = self.buffer_range(
            compressed.buffer,
            compressed.byte_offset,
            compressed.byte_length,
            &view_place,
        )?;
        self.charge(compressed.count, compressed.byte_stride, &view_place)?;
        let bytes = meshopt::decode(compressed, data).map_err(|problem| {
            self.fault(view_place, format!("meshopt compression: {problem}; compress the file again"))
        })?;
        let bytes = self.views[index].get_or_init(|| bytes);
        Ok((bytes, view.byte_stride))
    }
}

/// Why a version cannot be read.
fn version_problem(asset: &Asset) -> Option<String> {
    let version = asset.min_version.as_deref().unwrap_or(&asset.version);
    let is_known =
        version.split('.').next() == Some("2") && asset.min_version.as_deref().is_none_or(|min| min == "2.0");
    if version.is_empty() {
        return Some("it does not say of which version it is; is it a glTF file?".to_owned());
    }
    (!is_known).then(|| format!("the file is of glTF version '{version}'; export it as glTF 2.0"))
}

/// A name short enough for a message, without characters that would change how the message is shown.
fn shown(name: &str) -> String {
    let mut shown = String::new();
    for letter in name.chars().take(LONGEST_NAME) {
        if letter.is_control() {
            shown.extend(letter.escape_default());
        } else {
            shown.push(letter);
        }
    }
    if name.chars().nth(LONGEST_NAME).is_some() {
        shown.push('…');
    }
    shown
}
