//! Why there is no measurement.

use std::{error::Error, io};

use sheer_gallery::GalleryError;
use sheer_image::ImageError;
use sheer_metrics::MetricError;
use sheer_render::{Backend, RenderError, method::MethodError, shadow::ShadowError};
use sheer_scene::SceneError;

/// Why there is no measurement.
#[derive(Debug, thiserror::Error)]
pub enum LabError {
    /// Something was asked for that cannot be measured, whatever the state of the machine.
    #[error("{0}")]
    Misuse(String),
    /// There is no result, though everything ran.
    #[error("{0}")]
    NoResult(String),
    /// The backend does not run what was asked for.
    #[error(transparent)]
    Unsupported(Box<dyn Error + Send + Sync>),
    /// The backend makes no picture.
    #[error(transparent)]
    Backend(Box<dyn Error + Send + Sync>),
    /// A scene is there but cannot be rendered as asked.
    #[error("cannot set up {scene}: {source}")]
    SetUp {
        /// As it was asked for.
        scene: String,
        /// What the backend says.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The processor makes no picture.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The scene cannot be opened.
    #[error(transparent)]
    Gallery(#[from] GalleryError),
    /// A scene put together for a measurement is not valid, or lacks the camera that was asked for.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture does not fit into memory.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// Two pictures cannot be compared.
    #[error(transparent)]
    Metric(#[from] MetricError),
    /// There is no such method.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// There is no such shadow technique.
    #[error(transparent)]
    Shadow(#[from] ShadowError),
    /// What was to be done with a picture could not be done.
    #[error(transparent)]
    Output(Box<dyn Error + Send + Sync>),
    /// Temporary files cannot be written.
    #[error("cannot write temporary files: {0}; set TMPDIR to a folder that can be written to")]
    Temporary(#[from] io::Error),
}

/// A measurement, or why there is none.
pub type Result<T, E = LabError> = std::result::Result<T, E>;

impl LabError {
    /// What a backend says, told apart by whether it ever runs what was asked for.
    pub fn of_backend<B: Backend>(backend: &B, error: B::Error) -> Self {
        if backend.is_unsupported(&error) {
            Self::Unsupported(error.into())
        } else {
            Self::Backend(error.into())
        }
    }
}
