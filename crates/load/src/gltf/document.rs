//! A parsed file: its JSON, its bytes, what it may still cost, and what there was to say about it.

use std::{
    cell::{Cell, OnceCell, RefCell},
    collections::{HashMap, HashSet},
    hash::{BuildHasher as _, RandomState},
    io,
    path::{Path, PathBuf},
    rc::Rc,
};

use sheer_core::text::{MemorySize, beginning, quoted};

use super::{
    choice::Choices,
    json_size, lenient,
    limits::{BASE_BYTES, BYTES_PER_INPUT_BYTE},
    meshopt,
    resource::{self, UriError},
    schema::{Asset, Index, Root},
};
use crate::{
    LoadError, LoadOptions, LoadWarning,
    error::beyond_limit,
    loaded::{LONGEST_MESSAGE, LONGEST_NAME},
};

/// Warnings of a file that are said: a file in which everything is wrong would say it of everything.
const MOST_WARNINGS: usize = 100;
/// What the tree of a JSON text may take that does not parse as it stands, in bytes.
const LARGEST_TREE: u64 = 4 << 30;

/// The file while it is being read. Buffers are read when first asked for.
pub(super) struct Document<'a> {
    pub root: Root,
    pub options: &'a LoadOptions,
    /// What the options choose in this file.
    pub choices: Choices,
    path: &'a Path,
    binary_chunk: Option<&'a [u8]>,
    buffers: Vec<OnceCell<Rc<Vec<u8>>>>,
    /// Files that buffers lie in, each read once however many do.
    files: RefCell<HashMap<PathBuf, Rc<Vec<u8>>>>,
    /// Buffer views that are compressed, each decompressed when it is first asked for.
    views: Vec<OnceCell<Vec<u8>>>,
    /// What may still be decoded from a file of this size.
    bytes_left: Cell<u64>,
    /// What the scene may still take.
    memory_left: Cell<u64>,
    warnings: RefCell<Vec<LoadWarning>>,
    /// Hashes of the texts of all warnings, and how many were not kept.
    warned: RefCell<HashSet<u64>>,
    unsaid: Cell<usize>,
    hasher: RandomState,
    /// Place and problem of the first part that was lost.
    first_loss: RefCell<Option<(String, String)>>,
}

impl<'a> Document<'a> {
    pub(super) fn parse(
        bytes: &'a [u8],
        path: &'a Path,
        options: &'a LoadOptions,
    ) -> Result<Self, LoadError> {
        let fault = |place: &str, problem: String| LoadError::File {
            path: path.to_owned(),
            place: place.to_owned(),
            problem: shown(&problem),
        };
        let memory = options.memory_limit.map_or(u64::MAX, |limit| limit.0);
        let (json, binary_chunk) =
            resource::split_container(bytes).map_err(|problem| fault("container", problem))?;
        let parsed = json_size::parsed_bytes(json).saturating_add(bytes.len() as u64);
        let memory_left = memory.checked_sub(parsed).ok_or_else(|| LoadError::Limit {
            path: path.to_owned(),
            place: "JSON".to_owned(),
            problem: beyond_limit(parsed, memory, memory),
        })?;
        let strict: Option<Root> = serde_json::from_slice(json).ok();
        let lenient::Parsed { mut root, is_straightened, left_out } = match strict {
            Some(root) => lenient::Parsed { root, is_straightened: false, left_out: Vec::new() },
            None if json_size::tree_bytes(json) > memory_left.min(LARGEST_TREE) => {
                let problem = "it does not parse as it stands, and is too large to find out why; check it with a glTF validator";
                return Err(fault("JSON", problem.to_owned()));
            }
            None => lenient::parse(json, |only| version_problem(&only.asset))
                .map_err(|lenient::Fault { place, problem }| fault(&place, problem))?,
        };
        if let Some(problem) = version_problem(&root.asset) {
            return Err(fault("asset", problem));
        }
        cut_names(&mut root);
        let choices = Choices::new(&root, path, options)?;
        let (buffer_count, view_count) = (root.buffers.len(), root.buffer_views.len());
        let document = Self {
            root,
            options,
            choices,
            path,
            binary_chunk,
            buffers: (0..buffer_count).map(|_| OnceCell::new()).collect(),
            files: RefCell::default(),
            views: (0..view_count).map(|_| OnceCell::new()).collect(),
            bytes_left: Cell::new(BASE_BYTES + BYTES_PER_INPUT_BYTE * bytes.len() as u64),
            memory_left: Cell::new(memory_left),
            warnings: RefCell::default(),
            warned: RefCell::default(),
            unsaid: Cell::new(0),
            hasher: RandomState::new(),
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
    pub(super) fn fault(&self, place: impl AsRef<str>, problem: impl Into<String>) -> LoadError {
        let place = self.titled(place.as_ref());
        LoadError::File { path: self.path.to_owned(), place, problem: shown(&problem.into()) }
    }

    /// An error at a place that asks for more than the file may take.
    pub(super) fn limit(&self, place: impl AsRef<str>, problem: impl Into<String>) -> LoadError {
        let place = self.titled(place.as_ref());
        LoadError::Limit { path: self.path.to_owned(), place, problem: shown(&problem.into()) }
    }

    /// A part of the file, or nothing where it is broken: then `outcome` says in the warning what became of
    /// it. It stays an error for callers who are strict, and where the file asks for too much.
    pub(super) fn salvage<T>(
        &self,
        part: Result<T, LoadError>,
        outcome: &str,
    ) -> Result<Option<T>, LoadError> {
        match part {
            Err(LoadError::File { place, problem, .. }) if !self.options.strict => {
                self.first_loss.borrow_mut().get_or_insert_with(|| (place.clone(), problem.clone()));
                self.warn(LoadWarning::Lost { place, problem, outcome: outcome.to_owned() });
                Ok(None)
            }
            part => part.map(Some),
        }
    }

    /// Warns of a broken part and what became of it, or fails, as [`Self::salvage`] does.
    pub(super) fn lose(&self, fault: LoadError, outcome: &str) -> Result<(), LoadError> {
        self.salvage::<()>(Err(fault), outcome).map(|_| ())
    }

    /// The first part that was lost, as an error.
    pub(super) fn first_loss(&self) -> Option<LoadError> {
        let loss = self.first_loss.take();
        loss.map(|(place, problem)| LoadError::File { path: self.path.to_owned(), place, problem })
    }

    /// A place with the author's name for the part of the root that it begins with, if it has one:
    /// `meshes[3].primitives[0] ('Body')`.
    pub(super) fn titled(&self, place: &str) -> String {
        match self.name_of(place) {
            Some(name) if !name.is_empty() => format!("{place} ('{}')", quoted(name)),
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

    /// Adds a warning unless the same one is there already; counts it where there are enough.
    pub(super) fn warn(&self, warning: LoadWarning) {
        let hash = self.hasher.hash_one(warning.to_string());
        if !self.warned.borrow_mut().insert(hash) {
            return;
        }
        let mut warnings = self.warnings.borrow_mut();
        if warnings.len() < MOST_WARNINGS {
            warnings.push(warning);
        } else {
            self.unsaid.set(self.unsaid.get() + 1);
        }
    }

    /// Warns of something that was wrong in the file and has been put right.
    pub(super) fn repaired(&self, place: &str, what: &str) {
        self.warn(LoadWarning::Repaired { place: self.titled(place), what: what.to_owned() });
    }

    /// All warnings, or as many as anyone reads.
    pub(super) fn into_warnings(self) -> Vec<LoadWarning> {
        let mut warnings = self.warnings.into_inner();
        let unsaid = self.unsaid.get();
        if unsaid > 0 {
            // The last one makes room.
            warnings.truncate(MOST_WARNINGS - 1);
            warnings.push(LoadWarning::More { count: unsaid + 1 });
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
    ) -> Result<&'l T, LoadError> {
        list.get(index).ok_or_else(|| {
            let problem = format!(
                "{what} {index} is referred to, but there are only {}; export the file again",
                list.len()
            );
            self.fault(place, problem)
        })
    }

    /// Takes memory for `count` values of `bytes_each` from what the file may cost.
    pub(super) fn charge(&self, count: usize, bytes_each: usize, place: &str) -> Result<(), LoadError> {
        let cost = (count as u64).saturating_mul(bytes_each as u64);
        self.take(cost, place)?;
        let left = self.bytes_left.get().checked_sub(cost).ok_or_else(|| {
            let problem = format!(
                "{count} elements of {bytes_each} bytes are more than a file of this size may hold; check the count, or split the file"
            );
            self.limit(place, problem)
        })?;
        self.bytes_left.set(left);
        Ok(())
    }

    /// Takes memory from what the scene may take in all.
    pub(super) fn take(&self, bytes: u64, place: &str) -> Result<(), LoadError> {
        let Some(MemorySize(limit)) = self.options.memory_limit else { return Ok(()) };
        let left = self.memory_left.get();
        let rest =
            left.checked_sub(bytes).ok_or_else(|| self.limit(place, beyond_limit(bytes, left, limit)))?;
        self.memory_left.set(rest);
        Ok(())
    }

    /// Gives back memory that was taken and is not kept. What may be decoded stays less by it: that took
    /// time.
    pub(super) fn give_back(&self, bytes: usize) {
        self.memory_left.set(self.memory_left.get().saturating_add(bytes as u64));
    }

    /// What the scene may still take in memory, in bytes.
    pub(super) fn memory_left(&self) -> u64 {
        self.memory_left.get()
    }

    /// The file that a URI means; none for inline data, or if it may not be read.
    pub(super) fn file_of(&self, uri: &str) -> Option<PathBuf> {
        resource::file_of(uri, self.folder(), &self.options.allowed_folders)
    }

    fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// The bytes of a URI, which count as bytes read.
    pub(super) fn read_uri(&self, uri: &str, place: &str) -> Result<Vec<u8>, LoadError> {
        let allowed = &self.options.allowed_folders;
        let bytes =
            resource::read_uri(uri, self.folder(), allowed, self.memory_left.get()).map_err(|error| {
                match error {
                    UriError::Refused(problem) => self.fault(place, problem),
                    UriError::Unreadable(LoadError::Read { source, path })
                        if source.kind() == io::ErrorKind::FileTooLarge =>
                    {
                        let problem =
                            format!("cannot read {}: {source}; raise --memory-limit", path.display());
                        self.limit(place, problem)
                    }
                    UriError::Unreadable(error) => {
                        self.fault(place, format!("{error}; put it there or correct the name"))
                    }
                }
            })?;
        self.take(bytes.len() as u64, place)?;
        self.bytes_left.set(self.bytes_left.get() + BYTES_PER_INPUT_BYTE * bytes.len() as u64);
        Ok(bytes)
    }

    /// The bytes of a URI, those of a file read the first time.
    fn read_once(&self, uri: &str, place: &str) -> Result<Rc<Vec<u8>>, LoadError> {
        let Some(file) = self.file_of(uri) else { return self.read_uri(uri, place).map(Rc::new) };
        if let Some(bytes) = self.files.borrow().get(&file) {
            return Ok(Rc::clone(bytes));
        }
        let bytes = Rc::new(self.read_uri(uri, place)?);
        self.files.borrow_mut().insert(file, Rc::clone(&bytes));
        Ok(bytes)
    }

    /// A buffer, as long as the file says or longer.
    fn buffer(&self, index: Index, place: &str) -> Result<&[u8], LoadError> {
        let buffer = self.get(&self.root.buffers, index, "buffer", place)?;
        let place = format!("buffers[{index}]");
        let bytes = match (&buffer.uri, self.binary_chunk) {
            (Some(uri), _) => match self.buffers[index].get() {
                Some(bytes) => bytes.as_slice(),
                None => {
                    let bytes = self.read_once(uri, &place)?;
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
    ) -> Result<&[u8], LoadError> {
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
    pub(super) fn view(&self, index: Index, place: &str) -> Result<(&[u8], Option<usize>), LoadError> {
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

/// What a message quotes, short and fit to be shown.
fn shown(text: &str) -> String {
    beginning(text, LONGEST_MESSAGE)
}

/// Shortens names that no one could read.
fn cut_names(root: &mut Root) {
    let lights = &mut root.extensions.lights_punctual.lights;
    let names = (root.animations.iter_mut().map(|animation| &mut animation.name))
        .chain(root.cameras.iter_mut().map(|camera| &mut camera.name))
        .chain(root.images.iter_mut().map(|image| &mut image.name))
        .chain(lights.iter_mut().map(|light| &mut light.name))
        .chain(root.materials.iter_mut().map(|material| &mut material.name))
        .chain(root.meshes.iter_mut().map(|mesh| &mut mesh.name))
        .chain(root.nodes.iter_mut().map(|node| &mut node.name))
        .chain(root.skins.iter_mut().map(|skin| &mut skin.name))
        .chain(root.textures.iter_mut().map(|texture| &mut texture.name));
    for name in names.flatten() {
        if let Some((end, _)) = name.char_indices().nth(LONGEST_NAME) {
            name.truncate(end);
            name.shrink_to_fit();
        }
    }
}
