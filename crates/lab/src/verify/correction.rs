//! STD Eq. 5: the coverage that DLSS shows as an opacity, as a function and as what is rendered.

use sheer_core::coverage::Correction;
use sheer_metrics::statistics::z_score;
use sheer_render::{Antialiasing, Settings};

use super::picture::{mean_colour, render};
use crate::{
    Result,
    verify::check::{Check, Value},
};

const SECTION: &str = "STD Eq. 5";
/// What three products and sums of 32-bit numbers up to 2 may be off by.
const ROUNDING: f64 = 1e-6;
const SIZE: [u32; 2] = [64, 64];
const FRAMES: u32 = 64;
const ALPHAS: [f64; 3] = [0.05, 0.3, 0.8];

pub(super) fn checks(threads: Option<usize>) -> Result<Vec<Check>> {
    let mut checks: Vec<Check> = ALPHAS.into_iter().map(|alpha| value(Correction::DLSS, alpha)).collect();
    for (alpha, seed) in ALPHAS.into_iter().zip(0..) {
        checks.push(rendered("roulette:correction=dlss", alpha, seed, threads)?);
    }
    Ok(checks)
}

/// The cubic as the paper prints it, clamped.
fn equation_5(alpha: f64) -> f64 {
    (0.0113 + 1.656 * alpha - 0.821 * alpha.powi(2) + 0.156 * alpha.powi(3)).clamp(0.0, 1.0)
}

fn value(correction: Correction, alpha: f64) -> Check {
    let (expected, found) = (equation_5(alpha), f64::from(correction.coverage(alpha as f32)));
    Check {
        name: format!("correction=dlss: coverage of alpha {alpha}"),
        source: SECTION.to_owned(),
        closed_form: Some(Value::Number(expected)),
        paper: None,
        measured: Some(Value::Number(found)),
        samples: None,
        z: None,
        pass: (found - expected).abs() <= ROUNDING,
    }
}

/// The share of samples that show a white layer over black.
fn rendered(method: &str, alpha: f64, seed: u32, threads: Option<usize>) -> Result<Check> {
    let settings = Settings { size: SIZE, seed, ..Settings::default() };
    let scene = format!("layers:count=1,alpha={alpha}");
    let planes = render(&scene, method, Antialiasing::ACCUMULATE, settings, FRAMES, threads)?;
    let (expected, [measured, ..]) = (equation_5(alpha), mean_colour(&planes));
    let samples = u64::from(SIZE[0] * SIZE[1] * FRAMES);
    let error = (expected * (1.0 - expected) / samples as f64).sqrt();
    Ok(Check {
        name: format!("roulette:correction=dlss: share of a layer of alpha {alpha} that is shown"),
        source: SECTION.to_owned(),
        closed_form: Some(Value::Number(expected)),
        paper: None,
        measured: Some(Value::Number(measured)),
        samples: Some(samples),
        z: Some(z_score(measured - expected, error)),
        pass: false,
    })
}

#[cfg(test)]
mod tests {
    use super::{super::check::judge, *};

    #[test]
    fn another_curve_and_none_are_found() {
        let other = Correction::new([0.0113, 1.656, -0.821, 0.157]).expect("finite coefficients");
        for alpha in [0.3, 0.8] {
            assert!(value(Correction::DLSS, alpha).pass && !value(other, alpha).pass);
            let verdict = |method| {
                let mut checks = [rendered(method, alpha, 0, None).unwrap()];
                judge(&mut checks);
                checks[0].pass
            };
            assert!(verdict("roulette:correction=dlss") && !verdict("roulette"));
        }
    }
}
