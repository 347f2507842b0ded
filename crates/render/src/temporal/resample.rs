//! What techniques that reproject their history share: how it is looked up between pixels, and the colour
//! space in which it is held against new frames.

use glam::{UVec2, Vec2, Vec4};
use sheer_image::{Image, Region};

/// A place in a history: column and row of the pixel to its upper left, and the way from there, 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) column: i64,
    pub(super) row: i64,
    pub(super) share: Vec2,
}

impl Place {
    /// In the history of a region of a picture; `at` is in pixels of the picture, from the centre of its
    /// first one. `None` outside the region.
    pub(super) fn inside(region: Region, at: Vec2) -> Option<Self> {
        let first = UVec2::new(region.left, region.top).as_vec2() - 0.5;
        let end = UVec2::new(region.right(), region.bottom()).as_vec2() - 0.5;
        let is_inside = at.cmpgt(first).all() && at.cmplt(end).all();
        // The way from the pixel has the bits that it has in the whole picture.
        let low = at.floor();
        let (column, row) = (low.x as i64 - i64::from(region.left), low.y as i64 - i64::from(region.top));
        is_inside.then(|| Self { column, row, share: at - low })
    }

    /// The 4×4 pixels around; at the edges of the picture the nearest ones.
    pub(super) fn around<T>(self, image: &Image<T>) -> Around<'_, T> {
        let (width, height) = image.size();
        let inside = |at: i64, size: u32| at.clamp(0, i64::from(size) - 1) as usize;
        let columns = [-1, 0, 1, 2].map(|dx| inside(self.column + dx, width));
        let rows = [-1, 0, 1, 2].map(|dy| inside(self.row + dy, height) * width as usize);
        let pixels = image.as_slice();
        Around { pixels: rows.map(|row| columns.map(|column| &pixels[row + column])), share: self.share }
    }
}

/// The pixels around a place, row by row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around<'a, T> {
    pixels: [[&'a T; 4]; 4],
    share: Vec2,
}

impl<'a, T> Around<'a, T> {
    /// The four nearest pixels with their bilinear weights.
    pub(super) fn bilinear(&self) -> [(&'a T, f32); 4] {
        let Vec2 { x, y } = self.share;
        let [_, [_, upper_left, upper_right, _], [_, lower_left, lower_right, _], _] = self.pixels;
        [
            (upper_left, (1.0 - x) * (1.0 - y)),
            (upper_right, x * (1.0 - y)),
            (lower_left, (1.0 - x) * y),
            (lower_right, x * y),
        ]
    }

    /// Whether the place is a pixel's centre, so that this pixel alone counts.
    pub(super) fn is_centre(&self) -> bool {
        self.share == Vec2::ZERO
    }

    /// Whether all sixteen are so.
    pub(super) fn all(&self, is_so: impl Fn(&T) -> bool) -> bool {
        self.pixels.iter().flatten().all(|pixel| is_so(pixel))
    }

    /// The mean by Catmull and Rom's weights, which keep edges that bilinear lookups would blur a little more
    /// in every frame; each channel within the range of the four nearest pixels, so that nothing swings over.
    pub(super) fn sharp(&self, of: impl Fn(&T) -> Vec4) -> Vec4 {
        if self.is_centre() {
            return of(self.pixels[1][1]);
        }
        let (wx, wy) = (catmull_rom(self.share.x), catmull_rom(self.share.y));
        let values = self.pixels.map(|row| row.map(&of));
        let mut sum = Vec4::ZERO;
        for (row, wy) in values.iter().zip(wy) {
            for (&value, wx) in row.iter().zip(wx) {
                sum += value * (wx * wy);
            }
        }
        let [_, [_, a, b, _], [_, c, d, _], _] = values;
        sum.clamp(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
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
    fn a_history_of_a_region_is_looked_up_by_places_in_the_picture() {
        let whole = Image::from_fn(20, 10, |x, y| (x * x + 7 * y) as f32).unwrap();
        let region = Region { left: 6, top: 2, width: 9, height: 7 };
        let part = whole.cut(region).unwrap();
        for step in 0..40 {
            let at = Vec2::new(8.0, 4.0) + Vec2::new(0.1, 0.07) * step as f32;
            let [of_whole, of_part] =
                [(&whole, Region::whole([20, 10])), (&part, region)].map(|(image, region)| {
                    Place::inside(region, at).unwrap().around(image).sharp(|&value: &f32| Vec4::splat(value))
                });
            assert_eq!(of_whole, of_part, "{at}");
        }
        for outside in [[5.4, 4.0], [14.6, 4.0], [8.0, 1.4], [8.0, 8.6]] {
            assert!(Place::inside(region, outside.into()).is_none(), "{outside:?}");
        }
    }

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
            let at = Vec2::new(step as f32 * 0.1, 0.0);
            let place = Place::inside(Region::whole([8, 1]), at).unwrap();
            let value = place.around(&edge).sharp(|&value: &f32| Vec4::splat(value)).x;
            assert!((0.0..=1.0).contains(&value), "{value}");
        }
    }
}
