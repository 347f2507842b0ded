//! The alpha channel of a texture and its levels, as the any-hit test reads it, which asks for alpha far more
//! often than anything asks for colour.
//!
//! All levels lie in one list of bytes. Rows and columns go on by one texel where the texture is wrapped, so
//! that the four texels of a lookup are two pairs of neighbours, and only the first has to be brought inside.
//! Lookups have the bits of the plain evaluation (`Sampler::level_alpha`), which stays for what is rare:
//! mirrored textures, whose pairs run both ways, and coordinates of millions of texels.

use glam::Vec2;

use super::mip_chain::MipChain;
use crate::model::{Filter, Wrap};

/// The alpha channel of all levels of a texture.
#[derive(Clone, Debug)]
pub(super) struct AlphaMap {
    levels: Vec<AlphaLevel>,
    texels: Vec<u8>,
}

/// One level.
#[derive(Clone, Copy, Debug)]
struct AlphaLevel {
    /// Width and height, texels.
    size: Vec2,
    /// Of columns and of rows.
    axes: [Axis; 2],
    /// Index of its first texel.
    start: usize,
    /// Texels from row to row.
    stride: usize,
}

/// How a texel's index is brought inside along one axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// What is added: the column, or row, before the image is stored where its edge goes on for ever.
    first: i32,
    /// The last index of a first texel, after that.
    last: i32,
    /// Bits that are kept before: all, or those of a tile that is a power of two long.
    mask: i32,
    /// The length of any other tile; 0 if there is none.
    tile: i32,
}

/// 1.5 × 2^23: a number that is added to it is rounded to a whole one, in its low bits.
const MAGIC: f32 = 12_582_912.0;
/// Below this magnitude that is right.
const LIMIT: f32 = (1 << 22) as f32;

impl AlphaMap {
    /// The map of a chain; none for a texture that is mirrored.
    pub(super) fn new(chain: &MipChain, wrap: [Wrap; 2]) -> Option<Self> {
        if wrap.contains(&Wrap::MirroredRepeat) {
            return None;
        }
        let mut map = Self { levels: Vec::new(), texels: Vec::new() };
        for level in chain.levels() {
            let [columns, rows] = [0, 1].map(|axis| Axis::new(level.size[axis], wrap[axis]));
            let [width, height] = level.size;
            let stride = columns.stored();
            map.levels.push(AlphaLevel {
                size: Vec2::new(width as f32, height as f32),
                axes: [columns, rows],
                start: map.texels.len(),
                stride,
            });
            let texels = level.texels.as_slice();
            for row in 0..rows.stored() {
                let row = rows.texel(row, height) * width;
                map.texels.extend((0..stride).map(|column| texels[row + columns.texel(column, width)][3]));
            }
        }
        Some(map)
    }

    /// Bytes of the map of an image with its levels, at most, for each of its texels: a third more for the
    /// levels, and what is added at their edges.
    pub(super) const TEXEL_BYTES: u64 = 2;

    /// Alpha at a point of a level, 0 to 1; none where the plain evaluation has to be asked.
    #[inline(always)]
    pub(super) fn at(&self, level: u32, uv: Vec2, filter: Filter) -> Option<f32> {
        let level = &self.levels[level as usize];
        let place = uv * level.size - if filter == Filter::Linear { 0.5 } else { 0.0 };
        if !(place.x.abs() < LIMIT && place.y.abs() < LIMIT) {
            return None;
        }
        let ((column, mut fx), (row, mut fy)) = (split(place.x), split(place.y));
        if filter == Filter::Nearest {
            (fx, fy) = (0.0, 0.0);
        }
        let first = level.start + level.axes[1].inside(row) * level.stride + level.axes[0].inside(column);
        let pair = |at: usize| {
            let [left, right] = [self.texels[at], self.texels[at + 1]].map(f32::from);
            left + (right - left) * fx
        };
        let (upper, lower) = (pair(first), pair(first + level.stride));
        Some((upper + (lower - upper) * fy) * (1.0 / 255.0))
    }
}

/// The next lower whole number, and how far above it a number below [`LIMIT`] is.
#[inline(always)]
fn split(value: f32) -> (i32, f32) {
    let rounded = value + MAGIC;
    let nearest = rounded - MAGIC;
    let is_above = nearest > value;
    let whole = (rounded.to_bits() as i32).wrapping_sub(MAGIC.to_bits() as i32) - i32::from(is_above);
    let low = if is_above { nearest - 1.0 } else { nearest };
    (whole, value - low)
}

impl Axis {
    fn new(size: usize, wrap: Wrap) -> Self {
        let size = size as i32;
        match wrap {
            // From the texel before the image to its last.
            Wrap::ClampToEdge => Self { first: 1, last: size, mask: -1, tile: 0 },
            Wrap::Repeat | Wrap::MirroredRepeat if size.count_ones() == 1 => {
                Self { first: 0, last: size - 1, mask: size - 1, tile: 0 }
            }
            Wrap::Repeat | Wrap::MirroredRepeat => Self { first: 0, last: size - 1, mask: -1, tile: size },
        }
    }

    /// How many columns, or rows, are stored: the neighbour of the last one, too.
    fn stored(&self) -> usize {
        self.last as usize + 2
    }

    /// The texel of the image that is stored in a column, or a row.
    fn texel(&self, stored: usize, size: usize) -> usize {
        match self.first {
            0 => stored % size,
            _ => stored.saturating_sub(1).min(size - 1),
        }
    }

    /// The column, or row, of any texel that is the first of two.
    #[inline(always)]
    fn inside(&self, texel: i32) -> usize {
        let outside = self.tile != 0 && !(0..self.tile).contains(&texel);
        let texel = if outside { texel.rem_euclid(self.tile) } else { texel };
        ((texel & self.mask) + self.first).clamp(0, self.last) as usize
    }
}
