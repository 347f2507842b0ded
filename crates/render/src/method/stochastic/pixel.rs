//! What stochastic transparency keeps of a pixel.

use glam::Vec3;
use sheer_core::mask::MOST_SAMPLES;

use crate::contract::{Fragment, PixelSite};

const MOST: usize = MOST_SAMPLES as usize;
/// The sort key of an empty sample: behind every fragment.
const NOTHING: (f32, u32) = (f32::INFINITY, u32::MAX);

/// Sums of colours, and the same sums with all colours 1 (ST section 4: F(B) and F(B₁), F(U) and F(U₁), times
/// the number of samples).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub(super) rgb: Vec3,
    pub(super) ones: f32,
}

impl std::ops::Add for Sums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { rgb: self.rgb + other.rgb, ones: self.ones + other.ones }
    }
}

/// The samples of a pixel; those beyond the method's count are not used.
#[derive(Clone, Debug)]
pub(in crate::method) struct Pixel {
    pub(super) site: PixelSite,
    /// Product over all fragments of 1 - alpha at each sample: what is left of the background.
    pub(super) transmittance: [f32; MOST],
    /// The z-buffer of this round: depth and its tie-breaker.
    nearest: [(f32, u32); MOST],
    /// The colour buffer of this round.
    pub(super) shown: [Vec3; MOST],
    /// What this round has accumulated.
    pub(super) accumulated: Sums,
    pub(super) is_in_round: bool,
    ended_rounds: u32,
    /// Sums of the rounds that have ended.
    pub(super) sums: Sums,
    /// In how many of the rounds that have ended a sample was empty.
    empty_counts: [u8; MOST],
    pub(super) brightness: Brightness,
}

/// Numbers of the samples in a mask.
pub(super) fn covered(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let sample = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (sample < MOST).then_some(sample)
    })
}

impl Pixel {
    pub(super) fn new(site: &PixelSite) -> Self {
        Self {
            site: *site,
            transmittance: [1.0; MOST],
            nearest: [NOTHING; MOST],
            shown: [Vec3::ZERO; MOST],
            accumulated: Sums::default(),
            is_in_round: false,
            ended_rounds: 0,
            sums: Sums::default(),
            empty_counts: [0; MOST],
            brightness: Brightness::default(),
        }
    }

    pub(super) fn begin_round(&mut self) {
        self.nearest = [NOTHING; MOST];
        self.accumulated = Sums::default();
        self.is_in_round = true;
    }

    pub(super) fn end_round(&mut self, sums: Sums, samples: u32) {
        self.sums = self.sums + sums;
        for sample in 0..samples as usize {
            self.empty_counts[sample] += u8::from(self.nearest[sample] == NOTHING);
        }
        self.ended_rounds += 1;
        self.is_in_round = false;
    }

    /// How many rounds have ended or are under way.
    pub(super) fn rounds(&self) -> u32 {
        self.ended_rounds + u32::from(self.is_in_round)
    }

    /// Covered samples where nothing is in front of the fragment.
    pub(super) fn seen(&self, fragment: &Fragment<'_>) -> u64 {
        self.where_nearest(fragment, |key, nearest| key < nearest)
    }

    /// The number of covered samples in which the fragment is not hidden: it is itself the nearest, or
    /// nothing is in front.
    pub(super) fn unhidden_count(&self, fragment: &Fragment<'_>) -> u32 {
        self.where_nearest(fragment, |key, nearest| key <= nearest).count_ones()
    }

    fn where_nearest(&self, fragment: &Fragment<'_>, holds: impl Fn((f32, u32), (f32, u32)) -> bool) -> u64 {
        covered(fragment.coverage)
            .filter(|&sample| holds(fragment.sort_key(sample), self.nearest[sample]))
            .fold(0, |mask, sample| mask | 1 << sample)
    }

    pub(super) fn write_depth(&mut self, fragment: &Fragment<'_>, samples: u64) {
        covered(samples).for_each(|sample| self.nearest[sample] = fragment.sort_key(sample));
    }

    /// Total alpha of each sample (ST Eq. 5).
    pub(super) fn dim(&mut self, fragment: &Fragment<'_>) {
        covered(fragment.coverage).for_each(|sample| self.transmittance[sample] *= 1.0 - fragment.alpha);
    }

    /// The filtered total alpha: the mean over samples, which lie where the filter wants them.
    pub(super) fn total_alpha(&self, samples: u32) -> f32 {
        let transmittance = &self.transmittance[..samples as usize];
        transmittance.iter().map(|transmittance| 1.0 - transmittance).sum::<f32>() / samples as f32
    }

    /// The colours of this round's winners, and how many there are.
    pub(super) fn winners(&self, samples: u32) -> Sums {
        let shown = (0..samples as usize).filter(|&sample| self.nearest[sample] != NOTHING);
        shown.fold(Sums::default(), |sums, sample| sums + Sums { rgb: self.shown[sample], ones: 1.0 })
    }

    /// The share of rounds in which nothing covered a sample.
    pub(super) fn empty_share(&self, sample: usize) -> f32 {
        let now = self.is_in_round && self.nearest[sample] == NOTHING;
        let count = u32::from(self.empty_counts[sample]) + u32::from(now);
        if self.rounds() == 0 { 1.0 } else { count as f32 / self.rounds() as f32 }
    }
}

/// Mean and variance of the brightness of rounds (Welford 1962).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Brightness {
    count: f32,
    mean: f32,
    squares: f32,
}

impl Brightness {
    pub(super) fn add(&mut self, brightness: f32) {
        self.count += 1.0;
        let before = brightness - self.mean;
        self.mean += before / self.count;
        self.squares += before * (brightness - self.mean);
    }

    /// Standard error of the mean brightness; 0 for less than two rounds.
    pub(super) fn standard_error(&self) -> f32 {
        if self.count < 2.0 { 0.0 } else { (self.squares / (self.count * (self.count - 1.0))).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_samples_of_a_mask_are_counted_from_its_lowest_bit() {
        assert!(covered(1 << 63 | 0b101).eq([0, 2, 63]));
        assert_eq!(covered(0).count(), 0);
    }

    #[test]
    fn the_standard_error_is_that_of_the_mean() {
        let mut brightness = Brightness::default();
        [2.0, 4.0, 9.0].into_iter().for_each(|value| brightness.add(value));
        // Variance 13 of three.
        assert!((brightness.standard_error() - (13.0_f32 / 3.0).sqrt()).abs() < 1e-6);
    }
}
