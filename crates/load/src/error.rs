//! What can be wrong with a scene file.

use std::path::PathBuf;

use sheer_core::text::MemorySize;
use sheer_scene::SceneError;

/// Why a file does not open as a scene. Each message says where the fault is and what to do.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The path has an extension of no format that can be read.
    #[error("cannot open '{path}': it is not a {endings} file (built-in scenes are those of sheer-gallery)")]
    UnknownFormat {
        /// As it was given.
        path: PathBuf,
        /// The endings that are known, in words.
        endings: String,
    },
    /// The file or a file it refers to cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file that is read.
        path: PathBuf,
        /// Why the system cannot read it.
        source: std::io::Error,
    },
    /// The file breaks its format, or asks for what is not supported.
    #[error("{path}: {place}: {problem}")]
    File {
        /// The file that is read.
        path: PathBuf,
        /// Node, mesh, accessor, image… with index and name.
        place: String,
        /// What is wrong and what to do.
        problem: String,
    },
    /// The file asks for more than it may take of the machine.
    #[error("{path}: {place}: {problem}")]
    Limit {
        /// The file that is read.
        path: PathBuf,
        /// Node, mesh, accessor, image… with index and name.
        place: String,
        /// What is too much and what to do.
        problem: String,
    },
    /// The asked-for scene, clip or variant is not in the file.
    #[error("{path}: there is no {what} '{wanted}'; {available}")]
    NoChoice {
        /// The file, or the text of a built-in scene.
        path: PathBuf,
        /// Which kind of thing was asked for.
        what: &'static str,
        /// Name or number that was asked for.
        wanted: String,
        /// What there is, in words.
        available: String,
    },
}

/// What is wrong with `bytes` more, of which `left` are left of a limit.
pub(crate) fn beyond_limit(bytes: u64, left: u64, limit: u64) -> String {
    let [bytes, left, limit] = [bytes, left, limit].map(MemorySize);
    format!(
        "it takes {bytes} of memory, and of the limit of {limit} there are {left} left; simplify it, or raise --memory-limit"
    )
}

/// Where a scene that was read is not valid, and what is wrong there.
pub(crate) fn invalid_part(error: SceneError) -> (String, String) {
    match error {
        SceneError::Invalid { place, problem, .. } => (place, problem),
        other => ("cameras".to_owned(), other.to_string()),
    }
}
