//! The CPU's tree in buffers of the device, for adapters without ray query.

use sheer_accel::{Bvh, PackedTree};

use crate::{
    error::GpuError,
    resource::{
        bind_group::{read_only_entry, whole},
        buffer::{grown, storage_buffer},
    },
};

/// Bytes before the first node: the root's box and reference, see `BvhNodes` in shared/accel_bvh.wgsl.
const HEADER_BYTES: u64 = size_of::<Header>() as u64;

/// What the shader reads before the nodes.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Header {
    lower: [f32; 3],
    root: u32,
    upper: [f32; 3],
    unused: u32,
}

/// A [`Bvh`] on the device. Grows by half again, so that a scene whose triangle count rises seldom pays for new buffers.
#[derive(Debug)]
pub(crate) struct TreeAccel {
    nodes: wgpu::Buffer,
    blocks: wgpu::Buffer,
    /// [`PackedTree::kept_id`] of what lies in the buffers; `None` in new ones.
    kept_id: Option<u64>,
}

impl TreeAccel {
    /// Uploads a tree.
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

    /// Uploads the tree of another frame: only what [`Bvh::rebuild_after`] has made anew. True if [`TreeAccel::entries`]
    /// gives other buffers than before.
    ///
    /// # Errors
    /// As [`TreeAccel::new`]; the old tree stays.
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
        let header =
            Header { lower: tree.lower.into(), root: tree.root, upper: tree.upper.into(), unused: 0 };
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

    /// What bindings 15 and 16 of group 0 hold.
    pub(crate) fn entries(&self) -> [wgpu::BindGroupEntry<'_>; 2] {
        [whole(15, &self.nodes), whole(16, &self.blocks)]
    }

    /// The layout of bindings 15 and 16 of group 0.
    pub(crate) fn layout_entries(visibility: wgpu::ShaderStages) -> [wgpu::BindGroupLayoutEntry; 2] {
        [15, 16].map(|binding| read_only_entry(binding, visibility))
    }
}

/// At least one node, as a runtime-sized array cannot be empty.
fn node_bytes(tree: &PackedTree<'_>) -> u64 {
    HEADER_BYTES + tree.nodes.len().max(PackedTree::NODE_BYTES) as u64
}

fn block_bytes(tree: &PackedTree<'_>) -> u64 {
    tree.blocks.len().max(PackedTree::BLOCK_BYTES) as u64
}
