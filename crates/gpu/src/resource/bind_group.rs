//! Entries of bind groups and of their layouts.

use wgpu::{BindGroupLayoutEntry, BindingType, BufferBindingType, ShaderStages};

use crate::{compile::layout, device::Gpu};

/// The layout of a buffer of any size.
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

/// The layout of a storage buffer that shaders read.
pub(crate) fn read_only_entry(binding: u32, visibility: ShaderStages) -> BindGroupLayoutEntry {
    buffer_entry(binding, visibility, BufferBindingType::Storage { read_only: true })
}

/// The layout of a texture of two dimensions.
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

/// Binds a buffer from its first byte to its last.
pub(crate) fn whole(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
}

/// Binds all of a texture that a view shows.
pub(crate) fn texture_in(binding: u32, view: &wgpu::TextureView) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) }
}

/// A bind group of a layout that exists.
pub(crate) fn group_of(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    entries: &[wgpu::BindGroupEntry<'_>],
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries })
}

/// A bind group with its layout.
pub(crate) fn group(
    gpu: &Gpu,
    label: &str,
    layout_entries: &[BindGroupLayoutEntry],
    entries: &[wgpu::BindGroupEntry<'_>],
) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let layout = layout(gpu, label, layout_entries);
    let group = group_of(&gpu.device(), label, &layout, entries);
    (layout, group)
}
