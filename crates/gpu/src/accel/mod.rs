//! What rays are traced through: the driver's own structure where the adapter has ray query, else the CPU's
//! tree.
//!
//! Both are built over the triangles of a frame, and what never moves is built once. Shaders reach them by
//! two bindings, whose meaning `shared/accel_query.wgsl` and `shared/accel_bvh.wgsl` declare, and give the
//! same hits.

use sheer_accel::{Bvh, PackedTree};
use sheer_scene::Frame;
use wgpu::ShaderStages;

use self::{driver::DriverAccel, tree::TreeAccel};
use crate::{
    device::{Gpu, Tracer},
    error::GpuError,
    shader::constant::{self, Constant},
};

pub(crate) mod driver;
pub(crate) mod tree;

/// An acceleration structure over all triangles of a frame.
#[derive(Debug)]
pub(crate) enum Accel {
    /// Built by the driver, for ray query.
    Driver(DriverAccel),
    /// Built by [`sheer_accel`] and sent to the device.
    Tree { tree: Bvh, buffers: TreeAccel },
}

impl Accel {
    /// Builds the structure of the device's [`Tracer`]. `positions` holds the frame's triangles on the
    /// device.
    ///
    /// # Errors
    /// The device allows no structure of that size.
    pub(crate) fn new(gpu: &Gpu, positions: &wgpu::Buffer, frame: &Frame) -> Result<Self, GpuError> {
        let (device, queue) = (gpu.device(), gpu.queue());
        Ok(match gpu.tracer() {
            Tracer::Query => {
                let mut accel = Self::Driver(DriverAccel::new(&device)?);
                accel.update(gpu, positions, frame)?;
                accel
            }
            Tracer::Bvh => {
                let mut tree = Bvh::build(&frame.triangles()[..frame.static_count()]);
                tree.rebuild_after(frame.static_count(), frame.triangles());
                let buffers = TreeAccel::new(&device, &queue, &tree)?;
                Self::Tree { tree, buffers }
            }
        })
    }

    /// Builds anew what has moved since the last frame of the same animator. True if [`Self::entries`] gives
    /// other buffers than before.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn update(
        &mut self,
        gpu: &Gpu,
        positions: &wgpu::Buffer,
        frame: &Frame,
    ) -> Result<bool, GpuError> {
        let (device, queue) = (gpu.device(), gpu.queue());
        let (triangles, static_count) = (frame.triangles(), frame.static_count());
        match self {
            Self::Driver(accel) => {
                let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let replaced =
                    accel.update(&device, &queue, &mut encoder, positions, triangles, static_count)?;
                queue.submit([encoder.finish()]);
                Ok(replaced)
            }
            Self::Tree { tree, buffers } => {
                tree.rebuild_after(static_count, triangles);
                buffers.update(&device, &queue, tree)
            }
        }
    }

    /// Bytes of the buffers that shaders read or the driver builds from.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Driver(accel) => accel.bytes(),
            Self::Tree { buffers, .. } => buffers.bytes(),
        }
    }

    /// The layout of [`Self::entries`].
    pub(crate) fn layout_entries(
        tracer: Tracer,
        visibility: ShaderStages,
    ) -> [wgpu::BindGroupLayoutEntry; 2] {
        match tracer {
            Tracer::Query => DriverAccel::layout_entries(visibility),
            Tracer::Bvh => TreeAccel::layout_entries(visibility),
        }
    }

    /// The structure's part of group 0.
    pub(crate) fn entries(&self) -> [wgpu::BindGroupEntry<'_>; 2] {
        match self {
            Self::Driver(accel) => accel.entries(),
            Self::Tree { buffers, .. } => buffers.entries(),
        }
    }
}

/// The constants of shared/intersect.wgsl and of both traversals, as WGSL.
pub(crate) fn constants() -> String {
    // Fusion and rounding err by 2^-24 of a product each; twice their sum is beyond doubt.
    let area_doubt = 2.0 * f32::EPSILON;
    // The driver's t and ours differ by some roundings; this is sixteen.
    let query_slack: f32 = 1e-6;
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
    let reals = reals.into_iter().map(|(name, value)| Constant::new(name, value));
    let counts = counts.into_iter().map(|(name, value)| Constant::new(name, value));
    constant::text(&reals.chain(counts).collect::<Vec<_>>())
}
