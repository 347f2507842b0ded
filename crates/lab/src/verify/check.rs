//! What is checked, and how it is judged.

use serde::Serialize;
use sheer_metrics::statistics::{sidak, two_sided_p};

/// Probability that any of the random checks fails although nothing is wrong. The seeds are fixed, so it is
/// paid once, not each run.
const LEVEL: f64 = 1e-3;

/// One figure of a paper or property of a method.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// Of what.
    pub name: String,
    /// Paper and place in it, or what else demands it.
    pub source: String,
    /// What theory gives.
    pub closed_form: Option<Value>,
    /// What the paper prints.
    pub paper: Option<Value>,
    /// What this program gives.
    pub measured: Option<Value>,
    /// How many samples that rests on; null where it is counted rather than sampled.
    pub samples: Option<u64>,
    /// Standard errors between closed form and measurement; null where nothing is random.
    pub z: Option<f64>,
    /// Whether it is as it should be.
    pub pass: bool,
}

impl Check {
    /// Whether what was measured rounds to something else than the paper prints; false where it prints
    /// nothing. The closed form decides whether a check passes: papers have slips and samples of their own.
    #[must_use]
    pub fn differs_from_paper(&self) -> bool {
        let Some((paper, measured)) = self.paper.zip(self.measured) else { return false };
        let (paper, measured) = (paper.channels(), measured.channels());
        // Papers print two decimals or more: half of the last one is rounding.
        let decimals = |value: &f64| value.to_string().split_once('.').map_or(0, |(_, behind)| behind.len());
        let decimals = paper.iter().map(decimals).max().unwrap_or(0).max(2);
        let half = 0.5 * 0.1_f64.powi(decimals as i32) * (1.0 + 1e-9);
        paper.iter().zip(measured).any(|(paper, measured)| (paper - measured).abs() > half)
    }
}

impl Value {
    /// A number as three of the same.
    fn channels(self) -> [f64; 3] {
        match self {
            Self::Number(value) => [value; 3],
            Self::Colour(channels) => channels,
        }
    }
}

/// A number or a colour.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A number.
    Number(f64),
    /// Red, green and blue in linear light.
    Colour([f64; 3]),
}

/// Something that has one right answer.
pub(super) fn exact(
    name: impl Into<String>,
    source: &str,
    expected: f64,
    paper: Option<f64>,
    measured: f64,
) -> Check {
    Check {
        name: name.into(),
        source: source.to_owned(),
        closed_form: Some(Value::Number(expected)),
        paper: paper.map(Value::Number),
        measured: Some(Value::Number(measured)),
        samples: None,
        z: None,
        pass: expected.to_bits() == measured.to_bits(),
    }
}

/// Passes or fails everything that has a `z`: all of them together err with a probability of 1e-3.
pub fn judge(checks: &mut [Check]) {
    let count = checks.iter().filter(|check| check.z.is_some()).count();
    let level = sidak(LEVEL, count as u64);
    for check in checks {
        if let Some(z) = check.z {
            check.pass = two_sided_p(z) >= level;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(z: f64) -> Check {
        Check { z: Some(z), pass: false, ..exact("", "", 0.0, None, 0.0) }
    }

    #[test]
    fn chance_passes_and_what_is_beyond_it_fails() {
        let mut checks =
            vec![random(0.0), random(-3.5), random(7.0), random(f64::INFINITY), random(f64::NAN)];
        judge(&mut checks);
        assert_eq!(
            checks.iter().map(|check| check.pass).collect::<Vec<_>>(),
            [true, true, false, false, false]
        );
    }

    #[test]
    fn the_more_checks_the_wider_the_band_of_chance() {
        let mut alone = [random(3.5)];
        judge(&mut alone);
        assert!(!alone[0].pass);
    }

    #[test]
    fn what_is_not_as_printed_is_told_from_rounding() {
        let check = |paper, measured| exact("", "", 0.0, Some(paper), measured).differs_from_paper();
        assert!(!check(0.25, 0.249) && !check(0.1, 0.104_9) && !check(1512.0, 1512.0));
        assert!(check(0.35, 0.174) && check(0.1, 0.106) && check(0.273, 0.2742));
        let colour = |channels| Some(Value::Colour(channels));
        let printed = colour([0.14, 0.12, 0.0]);
        let rest = exact("", "", 0.0, None, 0.0);
        let with = |measured| Check { paper: printed, measured, ..rest.clone() }.differs_from_paper();
        assert!(!with(colour([0.136, 0.124, 0.0])) && with(colour([0.027, 0.027, 0.0])));
        assert!(!rest.differs_from_paper(), "the paper prints nothing");
    }

    #[test]
    fn exact_checks_allow_nothing() {
        assert!(exact("", "", 1512.0, None, 1512.0).pass);
        assert!(!exact("", "", 1512.0, None, 1512.0_f64.next_up()).pass);
    }
}
