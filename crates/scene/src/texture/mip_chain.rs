//! The levels of a texture: each half as wide and high as the one before, down to a single texel (Williams
//! 1983, *Pyramidal Parametrics*).
//!
//! A texel of a level is the mean of the image below it, in linear light. Levels are made from the numbers of
//! the level before, not from its bytes, so that rounding does not add up; they are stored in the encoding of
//! the image. Sizes are rounded down, and a texel of a level that was rounded covers a little more than two
//! texels a side: its weights are those of the polyphase box (Guthe and Heckbert 2005).

use std::sync::{Arc, OnceLock};

use glam::{Vec3, Vec4};
use sheer_core::colour::linear_from_srgb;
use sheer_image::Image;

use super::decoding::decode_tables;

/// What a texture's alpha is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum AlphaUse {
    /// Nothing: a channel like any other.
    None,
    /// Opacity: what is nothing has no colour.
    Blend,
    /// The same, tested against a least value, which is above 0 and at most 1.
    Test {
        /// The least alpha of the texture that counts as opaque.
        cutoff: f32,
    },
}

/// An image with its levels.
#[derive(Clone, Debug)]
pub struct MipChain {
    levels: Vec<Level>,
}

/// One level of a chain.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    pub(super) texels: Arc<Image<[u8; 4]>>,
    /// Width and height, texels.
    pub(super) size: [usize; 2],
}

/// A level that is being made: linear colour times weight, and weight; alpha beside it.
struct Sums {
    size: [usize; 2],
    texels: Vec<(Vec4, f32)>,
}

/// The texels of a level, along one axis, that a texel of the next covers, and their weights, which sum up to
/// one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Taps {
    first: usize,
    weights: [f32; 3],
    count: usize,
}

/// The weight of what is nothing, beside that of alpha: it decides the colour only where all is nothing, so
/// that a lookup between texels does not meet black there. A sixteenth of the least alpha that a byte holds.
const LEAST_WEIGHT: f32 = 1.0 / (16.0 * 255.0);

impl MipChain {
    /// The image as it is.
    pub(crate) fn of_one(image: &Arc<Image<[u8; 4]>>) -> Self {
        Self { levels: vec![Level::new(Arc::clone(image))] }
    }

    /// All levels of an image; `srgb`: its colours are sRGB-encoded.
    pub(crate) fn new(image: &Arc<Image<[u8; 4]>>, srgb: bool, alpha_use: AlphaUse) -> Self {
        let mut chain = Self::of_one(image);
        let mut size = chain.levels[0].size;
        let mut last: Option<Sums> = None;
        while size != [1, 1] {
            // The image itself is never held as sums, which take eight times its memory.
            let sums = match &last {
                None => Sums::half_of_image(image, srgb, alpha_use),
                Some(last) => last.halved(),
            };
            size = sums.size;
            let scale = match alpha_use {
                AlphaUse::None | AlphaUse::Blend => 1.0,
                AlphaUse::Test { cutoff } => sums.coverage_scale(cutoff, chain.levels[0].coverage(cutoff)),
            };
            chain.levels.push(Level::new(Arc::new(sums.encoded(srgb, scale))));
            last = Some(sums);
        }
        chain
    }

    pub(crate) fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The image, then its levels.
    pub fn images(&self) -> impl ExactSizeIterator<Item = &Image<[u8; 4]>> {
        self.levels.iter().map(|level| &*level.texels)
    }
}

impl Level {
    fn new(texels: Arc<Image<[u8; 4]>>) -> Self {
        Self { size: [texels.width() as usize, texels.height() as usize], texels }
    }

    /// Share of the texels whose alpha passes a test.
    fn coverage(&self, cutoff: f32) -> f32 {
        let texels = self.texels.as_slice();
        let passing = texels.iter().filter(|texel| f32::from(texel[3]) >= cutoff * 255.0).count();
        passing as f32 / texels.len() as f32
    }
}

impl Taps {
    /// Of texel `index` in the half of a level that is `size` texels long.
    fn new(index: usize, size: usize) -> Self {
        let half = half(size);
        if size == 1 {
            return Self { first: 0, weights: [1.0, 0.0, 0.0], count: 1 };
        }
        if size == 2 * half {
            return Self { first: 2 * index, weights: [0.5, 0.5, 0.0], count: 2 };
        }
        // The texel covers 2 + 1 / half texels, from index · (2 + 1 / half) on.
        let weights = [half - index, half, index + 1].map(|part| part as f32 / size as f32);
        Self { first: 2 * index, weights, count: 3 }
    }
}

/// The length of the next level.
fn half(size: usize) -> usize {
    (size / 2).max(1)
}

impl Sums {
    /// The level below an image.
    fn half_of_image(image: &Image<[u8; 4]>, srgb: bool, alpha_use: AlphaUse) -> Self {
        let decode = &decode_tables()[usize::from(srgb)];
        let texels = image.as_slice();
        let texel = |at: usize| {
            let [r, g, b, a] = texels[at];
            let alpha = f32::from(a) / 255.0;
            let weight = if alpha_use == AlphaUse::None { 1.0 } else { alpha + LEAST_WEIGHT };
            let rgb = Vec3::from_array([r, g, b].map(|byte| decode[usize::from(byte)]));
            ((rgb * weight).extend(weight), alpha)
        };
        Self::half_of([image.width() as usize, image.height() as usize], texel)
    }

    /// The next level.
    fn halved(&self) -> Self {
        Self::half_of(self.size, |at| self.texels[at])
    }

    /// The level below one of a size, of which `texel` gives colour times weight, weight, and alpha.
    fn half_of([width, height]: [usize; 2], texel: impl Fn(usize) -> (Vec4, f32)) -> Self {
        let size = [half(width), half(height)];
        let columns: Vec<Taps> = (0..size[0]).map(|x| Taps::new(x, width)).collect();
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        for row in (0..size[1]).map(|y| Taps::new(y, height)) {
            for column in &columns {
                let mut sum = (Vec4::ZERO, 0.0);
                for y in 0..row.count {
                    let first = (row.first + y) * width + column.first;
                    for (at, column_weight) in (first..first + column.count).zip(column.weights) {
                        let weight = row.weights[y] * column_weight;
                        let (colour, alpha) = texel(at);
                        sum.0 += weight * colour;
                        sum.1 += weight * alpha;
                    }
                }
                texels.push(sum);
            }
        }
        Self { size, texels }
    }

    /// The factor on alpha with which as large a share of the texels passes a test as of the image (Castaño
    /// 2010, *Computing Alpha Mipmaps*): means gather around the middle, so that what is thin would vanish.
    fn coverage_scale(&self, cutoff: f32, coverage: f32) -> f32 {
        let wanted = (coverage * self.texels.len() as f32).round() as usize;
        let passing = self.texels.iter().filter(|texel| texel.1 >= cutoff).count();
        if passing == wanted {
            return 1.0;
        }
        let mut alphas: Vec<f32> = self.texels.iter().map(|texel| texel.1).collect();
        alphas.sort_unstable_by(|a, b| b.total_cmp(a));
        // Halfway between the last that shall pass and the first that shall not: rounding moves neither over.
        let last = wanted.checked_sub(1).map_or(1.0 + 1.0 / 255.0, |last| alphas[last]);
        let next = alphas.get(wanted).copied().unwrap_or(0.0);
        cutoff / (0.5 * (last + next)).max(LEAST_WEIGHT)
    }

    /// The level in the encoding of the image.
    fn encoded(&self, srgb: bool, alpha_scale: f32) -> Image<[u8; 4]> {
        let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let colour = |value: f32| if srgb { srgb_byte(value) } else { byte(value) };
        let [width, height] = self.size;
        Image::from_fn(width as u32, height as u32, |x, y| {
            let (weighted, alpha) = self.texels[y as usize * width + x as usize];
            let [r, g, b] = (weighted.truncate() / weighted.w).to_array().map(colour);
            [r, g, b, byte(alpha * alpha_scale)]
        })
        .expect("a level is smaller than its image")
    }
}

/// How many cells the table of [`srgb_byte`] divides linear light into: no more than one byte ends in each.
const CELLS: usize = 4096;

/// The byte that is nearest to a linear value in its encoding, without the power that takes as long as all
/// the rest of a texel.
fn srgb_byte(linear: f32) -> u8 {
    /// The byte of the beginning of each cell, and the linear value at which each byte ends.
    static TABLES: OnceLock<([u8; CELLS + 1], [f32; 256])> = OnceLock::new();
    let (bytes, ends) = TABLES.get_or_init(|| {
        let end = |byte: usize| linear_from_srgb((byte as f32 + 0.5) / 255.0);
        let ends: [f32; 256] = std::array::from_fn(end);
        let of_cell = |cell: usize| {
            let start = cell as f32 / CELLS as f32;
            ends[..255].partition_point(|end| *end <= start) as u8
        };
        (std::array::from_fn(of_cell), ends)
    });
    let linear = linear.clamp(0.0, 1.0);
    let byte = bytes[(linear * CELLS as f32) as usize];
    byte + u8::from(byte < 255 && linear >= ends[usize::from(byte)])
}

#[cfg(test)]
mod tests {
    use sheer_core::{
        colour::srgb_from_linear,
        hash::{pcg3d, unit_from_bits},
    };

    use super::*;

    fn chain(width: u32, height: u32, alpha_use: AlphaUse, texel: impl Fn(u32, u32) -> [u8; 4]) -> MipChain {
        MipChain::new(&Arc::new(Image::from_fn(width, height, texel).unwrap()), true, alpha_use)
    }

    #[test]
    fn the_table_encodes_as_the_curve_does() {
        for step in 0..=50_000_u16 {
            let linear = f32::from(step) / 50_000.0;
            let exact = srgb_from_linear(linear) * 255.0;
            let byte = f32::from(srgb_byte(linear));
            assert!((byte - exact).abs() <= 0.501, "{linear}: {byte} for {exact}");
        }
        for byte in 0..=255 {
            assert_eq!(srgb_byte(linear_from_srgb(f32::from(byte) / 255.0)), byte);
        }
    }

    #[test]
    fn every_level_of_any_size_has_the_mean_of_the_image() {
        for [width, height] in [[64, 64], [37, 5], [1, 9], [100, 3], [2, 1], [31, 63]] {
            // A ramp: a texel that is left out or counted twice would show.
            let image = |x: u32, y: u32| [(x * 255 / width) as u8, (y * 255 / height) as u8, 40, 255];
            let chain = chain(width, height, AlphaUse::None, image);
            let mean = |level: &Level| {
                let sum: Vec3 = level
                    .texels
                    .as_slice()
                    .iter()
                    .map(|[r, g, b, _]| {
                        Vec3::from_array([r, g, b].map(|byte| decode_tables()[1][usize::from(*byte)]))
                    })
                    .sum();
                sum / level.texels.as_slice().len() as f32
            };
            let whole = mean(&chain.levels[0]);
            for level in &chain.levels {
                assert!((mean(level) - whole).abs().max_element() < 0.004, "{:?}", level.size);
            }
            let sizes: Vec<_> = chain.levels.iter().map(|level| level.size).collect();
            assert_eq!(sizes.last(), Some(&[1, 1]));
            assert!(sizes.windows(2).all(|pair| pair[1] == pair[0].map(half)), "{sizes:?}");
        }
    }

    #[test]
    fn weights_of_any_size_sum_up_to_one_and_take_all_texels_alike() {
        for size in 1..40 {
            let mut taken = vec![0.0; size];
            for index in 0..half(size) {
                let taps = Taps::new(index, size);
                assert!((taps.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
                (0..taps.count).for_each(|tap| taken[taps.first + tap] += taps.weights[tap]);
            }
            let share = half(size) as f32 / size as f32;
            assert!(taken.iter().all(|weight: &f32| (weight - share).abs() < 1e-6), "{size}: {taken:?}");
        }
    }

    #[test]
    fn what_is_nothing_does_not_darken_what_is_there() {
        let red_on_black = |x: u32, y: u32| if (x + y).is_multiple_of(4) { [255, 0, 0, 255] } else { [0; 4] };
        let chain = chain(32, 32, AlphaUse::Blend, red_on_black);
        for level in &chain.levels[2..] {
            for [r, g, b, a] in level.texels.as_slice() {
                assert!(*r >= 253 && *g == 0 && *b == 0 && (63..=65).contains(a), "{r} {g} {b} {a}");
            }
        }
        let clear =
            MipChain::new(&Arc::new(Image::filled(4, 4, [10, 20, 30, 0]).unwrap()), true, AlphaUse::Blend);
        assert_eq!(clear.levels[2].texels.as_slice(), [[10, 20, 30, 0]]);
    }

    #[test]
    fn alpha_tested_levels_keep_the_coverage_of_the_image() {
        // Blades one texel wide, a third of them above the cutoff: most of their means are below it.
        let blades = |x: u32, _: u32| {
            let random = unit_from_bits(pcg3d([x, 1, 2])[0]);
            [0, 255, 0, (255.0 * random * random) as u8]
        };
        let cutoff = 0.5;
        let tested = chain(256, 256, AlphaUse::Test { cutoff }, blades);
        let plain = chain(256, 256, AlphaUse::Blend, blades);
        let whole = tested.levels[0].coverage(cutoff);
        for (tested, plain) in tested.levels[1..6].iter().zip(&plain.levels[1..6]) {
            let [kept, lost] = [tested, plain].map(|level| (level.coverage(cutoff) - whole).abs());
            // A column of the level is the least that can change.
            assert!(kept <= 1.0 / tested.size[0] as f32, "{:?}: {kept}", tested.size);
            assert!(tested.size[0] > 32 || lost > 2.0 * kept, "{:?}: {lost}, {kept}", tested.size);
        }
    }
}
