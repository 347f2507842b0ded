//! Procedural textures: tiling noise, and images made of height, colour, roughness and occlusion at once.

use std::{f32::consts::FRAC_1_SQRT_2, iter, ops::Range, sync::LazyLock};

use glam::{IVec2, Vec2, Vec3};
use rayon::prelude::*;
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

/// A texel that is to be painted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    /// Its middle in the unit square, origin in the upper left corner.
    pub(crate) uv: Vec2,
    /// Its column and row, for what was prepared for every texel (see [`Fractal::sheet`]).
    pub(crate) texel: (u32, u32),
}

impl Spot {
    fn new(column: usize, row: usize, size: u32) -> Self {
        let uv = (Vec2::new(column as f32, row as f32) + 0.5) / size as f32;
        Self { uv, texel: (column as u32, row as u32) }
    }
}

/// The middles of the texels along an edge of a texture, as fractions of the edge.
pub(crate) fn texel_middles(size: u32) -> Vec<f32> {
    (0..size).map(|at| (at as f32 + 0.5) / size as f32).collect()
}

/// Paints a square tiling texture by what `texel` says of each spot.
pub(crate) fn paint(size: u32, texel: impl Fn(Spot) -> Texel + Sync) -> Painting {
    let mut colour = Image::filled(size, size, [0; 4]).expect("small");
    let mut surface = colour.clone();
    let mut heights = Image::filled(size, size, 0.0).expect("small");
    // A texel is taken apart at once: whole images of them would be many times as large as what they give.
    let rows = colour.par_rows_mut().zip(surface.par_rows_mut()).zip(heights.par_rows_mut());
    rows.enumerate().for_each(|(row, ((colour, surface), heights))| {
        for (column, ((colour, surface), height)) in colour.iter_mut().zip(surface).zip(heights).enumerate() {
            let texel = texel(Spot::new(column, row, size));
            *colour = colour_bytes(texel.colour, texel.alpha);
            *surface = [byte(texel.occlusion), byte(texel.roughness), 0, 255];
            *height = texel.height;
        }
    });
    Painting { colour, normal: normals(&heights), surface }
}

/// The normal map of a square tiling texture of heights.
fn normals(heights: &Image<f32>) -> Image<[u8; 4]> {
    let size = heights.width() as usize;
    let row_at = |row: usize| &heights.as_slice()[row % size * size..][..size];
    let mut normals = Image::filled(heights.width(), heights.width(), [0; 4]).expect("small");
    normals.par_rows_mut().enumerate().for_each(|(row, normals)| {
        let [above, own, below] = [size - 1, 0, 1].map(|offset| row_at(row + offset));
        for (column, normal) in normals.iter_mut().enumerate() {
            let right = if column + 1 < size { own[column + 1] } else { own[0] };
            let left = if column > 0 { own[column - 1] } else { own[size - 1] };
            // Central differences over two texels of 1/size each; v runs downwards, the bitangent up.
            let slope = Vec2::new(right - left, above[column] - below[column]) * (0.5 * size as f32);
            let direction = Vec3::new(-slope.x, -slope.y, 1.0).normalize() * 0.5 + 0.5;
            *normal = [byte(direction.x), byte(direction.y), byte(direction.z), 255];
        }
    });
    normals
}

/// Paints colour and alpha alone.
pub(crate) fn paint_colour(size: u32, texel: impl Fn(Spot) -> (Vec3, f32) + Sync) -> Image<[u8; 4]> {
    Image::par_from_fn(size, size, |x, y| {
        let (colour, alpha) = texel(Spot::new(x as usize, y as usize, size));
        colour_bytes(colour, alpha)
    })
    .expect("small")
}

fn colour_bytes(linear: Vec3, alpha: f32) -> [u8; 4] {
    static SRGB_BYTES: LazyLock<SrgbBytes> = LazyLock::new(SrgbBytes::new);
    let bytes = &*SRGB_BYTES;
    let [r, g, b] = linear.to_array().map(|value| bytes.byte(value));
    [r, g, b, byte(alpha)]
}

/// The byte that stands for a linear value, by its definition.
fn srgb_byte_exactly(linear: f32) -> u8 {
    byte(srgb_from_linear(linear.clamp(0.0, 1.0)))
}

/// The bytes of linear values without a power for each texel: the byte at the lower end of a step of values,
/// or the next one if the value reaches what that begins with.
struct SrgbBytes {
    /// The byte at the lower end of each step.
    low: Vec<u8>,
    /// The least value of the byte after each.
    next_begins: [f32; 256],
}

impl SrgbBytes {
    /// Steps of values: so many that none holds the beginnings of two bytes, even where the curve is
    /// steepest.
    const STEP_COUNT: usize = 4096;

    fn new() -> Self {
        let step = |step: usize| srgb_byte_exactly(step as f32 / Self::STEP_COUNT as f32);
        let begins = |wanted: usize| {
            // Positive floats are in the order of their bits.
            let (mut below, mut reached) = (0, 1.0_f32.to_bits());
            while reached - below > 1 {
                let middle = below + (reached - below) / 2;
                if usize::from(srgb_byte_exactly(f32::from_bits(middle))) < wanted {
                    below = middle;
                } else {
                    reached = middle;
                }
            }
            f32::from_bits(reached)
        };
        Self {
            low: (0..=Self::STEP_COUNT).map(step).collect(),
            next_begins: std::array::from_fn(
                |byte| if byte < 255 { begins(byte + 1) } else { f32::INFINITY },
            ),
        }
    }

    #[inline]
    fn byte(&self, linear: f32) -> u8 {
        let value = linear.clamp(0.0, 1.0);
        let low = self.low[(value * Self::STEP_COUNT as f32) as usize];
        low + u8::from(value >= self.next_begins[usize::from(low)])
    }
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

/// Noise that repeats after a whole number of lattice cells. What is asked for at many points is prepared
/// first: a lattice has far fewer points than a texture has texels, and hashing is most of the work.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    pub(crate) seed: u32,
}

impl Noise {
    /// Gradient noise (Perlin 2002) that repeats after `period` cells.
    pub(crate) fn gradient(self, period: IVec2) -> Gradient {
        let stride = period.x as usize + 1;
        let points = (0..=period.y).flat_map(|y| (0..=period.x).map(move |x| IVec2::new(x, y)));
        let directions = points.map(|point| (self.hash(wrapped(point, period), 0) >> 28) as u8).collect();
        Gradient { period, stride, directions }
    }

    /// Octaves of gradient noise, each of half the size and half the strength, over the unit square; about
    /// -1 to 1.
    pub(crate) fn fractal(self, cell_count: IVec2, octave_count: u32) -> Fractal {
        let octave = |octave: u32| {
            let period = cell_count * (1 << octave);
            let layer = Self { seed: self.seed ^ (octave.wrapping_mul(0x9e37_79b9)) };
            Octave { noise: layer.gradient(period), scale: period.as_vec2(), shift: 0.0 }
        };
        Fractal { octaves: (0..octave_count).map(octave).collect(), gain: 0.65 }
    }

    /// Cellular noise (Worley 1996) with feature points moved from the middles of their cells by up to
    /// `jitter`/2 cells.
    pub(crate) fn cells(self, period: IVec2, jitter: f32) -> Cells {
        let points = (0..period.y).flat_map(|y| (0..period.x).map(move |x| IVec2::new(x, y)));
        let feature = |point: IVec2| {
            let moved = Vec2::new(self.unit(point, 1), self.unit(point, 2)) - 0.5;
            (moved * jitter, self.unit(point, 3))
        };
        Cells { period, features: points.map(feature).collect() }
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

/// Gradient noise whose directions have been drawn (see [`Noise::gradient`]).
#[derive(Debug)]
pub(crate) struct Gradient {
    period: IVec2,
    /// Lattice points a row.
    stride: usize,
    /// Which of the [`DIRECTIONS`] each lattice point has, row by row. The first column and row come once
    /// more at the end, so that the far corners of a cell need no wrapping.
    directions: Vec<u8>,
}

impl Gradient {
    /// About -1 to 1 at `p` in cells.
    fn at(&self, p: Vec2) -> f32 {
        let cell = floor(p);
        let offset = p - cell.as_vec2();
        let low = wrapped(cell, self.period);
        let from = low.y as usize * self.stride + low.x as usize;
        let [upper, lower] = [&self.directions[from..], &self.directions[from + self.stride..]];
        let corner = |direction: u8, dx: f32, dy: f32| {
            let [x, y] = unit_vector(direction);
            x * (offset.x - dx) + y * (offset.y - dy)
        };
        let corners = [
            corner(upper[0], 0.0, 0.0),
            corner(upper[1], 1.0, 0.0),
            corner(lower[0], 0.0, 1.0),
            corner(lower[1], 1.0, 1.0),
        ];
        between(corners, fade(offset.x), fade(offset.y))
    }

    /// Adds `strength` times the noise at the points of a row.
    fn add_row(&self, columns: &Columns, y: f32, strength: f32, sums: &mut [f32]) {
        let cell = floor_one(y);
        let low = wrapped_one(cell, self.period.y) as usize * self.stride;
        let [upper, lower] = [low, low + self.stride].map(|at| &self.directions[at..][..self.stride]);
        let offset_y = y - cell as f32;
        let fade_y = fade(offset_y);
        for Run { cell, points } in &columns.runs {
            // What the points of a cell have in common: the directions, and what the row makes of them.
            let corner = |row: &[u8], right: usize, offset_y: f32| {
                let [x, y] = unit_vector(row[cell + right]);
                (x, y * offset_y)
            };
            let upper = [corner(upper, 0, offset_y), corner(upper, 1, offset_y)];
            let lower = [corner(lower, 0, offset_y - 1.0), corner(lower, 1, offset_y - 1.0)];
            let of_points = sums[points.clone()]
                .iter_mut()
                .zip(&columns.offsets[points.clone()])
                .zip(&columns.fades[points.clone()]);
            for ((sum, &offset), &fade_x) in of_points {
                let at = |(x, y): (f32, f32), dx: f32| x * (offset - dx) + y;
                let corners = [at(upper[0], 0.0), at(upper[1], 1.0), at(lower[0], 0.0), at(lower[1], 1.0)];
                *sum += between(corners, fade_x, fade_y) * strength;
            }
        }
    }

    /// Where the points of all rows lie within their cells.
    fn columns(&self, x: impl Iterator<Item = f32>) -> Columns {
        let mut columns = Columns { runs: Vec::new(), offsets: Vec::new(), fades: Vec::new() };
        for (index, x) in x.enumerate() {
            let cell = floor_one(x);
            let offset = x - cell as f32;
            columns.offsets.push(offset);
            columns.fades.push(fade(offset));
            let cell = wrapped_one(cell, self.period.x) as usize;
            match columns.runs.last_mut() {
                Some(run) if run.cell == cell => run.points.end = index + 1,
                _ => columns.runs.push(Run { cell, points: index..index + 1 }),
            }
        }
        columns
    }
}

/// What the noise at the points of a row has in common with that of every other row.
struct Columns {
    runs: Vec<Run>,
    /// Of each point from the left edge of its cell, and what fades by it.
    offsets: Vec<f32>,
    fades: Vec<f32>,
}

/// Neighbouring points of a row in the same cell.
struct Run {
    cell: usize,
    points: Range<usize>,
}

/// Octaves of gradient noise that have been prepared (see [`Noise::fractal`]).
#[derive(Debug)]
pub(crate) struct Fractal {
    /// Each has half the strength of the one before it.
    pub(crate) octaves: Vec<Octave>,
    /// Factor on the sum.
    pub(crate) gain: f32,
}

/// Gradient noise, and how a point of the whole becomes one of its cells.
#[derive(Debug)]
pub(crate) struct Octave {
    pub(crate) noise: Gradient,
    pub(crate) scale: Vec2,
    pub(crate) shift: f32,
}

impl Fractal {
    /// The noise at any point.
    pub(crate) fn at(&self, p: Vec2) -> f32 {
        self.coarse_at(p, self.octaves.len())
    }

    /// The sum of the first octaves alone.
    pub(crate) fn coarse_at(&self, p: Vec2, octave_count: usize) -> f32 {
        let mut sum = 0.0;
        for (octave, strength) in self.octaves.iter().zip(strengths()).take(octave_count) {
            sum += octave.noise.at(p * octave.scale + octave.shift) * strength;
        }
        sum * self.gain
    }

    /// The noise at every texel of a texture, to be looked up by [`Spot::texel`].
    pub(crate) fn sheet(&self, size: u32) -> Image<f32> {
        let middles = texel_middles(size);
        self.coarse_sheet(&middles, &middles, self.octaves.len())
    }

    /// The sum of the first octaves at all points of a grid: what [`Self::coarse_at`] says, to the bit.
    pub(crate) fn coarse_sheet(&self, x: &[f32], y: &[f32], octave_count: usize) -> Image<f32> {
        let octaves: Vec<_> = self.octaves[..octave_count]
            .iter()
            .zip(strengths())
            .map(|(octave, strength)| {
                let columns = octave.noise.columns(x.iter().map(|x| x * octave.scale.x + octave.shift));
                (octave, strength, columns)
            })
            .collect();
        let mut sheet = Image::filled(x.len() as u32, y.len() as u32, 0.0).expect("small");
        sheet.par_rows_mut().zip(y).for_each(|(row, y)| {
            for (octave, strength, columns) in &octaves {
                octave.noise.add_row(columns, y * octave.scale.y + octave.shift, *strength, row);
            }
            row.iter_mut().for_each(|sum| *sum *= self.gain);
        });
        sheet
    }
}

/// How strong each octave is.
fn strengths() -> impl Iterator<Item = f32> {
    iter::successors(Some(1.0), |strength| Some(0.5 * strength))
}

/// Cellular noise whose feature points have been drawn (see [`Noise::cells`]).
#[derive(Debug)]
pub(crate) struct Cells {
    period: IVec2,
    /// How far the feature point of each cell lies from its middle, and the cell's number; row by row.
    features: Vec<(Vec2, f32)>,
}

/// What cellular noise has at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Distance to the nearest feature point, in cells.
    pub(crate) nearest: f32,
    /// Distance to the border with the second nearest, in cells.
    pub(crate) border: f32,
    /// 0 to 1, one value a cell.
    pub(crate) id: f32,
}

impl Cells {
    /// What there is at `p` in cells.
    pub(crate) fn at(&self, p: Vec2) -> Cell {
        let cell = floor(p);
        let mut best = (f32::MAX, Vec2::ZERO, 0.0);
        let mut found = [Vec2::ZERO; 9];
        for (slot, (dy, dx)) in found.iter_mut().zip((-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dy, dx))))
        {
            let at = cell + IVec2::new(dx, dy);
            let point = wrapped(at, self.period);
            let (moved, id) = self.features[(point.y * self.period.x + point.x) as usize];
            let offset = p - (at.as_vec2() + 0.5 + moved);
            *slot = offset;
            if offset.length_squared() < best.0 {
                best = (offset.length_squared(), offset, id);
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
}

#[inline]
fn unit_vector(direction: u8) -> [f32; 2] {
    DIRECTIONS[usize::from(direction) % DIRECTIONS.len()]
}

/// How far noise has gone from one corner's to the next one's.
#[inline]
fn fade(offset: f32) -> f32 {
    offset * offset * offset * (offset * (offset * 6.0 - 15.0) + 10.0)
}

/// What the corners of a cell (upper left, upper right, lower left, lower right) come to within it.
#[inline]
fn between(corners: [f32; 4], fade_x: f32, fade_y: f32) -> f32 {
    let [upper_left, upper_right, lower_left, lower_right] = corners;
    let top = upper_left + (upper_right - upper_left) * fade_x;
    let bottom = lower_left + (lower_right - lower_left) * fade_x;
    1.6 * (top + (bottom - top) * fade_y)
}

/// A lattice point moved by whole periods to where both coordinates are from 0 to the period, exclusive.
#[inline]
fn wrapped(at: IVec2, period: IVec2) -> IVec2 {
    IVec2::new(wrapped_one(at.x, period.x), wrapped_one(at.y, period.y))
}

#[inline]
fn wrapped_one(at: i32, period: i32) -> i32 {
    // Nearly all points lie within the period already, and a division is slow.
    if (at as u32) < period as u32 { at } else { at.rem_euclid(period) }
}

/// The next lower whole numbers.
#[inline]
fn floor(p: Vec2) -> IVec2 {
    IVec2::new(floor_one(p.x), floor_one(p.y))
}

/// The next lower whole number, without the library call that `f32::floor` is on a plain x86-64.
#[inline]
fn floor_one(value: f32) -> i32 {
    let truncated = value as i32;
    truncated - i32::from(truncated as f32 > value)
}

/// 0 below `low`, 1 above `high`, smooth between.
pub(crate) fn smoothstep(low: f32, high: f32, value: f32) -> f32 {
    let s = ((value - low) / (high - low)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

#[cfg(test)]
mod tests {
    use sheer_core::{colour::linear_from_srgb, hash::Pcg32};

    use super::*;

    /// Fractal noise as it is defined, of hashes alone.
    fn defined(noise: Noise, uv: Vec2, cell_count: IVec2, octave_count: u32) -> f32 {
        let mut sum = 0.0;
        for octave in 0..octave_count {
            let period = cell_count * (1 << octave);
            let seed = noise.seed ^ (octave.wrapping_mul(0x9e37_79b9));
            let p = uv * period.as_vec2();
            let cell = p.floor();
            let f = p - cell;
            let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
            let corner = |x: i32, y: i32| {
                let point = (cell.as_ivec2() + IVec2::new(x, y)).rem_euclid(period);
                let direction = pcg3d([point.x as u32, point.y as u32, seed])[0] >> 28;
                Vec2::from_array(DIRECTIONS[direction as usize]).dot(f - Vec2::new(x as f32, y as f32))
            };
            let top = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * fade.x;
            let bottom = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * fade.x;
            sum += 1.6 * (top + (bottom - top) * fade.y) / (1 << octave) as f32;
        }
        sum * 0.65
    }

    #[test]
    fn prepared_noise_is_what_its_definition_says_to_the_bit() {
        let mut random = Pcg32::new(1, 0);
        for (cells, octave_count) in [([3, 3], 5), ([12, 2], 3), ([48, 1], 2), ([1, 5], 4)] {
            let noise = Noise { seed: random.next_u32() };
            let cells = IVec2::from_array(cells);
            let fractal = noise.fractal(cells, octave_count);
            // Around the unit square too: noise goes on where it was warped to.
            for _ in 0..2000 {
                let uv = Vec2::new(random.range(-1.5, 2.5), random.range(-1.5, 2.5));
                let (is, should) = (fractal.at(uv), defined(noise, uv, cells, octave_count));
                assert_eq!(is.to_bits(), should.to_bits(), "{cells} at {uv}: {is} and {should}");
            }
            let sheet = fractal.sheet(48);
            let mut xs: Vec<f32> = (0..40).map(|_| random.range(-1.5, 2.5)).collect();
            // Also in a row that goes back to where it was.
            xs.extend([0.0, 1.0, 0.5, 0.5, 1.5]);
            let scattered = fractal.coarse_sheet(&xs, &xs, octave_count as usize);
            for (y, x) in (0..48).flat_map(|y| (0..48).map(move |x| (y, x))) {
                let uv = (Vec2::new(x as f32, y as f32) + 0.5) / 48.0;
                let should = defined(noise, uv, cells, octave_count);
                assert_eq!(sheet[(x, y)].to_bits(), should.to_bits(), "{cells} at texel {x}, {y}");
            }
            for (y, x) in (0..xs.len()).flat_map(|y| (0..xs.len()).map(move |x| (y, x))) {
                let should = defined(noise, Vec2::new(xs[x], xs[y]), cells, octave_count);
                assert_eq!(scattered[(x as u32, y as u32)].to_bits(), should.to_bits(), "{cells} {x} {y}");
            }
        }
    }

    #[test]
    fn noise_tiles_and_stays_in_range() {
        let noise = Noise { seed: 7 };
        let period = IVec2::new(5, 3);
        let (gradient, cells) = (noise.gradient(period), noise.cells(period, 0.8));
        let mut extremes = (f32::MAX, f32::MIN);
        for step in 0..2000 {
            let p = Vec2::new(step as f32 * 0.0173, step as f32 * 0.0311);
            let value = gradient.at(p);
            assert!((value - gradient.at(p + period.as_vec2())).abs() < 1e-3);
            extremes = (extremes.0.min(value), extremes.1.max(value));
            let cell = cells.at(p);
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
        let bytes = SrgbBytes::new();
        for value in evenly.chain(ends).chain([0.0, 1.0, f32::MIN_POSITIVE]) {
            assert_eq!(bytes.byte(value), srgb_byte_exactly(value), "{value}");
        }
    }

    #[test]
    fn a_bump_has_normals_that_lean_away_from_its_top() {
        let painting = paint(32, |Spot { uv, .. }| {
            let height = 0.2 * (1.0 - 2.0 * (uv - 0.5).length()).max(0.0);
            Texel { height, ..Texel::matt(Vec3::ONE) }
        });
        let right_of_top = painting.normal[(22, 16)];
        let above_top = painting.normal[(16, 8)];
        assert!(right_of_top[0] > 150 && above_top[1] > 150, "{right_of_top:?} {above_top:?}");
    }
}
