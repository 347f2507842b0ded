//! A blue noise mask by void and cluster: Ulichney, *The void-and-cluster method for dither array
//! generation*, 1993.
//!
//! Pixels are ranked so that, for every threshold, those below it are spread evenly without a grid. Where the
//! paper leaves a choice it is fixed here: a Gaussian of σ = 1.5 pixels on the torus, and the lower index
//! among equals. Energies are whole numbers, so that adding and taking away pixels is exact and every machine
//! builds the same mask. Updating them around the changed pixel alone makes a 64×64 mask in tens of
//! milliseconds.

use std::sync::OnceLock;

use crate::hash::Pcg32;

/// Ulichney's choice for the Gaussian that measures crowding, in pixels.
const SIGMA_PX: f64 = 1.5;

/// Beyond this distance the Gaussian is less than one unit of [`ENERGY_ONE`].
const KERNEL_RADIUS_PX: i32 = 9;

/// The energy of a pixel at its own place. All of a full mask, 2πσ² = 14.1 times this, still fits 32 bits.
const ENERGY_ONE: f64 = (1_u32 << 24) as f64;

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
        let ranks = rank_all(side, seed);
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

/// A pattern of set pixels and how crowded each pixel is by them.
struct Pattern {
    side: i32,
    kernel: Vec<(i32, i32, u32)>,
    set: Vec<bool>,
    energy: Vec<u32>,
}

impl Pattern {
    fn empty(side: u32) -> Self {
        let count = (side * side) as usize;
        let reach = -KERNEL_RADIUS_PX..=KERNEL_RADIUS_PX;
        let kernel = reach
            .clone()
            .flat_map(|dy| reach.clone().map(move |dx| (dx, dy)))
            .map(|(dx, dy)| {
                let distance_squared = f64::from(dx * dx + dy * dy);
                let gaussian = (-distance_squared / (2.0 * SIGMA_PX * SIGMA_PX)).exp();
                (dx, dy, (gaussian * ENERGY_ONE).round() as u32)
            })
            .filter(|&(_, _, energy)| energy > 0)
            .collect();
        Self { side: side as i32, kernel, set: vec![false; count], energy: vec![0; count] }
    }

    fn toggle(&mut self, index: usize) {
        let adds = !self.set[index];
        self.set[index] = adds;
        let (x, y, wrap) = (index as i32 % self.side, index as i32 / self.side, self.side - 1);
        for &(dx, dy, energy) in &self.kernel {
            let at = (((y + dy) & wrap) * self.side + ((x + dx) & wrap)) as usize;
            if adds {
                self.energy[at] += energy;
            } else {
                self.energy[at] -= energy;
            }
        }
    }

    /// The most crowded set pixel, the first among equals.
    fn tightest_cluster(&self) -> usize {
        self.first_minimum(|index| self.set[index].then(|| u32::MAX - self.energy[index]))
    }

    /// The least crowded unset pixel, the first among equals.
    fn largest_void(&self) -> usize {
        self.first_minimum(|index| (!self.set[index]).then(|| self.energy[index]))
    }

    fn first_minimum(&self, key: impl Fn(usize) -> Option<u32>) -> usize {
        (0..self.set.len())
            .filter_map(|index| key(index).map(|key| (key, index)))
            .min()
            .expect("a pattern being ranked has both set and unset pixels")
            .1
    }
}

fn rank_all(side: u32, seed: u64) -> Vec<u16> {
    let count = side * side;
    let mut pattern = Pattern::empty(side);

    // Initial pattern: a tenth of the pixels at random, then moved from clusters to voids until nothing
    // moves.
    let first_count = (count / 10).max(1);
    let mut random = Pcg32::new(seed, 0);
    let mut missing = first_count;
    while missing > 0 {
        let index = random.below(count) as usize;
        if !pattern.set[index] {
            pattern.toggle(index);
            missing -= 1;
        }
    }
    loop {
        let cluster = pattern.tightest_cluster();
        pattern.toggle(cluster);
        let void = pattern.largest_void();
        pattern.toggle(void);
        if void == cluster {
            break;
        }
    }

    // Phase 1: the ranks of the initial pattern, by taking away the tightest cluster.
    let mut ranks = vec![0_u16; count as usize];
    let initial: Vec<usize> = (0..count as usize).filter(|&index| pattern.set[index]).collect();
    for rank in (0..first_count).rev() {
        let cluster = pattern.tightest_cluster();
        pattern.toggle(cluster);
        ranks[cluster] = rank as u16;
    }
    initial.into_iter().for_each(|index| pattern.toggle(index));

    // Phases 2 and 3: fill the largest void. Ulichney's third phase takes the tightest cluster of the unset
    // pixels, which is the same pixel: on a torus the energies of set and unset pixels add up to a constant.
    for rank in first_count..count {
        let void = pattern.largest_void();
        pattern.toggle(void);
        ranks[void] = rank as u16;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::hash::fnv1a;

    /// Mean power of the frequencies up to `limit` cycles per pixel, relative to that of all frequencies but
    /// 0.
    fn low_frequency_share(values: &[f32], side: usize, limit: f64) -> f64 {
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
        let wave: Vec<(f64, f64)> =
            (0..side).map(|k| (TAU * k as f64 / side as f64).sin_cos()).map(|(s, c)| (c, -s)).collect();
        // One discrete Fourier transform along x, one along y; 64 pixels need no faster one.
        let transform = |input: &dyn Fn(usize) -> (f64, f64), frequency: usize| {
            (0..side).fold((0.0, 0.0), |(re, im), i| {
                let ((a, b), (c, d)) = (input(i), wave[frequency * i % side]);
                (re + a * c - b * d, im + a * d + b * c)
            })
        };
        let rows: Vec<(f64, f64)> = (0..side * side)
            .map(|i| transform(&|x| (f64::from(values[i / side * side + x]) - mean, 0.0), i % side))
            .collect();
        let (mut low, mut all) = ((0.0, 0), (0.0, 0));
        for (fx, fy) in (0..side * side).map(|i| (i % side, i / side)).skip(1) {
            let (re, im) = transform(&|y| rows[y * side + fx], fy);
            let power = re * re + im * im;
            let cycles = |f: usize| f.min(side - f) as f64 / side as f64;
            if cycles(fx).hypot(cycles(fy)) <= limit {
                low = (low.0 + power, low.1 + 1);
            }
            all = (all.0 + power, all.1 + 1);
        }
        (low.0 / f64::from(low.1)) / (all.0 / f64::from(all.1))
    }

    /// Cycles per pixel below which the eye sees structure at a glance; the mask's energy peaks near 0.5.
    const LOW_FREQUENCY: f64 = 0.15;

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
