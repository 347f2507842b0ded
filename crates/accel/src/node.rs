//! Memory layout of the tree: nodes and leaf blocks, eight lanes each.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Children of a node and triangles of a leaf.
pub(crate) const WIDTH: usize = 8;

/// Points at a [`Node`] or, with the top bit set, at a [`Block`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct Child(pub(crate) u32);

impl Child {
    pub(crate) const BLOCK: u32 = 1 << 31;
    /// Fills unused lanes, whose boxes no ray enters.
    pub(crate) const NONE: Self = Self(u32::MAX);

    pub(crate) fn node(index: usize) -> Self {
        Self(index as u32)
    }

    pub(crate) fn block(index: usize) -> Self {
        Self(index as u32 | Self::BLOCK)
    }

    #[inline(always)]
    pub(crate) fn is_block(self) -> bool {
        self.0 & Self::BLOCK != 0
    }

    /// Index among the nodes or among the blocks.
    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        (self.0 & !Self::BLOCK) as usize
    }

    /// The same child after `nodes` nodes and `blocks` blocks were put before its array.
    pub(crate) fn shifted(self, nodes: usize, blocks: usize) -> Self {
        if self == Self::NONE {
            self
        } else if self.is_block() {
            Self::block(self.index() + blocks)
        } else {
            Self::node(self.index() + nodes)
        }
    }
}

/// Eight child boxes and where they lead. 224 bytes: full precision, since quantised boxes cost more to
/// decode than they save while the tree fits the last-level cache.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Node {
    /// Lower x, y, z, then upper x, y, z, of each child. Unused lanes hold +inf and -inf.
    pub(crate) bounds: [[f32; WIDTH]; 6],
    pub(crate) children: [Child; WIDTH],
}

impl Node {
    pub(crate) const EMPTY: Self = Self {
        bounds: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [Child::NONE; WIDTH],
    };

    pub(crate) fn set(&mut self, lane: usize, lower: Vec3, upper: Vec3, child: Child) {
        for axis in 0..3 {
            self.bounds[axis][lane] = lower[axis];
            self.bounds[axis + 3][lane] = upper[axis];
        }
        self.children[lane] = child;
    }

    pub(crate) fn lower(&self, lane: usize) -> Vec3 {
        Vec3::new(self.bounds[0][lane], self.bounds[1][lane], self.bounds[2][lane])
    }

    pub(crate) fn upper(&self, lane: usize) -> Vec3 {
        Vec3::new(self.bounds[3][lane], self.bounds[4][lane], self.bounds[5][lane])
    }
}

/// A leaf: up to eight triangles. Unused lanes hold NaN, which passes no comparison.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Coordinates by axis first, as the watertight test picks its axes by the ray:
    /// `vertices[axis][vertex][lane]`.
    pub(crate) vertices: [[[f32; WIDTH]; 3]; 3],
    /// Indices of the triangles, `u32::MAX` in unused lanes.
    pub(crate) triangles: [u32; WIDTH],
}

impl Block {
    pub(crate) const EMPTY: Self =
        Self { vertices: [[[f32::NAN; WIDTH]; 3]; 3], triangles: [u32::MAX; WIDTH] };

    pub(crate) fn set(&mut self, lane: usize, triangle: &[Vec3; 3], index: u32) {
        for (vertex, position) in triangle.iter().enumerate() {
            for axis in 0..3 {
                self.vertices[axis][vertex][lane] = position[axis];
            }
        }
        self.triangles[lane] = index;
    }

    pub(crate) fn vertex(&self, lane: usize, vertex: usize) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|axis| self.vertices[axis][vertex][lane]))
    }
}
