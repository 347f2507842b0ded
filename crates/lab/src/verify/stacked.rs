//! What stacked layers come to under methods of one shaded fragment, in the long run: the error of an
//! exponential average, which layers whose patterns are not independent leave in it for ever, and the mean,
//! where a method claims to be right on average.
//!
//! What is measured is held against the stated model: a closed form where frames are independent, else a
//! simulation of the paper's definitions ([`super::model`]). Pictures are the units of all tests: inside one
//! everything hangs on a few draws.

use sheer_core::hash::Pcg32;
use sheer_metrics::statistics::{Moments, z_score};
use sheer_render::{Antialiasing, Pipeline, Settings, Stage};

use super::{
    estimate::worst,
    model::{FRAMES, Model, Pattern, SIDE, Stack, WEIGHT, weights_of_phases},
    picture::stage,
};
use crate::{
    Result,
    verify::check::{Check, Value},
};

/// Pictures that are rendered for a row if they take all frames of the average; of patterns that repeat
/// earlier, each picture takes one period of frames and there are as many more.
const SEEDS: u32 = 32;
/// Pictures that are simulated for each row: many more, so that the model's own chance counts for little.
const TRIALS: u32 = 800;
/// Of the simulation.
const MODEL_SEED: u64 = 2026;

/// Stacks for which the error of `std` is told in all ways: to independent layers, to roulette, and after a
/// blur.
const STACKS: [Stack; 3] =
    [Stack { count: 2, alpha: 0.45 }, Stack { count: 8, alpha: 0.2 }, Stack { count: 20, alpha: 0.1 }];
const FAINT: Stack = Stack { count: 40, alpha: 0.05 };

/// Methods whose model is simulated, on one stack each, with what says so.
const SIMULATED: [(&str, Pattern, Stack, &str); 7] = [
    ("std", Pattern::Std, FAINT, "STD section 3.3"),
    ("std:noise=object", Pattern::StdOwnNoise, STACKS[2], "STD section 3.3, changed"),
    ("std:noise=object", Pattern::StdOwnNoise, FAINT, "STD section 3.3, changed"),
    ("dtaa-unique", Pattern::DtaaUnique, STACKS[1], "STD section 2.2"),
    ("stbn", Pattern::Stbn, STACKS[1], "STD section 7.2"),
    ("joint", Pattern::Joint, STACKS[1], "docs/joint.md"),
    ("joint", Pattern::Joint, STACKS[2], "docs/joint.md"),
];

/// Methods that claim no bias, but whose pixels are not independent of one another.
const UNBIASED: [(&str, &str); 4] = [
    ("joint", "docs/joint.md"),
    ("hashed", "Wyman and McGuire 2017"),
    ("roulette:hybrid=0.5", "STD section 3.4"),
    ("joint:hybrid=0.5", "STD section 3.4"),
];

pub(super) fn checks(threads: Option<usize>) -> Result<Vec<Check>> {
    let model = Model::new();
    let mut checks = Vec::new();
    for stack in STACKS {
        let mut stage = stage(&stack.scene(), threads)?;
        let roulette = Errors::measure(&mut stage, "roulette", FRAMES, stack)?;
        let std = Errors::measure(&mut stage, "std", Pattern::Std.period(), stack)?;
        let simulated = Errors::simulate(&model, Pattern::Std, stack);
        checks.push(independent("roulette", "STD section 3.2", stack, 0, &roulette));
        checks.push(modelled("std", "STD section 3.3", stack, &std, &simulated));
        checks.push(over_independent(stack, [&std, &roulette], &simulated));
        checks.push(left_by_a_blur(stack, &std, &simulated));
    }
    for (method, pattern, stack, source) in SIMULATED {
        let mut stage = stage(&stack.scene(), threads)?;
        let measured = Errors::measure(&mut stage, method, pattern.period(), stack)?;
        checks.push(modelled(method, source, stack, &measured, &Errors::simulate(&model, pattern, stack)));
    }
    let stack = STACKS[1];
    let mut stage = stage(&stack.scene(), threads)?;
    for (method, source) in UNBIASED {
        let measured = Errors::measure(&mut stage, method, FRAMES, stack)?;
        checks.push(mean_of(method, source, stack, &measured));
        if let Some(exact) = exact_layers(method, stack) {
            checks.push(independent(method, source, stack, exact, &measured));
        }
    }
    Ok(checks)
}

/// How many layers roulette's hybrid composites exactly: until visibility has fallen to its share.
fn exact_layers(method: &str, stack: Stack) -> Option<u32> {
    let share: f64 = method.strip_prefix("roulette:hybrid=")?.parse().ok()?;
    (0..=stack.count).find(|&layers| (1.0 - stack.alpha).powi(layers as i32) <= share)
}

/// What one picture has of error.
#[derive(Clone, Copy, Debug)]
struct PictureError {
    /// Mean square error by channel.
    squares: [f64; 3],
    /// Mean square error over all channels.
    square: f64,
    /// The same after a blur: noise averages out over a map, bias does not.
    blurred_square: f64,
    /// Mean by channel.
    mean: [f64; 3],
}

impl PictureError {
    fn new(picture: &[[f64; 3]], exact: [f64; 3]) -> Self {
        let pixels = picture.len() as f64;
        let squares_of = |picture: &[[f64; 3]]| {
            [0, 1, 2]
                .map(|at| picture.iter().map(|found| (found[at] - exact[at]).powi(2)).sum::<f64>() / pixels)
        };
        let squares = squares_of(picture);
        Self {
            squares,
            square: mean(squares),
            blurred_square: mean(squares_of(&blurred(picture))),
            mean: [0, 1, 2].map(|at| picture.iter().map(|found| found[at]).sum::<f64>() / pixels),
        }
    }
}

fn mean([r, g, b]: [f64; 3]) -> f64 {
    (r + g + b) / 3.0
}

/// The mean of each pixel and its eight neighbours; the picture repeats, as the maps do.
fn blurred(picture: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let at = |x: usize, y: usize| picture[y % SIDE * SIDE + x % SIDE];
    let around = |place: usize| {
        let (x, y) = (place % SIDE, place / SIDE);
        let neighbours = (0..9).map(|each| at(x + SIDE + each % 3 - 1, y + SIDE + each / 3 - 1));
        neighbours.fold([0.0; 3], |sum, colour| [0, 1, 2].map(|channel| sum[channel] + colour[channel] / 9.0))
    };
    (0..picture.len()).map(around).collect()
}

/// Those of many pictures, each with draws of its own.
#[derive(Clone, Debug)]
struct Errors(Vec<PictureError>);

impl Errors {
    /// Of a method whose pixels see the same again after `period` frames.
    fn measure(stage: &mut Stage, method: &str, period: u32, stack: Stack) -> Result<Self> {
        let (exact, weights) = (stack.colour(), weights_of_phases(period));
        let pictures = (0..SEEDS * FRAMES / period)
            .map(|seed| Ok(PictureError::new(&average(stage, method, seed, &weights)?, exact)));
        Ok(Self(pictures.collect::<Result<_>>()?))
    }

    fn simulate(model: &Model, pattern: Pattern, stack: Stack) -> Self {
        let mut random = Pcg32::new(MODEL_SEED, u64::from(stack.count));
        let exact = stack.colour();
        let picture = |_| PictureError::new(&model.picture(pattern, stack, &mut random), exact);
        Self((0..TRIALS).map(picture).collect())
    }

    fn moments(&self, of: impl Fn(&PictureError) -> f64) -> Moments {
        self.0.iter().map(of).collect()
    }

    fn rms(&self) -> f64 {
        self.moments(|error| error.square).mean().sqrt()
    }

    fn rms_by_channel(&self) -> [f64; 3] {
        [0, 1, 2].map(|at| self.moments(|error| error.squares[at]).mean().sqrt())
    }

    fn blurred_rms(&self) -> f64 {
        self.moments(|error| error.blurred_square).mean().sqrt()
    }

    /// Relative variance of the RMS error: half the standard error of the logarithm of the mean square,
    /// squared.
    fn relative_variance(&self) -> f64 {
        let squares = self.moments(|error| error.square);
        squares.variance_of_mean() / (2.0 * squares.mean()).powi(2)
    }

    fn check(&self, name: String, source: &str) -> Check {
        Check {
            name,
            source: source.to_owned(),
            closed_form: None,
            paper: None,
            measured: None,
            samples: Some((self.0.len() * SIDE * SIDE) as u64),
            z: None,
            pass: false,
        }
    }
}

/// Standard errors between two means.
fn z_between(one: Moments, other: Moments) -> f64 {
    z_score(one.mean() - other.mean(), (one.variance_of_mean() + other.variance_of_mean()).sqrt())
}

/// The RMS error, against that of frames that are drawn independently behind `exact` layers composited
/// exactly: a channel is 1 with the probability of its layers, and an average of weight w keeps w / (2 - w)
/// of the variance.
fn independent(method: &str, source: &str, stack: Stack, exact: u32, measured: &Errors) -> Check {
    let reaching = (1.0 - stack.alpha).powi(exact as i32);
    let kept = WEIGHT / (2.0 - WEIGHT);
    let squares = stack.shares_from(exact).map(|share| reaching * reaching * share * (1.0 - share) * kept);
    let squares_z = [0, 1, 2].map(|at| {
        let found = measured.moments(|error| error.squares[at]);
        z_score(found.mean() - squares[at], found.variance_of_mean().sqrt())
    });
    Check {
        closed_form: Some(Value::Colour(squares.map(f64::sqrt))),
        measured: Some(Value::Colour(measured.rms_by_channel())),
        z: Some(worst(squares_z)),
        ..measured.check(format!("{method}: RMS error of {}×{}", stack.count, stack.alpha), source)
    }
}

/// The RMS error, against that of the simulated model.
fn modelled(method: &str, source: &str, stack: Stack, measured: &Errors, simulated: &Errors) -> Check {
    let z = [0, 1, 2].map(|at| {
        z_between(measured.moments(|error| error.squares[at]), simulated.moments(|error| error.squares[at]))
    });
    Check {
        closed_form: Some(Value::Colour(simulated.rms_by_channel())),
        measured: Some(Value::Colour(measured.rms_by_channel())),
        z: Some(worst(z)),
        ..measured.check(format!("{method}: RMS error of {}×{}", stack.count, stack.alpha), source)
    }
}

/// By how much the error of `std` exceeds that of independent layers, which roulette has.
fn over_independent(stack: Stack, [std, roulette]: [&Errors; 2], simulated: &Errors) -> Check {
    let kept = WEIGHT / (2.0 - WEIGHT);
    let independent = mean(stack.colour().map(|share| share * (1.0 - share) * kept)).sqrt();
    let (expected, found) = (simulated.rms() / independent, std.rms() / roulette.rms());
    // The error of a logarithm is the relative error.
    let variance: f64 = [std, roulette, simulated].iter().map(|errors| errors.relative_variance()).sum();
    Check {
        closed_form: Some(Value::Number(expected)),
        measured: Some(Value::Number(found)),
        z: Some(z_score((found / expected).ln(), variance.sqrt())),
        ..std.check(
            format!("std: RMS error over roulette's, simulated, of {}×{}", stack.count, stack.alpha),
            "STD section 3.3",
        )
    }
}

/// The share of the error that a blur over a map's nine pixels leaves: a third of independent noise, all of a
/// bias.
fn left_by_a_blur(stack: Stack, std: &Errors, simulated: &Errors) -> Check {
    let (expected, found) = (simulated.blurred_rms() / simulated.rms(), std.blurred_rms() / std.rms());
    // Both errors of a picture go together: what is tested is the difference that vanishes on average if the
    // share is right (Fieller 1954).
    let difference = |error: &PictureError| error.blurred_square - expected * expected * error.square;
    Check {
        closed_form: Some(Value::Number(expected)),
        measured: Some(Value::Number(found)),
        z: Some(z_between(std.moments(difference), simulated.moments(difference))),
        ..std.check(
            format!("std: error left by a 3×3 blur, simulated, of {}×{}", stack.count, stack.alpha),
            "STD section 3.3",
        )
    }
}

/// The mean over pictures and pixels, against the exact colour.
fn mean_of(method: &str, source: &str, stack: Stack, measured: &Errors) -> Check {
    let exact = stack.colour();
    let means = [0, 1, 2].map(|at| measured.moments(|error| error.mean[at]));
    let z = [0, 1, 2].map(|at| z_score(means[at].mean() - exact[at], means[at].variance_of_mean().sqrt()));
    Check {
        closed_form: Some(Value::Colour(exact)),
        measured: Some(Value::Colour(means.map(|means| means.mean()))),
        z: Some(worst(z)),
        ..measured.check(format!("{method}: mean of {}×{}", stack.count, stack.alpha), source)
    }
}

/// The exponential average of frames through pixel centres, without the clamping of temporal anti-aliasing:
/// each frame with the weight of all that show the same.
fn average(stage: &mut Stage, method: &str, seed: u32, weights: &[f64]) -> Result<Vec<[f64; 3]>> {
    let settings = Settings { size: [SIDE as u32; 2], seed, ..Settings::default() };
    let mut pipeline = Pipeline::new(method.parse()?, Antialiasing::NONE, settings)?;
    let mut average = vec![[0.0; 3]; SIDE * SIDE];
    for (index, weight) in (0..).zip(weights) {
        pipeline.render(stage, index)?;
        for (average, current) in average.iter_mut().zip(pipeline.planes().colour.as_slice()) {
            *average = [0, 1, 2].map(|at| average[at] + weight * f64::from(current[at]));
        }
    }
    Ok(average)
}

#[cfg(test)]
mod tests {
    use super::{super::check::judge, *};

    fn passes(check: Check) -> bool {
        let mut checks = [check];
        judge(&mut checks);
        checks[0].pass
    }

    fn measured(method: &str, stack: Stack) -> Errors {
        let period = match method.split(':').next() {
            Some("std") => Pattern::Std.period(),
            Some("dtaa-unique") => Pattern::DtaaUnique.period(),
            Some("stbn") => Pattern::Stbn.period(),
            _ => FRAMES,
        };
        Errors::measure(&mut stage(&stack.scene(), None).unwrap(), method, period, stack).unwrap()
    }

    #[test]
    fn independent_frames_are_told_from_a_pattern_and_from_another_opacity() {
        let stack = STACKS[1];
        let roulette = measured("roulette", stack);
        assert!(passes(independent("", "", stack, 0, &roulette)));
        // Nine independent pixels have a third of the error of one.
        assert!((roulette.blurred_rms() / roulette.rms() - 1.0 / 3.0).abs() < 0.01);
        assert!(!passes(independent("", "", stack, 0, &measured("std", stack))));
        assert!(!passes(independent("", "", Stack { alpha: 0.22, ..stack }, 0, &roulette)));
        // So many exact layers leave another error.
        assert!(!passes(independent("", "", stack, 1, &roulette)));
    }

    #[test]
    fn patterns_that_layers_share_are_told_from_one_threshold_for_all() {
        let (model, stack) = (Model::new(), STACKS[1]);
        let joint = Errors::simulate(&model, Pattern::Joint, stack);
        for method in ["std", "std:noise=object", "dtaa-unique", "stbn", "roulette"] {
            assert!(!passes(modelled(method, "", stack, &measured(method, stack), &joint)), "{method}");
        }
        let measured = measured("joint", stack);
        for pattern in [Pattern::Std, Pattern::StdOwnNoise, Pattern::DtaaUnique, Pattern::Stbn] {
            let other = Errors::simulate(&model, pattern, stack);
            assert!(!passes(modelled("joint", "", stack, &measured, &other)), "{pattern:?}");
        }
    }

    #[test]
    fn who_shares_the_noise_shows_in_faint_layers() {
        let model = Model::new();
        for (method, right, wrong) in [
            ("std", Pattern::Std, Pattern::StdOwnNoise),
            ("std:noise=object", Pattern::StdOwnNoise, Pattern::Std),
        ] {
            let measured = measured(method, FAINT);
            let verdict = |pattern| {
                passes(modelled(method, "", FAINT, &measured, &Errors::simulate(&model, pattern, FAINT)))
            };
            assert!(verdict(right) && !verdict(wrong), "{method}");
        }
    }

    #[test]
    fn a_ratio_and_a_share_that_are_a_third_off_are_found() {
        let (stack, model) = (STACKS[1], Model::new());
        let simulated = Errors::simulate(&model, Pattern::Std, stack);
        let [std, roulette] = ["std", "roulette"].map(|method| measured(method, stack));
        let scaled = |by: f64, blurred_by: f64| {
            let scale = |error: &PictureError| PictureError {
                square: error.square * by * by,
                blurred_square: error.blurred_square * blurred_by * blurred_by,
                ..*error
            };
            Errors(std.0.iter().map(scale).collect())
        };
        assert!(passes(over_independent(stack, [&std, &roulette], &simulated)));
        assert!(!passes(over_independent(stack, [&scaled(1.33, 1.33), &roulette], &simulated)));
        assert!(passes(left_by_a_blur(stack, &std, &simulated)));
        assert!(!passes(left_by_a_blur(stack, &scaled(1.0, 1.33), &simulated)));
    }

    #[test]
    fn a_mean_that_is_off_by_two_percent_of_the_opacity_is_found() {
        let stack = STACKS[1];
        for (method, _) in UNBIASED {
            let measured = measured(method, stack);
            assert!(passes(mean_of(method, "", stack, &measured)), "{method}");
            let other = Stack { alpha: 0.204, ..stack };
            assert!(!passes(mean_of(method, "", other, &measured)), "{method}: the check is blind");
        }
    }

    #[test]
    fn hybrids_composite_until_visibility_has_fallen_to_their_share() {
        assert_eq!(exact_layers("roulette:hybrid=0.5", STACKS[1]), Some(4));
        assert_eq!(exact_layers("joint:hybrid=0.5", STACKS[1]), None);
    }
}
