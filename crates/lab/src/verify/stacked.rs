//! What plain spatio-temporal dithering gets wrong: stacked layers whose maps are not independent hide one
//! another too much or too little, for ever. The error is measured, shown beside that of independent layers,
//! and held against what an independent simulation of the paper's definitions gave.

use sheer_image::Image;
use sheer_metrics::statistics::{Moments, z_score};
use sheer_render::{Antialiasing, Settings, Stage, backend::Cpu};

use super::picture::stage;
use crate::{
    Result, Timeline,
    play::{Event, pipelines, play},
    verify::check::{Check, Value},
};

/// A multiple of the 3×3 maps, so that no cell counts more than another.
const SIZE: [u32; 2] = [30, 30];
const SEEDS: u32 = 24;
/// Of the new frame in the exponential average, as in the paper's temporal anti-aliasing.
const WEIGHT: f32 = 0.1;
/// After these, 0.1 % of the first frame is left.
const FRAMES: u32 = 64;

/// Layers and their alpha; what an independent simulation of the paper's definitions gave for layers of
/// random colours: the error of STD over that of roulette, and the share of it that a 3×3 blur leaves.
const STACKS: [(u32, f64, f64, f64); 3] = [
    (2, 0.45, 0.052 / 0.055, 0.044 / 0.052),
    (8, 0.2, 0.072 / 0.063, 0.046 / 0.072),
    (20, 0.1, 0.121 / 0.065, 0.064 / 0.121),
];
/// Other colours and other maps than the simulation's give other ratios; this far from them, something else
/// is going on.
const LEAST_AGREEMENT: f64 = 0.5;

pub(super) fn checks(threads: Option<usize>) -> Result<Vec<Check>> {
    let mut checks = Vec::new();
    for (count, alpha, expected_ratio, expected_share) in STACKS {
        let scene = format!("layers:count={count},alpha={alpha},colours=red-green,background=1");
        let mut stage = stage(&scene, threads)?;
        let roulette = Error::measure(&mut stage, "roulette")?;
        let std = Error::measure(&mut stage, "std")?;
        let independent = independent_rms(count, alpha);
        let ratio = mean(std.rms()) / mean(roulette.rms());
        let share = mean(std.blurred_rms()) / mean(std.rms());
        let check = |name: &str, closed_form, measured, pass| Check {
            name: format!("{name} {count}×{alpha}"),
            source: "STD section 3.3".to_owned(),
            closed_form,
            paper: None,
            measured: Some(measured),
            samples: Some(std.pixels.count()),
            z: None,
            pass,
        };
        let colour = |rms| Some(Value::Colour(rms));
        let number = |value| Some(Value::Number(value));
        checks.push(Check {
            z: Some(roulette.z(independent)),
            source: "STD section 3.2".to_owned(),
            ..check("roulette: RMS error of", colour(independent), Value::Colour(roulette.rms()), false)
        });
        // What it would be if the layers' maps were independent stands beside what it is.
        let agrees = agree(ratio, expected_ratio);
        checks.push(check("std: RMS error of", colour(independent), Value::Colour(std.rms()), agrees));
        checks.push(check(
            "std: RMS error over roulette's, simulated, of",
            number(expected_ratio),
            Value::Number(ratio),
            agrees,
        ));
        let agrees = agree(share, expected_share);
        checks.push(check(
            "std: error left by a 3×3 blur, simulated, of",
            number(expected_share),
            Value::Number(share),
            agrees,
        ));
    }
    Ok(checks)
}

fn agree(found: f64, expected: f64) -> bool {
    (found / expected).min(expected / found) >= LEAST_AGREEMENT
}

/// RMS error by channel if each frame is drawn independently: a channel is 1 with the probability of its
/// layers, and an average of weight w keeps w / (2 - w) of the variance.
fn independent_rms(count: u32, alpha: f64) -> [f64; 3] {
    let mut probability = [0.0; 3];
    let mut transmittance = 1.0;
    for layer in 0..count {
        probability[layer as usize % 2] += transmittance * alpha;
        transmittance *= 1.0 - alpha;
    }
    probability[2] = transmittance;
    let weight = f64::from(WEIGHT);
    probability.map(|p| (p * (1.0 - p) * weight / (2.0 - weight)).sqrt())
}

fn mean([r, g, b]: [f64; 3]) -> f64 {
    (r + g + b) / 3.0
}

/// Of exponential averages over time, over pixels and seeds.
#[derive(Debug, Default)]
struct Error {
    /// Squared error by channel.
    squares: [Moments; 3],
    /// The same after a blur: noise averages out over a map, bias does not.
    blurred_squares: [Moments; 3],
    /// Squared error of a pixel, mean over channels.
    pixels: Moments,
}

impl Error {
    fn measure(stage: &mut Stage, method: &str) -> Result<Self> {
        let exact = average(stage, "baseline", 0, 1)?;
        let mut error = Self::default();
        for seed in 0..SEEDS {
            let picture = average(stage, method, seed, FRAMES)?;
            let blurred = blur(&picture)?;
            let pixels = exact.as_slice().iter().zip(picture.as_slice()).zip(blurred.as_slice());
            for ((exact, picture), blurred) in pixels {
                let square =
                    |found: &[f32; 3], at: usize| (f64::from(found[at]) - f64::from(exact[at])).powi(2);
                for at in 0..3 {
                    error.squares[at].add(square(picture, at));
                    error.blurred_squares[at].add(square(blurred, at));
                }
                error.pixels.add(mean([0, 1, 2].map(|at| square(picture, at))));
            }
        }
        Ok(error)
    }

    fn rms(&self) -> [f64; 3] {
        self.squares.map(|squares| squares.mean().sqrt())
    }

    fn blurred_rms(&self) -> [f64; 3] {
        self.blurred_squares.map(|squares| squares.mean().sqrt())
    }

    /// Whether the mean square over all channels is the expected one, for pixels that are independent of one
    /// another.
    fn z(&self, expected_rms: [f64; 3]) -> f64 {
        let expected = mean(expected_rms.map(|rms| rms * rms));
        z_score(self.pixels.mean() - expected, self.pixels.variance_of_mean().sqrt())
    }
}

/// The exponential average of frames through pixel centres, without the clamping of temporal anti-aliasing.
fn average(stage: &mut Stage, method: &str, seed: u32, frames: u32) -> Result<Image<[f32; 3]>> {
    let settings = Settings { size: SIZE, seed, ..Settings::default() };
    let mut pipelines = pipelines(&Cpu, [&method.parse()?], Antialiasing::NONE, settings)?;
    let mut average = Image::filled(SIZE[0], SIZE[1], [0.0; 3])?;
    let timeline = Timeline::of(&settings, Antialiasing::NONE, frames);
    play(&Cpu, stage, &mut pipelines, timeline, |event| {
        let Event::Frame { index, pipelines } = event else { return Ok(()) };
        let weight = if index == 0 { 1.0 } else { WEIGHT };
        for (average, &[r, g, b, _]) in
            average.as_mut_slice().iter_mut().zip(pipelines[0].planes().colour.as_slice())
        {
            let current = [r, g, b];
            *average = [0, 1, 2].map(|at| average[at] + weight * (current[at] - average[at]));
        }
        Ok(())
    })?;
    Ok(average)
}

/// The mean of each pixel and its eight neighbours; the picture repeats, as the maps do.
fn blur(picture: &Image<[f32; 3]>) -> Result<Image<[f32; 3]>> {
    let (width, height) = picture.size();
    Ok(Image::from_fn(width, height, |x, y| {
        let mut sum = [0.0; 3];
        for (dx, dy) in (0..9).map(|at| (at % 3, at / 3)) {
            let neighbour = picture[((x + width + dx - 1) % width, (y + height + dy - 1) % height)];
            sum = [0, 1, 2].map(|at| sum[at] + neighbour[at] / 9.0);
        }
        sum
    })?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_roulette_is_that_of_independent_frames_and_that_of_std_is_not() {
        let mut stage = stage("layers:count=8,alpha=0.2,colours=red-green,background=1", None).unwrap();
        let expected = independent_rms(8, 0.2);
        let roulette = Error::measure(&mut stage, "roulette").unwrap();
        assert!(roulette.z(expected).abs() < 4.0, "{roulette:?}");
        // Nine independent pixels have a third of the error of one.
        assert!((mean(roulette.blurred_rms()) / mean(roulette.rms()) - 1.0 / 3.0).abs() < 0.03);
        let std = Error::measure(&mut stage, "std").unwrap();
        assert!(std.z(expected).abs() > 4.0, "{std:?}");
        assert!(!agree(mean(roulette.blurred_rms()) / mean(roulette.rms()), 0.8), "any share passes");
    }
}
