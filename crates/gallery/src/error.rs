//! Why there is no scene.

use sheer_load::LoadError;
use sheer_scene::SceneError;

/// Why a text does not open as a scene. Each message says what is wrong and what to do.
#[derive(Debug, thiserror::Error)]
pub enum GalleryError {
    /// Neither a built-in scene nor a file with a known extension.
    #[error(
        "'{text}' is neither a built-in scene nor a {endings} file; `sheer scenes` lists the built-in ones{suggestion}",
        endings = sheer_load::endings()
    )]
    Unknown {
        /// What was asked for.
        text: String,
        /// The built-in scene that is nearest to it, in words; empty where none is near.
        suggestion: String,
    },
    /// A parameter of a built-in scene is unknown, out of range or given twice.
    #[error("scene '{scene}': {problem}; `sheer scenes` lists the parameters")]
    Parameter {
        /// The scene's word on the command line.
        scene: String,
        /// What is wrong, in words.
        problem: String,
    },
    /// The file cannot be opened.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// What was built is not a valid scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
}
