//! Why a frame cannot be rendered.

use sheer_image::{ImageError, Region};
use sheer_scene::SceneError;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The scene cannot be seen as asked.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The picture cannot be made.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The part of the picture that is to be rendered is not within it.
    #[error("the part {crop} reaches beyond the picture of {}x{} pixels", size[0], size[1])]
    Crop {
        /// The part.
        crop: Region,
        /// Width and height of the picture, pixels.
        size: [u32; 2],
    },
    /// The operating system gives no threads.
    #[error("cannot start the rendering threads: {0}; try fewer with --threads")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The shadow maps are too large.
    #[error(
        "the shadow maps of {lights} lights would take {mebibytes} MiB; give --shadow a lower resolution= or less of what it keeps of a texel"
    )]
    ShadowMaps {
        /// How many lights there are.
        lights: usize,
        /// What their maps would take at least.
        mebibytes: usize,
    },
}
