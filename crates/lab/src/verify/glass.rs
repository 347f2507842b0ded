//! Coloured glass: what is seen through it, channel by channel, in closed form.
//!
//! Methods of one shaded fragment are asked twice: for one layer by every one of them, over a whole period of
//! its pattern where it has one, and for three layers by those that claim no bias of stacked layers.

use sheer_gallery::{LayerColours, glass_layers_closed_form};
use sheer_metrics::statistics::Moments;
use sheer_render::{Antialiasing, Settings, Stage};

use super::{
    estimate::colour_check,
    picture::{mean_colour, play, stage},
};
use crate::{
    Result,
    verify::check::{Check, Value},
};

/// Of each layer. Its opacity to the channel that passes best is 7/32, a level of every pattern: so whole
/// periods show it exactly.
const ALPHA: f32 = 0.125;
const TRANSMISSION: f32 = 0.75;
/// Linear grey.
const BACKGROUND: f32 = 0.75;
/// Rounding of 32-bit floats, added up over a few layers and thousands of pixels.
const ROUNDING: f64 = 1e-5;
/// Says what is to be seen: of a surface, and of light that is filtered.
const SOURCE: &str = "KHR_materials_transmission; McGuire and Enderton 2011, section 2";

/// Methods that composite three layers exactly, with the parameters that it takes.
const EXACT: [&str; 8] = [
    "baseline",
    "baseline:trace=continuation",
    "list",
    "list:samples=4",
    "peel",
    "kbuffer",
    "mlab",
    "adaptive",
];
/// Patterns of one layer, with the columns, rows and frames after which they repeat.
const PERIODIC: [(&str, [u32; 3]); 6] = [
    ("std", [192, 192, 9]),
    ("std:noise=object", [192, 192, 9]),
    ("dtaa", [320, 320, 5]),
    ("dtaa-unique", [320, 320, 5]),
    ("stbn", [64, 64, 16]),
    ("joint", [192, 192, 9]),
];
/// Methods of one fragment that are right on average, whatever the number of layers.
const RANDOM: [&str; 6] =
    ["roulette", "roulette:hash=mcguire", "hashed", "joint", "roulette:hybrid=0.7", "joint:hybrid=0.7"];
/// Width and height of a picture whose mean is a sample.
const SIDE: u32 = 32;
/// Such pictures, each with another seed, and the frames of each.
const SEEDS: u32 = 64;
const FRAMES: u32 = 9;

pub(super) fn checks(threads: Option<usize>) -> Result<Vec<Check>> {
    let mut one = stage(&scene(1), threads)?;
    let mut three = stage(&scene(3), threads)?;
    let mut checks = Vec::new();
    for method in EXACT {
        checks.push(exactly(&mut three, 3, method, [4, 4, 1])?);
    }
    for (method, period) in PERIODIC {
        checks.push(exactly(&mut one, 1, method, period)?);
    }
    for method in RANDOM {
        checks.push(on_average(&mut one, 1, method)?);
        checks.push(on_average(&mut three, 3, method)?);
    }
    Ok(checks)
}

fn scene(count: u32) -> String {
    format!(
        "layers:count={count},alpha={ALPHA},transmission={TRANSMISSION},colours=stained,background={BACKGROUND}"
    )
}

/// What is seen of so many layers.
fn closed_form(count: u32) -> [f64; 3] {
    let colour =
        glass_layers_closed_form(count, ALPHA, TRANSMISSION, LayerColours::Stained, BACKGROUND).as_dvec3();
    colour.to_array()
}

/// A picture that chance has no part in.
fn exactly(stage: &mut Stage, count: u32, method: &str, [width, height, frames]: [u32; 3]) -> Result<Check> {
    let settings = Settings { size: [width, height], ..Settings::default() };
    let mut measured = [0.0; 3];
    for frame in 0..frames {
        let settings = Settings { first_frame: frame, ..settings };
        let mean = mean_colour(&play(stage, method, Antialiasing::NONE, settings, 1)?);
        measured = [0, 1, 2].map(|at| measured[at] + mean[at] / f64::from(frames));
    }
    let expected = closed_form(count);
    let error = measured.iter().zip(expected).map(|(measured, expected)| (measured - expected).abs());
    Ok(Check {
        name: format!("{method}: {}", layers_of_glass(count)),
        source: SOURCE.to_owned(),
        closed_form: Some(Value::Colour(expected)),
        paper: None,
        measured: Some(Value::Colour(measured)),
        samples: None,
        z: None,
        pass: error.fold(0.0, f64::max) <= ROUNDING,
    })
}

/// The mean over pictures and pixels. Pictures are the units: pixels of one may depend on one another.
fn on_average(stage: &mut Stage, count: u32, method: &str) -> Result<Check> {
    let mut moments = [Moments::default(); 3];
    for seed in 0..SEEDS {
        let settings = Settings { size: [SIDE; 2], seed, ..Settings::default() };
        let mean = mean_colour(&play(stage, method, Antialiasing::ACCUMULATE, settings, FRAMES)?);
        moments.iter_mut().zip(mean).for_each(|(moments, mean)| moments.add(mean));
    }
    let name = format!("{method}: mean of {}", layers_of_glass(count));
    Ok(colour_check(name, SOURCE, closed_form(count), None, &moments, |mean| mean))
}

fn layers_of_glass(count: u32) -> String {
    if count == 1 {
        "a layer of coloured glass".to_owned()
    } else {
        format!("{count} layers of coloured glass")
    }
}

#[cfg(test)]
mod tests {
    use super::{super::check::judge, *};

    fn passes(check: Check) -> bool {
        let mut checks = [check];
        judge(&mut checks);
        checks[0].pass
    }

    /// Grey glass that is as opaque as the coloured one is to the mean of the channels.
    fn grey(count: u32) -> Stage {
        let passes = 1.0 - ALPHA - 0.375 * (1.0 - (0.75 + 0.5) / 3.0);
        let alpha = 1.0 - passes;
        let text = format!("layers:count={count},alpha={alpha},colours=stained,background={BACKGROUND}");
        stage(&text, None).unwrap()
    }

    #[test]
    fn coloured_glass_is_what_it_should_be_and_grey_glass_is_not() {
        let mut three = stage(&scene(3), None).unwrap();
        assert!(exactly(&mut three, 3, "baseline", [4, 4, 1]).unwrap().pass);
        assert!(!exactly(&mut grey(3), 3, "baseline", [4, 4, 1]).unwrap().pass);
        for method in ["roulette", "joint"] {
            assert!(passes(on_average(&mut three, 3, method).unwrap()), "{method}");
            assert!(!passes(on_average(&mut grey(3), 3, method).unwrap()), "{method}");
        }
    }

    #[test]
    fn a_whole_period_is_exact_and_a_part_of_it_is_not() {
        let mut one = stage(&scene(1), None).unwrap();
        assert!(exactly(&mut one, 1, "stbn", [64, 64, 16]).unwrap().pass);
        // Each frame of the pattern has all of its levels, but not each part of a frame.
        assert!(!exactly(&mut one, 1, "stbn", [64, 40, 16]).unwrap().pass);
        assert!(!exactly(&mut grey(1), 1, "stbn", [64, 64, 16]).unwrap().pass);
    }
}
