//! The CPU's tree in buffers of the device, for adapters without ray query.

use sheer_accel::{Bvh, PackedTree};

use crate::{
    error::GpuError,
    resource::{
        bind_group::{read_only_entry, whole},
        buffer::{grown, storage_buffer},
    },
    shader::{
        binding::{BIND_ACCEL, BIND_ACCEL_TRIANGLES},
        record::tree::BvhHeader,
    },
};

/// Bytes before the first node: the root's box and reference.
const HEADER_BYTES: u64 = size_of::<BvhHeader>() as u64;

/// A [`Bvh`] on the device. Grows by half again, so that a scene whose triangle count rises seldom pays for
/// new buffers.
#[derive(Debug)]
pub(crate) struct TreeAccel {
    nodes: wgpu::Buffer,
    blocks: wgpu::Buffer,
    /// [`PackedTree::kept_id`] of what lies in the buffers; `None` in new ones.
    kept_id: Option<u64>,
}

impl TreeAccel {
    /// Makes buffers for a tree and sends it whole.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when it exceeds a buffer of the device.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue, bvh: &Bvh) -> Result<Self, GpuError> {
        let tree = bvh.packed();
        let mut buffers = Self {
            nodes: storage_buffer(device, "tree nodes", node_bytes(&tree), 0)?,
            blocks: storage_buffer(device, "tree blocks", block_bytes(&tree), 0)?,
            kept_id: None,
        };
        buffers.write(queue, &tree);
        Ok(buffers)
    }

    /// Uploads the tree of another frame: only what [`Bvh::rebuild_after`] has made anew. True if
    /// [`TreeAccel::entries`] gives other buffers than before.
    ///
    /// # Errors
    /// As [`TreeAccel::new`]; what lay on the device stays.
    pub(crate) fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        bvh: &Bvh,
    ) -> Result<bool, GpuError> {
        let tree = bvh.packed();
        let nodes = grown(device, &self.nodes, "tree nodes", node_bytes(&tree))?;
        let blocks = grown(device, &self.blocks, "tree blocks", block_bytes(&tree))?;
        let replaced = nodes.is_some() || blocks.is_some();
        if replaced {
            self.kept_id = None;
        }
        if let Some(nodes) = nodes {
            self.nodes = nodes;
        }
        if let Some(blocks) = blocks {
            self.blocks = blocks;
        }
        self.write(queue, &tree);
        Ok(replaced)
    }

    fn write(&mut self, queue: &wgpu::Queue, tree: &PackedTree<'_>) {
        let header = BvhHeader { lower: tree.lower, root: tree.root, upper: tree.upper, padding: 0 };
        queue.write_buffer(&self.nodes, 0, bytemuck::bytes_of(&header));
        let is_kept = self.kept_id == Some(tree.kept_id);
        let (first_node, first_block) = if is_kept { (tree.kept_nodes, tree.kept_blocks) } else { (0, 0) };
        queue.write_buffer(&self.nodes, HEADER_BYTES + first_node as u64, &tree.nodes[first_node..]);
        queue.write_buffer(&self.blocks, first_block as u64, &tree.blocks[first_block..]);
        self.kept_id = Some(tree.kept_id);
    }

    /// Bytes of both buffers.
    pub(crate) fn bytes(&self) -> u64 {
        self.nodes.size() + self.blocks.size()
    }

    /// What the bindings of acceleration structures in group 0 hold.
    pub(crate) fn entries(&self) -> [wgpu::BindGroupEntry<'_>; 2] {
        [whole(BIND_ACCEL, &self.nodes), whole(BIND_ACCEL_TRIANGLES, &self.blocks)]
    }

    /// The layout of the bindings of acceleration structures in group 0.
    pub(crate) fn layout_entries(visibility: wgpu::ShaderStages) -> [wgpu::BindGroupLayoutEntry; 2] {
        [BIND_ACCEL, BIND_ACCEL_TRIANGLES].map(|binding| read_only_entry(binding, visibility))
    }
}

/// At least one node, as a runtime-sized array cannot be empty.
fn node_bytes(tree: &PackedTree<'_>) -> u64 {
    HEADER_BYTES + tree.nodes.len().max(PackedTree::NODE_BYTES) as u64
}

fn block_bytes(tree: &PackedTree<'_>) -> u64 {
    tree.blocks.len().max(PackedTree::BLOCK_BYTES) as u64
}
