//! Methods without bias: their mean over many frames is the exact picture.
//!
//! Both are rendered with the same sample positions, so that only the dithering differs. Three questions are
//! asked of a picture:
//!
//! * its mean brightness, a standard normal number;
//! * its blocks: each gives a standard normal number, and the sum of their squares a chi-square one;
//! * its pixels, each by itself, the least likely one counting. What is rarely drawn in a pixel is far from
//!   normal in it, so the probability of its deviation is bounded by Bernstein's inequality, from the
//!   variance and the greatest brightness that its fragments exactly have.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::colour::luminance;
use sheer_image::{Image, Planes};
use sheer_metrics::statistics::{Moments, sidak_family, two_sided_z, wilson_hilferty, z_score};
use sheer_render::{
    Antialiasing, Background, Clock, FrameSettings, Settings, Stage,
    contract::{Fragment, Memory, OrderedCompositing, PixelSite, Traversal},
    cpu::{OwnOrdered, render},
    temporal::jitter,
};

use super::picture::{play, stage, stage_of_files};
use crate::{
    Result,
    verify::check::{Check, Value},
};

const SIZE: [u32; 2] = [64, 36];
/// Frames that are added up; as many sample positions.
const FRAMES: u32 = 4;
/// Pictures with different seeds.
const SEEDS: u32 = 32;
/// Width and height of a block; these divide the picture.
const BLOCK_PX: [u32; 2] = [16, 12];
/// Share of the brightness by which sums of 32-bit floats may differ.
const ROUNDING: f64 = 1e-6;

/// Name and file contents.
type File = (&'static str, &'static [u8]);

macro_rules! file {
    ($folder:literal, $name:literal) => {
        ($name, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/", $folder, "/", $name)))
    };
}

/// Colours, textures and shadows; deep and shallow.
const SCENES: [(&str, &str); 2] =
    [("layers", "layers:count=8,alpha=0.2,colours=rainbow,background=0.3"), ("smoke-square", "smoke-square")];
/// Files with closed and crossing surfaces, made transparent.
const FILES: [(&str, [File; 2]); 2] = [
    (
        "SimpleInstancing",
        [
            file!("SimpleInstancing", "SimpleInstancing.gltf"),
            file!("SimpleInstancing", "SimpleInstancing_data.bin"),
        ],
    ),
    (
        "AnimatedMorphCube",
        [
            file!("AnimatedMorphCube-Quantized", "AnimatedMorphCube.gltf"),
            file!("AnimatedMorphCube-Quantized", "AnimatedMorphCube.bin"),
        ],
    ),
];
const FILE_ALPHA: f32 = 0.3;

pub(super) fn checks(threads: Option<usize>) -> Result<Vec<Check>> {
    let built_in = SCENES.iter().map(|(name, scene)| (*name, stage(scene, threads)));
    let files = FILES.iter().map(|(name, files)| (*name, stage_of_files(files, FILE_ALPHA, threads)));
    let mut checks = Vec::new();
    for (name, stage) in built_in.chain(files) {
        let mut stage = stage?;
        let exact = draws(&mut stage)?;
        checks.extend(Difference::measure(&mut stage, "roulette", &exact)?.checks(name));
    }
    Ok(checks)
}

fn settings(seed: u32) -> Settings {
    // Without a background, whose brightness no fragment tells.
    Settings { size: SIZE, seed, background: Background::None, ..Settings::default() }
}

fn accumulate(stage: &mut Stage, method: &str, seed: u32) -> Result<Image<f64>> {
    let brightness =
        |planes: &Planes| planes.colour.map(|&[r, g, b, _]| f64::from(luminance([r, g, b].into())));
    Ok(brightness(&play(stage, method, Antialiasing::ACCUMULATE, settings(seed), FRAMES)?))
}

/// What a pixel's brightness exactly is, over all frames: that of a fragment drawn with the probability that
/// it is seen.
#[derive(Clone, Copy, Debug, Default)]
struct Drawn {
    /// Mean.
    mean: f64,
    /// Variance of the mean of one draw a frame.
    variance: f64,
    /// No draw is further from its mean.
    reach: f64,
}

/// Composites brightness, its square and its maximum in place of red, green and blue.
struct MomentsOfDraws;

/// Visibility, and the three sums.
type SeenSoFar = (f32, Vec3);

impl OrderedCompositing for MomentsOfDraws {
    type Pixel = SeenSoFar;

    fn traversal(&self) -> Traversal {
        Traversal::Sorted
    }

    fn memory(&self) -> Memory {
        Memory::PerFragment(12)
    }

    fn begin(&self, _: &PixelSite) -> SeenSoFar {
        (1.0, Vec3::ZERO)
    }

    fn add(
        &self,
        (visibility, sums): &mut SeenSoFar,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        let brightness = luminance(shade());
        let seen = *visibility * fragment.alpha;
        *sums = Vec3::new(
            sums.x + seen * brightness,
            sums.y + seen * brightness * brightness,
            sums.z.max(brightness),
        );
        *visibility *= 1.0 - fragment.alpha;
        if *visibility > 0.0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn transmittance(&self, _: &SeenSoFar) -> f32 {
        0.0
    }

    fn resolve(&self, (_, sums): &SeenSoFar) -> Vec3 {
        *sums
    }
}

/// What each pixel of the mean of all frames has to be.
fn draws(stage: &mut Stage) -> Result<Image<Drawn>> {
    let settings = settings(0);
    let clock = Clock::new(&settings, Antialiasing::ACCUMULATE);
    let mut drawn = Image::filled(SIZE[0], SIZE[1], Drawn::default())?;
    for frame in 0..FRAMES {
        stage.advance(clock.at(frame));
        let jitter = jitter(Antialiasing::ACCUMULATE, frame);
        let frame_settings = FrameSettings { run: settings, frame, jitter, layers: None, is_still: true };
        let sums = render(stage, &OwnOrdered(MomentsOfDraws), &frame_settings)?.planes.colour;
        let frames = f64::from(FRAMES);
        for (pixel, sums) in drawn.as_mut_slice().iter_mut().zip(sums.as_slice()) {
            let [mean, square, greatest, _] = sums.map(f64::from);
            pixel.mean += mean / frames;
            let variance = square - mean * mean;
            // What is left of a constant after rounding to 32 bits is no chance.
            if variance > ROUNDING * square {
                pixel.variance += variance / (frames * frames);
            }
            pixel.reach = pixel.reach.max(greatest / frames);
        }
    }
    Ok(drawn)
}

/// How far a method's mean is from the exact picture, in brightness.
struct Difference {
    /// Means of the exact picture and of the method's.
    exact: f64,
    measured: f64,
    /// Of the whole picture.
    z: f64,
    /// One a block that has anything random in it.
    block_z: Vec<f64>,
    worst: WorstPixel,
}

/// The pixel whose deviation is the least likely.
#[derive(Clone, Copy, Debug)]
struct WorstPixel {
    exact: f64,
    measured: f64,
    /// Probability of such a deviation in that pixel, at most.
    probability: f64,
}

/// Upper bound of the probability that the mean of `count` draws deviates by so much (Bernstein 1924).
fn bernstein(deviation: f64, drawn: Drawn, count: f64) -> f64 {
    let exponent = 0.5 * count * deviation * deviation / (drawn.variance + drawn.reach * deviation / 3.0);
    if deviation > 0.0 { (2.0 * (-exponent).exp()).min(1.0) } else { 1.0 }
}

impl Difference {
    fn measure(stage: &mut Stage, method: &str, exact: &Image<Drawn>) -> Result<Self> {
        let mut pixels = exact.map(|_| Moments::default());
        for seed in 0..SEEDS {
            let picture = accumulate(stage, method, seed)?;
            for (moments, value) in pixels.as_mut_slice().iter_mut().zip(picture.as_slice()) {
                moments.add(*value);
            }
        }
        Ok(Self::from_moments(&pixels, exact))
    }

    fn from_moments(pixels: &Image<Moments>, exact: &Image<Drawn>) -> Self {
        let mut whole = Sum::default();
        let mut worst = WorstPixel { exact: 0.0, measured: 0.0, probability: 1.0 };
        let mut block_z = Vec::new();
        for top in (0..SIZE[1]).step_by(BLOCK_PX[1] as usize) {
            for left in (0..SIZE[0]).step_by(BLOCK_PX[0] as usize) {
                let mut block = Sum::default();
                for y in top..top + BLOCK_PX[1] {
                    for x in left..left + BLOCK_PX[0] {
                        block.add(pixels[(x, y)], exact[(x, y)]);
                        whole.add(pixels[(x, y)], exact[(x, y)]);
                        let pixel = WorstPixel::new(pixels[(x, y)], exact[(x, y)]);
                        if pixel.probability < worst.probability {
                            worst = pixel;
                        }
                    }
                }
                // Where nothing is random there is nothing to test but equality, and the whole picture does.
                if block.variance > 0.0 {
                    block_z.push(block.z());
                }
            }
        }
        let pixel_count = f64::from(SIZE[0] * SIZE[1]);
        Self {
            exact: whole.exact / pixel_count,
            measured: whole.measured / pixel_count,
            z: whole.z(),
            block_z,
            worst,
        }
    }

    fn checks(&self, scene: &str) -> [Check; 3] {
        let samples = Some(u64::from(SIZE[0] * SIZE[1] * FRAMES * SEEDS));
        let source = "STD section 3.2".to_owned();
        let degrees = self.block_z.len() as f64;
        let chi_square: f64 = self.block_z.iter().map(|z| z * z).sum();
        let mean = Check {
            name: format!("roulette: mean brightness of {scene}"),
            source: source.clone(),
            closed_form: Some(Value::Number(self.exact)),
            paper: None,
            measured: Some(Value::Number(self.measured)),
            samples,
            z: Some(self.z),
            pass: false,
        };
        let blocks = Check {
            name: format!("roulette: chi-square of {scene} in blocks"),
            source,
            closed_form: Some(Value::Number(degrees)),
            paper: None,
            measured: Some(Value::Number(chi_square)),
            samples,
            z: Some(wilson_hilferty(chi_square, degrees)),
            pass: false,
        };
        let pixels = Check {
            name: format!("roulette: least likely pixel of {scene}"),
            source: "STD section 3.2".to_owned(),
            closed_form: Some(Value::Number(self.worst.exact)),
            paper: None,
            measured: Some(Value::Number(self.worst.measured)),
            samples: Some(u64::from(FRAMES * SEEDS)),
            z: Some(two_sided_z(sidak_family(self.worst.probability, u64::from(SIZE[0] * SIZE[1])))),
            pass: false,
        };
        [mean, blocks, pixels]
    }
}

impl WorstPixel {
    fn new(pixel: Moments, exact: Drawn) -> Self {
        let deviation = (pixel.mean() - exact.mean).abs() - ROUNDING * exact.mean;
        let probability = bernstein(deviation, exact, f64::from(SEEDS));
        Self { exact: exact.mean, measured: pixel.mean(), probability }
    }
}

/// Of independent pixels.
#[derive(Default)]
struct Sum {
    exact: f64,
    measured: f64,
    variance: f64,
}

impl Sum {
    fn add(&mut self, pixel: Moments, exact: Drawn) {
        self.exact += exact.mean;
        self.measured += pixel.mean();
        self.variance += exact.variance / f64::from(SEEDS);
    }

    fn z(&self) -> f64 {
        let rounding = ROUNDING * self.exact.abs();
        z_score(self.measured - self.exact, self.variance.sqrt().hypot(rounding))
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::judge;
    use super::*;

    fn judged(method: &str, scene: &str, exact_scene: &str) -> Vec<bool> {
        let exact = draws(&mut stage(exact_scene, None).unwrap()).unwrap();
        let difference = Difference::measure(&mut stage(scene, None).unwrap(), method, &exact).unwrap();
        let mut checks = difference.checks("a scene");
        judge(&mut checks);
        checks.iter().map(|check| check.pass).collect()
    }

    const SCENE: &str = "layers:count=8,alpha=0.2,background=0.3";

    #[test]
    fn an_unbiased_method_passes() {
        assert_eq!(judged("roulette", SCENE, SCENE), [true, true, true]);
    }

    #[test]
    fn a_method_that_takes_alpha_for_two_percent_more_is_found() {
        // No single pixel can tell so little; all together do.
        assert_eq!(
            judged("roulette", "layers:count=8,alpha=0.204,background=0.3", SCENE)[..2],
            [false, false]
        );
    }

    #[test]
    fn pixels_that_are_wrong_by_themselves_are_found() {
        assert!(!judged("roulette", "layers:count=8,alpha=0.05,background=0.3", SCENE)[2]);
        assert!(!judged("std", SCENE, SCENE)[2], "the known bias of plain STD");
    }

    #[test]
    fn the_bound_holds_for_a_coin() {
        // 32 throws of a coin: at least 24 or at most 8 heads have a probability of 0.007.
        let coin = Drawn { mean: 0.5, variance: 0.25, reach: 0.5 };
        let bound = bernstein(0.25, coin, 32.0);
        assert!(bound > 0.007 && bound < 0.1, "{bound}");
    }

    #[test]
    fn the_exact_moments_have_the_baselines_mean() {
        let mut stage = stage(SCENE, None).unwrap();
        let baseline = accumulate(&mut stage, "baseline", 0).unwrap();
        for (exact, drawn) in baseline.as_slice().iter().zip(draws(&mut stage).unwrap().as_slice()) {
            assert!((exact - drawn.mean).abs() < 1e-5, "{exact} {drawn:?}");
        }
    }

    #[test]
    fn the_known_bias_of_plain_std_is_found() {
        assert!(judged("std", SCENE, SCENE).contains(&false));
    }
}
