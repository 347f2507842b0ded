//! The tree as a traversal reads it, borrowed from whoever built it.

use glam::Vec3A;

use crate::build::Part;
use crate::node::{Block, Child, Node};
use crate::simd::lanes::Lanes;

/// What a traversal reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tree<'a> {
    pub(crate) nodes: &'a [Node],
    pub(crate) blocks: &'a [Block],
    /// The node or leaf that holds all others; none without triangles.
    pub(crate) root: Option<Child>,
    pub(crate) lower: Vec3A,
    pub(crate) upper: Vec3A,
}

impl<'a> Tree<'a> {
    #[inline(always)]
    pub(crate) fn new(nodes: &'a [Node], blocks: &'a [Block], whole: Option<Part>) -> Self {
        let (lower, upper) = whole.map_or((Vec3A::ZERO, Vec3A::ZERO), |part| part.bounds.corners());
        Self { nodes, blocks, root: whole.map(|part| part.root), lower, upper }
    }

    /// Asks for the memory of a child.
    #[inline(always)]
    pub(crate) fn prefetch<L: Lanes>(&self, lanes: L, child: Child) {
        if child.is_block() {
            lanes.prefetch(&self.blocks[child.index()]);
        } else {
            lanes.prefetch(&self.nodes[child.index()]);
        }
    }
}
