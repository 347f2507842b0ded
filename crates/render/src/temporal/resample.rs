//! What techniques that reproject their history share: how it is looked up between pixels, and the colour
//! space in which it is held against new frames.

use glam::{Vec2, Vec4};
use sheer_image::Image;

/// A place in a history, pixels (origin at the first pixel's centre): the pixel to its upper left, and the
/// way from there, 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) column: i64,
    pub(super) row: i64,
    pub(super) share: Vec2,
}

impl Place {
    /// `None` outside a picture of this width and height.
    pub(super) fn inside((width, height): (u32, u32), at: Vec2) -> Option<Self> {
        let is_inside = at.x > -0.5 && at.y > -0.5 && at.x < width as f32 - 0.5 && at.y < height as f32 - 0.5;
        let low = at.floor();
        is_inside.then(|| Self { column: low.x as i64, row: low.y as i64, share: at - low })
    }

    /// The pixel at an offset; at the edges the nearest one.
    pub(super) fn pixel<T>(self, image: &Image<T>, dx: i64, dy: i64) -> &T {
        image.get_clamped(self.column + dx, self.row + dy)
    }

    /// The four pixels around with their bilinear weights.
    pub(super) fn bilinear(self) -> [((i64, i64), f32); 4] {
        let Vec2 { x, y } = self.share;
        [((0, 0), (1.0 - x) * (1.0 - y)), ((1, 0), x * (1.0 - y)), ((0, 1), (1.0 - x) * y), ((1, 1), x * y)]
    }

    /// The mean by Catmull and Rom's weights, which keep edges that bilinear lookups would blur a little more
    /// in every frame; each channel within the range of the four pixels around, so that nothing swings over.
    pub(super) fn sharp<T>(self, image: &Image<T>, of: impl Fn(&T) -> Vec4) -> Vec4 {
        let texel = |dx, dy| of(self.pixel(image, dx, dy));
        if self.share == Vec2::ZERO {
            return texel(0, 0);
        }
        let (wx, wy) = (catmull_rom(self.share.x), catmull_rom(self.share.y));
        let mut sum = Vec4::ZERO;
        let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        for (dy, wy) in (-1..).zip(wy) {
            for (dx, wx) in (-1..).zip(wx) {
                let value = texel(dx, dy);
                sum += value * (wx * wy);
                if (0..2).contains(&dx) && (0..2).contains(&dy) {
                    (low, high) = (low.min(value), high.max(value));
                }
            }
        }
        sum.clamp(low, high)
    }
}

/// Weights of the four samples around a point at `s` between the middle two.
fn catmull_rom(s: f32) -> [f32; 4] {
    let (s2, s3) = (s * s, s * s * s);
    [
        0.5 * (-s3 + 2.0 * s2 - s),
        0.5 * (3.0 * s3 - 5.0 * s2 + 2.0),
        0.5 * (-3.0 * s3 + 4.0 * s2 + s),
        0.5 * (s3 - s2),
    ]
}

/// Luma, two differences of colour, and alpha: of linear premultiplied RGBA. Linear, so that means are means.
pub(super) fn ycocga_from_rgba(rgba: [f32; 4]) -> Vec4 {
    let [r, g, b, a] = rgba;
    Vec4::new(0.25 * r + 0.5 * g + 0.25 * b, 0.5 * (r - b), -0.25 * r + 0.5 * g - 0.25 * b, a)
}

/// The same back.
pub(super) fn rgba_from_ycocga(ycocga: Vec4) -> [f32; 4] {
    let [y, co, cg, a] = ycocga.to_array();
    [y + co - cg, y + cg, y - co - cg, a]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_come_back() {
        let rgba = [0.2, 0.9, 3.0, 0.5];
        let back = rgba_from_ycocga(ycocga_from_rgba(rgba));
        assert!((Vec4::from(back) - Vec4::from(rgba)).abs().max_element() < 1e-6);
    }

    #[test]
    fn catmull_rom_weights_sum_to_one_and_interpolate() {
        for step in 0..=10 {
            assert!((catmull_rom(step as f32 / 10.0).iter().sum::<f32>() - 1.0).abs() < 1e-6);
        }
        assert_eq!(catmull_rom(0.0), [0.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn nothing_swings_over_at_an_edge() {
        let edge = Image::from_fn(8, 1, |x, _| if x < 4 { 0.0 } else { 1.0 }).unwrap();
        for step in 0..70 {
            let place = Place::inside(edge.size(), Vec2::new(step as f32 * 0.1, 0.0)).unwrap();
            let value = place.sharp(&edge, |&value: &f32| Vec4::splat(value)).x;
            assert!((0.0..=1.0).contains(&value), "{value}");
        }
    }
}
