//! How the error falls with the number of samples: as 1/S for one layer, as 1/√S in thin media (ST section
//! 3.1).

use sheer_metrics::statistics::{Moments, z_score};

use super::{
    stack::{Layer, Stack},
    trials::moments,
};
use crate::verify::estimate::number_check;
use crate::{
    Result,
    verify::check::{Check, Value},
};

/// Pixels a check: 64 layers of 64 samples take their time.
const TRIALS: u32 = 20_000;
const SAMPLES: [u32; 3] = [4, 16, 64];
const SECTION: &str = "ST section 3.1";

pub(super) fn checks() -> Result<Vec<Check>> {
    let mut checks = Falling::measure("one layer", "stratified", -1.0, one_layer)?.checks();
    checks.extend(Falling::measure("thin media", "stratified", -0.5, thin_media)?.checks());
    Ok(checks)
}

/// A stack for a number of samples, and the mean square error of the basic estimator with it.
type Medium = fn(u32) -> (Stack, f64);

/// A third of the samples and a third of one: the same fraction is left to chance whether there are 4, 16 or
/// 64.
fn one_layer(samples: u32) -> (Stack, f64) {
    let alpha = 1.0 / 3.0;
    let chance = (alpha * f64::from(samples)).fract();
    (Stack::single(alpha), chance * (1.0 - chance) / f64::from(samples).powi(2))
}

/// As many layers as samples, a sample each: balls thrown into bins, of which some stay empty (Kolchin,
/// Sevastyanov and Chistyakov 1978).
fn thin_media(samples: u32) -> (Stack, f64) {
    let count = f64::from(samples);
    let layers = (0..samples).map(|id| Layer::new(id, 1.0 / count, [1.0; 3])).collect();
    let stays_empty = |bins: f64| (1.0 - bins / count).powf(count);
    let variance = count * (count - 1.0) * stays_empty(2.0) + count * stays_empty(1.0)
        - (count * stays_empty(1.0)).powi(2);
    (Stack { layers, background: [0.0; 3] }, variance / (count * count))
}

/// Mean square errors at a few numbers of samples.
struct Falling {
    name: &'static str,
    /// Of the RMS error in S, for large S.
    exponent: f64,
    expected: [f64; 3],
    measured: [Moments; 3],
}

impl Falling {
    fn measure(name: &'static str, masks: &str, exponent: f64, medium: Medium) -> Result<Self> {
        let mut falling = Self { name, exponent, expected: [0.0; 3], measured: [Moments::default(); 3] };
        for (at, samples) in SAMPLES.into_iter().enumerate() {
            let (stack, expected) = medium(samples);
            let [right, ..] = stack.colour();
            let method = format!("stochastic:samples={samples},masks={masks},estimator=basic,correct=off");
            let [measured, ..] =
                moments(&method, &stack, TRIALS, 100 + samples, |_, value| (value - right).powi(2))?;
            falling.expected[at] = expected;
            falling.measured[at] = measured;
        }
        Ok(falling)
    }

    fn checks(&self) -> Vec<Check> {
        let rows = SAMPLES.into_iter().zip(self.expected.into_iter().zip(&self.measured));
        let mut checks: Vec<Check> = rows
            .map(|(samples, (expected, measured))| {
                let name = format!("stochastic, stratified, {samples} samples: RMS error in {}", self.name);
                number_check(name, SECTION, expected, None, measured, f64::sqrt)
            })
            .collect();
        checks.push(self.slope());
        checks
    }

    /// The exponent between the first and the last.
    fn slope(&self) -> Check {
        let span = f64::from(SAMPLES[2] / SAMPLES[0]).ln();
        let exponent = |first: f64, last: f64| 0.5 * (last / first).ln() / span;
        let [first, _, last] = &self.measured;
        let expected = exponent(self.expected[0], self.expected[2]);
        let measured = exponent(first.mean(), last.mean());
        // The relative error of a mean is the error of its logarithm.
        let relative = |moments: &Moments| moments.variance_of_mean() / moments.mean().powi(2);
        let error = 0.5 * (relative(first) + relative(last)).sqrt() / span;
        Check {
            name: format!("stochastic, stratified, 4 to 64 samples: exponent of the error in {}", self.name),
            source: SECTION.to_owned(),
            closed_form: Some(Value::Number(expected)),
            paper: Some(Value::Number(self.exponent)),
            measured: Some(Value::Number(measured)),
            samples: Some(first.count() + last.count()),
            z: Some(z_score(measured - expected, error)),
            pass: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tests::failures, *};

    #[test]
    fn naive_masks_do_not_fall_as_stratified_ones_do() {
        let naive = Falling::measure("one layer", "naive", -1.0, one_layer).unwrap();
        assert_eq!(failures(naive.checks()).len(), 4);
    }

    #[test]
    fn masks_that_are_always_the_same_fail_in_thin_media() {
        let same = Falling::measure("thin media", "a2c", -0.5, thin_media).unwrap();
        assert!(failures(vec![same.checks().swap_remove(2)]).len() == 1);
        assert_eq!(failures(same.checks()).len(), 4);
    }

    #[test]
    fn the_closed_forms_fall_as_the_paper_says() {
        let exponent = |medium: Medium| {
            let [few, many] = [64, 4096].map(|samples| medium(samples).1);
            0.5 * (many / few).ln() / 64.0_f64.ln()
        };
        assert!((exponent(one_layer) + 1.0).abs() < 1e-9);
        assert!((exponent(thin_media) + 0.5).abs() < 0.01);
    }
}
