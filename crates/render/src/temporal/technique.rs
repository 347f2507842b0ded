//! What an anti-aliasing technique is: where each frame samples its pixels, and how frames are added up.

use glam::Vec2;
use sheer_core::{bibliography::Work, parameter::ParameterInfo};
use sheer_image::{ImageError, Planes};

use super::{align::Reprojection, layer_history::LayerHistory};
use crate::{contract::ShaderConstant, settings::LayerSplit};

/// A technique's row in lists and help, and what a GPU needs of it.
#[derive(Clone, Copy, Debug)]
pub struct AntialiasingInfo {
    /// The word on the command line; the module and the shader are called the same, with `_` for `-`.
    pub id: &'static str,
    /// A line on what it does.
    pub title: &'static str,
    /// Paper and section that describe it; `own` for what has no publication.
    pub paper: &'static str,
    /// The bibliography's entries for [`Self::paper`]; none for what has no publication.
    pub works: &'static [&'static Work],
    /// What it keeps of a pixel from frame to frame, in words.
    pub stores: &'static str,
    /// Whether all frames of a run show one moment.
    pub time_stands_still: bool,
    /// Frames after which a history that begins anew shows what an older one does, to about 55 dB where much
    /// moves; 0 where a frame owes nothing to those before it, or everything since the first.
    pub warm_up_frames: u32,
    /// Keys that it takes on the command line.
    pub parameters: &'static [ParameterInfo],
    /// Constants of its shader, beside its parameters and what all shaders have.
    pub constants: &'static [ShaderConstant],
}

/// What has been added up of the frames before.
#[derive(Clone, Debug)]
pub(super) struct Past {
    /// The picture; nothing yet before the first frame.
    pub(super) planes: Planes,
    /// What a technique keeps of each layer.
    pub(super) layers: Option<LayerHistory>,
    /// How many frames.
    pub(super) count: u32,
    /// How many frames in a row have shown the same, the new one among them.
    pub(super) still_count: u32,
}

/// How frames are added up.
pub(super) trait Technique: Sync {
    /// Offset of a frame's sample from the pixel centre, each coordinate in (-0.5, 0.5) pixels.
    fn jitter(&self, frame: u32) -> Vec2;

    /// See [`super::margin_px`].
    fn margin_px(&self) -> u32 {
        0
    }

    /// How it wants the pixels of each frame split into layers, if it does.
    fn layers(&self) -> Option<LayerSplit> {
        None
    }

    /// Turns a new frame into the picture so far, and returns what else is to be kept.
    ///
    /// # Errors
    /// [`ImageError::Size`] if memory does not suffice.
    fn resolve(
        &self,
        past: &Past,
        current: &mut Planes,
        reprojection: Reprojection,
    ) -> Result<Option<LayerHistory>, ImageError>;

    /// The value of each key, as it would be typed.
    fn values(&self) -> Vec<String>;
}
