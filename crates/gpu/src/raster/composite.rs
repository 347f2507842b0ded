//! Composites what a method has left of the transparent fragments over what is opaque: the last step of all
//! methods but those of one shaded fragment.

use wgpu::ShaderStages;

use super::{opaque::Opaque, parts::Parts};
use crate::{
    compile::compute_pipeline,
    error::GpuError,
    recording::{Groups, Recording},
    resource::bind_group::{group, texture_entry, texture_in},
    shader::binding::BIND_OPAQUE_SURFACES,
};

/// One shader for all methods, since it shades.
const PIECE: &str = "pass/composite";

/// Shades the nearest opaque surface of each pixel, or the background, where something is seen of it.
#[derive(Debug)]
pub(super) struct Composite {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

impl Composite {
    /// What the time of the pass is reported as.
    pub(super) const STEP: &str = "behind";

    pub(super) fn new(parts: &Parts<'_>, opaque: &Opaque) -> Result<Self, GpuError> {
        let module = parts.gpu.shader(&parts.linker.link(PIECE)?)?;
        let (layout, group) = group(
            parts.gpu,
            Self::STEP,
            &[texture_entry(
                BIND_OPAQUE_SURFACES,
                ShaderStages::COMPUTE,
                wgpu::TextureSampleType::Uint,
                false,
            )],
            &[texture_in(BIND_OPAQUE_SURFACES, &opaque.surface.view)],
        );
        let groups = [&parts.layouts.scene, &parts.layouts.pass, &layout];
        let pipeline = compute_pipeline(parts.gpu, Self::STEP, &groups, &module, "cs_composite");
        parts.gpu.check(PIECE)?;
        Ok(Self { pipeline, group })
    }

    pub(super) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        recording.for_each_pixel(Self::STEP, &self.pipeline, groups, Some(&self.group));
    }
}
