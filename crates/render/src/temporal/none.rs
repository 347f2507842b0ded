//! No anti-aliasing: one sample through each pixel centre, each frame by itself.

use glam::Vec2;
use sheer_core::parameter::Values;
use sheer_image::{ImageError, Planes};

use super::{
    align::Reprojection,
    layer_history::LayerHistory,
    technique::{AntialiasingInfo, Past, Technique},
};

/// The row of the technique in lists and help, and what a GPU needs of it.
pub(super) const INFO: AntialiasingInfo = AntialiasingInfo {
    id: "none",
    title: "one sample through each pixel centre; frames are not added up",
    paper: "own",
    works: &[],
    stores: "nothing",
    time_stands_still: false,
    warm_up_frames: 0,
    parameters: &[],
    constants: &[],
};

/// No anti-aliasing: nothing to set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct None;

impl None {
    pub(super) fn new(_: &Values) -> Self {
        Self
    }
}

impl Technique for None {
    fn jitter(&self, _: u32) -> Vec2 {
        Vec2::ZERO
    }

    fn resolve(&self, _: &Past, _: &mut Planes, _: Reprojection) -> Result<Option<LayerHistory>, ImageError> {
        Ok(Option::None)
    }

    fn values(&self) -> Vec<String> {
        Vec::new()
    }
}
