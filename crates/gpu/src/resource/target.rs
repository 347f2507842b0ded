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
    /// A target with one sample a pixel.
    ///
    /// # Errors
    /// As [`Self::multisampled`].
    pub(crate) fn new(
        gpu: &Gpu,
        size: [u32; 2],
        label: &str,
        format: TextureFormat,
        usage: TextureUsages,
    ) -> Result<Self, GpuError> {
        Self::multisampled(gpu, size, label, format, usage, 1)
    }

    /// A target with `samples` samples a pixel, 1 or a number of `AdapterReport::msaa`.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when the picture is longer than a texture may be; the device's own errors.
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

    /// Bytes of device memory that all samples of all texels take.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The target as an attachment that starts a pass from one colour.
    pub(crate) fn cleared(&self, colour: wgpu::Color) -> wgpu::RenderPassColorAttachment<'_> {
        self.attached(wgpu::LoadOp::Clear(colour))
    }

    /// The target as an attachment that starts a pass by `load`.
    pub(crate) fn attached(&self, load: wgpu::LoadOp<wgpu::Color>) -> wgpu::RenderPassColorAttachment<'_> {
        let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
        wgpu::RenderPassColorAttachment { view: &self.view, depth_slice: None, resolve_target: None, ops }
    }

    /// The target as a depth attachment that starts a pass from the furthest depth.
    pub(crate) fn cleared_depth(&self) -> wgpu::RenderPassDepthStencilAttachment<'_> {
        let depth_ops = wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store };
        wgpu::RenderPassDepthStencilAttachment {
            view: &self.view,
            depth_ops: Some(depth_ops),
            stencil_ops: None,
        }
    }
}
