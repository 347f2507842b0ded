//! A blue noise mask by void and cluster (Ulichney 1993), with a Gaussian of σ = 1.5 pixels.

use std::sync::OnceLock;

use crate::void_and_cluster::{Torus, rank_all};

/// Ulichney's choice for the Gaussian that measures crowding, in pixels.
pub(crate) const SIGMA_PX: f64 = 1.5;

/// Beyond this distance the Gaussian rounds to no energy at all.
pub(crate) const REACH_PX: i32 = 9;

/// A square mask that tiles without seams.
#[derive(Clone, Debug, PartialEq)]
pub struct BlueNoise {
    side: u32,
    ranks: Vec<u16>,
    values: Vec<f32>,
}

/// The 64×64 mask that the dithered methods share. Built on first use.
#[must_use]
pub fn blue_noise_64() -> &'static BlueNoise {
    static MASK: OnceLock<BlueNoise> = OnceLock::new();
    MASK.get_or_init(|| BlueNoise::build(64, 0))
}

impl BlueNoise {
    /// A mask of `side` × `side` pixels that depends on `seed` alone.
    ///
    /// # Panics
    /// If `side` is not a power of two from 2 to 256: wrapping is a bit mask, and ranks have 16 bits.
    #[must_use]
    pub fn build(side: u32, seed: u64) -> Self {
        assert!(side.is_power_of_two() && (2..=256).contains(&side), "a blue noise side of {side}");
        let ranks = rank_all(Torus { side, depth: 1 }, seed, REACH_PX, |dx, dy, dt| {
            if dt == 0 { gaussian(dx * dx + dy * dy) } else { 0.0 }
        });
        let count = ranks.len() as f32;
        let values = ranks.iter().map(|&rank| (f32::from(rank) + 0.5) / count).collect();
        Self { side, ranks, values }
    }

    /// Pixels on a side.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Each number from 0 to the pixel count less 1 once, row by row.
    #[must_use]
    pub fn ranks(&self) -> &[u16] {
        &self.ranks
    }

    /// (rank + 0.5) / pixel count, which lies inside (0, 1), row by row.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The value, inside (0, 1), at column `x` and row `y` of the plane tiled with the mask.
    #[must_use]
    pub fn value(&self, x: u32, y: u32) -> f32 {
        let wrap = self.side - 1;
        self.values[((y & wrap) * self.side + (x & wrap)) as usize]
    }
}

/// How much two pixels crowd one another, from the square of their distance.
pub(crate) fn gaussian(distance_squared: i32) -> f64 {
    (-f64::from(distance_squared) / (2.0 * SIGMA_PX * SIGMA_PX)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        hash::{Pcg32, fnv1a},
        spectrum::{LOW_FREQUENCY, low_frequency_share},
    };

    #[test]
    fn the_mask_lacks_low_frequencies() {
        let share = low_frequency_share(blue_noise_64().values(), 64, LOW_FREQUENCY);
        assert!(share < 0.05, "{share}");
    }

    #[test]
    fn white_noise_fails_the_same_test() {
        let mut random = Pcg32::new(5, 0);
        let white: Vec<f32> = (0..64 * 64).map(|_| random.next_f32()).collect();
        let share = low_frequency_share(&white, 64, LOW_FREQUENCY);
        assert!((0.8..1.25).contains(&share), "{share}");
    }

    #[test]
    fn thresholding_the_mask_lacks_low_frequencies_at_every_level() {
        for level in [0.1, 0.25, 0.5, 0.75, 0.9] {
            let dots: Vec<f32> =
                blue_noise_64().values().iter().map(|&v| if v < level { 1.0 } else { 0.0 }).collect();
            let share = low_frequency_share(&dots, 64, LOW_FREQUENCY);
            assert!(share < 0.2, "level {level}: {share}");
        }
    }

    #[test]
    fn every_rank_occurs_once_and_values_stay_inside_zero_and_one() {
        for side in [2, 16, 64] {
            let mask = BlueNoise::build(side, 1);
            let mut ranks = mask.ranks().to_vec();
            ranks.sort_unstable();
            assert!(ranks.iter().copied().eq(0..(side * side) as u16));
            assert!(mask.values().iter().all(|&value| 0.0 < value && value < 1.0));
        }
    }

    #[test]
    fn the_mask_tiles_and_depends_on_the_seed_alone() {
        let mask = BlueNoise::build(16, 3);
        assert_eq!(mask.value(5, 7), mask.values()[7 * 16 + 5]);
        assert_eq!(mask.value(5, 7), mask.value(5 + 16 * 9, 7 + 16));
        assert_eq!(mask, BlueNoise::build(16, 3));
        assert_ne!(mask, BlueNoise::build(16, 4));
    }

    #[test]
    fn the_table_is_the_one_all_pictures_were_made_with() {
        assert_eq!(
            fnv1a(blue_noise_64().ranks().iter().flat_map(|rank| rank.to_le_bytes())),
            0x661c_9c59_600d_2de5
        );
    }
}
