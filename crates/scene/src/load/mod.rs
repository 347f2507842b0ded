//! Loaders, one file a format.

use std::path::Path;

use crate::error::SceneError;

mod gltf;
mod loaded;

pub use loaded::{LoadWarning, Loaded};

/// Opens a `.gltf` or `.glb` file by path; its extension, in any case, says which format it has.
///
/// # Errors
/// [`SceneError::UnknownFormat`] for a path with another extension or none; otherwise [`SceneError`] says
/// what is wrong, where, and what to do.
pub fn open(path: impl AsRef<Path>) -> Result<Loaded, SceneError> {
    let path = path.as_ref();
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("gltf" | "glb") => gltf::load(path),
        _ => Err(SceneError::UnknownFormat { path: path.to_owned() }),
    }
}

/// Reads a `.gltf` or `.glb` file that is in memory already. Files that it refers to are looked for beside
/// `path`, which also names the scene and stands in messages; it need not exist.
///
/// # Errors
/// [`SceneError::File`] says what is wrong, where, and what to do; [`SceneError::Read`] names a file beside
/// it that cannot be read.
pub fn read_gltf(bytes: &[u8], path: &Path) -> Result<Loaded, SceneError> {
    gltf::load_slice(bytes, path)
}
