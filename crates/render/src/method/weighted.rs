//! Weighted blended transparency: the mean of all colours, those nearer to the eye with more weight, over a background that is seen by the
//! exact transmittance (McGuire and Bavoil 2013).
//!
//! The weight functions are curves over the depth in scene units, made for metres and a range of 0.1 to 500. They depend on scale: the same
//! scene in centimetres has nearly all weights at their least and becomes the plain mean; a thumbnail of it has them at their most. Only
//! Eq. 10 goes by where a depth lies within the range of the frame.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};

use crate::contract::{Compositing, Fragment, Gathering, Memory, MethodInfo, PixelSite, Visitor};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "weighted",
    title: "the mean of all fragments, weighted by alpha and depth: one pass, no order at all",
    paper: "McGuire, Bavoil 2013, Weighted Blended Order-Independent Transparency",
    bias: "colours of several layers are a mean by weights that depend on the scene's scale; the background is exact",
    parameters: &[ParameterInfo {
        key: "weight",
        default: "eq7",
        range: ParameterRange::Choice(&["eq7", "eq8", "eq9", "eq10"]),
        what: "the paper's functions of depth; eq7 to eq9 for scenes in metres, eq10 for the depth range of the frame",
    }],
    alignment_px: 1,
};

/// Weights stay within these (Eq. 7 to 9), so that sums in 16-bit floats neither overflow nor vanish.
pub const WEIGHTS: [f32; 2] = [1e-2, 3e3];

/// Weighted blended transparency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighted {
    weight: Weight,
}

/// The equations of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Weight {
    Eq7,
    Eq8,
    Eq9,
    Eq10,
}

/// Sums over the fragments of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sums {
    depth_range: [f32; 2],
    rgb_weighted: Vec3,
    alpha_weighted: f32,
    transmittance: f32,
    count: u32,
}

impl Weighted {
    pub(crate) fn new(values: &Values) -> Self {
        let weight = match values.text("weight") {
            "eq8" => Weight::Eq8,
            "eq9" => Weight::Eq9,
            "eq10" => Weight::Eq10,
            _ => Weight::Eq7,
        };
        Self { weight }
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.compositing(self)
    }
}

impl Weight {
    /// The weight of a depth, without the factor of alpha that all of them have.
    fn of_depth(self, depth: f32, [near, far]: [f32; 2]) -> f32 {
        let z = depth.abs();
        let curve = match self {
            Self::Eq7 => 10.0 / (1e-5 + (z / 5.0).powi(2) + (z / 200.0).powi(6)),
            Self::Eq8 => 10.0 / (1e-5 + (z / 10.0).powi(3) + (z / 200.0).powi(6)),
            Self::Eq9 => 0.03 / (1e-5 + (z / 200.0).powi(4)),
            Self::Eq10 => {
                // What a depth buffer holds (Eq. 11).
                let span = (far - near).max(f32::EPSILON * far);
                let in_buffer = (far - near * far / z.max(near)) / span;
                WEIGHTS[1] * (1.0 - in_buffer).powi(3)
            }
        };
        curve.clamp(WEIGHTS[0], WEIGHTS[1])
    }
}

impl Compositing for Weighted {
    type Pixel = Sums;

    fn gathering(&self) -> Gathering {
        Gathering::Unordered { each_pass: false }
    }

    fn memory(&self) -> Memory {
        // Sums of colour and alpha in 16-bit floats; transmittance in one more.
        Memory::Bounded(10)
    }

    fn begin(&self, site: &PixelSite) -> Sums {
        Sums {
            depth_range: site.depth_range,
            rgb_weighted: Vec3::ZERO,
            alpha_weighted: 0.0,
            transmittance: 1.0,
            count: 0,
        }
    }

    fn add(
        &self,
        pixel: &mut Sums,
        _: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        let alpha = fragment.alpha;
        let weight = alpha * alpha * self.weight.of_depth(fragment.depth(), pixel.depth_range);
        pixel.rgb_weighted += weight * shade();
        pixel.alpha_weighted += weight;
        pixel.transmittance *= 1.0 - alpha;
        pixel.count += 1;
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Sums, _: usize) -> f32 {
        pixel.transmittance
    }

    fn resolve(&self, pixel: &Sums) -> Vec3 {
        if pixel.count == 0 {
            return Vec3::ZERO;
        }
        pixel.rgb_weighted * ((1.0 - pixel.transmittance) / pixel.alpha_weighted)
    }

    /// There is one place for all.
    fn merged_count(&self, pixel: &Sums) -> u32 {
        pixel.count.saturating_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Weight; 4] = [Weight::Eq7, Weight::Eq8, Weight::Eq9, Weight::Eq10];

    #[test]
    fn the_weights_are_those_of_the_paper() {
        // Eq. 7: 10 / (1e-5 + 4 + 1.5625e-8) at 10 m.
        let expected = [10.0 / 4.000_01, 10.0 / 1.000_01, 0.03 / 1.625e-5];
        for (weight, expected) in ALL.into_iter().zip(expected) {
            let found = weight.of_depth(10.0, [1.0, 100.0]);
            assert!((found / expected - 1.0).abs() < 1e-5, "{weight:?}: {found}, not {expected}");
        }
        // Halfway between near and far in the buffer: 3e3 / 8.
        let middle = 2.0 / (1.0 / 1.0 + 1.0 / 100.0);
        assert!((Weight::Eq10.of_depth(middle, [1.0, 100.0]) - 375.0).abs() < 0.01);
    }

    #[test]
    fn weights_fall_with_depth_and_stay_in_their_range() {
        for weight in ALL {
            let of = |depth| weight.of_depth(depth, [0.5, 500.0]);
            let depths = (0..=60).map(|step| 0.01 * 10_f32.powf(0.1 * step as f32));
            let weights: Vec<f32> = depths.map(of).collect();
            assert!(weights.windows(2).all(|pair| pair[1] <= pair[0]), "{weight:?}: {weights:?}");
            assert!(weights.iter().all(|weight| (WEIGHTS[0]..=WEIGHTS[1]).contains(weight)), "{weight:?}");
            assert!(of(1.0) > 1.5 * of(100.0), "{weight:?}: the check is blind");
        }
    }

    #[test]
    fn a_frame_of_one_depth_has_a_weight() {
        for weight in ALL {
            assert!(weight.of_depth(3.0, [3.0, 3.0]).is_finite());
        }
    }
}
