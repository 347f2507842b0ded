//! The nearest opaque surface of each pixel, which most techniques start from.

use wgpu::TextureUsages;

use super::{
    draw::Draw,
    format::{DEPTH_FORMAT, NO_SURFACE, SURFACE_FORMAT},
    parts::Parts,
};
use crate::{
    error::GpuError,
    recording::{Groups, Recording},
    resource::target::Target,
};

/// The nearest opaque surface of each pixel, and how it is drawn.
#[derive(Debug)]
pub(crate) struct Opaque {
    pipeline: wgpu::RenderPipeline,
    pub(crate) surface: Target,
    depth: Target,
}

impl Opaque {
    /// What the time of the pass is reported as.
    pub(super) const STEP: &str = "opaque";

    pub(crate) fn new(parts: &Parts<'_>) -> Result<Self, GpuError> {
        let module = parts.gpu.shader(&parts.linker.link("pass/opaque")?)?;
        let pipeline = Draw {
            label: Self::STEP,
            module: &module,
            vertex: "vs_all",
            fragment: "fs_opaque",
            group: None,
            targets: &[(SURFACE_FORMAT, None)],
            depth: Some(wgpu::CompareFunction::Less),
            samples: 1,
        };
        let pipeline = pipeline.build(parts);
        parts.gpu.check("pass/opaque")?;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let surface = Target::new(parts.gpu, parts.size, "opaque surface", SURFACE_FORMAT, usage)?;
        let depth = Target::new(
            parts.gpu,
            parts.size,
            "opaque depth",
            DEPTH_FORMAT,
            TextureUsages::RENDER_ATTACHMENT,
        )?;
        Ok(Self { pipeline, surface, depth })
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        let targets = [Some(self.surface.cleared(NO_SURFACE))];
        recording.draw(Self::STEP, &self.pipeline, groups, None, &targets, Some(self.depth.cleared_depth()));
    }
}
