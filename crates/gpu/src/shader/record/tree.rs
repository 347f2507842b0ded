//! Our own tree of eight children a node, in the layout of [`PackedTree`].

use glam::{UVec4, Vec3, Vec4};
use sheer_accel::PackedTree;

use crate::shader::declaration::shader_struct;

shader_struct! {
    /// What comes before the nodes.
    struct BvhHeader {
        /// Lower corner of the box around all triangles, world.
        lower: Vec3,
        /// Where a ray begins; BVH_NONE without triangles.
        root: u32,
        /// Upper corner of the box around all triangles, world.
        upper: Vec3,
        /// Fills the last row.
        padding: u32,
    }
}

shader_struct! {
    /// A node with eight children.
    struct BvhNode {
        /// Lower x, y, z, then upper x, y, z: four children, then the other four.
        bounds: [[Vec4; 2]; 6],
        /// Indices of nodes or, with BVH_BLOCK, of blocks; BVH_NONE in unused lanes.
        children: [UVec4; 2],
    }
}

shader_struct! {
    /// Up to eight triangles.
    struct BvhBlock {
        /// `vertices[axis][vertex][lane]`, world.
        vertices: [[[f32; 8]; 3]; 3],
        /// Triangles of the frame; BVH_NONE from the first unused lane on.
        triangles: [u32; 8],
    }
}

const _: () = assert!(
    size_of::<BvhNode>() == PackedTree::NODE_BYTES && size_of::<BvhBlock>() == PackedTree::BLOCK_BYTES,
    "what is sent is the tree of sheer_accel"
);
