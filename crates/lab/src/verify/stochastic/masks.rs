//! What ST section 4 asks of masks: proportional, uncorrelated, improving.

use sheer_metrics::statistics::Moments;

use super::{
    outcomes::size_probability,
    stack::{Layer, Stack},
    trials::pixels,
};
use crate::verify::estimate::number_check;
use crate::{Result, verify::check::Check};

/// Pixels a check.
const TRIALS: u32 = 50_000;
/// Opacities of two layers; neither has a whole number of samples.
const ALPHAS: [f64; 2] = [0.45, 0.3];
const SECTION: &str = "ST section 4";

pub(super) fn checks() -> Result<Vec<Check>> {
    let mut checks = Vec::new();
    for samples in [4, 16, 64] {
        for masks in ["naive", "stratified", "laine-karras"] {
            checks.extend(Shares::measure(masks, samples)?.checks(masks));
        }
    }
    Ok(checks)
}

/// Of the samples of many pixels: the share that one layer covers, and the share that both do.
struct Shares {
    samples: u32,
    of_one: Vec<f64>,
    of_both: Vec<f64>,
}

impl Shares {
    fn measure(masks: &str, samples: u32) -> Result<Self> {
        let method = format!("stochastic:samples={samples},masks={masks},estimator=basic,correct=off");
        let [front, back] =
            [0, 1].map(|id| Layer::new(id, ALPHAS[id as usize], [1.0 - f64::from(id), f64::from(id), 0.0]));
        let run = |layers: Vec<Layer>| -> Result<Vec<[f64; 3]>> {
            let mut colours = Vec::with_capacity(TRIALS as usize);
            let stack = Stack { layers, background: [0.0; 3] };
            pixels(&method, &stack, TRIALS, 8 + samples, |colour| colours.push(colour))?;
            Ok(colours)
        };
        // What is seen of the layer behind, once by itself and once behind the other: the same masks, as they
        // hang on the surface.
        let (together, alone) = (run(vec![front, back])?, run(vec![back])?);
        Ok(Self {
            samples,
            of_one: together.iter().map(|colour| colour[0]).collect(),
            of_both: together.iter().zip(&alone).map(|(together, alone)| alone[1] - together[1]).collect(),
        })
    }

    fn checks(&self, masks: &str) -> Vec<Check> {
        let check = |what: &str, expected, values: &mut dyn Iterator<Item = f64>, shown: fn(f64) -> f64| {
            let name = format!("stochastic, {masks}, {} samples: {what}", self.samples);
            number_check(name, SECTION, expected, None, &values.collect::<Moments>(), shown)
        };
        let [alpha, other] = ALPHAS;
        let both = alpha * other;
        let mut checks = vec![
            check("mean share of a layer", alpha, &mut self.of_one.iter().copied(), |mean| mean),
            check("mean share of two layers' overlap", both, &mut self.of_both.iter().copied(), |mean| mean),
        ];
        if masks == "stratified" {
            let squares = |values: &[f64], mean: f64| {
                values.iter().map(|value| (value - mean).powi(2)).collect::<Vec<_>>()
            };
            let [of_one, of_both] = variances(self.samples);
            let shares = squares(&self.of_one, alpha);
            checks.push(check("standard deviation of the share", of_one, &mut shares.into_iter(), f64::sqrt));
            let overlaps = squares(&self.of_both, both);
            checks.push(check(
                "standard deviation of the overlap",
                of_both,
                &mut overlaps.into_iter(),
                f64::sqrt,
            ));
        }
        checks
    }
}

/// Of the share of the first layer and of the overlap, which is hypergeometric once the sizes are known.
fn variances(samples: u32) -> [f64; 2] {
    let count = f64::from(samples);
    let [alpha, other] = ALPHAS;
    let (mut of_one, mut of_both) = (0.0, 0.0);
    for size in 0..=samples {
        let probability = size_probability(samples, alpha, size);
        let share = f64::from(size) / count;
        of_one += probability * (share - alpha).powi(2);
        for other_size in 0..=samples {
            let probability = probability * size_probability(samples, other, other_size);
            let other_share = f64::from(other_size) / count;
            let spread = share * (1.0 - share) * other_share * (1.0 - other_share) / (count - 1.0);
            of_both += probability * (spread + (share * other_share - alpha * other).powi(2));
        }
    }
    [of_one, of_both]
}

#[cfg(test)]
mod tests {
    use super::{super::tests::failures, *};

    #[test]
    fn masks_that_are_always_the_same_are_proportional_but_correlated() {
        for samples in [4, 16, 64] {
            let failed = failures(Shares::measure("a2c", samples).unwrap().checks("stratified"));
            let expected = ["mean share of two layers' overlap", "standard deviation of the overlap"]
                .map(|what| format!("stochastic, stratified, {samples} samples: {what}"));
            assert_eq!(failed, expected);
        }
    }

    #[test]
    fn naive_masks_vary_more_than_stratified_ones() {
        let failed = failures(Shares::measure("naive", 16).unwrap().checks("stratified"));
        assert_eq!(failed.len(), 2, "{failed:?}");
    }

    #[test]
    fn a_layer_that_covers_two_percent_too_much_is_noticed() {
        for masks in ["naive", "stratified", "laine-karras"] {
            let mut shares = Shares::measure(masks, 16).unwrap();
            shares.of_one.iter_mut().for_each(|share| *share *= 1.02);
            let failed = failures(shares.checks(masks));
            assert!(failed.iter().any(|name| name.ends_with("mean share of a layer")), "{masks}: {failed:?}");
        }
    }

    #[test]
    fn the_variances_fall_with_the_samples() {
        let [few, some, many] = [4, 16, 64].map(variances);
        assert!(few[0] > some[0] && some[0] > many[0] && few[1] > some[1] && some[1] > many[1]);
    }
}
