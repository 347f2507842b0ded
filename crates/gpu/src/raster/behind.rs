//! The last step of methods that leave the light of transparent fragments and what is seen through them: what is behind.

use wgpu::ShaderStages;

use super::{Opaque, Parts};
use crate::{
    GpuError,
    bindings::{compute_pipeline, group, texture_entry, texture_in},
    recording::{Groups, Recording},
};

/// Its shader, one for all methods.
const PIECE: &str = "pass/behind";

/// Shades the nearest opaque surface of each pixel, or the background.
#[derive(Debug)]
pub(super) struct Behind {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

impl Behind {
    pub(super) fn new(parts: &Parts<'_>, opaque: &Opaque) -> Result<Self, GpuError> {
        let device = parts.gpu.device();
        let module = parts.gpu.shader(PIECE, parts.linker.link(PIECE)?)?;
        let (layout, group) = group(
            &device,
            "behind",
            &[texture_entry(0, ShaderStages::COMPUTE, wgpu::TextureSampleType::Uint, false)],
            &[texture_in(0, &opaque.surface.view)],
        );
        let groups = [&parts.layouts.scene, &parts.layouts.pass, &layout];
        let pipeline = compute_pipeline(&device, "behind", &groups, &module, "cs_behind");
        parts.gpu.check(PIECE)?;
        Ok(Self { pipeline, group })
    }

    pub(super) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        recording.for_each_pixel("behind", &self.pipeline, groups, Some(&self.group));
    }
}
