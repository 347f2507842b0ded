//! Stochastic transparency (ST): the paper's figures and arguments, measured by the method itself on fragments made up.

use sheer_metrics::statistics::{Moments, sidak_family, two_sided_p, two_sided_z, z_score};

use crate::report::json::{Check, Value};

mod bias;
mod examples;
mod falling;
mod masks;
mod outcomes;
mod trials;

pub(super) fn checks() -> anyhow::Result<Vec<Check>> {
    let groups = [examples::checks()?, bias::checks()?, masks::checks()?, falling::checks()?];
    Ok(groups.into_iter().flatten().collect())
}

/// Squares of what 32-bit floats make of sums of a few numbers up to 1: what should not differ differs by no more.
const ROUNDING_SQUARED: f64 = 1e-12;

/// The measured means of three numbers that chance has a part in, against what they should be; one verdict.
fn colour_check(
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
fn number_check(
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

/// Standard errors between a mean and what it should be. Where nothing varies, anything beyond rounding is infinitely far.
fn mean_z(expected: f64, measured: &Moments) -> f64 {
    let difference = measured.mean() - expected;
    if difference * difference <= ROUNDING_SQUARED && measured.variance() <= ROUNDING_SQUARED {
        return 0.0;
    }
    z_score(difference, measured.variance_of_mean().sqrt())
}

/// The standard normal number that is as rare as the rarest of several.
fn worst(z: impl IntoIterator<Item = f64>) -> f64 {
    let (least, count) = z.into_iter().fold((1.0_f64, 0), |(least, count), z| {
        // Not a number is no probability: nothing may pass for it.
        let p = two_sided_p(z);
        (if p.is_nan() { 0.0 } else { least.min(p) }, count + 1)
    });
    if least > 0.0 { two_sided_z(sidak_family(least, count)) } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::{
        super::judge,
        outcomes::Stack,
        trials::{Layer, pixels},
        *,
    };

    /// The names of those that fail.
    pub(super) fn failures(mut checks: Vec<Check>) -> Vec<String> {
        judge(&mut checks);
        checks.into_iter().filter(|check| !check.pass).map(|check| check.name).collect()
    }

    #[test]
    fn everything_passes() {
        assert_eq!(failures(checks().unwrap()), [""; 0]);
    }

    #[test]
    fn what_does_not_vary_has_to_be_right() {
        let still = |value: f64| [value; 9].into_iter().collect::<Moments>();
        assert_eq!(mean_z(0.25, &still(0.25)), 0.0);
        assert_eq!(mean_z(0.25, &still(0.250_1)).abs(), f64::INFINITY);
        assert_eq!(worst([0.0, f64::NAN]), f64::INFINITY);
        assert!((worst([2.0]) - 2.0).abs() < 1e-6 && worst([2.0, 0.0, 0.0]) < 2.0);
    }

    #[test]
    fn fragments_are_handed_over_back_to_front_and_blended_front_to_back() {
        let layers = vec![Layer::new(0, 0.5, [1.0, 0.0, 0.0]), Layer::new(1, 0.5, [0.0, 1.0, 0.0])];
        let stack = Stack { layers, background: [0.0, 0.0, 1.0] };
        pixels("list", &stack, 3, 0, |colour| assert_eq!(colour, [0.5, 0.25, 0.25])).unwrap();
        assert!(pixels("std", &stack, 3, 0, |_| ()).is_err(), "no method of fragments");
    }
}
