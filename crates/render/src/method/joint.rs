//! Joint dithering: the thresholds of STD, one a pixel for all its layers, held against the coverage they
//! accumulate. Our own answer to the first item of STD section 6: layers cannot mask one another, since there
//! is nothing to correlate.

use sheer_core::{bibliography, choice, hash::pcg2d, parameter::Values, threshold_map::threshold_index};

use super::static_noise::{MIDDLE_CONSTANT, NOISE_OF_ALL, Noise};
use crate::contract::{MethodInfo, Selection, ShaderConstant, Tables, Visitor};

choice! {
    /// What happens after the nine frames of the walk over the map.
    enum Cycle {
        /// The blue noise moves on by the golden ratio.
        Golden = "golden",
        /// The same nine thresholds again, as in STD.
        Still = "still",
    }
}

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "joint",
    title: "one dithered threshold a pixel against the coverage accumulated front to back; one shaded fragment a pixel",
    paper: "own; dithering after Brüll, Kern, Grosch (STD), section 3.3",
    works: &[&bibliography::STD],
    bias: "none; with cycle=still a layer's share of a still pixel stays off by up to a ninth, in the mean of all pixels it is right",
    parameters: &[
        Cycle::parameter(
            "cycle",
            Cycle::Golden,
            "move the blue noise by the golden ratio every nine frames, so that a still picture converges; or never, as STD",
        ),
        NOISE_OF_ALL,
    ],
    alignment_px: 3,
    constants: &[
        ShaderConstant::count("SHIFT_PX", SHIFT_PX),
        ShaderConstant::count("CYCLE_FRAMES", CYCLE_FRAMES),
        ShaderConstant::count("GOLDEN_RATIO_BITS", GOLDEN_RATIO_BITS),
        ShaderConstant::count("OFFSET_BITS", OFFSET_BITS),
        MIDDLE_CONSTANT,
    ],
    tables: &[],
};

/// Period of map and blue noise together, pixels.
const SHIFT_PX: u32 = 3 * 64;
/// Frames in which the walk over the map visits all nine strata.
const CYCLE_FRAMES: u32 = 9;
/// The golden ratio less 1 in 32 binary places: its multiples fill the circle evenly, however many there are.
const GOLDEN_RATIO_BITS: u32 = 0x9e37_79b9;
/// Binary places inside a stratum: with the stratum before the point they fill the 24 bits of an `f32`, so
/// that no threshold rounds to 1.
const OFFSET_BITS: u32 = 20;

/// Joint dithering with or without a moving blue noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Joint {
    cycle: Cycle,
    noise: Noise,
}

impl Joint {
    pub(super) fn new(values: &Values) -> Self {
        Self { cycle: values.choice("cycle"), noise: Noise::new(values) }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.selection(self)
    }
}

impl Selection for Joint {
    fn threshold(&self, pixel: [u32; 2], frame: u32, seed: u32, tables: &Tables) -> f32 {
        // Another seed moves the pattern over the screen. Any map would do, as there is nothing that it has
        // to differ from.
        let [shift_x, shift_y] = pcg2d([seed, 0]);
        let pixel = [pixel[0].wrapping_add(shift_x % SHIFT_PX), pixel[1].wrapping_add(shift_y % SHIFT_PX)];
        let stratum = threshold_index(&tables.std_maps[0], pixel, frame);
        let cycle = match self.cycle {
            Cycle::Golden => frame / CYCLE_FRAMES,
            Cycle::Still => 0,
        };
        let moved = cycle.wrapping_mul(GOLDEN_RATIO_BITS) >> (32 - OFFSET_BITS);
        let one = 1 << OFFSET_BITS;
        let offset = ((self.noise.of_all(pixel, tables) * one as f32) as u32 + moved) % one;
        (f32::from(stratum) + offset as f32 / one as f32) / 9.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cycle_of_nine_frames_meets_every_ninth_of_the_range_once() {
        let (joint, tables) = (Joint { cycle: Cycle::Golden, noise: Noise::Shared }, Tables::get());
        for (cycle, pixel) in [(0, [0, 0]), (1, [5, 7]), (1000, [63, 64]), (u32::MAX / 9 - 1, [1919, 1079])] {
            let mut strata: Vec<_> = (cycle * 9..cycle * 9 + 9)
                .map(|frame| (joint.threshold(pixel, frame, 3, &tables) * 9.0) as u32)
                .collect();
            strata.sort_unstable();
            assert_eq!(strata, [0, 1, 2, 3, 4, 5, 6, 7, 8], "cycle {cycle}, pixel {pixel:?}");
        }
    }

    #[test]
    fn the_thresholds_of_a_pixel_converge_to_uniform_and_do_not_when_the_blue_noise_stands_still() {
        let tables = Tables::get();
        // Star discrepancy of 89 cycles; the golden ratio's is of the order log n / n, on top of the ninths.
        let discrepancy = |cycle| {
            let count = 89 * 9;
            let joint = Joint { cycle, noise: Noise::Shared };
            let mut sorted: Vec<f32> =
                (0..count).map(|frame| joint.threshold([17, 40], frame, 0, &tables)).collect();
            sorted.sort_unstable_by(f32::total_cmp);
            let ranks = sorted.iter().zip(0_u16..);
            ranks.map(|(x, rank)| (x - f32::from(rank) / count as f32).abs()).fold(0.0, f32::max)
        };
        assert!(discrepancy(Cycle::Golden) < 0.004, "{}", discrepancy(Cycle::Golden));
        assert!(discrepancy(Cycle::Still) > 0.05, "the check is blind: {}", discrepancy(Cycle::Still));
    }

    #[test]
    fn no_threshold_reaches_one() {
        let (joint, tables) = (Joint { cycle: Cycle::Golden, noise: Noise::Shared }, Tables::get());
        for frame in 0..20_000 {
            let threshold = joint.threshold([frame % 64, frame / 64 % 64], frame, 0, &tables);
            assert!((0.0..1.0).contains(&threshold), "frame {frame}: {threshold}");
        }
    }
}
