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
    /// The alpha channel alone: a quarter of the memory traffic where most lookups happen.
    alpha: Vec<u8>,
    decode: &'static [f32; 256],
    /// Width and height, texels.
    size: [usize; 2],
    wrap: [Wrap; 2],
    filter: Filter,
}

/// Linear values of all bytes: first of those that are linear, then of those that are sRGB-encoded.
#[must_use]
pub fn decode_tables() -> &'static [[f32; 256]; 2] {
    static TABLES: OnceLock<[[f32; 256]; 2]> = OnceLock::new();
    TABLES.get_or_init(|| {
        let byte = |index: usize| index as f32 / 255.0;
        [std::array::from_fn(byte), std::array::from_fn(|index| linear_from_srgb(byte(index)))]
    })
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
    pub(crate) fn new(texture: &Texture) -> Self {
        Self {
            alpha: texture.image.as_slice().iter().map(|texel| texel[3]).collect(),
            image: Arc::clone(&texture.image),
            size: [texture.image.width() as usize, texture.image.height() as usize],
            decode: &decode_tables()[usize::from(texture.srgb)],
            wrap: texture.wrap,
            filter: texture.filter,
        }
    }

    /// Colour and alpha at a point: linear, not multiplied.
    pub(crate) fn sample(&self, uv: Vec2) -> Vec4 {
        let texels = self.image.as_slice();
        let ([a, b, c, d], [fx, fy]) = self.footprint(uv);
        let texel = |index: usize| {
            let [r, g, b, a] = texels[index].map(usize::from);
            Vec4::new(self.decode[r], self.decode[g], self.decode[b], a as f32 / 255.0)
        };
        texel(a).lerp(texel(b), fx).lerp(texel(c).lerp(texel(d), fx), fy)
    }

    /// Alpha, 0 to 1.
    #[inline]
    pub(crate) fn sample_alpha(&self, uv: Vec2) -> f32 {
        let ([a, b, c, d], [fx, fy]) = self.footprint(uv);
        let texel = |index: usize| f32::from(self.alpha[index]);
        let upper = texel(a) + (texel(b) - texel(a)) * fx;
        let lower = texel(c) + (texel(d) - texel(c)) * fx;
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
        let image =
            Image::from_fn(2, 1, |x, _| if x == 0 { [0, 0, 0, 0] } else { [255, 255, 255, 255] }).unwrap();
        Sampler::new(&Texture {
            name: String::new(),
            image: Arc::new(image),
            srgb: true,
            wrap: [wrap; 2],
            filter,
        })
    }

    #[test]
    fn both_lookups_agree_on_alpha() {
        let sampler = sampler(Wrap::Repeat, Filter::Linear);
        for step in -40..40 {
            let uv = Vec2::new(step as f32 * 0.07, 0.3);
            assert!((sampler.sample(uv).w - sampler.sample_alpha(uv)).abs() < 1e-6);
        }
    }

    #[test]
    fn wrapping_holds_tiles_or_mirrors_the_edge() {
        let at = |wrap, u| sampler(wrap, Filter::Nearest).sample_alpha(Vec2::new(u, 0.0));
        assert_eq!(at(Wrap::ClampToEdge, 7.0), 1.0);
        assert_eq!(at(Wrap::Repeat, 1.2), 0.0);
        assert_eq!(at(Wrap::MirroredRepeat, 1.2), 1.0);
        assert_eq!(at(Wrap::Repeat, -0.2), 1.0);
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
