//! Dither Temporal AA of Unreal Engine 4: thresholds from a 5×5 map that walks over the screen, the same for
//! all objects (STD section 2.2, Listing 1).

use sheer_core::{bibliography, parameter::Values};

use super::static_noise::{MIDDLE_CONSTANT, NOISE_OF_ALL, Noise};
use crate::contract::{BLUE_NOISE_SIDE, MethodInfo, ShaderConstant, Site, Tables, Threshold, Visitor};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "dtaa",
    title: "five thresholds dithered over space and time, one map for all objects; one shaded fragment a pixel",
    paper: "Epic Games, DitherTemporalAA; Brüll, Kern, Grosch (STD), section 2.2",
    works: &[&bibliography::EPIC_DITHER, &bibliography::STD],
    bias: "stacked layers share their thresholds: whatever is no more opaque than what lies before it is never seen",
    parameters: &[NOISE_OF_ALL],
    alignment_px: SIDE,
    constants: &[SIDE_CONSTANT, ShaderConstant::count("DTAA_PERIOD_PX", PERIOD_PX), MIDDLE_CONSTANT],
    tables: &[],
};

/// Rows and columns of the map, and how many thresholds it has.
pub(super) const SIDE: u32 = 5;
/// [`SIDE`] for the shaders of all methods that take the map.
pub(super) const SIDE_CONSTANT: ShaderConstant = ShaderConstant::count("DTAA_SIDE", SIDE);

/// Columns after which both the map and the blue noise repeat.
const PERIOD_PX: u32 = SIDE * BLUE_NOISE_SIDE;

/// Dither Temporal AA with or without its blue noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dtaa {
    noise: Noise,
}

impl Dtaa {
    pub(super) fn new(values: &Values) -> Self {
        Self { noise: Noise::new(values) }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }
}

impl Threshold for Dtaa {
    #[inline]
    fn threshold(&self, site: &Site, tables: &Tables) -> f32 {
        // The listing draws nothing at random. A seed moves the whole pattern sideways, seed 0 leaves it in
        // place.
        let [x, y] = site.pixel;
        let pixel = [x + site.seed % PERIOD_PX, y];
        threshold(stratum(pixel, site.frame), self.noise.of_all(pixel, tables))
    }
}

/// `stratify` of Listing 1, 0 to 4: the frame index is added to both coordinates, so that a pixel steps by 3
/// of 5 a frame.
#[inline]
pub(super) fn stratum(pixel: [u32; 2], frame: u32) -> u32 {
    let [x, y] = pixel.map(|coordinate| coordinate % SIDE + frame % SIDE);
    (x + 2 * y) % SIDE
}

/// The last line of Listing 1, with the blue noise of a pixel.
#[inline]
pub(super) fn threshold(stratum: u32, noise: f32) -> f32 {
    (stratum as f32 + noise) / SIDE as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_frame_shows_the_matrix_of_equation_4() {
        let printed = [[0, 1, 2, 3, 4], [2, 3, 4, 0, 1], [4, 0, 1, 2, 3], [1, 2, 3, 4, 0], [3, 4, 0, 1, 2]];
        for y in 0..10 {
            for x in 0..10 {
                assert_eq!(
                    stratum([x, y], 0),
                    printed[y as usize % 5][x as usize % 5],
                    "column {x}, row {y}"
                );
            }
        }
    }

    #[test]
    fn every_pixel_walks_through_all_five_thresholds_in_steps_of_three() {
        for pixel in [[0, 0], [3, 1], [959, 539], [u32::MAX, u32::MAX - 1]] {
            for first in [0, 5, 5 * 1_000_003] {
                let walk: Vec<u32> = (first..first + 5).map(|frame| stratum(pixel, frame)).collect();
                assert!(walk.windows(2).all(|pair| pair[1] == (pair[0] + 3) % 5), "{walk:?}");
            }
        }
    }
}
