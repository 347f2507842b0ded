//! Textures before their images are decoded.

use std::sync::Arc;

use sheer_image::Image;
use sheer_scene::model::{Filter, Minification, Wrap};

use super::schema::Index;

/// A texture before its image is decoded.
#[derive(Clone)]
pub(super) struct Texels {
    pub(super) name: String,
    pub(super) source: Source,
    pub(super) srgb: bool,
    pub(super) wrap: [Wrap; 2],
    pub(super) filter: Filter,
    pub(super) minification: Minification,
}

/// Where texels come from.
#[derive(Clone)]
pub(super) enum Source {
    /// Images of the file, of which the first that can be read is meant.
    File(Vec<Index>),
    /// Texels that are computed from other images.
    Computed(Arc<Image<[u8; 4]>>),
}

impl Texels {
    /// The images of the file that the texels may be from, unless they are computed.
    pub(super) fn file_images(&self) -> Option<&[Index]> {
        match &self.source {
            Source::File(indices) => Some(indices),
            Source::Computed(_) => None,
        }
    }
}
