//! Claims and the tests that decide them.
//!
//! What hangs on random numbers is measured with several seeds, and two methods are compared seed by seed: a
//! claim holds if the mean difference has its sign and a two-sided paired t-test (Student 1908) gives chance
//! at most [`LEVEL`]. With one seed the sign alone decides. Claims are not corrected for their number: each
//! says how likely it is to be chance by itself.

use sheer_metrics::statistics::{Moments, student_t_p};

use super::findings::Claim;

/// Probability of chance up to which a difference counts.
pub(super) const LEVEL: f64 = 0.05;

/// What was measured of something with each of the seeds.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    /// Method or setting.
    pub(super) name: String,
    /// One a seed, in the order of the seeds.
    pub(super) values: Vec<f64>,
}

impl Sample {
    pub(super) fn new(name: impl Into<String>, values: Vec<f64>) -> Self {
        Self { name: name.into(), values }
    }

    pub(super) fn mean(&self) -> f64 {
        self.values.iter().copied().collect::<Moments>().mean()
    }

    /// The same times a factor: what another one is to stay below.
    fn scaled(&self, factor: f64) -> Self {
        Self::new(self.name.clone(), self.values.iter().map(|value| value * factor).collect())
    }
}

/// Something that is not random, or whose allowance for chance is in the text.
pub(super) fn claim(text: impl Into<String>, holds: bool) -> Claim {
    Claim::new(text, holds)
}

/// That the second exceeds the first in every seed alike, with a text of one's own for the means.
pub(super) fn less_as(text: impl Into<String>, low: &Sample, high: &Sample) -> Claim {
    let differences: Moments = high.values.iter().zip(&low.values).map(|(high, low)| high - low).collect();
    let text = text.into();
    let is_less = differences.mean() > 0.0;
    if differences.count() < 2 {
        return claim(text, is_less);
    }
    let p = chance(differences);
    let seeds = differences.count();
    let text = format!("{text} (p = {p:.2}, {seeds} seeds)").replace("p = 0.00", "p < 0.005");
    Claim { p: Some(p), ..claim(text, is_less && p <= LEVEL) }
}

/// Probability that chance alone makes a mean difference so large. What never varies is no chance.
fn chance(differences: Moments) -> f64 {
    let error = differences.variance_of_mean().sqrt();
    if error == 0.0 {
        return if differences.mean() == 0.0 { 1.0 } else { 0.0 };
    }
    student_t_p(differences.mean() / error, differences.count() as u32 - 1)
}

/// That a quantity of the first exceeds that of the second.
pub(super) fn greater(quantity: &str, one: &Sample, other: &Sample) -> Claim {
    let text =
        format!("{quantity} of {} {} > {} {}", one.name, shown(one.mean()), other.name, shown(other.mean()));
    less_as(text, other, one)
}

/// That the first is less than the second.
pub(super) fn less(quantity: &str, one: &Sample, other: &Sample) -> Claim {
    let text =
        format!("{quantity} of {} {} < {} {}", one.name, shown(one.mean()), other.name, shown(other.mean()));
    less_as(text, one, other)
}

/// That the first is at most a share of the second.
pub(super) fn at_most(quantity: &str, one: &Sample, share: f64, other: &Sample) -> Claim {
    let found = one.mean() / other.mean();
    let text = format!("{quantity} of {} {found:.2} of {}, at most {share}", one.name, other.name);
    less_as(text, one, &other.scaled(share))
}

/// That the first is at least a share of the second.
pub(super) fn at_least(quantity: &str, one: &Sample, share: f64, other: &Sample) -> Claim {
    let found = one.mean() / other.mean();
    let text = format!("{quantity} of {} {found:.2} of {}, at least {share}", one.name, other.name);
    less_as(text, &other.scaled(share), one)
}

/// That each is less than the one before; the least certain pair decides.
pub(super) fn falling(text: impl Into<String>, samples: &[Sample]) -> Claim {
    let text = text.into();
    let pairs = samples.windows(2).map(|pair| less_as(String::new(), &pair[1], &pair[0]));
    let pairs: Vec<Claim> = pairs.collect();
    let p = pairs.iter().filter_map(|pair| pair.p).reduce(f64::max);
    let holds = pairs.iter().all(|pair| pair.holds);
    let text = match p {
        Some(p) => format!("{text} (p ≤ {p:.2} for each pair, {} seeds)", samples[0].values.len()),
        None => text,
    };
    Claim { p, ..claim(text, holds) }
}

/// A mean with four figures behind the point, or more where there is nothing before them.
fn shown(value: f64) -> String {
    if value.abs() < 0.01 { format!("{value:.5}") } else { format!("{value:.4}") }
}

impl Claim {
    /// What follows, by what was measured: one sentence if the claim holds, another one if it does not. What
    /// chance may explain says so.
    pub(super) fn remark(mut self, held: &str, failed: &str) -> Self {
        let text = if self.is_undecided() {
            "The seeds do not decide it."
        } else if self.holds {
            held
        } else {
            failed
        };
        self.remark = (!text.is_empty()).then(|| text.to_owned());
        self
    }

    /// Whether chance may explain what was measured.
    fn is_undecided(&self) -> bool {
        self.p.is_some_and(|p| p > LEVEL)
    }

    /// A sign for lists: a tick, a cross, or a question mark where the seeds do not decide.
    #[must_use]
    pub fn mark(&self) -> &'static str {
        if self.is_undecided() {
            "?"
        } else if self.holds {
            "✓"
        } else {
            "✗"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(name: &str, values: &[f64]) -> Sample {
        Sample::new(name, values.to_vec())
    }

    #[test]
    fn what_all_seeds_agree_on_holds_and_the_opposite_does_not() {
        let (low, high) = (sample("low", &[1.0, 1.1, 1.2]), sample("high", &[2.0, 2.1, 2.21]));
        let right = less("error", &low, &high);
        assert!(right.holds && right.mark() == "✓" && right.p.unwrap() < 0.01, "{right:?}");
        let wrong = less("error", &high, &low);
        assert!(!wrong.holds && wrong.mark() == "✗" && wrong.p == right.p, "{wrong:?}");
        assert!(greater("error", &high, &low).holds && !greater("error", &low, &high).holds);
        assert!(right.text.starts_with("error of low 1.1000 < high 2.1033 (p"), "{}", right.text);
    }

    #[test]
    fn what_seeds_disagree_on_is_undecided_and_is_said_to_be() {
        let (one, other) = (sample("a", &[1.0, 1.3, 0.9]), sample("b", &[1.1, 1.2, 1.1]));
        let claim = less("error", &one, &other).remark("better", "worse");
        assert!(!claim.holds && claim.mark() == "?", "{claim:?}");
        assert_eq!(claim.remark.as_deref(), Some("The seeds do not decide it."));
    }

    #[test]
    fn the_remark_is_that_of_the_outcome() {
        let (low, high) = (sample("low", &[1.0]), sample("high", &[2.0]));
        let remark = |claim: Claim| claim.remark("as said", "not as said").remark;
        assert_eq!(remark(less("error", &low, &high)).as_deref(), Some("as said"));
        assert_eq!(remark(less("error", &high, &low)).as_deref(), Some("not as said"));
        assert_eq!(less("error", &low, &high).remark("", "no").remark, None);
        assert_eq!(less("error", &low, &high).p, None);
    }

    #[test]
    fn shares_and_chains_are_tested_as_well() {
        let (half, whole) = (sample("half", &[0.5, 0.52, 0.48]), sample("whole", &[1.0, 1.02, 0.99]));
        assert!(at_most("time", &half, 0.6, &whole).holds && !at_most("time", &half, 0.4, &whole).holds);
        assert!(at_least("time", &half, 0.4, &whole).holds && !at_least("time", &half, 0.6, &whole).holds);
        let least = sample("least", &[0.1, 0.11, 0.12]);
        assert!(falling("all", &[whole.clone(), half.clone(), least.clone()]).holds);
        assert!(!falling("all", &[whole, least, half]).holds);
    }

    #[test]
    fn what_never_varies_is_no_chance() {
        let still = |name: &str, value: f64| sample(name, &[value; 3]);
        assert!(less("error", &still("a", 1.0), &still("b", 2.0)).holds);
        assert_eq!(less("error", &still("a", 1.0), &still("b", 1.0)).mark(), "?");
    }
}
