//! The driver's acceleration structure, for adapters with ray query.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::{
    error::GpuError,
    resource::{
        bind_group::read_only_entry,
        buffer::{check_limit, grown, storage_buffer},
    },
    shader::binding::{BIND_ACCEL, BIND_ACCEL_TRIANGLES},
};

/// Custom data of an instance has 24 bits.
const CUSTOM_DATA_LIMIT: u64 = (1 << 24) - 1;

const IDENTITY: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// Bottom levels over the static and over the moving triangles of a frame, both in world, and a top level
/// over the two.
///
/// Triangles go to the driver along a Morton curve: Mesa's llvmpipe builds its tree in the order given, and
/// is tens of times slower without. `order` in shared/accel_query.wgsl leads back. Triangles that the CPU's
/// tree ignores ([`sheer_accel::is_kept`]) are left out.
#[derive(Debug)]
pub(crate) struct DriverAccel {
    top: wgpu::Tlas,
    fixed: Option<Bottom>,
    moving: Option<Bottom>,
    /// The `static_count` that `fixed` was built for.
    static_count: Option<usize>,
    /// Triangles of the static primitives, then of the moving ones.
    order: wgpu::Buffer,
    /// The static part of `order`, for a buffer that has grown.
    fixed_order: Vec<u32>,
}

/// A bottom level and the indices it is built from.
#[derive(Debug)]
struct Bottom {
    blas: wgpu::Blas,
    /// Three a triangle, relative to the part's first vertex.
    indices: wgpu::Buffer,
    /// Triangles there is room for.
    capacity: u32,
}

/// The part of a frame that a bottom level is about to be built over.
struct Build {
    /// Which of the frame's triangles it holds.
    range: Range<usize>,
    /// Indices of the triangles that are kept, along the Morton curve.
    order: Vec<u32>,
}

impl DriverAccel {
    /// A structure over nothing; [`DriverAccel::update`] comes before the first use.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when the device has too few instances.
    pub(crate) fn new(device: &wgpu::Device) -> Result<Self, GpuError> {
        check_limit("the top level", 2, device.limits().max_tlas_instance_count.into())?;
        let top = device.create_tlas(&wgpu::CreateTlasDescriptor {
            label: Some("top level"),
            max_instances: 2,
            flags: wgpu::AccelerationStructureFlags::PREFER_FAST_TRACE,
            update_mode: wgpu::AccelerationStructureUpdateMode::Build,
        });
        let order = storage_buffer(device, "triangle order", 4, 0)?;
        Ok(Self { top, fixed: None, moving: None, static_count: None, order, fixed_order: Vec::new() })
    }

    /// Records the build for a frame. The first `static_count` triangles stay as they were at the last call
    /// with that `static_count`, and are not built again. `positions` holds nine floats a triangle, has the
    /// usage `BLAS_INPUT`, and is filled before the encoder's commands run. True if [`DriverAccel::entries`]
    /// gives another buffer than before.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when there are too many triangles; nothing is recorded then.
    pub(crate) fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        positions: &wgpu::Buffer,
        triangles: &[[Vec3; 3]],
        static_count: usize,
    ) -> Result<bool, GpuError> {
        // Which parts are built, and in which order their triangles go to the driver.
        let static_count = static_count.min(triangles.len());
        let fixed = (self.static_count != Some(static_count)).then(|| Build::new(triangles, 0..static_count));
        let moving = Build::new(triangles, static_count..triangles.len());
        let fixed_len = fixed.as_ref().map_or(self.fixed_order.len(), |build| build.order.len());

        // All limits before anything changes.
        check_limit("the static part of the scene", fixed_len as u64, CUSTOM_DATA_LIMIT)?;
        let vertex_limit = u64::from(device.limits().max_blas_primitive_count);
        for count in [static_count, triangles.len() - static_count] {
            check_limit("a bottom level's vertices", 3 * count as u64, vertex_limit)?;
        }
        let order_bytes = 4 * (fixed_len + moving.order.len()) as u64;
        let order = grown(device, &self.order, "triangle order", order_bytes)?;
        let new_fixed = fixed.as_ref().map(|build| build.room(device, None, FIXED)).transpose()?;
        let new_moving = moving.room(device, self.moving.take(), MOVING)?;

        // From here on nothing fails.
        let replaced = order.is_some();
        if let Some(order) = order {
            self.order = order;
        }
        if let Some(bottom) = new_fixed {
            self.fixed = bottom;
        }
        self.moving = new_moving;
        if let Some(build) = &fixed {
            (self.static_count, self.fixed_order) = (Some(static_count), build.order.clone());
        }
        // Triangles of the primitives are sent where they or their buffer are new.
        if replaced || fixed.is_some() {
            queue.write_buffer(&self.order, 0, bytemuck::cast_slice(&self.fixed_order));
        }
        queue.write_buffer(&self.order, 4 * fixed_len as u64, bytemuck::cast_slice(&moving.order));
        self.record(queue, encoder, positions, fixed.as_ref(), &moving);
        Ok(replaced)
    }

    fn record(
        &mut self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        positions: &wgpu::Buffer,
        fixed: Option<&Build>,
        moving: &Build,
    ) {
        let instance = |bottom: &Option<Bottom>, first: usize| {
            bottom
                .as_ref()
                .map(|bottom| wgpu::TlasInstance::new(&bottom.blas, IDENTITY, first as u32, u8::MAX))
        };
        self.top[0] = instance(&self.fixed, 0);
        self.top[1] = instance(&self.moving, self.fixed_order.len());

        let parts = [(fixed, &self.fixed), (Some(moving), &self.moving)];
        let parts: Vec<(&Build, &Bottom, _)> = parts
            .into_iter()
            .filter_map(|(build, bottom)| Some((build?, bottom.as_ref()?)))
            .map(|(build, bottom)| (build, bottom, build.size()))
            .collect();
        let entries: Vec<wgpu::BlasBuildEntry<'_>> = parts
            .iter()
            .map(|(build, bottom, size)| {
                queue.write_buffer(&bottom.indices, 0, bytemuck::cast_slice(&build.indices()));
                wgpu::BlasBuildEntry {
                    blas: &bottom.blas,
                    geometry: wgpu::BlasGeometries::TriangleGeometries(vec![wgpu::BlasTriangleGeometry {
                        size,
                        vertex_buffer: positions,
                        first_vertex: 3 * build.range.start as u32,
                        vertex_stride: size_of::<Vec3>() as u64,
                        index_buffer: Some(&bottom.indices),
                        first_index: Some(0),
                        transform_buffer: None,
                        transform_buffer_offset: None,
                    }]),
                }
            })
            .collect();
        encoder.build_acceleration_structures(entries.iter(), std::iter::once(&self.top));
    }

    /// Bytes of the buffers that it is built from; what the driver keeps of them is the driver's secret.
    pub(crate) fn bytes(&self) -> u64 {
        let bottoms = [&self.fixed, &self.moving].into_iter().flatten();
        self.order.size() + bottoms.map(|bottom| bottom.indices.size()).sum::<u64>()
    }

    /// What the bindings of acceleration structures in group 0 hold.
    pub(crate) fn entries(&self) -> [wgpu::BindGroupEntry<'_>; 2] {
        [
            wgpu::BindGroupEntry { binding: BIND_ACCEL, resource: self.top.as_binding() },
            wgpu::BindGroupEntry { binding: BIND_ACCEL_TRIANGLES, resource: self.order.as_entire_binding() },
        ]
    }

    /// The layout of the bindings of acceleration structures in group 0.
    pub(crate) fn layout_entries(visibility: wgpu::ShaderStages) -> [wgpu::BindGroupLayoutEntry; 2] {
        let ty = wgpu::BindingType::AccelerationStructure { vertex_return: false };
        [
            wgpu::BindGroupLayoutEntry { binding: BIND_ACCEL, visibility, ty, count: None },
            read_only_entry(BIND_ACCEL_TRIANGLES, visibility),
        ]
    }
}

/// What a bottom level is called, and what matters of it.
type Kind = (&'static str, wgpu::AccelerationStructureFlags);

const FIXED: Kind = ("static triangles", wgpu::AccelerationStructureFlags::PREFER_FAST_TRACE);
const MOVING: Kind = ("moving triangles", wgpu::AccelerationStructureFlags::PREFER_FAST_BUILD);

impl Build {
    fn new(triangles: &[[Vec3; 3]], range: Range<usize>) -> Self {
        Self { order: morton_order(triangles, range.clone()), range }
    }

    /// Vertex indices of the primitives, relative to the part's first vertex.
    fn indices(&self) -> Vec<[u32; 3]> {
        let first = self.range.start as u32;
        self.order
            .par_iter()
            .map(|triangle| [0, 1, 2].map(|vertex| 3 * (triangle - first) + vertex))
            .collect()
    }

    fn size(&self) -> wgpu::BlasTriangleGeometrySizeDescriptor {
        triangles_of(self.range.len() as u32, self.order.len() as u32)
    }

    /// A bottom level with room for the part: the old one if it has, else a new one, half again as large as
    /// the old. None without triangles.
    fn room(
        &self,
        device: &wgpu::Device,
        old: Option<Bottom>,
        (label, flags): Kind,
    ) -> Result<Option<Bottom>, GpuError> {
        let needed = self.range.len() as u32;
        if self.order.is_empty() {
            return Ok(None);
        }
        let old_capacity = match old {
            Some(old) if needed <= old.capacity => return Ok(Some(old)),
            Some(old) => old.capacity,
            None => 0,
        };
        let limits = device.limits();
        let wished = old_capacity.saturating_add(old_capacity / 2).min(limits.max_blas_primitive_count / 3);
        let capacity = needed.max(wished);
        let index_bytes = u64::from(capacity) * size_of::<[u32; 3]>() as u64;
        check_limit("the indices of a bottom level", index_bytes, limits.max_buffer_size)?;
        let blas = device.create_blas(
            &wgpu::CreateBlasDescriptor {
                label: Some(label),
                flags,
                update_mode: wgpu::AccelerationStructureUpdateMode::Build,
            },
            wgpu::BlasGeometrySizeDescriptors::Triangles {
                descriptors: vec![triangles_of(capacity, capacity)],
            },
        );
        let indices = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: index_bytes,
            usage: wgpu::BufferUsages::BLAS_INPUT | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Some(Bottom { blas, indices, capacity }))
    }
}

/// `indexed` triangles among the vertices of `count`.
fn triangles_of(count: u32, indexed: u32) -> wgpu::BlasTriangleGeometrySizeDescriptor {
    wgpu::BlasTriangleGeometrySizeDescriptor {
        vertex_format: wgpu::VertexFormat::Float32x3,
        vertex_count: 3 * count,
        index_format: Some(wgpu::IndexFormat::Uint32),
        index_count: Some(3 * indexed),
        // Not opaque, so that each hit is a candidate; each once, as compositing methods count them.
        flags: wgpu::AccelerationStructureGeometryFlags::NO_DUPLICATE_ANY_HIT_INVOCATION,
    }
}

/// The kept ones of `triangles[range]` along a Morton curve through their boxes' middles; ties by index.
fn morton_order(triangles: &[[Vec3; 3]], range: Range<usize>) -> Vec<u32> {
    let middle = |index: usize| {
        let [a, b, c] = triangles[index];
        (a.min(b).min(c).as_dvec3() + a.max(b).max(c).as_dvec3()) * 0.5
    };
    let kept: Vec<u32> = range
        .into_par_iter()
        .filter(|&index| sheer_accel::is_kept(&triangles[index]))
        .map(|index| index as u32)
        .collect();
    let empty = || (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (lower, upper) = kept
        .par_iter()
        .map(|&index| (middle(index as usize), middle(index as usize)))
        .reduce(empty, |a, b| (a.0.min(b.0), a.1.max(b.1)));
    // One cell size on all axes: cells are cubes.
    let scale = CELLS / (upper - lower).max_element().max(f64::MIN_POSITIVE);
    let mut keyed: Vec<(u64, u32)> = kept
        .into_par_iter()
        .map(|index| {
            let cell = ((middle(index as usize) - lower) * scale).min(DVec3::splat(CELLS));
            (spread(cell.x as u64) | spread(cell.y as u64) << 1 | spread(cell.z as u64) << 2, index)
        })
        .collect();
    keyed.par_sort_unstable();
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// The last cell of the curve's grid along an axis: 21 bits each make a key of 63.
const CELLS: f64 = ((1 << 21) - 1) as f64;

/// Puts two zero bits before each of the lowest 21 bits.
fn spread(bits: u64) -> u64 {
    let bits = (bits | bits << 32) & 0x001f_0000_0000_ffff;
    let bits = (bits | bits << 16) & 0x001f_0000_ff00_00ff;
    let bits = (bits | bits << 8) & 0x100f_00f0_0f00_f00f;
    let bits = (bits | bits << 4) & 0x10c3_0c30_c30c_30c3;
    (bits | bits << 2) & 0x1249_2492_4924_9249
}
