//! A spatio-temporal blue noise mask: Wolfe, Morrical, Akenine-Möller and Ramamoorthi, *Spatiotemporal Blue
//! Noise Masks*, 2022.
//!
//! Each frame is a blue noise mask of the plane, and each pixel runs through blue noise over the frames. So
//! two pixels crowd one another only if they share a frame or are the same pixel in two frames: a Gaussian of
//! their distance on the plane or in time, and void and cluster on the torus of both. Blue noise of three
//! dimensions would be blue in neither.

use std::sync::OnceLock;

use crate::{
    blue_noise::{REACH_PX, gaussian},
    void_and_cluster::{Torus, rank_all},
};

/// Columns and rows of the mask.
pub const SIDE: u32 = 64;

/// Frames of the mask, after which it repeats.
pub const FRAME_COUNT: u32 = 16;

/// Pixels of the mask over all of its frames: as many as 16-bit ranks tell apart.
pub const COUNT: u32 = SIDE * SIDE * FRAME_COUNT;

/// The mask's ranks, each number below [`COUNT`] once: frame by frame, row by row. Built on first use, within
/// a fraction of a second.
#[must_use]
pub fn spatio_temporal_ranks() -> &'static [u16] {
    static RANKS: OnceLock<Vec<u16>> = OnceLock::new();
    RANKS.get_or_init(|| {
        rank_all(Torus { side: SIDE, depth: FRAME_COUNT }, 0, REACH_PX, |dx, dy, dt| {
            if dt == 0 {
                gaussian(dx * dx + dy * dy)
            } else if (dx, dy) == (0, 0) {
                gaussian(dt * dt)
            } else {
                0.0
            }
        })
    })
}

/// (rank + 0.5) / [`COUNT`], which lies inside (0, 1), at a column and row of the plane and in a frame: the
/// mask tiles all three.
#[must_use]
pub fn value(ranks: &[u16], [x, y]: [u32; 2], frame: u32) -> f32 {
    let index = (frame % FRAME_COUNT * SIDE + y % SIDE) * SIDE + x % SIDE;
    (f32::from(ranks[index as usize]) + 0.5) / COUNT as f32
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::{
        hash::{Pcg32, fnv1a},
        spectrum::{LOW_FREQUENCY, low_frequency_share},
    };

    const PIXEL_COUNT: usize = (SIDE * SIDE) as usize;

    fn values() -> Vec<f32> {
        spatio_temporal_ranks().iter().map(|&rank| (f32::from(rank) + 0.5) / COUNT as f32).collect()
    }

    fn white() -> Vec<f32> {
        let mut random = Pcg32::new(6, 0);
        (0..COUNT).map(|_| random.next_f32()).collect()
    }

    /// Mean power over all pixels of one and two cycles in the mask's frames, relative to that of all
    /// frequencies but 0.
    fn slow_share(values: &[f32]) -> f64 {
        let frames = FRAME_COUNT as usize;
        let power: Vec<f64> = (1..=frames / 2)
            .map(|frequency| {
                let of_pixel = |pixel: usize| {
                    let (sin, cos) = (0..frames).fold((0.0, 0.0), |(sin, cos), frame| {
                        let angle = TAU * (frequency * frame) as f64 / frames as f64;
                        let value = f64::from(values[frame * PIXEL_COUNT + pixel]);
                        (sin + value * angle.sin(), cos + value * angle.cos())
                    });
                    sin * sin + cos * cos
                };
                (0..PIXEL_COUNT).step_by(7).map(of_pixel).sum()
            })
            .collect();
        (power[0] + power[1]) / 2.0 / (power.iter().sum::<f64>() / power.len() as f64)
    }

    #[test]
    fn every_rank_occurs_once() {
        let mut ranks = spatio_temporal_ranks().to_vec();
        ranks.sort_unstable();
        assert!(ranks.iter().copied().eq(0..=u16::MAX));
    }

    #[test]
    fn each_frame_lacks_low_frequencies_and_each_pixel_slow_ones() {
        let values = values();
        for frame in values.chunks(PIXEL_COUNT) {
            let share = low_frequency_share(frame, SIDE as usize, LOW_FREQUENCY);
            assert!(share < 0.1, "{share}");
        }
        let share = slow_share(&values);
        assert!(share < 0.3, "{share}");
    }

    #[test]
    fn white_noise_fails_the_same_tests() {
        let white = white();
        let share = low_frequency_share(&white[..PIXEL_COUNT], SIDE as usize, LOW_FREQUENCY);
        assert!((0.8..1.25).contains(&share), "{share}");
        let share = slow_share(&white);
        assert!((0.9..1.1).contains(&share), "{share}");
    }

    #[test]
    fn a_frame_and_a_pixel_are_covered_evenly_at_every_level() {
        // Standard deviation of how many of a pixel's frames lie below a level, against the binomial one of
        // white noise.
        let spread = |values: &[f32], level: f32| {
            let counts = (0..PIXEL_COUNT).map(|pixel| {
                (0..FRAME_COUNT as usize).filter(|frame| values[frame * PIXEL_COUNT + pixel] < level).count()
            });
            let mean = f64::from(level) * f64::from(FRAME_COUNT);
            let variance =
                counts.map(|count| (count as f64 - mean).powi(2)).sum::<f64>() / PIXEL_COUNT as f64;
            (variance / (mean * f64::from(1.0 - level))).sqrt()
        };
        let (values, white) = (values(), white());
        for level in [0.1, 0.25, 0.5, 0.75, 0.9] {
            for frame in values.chunks(PIXEL_COUNT) {
                let covered = frame.iter().filter(|&&value| value < level).count() as f32;
                assert!((covered / PIXEL_COUNT as f32 - level).abs() < 0.01, "level {level}: {covered}");
            }
            let (mask, control) = (spread(&values, level), spread(&white, level));
            assert!(mask < 0.7, "level {level}: {mask}");
            assert!((0.95..1.05).contains(&control), "level {level}: {control}");
        }
    }

    #[test]
    fn the_mask_tiles_the_plane_and_time() {
        let ranks = spatio_temporal_ranks();
        let at = |pixel, frame| value(ranks, pixel, frame);
        assert_eq!(at([5, 7], 3), values()[(3 * SIDE as usize + 7) * SIDE as usize + 5]);
        assert_eq!(at([5, 7], 3), at([5 + 9 * SIDE, 7 + SIDE], 3 + 100 * FRAME_COUNT));
    }

    #[test]
    fn the_table_is_the_one_all_pictures_were_made_with() {
        assert_eq!(
            fnv1a(spatio_temporal_ranks().iter().flat_map(|rank| rank.to_le_bytes())),
            0xc96f_0088_d358_470d
        );
    }
}
