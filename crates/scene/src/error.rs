//! What can be wrong with a scene.

use std::path::PathBuf;

/// Why there is no scene. Each message says where the fault is and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
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
    /// A scene put together by a program is not valid.
    #[error("scene '{scene}': {place}: {problem}")]
    Invalid {
        /// Name of the scene.
        scene: String,
        /// Which part is wrong: its kind, index and name.
        place: String,
        /// What is wrong with the part.
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
    /// The asked-for camera is not there.
    #[error("scene '{scene}' has no camera '{wanted}'; it has: {available}")]
    NoCamera {
        /// Name of the scene.
        scene: String,
        /// Name of the camera that was asked for.
        wanted: String,
        /// Names of the cameras that it has.
        available: String,
    },
}
