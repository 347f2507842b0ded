//! ST section 4: which estimators are right on average, and how far off the others are.

use super::{
    examples::keys,
    outcomes::{Estimator, Exact, Law, size_probability},
    stack::{Layer, Stack},
    trials::moments,
};
use crate::verify::estimate::{colour_check, number_check};
use crate::{Result, verify::check::Check};

/// Pixels a check: a mean is known to a thousandth of the error of one pixel or better.
const TRIALS: u32 = 200_000;
const BASIC: Estimator = Estimator { law: Law::Stratified, is_depth_based: false, is_corrected: false };
const SECTION: &str = "ST section 4";

pub(super) fn checks() -> Result<Vec<Check>> {
    let mut checks = Vec::new();
    for masks in ["naive", "stratified", "laine-karras"] {
        for estimator in ["basic", "depth"] {
            checks.push(unbiased(masks, estimator)?);
        }
    }
    checks.push(alpha_correction("stratified")?);
    for samples in [4, 8] {
        checks.push(empty_pixels(samples, "stratified")?);
    }
    checks.push(single_layer("depth")?);
    for samples in [4, 16, 64] {
        checks.push(corrected_depth(samples, "stratified")?);
    }
    checks.push(eight_samples("one pass of eight", BASIC, BASIC)?);
    let halves = Estimator { law: Law::Halves, ..BASIC };
    checks.push(eight_samples("two passes of four", halves, halves)?);
    Ok(checks)
}

/// E(B) = C and E(U) = C, on Example 1.
fn unbiased(masks: &str, estimator: &str) -> Result<Check> {
    let stack = Stack::example_1();
    let method = format!("stochastic:samples=4,masks={masks},estimator={estimator},correct=off");
    let measured = moments(&method, &stack, TRIALS, 3, |_, value| value)?;
    let name = format!("stochastic, {masks}, {estimator}: mean of Example 1");
    Ok(colour_check(name, SECTION, stack.colour(), None, &measured, |mean| mean))
}

/// Two layers of alpha 1/S hold a sample each, or both the same one.
fn alpha_correction(masks: &str) -> Result<Check> {
    let layers = vec![Layer::new(0, 0.25, [1.0, 0.0, 0.0]), Layer::new(1, 0.25, [0.0, 1.0, 0.0])];
    let stack = Stack { layers, background: [0.0; 3] };
    let estimator = Estimator { is_corrected: true, ..BASIC };
    let expected = Exact::new(estimator, 4, &stack).mean;
    let method = keys(estimator, 4).replace("stratified", masks);
    let measured = moments(&method, &stack, TRIALS, 4, |_, value| value)?;
    let name = "stochastic, alpha-corrected: mean of two layers of 1/4, not 0.25 and 0.1875".to_owned();
    Ok(colour_check(name, "ST section 4.1", expected, Some([0.273, 0.164, 0.0]), &measured, |mean| mean))
}

/// A layer of alpha 1/(2S) leaves every other pixel empty, and nothing there can be corrected.
fn empty_pixels(samples: u32, masks: &str) -> Result<Check> {
    let alpha = 0.5 / f64::from(samples);
    let method = keys(Estimator { is_corrected: true, ..BASIC }, samples).replace("stratified", masks);
    let [measured, ..] = moments(&method, &Stack::single(alpha), TRIALS, 10 + samples, |_, value| value)?;
    let name =
        format!("stochastic, alpha-corrected: share of a layer of alpha 1/{} that is shown", 2 * samples);
    Ok(number_check(name, "ST section 4.1", 0.5 * alpha, Some(0.5), &measured, |mean| mean / alpha))
}

/// The nearest fragment is never hidden: the same layer is exact in every pixel.
fn single_layer(estimator: &str) -> Result<Check> {
    let alpha = 1.0 / 8.0;
    let method = format!("stochastic:samples=4,estimator={estimator}");
    let [measured, ..] = moments(&method, &Stack::single(alpha), TRIALS, 5, |_, value| value)?;
    let name = "stochastic, depth, alpha-corrected: share of a layer of alpha 1/8 that is shown".to_owned();
    Ok(number_check(name, "ST section 4.2", alpha, Some(1.0), &measured, |mean| mean / alpha))
}

/// D of Example 1: biased for any S, its error falling with S. The second layer's visibility is 1 - R/S of
/// the first, and nothing else is random.
fn corrected_depth(samples: u32, masks: &str) -> Result<Check> {
    let stack = Stack::example_1();
    let right = stack.colour();
    let mut expected = [0.0; 3];
    for size in 0..=samples {
        let visibility = 1.0 - f64::from(size) / f64::from(samples);
        let first = (1.0 - stack.transmittance()) / (1.0 + visibility);
        let probability = size_probability(samples, stack.layers[0].alpha, size);
        expected[0] += probability * (first - right[0]).powi(2);
        expected[1] += probability * (first * visibility - right[1]).powi(2);
    }
    let method = format!("stochastic:samples={samples},masks={masks}");
    let measured =
        moments(&method, &stack, TRIALS / 4, 6, |channel, value| (value - right[channel]).powi(2))?;
    let name = format!("stochastic, depth, alpha-corrected, {samples} samples: RMS error of Example 1");
    Ok(colour_check(name, "ST section 4.2", expected, None, &measured, f64::sqrt))
}

/// Two passes of four samples that share R between them are nearly as good as one of eight. `measured` is the
/// same estimator.
fn eight_samples(name: &str, estimator: Estimator, measured: Estimator) -> Result<Check> {
    let stack = Stack::example_1();
    let right = stack.colour();
    let expected = Exact::new(estimator, 8, &stack).square_error;
    let square_error = |channel: usize, value: f64| (value - right[channel]).powi(2);
    let measured = moments(&keys(measured, 8), &stack, TRIALS, 7, square_error)?;
    let name = format!("stochastic, basic, {name}: RMS error of Example 1");
    Ok(colour_check(name, "ST footnotes 3 and 4", expected, None, &measured, f64::sqrt))
}

#[cfg(test)]
mod tests {
    use super::{super::tests::failures, *};

    fn fails(check: Result<Check>) -> bool {
        failures(vec![check.unwrap()]).len() == 1
    }

    #[test]
    fn masks_that_are_always_the_same_bias_what_is_behind() {
        for estimator in ["basic", "depth"] {
            assert!(fails(unbiased("a2c", estimator)), "{estimator}");
        }
        assert!(fails(alpha_correction("a2c")) && fails(alpha_correction("naive")));
    }

    #[test]
    fn an_alpha_correction_of_winners_is_no_estimator_by_depth() {
        assert!(fails(single_layer("basic")));
    }

    #[test]
    fn naive_masks_leave_more_pixels_empty() {
        for samples in [4, 8] {
            assert!(fails(empty_pixels(samples, "naive")), "{samples}");
        }
    }

    #[test]
    fn naive_masks_have_a_greater_error_than_corrected_depth_may() {
        for samples in [4, 16, 64] {
            assert!(fails(corrected_depth(samples, "naive")), "{samples}");
        }
    }

    #[test]
    fn one_pass_of_eight_is_told_from_two_of_four() {
        let halves = Estimator { law: Law::Halves, ..BASIC };
        assert!(fails(eight_samples("", BASIC, halves)) && fails(eight_samples("", halves, BASIC)));
    }
}
