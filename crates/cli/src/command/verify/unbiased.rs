//! Methods without bias: their mean over many frames is the exact picture.
//!
//! Both are rendered with the same sample positions, so that only the dithering differs. The picture is cut into blocks; each gives a
//! standard normal number, and the sum of their squares a chi-square one. Blocks, not pixels: what is rarely drawn in a pixel is far from
//! normal in it.

use sheer_core::colour::luminance;
use sheer_image::{Image, Planes};
use sheer_metrics::statistics::{Moments, z_score};
use sheer_render::{Antialiasing, Settings, Stage};

use super::picture::{play, stage, stage_of_files};
use crate::report::json::{Check, Value};

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
        (
            $name,
            include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/gltf/", $folder, "/", $name)),
        )
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

pub(super) fn checks(threads: Option<usize>) -> anyhow::Result<Vec<Check>> {
    let built_in = SCENES.iter().map(|(name, scene)| (*name, stage(scene, threads)));
    let files = FILES.iter().map(|(name, files)| (*name, stage_of_files(files, FILE_ALPHA, threads)));
    let mut checks = Vec::new();
    for (name, stage) in built_in.chain(files) {
        let mut stage = stage?;
        let exact = accumulate(&mut stage, "baseline", 0)?;
        checks.extend(Difference::measure(&mut stage, "roulette", &exact)?.checks(name));
    }
    Ok(checks)
}

fn accumulate(stage: &mut Stage, method: &str, seed: u32) -> anyhow::Result<Image<f64>> {
    let settings = Settings { size: SIZE, seed, ..Settings::default() };
    let brightness =
        |planes: &Planes| planes.colour.map(|&[r, g, b, _]| f64::from(luminance([r, g, b].into())));
    Ok(brightness(&play(stage, method, Antialiasing::Accumulate, settings, FRAMES)?))
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
}

impl Difference {
    fn measure(stage: &mut Stage, method: &str, exact: &Image<f64>) -> anyhow::Result<Self> {
        let mut pixels = exact.map(|_| Moments::default());
        for seed in 0..SEEDS {
            let picture = accumulate(stage, method, seed)?;
            for (moments, value) in pixels.as_mut_slice().iter_mut().zip(picture.as_slice()) {
                moments.add(*value);
            }
        }
        Ok(Self::from_moments(&pixels, exact))
    }

    fn from_moments(pixels: &Image<Moments>, exact: &Image<f64>) -> Self {
        let mut whole = Sum::default();
        let mut block_z = Vec::new();
        for top in (0..SIZE[1]).step_by(BLOCK_PX[1] as usize) {
            for left in (0..SIZE[0]).step_by(BLOCK_PX[0] as usize) {
                let mut block = Sum::default();
                for y in top..top + BLOCK_PX[1] {
                    for x in left..left + BLOCK_PX[0] {
                        block.add(pixels[(x, y)], exact[(x, y)]);
                        whole.add(pixels[(x, y)], exact[(x, y)]);
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
        }
    }

    fn checks(&self, scene: &str) -> [Check; 2] {
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
        [mean, blocks]
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
    fn add(&mut self, pixel: Moments, exact: f64) {
        self.exact += exact;
        self.measured += pixel.mean();
        self.variance += pixel.variance_of_mean();
    }

    fn z(&self) -> f64 {
        let rounding = ROUNDING * self.exact.abs();
        z_score(self.measured - self.exact, self.variance.sqrt().hypot(rounding))
    }
}

/// The standard normal number that is as rare as a chi-square one (Wilson and Hilferty 1931).
fn wilson_hilferty(chi_square: f64, degrees: f64) -> f64 {
    let spread = 2.0 / (9.0 * degrees);
    ((chi_square / degrees).cbrt() - (1.0 - spread)) / spread.sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::judge;
    use super::*;

    fn judged(method: &str, scene: &str, exact_scene: &str) -> Vec<bool> {
        let exact = accumulate(&mut stage(exact_scene, None).unwrap(), "baseline", 0).unwrap();
        let difference = Difference::measure(&mut stage(scene, None).unwrap(), method, &exact).unwrap();
        let mut checks = difference.checks("a scene");
        judge(&mut checks);
        checks.iter().map(|check| check.pass).collect()
    }

    const SCENE: &str = "layers:count=8,alpha=0.2,background=0.3";

    #[test]
    fn an_unbiased_method_passes() {
        assert_eq!(judged("roulette", SCENE, SCENE), [true, true]);
    }

    #[test]
    fn a_method_that_takes_alpha_for_two_percent_more_is_found() {
        assert_eq!(judged("roulette", "layers:count=8,alpha=0.204,background=0.3", SCENE), [false, false]);
    }

    #[test]
    fn the_known_bias_of_plain_std_is_found() {
        assert!(judged("std", SCENE, SCENE).contains(&false));
    }

    #[test]
    fn the_normal_number_of_a_chi_square_one_has_its_probability() {
        use sheer_metrics::statistics::{chi_square_p, two_sided_p};
        for chi_square in [14.0, 21.0, 30.0] {
            let z = wilson_hilferty(chi_square, 12.0);
            assert!((two_sided_p(z) / 2.0 / chi_square_p(chi_square, 12) - 1.0).abs() < 0.05);
        }
    }
}
