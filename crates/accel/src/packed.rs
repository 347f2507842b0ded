//! The tree as bytes, for a processor that traverses it by itself.

use glam::Vec3;

use crate::limits::{COORDINATE_LIMIT, LEAST_SPEED, LEVEL_LIMIT, SPEED_LIMIT};
use crate::node::{Block, Child, Node, WIDTH};
use crate::traverse::Slabs;

/// A tree as it lies in memory, borrowed from [`crate::Bvh::packed`]. All numbers have the processor's byte
/// order.
///
/// * A node, [`PackedTree::NODE_BYTES`]: `bounds: [[f32; 8]; 6]` (lower x, y, z, then upper x, y, z, of each
///   of eight children), then `children: [u32; 8]`.
/// * A block, [`PackedTree::BLOCK_BYTES`]: `vertices: [[[f32; 8]; 3]; 3]` (by axis, vertex and lane), then
///   `triangles: [u32; 8]`. Unused lanes come last and hold NaN and [`PackedTree::NONE`].
/// * A reference to a child: [`PackedTree::NONE`] in unused lanes (not always the last), the index of a block
///   with the bit [`PackedTree::BLOCK`], else the index of a node.
///
/// The first [`PackedTree::kept_nodes`] and [`PackedTree::kept_blocks`] bytes are the part that
/// [`crate::Bvh::rebuild_after`] keeps: they are the same in all trees of the same [`PackedTree::kept_id`].
#[derive(Clone, Copy, Debug)]
pub struct PackedTree<'a> {
    /// The nodes; some are no longer reached from the root.
    pub nodes: &'a [u8],
    /// The leaf blocks, as bytes.
    pub blocks: &'a [u8],
    /// Reference to the root, [`PackedTree::NONE`] without triangles.
    pub root: u32,
    /// Lowest corner of all triangles; 0 without any.
    pub lower: Vec3,
    /// Highest corner of all triangles; 0 without any.
    pub upper: Vec3,
    /// Changes whenever the kept part does, and is never used again in this process.
    pub kept_id: u64,
    /// Bytes of `nodes` that belong to the kept part.
    pub kept_nodes: usize,
    /// Bytes of `blocks` that belong to the kept part.
    pub kept_blocks: usize,
}

impl PackedTree<'_> {
    /// Bytes of a node.
    pub const NODE_BYTES: usize = size_of::<Node>();
    /// Bytes of a block.
    pub const BLOCK_BYTES: usize = size_of::<Block>();
    /// A reference to nothing, and the triangle of an unused lane.
    pub const NONE: u32 = Child::NONE.0;
    /// Marks references to blocks.
    pub const BLOCK: u32 = Child::BLOCK;
    /// References that a traversal has waiting at most, if it takes one away before it adds that node's
    /// children.
    pub const STACK_SIZE: u32 = LEVEL_LIMIT * (WIDTH as u32 - 1) + 1;
    /// Largest magnitude of a coordinate of a ray's origin.
    pub const COORDINATE_LIMIT: f32 = COORDINATE_LIMIT;
    /// Largest component that a ray's direction may have.
    pub const SPEED_LIMIT: f32 = SPEED_LIMIT;
    /// Least value of the largest component of a ray's direction.
    pub const LEAST_SPEED: f32 = LEAST_SPEED;
    /// How far boxes are widened, relative to the sum of their largest distance along an axis and along all
    /// axes.
    pub const PADDING: f32 = Slabs::PADDING;
    /// How far boxes are widened, relative to the ray's origin.
    pub const ORIGIN_PADDING: f32 = Slabs::ORIGIN_PADDING;
    /// Relative slack of box distances.
    pub const SLACK: f32 = Slabs::SLACK;
    /// Least speed along an axis that the box test reckons with, relative to the fastest.
    pub const SLOWEST: f32 = Slabs::SLOWEST;
}
