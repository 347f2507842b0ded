//! Stochastic transparency (ST): the paper's figures and arguments, measured by the method itself on
//! fragments made up.

use crate::{Result, verify::check::Check};

mod bias;
mod examples;
mod falling;
mod masks;
mod outcomes;
mod stack;
mod trials;

pub(super) fn checks() -> Result<Vec<Check>> {
    let groups = [examples::checks()?, bias::checks()?, masks::checks()?, falling::checks()?];
    Ok(groups.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::{
        super::check::judge,
        stack::{Layer, Stack},
        trials::pixels,
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
    fn fragments_are_handed_over_back_to_front_and_blended_front_to_back() {
        let layers = vec![Layer::new(0, 0.5, [1.0, 0.0, 0.0]), Layer::new(1, 0.5, [0.0, 1.0, 0.0])];
        let stack = Stack { layers, background: [0.0, 0.0, 1.0] };
        pixels("list", &stack, 3, 0, |colour| assert_eq!(colour, [0.5, 0.25, 0.25])).unwrap();
        assert!(pixels("std", &stack, 3, 0, |_| ()).is_err(), "no method of fragments");
    }
}
