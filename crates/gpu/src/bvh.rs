//! The CPU's tree in buffers of the device, for adapters without ray query.

use std::fmt::Write as _;

use sheer_accel::{Bvh, PackedTree};

use crate::{GpuError, bindings::buffer_entry};

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
pub(crate) struct BvhBuffers {
    nodes: wgpu::Buffer,
    blocks: wgpu::Buffer,
    /// [`PackedTree::kept_id`] of what lies in the buffers; `None` in new ones.
    kept_id: Option<u64>,
}

impl BvhBuffers {
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

    /// Uploads the tree of another frame: only what [`Bvh::rebuild_after`] has made anew. True if [`BvhBuffers::entries`]
    /// gives other buffers than before.
    ///
    /// # Errors
    /// As [`BvhBuffers::new`]; the old tree stays.
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
        [(15, &self.nodes), (16, &self.blocks)]
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
    }

    /// The layout of bindings 15 and 16 of group 0.
    pub(crate) fn layout_entries(visibility: wgpu::ShaderStages) -> [wgpu::BindGroupLayoutEntry; 2] {
        [15, 16].map(|binding| storage_layout(binding, visibility))
    }
}

/// At least one node, as a runtime-sized array cannot be empty.
fn node_bytes(tree: &PackedTree<'_>) -> u64 {
    HEADER_BYTES + tree.nodes.len().max(PackedTree::NODE_BYTES) as u64
}

fn block_bytes(tree: &PackedTree<'_>) -> u64 {
    tree.blocks.len().max(PackedTree::BLOCK_BYTES) as u64
}

/// The layout of a storage buffer that shaders read.
pub(crate) fn storage_layout(binding: u32, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    buffer_entry(binding, visibility, wgpu::BufferBindingType::Storage { read_only: true })
}

/// A larger buffer if `buffer` has fewer than `needed` bytes: half again as large as before, or as needed.
fn grown(
    device: &wgpu::Device,
    buffer: &wgpu::Buffer,
    what: &str,
    needed: u64,
) -> Result<Option<wgpu::Buffer>, GpuError> {
    let is_large_enough = needed <= buffer.size();
    (!is_large_enough).then(|| storage_buffer(device, what, needed, buffer.size() / 2 * 3)).transpose()
}

/// A storage buffer of `needed` bytes, or of `wished` if that is more and the device allows it.
pub(crate) fn storage_buffer(
    device: &wgpu::Device,
    what: &str,
    needed: u64,
    wished: u64,
) -> Result<wgpu::Buffer, GpuError> {
    let limits = device.limits();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / 4 * 4;
    check_limit(what, needed, limit)?;
    Ok(device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(what),
        size: needed.max(wished.min(limit)).next_multiple_of(4),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    }))
}

/// An error if `needed` is above `limit`.
pub(crate) fn check_limit(what: &str, needed: u64, limit: u64) -> Result<(), GpuError> {
    if needed <= limit {
        return Ok(());
    }
    Err(GpuError::Limit {
        what: what.to_owned(),
        needed,
        limit,
        instead: "take a smaller scene or --backend cpu".to_owned(),
    })
}

/// The constants of shared/intersect.wgsl and of both traversals, as WGSL.
pub(crate) fn constants() -> String {
    // Fusion and rounding err by 2^-24 of a product each; twice their sum is beyond doubt.
    let area_doubt = 2.0 * f32::EPSILON;
    // The driver's t and ours differ by some roundings; this is sixteen.
    let query_slack = 1e-6;
    let reals = [
        ("COORDINATE_LIMIT", PackedTree::COORDINATE_LIMIT),
        ("SPEED_LIMIT", PackedTree::SPEED_LIMIT),
        ("LEAST_SPEED", PackedTree::LEAST_SPEED),
        ("AREA_DOUBT", area_doubt),
        ("QUERY_SLACK", query_slack),
        ("BVH_PADDING", PackedTree::PADDING),
        ("BVH_ORIGIN_PADDING", PackedTree::ORIGIN_PADDING),
        ("BVH_SLACK", PackedTree::SLACK),
        ("BVH_SLOWEST", PackedTree::SLOWEST),
    ];
    let counts = [
        ("BVH_NONE", PackedTree::NONE),
        ("BVH_BLOCK", PackedTree::BLOCK),
        ("BVH_STACK_SIZE", PackedTree::STACK_SIZE),
    ];
    let mut text = String::new();
    for (name, value) in reals {
        // `{:?}` prints the shortest decimal that reads back as the same bits.
        writeln!(text, "const {name}: f32 = {value:?}f;").expect("a string takes any text");
    }
    for (name, value) in counts {
        writeln!(text, "const {name}: u32 = {value}u;").expect("a string takes any text");
    }
    text
}
