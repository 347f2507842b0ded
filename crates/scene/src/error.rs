//! What can be wrong with a scene.

use std::path::PathBuf;

/// Why there is no scene. Each message says where the fault is and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Neither a built-in scene nor a file with a known extension.
    #[error(
        "'{0}' is neither a built-in scene nor a .gltf or .glb file; `sheer scenes` lists the built-in ones"
    )]
    Unknown(String),
    /// A built-in scene's parameter is off.
    #[error("scene '{scene}': {problem}; `sheer scenes` lists the parameters")]
    Parameter {
        /// Built-in name.
        scene: String,
        /// What is wrong, in words.
        problem: String,
    },
    /// The file or a file it refers to cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file breaks its format, or asks for what is not supported.
    #[error("{path}: {place}: {problem}")]
    File {
        /// The file.
        path: PathBuf,
        /// Node, mesh, accessor, image… with index and name.
        place: String,
        /// What is wrong and what to do.
        problem: String,
    },
    /// A scene put together by a program is not valid.
    #[error("scene '{scene}': {place}: {problem}")]
    Invalid {
        /// Scene name.
        scene: String,
        /// Part and index.
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// The asked-for camera is not there.
    #[error("scene '{scene}' has no camera '{wanted}'; it has: {available}")]
    NoCamera {
        /// Scene name.
        scene: String,
        /// What was asked for.
        wanted: String,
        /// What there is.
        available: String,
    },
}
