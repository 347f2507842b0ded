//! Moment-based transparency: a first pass adds up moments of the absorbance over depth, a second one adds up
//! all colours by the transmittance that they imply (Münstermann, Krumpen, Klein and Peters 2018, with power
//! moments).
//!
//! Absorbance, -ln(1 - alpha), adds up where transmittance multiplies, so that blending units can do it in
//! any order. The moments leave open where in depth it lies; the paper takes the point between the least and
//! the largest answer that `overestimation` names.
//!
//! Moments are summed in 32 bits, as on a GPU. The algebra that follows is in 64, so that an error is that of
//! the method, and the biased matrix is factorised once a pixel, where a shader does it for each fragment.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    bibliography, choice,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use self::hamburger::Problem;
use crate::contract::{
    Binding, Blend, Fragment, Memory, MethodInfo, NoRaster, Passes, PixelSite, Raster, Resource, Retrace,
    ShaderConstant, ShaderValue, Step, StepKind, TargetFormat, UnorderedCompositing, Visitor,
};

mod hamburger;

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "moments",
    title: "visibility from 4, 6 or 8 moments of absorbance over depth: two additive passes",
    paper: "Münstermann, Krumpen, Klein, Peters 2018, Moment-Based Order-Independent Transparency",
    works: &[&bibliography::MUENSTERMANN_2018],
    bias: "visibility is smoothed over depth, so that colours of several layers mix; the background is exact",
    parameters: &[
        Order::parameter("order", Order::Four, "power moments"),
        ParameterInfo {
            key: "overestimation",
            // The paper's, section 3.
            default: "0.25",
            range: ParameterRange::Real(0.0, 1.0),
            what: "share of the absorbance at a fragment's own depth that counts as in front of it: more hides more of what is behind",
        },
        Retrace::PARAMETER,
    ],
    alignment_px: 1,
    constants: &[],
    tables: &[],
};

choice! {
    /// How many power moments there are, beside the absorbance itself.
    enum Order {
        /// First to fourth moment.
        Four = "4",
        /// First to sixth moment.
        Six = "6",
        /// First to eighth moment.
        Eight = "8",
    }
}

impl Order {
    /// The number of moments, the absorbance not counted.
    fn count(self) -> usize {
        match self {
            Self::Four => 4,
            Self::Six => 6,
            Self::Eight => 8,
        }
    }

    /// How far 32-bit moments are moved, and the even moments (the odd ones are 0) that they are moved to:
    /// both as the paper's supplement gives them.
    fn published_bias(self) -> (f64, &'static [f64]) {
        match self {
            Self::Four => (5e-7, &[0.375, 0.375]),
            Self::Six => (5e-6, &[0.48, 0.451, 0.45]),
            Self::Eight => (5e-5, &[0.75, 0.676_666_666_666_666_7, 0.63, 0.600_303_030_303_030_3]),
        }
    }
}

/// Moment-based transparency of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moments {
    order: Order,
    overestimation: f64,
    retrace: Retrace,
}

/// Sums over the fragments of a pixel.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    /// Logarithms of the least and the largest depth.
    ln_depth_range: [f32; 2],
    /// The zeroth moment: the sum of absorbances.
    absorbance: f32,
    /// The first one and so on, each times the absorbance.
    moments: [f32; hamburger::MOST_MOMENTS],
    count: u32,
    problem: Problem,
    rgb_weighted: Vec3,
    alpha_weighted: f32,
}

impl Moments {
    pub(super) fn new(values: &Values) -> Self {
        let overestimation = values.real("overestimation").into();
        Self { order: values.choice("order"), overestimation, retrace: values.choice(Retrace::PARAMETER.key) }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.unordered(self)
    }

    /// The moments a unit of absorbance, moved towards those of a distribution that is well inside the valid
    /// ones, so that rounding takes none outside.
    fn biased(&self, pixel: &Sums) -> [f64; hamburger::MOST_MOMENTS] {
        let (bias, towards) = self.order.published_bias();
        std::array::from_fn(|index| {
            let moment = f64::from(pixel.moments[index]) / f64::from(pixel.absorbance);
            let even = if index % 2 == 1 { towards.get(index / 2).copied().unwrap_or(0.0) } else { 0.0 };
            moment + bias * (even - moment)
        })
    }
}

impl Sums {
    /// The logarithm of depth from -1 at the nearest to 1 at the furthest: layers are told apart by the ratio
    /// of their depths.
    fn warped(&self, depth: f32) -> f32 {
        let [near, far] = self.ln_depth_range;
        let share = (depth.ln() - near) / (far - near).max(f32::EPSILON);
        (2.0 * share - 1.0).clamp(-1.0, 1.0)
    }
}

impl UnorderedCompositing for Moments {
    type Pixel = Sums;

    fn retrace(&self) -> Retrace {
        self.retrace
    }

    fn pass_count(&self) -> usize {
        2
    }

    fn pass_name(&self, pass: usize) -> &'static str {
        ["moments", "blend"][pass]
    }

    fn memory(&self) -> Memory {
        // The absorbance and its moments in 32 bits; then sums of colour and alpha in 16.
        Memory::Bounded(4 + 4 * self.order.count() as u32 + 8)
    }

    fn raster(&self) -> Result<Raster, NoRaster> {
        const ABSORBANCES: Binding = Binding::new("BIND_ABSORBANCES", 1);
        const MOMENTS: Binding = Binding::new("BIND_MOMENTS", 2);
        const FURTHER_MOMENTS: Binding = Binding::new("BIND_FURTHER_MOMENTS", 3);
        const BLENDED_SUMS: Binding = Binding::new("BIND_BLENDED_SUMS", 4);
        let (bias, towards) = self.order.published_bias();
        let mut four = [0.0; 4];
        four.iter_mut().zip(towards).for_each(|(four, towards)| *four = *towards as f32);
        let constants = vec![
            ShaderConstant::real("MOMENT_BIAS", bias as f32),
            ShaderConstant { name: "MOMENT_TOWARDS", value: ShaderValue::Vec4F(four) },
        ];
        // Sums of colours in the 16 bits of the paper; absorbance and moments in 32.
        let mut resources = vec![
            Resource::sums("blended sums", TargetFormat::Rgba16Float),
            Resource::sums("absorbance", TargetFormat::R32Float),
            Resource::sums("moments 1 to 4", TargetFormat::Rgba32Float),
        ];
        match self.order {
            Order::Four => {}
            Order::Six => resources.push(Resource::sums("moments 5 and 6", TargetFormat::Rg32Float)),
            Order::Eight => resources.push(Resource::sums("moments 5 to 8", TargetFormat::Rgba32Float)),
        }
        // At order 4 the first four stand in for the further ones, which nothing looks at.
        let sums = vec![(ABSORBANCES, 1), (MOMENTS, 2), (FURTHER_MOMENTS, resources.len() - 1)];
        let targets = (1..resources.len()).map(|index| (index, Some(Blend::Add))).collect();
        let draw = |name, entry_point, targets, bound| Step {
            name,
            entry_point,
            kind: StepKind::Draw { targets, depth: None },
            bound,
        };
        let steps = vec![
            draw("moments", "fs_moments", targets, Vec::new()),
            draw("blend", "fs_blend", vec![(0, Some(Blend::Add))], sums),
            Step::last(vec![(ABSORBANCES, 1), (BLENDED_SUMS, 0)]),
        ];
        Ok(Raster::Passes(Passes { resources, steps, constants }))
    }

    fn begin(&self, site: &PixelSite) -> Sums {
        Sums {
            ln_depth_range: site.depth_range.map(f32::ln),
            absorbance: 0.0,
            moments: [0.0; hamburger::MOST_MOMENTS],
            count: 0,
            problem: Problem::EMPTY,
            rgb_weighted: Vec3::ZERO,
            alpha_weighted: 0.0,
        }
    }

    fn begin_pass(&self, pixel: &mut Sums, pass: usize) -> ControlFlow<()> {
        if pass == 1 {
            if pixel.count == 0 {
                return ControlFlow::Break(());
            }
            pixel.problem = Problem::new(&self.biased(pixel)[..self.order.count()]);
        }
        ControlFlow::Continue(())
    }

    fn add(
        &self,
        pixel: &mut Sums,
        pass: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        let depth = pixel.warped(fragment.depth());
        if pass == 0 {
            let absorbance = -(-fragment.alpha).ln_1p();
            pixel.absorbance += absorbance;
            let mut power = absorbance;
            for moment in &mut pixel.moments[..self.order.count()] {
                power *= depth;
                *moment += power;
            }
            pixel.count += 1;
        } else {
            let share = pixel.problem.share_in_front(depth.into(), self.overestimation);
            let weight = fragment.alpha * (-pixel.absorbance * share as f32).exp();
            pixel.rgb_weighted += weight * shade();
            pixel.alpha_weighted += weight;
        }
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Sums, _: usize) -> f32 {
        (-pixel.absorbance).exp()
    }

    fn resolve(&self, pixel: &Sums) -> Vec3 {
        if pixel.count == 0 {
            return Vec3::ZERO;
        }
        // Scaled so that what is seen of all fragments and of the background adds up to one.
        pixel.rgb_weighted * (-(-pixel.absorbance).exp_m1() / pixel.alpha_weighted)
    }

    /// All fragments but one are merged: there is one sum for all.
    fn merged_count(&self, pixel: &Sums) -> u32 {
        pixel.count.saturating_sub(1)
    }
}
