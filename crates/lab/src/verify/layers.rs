//! Constant layers: what is seen through them in closed form.

use sheer_metrics::statistics::z_score;
use sheer_render::{Antialiasing, Settings};

use super::picture::{mean_colour, render};
use crate::{
    Result,
    verify::check::{Check, Value},
};

const SIZE: [u32; 2] = [32, 32];
const FRAMES: u32 = 64;
/// Rounding of 32-bit floats, added up over a few layers and thousands of pixels.
const ROUNDING: f64 = 1e-5;

pub(super) fn checks(threads: Option<usize>) -> Result<Vec<Check>> {
    let mut checks = vec![
        example(
            "Example 1",
            "count=2,alpha=0.45,colours=red-green,background=1",
            [0.45, 0.2475, 0.3025],
            threads,
        )?,
        example(
            "Example 2",
            "count=4,alpha=0.25,colours=white,background=0.25",
            [1.0 - 0.75 * 0.75_f64.powi(4); 3],
            threads,
        )?,
    ];
    let stacks = [1, 2, 4, 8].into_iter().flat_map(|count| [0.1, 0.25, 0.5].map(|alpha| (count, alpha)));
    for ((count, alpha), seed) in stacks.zip(0..) {
        checks.push(transmittance(count, alpha, seed, threads)?);
    }
    Ok(checks)
}

/// The exact colours of the examples.
fn example(name: &str, parameters: &str, expected: [f64; 3], threads: Option<usize>) -> Result<Check> {
    let settings = Settings { size: [4, 4], ..Settings::default() };
    let planes =
        render(&format!("layers:{parameters}"), "baseline", Antialiasing::NONE, settings, 1, threads)?;
    let measured = mean_colour(&planes);
    let error = measured.iter().zip(expected).map(|(measured, expected)| (measured - expected).abs());
    Ok(Check {
        name: format!("baseline: {name}"),
        source: "ST section 3.1".to_owned(),
        closed_form: Some(Value::Colour(expected)),
        paper: None,
        measured: Some(Value::Colour(measured)),
        samples: None,
        z: None,
        pass: error.fold(0.0, f64::max) <= ROUNDING,
    })
}

/// Red and green layers before blue: what arrives of the blue is their transmittance.
///
/// Stacks that share a seed would share the random numbers of their front layers.
fn transmittance(count: u32, alpha: f64, seed: u32, threads: Option<usize>) -> Result<Check> {
    let scene = format!("layers:count={count},alpha={alpha},colours=red-green,background=1");
    let settings = Settings { size: SIZE, seed, ..Settings::default() };
    let planes = render(&scene, "roulette", Antialiasing::ACCUMULATE, settings, FRAMES, threads)?;
    let [_, _, measured] = mean_colour(&planes);
    // The scene holds a 32-bit alpha.
    let expected = (1.0 - f64::from(alpha as f32)).powi(count as i32);
    let samples = u64::from(SIZE[0] * SIZE[1] * FRAMES);
    Ok(Check {
        name: format!("roulette: transmittance of {count}×{alpha}"),
        source: "STD section 3.2".to_owned(),
        closed_form: Some(Value::Number(expected)),
        paper: None,
        measured: Some(Value::Number(measured)),
        samples: Some(samples),
        z: Some(binomial_z(expected, measured, samples)),
        pass: false,
    })
}

/// Each sample sees the background with the expected probability, or does not.
fn binomial_z(expected: f64, measured: f64, samples: u64) -> f64 {
    z_score(measured - expected, (expected * (1.0 - expected) / samples as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transmittance_that_is_one_percent_off_is_noticed() {
        let check = transmittance(2, 0.25, 0, None).unwrap();
        let Some(Value::Number(measured)) = check.measured else { panic!("no number") };
        let samples = check.samples.unwrap();
        assert!(check.z.unwrap().abs() < 4.0);
        assert!(binomial_z(0.99 * 0.5625, measured, samples * 16).abs() > 4.0);
    }
}
