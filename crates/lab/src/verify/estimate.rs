//! Measured means against what they should be.

use sheer_metrics::statistics::{Moments, sidak_family, two_sided_p, two_sided_z, z_score};

use super::check::{Check, Value};

/// Squares of what 32-bit floats make of sums of a few numbers up to 1: what should not differ differs by no
/// more.
const ROUNDING_SQUARED: f64 = 1e-12;

/// The measured means of three numbers that chance has a part in, against what they should be; one verdict.
pub(super) fn colour_check(
    name: String,
    source: &str,
    expected: [f64; 3],
    paper: Option<[f64; 3]>,
    measured: &[Moments; 3],
    shown: impl Fn(f64) -> f64,
) -> Check {
    let z = expected.into_iter().zip(measured).map(|(expected, measured)| mean_z(expected, measured));
    Check {
        name,
        source: source.to_owned(),
        closed_form: Some(Value::Colour(expected.map(&shown))),
        paper: paper.map(Value::Colour),
        measured: Some(Value::Colour(measured.map(|moments| shown(moments.mean())))),
        samples: Some(measured[0].count()),
        z: Some(worst(z)),
        pass: false,
    }
}

/// The same for one number, shown over a unit.
pub(super) fn number_check(
    name: String,
    source: &str,
    expected: f64,
    paper: Option<f64>,
    measured: &Moments,
    shown: impl Fn(f64) -> f64,
) -> Check {
    Check {
        name,
        source: source.to_owned(),
        closed_form: Some(Value::Number(shown(expected))),
        paper: paper.map(Value::Number),
        measured: Some(Value::Number(shown(measured.mean()))),
        samples: Some(measured.count()),
        z: Some(mean_z(expected, measured)),
        pass: false,
    }
}

/// Standard errors between a mean and what it should be. Where nothing varies, anything beyond rounding is
/// infinitely far.
pub(super) fn mean_z(expected: f64, measured: &Moments) -> f64 {
    let difference = measured.mean() - expected;
    if difference * difference <= ROUNDING_SQUARED && measured.variance() <= ROUNDING_SQUARED {
        return 0.0;
    }
    z_score(difference, measured.variance_of_mean().sqrt())
}

/// The standard normal number that is as rare as the rarest of several.
pub(super) fn worst(z: impl IntoIterator<Item = f64>) -> f64 {
    let (least, count) = z.into_iter().fold((1.0_f64, 0), |(least, count), z| {
        // Not a number is no probability: nothing may pass for it.
        let p = two_sided_p(z);
        (if p.is_nan() { 0.0 } else { least.min(p) }, count + 1)
    });
    if least > 0.0 { two_sided_z(sidak_family(least, count)) } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_vary_has_to_be_right() {
        let still = |value: f64| [value; 9].into_iter().collect::<Moments>();
        assert_eq!(mean_z(0.25, &still(0.25)), 0.0);
        assert_eq!(mean_z(0.25, &still(0.250_1)).abs(), f64::INFINITY);
        assert_eq!(worst([0.0, f64::NAN]), f64::INFINITY);
        assert!((worst([2.0]) - 2.0).abs() < 1e-6 && worst([2.0, 0.0, 0.0]) < 2.0);
    }
}
