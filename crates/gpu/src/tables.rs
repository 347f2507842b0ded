//! All tables that shaders read, in one buffer of words: a shader holds none itself.

use sheer_core::{mask, spatio_temporal::spatio_temporal_ranks, threshold_map};
use sheer_render::{
    contract::{self, BLUE_NOISE_SIDE},
    method::{dtaa, dtaa_unique},
};
use sheer_scene::decode_tables;

use crate::shader::constant::{self, Constant};

/// First word of the maps of STD section 3.3, a threshold a word, map by map, row by row.
pub(crate) const TABLE_STD_MAPS: u32 = 0;
/// First word of the blue noise, the bits of a float a word, row by row.
pub(crate) const TABLE_BLUE_NOISE: u32 =
    TABLE_STD_MAPS + (threshold_map::MAP_COUNT * threshold_map::THRESHOLD_COUNT) as u32;
/// First word of the permutations of `dtaa-unique`, a threshold a word.
pub(crate) const TABLE_PERMUTATIONS: u32 = TABLE_BLUE_NOISE + BLUE_NOISE_SIDE * BLUE_NOISE_SIDE;
/// First word of the linear values of all bytes, the bits of a float a word: 256 of linear bytes, then 256 of sRGB bytes.
pub(crate) const TABLE_DECODE: u32 = TABLE_PERMUTATIONS + dtaa_unique::PERMUTATION_COUNT as u32 * dtaa::SIDE;
/// First word of what not every shader needs.
const TABLE_REST: u32 = TABLE_DECODE + 512;

/// The words of all tables.
#[derive(Clone, Debug)]
pub(crate) struct Tables {
    pub(crate) words: Vec<u32>,
    mask_samples: u32,
    /// First word of the masks.
    masks: u32,
    /// First word of the masks over rounds.
    round_masks: u32,
    /// First word of the spatio-temporal ranks; without them past the end, where a shader reads nothing of use.
    ranks: u32,
}

impl Tables {
    /// The most samples of a mask: on the GPU it is one word.
    pub(crate) const MOST_MASK_SAMPLES: u32 = u32::BITS;

    /// The tables, those of the method `stbn` only if it needs them, for they take long to build, and of masks those of so many samples and,
    /// where these are drawn in several rounds, of as many rounds; none for 0.
    pub(crate) fn new(method_needs_stbn: bool, [mask_samples, rounds]: [u32; 2]) -> Self {
        debug_assert!(
            mask_samples.max(rounds) <= Self::MOST_MASK_SAMPLES,
            "{mask_samples} samples or {rounds} rounds are no word"
        );
        let tables = contract::Tables::get();
        let maps = tables.std_maps.iter().flatten().copied().map(u32::from);
        let blue_noise = tables.blue_noise.iter().map(|value| value.to_bits());
        let permutations = dtaa_unique::PERMUTATIONS.iter().flatten().copied().map(u32::from);
        let decode = decode_tables().iter().flatten().map(|value| value.to_bits());
        let mut words: Vec<u32> = maps.chain(blue_noise).chain(permutations).chain(decode).collect();
        debug_assert_eq!(words.len(), TABLE_REST as usize, "each table begins where the last one ends");

        let masks = words.len() as u32;
        let mut add_masks = |samples: u32| {
            if samples > 0 {
                words.extend(mask::mask_table(samples).masks().iter().map(|mask| *mask as u32));
            }
            words.len() as u32
        };
        let round_masks = add_masks(mask_samples);
        let ranks = add_masks(rounds);
        if method_needs_stbn {
            words.extend(spatio_temporal_ranks().iter().copied().map(u32::from));
        }
        Self { words, mask_samples, masks, round_masks, ranks }
    }

    /// Where the tables begin that not all shaders need, and the samples of a mask; the offsets of the others are among all shaders' constants.
    pub(crate) fn constants(&self) -> String {
        constant::text(&[
            Constant::new("MASK_SAMPLES", self.mask_samples),
            Constant::new("TABLE_MASKS", self.masks),
            Constant::new("TABLE_ROUND_MASKS", self.round_masks),
            Constant::new("TABLE_RANKS", self.ranks),
        ])
    }
}

#[cfg(test)]
mod tests {
    use sheer_core::colour::linear_from_srgb;

    use super::*;

    #[test]
    fn each_table_lies_where_its_constant_says() {
        let tables = Tables::new(true, [8, 3]);
        let at = |first: u32, index: u32| tables.words[(first + index) as usize];
        assert_eq!(at(TABLE_STD_MAPS, 9 * 17 + 4), u32::from(threshold_map::std_maps()[17][4]));
        let noise = contract::Tables::get().blue_noise_at([3, 2]);
        assert_eq!(f32::from_bits(at(TABLE_BLUE_NOISE, 64 * 2 + 3)), noise);
        assert_eq!(at(TABLE_PERMUTATIONS, 5 * 119 + 1), u32::from(dtaa_unique::PERMUTATIONS[119][1]));
        assert_eq!(f32::from_bits(at(TABLE_DECODE, 51)), 0.2);
        assert_eq!(f32::from_bits(at(TABLE_DECODE, 256 + 51)), linear_from_srgb(0.2));
        assert_eq!(u64::from(at(tables.masks, 2047 * 3 + 11)), mask::mask_table(8).masks()[2047 * 3 + 11]);
        assert_eq!(u64::from(at(tables.round_masks, 2047 + 5)), mask::mask_table(3).masks()[2047 + 5]);
        assert_eq!(at(tables.ranks, 12_345), u32::from(spatio_temporal_ranks()[12_345]));
        assert_eq!(tables.words.len() as u32, tables.ranks + sheer_core::spatio_temporal::COUNT);
    }
}
