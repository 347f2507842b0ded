//! Why images cannot be compared.

use sheer_image::{Image, ImageError};

/// Why a metric has no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MetricError {
    /// The images differ in size.
    #[error(
        "cannot compare {}x{} pixels with a reference of {}x{}: render both at the same size",
        image.0, image.1, reference.0, reference.1
    )]
    SizesDiffer {
        /// Width and height of the reference, in pixels.
        reference: (u32, u32),
        /// Width and height of the image, in pixels.
        image: (u32, u32),
    },
    /// A clip and its reference differ in length, or are empty.
    #[error(
        "cannot compare {images} frames with {references} reference frames: give as many of both, at least one"
    )]
    FramesDiffer {
        /// Frames of the reference clip.
        references: usize,
        /// Frames of the clip that is compared.
        images: usize,
    },
    /// ColorVideoVDP has no answer.
    #[error("ColorVideoVDP: {0}")]
    Vdp(#[from] colorvideovdp::Error),
    /// A result does not fit into memory.
    #[error(transparent)]
    Image(#[from] ImageError),
}

/// Passes if both images have the same size.
pub(crate) fn check_sizes<A, B>(reference: &Image<A>, image: &Image<B>) -> Result<(), MetricError> {
    if reference.size() == image.size() {
        Ok(())
    } else {
        Err(MetricError::SizesDiffer { reference: reference.size(), image: image.size() })
    }
}
