//! Composites what a method has left of the transparent fragments over what is opaque: the last step of all methods but those of
//! one shaded fragment.

use wgpu::ShaderStages;

use super::{opaque::Opaque, parts::Parts};
use crate::{
    error::GpuError,
    recording::{Groups, Recording, compute_pipeline},
    resource::bind_group::{group, texture_entry, texture_in},
};

/// What the time of the pass is reported as.
const STEP: &str = "behind";
/// One shader for all methods, since it shades.
const PIECE: &str = "pass/composite";

/// Shades the nearest opaque surface of each pixel, or the background, where something is seen of it.
#[derive(Debug)]
pub(super) struct Composite {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

impl Composite {
    pub(super) fn new(parts: &Parts<'_>, opaque: &Opaque) -> Result<Self, GpuError> {
        let device = parts.gpu.device();
        let module = parts.gpu.shader(PIECE, parts.linker.link(PIECE)?)?;
        let (layout, group) = group(
            &device,
            STEP,
            &[texture_entry(0, ShaderStages::COMPUTE, wgpu::TextureSampleType::Uint, false)],
            &[texture_in(0, &opaque.surface.view)],
        );
        let groups = [&parts.layouts.scene, &parts.layouts.pass, &layout];
        let pipeline = compute_pipeline(&device, STEP, &groups, &module, "cs_composite");
        parts.gpu.check(PIECE)?;
        Ok(Self { pipeline, group })
    }

    pub(super) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        recording.for_each_pixel(STEP, &self.pipeline, groups, Some(&self.group));
    }
}
