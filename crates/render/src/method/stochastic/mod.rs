//! Stochastic transparency (ST): each fragment covers a random subset of a pixel's samples.
//!
//! Enderton, Sintorn, Shirley and Luebke, *Stochastic Transparency*, IEEE TVCG 17 (8), 2011: sampling
//! (section 3.1), alpha correction (3.3), the depth-based estimator (3.4), spatial anti-aliasing with its
//! compositing (3.5), seeds, adaptive passes and post filter (6).

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    bibliography, choice,
    colour::luminance,
    mask::MOST_SAMPLES,
    parameter::{ParameterInfo, ParameterRange, Switch, Values},
};

use self::{
    masks::Masks,
    pixel::{Pixel, Sums, covered},
};
use crate::contract::{
    Fragment, LayerFilter, Memory, MethodInfo, Multisample, NoRaster, PixelSite, Placement, Raster, Retrace,
    SampleContent, Samples, UnorderedCompositing, Visitor,
};

mod masks;
mod pixel;

choice! {
    /// Where the samples lie: [`Placement`] by its words.
    enum PlacementChoice {
        /// [`Placement::Centre`].
        Centre = "centre",
        /// [`Placement::Box`].
        Box = "box",
        /// [`Placement::Gaussian`].
        Gaussian = "gaussian",
    }
}

choice! {
    /// What the colour of the transparent layer is made from.
    enum Estimator {
        /// A fragment counts by the samples that do not hide it (ST section 3.4).
        Depth = "depth",
        /// A sample has the colour of its nearest fragment (ST section 3.1).
        Basic = "basic",
    }
}

choice! {
    /// What is laid over the transparent layer.
    enum FilterChoice {
        /// Noise stays as it is.
        None = "none",
        /// A cross-bilateral filter (ST section 6).
        Bilateral = "bilateral",
    }
}

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "stochastic",
    title: "each fragment covers a random subset of the pixel's samples; a z-buffer a sample does the rest",
    paper: "Enderton, Sintorn, Shirley, Luebke (ST)",
    works: &[&bibliography::ST],
    bias: "none with correct=off; with correct=on less noise, and a bias that falls with the samples \
           (estimator=depth); adaptive and filter add theirs",
    parameters: &[
        ParameterInfo {
            key: "samples",
            default: "8",
            range: ParameterRange::Count(1, MOST_SAMPLES),
            what: "samples a pixel in each pass; usual are 4, 8, 16, 64; for more than 64 take passes",
        },
        ParameterInfo {
            key: "passes",
            default: "1",
            range: ParameterRange::Count(1, MOST_SAMPLES),
            what: "stochastic passes, each with samples of its own, averaged before the one division (ST section 3.5)",
        },
        PlacementChoice::parameter(
            "placement",
            PlacementChoice::Centre,
            "samples all in the pixel centre; or spread over the pixel, or by a small Gaussian: spatial anti-aliasing",
        ),
        masks::Kind::parameter(
            "masks",
            masks::Kind::Stratified,
            "R = ⌊αS + ξ⌋ random samples; a coin a sample; stratified over neighbours and layers, too (Laine and Karras 2011); \
             always the first R, as alpha-to-coverage has it, so that layers hide one another",
        ),
        Estimator::parameter(
            "estimator",
            Estimator::Depth,
            "every fragment weighted by its visibility in a stochastic depth map (ST section 3.4); or winners only (3.1)",
        ),
        Switch::parameter(
            "correct",
            Switch::On,
            "alpha correction by the exact total alpha (ST section 3.3)",
        ),
        masks::SeedBy::parameter(
            "seed-by",
            masks::SeedBy::Primitive,
            "whose mask is one and the same (ST section 6); front and back faces differ in any case",
        ),
        Switch::parameter(
            "reseed",
            Switch::On,
            "new masks each frame, for accumulation over time; or noise that stands still, as the paper's",
        ),
        masks::Dither::parameter(
            "dither",
            masks::Dither::Off,
            "ξ drawn at random; or dithered over a tile of pixels by blue noise (ST section 3.1)",
        ),
        ParameterInfo {
            key: "adaptive",
            default: "0",
            range: ParameterRange::Real(0.0, 1.0),
            what: "passes end in a pixel whose brightness has a smaller standard error (ST section 6); 0: never",
        },
        FilterChoice::parameter(
            "filter",
            FilterChoice::None,
            "blur of the transparent layer across pixels of similar total alpha (ST section 6)",
        ),
        Retrace::PARAMETER,
    ],
    alignment_px: 1,
    constants: &[],
    tables: &[],
};

/// Rounds before adaptive passes may end: fewer agree by chance too often, and such a pixel would keep its
/// error.
const LEAST_ROUNDS: u32 = 4;
/// ST section 6 leaves the filter's size open. Noise is independent from pixel to pixel, so a few neighbours
/// do; total alpha has no noise, so steps as small as this are edges.
const FILTER: LayerFilter = LayerFilter { radius_px: 2, sigma_px: 1.0, sigma_alpha: 0.05 };

/// Stochastic transparency with one of its estimators over a number of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stochastic {
    samples: Samples,
    passes: u32,
    masks: Masks,
    estimator: Estimator,
    is_corrected: bool,
    retrace: Retrace,
    /// Standard error below which passes end.
    adaptive: f32,
    filter: Option<LayerFilter>,
}

/// What a pass over all fragments is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// Transmittance of each sample, exactly.
    TotalAlpha,
    /// Stochastic masks and a z-buffer of colours.
    Colour { round: u32 },
    /// Stochastic masks and a z-buffer alone.
    Depth { round: u32 },
    /// Colours weighted by visibility.
    Accumulate,
}

impl Stochastic {
    pub(super) fn new(values: &Values) -> Self {
        let placement = match values.choice("placement") {
            PlacementChoice::Centre => Placement::Centre,
            PlacementChoice::Box => Placement::Box,
            PlacementChoice::Gaussian => Placement::Gaussian,
        };
        let filter = match values.choice("filter") {
            FilterChoice::None => None,
            FilterChoice::Bilateral => Some(FILTER),
        };
        Self {
            samples: Samples { count: values.count("samples"), placement },
            passes: values.count("passes"),
            masks: Masks::new(values),
            estimator: values.choice("estimator"),
            is_corrected: values.choice::<Switch>("correct") == Switch::On,
            retrace: values.choice(Retrace::PARAMETER.key),
            adaptive: values.real("adaptive"),
            filter,
        }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.unordered(self)
    }

    fn step(&self, pass: usize) -> Step {
        let pass = pass as u32;
        match (self.is_corrected, self.estimator) {
            (true, _) if pass == 0 => Step::TotalAlpha,
            (corrected, Estimator::Basic) => Step::Colour { round: pass - u32::from(corrected) },
            (corrected, Estimator::Depth) => match pass - u32::from(corrected) {
                pass if pass.is_multiple_of(2) => Step::Depth { round: pass / 2 },
                _ => Step::Accumulate,
            },
        }
    }

    /// The samples that a fragment wins, for all steps with masks. `seen` are those that hide it by nothing
    /// yet.
    fn winning(&self, pixel: &Pixel, round: u32, fragment: &Fragment<'_>) -> u64 {
        let seen = pixel.seen(fragment);
        // Samples that it does not cover count as seen: so that triangles which share the samples of a pixel
        // share the strata, too.
        let unhidden = seen | !fragment.coverage;
        seen & self.masks.mask(&pixel.site, fragment, round, unhidden)
    }

    /// Colour of the transparent layer, premultiplied, from sums over samples and rounds: A, B, D or U of ST
    /// section 4.
    fn estimate(&self, pixel: &Pixel, sums: Sums, rounds: u32) -> Vec3 {
        if !self.is_corrected {
            return sums.rgb / (rounds * self.samples.count).max(1) as f32;
        }
        // Filtered first, then divided (ST section 4.2); a pixel without any winner stays empty (4.1).
        if sums.ones > 0.0 {
            pixel.total_alpha(self.samples.count) / sums.ones * sums.rgb
        } else {
            Vec3::ZERO
        }
    }

    /// The sums of the round that is under way.
    fn round_sums(&self, pixel: &Pixel) -> Sums {
        match self.estimator {
            Estimator::Basic => pixel.winners(self.samples.count),
            Estimator::Depth => pixel.accumulated,
        }
    }
}

impl UnorderedCompositing for Stochastic {
    type Pixel = Pixel;

    fn retrace(&self) -> Retrace {
        self.retrace
    }

    fn samples(&self) -> Samples {
        self.samples
    }

    fn pass_count(&self) -> usize {
        let passes_a_round = match self.estimator {
            Estimator::Basic => 1,
            Estimator::Depth => 2,
        };
        usize::from(self.is_corrected) + passes_a_round * self.passes as usize
    }

    fn pass_name(&self, pass: usize) -> &'static str {
        match self.step(pass) {
            Step::TotalAlpha => "total alpha",
            Step::Colour { .. } => "stochastic colour",
            Step::Depth { .. } => "stochastic depth",
            Step::Accumulate => "accumulate",
        }
    }

    fn is_order_independent(&self) -> bool {
        !self.masks.depend_on_order()
    }

    fn is_random(&self) -> bool {
        true
    }

    fn memory(&self) -> Memory {
        // A sample: depth in 4 bytes, colour and alpha in four 16-bit floats, exact total alpha in one.
        Memory::Bounded(self.samples.count * (4 + 8 + if self.is_corrected { 2 } else { 0 }))
    }

    fn layer_filter(&self) -> Option<LayerFilter> {
        self.filter
    }

    fn raster(&self) -> Result<Raster, NoRaster> {
        let no = |what: &str, instead| Err(NoRaster { what: what.to_owned(), instead: Some(instead) });
        if self.masks.depend_on_order() {
            return no("masks=laine-karras needs the order of drawing", "take masks=stratified");
        }
        if self.samples.placement == Placement::Gaussian {
            return no(
                "placement=gaussian leaves the pixel, the hardware's samples do not",
                "take placement=box",
            );
        }
        if self.filter.is_some() {
            return no("filter=bilateral is not drawn by raster", "take filter=none");
        }
        if self.adaptive > 0.0 {
            return no("as many rounds are drawn in all pixels", "take adaptive=0");
        }
        Ok(Raster::Multisample(Multisample {
            samples: self.samples.count,
            passes: self.passes,
            keeps: match self.estimator {
                Estimator::Basic => SampleContent::Colour,
                Estimator::Depth => SampleContent::Depth,
            },
            is_corrected: self.is_corrected,
        }))
    }

    fn begin(&self, site: &PixelSite) -> Pixel {
        Pixel::new(site)
    }

    fn begin_pass(&self, pixel: &mut Pixel, pass: usize) -> ControlFlow<()> {
        let (Step::Colour { round } | Step::Depth { round }) = self.step(pass) else {
            return ControlFlow::Continue(());
        };
        if round > 0 {
            let sums = self.round_sums(pixel);
            if self.adaptive > 0.0 {
                pixel.brightness.add(luminance(self.estimate(pixel, sums, 1)));
            }
            pixel.end_round(sums, self.samples.count);
            if round >= LEAST_ROUNDS && pixel.brightness.standard_error() < self.adaptive {
                return ControlFlow::Break(());
            }
        }
        pixel.begin_round();
        ControlFlow::Continue(())
    }

    fn add(
        &self,
        pixel: &mut Pixel,
        pass: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        match self.step(pass) {
            Step::TotalAlpha => pixel.dim(fragment),
            Step::Depth { round } => {
                let won = self.winning(pixel, round, fragment);
                pixel.write_depth(fragment, won);
            }
            Step::Colour { round } => {
                let won = self.winning(pixel, round, fragment);
                if won != 0 {
                    pixel.write_depth(fragment, won);
                    let rgb = shade();
                    covered(won).for_each(|sample| pixel.shown[sample] = rgb);
                }
            }
            Step::Accumulate => {
                // visibility · α · colour (ST Eq. 6), the visibility by counting samples (Eq. 4).
                let weight = fragment.alpha * pixel.unhidden_count(fragment) as f32;
                if weight > 0.0 {
                    let Sums { rgb, ones } = pixel.accumulated;
                    pixel.accumulated = Sums { rgb: rgb + weight * shade(), ones: ones + weight };
                }
            }
        }
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Pixel, sample: usize) -> f32 {
        if self.is_corrected { pixel.transmittance[sample] } else { pixel.empty_share(sample) }
    }

    fn resolve(&self, pixel: &Pixel) -> Vec3 {
        // Passes that have ended early have handed over their last round already.
        let last = if pixel.is_in_round { self.round_sums(pixel) } else { Sums::default() };
        self.estimate(pixel, pixel.sums + last, pixel.rounds())
    }
}
