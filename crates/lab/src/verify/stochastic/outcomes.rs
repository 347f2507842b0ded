//! All that can come out of a pixel of a few samples, with its probability: a second way to the same figures,
//! in doubles, from the paper's definitions alone.

use super::stack::{Layer, Stack};

/// How masks come about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// A coin a sample.
    Naive,
    /// A random subset of R samples.
    Stratified,
    /// R split evenly between two halves of the samples, the odd one by a coin; a random subset of each.
    Halves,
}

/// An estimator of ST.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimator {
    pub(super) law: Law,
    pub(super) is_depth_based: bool,
    pub(super) is_corrected: bool,
}

/// Mean and mean square error of an estimator.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Exact {
    pub(super) mean: [f64; 3],
    pub(super) square_error: [f64; 3],
}

impl Exact {
    /// By enumeration of all masks of all layers.
    pub(super) fn new(estimator: Estimator, samples: u32, stack: &Stack) -> Self {
        let mut exact = Self::default();
        let right = stack.colour();
        let mut masks = Vec::with_capacity(stack.layers.len());
        each_outcome(estimator.law, samples, &stack.layers, 1.0, &mut masks, &mut |probability, masks| {
            let found = estimator.colour(samples, stack, masks);
            for channel in 0..3 {
                exact.mean[channel] += probability * found[channel];
                exact.square_error[channel] += probability * (found[channel] - right[channel]).powi(2);
            }
        });
        exact
    }
}

fn each_outcome(
    law: Law,
    samples: u32,
    layers: &[Layer],
    probability: f64,
    masks: &mut Vec<u32>,
    visit: &mut dyn FnMut(f64, &[u32]),
) {
    let Some((layer, further)) = layers.split_first() else { return visit(probability, masks) };
    for mask in 0..1 << samples {
        let probability = probability * law.probability(samples, layer.alpha, mask);
        if probability > 0.0 {
            masks.push(mask);
            each_outcome(law, samples, further, probability, masks, visit);
            masks.pop();
        }
    }
}

impl Law {
    fn probability(self, samples: u32, alpha: f64, mask: u32) -> f64 {
        let size = mask.count_ones();
        match self {
            Self::Naive => alpha.powi(size as i32) * (1.0 - alpha).powi((samples - size) as i32),
            Self::Stratified => size_probability(samples, alpha, size) / subsets(samples, size),
            Self::Halves => {
                let half = samples / 2;
                let low = (mask & ((1 << half) - 1)).count_ones();
                let high = size - low;
                let split = match low.abs_diff(high) {
                    0 => 1.0,
                    1 => 0.5,
                    _ => 0.0,
                };
                split * size_probability(samples, alpha, size) / (subsets(half, low) * subsets(half, high))
            }
        }
    }
}

/// That R is `size`: R = ⌊αS + ξ⌋ for a uniform ξ.
pub(super) fn size_probability(samples: u32, alpha: f64, size: u32) -> f64 {
    (1.0 - (alpha * f64::from(samples) - f64::from(size)).abs()).max(0.0)
}

/// Samples choose size.
fn subsets(samples: u32, size: u32) -> f64 {
    (0..size).map(|index| f64::from(samples - index) / f64::from(index + 1)).product()
}

impl Estimator {
    fn colour(self, samples: u32, stack: &Stack, masks: &[u32]) -> [f64; 3] {
        let share = |mask: u32| f64::from(mask.count_ones()) / f64::from(samples);
        let (mut hidden, mut rgb, mut ones) = (0, [0.0; 3], 0.0);
        for (layer, mask) in stack.layers.iter().zip(masks) {
            let weight =
                if self.is_depth_based { layer.alpha * (1.0 - share(hidden)) } else { share(mask & !hidden) };
            rgb = [0, 1, 2].map(|channel| rgb[channel] + weight * layer.rgb[channel]);
            ones += weight;
            hidden |= mask;
        }
        let (factor, seen) = if self.is_corrected {
            let seen = stack.transmittance();
            (if ones > 0.0 { (1.0 - seen) / ones } else { 0.0 }, seen)
        } else {
            (1.0, 1.0 - share(hidden))
        };
        [0, 1, 2].map(|channel| factor * rgb[channel] + seen * stack.background[channel])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outcomes_of_every_law_have_probability_one_and_alpha_as_their_mean() {
        for law in [Law::Naive, Law::Stratified, Law::Halves] {
            for alpha in [0.05, 0.45, 0.5, 0.9] {
                let (mut whole, mut mean) = (0.0, 0.0);
                for mask in 0..256_u32 {
                    let probability = law.probability(8, alpha, mask);
                    whole += probability;
                    mean += probability * f64::from(mask.count_ones()) / 8.0;
                }
                assert!((whole - 1.0).abs() < 1e-12 && (mean - alpha).abs() < 1e-12, "{law:?} {alpha}");
            }
        }
    }

    #[test]
    fn the_examples_have_the_colours_of_the_paper() {
        let near = |found: [f64; 3], expected: [f64; 3]| {
            found.into_iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-4)
        };
        assert!(near(Stack::example_1().colour(), [0.45, 0.2475, 0.3025]));
        assert!(near(Stack::example_2().colour(), [0.7627; 3]));
    }
}
