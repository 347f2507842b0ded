//! All tables that shaders read, in one buffer of words: a shader holds none itself.

use sheer_core::{mask, threshold_map};
use sheer_render::contract::{self, BLUE_NOISE_SIDE, ShaderTable};
use sheer_scene::decode_tables;

use crate::shader::constant::{self, Constant};

/// First word of the maps of STD section 3.3, a threshold a word, map by map, row by row.
pub(crate) const TABLE_STD_MAPS: u32 = 0;
/// First word of the blue noise, the bits of a float a word, row by row.
pub(crate) const TABLE_BLUE_NOISE: u32 =
    TABLE_STD_MAPS + (threshold_map::MAP_COUNT * threshold_map::THRESHOLD_COUNT) as u32;
/// First word of the linear values of all bytes, the bits of a float a word: 256 of linear bytes, then 256 of
/// sRGB bytes.
pub(crate) const TABLE_DECODE: u32 = TABLE_BLUE_NOISE + BLUE_NOISE_SIDE * BLUE_NOISE_SIDE;
/// First word of what not every shader needs: the tables of the method, then masks.
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
}

impl Tables {
    /// The most samples of a mask: on the GPU it is one word.
    pub(crate) const MOST_MASK_SAMPLES: u32 = u32::BITS;

    /// What all shaders need; then the tables of a method, and of masks those of so many samples and, where
    /// these are drawn in several rounds, of as many rounds; none for 0.
    pub(crate) fn new(of_method: &[ShaderTable], [mask_samples, rounds]: [u32; 2]) -> Self {
        debug_assert!(
            mask_samples.max(rounds) <= Self::MOST_MASK_SAMPLES,
            "{mask_samples} samples or {rounds} rounds are no word"
        );
        let tables = contract::Tables::get();
        let maps = tables.std_maps.iter().flatten().copied().map(u32::from);
        let blue_noise = tables.blue_noise.iter().map(|value| value.to_bits());
        let decode = decode_tables().iter().flatten().map(|value| value.to_bits());
        let mut words: Vec<u32> = maps.chain(blue_noise).chain(decode).collect();
        debug_assert_eq!(words.len(), TABLE_REST as usize, "each table begins where the last one ends");
        of_method.iter().for_each(|table| words.extend((table.words)()));

        let masks = words.len() as u32;
        let mut add_masks = |samples: u32| {
            if samples > 0 {
                words.extend(mask::mask_table(samples).masks().iter().map(|mask| *mask as u32));
            }
            words.len() as u32
        };
        let round_masks = add_masks(mask_samples);
        add_masks(rounds);
        Self { words, mask_samples, masks, round_masks }
    }

    /// Where the masks begin, and their samples; the offsets of the tables of all shaders are among all
    /// shaders' constants. Without masks they are the same for all methods, whatever tables these have: so
    /// that a shader that shades is the same text for all of them, which drivers compile once.
    pub(crate) fn constants(&self) -> String {
        let [masks, round_masks] =
            if self.mask_samples > 0 { [self.masks, self.round_masks] } else { [TABLE_REST; 2] };
        constant::text(&[
            Constant::new("MASK_SAMPLES", self.mask_samples),
            Constant::new("TABLE_MASKS", masks),
            Constant::new("TABLE_ROUND_MASKS", round_masks),
        ])
    }
}

/// Where each of the tables of a method begins.
pub(crate) fn of_method(tables: &[ShaderTable]) -> Vec<Constant> {
    let mut first = TABLE_REST;
    let mut constants = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        constants.push(Constant::new(table.name, first));
        // The last table need not be built to know where it begins.
        if index + 1 < tables.len() {
            first += (table.words)().len() as u32;
        }
    }
    constants
}

#[cfg(test)]
mod tests {
    use sheer_core::colour::linear_from_srgb;

    use super::*;

    #[test]
    fn each_table_lies_where_its_constant_says() {
        let of_method = [
            ShaderTable { name: "TABLE_SQUARES", words: || vec![0, 1, 4, 9] },
            ShaderTable { name: "TABLE_CUBES", words: || vec![0, 1, 8] },
        ];
        let tables = Tables::new(&of_method, [8, 3]);
        let at = |first: u32, index: u32| tables.words[(first + index) as usize];
        assert_eq!(at(TABLE_STD_MAPS, 9 * 17 + 4), u32::from(threshold_map::std_maps()[17][4]));
        let noise = contract::Tables::get().blue_noise_at([3, 2]);
        assert_eq!(f32::from_bits(at(TABLE_BLUE_NOISE, 64 * 2 + 3)), noise);
        assert_eq!(f32::from_bits(at(TABLE_DECODE, 51)), 0.2);
        assert_eq!(f32::from_bits(at(TABLE_DECODE, 256 + 51)), linear_from_srgb(0.2));
        let [squares, cubes] = [TABLE_REST, TABLE_REST + 4];
        let named = [Constant::new("TABLE_SQUARES", squares), Constant::new("TABLE_CUBES", cubes)];
        assert_eq!(super::of_method(&of_method), named);
        assert_eq!([at(squares, 3), at(cubes, 2)], [9, 8]);
        assert_eq!(u64::from(at(tables.masks, 2047 * 3 + 11)), mask::mask_table(8).masks()[2047 * 3 + 11]);
        assert_eq!(u64::from(at(tables.round_masks, 2047 + 5)), mask::mask_table(3).masks()[2047 + 5]);
    }

    #[test]
    fn tables_of_a_method_change_no_constant_of_the_shaders_that_shade() {
        let table = ShaderTable { name: "TABLE_ONE", words: || vec![1] };
        assert_eq!(Tables::new(&[table], [0, 0]).constants(), Tables::new(&[], [0, 0]).constants());
    }
}
