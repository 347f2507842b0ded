//! Textures that passes draw to.

use wgpu::{TextureFormat, TextureUsages};

use crate::{device::Gpu, error::GpuError};

/// A texture of the picture's size.
#[derive(Debug)]
pub(crate) struct Target {
    pub(crate) view: wgpu::TextureView,
    bytes: u64,
}

impl Target {
    pub(crate) fn new(
        gpu: &Gpu,
        size: [u32; 2],
        label: &str,
        format: TextureFormat,
        usage: TextureUsages,
    ) -> Result<Self, GpuError> {
        Self::multisampled(gpu, size, label, format, usage, 1)
    }

    /// With several samples a pixel.
    pub(crate) fn multisampled(
        gpu: &Gpu,
        size: [u32; 2],
        label: &str,
        format: TextureFormat,
        usage: TextureUsages,
        samples: u32,
    ) -> Result<Self, GpuError> {
        let device = gpu.device();
        let [width, height] = size;
        let limit = device.limits().max_texture_dimension_2d;
        if width.max(height) > limit {
            return Err(GpuError::Limit {
                what: format!("a picture {} pixels long", width.max(height)),
                needed: width.max(height).into(),
                limit: limit.into(),
                instead: "take a smaller --size, or --backend gpu:ray".to_owned(),
            });
        }
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        });
        gpu.check(label)?;
        let texel = format.block_copy_size(None).map_or(4, u64::from);
        let bytes = texel * u64::from(samples) * u64::from(width) * u64::from(height);
        Ok(Self { view: texture.create_view(&wgpu::TextureViewDescriptor::default()), bytes })
    }

    /// Bytes of all texels.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// As an attachment that starts from one colour.
    pub(crate) fn cleared(&self, colour: wgpu::Color) -> wgpu::RenderPassColorAttachment<'_> {
        self.attached(wgpu::LoadOp::Clear(colour))
    }

    /// As an attachment that goes on from what it holds.
    pub(crate) fn attached(&self, load: wgpu::LoadOp<wgpu::Color>) -> wgpu::RenderPassColorAttachment<'_> {
        let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
        wgpu::RenderPassColorAttachment { view: &self.view, depth_slice: None, resolve_target: None, ops }
    }

    /// As a depth attachment that starts from the furthest depth.
    pub(crate) fn cleared_depth(&self) -> wgpu::RenderPassDepthStencilAttachment<'_> {
        let depth_ops = wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store };
        wgpu::RenderPassDepthStencilAttachment {
            view: &self.view,
            depth_ops: Some(depth_ops),
            stencil_ops: None,
        }
    }
}
