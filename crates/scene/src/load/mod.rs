//! Loaders, one file a format.

use std::{
    fs::{self, File},
    io::Read as _,
    path::Path,
};

use crate::error::SceneError;

mod gltf;
mod loaded;
mod options;

pub use loaded::{LoadWarning, Loaded};
pub use options::LoadOptions;

/// Opens a scene file by path, with the default [`LoadOptions`].
///
/// # Errors
/// As [`open_with`].
pub fn open(path: impl AsRef<Path>) -> Result<Loaded, SceneError> {
    open_with(path, &LoadOptions::default())
}

/// Opens a scene file by path. Its ending, in any case, says which format it has: `.gltf` or `.glb`. A file
/// with another ending, or none, is opened as glTF if that is what is in it, as in `.vrm`.
///
/// # Errors
/// [`SceneError::UnknownFormat`] for a path that is neither; otherwise [`SceneError`] says what is wrong,
/// where, and what to do.
pub fn open_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, SceneError> {
    let path = path.as_ref();
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("gltf" | "glb") => gltf::load(path, options),
        _ if gltf::begins_like_gltf(&first_bytes(path)) => gltf::load(path, options),
        _ => Err(SceneError::UnknownFormat { path: path.to_owned() }),
    }
}

/// Reads a `.gltf` or `.glb` file that is in memory already. Files that it refers to are looked for beside
/// `path`, which also names the scene and stands in messages; it need not exist.
///
/// # Errors
/// [`SceneError::File`] says what is wrong, where, and what to do; [`SceneError::Limit`] that the file asks
/// for more than it may take; [`SceneError::Read`] names a file beside it that cannot be read.
pub fn read_gltf(bytes: &[u8], path: &Path, options: &LoadOptions) -> Result<Loaded, SceneError> {
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
