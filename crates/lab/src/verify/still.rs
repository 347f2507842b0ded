//! Layered accumulation of a picture in which nothing moves comes to the exact picture, under every method of
//! one shaded fragment.

use sheer_core::colour::luminance;
use sheer_image::Planes;
use sheer_metrics::statistics::Moments;
use sheer_render::{Antialiasing, Method, Settings, Stage, method::METHODS};

use super::{
    check::{Check, Value},
    picture::{play, stage},
};
use crate::Result;

const SCENE: &str = "pane";
const SIZE: [u32; 2] = [16, 9];
/// Each threshold of the STD walk meets each of the 32 sample positions.
const FRAMES: u32 = 288;
/// As many as the layers' sample positions.
const EXACT_FRAMES: u32 = 32;
/// Pictures with different seeds.
const SEEDS: u32 = 4;
/// What the mean brightness may be off by beyond chance: late frames weigh more than early ones, so that
/// offsets and thresholds are not yet met equally often. A quarter of a step of 8 bits.
const UNEVEN: f64 = 1.0 / 1024.0;
const STANDARD_ERRORS: f64 = 5.0;

pub(super) fn checks(threads: Option<usize>) -> Result<Vec<Check>> {
    let mut stage = stage(SCENE, threads)?;
    let exact = brightness(&mut stage, "baseline", Antialiasing::ACCUMULATE, 0, EXACT_FRAMES)?;
    let mut checks = Vec::new();
    for info in METHODS {
        let method: Method = info.id.parse()?;
        if method.family().shades_one_fragment() {
            checks.push(check(&mut stage, info.id, Antialiasing::LAYERED, exact)?);
        }
    }
    Ok(checks)
}

/// Mean over the picture.
fn brightness(
    stage: &mut Stage,
    method: &str,
    antialiasing: Antialiasing,
    seed: u32,
    frames: u32,
) -> Result<f64> {
    let settings = Settings { size: SIZE, seed, ..Settings::default() };
    let planes: Planes = play(stage, method, antialiasing, settings, frames)?;
    let pixels = planes.colour.as_slice();
    let sum: f64 = pixels.iter().map(|&[r, g, b, _]| f64::from(luminance([r, g, b].into()))).sum();
    Ok(sum / pixels.len() as f64)
}

fn check(stage: &mut Stage, method: &str, antialiasing: Antialiasing, exact: f64) -> Result<Check> {
    let mut moments = Moments::default();
    for seed in 0..SEEDS {
        moments.add(brightness(stage, method, antialiasing, seed, FRAMES)?);
    }
    let allowed = UNEVEN + STANDARD_ERRORS * moments.variance_of_mean().sqrt();
    Ok(Check {
        name: format!("{method}: mean brightness of {SCENE} under {antialiasing}, nothing moving"),
        source: "docs/layered.md".to_owned(),
        closed_form: Some(Value::Number(exact)),
        paper: None,
        measured: Some(Value::Number(moments.mean())),
        samples: Some(u64::from(SEEDS)),
        z: None,
        pass: (moments.mean() - exact).abs() <= allowed,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_of_one_fragment_comes_to_the_exact_picture() {
        let checks = checks(None).unwrap();
        assert!(checks.len() >= 7, "{checks:?}");
        let failed: Vec<&Check> = checks.iter().filter(|check| !check.pass).collect();
        assert!(failed.is_empty(), "{failed:?}");
    }

    #[test]
    fn half_a_step_of_eight_bits_is_noticed() {
        let mut stage = stage(SCENE, None).unwrap();
        let exact = brightness(&mut stage, "baseline", Antialiasing::ACCUMULATE, 0, EXACT_FRAMES).unwrap();
        let darker = check(&mut stage, "joint", Antialiasing::LAYERED, exact + 1.0 / 510.0).unwrap();
        assert!(!darker.pass, "{darker:?}");
    }
}
