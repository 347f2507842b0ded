//! Loaders, one file a format.

use std::{fmt, path::Path};

use crate::{SceneError, scene::Scene};

mod gltf;

/// A scene and what was left out of it.
#[derive(Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// Things a user should know, each said once.
    pub warnings: Vec<LoadWarning>,
}

/// Something in a file that is shown differently from what its author meant.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LoadWarning {
    /// An optional extension that has no effect here.
    ExtensionIgnored {
        /// Its name.
        extension: String,
    },
    /// Points and lines are not drawn.
    NotTriangles {
        /// Mesh and primitive.
        place: String,
        /// The mode's name.
        mode: String,
    },
    /// `KHR_materials_transmission` is drawn as coverage: nothing refracts.
    TransmissionAsCoverage {
        /// Material index and name.
        material: String,
    },
    /// An animation moves what an earlier one moves, and is not played.
    AnimationSkipped {
        /// Animation index and name.
        place: String,
    },
    /// The file was repaired in a way its author would want, e.g. a normal that was not of unit length.
    Repaired {
        /// Where.
        place: String,
        /// What was done.
        what: String,
    },
}

impl fmt::Display for LoadWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ExtensionIgnored { extension } => write!(f, "extension {extension} has no effect here"),
            Self::NotTriangles { place, mode } => write!(f, "{place}: {mode} are not drawn"),
            Self::TransmissionAsCoverage { material } => {
                write!(f, "{material}: transmission is drawn as alpha coverage, without refraction")
            }
            Self::AnimationSkipped { place } => {
                write!(f, "{place} is not played: it moves what an earlier animation moves")
            }
            Self::Repaired { place, what } => write!(f, "{place}: {what}"),
        }
    }
}

/// Opens a `.gltf` or `.glb` file by path; its extension, in any case, says which format it has.
///
/// # Errors
/// [`SceneError::UnknownFormat`] for a path with another extension or none; otherwise [`SceneError`] says what is wrong, where, and what
/// to do.
pub fn open(path: impl AsRef<Path>) -> Result<Loaded, SceneError> {
    let path = path.as_ref();
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("gltf" | "glb") => gltf::load(path),
        _ => Err(SceneError::UnknownFormat { path: path.to_owned() }),
    }
}

/// Reads a `.gltf` or `.glb` file that is in memory already. Files that it refers to are looked for beside `path`, which also names the
/// scene and stands in messages; it need not exist.
///
/// # Errors
/// [`SceneError::File`] says what is wrong, where, and what to do; [`SceneError::Read`] names a file beside it that cannot be read.
pub fn read_gltf(bytes: &[u8], path: &Path) -> Result<Loaded, SceneError> {
    gltf::load_slice(bytes, path)
}
