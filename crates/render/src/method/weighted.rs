//! Weighted blended transparency: the mean of all colours, those nearer to the eye with more weight, over a
//! background that is seen by the exact transmittance (McGuire and Bavoil 2013).
//!
//! The weight functions are curves over the depth in scene units, made for metres and a range of 0.1 to 500.
//! They depend on scale: the same scene in centimetres has nearly all weights at their least and becomes the
//! plain mean; a thumbnail of it has them at their most. Only Eq. 10 goes by where a depth lies within the
//! range of the frame.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{bibliography, choice, parameter::Values};

use crate::contract::{
    Binding, Blend, Fragment, Memory, MethodInfo, NoRaster, Passes, PixelSite, Raster, Resource,
    ShaderConstant, Step, StepKind, TargetFormat, UnorderedCompositing, Visitor,
};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "weighted",
    title: "the mean of all fragments, weighted by alpha and depth: one pass, no order at all",
    paper: "McGuire, Bavoil 2013, Weighted Blended Order-Independent Transparency",
    works: &[&bibliography::MCGUIRE_BAVOIL_2013],
    bias: "colours of several layers are a mean by weights that depend on the scene's scale; the background is exact",
    parameters: &[Weight::parameter(
        "weight",
        Weight::Eq7,
        "the paper's functions of depth; eq7 to eq9 for scenes in metres, eq10 for the depth range of the frame",
    )],
    alignment_px: 1,
    constants: &[],
    tables: &[],
};

/// Weights stay within these (Eq. 7 to 9), so that sums in 16-bit floats neither overflow nor vanish.
const WEIGHTS: [f32; 2] = [1e-2, 3e3];

/// Weighted blended transparency with one of the weight functions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Weighted {
    weight: Weight,
}

choice! {
    /// The equations of the paper for the weight of a depth.
    enum Weight {
        /// Falls with the square of the depth, later with its sixth power.
        Eq7 = "eq7",
        /// Falls with the cube of the depth, later with its sixth power.
        Eq8 = "eq8",
        /// Falls with the fourth power of the depth.
        Eq9 = "eq9",
        /// Falls with the cube of what a depth buffer holds.
        Eq10 = "eq10",
    }
}

/// Sums over the fragments of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    depth_range: [f32; 2],
    rgb_weighted: Vec3,
    alpha_weighted: f32,
    transmittance: f32,
    count: u32,
}

impl Weighted {
    pub(super) fn new(values: &Values) -> Self {
        Self { weight: values.choice("weight") }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.unordered(self)
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

impl UnorderedCompositing for Weighted {
    type Pixel = Sums;

    fn memory(&self) -> Memory {
        // Sums of colour and alpha in 16-bit floats; transmittance in one more.
        Memory::Bounded(10)
    }

    fn raster(&self) -> Result<Raster, NoRaster> {
        const SUMS: Binding = Binding::new("BIND_WEIGHTED_SUMS", 1);
        const TRANSMITTANCE: Binding = Binding::new("BIND_WEIGHTED_TRANSMITTANCE", 2);
        let [least, most] = WEIGHTS;
        let constants =
            vec![ShaderConstant::real("WEIGHT_LEAST", least), ShaderConstant::real("WEIGHT_MOST", most)];
        // Sums in the 16 bits of the paper.
        let resources = vec![
            Resource::sums("weighted sums", TargetFormat::Rgba16Float),
            Resource::products("weighted transmittance", TargetFormat::R16Float),
        ];
        let targets = vec![(0, Some(Blend::Add)), (1, Some(Blend::Multiply))];
        let blend = Step {
            name: "blend",
            entry_point: "fs_blend",
            kind: StepKind::Draw { targets, depth: None },
            bound: Vec::new(),
        };
        let steps = vec![blend, Step::last(vec![(SUMS, 0), (TRANSMITTANCE, 1)])];
        Ok(Raster::Passes(Passes { resources, steps, constants }))
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

    /// All fragments but one are merged: there is one sum for all.
    fn merged_count(&self, pixel: &Sums) -> u32 {
        pixel.count.saturating_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use sheer_core::parameter::Choice as _;

    use super::*;

    #[test]
    fn the_weights_are_those_of_the_paper() {
        // Eq. 7: 10 / (1e-5 + 4 + 1.5625e-8) at 10 m.
        let expected = [10.0 / 4.000_01, 10.0 / 1.000_01, 0.03 / 1.625e-5];
        for (&weight, expected) in Weight::ALL.iter().zip(expected) {
            let found = weight.of_depth(10.0, [1.0, 100.0]);
            assert!((found / expected - 1.0).abs() < 1e-5, "{weight:?}: {found}, not {expected}");
        }
        // Halfway between near and far in the buffer: 3e3 / 8.
        let middle = 2.0 / (1.0 / 1.0 + 1.0 / 100.0);
        assert!((Weight::Eq10.of_depth(middle, [1.0, 100.0]) - 375.0).abs() < 0.01);
    }

    #[test]
    fn weights_fall_with_depth_and_stay_in_their_range() {
        for &weight in Weight::ALL {
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
        for &weight in Weight::ALL {
            assert!(weight.of_depth(3.0, [3.0, 3.0]).is_finite());
        }
    }
}
