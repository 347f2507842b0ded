//! What is kept of the layers of each pixel from frame to frame.

use glam::{Vec3, Vec4};
use sheer_image::Image;

/// Depth in place of infinity, which cannot be scaled.
pub(super) const FARTHEST: f32 = 1e30;

/// What has been averaged of one layer of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mean {
    /// YCoCg and alpha, premultiplied.
    pub(super) colour: Vec4,
    /// Mean weight of the samples.
    pub(super) weight: f32,
    /// How many samples; no more than a new one's least weight allows.
    pub(super) count: f32,
    /// Variance of their luma.
    pub(super) variance: f32,
}

/// What is kept of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kept {
    pub(super) front: Mean,
    pub(super) back: Mean,
    /// Mean coverage, what glass absorbs beyond it, and of how many frames.
    pub(super) coverage: f32,
    pub(super) absorbed: Vec3,
    pub(super) coverage_count: f32,
    pub(super) back_depth: f32,
}

/// What is kept of the layers of all pixels.
#[derive(Clone, Debug)]
pub(super) struct LayerHistory(pub(super) Image<Kept>);

/// One of the layers of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Front,
    Back,
}

impl Mean {
    pub(super) const NONE: Self = Self { colour: Vec4::ZERO, weight: 0.0, count: 0.0, variance: 0.0 };

    /// With another sample: the mean of all samples by their weights, exponential once they are `most`.
    pub(super) fn plus(self, colour: Vec4, weight: f32, most: f32) -> Self {
        let count = (self.count + 1.0).min(most);
        let mean_weight = self.weight + (weight - self.weight) / count;
        if mean_weight <= 0.0 {
            return self;
        }
        let gain = (weight / (count * mean_weight)).min(1.0);
        let offset = colour - self.colour;
        let variance = (1.0 - gain) * (self.variance + gain * offset.x * offset.x);
        Self { colour: self.colour + offset * gain, weight: mean_weight, count, variance }
    }
}

impl Kept {
    pub(super) const NONE: Self = Self {
        front: Mean::NONE,
        back: Mean::NONE,
        coverage: 0.0,
        absorbed: Vec3::ZERO,
        coverage_count: 0.0,
        back_depth: FARTHEST,
    };

    /// What glass absorbs, and the coverage.
    pub(super) fn hidden(&self) -> Vec4 {
        self.absorbed.extend(self.coverage)
    }

    pub(super) fn mean(&self, side: Side) -> &Mean {
        match side {
            Side::Front => &self.front,
            Side::Back => &self.back,
        }
    }
}
