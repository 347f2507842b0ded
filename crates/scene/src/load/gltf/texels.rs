//! Textures before their images are decoded.

use std::sync::Arc;

use sheer_image::Image;

use super::schema::Index;
use crate::model::{Filter, Minification, Wrap};

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
    /// An image of the file.
    File(Index),
    /// Texels that are computed from other images.
    Computed(Arc<Image<[u8; 4]>>),
}

impl Texels {
    /// The image of the file that the texels are from, unless they are computed.
    pub(super) fn file_image(&self) -> Option<Index> {
        match self.source {
            Source::File(index) => Some(index),
            Source::Computed(_) => None,
        }
    }
}
