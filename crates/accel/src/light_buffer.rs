//! Rays of one direction, such as those to the sun, by a light buffer (Haines and Greenberg 1986, *The Light
//! Buffer: A Shadow-Testing Accelerator*).
//!
//! Such a ray is a point of the plane across it, and meets a triangle where the image of the triangle in that
//! plane holds the point. So the plane is divided into cells, each with a list of all triangles whose images
//! touch it, the furthest along the rays first: a ray finds its list by its origin alone and walks it down to
//! the origin's own depth, without boxes and without a stack. A cell is divided in sixteen as long as that
//! makes the lists of its rays shorter. The lists hold copies, eight triangles a block, and the test is that
//! of the tree, with its hits to the bit.
//!
//! The price are copies, one of a triangle for each cell that it touches, and that there is one buffer a
//! direction. The caller says how much memory the copies may take; with less, lists are longer.

use std::fmt;

use glam::{DVec2, Vec2, Vec3};
use rayon::prelude::*;

use crate::build::is_kept;
use crate::column::Column;
use crate::limits::{COORDINATE_LIMIT, INDEX_LIMIT};
use crate::node::{Block, Child, WIDTH};
use crate::ray::{Hit, Ray};
use crate::simd::SupportedPath;
use crate::traverse::Shear;

/// Cells a side that a cell is divided into.
const SIDE: usize = 4;
/// A cell is divided if the lists of its rays become this much shorter, on average.
const LEAST_GAIN: f32 = 0.6;
/// How often a cell may be divided: 4^10 along each axis are as fine as the numbers are.
const MOST_LEVELS: u32 = 10;
/// Triangles of a cell that is not worth dividing.
const FEW: usize = 2 * WIDTH;
/// Bytes of a place in a list for a copy: an eighth of a block of 320, of its depth, of a list and of the
/// child that leads there, in arrays that may be twice as long as what they hold.
const PLACE_BYTES: usize = 88;
/// Smallest extent of region and triangles: products of two lengths that are as small as the margin around
/// images still are normal numbers.
const LEAST_REACH: f32 = 1e-12;
/// Triangles of a cell from which on its parts are made by all threads.
const PARALLEL: usize = 4096;
/// Marks an opaque triangle's index.
const OPAQUE: u32 = 1 << 31;

/// Triangles in the order in which rays of one direction meet them.
///
/// The same triangles are ignored as by a [`crate::Bvh`].
#[derive(Clone)]
pub struct LightBuffer {
    direction: Vec3,
    plane: Plane,
    shear: Shear,
    lists: Lists,
    root: Child,
    path: SupportedPath,
}

/// The plane across the rays, in the coordinates of the triangle test: points move along the rays until their
/// fastest axis is 0.
#[derive(Clone, Copy)]
struct Plane {
    /// Original axes that become x, y and z.
    axes: [usize; 3],
    /// The direction's x and y per z.
    slope: DVec2,
    /// What lies at (0, 0).
    middle: DVec2,
    /// Of z along the rays.
    sign: f32,
    /// Where origins may lie, so that [`Self::margin`] holds.
    region: [Vec3; 2],
    /// How far apart rounding may take a ray and a triangle that it hits, in the plane.
    margin: Vec2,
    /// The same along the rays.
    depth_margin: f32,
}

/// A triangle seen along the rays.
#[derive(Clone, Copy)]
struct Image {
    corners: [Vec2; 3],
    /// Its furthest depth.
    top: f32,
    /// Index of the triangle, with [`OPAQUE`].
    triangle: u32,
}

/// A part of the plane and its own parts.
#[derive(Clone)]
struct Cell {
    grid: Grid,
    /// Cells, or lists in the place of blocks, row by row.
    children: [Child; SIDE * SIDE],
}

/// A rectangle of the plane in rows and columns.
#[derive(Clone, Copy)]
struct Grid {
    lower: Vec2,
    /// Size of a part.
    step: Vec2,
    /// Parts a unit.
    scale: Vec2,
}

/// The blocks of a cell: first those of opaque triangles, then all others.
#[derive(Clone, Copy)]
struct List {
    start: u32,
    opaque_end: u32,
    end: u32,
}

impl List {
    const EMPTY: Self = Self { start: 0, opaque_end: 0, end: 0 };
}

/// Cells, lists, and their blocks.
#[derive(Clone, Default)]
struct Lists {
    cells: Vec<Cell>,
    lists: Vec<List>,
    blocks: Vec<Block>,
    /// Furthest depth of each block; it falls from block to block.
    tops: Vec<f32>,
}

impl LightBuffer {
    /// Sorts triangles for rays of a direction, on the threads of the current rayon pool; their number
    /// changes nothing. Triangles are numbered from `first_number` on, and those that are opaque by their
    /// number come first. `region`: lowest and highest corner of where origins may lie. The buffer takes
    /// `most_bytes` at most.
    ///
    /// None if these do not suffice for a single list, and for a direction or a region that is out of the
    /// ranges which [`Ray`] names, or too small for `f32` to divide.
    #[must_use]
    pub fn build(
        triangles: &[[Vec3; 3]],
        first_number: u32,
        is_opaque: impl Fn(u32) -> bool + Sync,
        direction: Vec3,
        region: [Vec3; 2],
        most_bytes: usize,
    ) -> Option<Self> {
        let count = triangles.len().min(INDEX_LIMIT.saturating_sub(first_number as usize));
        let kept = triangles[..count].par_iter().with_min_len(PARALLEL).filter(|triangle| is_kept(triangle));
        let joined = |[lower, upper]: [Vec3; 2], [low, high]: [Vec3; 2]| [lower.min(low), upper.max(high)];
        let around = kept
            .fold(|| region, |bounds, triangle| triangle.iter().fold(bounds, |all, p| joined(all, [*p; 2])))
            .reduce(|| region, joined);
        let (plane, shear) = Plane::new(direction, region, around)?;
        let image = |index: usize| {
            let triangle = &triangles[index];
            let tag = if is_opaque(first_number + index as u32) { OPAQUE } else { 0 };
            is_kept(triangle).then(|| Image {
                corners: triangle.map(|corner| plane.place(corner)),
                top: triangle.map(|corner| plane.depth(corner)).into_iter().fold(f32::NEG_INFINITY, f32::max),
                triangle: index as u32 | tag,
            })
        };
        let images: Vec<Image> =
            (0..count).into_par_iter().with_min_len(PARALLEL).filter_map(image).collect();

        let nothing = [Vec2::INFINITY, Vec2::NEG_INFINITY];
        let [lower, upper] = images.iter().fold(nothing, |[lower, upper], image| {
            let [low, high] = image.bounds(plane.margin);
            [lower.min(low), upper.max(high)]
        });
        let grower = Grower { triangles, first_number, images: &images, margin: plane.margin };
        let all: Vec<u32> = (0..images.len() as u32).collect();
        let room = (most_bytes / PLACE_BYTES / WIDTH).min(INDEX_LIMIT);
        if room < grower.block_count(&all) {
            return None;
        }
        let mut lists = Lists::default();
        let root = grower.grow(&all, [lower, upper - lower], room, 0, &mut lists);
        lists.shrink();
        Some(Self { direction, plane, shear, lists, root, path: SupportedPath::detect() })
    }

    /// Visits every hit inside `[t_min, t_max]` of a ray of the buffer's direction: opaque triangles first,
    /// then all others, both roughly from the far end of the ray to its origin. `visit` returns the new
    /// `t_max`; one above the current has no effect, `f32::NEG_INFINITY` stops. Hits are those of a
    /// [`crate::Bvh`], to the bit.
    ///
    /// False, and nothing is visited, if the buffer does not serve the ray ([`Self::serves`]).
    #[inline]
    pub fn traverse(&self, ray: &Ray, visit: impl FnMut(Hit) -> f32) -> bool {
        if !self.serves(ray) {
            return false;
        }
        let List { start, opaque_end, end } = self.list_at(self.plane.place(ray.origin));
        let run = |start: u32, end: u32| {
            let range = start as usize..end as usize;
            (&self.lists.blocks[range.clone()], &self.lists.tops[range])
        };
        let column = Column {
            shear: self.shear.at(ray.origin),
            // As for the tree, where -0 becomes +0.
            t_min: ray.t_min.max(0.0) + 0.0,
            lowest: self.plane.depth(ray.origin) - self.plane.depth_margin,
            runs: [run(start, opaque_end), run(opaque_end, end)],
        };
        self.path.scan(&column, ray.t_max, visit);
        true
    }

    /// Whether a ray has the buffer's direction and begins within its region.
    #[inline]
    #[must_use]
    pub fn serves(&self, ray: &Ray) -> bool {
        let bits = |direction: Vec3| direction.to_array().map(f32::to_bits);
        bits(ray.direction) == bits(self.direction) && self.plane.covers(ray.origin)
    }

    /// What the buffer takes in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let Lists { cells, lists, blocks, tops } = &self.lists;
        cells.capacity() * size_of::<Cell>()
            + lists.capacity() * size_of::<List>()
            + blocks.capacity() * size_of::<Block>()
            + tops.capacity() * size_of::<f32>()
    }

    /// The same buffer on another path, which the processor runs.
    #[cfg(test)]
    pub(crate) fn with_path(self, path: crate::SimdPath) -> Self {
        Self { path: SupportedPath::new(path).expect("tests ask before"), ..self }
    }

    #[inline]
    fn list_at(&self, at: Vec2) -> List {
        let mut child = self.root;
        while !child.is_block() {
            let cell = &self.lists.cells[child.index()];
            let [column, row] = cell.grid.part(at);
            child = cell.children[row * SIDE + column];
        }
        if child == Child::NONE { List::EMPTY } else { self.lists.lists[child.index()] }
    }
}

impl fmt::Debug for LightBuffer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("LightBuffer").field("lists", &self.lists.lists.len()).finish_non_exhaustive()
    }
}

impl Plane {
    /// `region` is where origins lie, `around` holds that and all triangles.
    fn new(direction: Vec3, region: [Vec3; 2], [lower, upper]: [Vec3; 2]) -> Option<(Self, Shear)> {
        let ray = Ray { origin: Vec3::ZERO, direction, t_min: 0.0, t_max: f32::INFINITY };
        let limit = Vec3::splat(COORDINATE_LIMIT);
        if !(lower.abs().cmple(limit) & upper.abs().cmple(limit)).all() {
            return None;
        }
        let reach = upper - lower;
        if reach.max_element() < LEAST_REACH {
            return None;
        }
        let shear = Shear::of(&ray)?;
        let [x, y, z] = shear.axes;
        let [slope_x, slope_y, _] = shear.slope;
        // With u = 2^-24: the triangle test moves a vertex by 5 u (X + Z) at most (see `Slabs`), images round
        // twice, the sides of cells once a level, and the question whether the two touch eight times. 32 u.
        let margin = (Vec2::new(reach[x], reach[y]) + reach[z]) * (16.0 * f32::EPSILON);
        let mut plane = Self {
            axes: [x, y, z],
            slope: DVec2::new(slope_x.into(), slope_y.into()),
            middle: DVec2::ZERO,
            sign: direction[z].signum(),
            region,
            margin,
            depth_margin: reach[z] * f32::EPSILON,
        };
        plane.middle = plane.across(0.5 * lower + 0.5 * upper);
        Some((plane, shear))
    }

    #[inline]
    fn across(&self, point: Vec3) -> DVec2 {
        let [x, y, z] = self.axes.map(|axis| f64::from(point[axis]));
        DVec2::new(x, y) - self.slope * z - self.middle
    }

    /// Where the ray through a point meets the plane.
    #[inline]
    fn place(&self, point: Vec3) -> Vec2 {
        self.across(point).as_vec2()
    }

    /// How far along the rays a point is.
    #[inline]
    fn depth(&self, point: Vec3) -> f32 {
        point[self.axes[2]] * self.sign
    }

    #[inline]
    fn covers(&self, origin: Vec3) -> bool {
        (self.region[0].cmple(origin) & origin.cmple(self.region[1])).all()
    }
}

impl Image {
    fn is_opaque(&self) -> bool {
        self.triangle & OPAQUE != 0
    }

    fn bounds(&self, margin: Vec2) -> [Vec2; 2] {
        let [a, b, c] = self.corners;
        [a.min(b).min(c) - margin, a.max(b).max(c) + margin]
    }

    /// Whether it touches a rectangle that its bounds touch: along the normal of no edge do the two lie
    /// apart. Which way the corners turn is not asked, for of a triangle that is seen from its edge that is
    /// lost.
    fn touches(&self, [lower, upper]: [Vec2; 2]) -> bool {
        let [a, b, c] = self.corners;
        let (middle, half) = ((lower + upper) * 0.5, (upper - lower) * 0.5);
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().all(|[from, to, apex]| {
            let normal = (to - from).perp();
            let apex = normal.dot(apex - from);
            let (middle, reach) = (normal.dot(middle - from), normal.abs().dot(half));
            middle + reach >= apex.min(0.0) && middle - reach <= apex.max(0.0)
        })
    }
}

impl Grid {
    fn new([lower, size]: [Vec2; 2]) -> Self {
        let scale = Vec2::splat(SIDE as f32) / size;
        Self { lower, step: size / SIDE as f32, scale }
    }

    /// Column and row of the part in which a place lies, of one outside the nearest. Never falls as the place
    /// moves up, rounding included.
    #[inline]
    fn part(&self, at: Vec2) -> [usize; 2] {
        let place = (at - self.lower) * self.scale;
        // What is negative, or not a number where the rectangle has no size, becomes 0.
        [place.x, place.y].map(|place| (place as usize).min(SIDE - 1))
    }

    /// A part, widened.
    fn rectangle(&self, [column, row]: [usize; 2], margin: Vec2) -> [Vec2; 2] {
        let lower = self.lower + self.step * Vec2::new(column as f32, row as f32);
        [lower - margin, lower + self.step + margin]
    }
}

/// Makes lists of images.
struct Grower<'a> {
    triangles: &'a [[Vec3; 3]],
    first_number: u32,
    images: &'a [Image],
    margin: Vec2,
}

/// What touches the parts of a grid: indices of images, one part after the other.
struct Divided {
    touching: Vec<u32>,
    ends: [usize; SIDE * SIDE],
    /// Blocks that the list of each part takes.
    blocks: [usize; SIDE * SIDE],
}

impl Divided {
    fn part(&self, place: usize) -> &[u32] {
        let start = if place == 0 { 0 } else { self.ends[place - 1] };
        &self.touching[start..self.ends[place]]
    }
}

impl Grower<'_> {
    /// A cell for a rectangle, given by its lower corner and its size, or a list of all that touches it,
    /// which are indices of images. `room`: how many blocks its lists may take, enough for that one; a cell
    /// counts as one, too.
    fn grow(
        &self,
        touching: &[u32],
        rectangle: [Vec2; 2],
        room: usize,
        level: u32,
        lists: &mut Lists,
    ) -> Child {
        if touching.is_empty() {
            return Child::NONE;
        }
        let grid = Grid::new(rectangle);
        let divided = if touching.len() > FEW && level < MOST_LEVELS {
            self.divide(touching, &grid, room)
        } else {
            None
        };
        let Some(divided) = divided else { return self.list(touching, lists) };

        // Each part gets its share of the room that is left.
        let spare = (room - 1 - divided.blocks.iter().sum::<usize>()) as f64;
        let grow_part = |place: usize, lists: &mut Lists| {
            let part = divided.part(place);
            let share = part.len() as f64 / divided.touching.len() as f64;
            let room = divided.blocks[place] + (spare * share) as usize;
            let [lower, _] = grid.rectangle([place % SIDE, place / SIDE], Vec2::ZERO);
            self.grow(part, [lower, grid.step], room, level + 1, lists)
        };
        let index = lists.cells.len();
        lists.cells.push(Cell { grid, children: [Child::NONE; SIDE * SIDE] });
        if touching.len() < PARALLEL {
            for place in 0..SIDE * SIDE {
                lists.cells[index].children[place] = grow_part(place, lists);
            }
        } else {
            let grow_apart = |place: usize| {
                let mut lists = Lists::default();
                (grow_part(place, &mut lists), lists)
            };
            let grown: Vec<(Child, Lists)> = (0..SIDE * SIDE).into_par_iter().map(grow_apart).collect();
            for (place, (child, part)) in grown.into_iter().enumerate() {
                lists.cells[index].children[place] = child.shifted(lists.cells.len(), lists.lists.len());
                lists.append(part);
            }
        }
        Child::node(index)
    }

    /// What touches each part of a grid; none if that is not worth its copies, or has no room.
    fn divide(&self, touching: &[u32], grid: &Grid, room: usize) -> Option<Divided> {
        // The parts of each as bits, then the lists, when their lengths are known.
        let mut counts = [[0_usize; 2]; SIDE * SIDE];
        let parts_of = |&index: &u32| {
            let image = &self.images[index as usize];
            let parts = self.parts(image, grid);
            let mut left = parts;
            while left != 0 {
                counts[left.trailing_zeros() as usize][usize::from(image.is_opaque())] += 1;
                left &= left - 1;
            }
            parts
        };
        let parts: Vec<u16> = touching.iter().map(parts_of).collect();
        let blocks = counts.map(|[partial, opaque]| partial.div_ceil(WIDTH) + opaque.div_ceil(WIDTH));
        let block_count = blocks.iter().sum::<usize>();
        let mean = block_count as f32 / (SIDE * SIDE) as f32;
        if block_count >= room || mean > LEAST_GAIN * self.block_count(touching) as f32 {
            return None;
        }
        let mut ends = [0; SIDE * SIDE];
        let mut sum = 0;
        for (end, [partial, opaque]) in ends.iter_mut().zip(counts) {
            *end = sum;
            sum += partial + opaque;
        }
        let mut divided = vec![0; sum];
        for (&index, mut left) in touching.iter().zip(parts) {
            while left != 0 {
                let end = &mut ends[left.trailing_zeros() as usize];
                divided[*end] = index;
                *end += 1;
                left &= left - 1;
            }
        }
        Some(Divided { touching: divided, ends, blocks })
    }

    /// How many blocks a list of images takes.
    fn block_count(&self, touching: &[u32]) -> usize {
        let opaque = touching.iter().filter(|&&index| self.images[index as usize].is_opaque()).count();
        opaque.div_ceil(WIDTH) + (touching.len() - opaque).div_ceil(WIDTH)
    }

    /// The parts of a grid that an image touches, a bit each.
    fn parts(&self, image: &Image, grid: &Grid) -> u16 {
        let [[left, bottom], [right, top]] = image.bounds(self.margin).map(|corner| grid.part(corner));
        if left == right && bottom == top {
            return 1 << (bottom * SIDE + left);
        }
        let mut parts = 0;
        for row in bottom..=top {
            for column in left..=right {
                let touches = image.touches(grid.rectangle([column, row], self.margin));
                parts |= u16::from(touches) << (row * SIDE + column);
            }
        }
        parts
    }

    fn list(&self, touching: &[u32], lists: &mut Lists) -> Child {
        let of = |index: u32| &self.images[index as usize];
        let mut touching = touching.to_vec();
        touching.sort_unstable_by(|&a, &b| {
            let (a, b) = (of(a), of(b));
            // Opaque ones have the greater index.
            (b.triangle & OPAQUE)
                .cmp(&(a.triangle & OPAQUE))
                .then(b.top.total_cmp(&a.top))
                .then(a.triangle.cmp(&b.triangle))
        });
        let opaque = touching.partition_point(|&index| of(index).is_opaque());
        let start = lists.blocks.len() as u32;
        let mut ends = [0; 2];
        for (end, run) in ends.iter_mut().zip([&touching[..opaque], &touching[opaque..]]) {
            for chunk in run.chunks(WIDTH) {
                let mut block = Block::EMPTY;
                for (lane, &index) in chunk.iter().enumerate() {
                    let triangle = of(index).triangle & !OPAQUE;
                    block.set(lane, &self.triangles[triangle as usize], self.first_number + triangle);
                }
                lists.blocks.push(block);
                lists.tops.push(of(chunk[0]).top);
            }
            *end = lists.blocks.len() as u32;
        }
        lists.lists.push(List { start, opaque_end: ends[0], end: ends[1] });
        Child::block(lists.lists.len() - 1)
    }
}

impl Lists {
    /// Gives back what growing has kept in reserve.
    fn shrink(&mut self) {
        self.cells.shrink_to_fit();
        self.lists.shrink_to_fit();
        self.blocks.shrink_to_fit();
        self.tops.shrink_to_fit();
    }

    /// Adds others behind these.
    fn append(&mut self, others: Self) {
        let (first_cell, first_list) = (self.cells.len(), self.lists.len());
        let first_block = self.blocks.len() as u32;
        self.cells.extend(others.cells.into_iter().map(|mut cell| {
            cell.children = cell.children.map(|child| child.shifted(first_cell, first_list));
            cell
        }));
        self.lists.extend(others.lists.into_iter().map(|list| List {
            start: list.start + first_block,
            opaque_end: list.opaque_end + first_block,
            end: list.end + first_block,
        }));
        self.blocks.extend_from_slice(&others.blocks);
        self.tops.extend_from_slice(&others.tops);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bvh;

    /// Numbers in [0, 1): the upper bits of a linear congruential generator.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 40) as f32 / (1 << 24) as f32
        }

        fn point(&mut self) -> Vec3 {
            Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
        }
    }

    #[test]
    fn whatever_a_ray_hits_is_seen_within_the_margin_around_the_ray() {
        let mut numbers = Numbers(5);
        let (mut met, mut apart) = ([0; 3], [0; 3]);
        for direction in [Vec3::Z, Vec3::new(0.3, -0.2, 1.0), Vec3::new(-1.0, 0.7, 0.9)] {
            for (offset, unit) in [(Vec3::ZERO, 1.0), (Vec3::new(1e3, -3e3, 2e3), 1.0), (Vec3::ZERO, 1e-6)] {
                let region = [offset - 8.0 * unit, offset + 8.0 * unit];
                let (plane, _) = Plane::new(direction, region, region).unwrap();
                for trial in 0..6000 {
                    // Any triangle, one that is seen from its edge, and one with an edge along the rays:
                    // which way the corners of the latter turn is chance.
                    let kind = trial % 3;
                    let (a, b) = (numbers.point(), numbers.point());
                    let along = direction * (numbers.next() - 0.5);
                    let c = [numbers.point(), a.lerp(b, numbers.next()) + along, b + along][kind];
                    let triangle = [a, b, c].map(|corner| offset + corner * unit);
                    let [a, b, c] = triangle;
                    let on_edge = [a.lerp(b, numbers.next()), b.lerp(c, numbers.next()), a][trial / 3 % 3];
                    let origin = on_edge - direction * (3.0 * unit * numbers.next());
                    let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
                    if !Bvh::build(&[triangle]).any(&ray, |_| true) {
                        continue;
                    }

                    let corners = triangle.map(|corner| plane.place(corner));
                    let image = Image { corners, top: 0.0, triangle: 0 };
                    let place = plane.place(origin);
                    let [lower, upper] = image.bounds(plane.margin);
                    let is_touched = image.touches([place - plane.margin, place + plane.margin]);
                    assert!(
                        is_touched && (lower.cmple(place) & place.cmple(upper)).all(),
                        "{ray:?} {triangle:?}"
                    );
                    met[kind] += 1;
                    let [lower, upper] = image.bounds(Vec2::ZERO);
                    let is_inside = (lower.cmple(place) & place.cmple(upper)).all();
                    apart[kind] += usize::from(!is_inside || !image.touches([place, place]));
                }
            }
        }
        assert!(met.into_iter().all(|count| count > 300), "{met:?} hits");
        assert!(apart.into_iter().all(|count| count > 30), "{apart:?} would be missed without a margin");
    }
}
