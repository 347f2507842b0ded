//! What can be wrong with a scene.

use sheer_core::suggestion::suggestion;

/// Why there is no scene, or no such part of it. Each message says where the fault is.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
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
    /// The asked-for camera is not there.
    #[error("scene '{scene}' has no camera '{wanted}'; it has: {available}{}", suggestion(.wanted, .available.split(", ")))]
    NoCamera {
        /// Name of the scene.
        scene: String,
        /// Name of the camera that was asked for.
        wanted: String,
        /// Names of the cameras that it has.
        available: String,
    },
    /// A camera is to look at the point where it is.
    #[error("eye and target are the same point: there is no direction to look in")]
    NoDirection,
}
