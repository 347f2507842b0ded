//! Which samples of a texel a blocker takes (ST section 3.1).

use sheer_core::{
    choice,
    hash::{Pcg32, pcg4d, unit_from_bits},
};

choice! {
    /// How the samples of a texel are drawn.
    pub enum Sampling {
        /// Each sample flips a coin of its own.
        Naive = "naive",
        /// `R = ⌊alpha · S + ξ⌋` of `S` samples, a random subset.
        Stratified = "stratified",
    }
}

/// The most samples of a texel: a mask is a 64-bit word.
pub(super) const MOST_SAMPLES: u32 = 64;

/// Seed of the mask of a blocker, given by its triangle, in a texel. Masks of two blockers have to be
/// independent.
pub(super) fn seed(texel: usize, blocker: u32, key: u32) -> u64 {
    let [high, low, ..] = pcg4d([texel as u32, blocker, key, (texel as u64 >> 32) as u32]);
    u64::from(high) << 32 | u64::from(low)
}

impl Sampling {
    /// Bit `s` is set if sample `s` of `samples` is covered; each is with probability `alpha`. For one seed a
    /// larger alpha covers what a smaller one covers and more, so that three channels with one seed lose no
    /// light to chance colours (McGuire and Enderton 2011).
    pub(super) fn mask(self, alpha: f32, samples: u32, seed: u64) -> u64 {
        match self {
            Self::Naive => {
                let mut coins = Pcg32::new(seed, samples.into());
                (0..samples).fold(0, |mask, sample| mask | u64::from(coins.next_f32() < alpha) << sample)
            }
            Self::Stratified => {
                let xi = f64::from(unit_from_bits(seed as u32));
                let count = (f64::from(alpha) * f64::from(samples) + xi) as u32;
                subset(seed, count.min(samples), samples)
            }
        }
    }
}

/// A random subset of `count` of `samples` samples, all equally likely: the first ones of a random order, by
/// the shuffle of Fisher and Yates, stopped early.
fn subset(seed: u64, count: u32, samples: u32) -> u64 {
    if count >= samples {
        return u64::MAX >> (MOST_SAMPLES - samples);
    }
    let mut order: [u8; MOST_SAMPLES as usize] = std::array::from_fn(|sample| sample as u8);
    let mut random = Pcg32::new(seed, 0);
    let mut mask = 0;
    for at in 0..count {
        let other = at + random.below(samples - at);
        order.swap(at as usize, other as usize);
        mask |= 1 << order[at as usize];
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWS: u32 = 40_000;

    #[test]
    fn both_ends_of_alpha_are_exact() {
        for sampling in [Sampling::Naive, Sampling::Stratified] {
            for samples in [1, 3, 8, 63, 64] {
                let all = u64::MAX >> (64 - samples);
                for draw in 0..500 {
                    let seed = seed(draw, 7, 3);
                    assert_eq!(sampling.mask(0.0, samples, seed), 0);
                    assert_eq!(sampling.mask(1.0, samples, seed), all);
                    assert_eq!(sampling.mask(0.4, samples, seed) & !all, 0);
                }
            }
        }
    }

    #[test]
    fn every_sample_is_covered_with_the_probability_of_alpha() {
        for sampling in [Sampling::Naive, Sampling::Stratified] {
            for (alpha, samples) in [(0.45, 4), (0.1, 8), (0.83, 16), (0.3, 64)] {
                let mut counts = vec![0_u32; samples as usize];
                for draw in 0..DRAWS {
                    let mask = sampling.mask(alpha, samples, seed(draw as usize, 1, 2));
                    counts
                        .iter_mut()
                        .enumerate()
                        .for_each(|(sample, count)| *count += (mask >> sample & 1) as u32);
                }
                let expected = f64::from(DRAWS) * f64::from(alpha);
                let deviation = (expected * (1.0 - f64::from(alpha))).sqrt();
                // 92 samples in all and two kinds: 4.5 standard deviations happen once in 800 runs.
                for count in counts {
                    let z = (f64::from(count) - expected) / deviation;
                    assert!(z.abs() < 4.5, "{sampling:?} {alpha} {samples}: z {z}");
                }
            }
        }
    }

    #[test]
    fn strata_hold_one_of_two_neighbouring_counts_and_all_subsets_alike() {
        let mut seen = [0_u32; 16];
        for draw in 0..DRAWS {
            let mask = Sampling::Stratified.mask(0.5, 4, seed(draw as usize, 5, 9));
            seen[mask as usize] += 1;
        }
        let expected = f64::from(DRAWS) / 6.0;
        let pairs = seen.iter().enumerate().filter(|(mask, _)| mask.count_ones() == 2);
        let chi: f64 = pairs.map(|(_, &count)| (f64::from(count) - expected).powi(2) / expected).sum();
        // Five degrees of freedom: 20.5 is exceeded once in a thousand.
        assert!(chi < 20.5, "{chi}: {seen:?}");
        assert_eq!(
            seen.iter().enumerate().filter(|(mask, _)| mask.count_ones() != 2).map(|(_, n)| n).sum::<u32>(),
            0
        );
        for draw in 0..2_000 {
            let count = Sampling::Stratified.mask(0.45, 4, seed(draw, 0, 0)).count_ones();
            assert!((1..=2).contains(&count), "{count}");
        }
    }

    #[test]
    fn a_larger_alpha_covers_what_a_smaller_one_covers() {
        for sampling in [Sampling::Naive, Sampling::Stratified] {
            for draw in 0..2_000 {
                let [small, large] = [0.3, 0.6].map(|alpha| sampling.mask(alpha, 16, seed(draw, 4, 4)));
                assert_eq!(small & !large, 0);
            }
        }
    }

    #[test]
    fn masks_of_two_blockers_are_uncorrelated_and_equal_seeds_are_not() {
        let shared = |other: u32| {
            let both = (0..DRAWS).map(|texel| {
                let [a, b] = [3, other]
                    .map(|blocker| Sampling::Stratified.mask(0.5, 8, seed(texel as usize, blocker, 1)));
                (a & b).count_ones()
            });
            f64::from(both.sum::<u32>()) / f64::from(DRAWS)
        };
        // Two of eight on average, hypergeometric: variance 4/7 a draw.
        let z = |mean: f64| (mean - 2.0) / (4.0 / 7.0 / f64::from(DRAWS)).sqrt();
        assert!(z(shared(4)).abs() < 4.0, "{}", shared(4));
        assert!(z(shared(3)) > 100.0, "the check is blind");
    }
}
