//! Where a tree lies: in the world as it is stored, or placed there by an affine map.
//!
//! What is placed is taken to world coordinates on the way, boxes and vertices alike, and everything else is
//! the traversal's. A vertex gets the bits that `Affine3A::transform_point3` gives it, so that an instance is
//! hit exactly as its triangles would be, were they stored in world space. A box becomes the box around its
//! image by the same sums; as rounding is monotonic, it holds the rounded vertices without any slack, however
//! flat or mirrored the map is. The alternative, a ray in the space of the object, has tighter boxes where an
//! instance is turned, and needs an inverse and a bound on its rounding.

use glam::{Affine3A, Vec3, Vec3A};

use crate::build::is_kept;
use crate::limits::COORDINATE_LIMIT;
use crate::node::{Block, Node, WIDTH};
use crate::simd::lanes::Lanes;

/// How a traversal sees boxes and triangles of a tree.
pub(crate) trait Placement {
    /// One plane of each child's box; `row` as in [`Node::bounds`].
    fn plane<L: Lanes>(&self, lanes: L, node: &Node, row: usize) -> L::F;
    /// Both planes of each child's box along an axis, finite where the box holds a triangle that is kept.
    fn slab<L: Lanes>(&self, lanes: L, node: &Node, axis: usize) -> [L::F; 2];
    /// Lanes that hold a child, as far as their boxes do not tell.
    fn used<L: Lanes>(&self, lanes: L, node: &Node) -> u32;
    /// One coordinate of the three vertices of each triangle.
    fn coordinates<L: Lanes>(&self, lanes: L, block: &Block, axis: usize) -> [L::F; 3];
    /// One coordinate of one vertex.
    fn coordinate(&self, block: &Block, lane: usize, vertex: usize, axis: usize) -> f32;
    /// Number of a triangle of a block for the caller.
    fn number(&self, triangle: u32) -> u32;
    /// Whether a triangle that is hit takes part at all, see [`is_kept`].
    fn keeps(&self, block: &Block, lane: usize) -> bool;
}

/// As it is stored.
pub(crate) struct InWorld;

impl Placement for InWorld {
    #[inline(always)]
    fn plane<L: Lanes>(&self, lanes: L, node: &Node, row: usize) -> L::F {
        lanes.load(&node.bounds[row])
    }

    #[inline(always)]
    fn slab<L: Lanes>(&self, lanes: L, node: &Node, axis: usize) -> [L::F; 2] {
        [lanes.load(&node.bounds[axis]), lanes.load(&node.bounds[axis + 3])]
    }

    #[inline(always)]
    fn used<L: Lanes>(&self, _: L, _: &Node) -> u32 {
        u32::MAX
    }

    #[inline(always)]
    fn coordinates<L: Lanes>(&self, lanes: L, block: &Block, axis: usize) -> [L::F; 3] {
        let [a, b, c] = &block.vertices[axis];
        [lanes.load(a), lanes.load(b), lanes.load(c)]
    }

    #[inline(always)]
    fn coordinate(&self, block: &Block, lane: usize, vertex: usize, axis: usize) -> f32 {
        block.vertices[axis][vertex][lane]
    }

    #[inline(always)]
    fn number(&self, triangle: u32) -> u32 {
        triangle
    }

    #[inline(always)]
    fn keeps(&self, _: &Block, _: usize) -> bool {
        true
    }
}

/// Placed by an affine map.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    /// Factors of x, y and z, and what is added, for each coordinate in world.
    rows: [[f32; 4]; 3],
    /// For each row of [`Node::bounds`] in world the three rows of which it is made.
    sources: [[u8; 3]; 6],
    /// Number of the first triangle.
    first_triangle: u32,
    /// Whether a triangle has left the range of coordinates or lost its area, so that each hit is looked at.
    pub(crate) some_dropped: bool,
}

impl Placed {
    pub(crate) fn new(world_from_object: &Affine3A, first_triangle: u32) -> Self {
        let Affine3A { matrix3, translation } = world_from_object;
        let rows = [0, 1, 2].map(|axis| {
            [matrix3.x_axis[axis], matrix3.y_axis[axis], matrix3.z_axis[axis], translation[axis]]
        });
        // The lower plane of an image comes from the lower planes where a factor is positive, else from the
        // upper ones.
        let sources = [0, 1, 2, 3, 4, 5].map(|row| {
            [0, 1, 2].map(|axis: u8| {
                axis + if (rows[row % 3][usize::from(axis)] < 0.0) == (row < 3) { 3 } else { 0 }
            })
        });
        Self { rows, sources, first_triangle, some_dropped: false }
    }

    /// The triangle of a block's lane in world.
    pub(crate) fn triangle(&self, block: &Block, lane: usize) -> [Vec3; 3] {
        [0, 1, 2]
            .map(|vertex| Vec3::from_array([0, 1, 2].map(|axis| self.coordinate(block, lane, vertex, axis))))
    }

    /// Lowest and highest corner of a block's triangles that are kept; notes whether some are not.
    pub(crate) fn grow(&mut self, block: &Block, [lower, upper]: [Vec3A; 2]) -> [Vec3A; 2] {
        let used = (0..WIDTH).filter(|&lane| block.triangles[lane] != u32::MAX);
        used.fold([lower, upper], |[lower, upper], lane| {
            let triangle = self.triangle(block, lane);
            if !is_kept(&triangle) {
                self.some_dropped = true;
                return [lower, upper];
            }
            let [a, b, c] = triangle.map(Vec3A::from);
            [lower.min(a).min(b).min(c), upper.max(a).max(b).max(c)]
        })
    }
}

impl Placement for Placed {
    #[inline(always)]
    fn plane<L: Lanes>(&self, lanes: L, node: &Node, row: usize) -> L::F {
        let [x, y, z] = self.sources[row];
        let [x, y, z] =
            [&node.bounds[usize::from(x)], &node.bounds[usize::from(y)], &node.bounds[usize::from(z)]];
        combine(lanes, self.rows[row % 3], [lanes.load(x), lanes.load(y), lanes.load(z)])
    }

    /// Beyond the range of coordinates nothing is kept. A plane that has left even that of numbers is the
    /// first operand, and gives way to the second.
    #[inline(always)]
    fn slab<L: Lanes>(&self, lanes: L, node: &Node, axis: usize) -> [L::F; 2] {
        let limit = lanes.splat(COORDINATE_LIMIT);
        [
            lanes.max(self.plane(lanes, node, axis), lanes.sub(lanes.splat(0.0), limit)),
            lanes.min(self.plane(lanes, node, axis + 3), limit),
        ]
    }

    /// The infinite boxes of unused lanes may have become anything.
    #[inline(always)]
    fn used<L: Lanes>(&self, lanes: L, node: &Node) -> u32 {
        lanes.lt(lanes.load(&node.bounds[0]), lanes.splat(f32::INFINITY))
    }

    #[inline(always)]
    fn coordinates<L: Lanes>(&self, lanes: L, block: &Block, axis: usize) -> [L::F; 3] {
        let [x, y, z] = &block.vertices;
        let row = self.rows[axis];
        [
            combine(lanes, row, [lanes.load(&x[0]), lanes.load(&y[0]), lanes.load(&z[0])]),
            combine(lanes, row, [lanes.load(&x[1]), lanes.load(&y[1]), lanes.load(&z[1])]),
            combine(lanes, row, [lanes.load(&x[2]), lanes.load(&y[2]), lanes.load(&z[2])]),
        ]
    }

    #[inline(always)]
    fn coordinate(&self, block: &Block, lane: usize, vertex: usize, axis: usize) -> f32 {
        let [x, y, z, added] = self.rows[axis];
        let [x_row, y_row, z_row] = &block.vertices;
        x * x_row[vertex][lane] + y * y_row[vertex][lane] + z * z_row[vertex][lane] + added
    }

    #[inline(always)]
    fn number(&self, triangle: u32) -> u32 {
        self.first_triangle + triangle
    }

    #[inline(always)]
    fn keeps(&self, block: &Block, lane: usize) -> bool {
        !self.some_dropped || is_kept(&self.triangle(block, lane))
    }
}

/// The sum of `Affine3A::transform_point3`, in its order.
#[inline(always)]
fn combine<L: Lanes>(lanes: L, [x, y, z, added]: [f32; 4], point: [L::F; 3]) -> L::F {
    let sum = lanes.add(lanes.mul(point[0], lanes.splat(x)), lanes.mul(point[1], lanes.splat(y)));
    lanes.add(lanes.add(sum, lanes.mul(point[2], lanes.splat(z))), lanes.splat(added))
}
