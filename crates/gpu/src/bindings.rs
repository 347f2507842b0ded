//! Bind groups that all passes have in common: 0 the scene and the frame, 1 the pixels that come of it and the shadow maps.

use wgpu::{BindGroupLayoutEntry, BindingType, BufferBindingType, BufferUsages, ShaderStages};

use crate::{
    GpuError,
    device::{Gpu, Tracer},
    shadow::ShadowMaps,
    stage::Stage,
};

/// Binding of the uniform of shaders/shared/frame.wgsl.
const FRAME: u32 = 0;
/// Binding of the tables of shaders/shared/tables.wgsl.
const TABLES: u32 = 14;
/// Binding of the surfaces of shaders/shared/pass.wgsl.
const SURFACES: u32 = 5;

/// Layouts of groups 0 and 1.
#[derive(Debug)]
pub(crate) struct Layouts {
    /// Group 0.
    pub(crate) scene: wgpu::BindGroupLayout,
    /// Group 1.
    pub(crate) pass: wgpu::BindGroupLayout,
}

/// A buffer in a layout.
pub(crate) fn buffer_entry(
    binding: u32,
    visibility: ShaderStages,
    ty: BufferBindingType,
) -> BindGroupLayoutEntry {
    BindGroupLayoutEntry {
        binding,
        visibility,
        ty: BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

/// A whole buffer in a bind group.
pub(crate) fn whole(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
}

impl Layouts {
    /// `has_maps`: whether light is looked up in shadow maps.
    pub(crate) fn new(device: &wgpu::Device, tracer: Tracer, has_maps: bool) -> Self {
        let every = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let writers = ShaderStages::FRAGMENT | ShaderStages::COMPUTE;
        let read_only = BufferBindingType::Storage { read_only: true };
        let mut scene = vec![
            buffer_entry(FRAME, every, BufferBindingType::Uniform),
            buffer_entry(TABLES, every, read_only),
        ];
        scene.extend(Stage::layout_entries(tracer));
        let read_write = BufferBindingType::Storage { read_only: false };
        let mut pass = [0, 1, SURFACES].map(|binding| buffer_entry(binding, writers, read_write)).to_vec();
        if has_maps {
            pass.extend(ShadowMaps::layout_entries(writers, true));
        }
        let layout = |label, entries: &[BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        Self { scene: layout("scene", &scene), pass: layout("pass", &pass) }
    }

    /// Group 0.
    pub(crate) fn scene_group(
        &self,
        device: &wgpu::Device,
        frame: &wgpu::Buffer,
        tables: &wgpu::Buffer,
        stage: &Stage,
    ) -> wgpu::BindGroup {
        let mut entries = vec![whole(FRAME, frame), whole(TABLES, tables)];
        entries.extend(stage.entries());
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene"),
            layout: &self.scene,
            entries: &entries,
        })
    }

    /// Group 1.
    pub(crate) fn pass_group(
        &self,
        device: &wgpu::Device,
        [pixels, counters, surfaces]: [&wgpu::Buffer; 3],
        shadows: Option<&ShadowMaps>,
    ) -> wgpu::BindGroup {
        let mut entries = vec![whole(0, pixels), whole(1, counters), whole(SURFACES, surfaces)];
        entries.extend(shadows.into_iter().flat_map(ShadowMaps::entries));
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("pass"),
            layout: &self.pass,
            entries: &entries,
        })
    }
}

/// A compute pipeline over groups 0, 1 and those of the pass itself.
pub(crate) fn compute_pipeline(
    device: &wgpu::Device,
    label: &str,
    groups: &[&wgpu::BindGroupLayout],
    module: &wgpu::ShaderModule,
    entry_point: &str,
) -> wgpu::ComputePipeline {
    let groups: Vec<_> = groups.iter().map(|group| Some(*group)).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
        module,
        entry_point: Some(entry_point),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}

/// A texture in a layout.
pub(crate) fn texture_entry(
    binding: u32,
    visibility: ShaderStages,
    sample_type: wgpu::TextureSampleType,
    multisampled: bool,
) -> BindGroupLayoutEntry {
    let view_dimension = wgpu::TextureViewDimension::D2;
    let ty = BindingType::Texture { sample_type, view_dimension, multisampled };
    BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

/// A texture in a bind group.
pub(crate) fn texture_in(binding: u32, view: &wgpu::TextureView) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) }
}

/// A bind group with its layout.
pub(crate) fn group(
    device: &wgpu::Device,
    label: &str,
    layout: &[BindGroupLayoutEntry],
    entries: &[wgpu::BindGroupEntry<'_>],
) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let layout = device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: layout });
    let descriptor = wgpu::BindGroupDescriptor { label: Some(label), layout: &layout, entries };
    let group = device.create_bind_group(&descriptor);
    (layout, group)
}

/// A buffer that starts with zeros.
pub(crate) fn buffer(device: &wgpu::Device, label: &str, size: u64, usage: BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}

/// A storage buffer of so many bytes a pixel, and so many more.
pub(crate) fn storage(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    label: &str,
    [bytes_per_pixel, more_bytes]: [u64; 2],
    usage: BufferUsages,
) -> Result<wgpu::Buffer, GpuError> {
    let size = bytes_per_pixel * u64::from(width) * u64::from(height) + more_bytes;
    let device = gpu.device();
    let limits = device.limits();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    if size > limit || size == 0 {
        return Err(GpuError::Limit {
            what: format!("{label} of a picture of {width}x{height} pixels"),
            needed: size,
            limit,
            instead: "take a size within that, and not zero".to_owned(),
        });
    }
    let buffer = buffer(&device, label, size, usage | BufferUsages::STORAGE);
    gpu.check(label)?;
    Ok(buffer)
}
