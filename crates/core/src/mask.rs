//! Which samples of a pixel a transparent fragment covers: the masks of Enderton, Sintorn, Shirley and
//! Luebke, *Stochastic Transparency* (ST), 2011, sections 3.1 and 5, and the thresholds of Laine and Karras,
//! *Stratified Sampling for Stochastic Transparency*, 2011.
//!
//! Everything is integers, so that a shader draws the same masks.

use std::sync::OnceLock;

use crate::hash::{Pcg32, pcg2d, unit_from_bits};

/// The most samples that a mask has a bit for.
pub const MOST_SAMPLES: u32 = 64;
/// Masks that a fragment chooses from (ST section 5). A prime near 2048: two fragments of one pixel choose
/// the same mask once in so many pixels.
pub const WIDTH: usize = 2047;
/// Bits of an opacity (ST section 5: approximately 10).
pub const ALPHA_BITS: u32 = 10;
/// The opacity that is opaque.
pub const OPAQUE: u32 = 1 << ALPHA_BITS;

/// An opacity, 0 to 1, in [`ALPHA_BITS`], rounded up or down as random bits say: right on average.
///
/// A deviation: ST takes the nearest, which is off by up to 1/2048 for ever, more than the noise of a few
/// thousand pixels.
#[must_use]
pub fn quantised_alpha(alpha: f32, bits: u32) -> u32 {
    let exact = alpha * OPAQUE as f32;
    exact as u32 + u32::from(unit_from_bits(bits) < exact.fract())
}

/// How many of `samples` are covered: R = ⌊αS + ξ⌋ of ST section 3.1, with α and ξ in [`ALPHA_BITS`]. With ξ
/// uniform, αS on average.
#[must_use]
pub const fn set_size(alpha: u32, samples: u32, xi: u32) -> u32 {
    (alpha * samples + xi) >> ALPHA_BITS
}

/// Naive sampling: each sample by itself with the probability of an opacity in [`ALPHA_BITS`].
#[must_use]
pub fn coin_mask(alpha: u32, [first, second]: [u32; 2]) -> u64 {
    if alpha >= OPAQUE {
        return u64::MAX;
    }
    // From the lowest digit of α up: OR with a fair coin takes p to (p + 1) / 2, AND to p / 2, for all
    // samples at once.
    (0..ALPHA_BITS).fold(0, |mask, digit| {
        let [low, high] = pcg2d([first, second.wrapping_add(digit)]);
        let coins = u64::from(low) | u64::from(high) << 32;
        if alpha >> digit & 1 == 1 { mask | coins } else { mask & coins }
    })
}

/// Random subsets of a pixel's samples, [`WIDTH`] of each size.
///
/// ST indexes its table by α and a random number. Subsets depend on α by their size alone, so this one is
/// indexed by the size: 65 rows instead of 1024, and ξ is no longer tied to the subset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaskTable {
    /// Row by row, a row for each size from 0 to the sample count.
    masks: Vec<u64>,
}

/// The table for so many samples, 1 to [`MOST_SAMPLES`]. Built on first use, within milliseconds; 1 MB for 64
/// samples.
///
/// # Panics
/// For another number of samples.
#[must_use]
pub fn mask_table(samples: u32) -> &'static MaskTable {
    static TABLES: [OnceLock<MaskTable>; MOST_SAMPLES as usize] = [const { OnceLock::new() }; 64];
    TABLES[samples as usize - 1].get_or_init(|| MaskTable::build(samples, 0))
}

impl MaskTable {
    /// A table that depends on its arguments alone.
    ///
    /// # Panics
    /// For less than 1 or more than [`MOST_SAMPLES`] samples.
    #[must_use]
    pub fn build(samples: u32, seed: u64) -> Self {
        assert!((1..=MOST_SAMPLES).contains(&samples), "{samples} samples have no mask of 64 bits");
        let mut masks = Vec::with_capacity((samples as usize + 1) * WIDTH);
        for size in 0..=samples {
            let mut random = Pcg32::new(seed, u64::from(samples * (MOST_SAMPLES + 1) + size));
            let mut order: Vec<u32> = (0..samples).collect();
            // One mask after the other from the circle of a random order, until it closes: so that in a table
            // as short as this, too, each sample is covered as often as any other, give or take one. Masks
            // drawn one by one would favour some by a hundredth.
            for index in 0..WIDTH {
                let start = index as u32 * size % samples;
                if start == 0 {
                    shuffle(&mut order, &mut random);
                }
                let run = (start..start + size).map(|index| 1 << order[(index % samples) as usize]);
                masks.push(run.fold(0, |mask, bit: u64| mask | bit));
            }
        }
        Self { masks }
    }

    /// A subset of `size` samples, chosen by random bits.
    ///
    /// # Panics
    /// If there are not so many samples.
    #[must_use]
    pub fn pick(&self, size: u32, bits: u32) -> u64 {
        // The high half of the product is uniform in 0..WIDTH (Lemire 2019).
        let column = (u64::from(bits) * WIDTH as u64) >> 32;
        self.masks[size as usize * WIDTH + column as usize]
    }

    /// All masks, row by row.
    #[must_use]
    pub fn masks(&self) -> &[u64] {
        &self.masks
    }
}

/// Shuffles in place, every order equally likely: the algorithm of Fisher and Yates.
fn shuffle(order: &mut [u32], random: &mut Pcg32) {
    for last in (1..order.len()).rev() {
        order.swap(last, random.below(last as u32 + 1) as usize);
    }
}

/// Columns and rows of pixels after which the curve of [`along_curve`] starts anew.
pub const CURVE_SIDE: u32 = 1024;

/// The index of a pixel along a Z-curve through [`CURVE_SIDE`]² pixels, in 20 bits (Morton 1966): pixels that
/// follow one another fill squares.
#[must_use]
pub const fn along_curve([x, y]: [u32; 2]) -> u32 {
    const fn spread(coordinate: u32) -> u32 {
        let mut bits = coordinate % CURVE_SIDE;
        bits = (bits | bits << 8) & 0x00ff_00ff;
        bits = (bits | bits << 4) & 0x0f0f_0f0f;
        bits = (bits | bits << 2) & 0x3333_3333;
        (bits | bits << 1) & 0x5555_5555
    }
    spread(x) | spread(y) << 1
}

/// Multipliers of the scramble of [`stratified_threshold`], even so that a digit changes higher ones only
/// (Laine and Karras 2011, section 3.1).
pub const SCRAMBLE: [u32; 4] = [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6];

/// The threshold, as a fraction of 2³², of the sample with an index along a curve through all samples of all
/// pixels (Laine and Karras 2011, section 3.1): among any 2^k samples that follow one another from a multiple
/// of 2^k, each 2^k-th of the range from 0 to 1 has one.
///
/// The mirrored index is scrambled by operations in which lower bits change higher ones only, so that each
/// digit of the threshold is flipped by all digits above it in the index. `surface` should be random: another
/// one gives independent thresholds.
#[must_use]
pub const fn stratified_threshold(index: u32, surface: u32) -> u32 {
    let mut x = index.reverse_bits().wrapping_add(surface);
    x ^= x.wrapping_mul(SCRAMBLE[0]);
    x ^= x.wrapping_mul(SCRAMBLE[1]);
    x ^= x.wrapping_mul(SCRAMBLE[2]);
    x ^ x.wrapping_mul(SCRAMBLE[3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::{fnv1a, pcg, pcg4d};

    /// Standard deviations by which a count of hits with a probability misses its mean.
    fn binomial_z(hits: u32, trials: u32, probability: f64) -> f64 {
        let trials = f64::from(trials);
        (f64::from(hits) - trials * probability) / (trials * probability * (1.0 - probability)).sqrt()
    }

    #[test]
    fn a_row_holds_subsets_of_its_size_that_favour_no_sample() {
        for samples in [1, 3, 4, 8, 16, 63, 64] {
            let table = mask_table(samples);
            assert_eq!(table.masks().len(), (samples as usize + 1) * WIDTH);
            for (size, row) in (0..).zip(table.masks().chunks(WIDTH)) {
                assert!(
                    row.iter()
                        .all(|mask| mask.count_ones() == size && u64::BITS - mask.leading_zeros() <= samples)
                );
                let counts: Vec<u32> = (0..samples)
                    .map(|sample| row.iter().map(|mask| (mask >> sample & 1) as u32).sum())
                    .collect();
                let (least, most) = counts
                    .iter()
                    .fold((u32::MAX, 0), |(least, most), &count| (least.min(count), most.max(count)));
                assert!(most - least <= 1, "{samples} samples, {size} of them: {counts:?}");
            }
        }
    }

    #[test]
    fn every_subset_of_a_few_samples_is_about_as_frequent() {
        // Masks of one order exclude one another, which spreads them a little more evenly than independent
        // ones.
        let table = mask_table(8);
        for size in 1..8 {
            let row = &table.masks()[size * WIDTH..][..WIDTH];
            let all = (0..=u64::from(u8::MAX)).filter(|mask| mask.count_ones() == size as u32);
            let choices = all.clone().count() as f64;
            for mask in all {
                let hits = row.iter().filter(|&&other| other == mask).count() as u32;
                let z = binomial_z(hits, WIDTH as u32, 1.0 / choices);
                assert!(z.abs() < 5.0, "{mask:#b}: {hits}, z {z}");
            }
        }
    }

    #[test]
    fn the_tables_are_those_all_pictures_were_made_with() {
        let hash = |samples| fnv1a(mask_table(samples).masks().iter().flat_map(|mask| mask.to_le_bytes()));
        assert_eq!(
            [4, 8, 64].map(hash),
            [0x5c7d_c5f3_9449_6d8f, 0xbae2_8dd7_08d3_91d8, 0xc4c9_3113_ecf9_dc6c]
        );
    }

    #[test]
    fn the_size_of_a_subset_is_alpha_times_the_samples_on_average() {
        for samples in [1, 4, 7, 64, 4096] {
            for alpha in [1, 10, 461, 512, 1023, OPAQUE] {
                let sizes: u32 = (0..OPAQUE).map(|xi| set_size(alpha, samples, xi)).sum();
                assert_eq!(sizes, alpha * samples);
            }
        }
    }

    #[test]
    fn ten_bits_of_alpha_are_right_on_average() {
        const TRIALS: u32 = 1 << 16;
        for alpha in [0.45, 0.010_1, 0.333, 0.999_9] {
            let exact = f64::from(alpha * OPAQUE as f32);
            let up =
                (0..TRIALS).filter(|&trial| f64::from(quantised_alpha(alpha, pcg(trial))) > exact).count();
            let z = binomial_z(up as u32, TRIALS, exact.fract());
            assert!(z.abs() < 4.0, "{alpha}: z {z}");
        }
        assert_eq!((quantised_alpha(0.0, u32::MAX), quantised_alpha(1.0, u32::MAX)), (0, OPAQUE));
        assert_eq!(quantised_alpha(0.25, 0x1234_5678), 256, "what ten bits hold stays as it is");
    }

    #[test]
    fn coins_cover_each_sample_with_its_probability_and_any_two_independently() {
        const TRIALS: u32 = 40_000;
        for alpha in [10, 461, 900] {
            let p = f64::from(alpha) / f64::from(OPAQUE);
            let masks: Vec<u64> = (0..TRIALS).map(|trial| coin_mask(alpha, [trial, pcg(trial)])).collect();
            let count = |bits: u64| masks.iter().filter(|mask| *mask & bits == bits).count() as u32;
            for sample in [0, 1, 31, 32, 63] {
                let z = binomial_z(count(1 << sample), TRIALS, p);
                assert!(z.abs() < 4.5, "{alpha}, sample {sample}: z {z}");
                let z = binomial_z(count(1 << sample | 1 << 7), TRIALS, p * p);
                assert!(z.abs() < 4.5, "{alpha}, samples {sample} and 7: z {z}");
            }
        }
        assert_eq!((coin_mask(0, [1, 2]), coin_mask(OPAQUE, [1, 2])), (0, u64::MAX));
    }

    #[test]
    fn the_curve_visits_each_pixel_once_square_by_square() {
        assert_eq!(
            [[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [1023, 1023]].map(along_curve),
            [0, 1, 2, 3, 4, (1 << 20) - 1]
        );
        let mut places: Vec<u32> = (0..1 << 12).map(|at| along_curve([at % 64, at / 64])).collect();
        places.sort_unstable();
        assert!(places.into_iter().eq(0..1 << 12));
    }

    #[test]
    fn successive_thresholds_have_one_in_each_stratum() {
        for surface in (0..50).map(pcg) {
            for bits in 0..8 {
                for start in [0, 3, 1000].map(|block: u32| block << bits) {
                    let mut strata: Vec<u32> = (start..start + (1 << bits))
                        .map(|place| (u64::from(stratified_threshold(place, surface)) << bits >> 32) as u32)
                        .collect();
                    strata.sort_unstable();
                    assert!(strata.into_iter().eq(0..1 << bits));
                }
            }
        }
    }

    #[test]
    fn thresholds_are_uniform_and_those_of_two_surfaces_independent() {
        // Pairs of thresholds at one place, in 8×8 cells: each as often as any other. Places far apart, and
        // many surfaces.
        const TRIALS: u32 = 1 << 17;
        let mut counts = [0_u32; 64];
        for trial in 0..TRIALS {
            let [place, _, one, two] = pcg4d([trial, 1, 2, 3]);
            let [a, b] = [one, two].map(|surface| stratified_threshold(place >> 6, surface) >> 29);
            counts[(a * 8 + b) as usize] += 1;
        }
        let expected = f64::from(TRIALS) / 64.0;
        let chi_square: f64 =
            counts.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
        let z = (chi_square - 63.0) / (2.0 * 63.0_f64).sqrt();
        assert!(z.abs() < 4.0, "z {z}");
    }

    #[test]
    fn two_surfaces_are_independent_within_one_frame() {
        // Of all pixels of a square, the share in which the first of four samples is covered by both of two
        // half-transparent surfaces.
        let share = |surfaces: [u32; 2]| {
            let both = (0..1 << 12).filter(|pixel| {
                surfaces.iter().all(|&surface| stratified_threshold(pixel << 2, surface) < 1 << 31)
            });
            both.count() as f64 / f64::from(1 << 12)
        };
        for pair in 0..50 {
            let both = share([pcg(2 * pair), pcg(2 * pair + 1)]);
            assert!((both - 0.25).abs() < 0.05, "{both}");
        }
        assert!((share([pcg(1); 2]) - 0.25).abs() > 0.2, "the check is blind");
    }
}
