//! Procedural textures: tiling noise, and images made of height, colour, roughness and occlusion at once.

use std::{f32::consts::FRAC_1_SQRT_2, sync::LazyLock};

use glam::{IVec2, Vec2, Vec3};
use sheer_core::{
    colour::srgb_from_linear,
    hash::{pcg3d, unit_from_bits},
};
use sheer_image::Image;

/// A surface at one point of a texture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Texel {
    /// Linear colour, not multiplied by alpha.
    pub(crate) colour: Vec3,
    /// Opacity or cut-out, 0 to 1.
    pub(crate) alpha: f32,
    /// Height in units of the texture's edge; its slope becomes the normal map.
    pub(crate) height: f32,
    /// Perceptual roughness, 0 to 1.
    pub(crate) roughness: f32,
    /// Share of the environment's light that gets here, 0 to 1.
    pub(crate) occlusion: f32,
}

impl Texel {
    pub(crate) fn matt(colour: Vec3) -> Self {
        Self { colour, alpha: 1.0, height: 0.0, roughness: 0.9, occlusion: 1.0 }
    }
}

/// The images of a painted surface.
pub(crate) struct Painting {
    /// sRGB colour and straight alpha.
    pub(crate) colour: Image<[u8; 4]>,
    /// Tangent-space normals (+Y up, glTF).
    pub(crate) normal: Image<[u8; 4]>,
    /// Occlusion in red, roughness in green, metallic (none) in blue.
    pub(crate) surface: Image<[u8; 4]>,
}

/// Paints a square tiling texture; `texel` is asked at points of the unit square, origin in the upper left
/// corner.
pub(crate) fn paint(size: u32, texel: impl Fn(Vec2) -> Texel + Sync) -> Painting {
    let at = |x: u32, y: u32| texel((Vec2::new(x as f32, y as f32) + 0.5) / size as f32);
    let texels = Image::par_from_fn(size, size, at).expect("small");
    let colour = texels.map(|texel| colour_bytes(texel.colour, texel.alpha));
    let surface = texels.map(|texel| [byte(texel.occlusion), byte(texel.roughness), 0, 255]);
    let normal = Image::from_fn(size, size, |x, y| {
        let height = |dx: u32, dy: u32| texels[((x + dx) % size, (y + dy) % size)].height;
        // Central differences over two texels of 1/size each; v runs downwards, the bitangent up.
        let slope = Vec2::new(height(1, 0) - height(size - 1, 0), height(0, size - 1) - height(0, 1))
            * (0.5 * size as f32);
        let normal = Vec3::new(-slope.x, -slope.y, 1.0).normalize() * 0.5 + 0.5;
        [byte(normal.x), byte(normal.y), byte(normal.z), 255]
    });
    Painting { colour, normal: normal.expect("small"), surface }
}

/// Paints colour and alpha alone.
pub(crate) fn paint_colour(size: u32, texel: impl Fn(Vec2) -> (Vec3, f32) + Sync) -> Image<[u8; 4]> {
    Image::par_from_fn(size, size, |x, y| {
        let (colour, alpha) = texel((Vec2::new(x as f32, y as f32) + 0.5) / size as f32);
        colour_bytes(colour, alpha)
    })
    .expect("small")
}

fn colour_bytes(linear: Vec3, alpha: f32) -> [u8; 4] {
    let [r, g, b] = linear.to_array().map(srgb_byte);
    [r, g, b, byte(alpha)]
}

/// The byte that stands for a linear value, by its definition.
fn srgb_byte_exactly(linear: f32) -> u8 {
    byte(srgb_from_linear(linear.clamp(0.0, 1.0)))
}

/// The same byte without a power for each texel: the byte at the lower end of a step of values, counted on
/// while the value reaches what the next byte begins with.
fn srgb_byte(linear: f32) -> u8 {
    /// Steps of values: so many that none holds the beginnings of two bytes, even where the curve is
    /// steepest.
    const STEP_COUNT: usize = 4096;
    struct Table {
        /// The byte at the lower end of each step.
        byte: Vec<u8>,
        /// The least value of each byte after 0.
        begins: Vec<f32>,
    }
    static TABLE: LazyLock<Table> = LazyLock::new(|| Table {
        byte: (0..=STEP_COUNT).map(|step| srgb_byte_exactly(step as f32 / STEP_COUNT as f32)).collect(),
        begins: (1..=255)
            .map(|wanted| {
                // Positive floats are in the order of their bits.
                let (mut below, mut reached) = (0, 1.0_f32.to_bits());
                while reached - below > 1 {
                    let middle = below + (reached - below) / 2;
                    if srgb_byte_exactly(f32::from_bits(middle)) < wanted {
                        below = middle;
                    } else {
                        reached = middle;
                    }
                }
                f32::from_bits(reached)
            })
            .collect(),
    });
    let value = linear.clamp(0.0, 1.0);
    let table = &*TABLE;
    let mut byte = table.byte[(value * STEP_COUNT as f32) as usize];
    while table.begins.get(usize::from(byte)).is_some_and(|&begin| value >= begin) {
        byte += 1;
    }
    byte
}

fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Sixteen unit vectors around the circle: as good as any angle, and quicker to come by.
const DIRECTIONS: [[f32; 2]; 16] = {
    const C: f32 = 0.923_879_5;
    const H: f32 = FRAC_1_SQRT_2;
    const S: f32 = 0.382_683_43;
    [
        [1.0, 0.0],
        [C, S],
        [H, H],
        [S, C],
        [0.0, 1.0],
        [-S, C],
        [-H, H],
        [-C, S],
        [-1.0, 0.0],
        [-C, -S],
        [-H, -H],
        [-S, -C],
        [0.0, -1.0],
        [S, -C],
        [H, -H],
        [C, -S],
    ]
};

/// Noise that repeats after a whole number of lattice cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    pub(crate) seed: u32,
}

/// What cellular noise has at a point (see [`Noise::cells`]).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Distance to the nearest feature point, in cells.
    pub(crate) nearest: f32,
    /// Distance to the border with the second nearest, in cells.
    pub(crate) border: f32,
    /// 0 to 1, one value a cell.
    pub(crate) id: f32,
}

impl Noise {
    /// Gradient noise (Perlin 2002) in about -1 to 1 at `p` in cells, repeating after `period` cells.
    pub(crate) fn gradient(self, p: Vec2, period: IVec2) -> f32 {
        let cell = floor(p);
        let f = p - cell.as_vec2();
        let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
        // The four corners share what wrapping costs.
        let low = wrapped(cell, period);
        let high = wrapped(low + 1, period);
        let corner = |x: i32, y: i32, dx: f32, dy: f32| {
            let direction = self.hash(IVec2::new(x, y), 0) >> 28;
            Vec2::from_array(DIRECTIONS[direction as usize]).dot(f - Vec2::new(dx, dy))
        };
        let [upper_left, upper_right] = [corner(low.x, low.y, 0.0, 0.0), corner(high.x, low.y, 1.0, 0.0)];
        let [lower_left, lower_right] = [corner(low.x, high.y, 0.0, 1.0), corner(high.x, high.y, 1.0, 1.0)];
        let top = upper_left + (upper_right - upper_left) * fade.x;
        let bottom = lower_left + (lower_right - lower_left) * fade.x;
        1.6 * (top + (bottom - top) * fade.y)
    }

    /// Octaves of gradient noise, each of half the size and half the strength, over the unit square of `uv`;
    /// about -1 to 1.
    pub(crate) fn fractal(self, uv: Vec2, cell_count: IVec2, octave_count: u32) -> f32 {
        let mut sum = 0.0;
        for octave in 0..octave_count {
            let period = cell_count * (1 << octave);
            let layer = Self { seed: self.seed ^ (octave.wrapping_mul(0x9e37_79b9)) };
            sum += layer.gradient(uv * period.as_vec2(), period) / (1 << octave) as f32;
        }
        sum * 0.65
    }

    /// Cellular noise (Worley 1996) with feature points moved from the middles of their cells by up to
    /// `jitter`/2 cells.
    pub(crate) fn cells(self, p: Vec2, period: IVec2, jitter: f32) -> Cell {
        let cell = floor(p);
        let mut best = (f32::MAX, Vec2::ZERO, 0.0);
        let mut found = [Vec2::ZERO; 9];
        for (slot, (dy, dx)) in found.iter_mut().zip((-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dy, dx))))
        {
            let at = cell + IVec2::new(dx, dy);
            let point = wrapped(at, period);
            let moved = Vec2::new(self.unit(point, 1), self.unit(point, 2)) - 0.5;
            let offset = p - (at.as_vec2() + 0.5 + moved * jitter);
            *slot = offset;
            if offset.length_squared() < best.0 {
                best = (offset.length_squared(), offset, self.unit(point, 3));
            }
        }
        let (distance_squared, offset, id) = best;
        let mut border = f32::MAX;
        for other in found {
            let between = offset - other;
            if between.length_squared() > 1e-6 {
                border = border.min(-(offset + other).dot(between) * 0.5 / between.length());
            }
        }
        Cell { nearest: distance_squared.sqrt(), border, id }
    }

    /// A number in [0, 1) for each lattice point and channel, repeating after `period` points.
    pub(crate) fn lattice(self, at: IVec2, period: IVec2, channel: u32) -> f32 {
        self.unit(wrapped(at, period), channel)
    }

    /// The number of a lattice point that lies within the period.
    #[inline]
    fn unit(self, point: IVec2, channel: u32) -> f32 {
        unit_from_bits(self.hash(point, channel))
    }

    #[inline]
    fn hash(self, point: IVec2, channel: u32) -> u32 {
        pcg3d([point.x as u32, point.y as u32, self.seed.wrapping_add(channel << 24)])[0]
    }
}

/// A lattice point moved by whole periods to where both coordinates are from 0 to the period, exclusive.
#[inline]
fn wrapped(at: IVec2, period: IVec2) -> IVec2 {
    // Nearly all points lie within the period already, and a division costs more than the hash.
    let wrap = |at: i32, period: i32| if (at as u32) < period as u32 { at } else { at.rem_euclid(period) };
    IVec2::new(wrap(at.x, period.x), wrap(at.y, period.y))
}

/// The next lower whole numbers, without the library call that `f32::floor` is on a plain x86-64.
#[inline]
fn floor(p: Vec2) -> IVec2 {
    let truncated = p.as_ivec2();
    truncated - IVec2::new(i32::from(truncated.x as f32 > p.x), i32::from(truncated.y as f32 > p.y))
}

/// 0 below `low`, 1 above `high`, smooth between.
pub(crate) fn smoothstep(low: f32, high: f32, value: f32) -> f32 {
    let s = ((value - low) / (high - low)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

#[cfg(test)]
mod tests {
    use sheer_core::colour::linear_from_srgb;

    use super::*;

    #[test]
    fn noise_tiles_and_stays_in_range() {
        let noise = Noise { seed: 7 };
        let period = IVec2::new(5, 3);
        let mut extremes = (f32::MAX, f32::MIN);
        for step in 0..2000 {
            let p = Vec2::new(step as f32 * 0.0173, step as f32 * 0.0311);
            let value = noise.gradient(p, period);
            assert!((value - noise.gradient(p + period.as_vec2(), period)).abs() < 1e-3);
            extremes = (extremes.0.min(value), extremes.1.max(value));
            let cell = noise.cells(p, period, 0.8);
            assert!(cell.border >= -1e-5 && cell.nearest < 1.5, "{cell:?}");
        }
        assert!(
            extremes.0 > -1.3 && extremes.0 < -0.5 && extremes.1 > 0.5 && extremes.1 < 1.3,
            "{extremes:?}"
        );
    }

    #[test]
    fn the_table_of_bytes_gives_what_the_definition_gives() {
        let evenly = (0..=100_000).map(|step| step as f32 / 100_000.0 * 1.2 - 0.1);
        // Where one byte ends and the next begins, to the last bit.
        let ends = (1..=255).flat_map(|byte: u8| {
            let middle = linear_from_srgb((f32::from(byte) - 0.5) / 255.0);
            (0..64).map(move |bits| f32::from_bits(middle.to_bits() - 32 + bits))
        });
        for value in evenly.chain(ends).chain([0.0, 1.0, f32::MIN_POSITIVE]) {
            assert_eq!(srgb_byte(value), srgb_byte_exactly(value), "{value}");
        }
    }

    #[test]
    fn a_bump_has_normals_that_lean_away_from_its_top() {
        let painting = paint(32, |uv| {
            let height = 0.2 * (1.0 - 2.0 * (uv - 0.5).length()).max(0.0);
            Texel { height, ..Texel::matt(Vec3::ONE) }
        });
        let right_of_top = painting.normal[(22, 16)];
        let above_top = painting.normal[(16, 8)];
        assert!(right_of_top[0] > 150 && above_top[1] > 150, "{right_of_top:?} {above_top:?}");
    }
}
