//! Scene files, one file or folder a format: each ends in [`Scene::new`](sheer_scene::Scene::new), which
//! validates what was read.
//!
//! A file does not take more of the machine than [`LoadOptions::memory_limit`] allows: it is counted before
//! it is taken. What is broken in it is left out and named in a [`LoadWarning`] if the rest can be drawn.

use std::{
    fs::{self, File},
    io::Read as _,
    path::Path,
};

mod contents;
mod crease;
mod error;
mod gltf;
mod hair;
mod loaded;
mod obj;
mod options;
mod ply;
mod polygon;
mod single;
mod source;
mod stl;
mod stroke;
mod text;
mod vertex_colour;

use contents::chosen;
use source::Source;

pub use contents::{Clip, Contents, Extension};
pub use error::LoadError;
pub use loaded::{LoadWarning, Loaded};
pub use options::LoadOptions;
pub use single::scene_of_mesh;

/// Opens a scene file by path, with the default [`LoadOptions`].
///
/// # Errors
/// As [`open_with`].
pub fn open(path: impl AsRef<Path>) -> Result<Loaded, LoadError> {
    open_with(path, &LoadOptions::default())
}

/// Who reads a format.
type Read = fn(&[u8], &Path, &LoadOptions) -> Result<Loaded, LoadError>;

/// A format and how its files are known.
struct Format {
    /// Endings of its files in lower case.
    endings: &'static [&'static str],
    /// Whether a file that begins with these bytes is of this format and no other.
    begins: fn(&[u8]) -> bool,
    read: Read,
}

/// All formats.
const FORMATS: &[Format] = &[
    Format { endings: &["gltf", "glb"], begins: gltf::begins_like_gltf, read: gltf::load_slice },
    Format {
        endings: &["obj"],
        begins: |_| false,
        read: |bytes, path, options| obj::read(bytes, Source::new("OBJ", bytes.len(), path, options)?),
    },
    Format {
        endings: &["ply"],
        begins: |bytes| bytes.starts_with(ply::SIGNATURE),
        read: |bytes, path, options| ply::read(bytes, Source::new("PLY", bytes.len(), path, options)?),
    },
    Format {
        endings: &["stl"],
        begins: stl::begins_like_stl,
        read: |bytes, path, options| stl::read(bytes, Source::new("STL", bytes.len(), path, options)?),
    },
    Format {
        endings: &["hair"],
        begins: |bytes| bytes.starts_with(hair::SIGNATURE),
        read: |bytes, path, options| hair::read(bytes, Source::new("hair", bytes.len(), path, options)?),
    },
];

/// The endings of the files that can be opened, for messages: `.gltf, .glb or …`.
#[must_use]
pub fn endings() -> String {
    let all: Vec<String> =
        FORMATS.iter().flat_map(|format| format.endings).map(|ending| format!(".{ending}")).collect();
    match all.split_last() {
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}

/// The format of a file, by its ending, in any case, or its first bytes: what is in it counts for more.
fn format_of(path: &Path, beginning: &[u8]) -> Result<&'static Format, LoadError> {
    let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
    let by_ending = FORMATS
        .iter()
        .find(|format| ending.as_deref().is_some_and(|ending| format.endings.contains(&ending)));
    let begins = |format: &&Format| (format.begins)(beginning);
    by_ending
        .filter(begins)
        .or_else(|| FORMATS.iter().find(begins))
        .or(by_ending)
        .ok_or_else(|| LoadError::UnknownFormat { path: path.to_owned(), endings: endings() })
}

/// Opens a scene file by path: glTF 2.0, OBJ, PLY, STL or hair, by its ending (see [`endings`]), in any case,
/// or by what is in it, as in `.vrm`.
///
/// # Errors
/// [`LoadError::UnknownFormat`] for a path that is of none; otherwise [`LoadError`] says what is wrong,
/// where, and what to do.
pub fn open_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let path = path.as_ref();
    let format = format_of(path, &first_bytes(path))?;
    let most_bytes = options.memory_limit.map_or(u64::MAX, |limit| limit.0);
    (format.read)(&gltf::read_file(path, most_bytes)?, path, options)
}

/// Reads a file that is in memory already. Files that it refers to are looked for beside `path`, which also
/// names the scene, stands in messages and says by its ending which format it is where the bytes leave it
/// open; it need not exist.
///
/// # Errors
/// As [`open_with`].
pub fn read(bytes: &[u8], path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    (format_of(path, bytes)?.read)(bytes, path, options)
}

/// Reads a `.gltf` or `.glb` file that is in memory already. Files that it refers to are looked for beside
/// `path`, which also names the scene and stands in messages; it need not exist.
///
/// # Errors
/// [`LoadError::File`] says what is wrong, where, and what to do; [`LoadError::Limit`] that the file asks
/// for more than it may take; [`LoadError::Read`] names a file beside it that cannot be read.
pub fn read_gltf(bytes: &[u8], path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    gltf::load_slice(bytes, path, options)
}

/// What a file begins with, enough to know a format by; nothing if it is no file that can be read.
fn first_bytes(path: &Path) -> Vec<u8> {
    const MOST: u64 = 64;
    let mut bytes = Vec::new();
    // A pipe or a device may have no end, or wait for ever.
    if fs::metadata(path).is_ok_and(|metadata| metadata.is_file())
        && let Ok(file) = File::open(path)
    {
        // What cannot be read has no format.
        let _ = file.take(MOST).read_to_end(&mut bytes);
    }
    bytes
}
