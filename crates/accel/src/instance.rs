//! Two levels: trees over meshes, which stay in the space of their object, and one over the instances that
//! place them in the world.
//!
//! Memory goes with the meshes, not with what they are drawn as. Each instance has the box of its triangles
//! in world, exact to the bit; when it moves, its box is found again and the upper tree is built again.

use std::{fmt, sync::Arc};

use glam::{Affine3A, Vec3, Vec3A};
use rayon::prelude::*;

use crate::build::{self, Bounds, Part};
use crate::limits::INDEX_LIMIT;
use crate::node::{Block, Node};
use crate::placement::Placed;
use crate::tree::Tree;

/// A tree over the triangles of a mesh, in the space of its object, which [`Instance`]s place.
#[derive(Clone)]
pub struct MeshTree {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
    part: Option<Part>,
    triangle_count: usize,
}

impl MeshTree {
    /// Builds a tree on the threads of the current rayon pool; their number does not change it.
    #[must_use]
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        let (mut nodes, mut blocks) = (Vec::new(), Vec::new());
        let part = build::build(triangles, 0..triangles.len(), 0, &mut nodes, &mut blocks);
        Self { nodes, blocks, part, triangle_count: triangles.len() }
    }

    fn tree(&self) -> Tree<'_> {
        Tree::new(&self.nodes, &self.blocks, self.part)
    }
}

impl fmt::Debug for MeshTree {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("MeshTree").field("triangles", &self.triangle_count).finish_non_exhaustive()
    }
}

/// A mesh placed in the world.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Index into the meshes that [`crate::Bvh::build_with_meshes`] was given.
    pub mesh: usize,
    /// Where it lies; any affine map, mirrored and flat ones, too.
    pub world_from_object: Affine3A,
    /// [`crate::Hit::triangle`] of its first triangle; the others follow.
    pub first_triangle: u32,
}

/// The tree over the instances.
#[derive(Clone)]
pub(crate) struct TopLevel {
    meshes: Arc<[MeshTree]>,
    placed: Vec<Found>,
    /// Leaves are no blocks but indices into `placed`.
    nodes: Vec<Node>,
    part: Option<Part>,
}

/// An instance and the box of its triangles in world; none if it has no triangle that is kept.
#[derive(Clone)]
struct Found {
    mesh: usize,
    placed: Placed,
    bounds: Option<[Vec3A; 2]>,
}

impl TopLevel {
    pub(crate) fn new(meshes: Vec<MeshTree>) -> Self {
        Self { meshes: meshes.into(), placed: Vec::new(), nodes: Vec::new(), part: None }
    }

    /// Places the instances, of which the first `still_count` are where they were, as far as they were there.
    pub(crate) fn place(&mut self, still_count: usize, instances: &[Instance]) {
        self.placed.truncate(still_count.min(instances.len()));
        let new = &instances[self.placed.len()..];
        self.placed.par_extend(new.par_iter().map(|instance| Found::new(&self.meshes, instance)));

        // Those without a box are in no leaf.
        let (boxes, owners): (Vec<_>, Vec<_>) = (0..)
            .zip(&self.placed)
            .filter_map(|(index, found)| found.bounds.map(|bounds| (Bounds::new(bounds), index)))
            .unzip();
        self.nodes.clear();
        self.part = build::build_over(&boxes, &owners, &mut self.nodes);
    }

    /// The tree over the boxes of the instances; what stands in the place of blocks goes to
    /// [`Self::instance`].
    pub(crate) fn tree(&self) -> Tree<'_> {
        Tree::new(&self.nodes, &[], self.part)
    }

    pub(crate) fn bounds(&self) -> Option<Bounds> {
        self.part.map(|part| part.bounds)
    }

    #[inline(always)]
    pub(crate) fn instance(&self, index: usize) -> (Tree<'_>, &Placed) {
        let found = &self.placed[index];
        (self.meshes[found.mesh].tree(), &found.placed)
    }
}

impl Found {
    fn new(meshes: &[MeshTree], instance: &Instance) -> Self {
        let mesh = &meshes[instance.mesh];
        let mut placed = Placed::new(&instance.world_from_object, instance.first_triangle);
        let nothing = [Vec3A::INFINITY, Vec3A::NEG_INFINITY];
        let in_range = instance.first_triangle as usize + mesh.triangle_count <= INDEX_LIMIT;
        let blocks = if in_range { &mesh.blocks[..] } else { &[] };
        let [lower, upper] = blocks.iter().fold(nothing, |bounds, block| placed.grow(block, bounds));
        Self { mesh: instance.mesh, placed, bounds: (lower.x <= upper.x).then_some([lower, upper]) }
    }
}
