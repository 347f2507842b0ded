//! Texture lookup: bilinear in linear light, with the alpha channel kept apart for the any-hit test.

use std::sync::{Arc, OnceLock};

use glam::{Vec2, Vec4};
use sheer_core::colour::linear_from_srgb;
use sheer_image::Image;

use crate::model::{Filter, Texture, Wrap};

/// A texture ready for lookups.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    image: Arc<Image<[u8; 4]>>,
    /// For each texel its alpha and those of the texels right of it, below it, and below right: most lookups are any-hit tests, and so
    /// each is one load. Empty where a lookup cannot be one, or nobody asks.
    alpha: Vec<[u8; 4]>,
    decode: &'static [f32; 256],
    /// Width and height, texels.
    size: [usize; 2],
    wrap: [Wrap; 2],
    filter: Filter,
}

/// Linear values of all bytes, sRGB-encoded or not.
fn decode_tables() -> &'static [[f32; 256]; 2] {
    static TABLES: OnceLock<[[f32; 256]; 2]> = OnceLock::new();
    TABLES.get_or_init(|| {
        let byte = |index: usize| index as f32 / 255.0;
        [std::array::from_fn(byte), std::array::from_fn(|index| linear_from_srgb(byte(index)))]
    })
}

/// The alpha of each texel with that of its neighbours to the right and below, as the texture wraps.
fn packed_alpha(texture: &Texture) -> Vec<[u8; 4]> {
    let image = &texture.image;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let next = |at: usize, size: usize, wrap: Wrap| match wrap {
        Wrap::ClampToEdge => (at + 1).min(size - 1),
        Wrap::Repeat | Wrap::MirroredRepeat => (at + 1) % size,
    };
    let alpha = |x: usize, y: usize| image.as_slice()[y * width + x][3];
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pack = |(x, y)| {
        let (right, below) = (next(x, width, texture.wrap[0]), next(y, height, texture.wrap[1]));
        [alpha(x, y), alpha(right, y), alpha(x, below), alpha(right, below)]
    };
    texels.map(pack).collect()
}

/// The texel left of a lookup, wrapped into the image, and the weight of its right neighbour.
#[inline]
fn place(coordinate: f32, size: usize, wrap: Wrap) -> (usize, f32) {
    let mut position = coordinate * size as f32 - 0.5;
    if wrap == Wrap::ClampToEdge {
        position = position.clamp(0.0, (size - 1) as f32);
    }
    let low = floor(position);
    (wrapped(low, size, wrap), position - low as f32)
}

/// The two texels on either side of a lookup, wrapped into the image, and the weight of the second.
#[inline]
fn neighbours(coordinate: f32, size: usize, wrap: Wrap, filter: Filter) -> ([usize; 2], f32) {
    let position = coordinate * size as f32;
    match filter {
        Filter::Nearest => {
            let texel = wrapped(floor(position), size, wrap);
            ([texel, texel], 0.0)
        }
        Filter::Linear => {
            let low = floor(position - 0.5);
            let texels = [wrapped(low, size, wrap), wrapped(low.wrapping_add(1), size, wrap)];
            (texels, position - 0.5 - low as f32)
        }
    }
}

/// Any texel index as one inside the image.
#[inline]
fn wrapped(texel: i32, size: usize, wrap: Wrap) -> usize {
    let size_i = size as i32;
    // Nearly all lookups fall inside, and a division costs as much as the rest of the lookup.
    if (texel as u32) < size as u32 {
        return texel as usize;
    }
    let inside = match wrap {
        Wrap::Repeat if size.is_power_of_two() => texel & (size_i - 1),
        Wrap::Repeat => texel.rem_euclid(size_i),
        Wrap::ClampToEdge => texel.clamp(0, size_i - 1),
        Wrap::MirroredRepeat => {
            let turn = texel.rem_euclid(size_i.saturating_mul(2));
            if turn < size_i { turn } else { 2 * size_i - 1 - turn }
        }
    };
    inside as usize
}

/// The next lower whole number, without the library call that `f32::floor` is on a plain x86-64.
#[inline]
fn floor(value: f32) -> i32 {
    let truncated = value as i32;
    truncated.wrapping_sub(i32::from((truncated as f32) > value))
}

impl Sampler {
    /// `tested`: the texture's alpha decides whether rays hit.
    pub(crate) fn new(texture: &Texture, tested: bool) -> Self {
        let size = [texture.image.width() as usize, texture.image.height() as usize];
        let packs =
            tested && texture.filter == Filter::Linear && !texture.wrap.contains(&Wrap::MirroredRepeat);
        Self {
            alpha: if packs { packed_alpha(texture) } else { Vec::new() },
            image: Arc::clone(&texture.image),
            size,
            decode: &decode_tables()[usize::from(texture.srgb)],
            wrap: texture.wrap,
            filter: texture.filter,
        }
    }

    /// Linear straight RGBA.
    pub(crate) fn sample(&self, uv: Vec2) -> Vec4 {
        let texels = self.image.as_slice();
        let ([a, b, c, d], [fx, fy]) = self.footprint(uv);
        let texel = |index: usize| {
            let [r, g, b, a] = texels[index].map(usize::from);
            Vec4::new(self.decode[r], self.decode[g], self.decode[b], a as f32 / 255.0)
        };
        texel(a).lerp(texel(b), fx).lerp(texel(c).lerp(texel(d), fx), fy)
    }

    /// Alpha, 0 to 1: [`Self::sample`]'s, within rounding.
    #[inline]
    pub(crate) fn sample_alpha(&self, uv: Vec2) -> f32 {
        if self.alpha.is_empty() {
            return self.sample(uv).w;
        }
        let [width, height] = self.size;
        let (column, fx) = place(uv.x, width, self.wrap[0]);
        let (row, fy) = place(uv.y, height, self.wrap[1]);
        let [a, b, c, d] = self.alpha[row * width + column].map(f32::from);
        let upper = a + (b - a) * fx;
        let lower = c + (d - c) * fx;
        (upper + (lower - upper) * fy) * (1.0 / 255.0)
    }

    /// The four texels around a place, row by row, and the weights of the right and the lower ones.
    #[inline]
    fn footprint(&self, uv: Vec2) -> ([usize; 4], [f32; 2]) {
        let [width, height] = self.size;
        let ([left, right], fx) = neighbours(uv.x, width, self.wrap[0], self.filter);
        let ([top, bottom], fy) = neighbours(uv.y, height, self.wrap[1], self.filter);
        let (top, bottom) = (top * width, bottom * width);
        ([top + left, top + right, bottom + left, bottom + right], [fx, fy])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampler(wrap: Wrap, filter: Filter) -> Sampler {
        let texel = |x: u32, y: u32| [255, 255, 255, (37 * x + 101 * y) as u8];
        let image = Arc::new(Image::from_fn(5, 4, texel).unwrap());
        let texture = Texture { name: String::new(), image, srgb: true, wrap: [wrap; 2], filter };
        Sampler::new(&texture, true)
    }

    #[test]
    fn both_lookups_agree_on_alpha() {
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            for filter in [Filter::Linear, Filter::Nearest] {
                let sampler = sampler(wrap, filter);
                for step in -400..400 {
                    let uv = Vec2::new(step as f32 * 0.0071, step as f32 * 0.0033 + 0.4);
                    let (whole, alone) = (sampler.sample(uv).w, sampler.sample_alpha(uv));
                    assert!((whole - alone).abs() < 1e-5, "{wrap:?} {filter:?} at {uv}: {whole}, {alone}");
                }
            }
        }
    }

    #[test]
    fn wrapping_holds_tiles_or_mirrors_the_edge() {
        let at = |wrap, u| {
            let alpha = sampler(wrap, Filter::Nearest).sample_alpha(Vec2::new(u, 0.0));
            (alpha * 255.0 / 37.0).round() as u32
        };
        assert_eq!(at(Wrap::ClampToEdge, 7.0), 4);
        assert_eq!(at(Wrap::Repeat, 1.3), 1);
        assert_eq!(at(Wrap::MirroredRepeat, 1.3), 3);
        assert_eq!(at(Wrap::Repeat, -0.1), 4);
    }

    #[test]
    fn absurd_coordinates_stay_inside() {
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            for u in [f32::NAN, f32::INFINITY, -1e30, 1e30] {
                let _ = sampler(wrap, Filter::Linear).sample(Vec2::new(u, u));
            }
        }
    }
}
