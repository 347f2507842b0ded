//! The plain mean of jittered frames of one moment: for stills and references.

use glam::Vec2;
use rayon::prelude::*;
use sheer_core::parameter::Values;
use sheer_image::{ImageError, Planes};

use super::{
    align::Reprojection,
    jitter::halton,
    layer_history::LayerHistory,
    technique::{AntialiasingInfo, Past, Technique},
};

/// The row of the technique in lists and help, and what a GPU needs of it.
pub(super) const INFO: AntialiasingInfo = AntialiasingInfo {
    id: "accumulate",
    title: "the plain mean of jittered frames of one moment",
    paper: "own",
    works: &[],
    stores: "the mean colour",
    time_stands_still: true,
    warm_up_frames: 0,
    parameters: &[],
    constants: &[],
};

/// The plain mean: nothing to set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Accumulate;

impl Accumulate {
    pub(super) fn new(_: &Values) -> Self {
        Self
    }
}

impl Technique for Accumulate {
    fn jitter(&self, frame: u32) -> Vec2 {
        halton(frame.wrapping_add(1))
    }

    fn resolve(
        &self,
        past: &Past,
        current: &mut Planes,
        _: Reprojection,
    ) -> Result<Option<LayerHistory>, ImageError> {
        // What was there before a history began anew is no part of it, not even by its rounding.
        if past.count == 0 {
            return Ok(None);
        }
        let weight = 1.0 / (past.count as f32 + 1.0);
        current.colour.par_rows_mut().zip(past.planes.colour.par_rows()).for_each(|(current, mean)| {
            for (current, mean) in current.iter_mut().zip(mean) {
                *current = std::array::from_fn(|channel| {
                    mean[channel] + (current[channel] - mean[channel]) * weight
                });
            }
        });
        Ok(None)
    }

    fn values(&self) -> Vec<String> {
        Vec::new()
    }
}
