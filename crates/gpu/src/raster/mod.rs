//! The raster path: all triangles are drawn, pass after pass, without vertex buffers.
//!
//! Every method starts from the nearest opaque surface of each pixel or makes it itself. One-fragment methods go by a visibility buffer
//! ([`visibility`]); those that need fragments in order by a list a pixel ([`list`]); those that take them in any order by what their plan says
//! ([`plan`], [`family`]); `stochastic` by targets of several samples a pixel ([`stochastic`]).

use sheer_render::{Method, Settings};
use wgpu::{TextureFormat, TextureUsages};

use self::{
    family::Family,
    stochastic::{Sampling, Stochastic},
    target::Target,
    visibility::Visibility,
};
pub(crate) use self::{list::Lists, plan::Plan};
use crate::{
    GpuError,
    bindings::Layouts,
    device::Gpu,
    ray::Search,
    recording::{Groups, Recording},
    shader::Linker,
};

mod behind;
mod draw;
mod family;
mod list;
mod plan;
pub(crate) mod stochastic;
mod target;
mod visibility;

/// How a method is drawn.
#[derive(Debug)]
enum Technique {
    Visibility(Box<Visibility>),
    Lists(Box<Lists>),
    Family(Box<Family>),
    Stochastic(Box<Stochastic>),
}

/// A method on the raster path.
#[derive(Debug)]
pub(crate) struct RasterPath {
    technique: Technique,
}

/// What all techniques are made from.
pub(crate) struct Parts<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) layouts: &'a Layouts,
    /// Knows how rays of light are traced; what goes by it is the same for all methods, and drivers compile it once.
    pub(crate) linker: &'a Linker,
    /// Knows the method, too.
    pub(crate) method_linker: Linker,
    /// Pixels.
    pub(crate) size: [u32; 2],
}

impl RasterPath {
    pub(crate) fn new(
        gpu: &Gpu,
        method: &Method,
        search: Option<Search>,
        settings: &Settings,
        linker: &Linker,
        layouts: &Layouts,
    ) -> Result<Self, GpuError> {
        let method_linker = linker.clone().method(method);
        let parts = Parts { gpu, layouts, linker, method_linker, size: settings.size };
        let technique = match search {
            Some(search) if !search.needs_order() => {
                Technique::Visibility(Box::new(Visibility::new(&parts)?))
            }
            Some(search) => Technique::Lists(Box::new(Lists::new(&parts, search)?)),
            None => Self::unordered(&parts, method)?,
        };
        Ok(Self { technique })
    }

    fn unordered(parts: &Parts<'_>, method: &Method) -> Result<Technique, GpuError> {
        if let Some(sampling) = Sampling::of(method, parts.gpu.report())? {
            return Ok(Technique::Stochastic(Box::new(Stochastic::new(parts, sampling)?)));
        }
        let Some(plan) = Plan::of(method)? else {
            return Err(GpuError::Unsupported {
                what: format!("method {} has no raster version", method.info().id),
                instead: "take --backend cpu".to_owned(),
            });
        };
        let text = plan.link(parts.method_linker.clone())?;
        Ok(match plan {
            Plan::Lists => Technique::Lists(Box::new(Lists::planned(parts, text)?)),
            Plan::Passes(passes) => Technique::Family(Box::new(Family::new(parts, passes, text)?)),
        })
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        match &self.technique {
            Technique::Visibility(visibility) => visibility.record(recording, groups),
            Technique::Lists(lists) => lists.record(recording, groups),
            Technique::Family(family) => family.record(recording, groups),
            Technique::Stochastic(stochastic) => stochastic.record(recording, groups),
        }
    }

    /// Bytes of what the method keeps, beyond the pixels that come of it.
    pub(crate) fn method_bytes(&self) -> u64 {
        match &self.technique {
            Technique::Visibility(visibility) => visibility.bytes(),
            Technique::Lists(lists) => lists.bytes(),
            Technique::Family(family) => family.bytes(),
            Technique::Stochastic(stochastic) => stochastic.bytes(),
        }
    }
}

/// Format of a visibility buffer: triangle, two weights, side.
pub(crate) const SURFACE_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// Depths keep all bits of the distances they are made from.
pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// No triangle.
const NO_SURFACE: wgpu::Color = wgpu::Color { r: u32::MAX as f64, g: 0.0, b: 0.0, a: 0.0 };

/// The nearest opaque surface of each pixel, and how it is drawn.
#[derive(Debug)]
pub(crate) struct Opaque {
    pipeline: wgpu::RenderPipeline,
    pub(crate) surface: Target,
    depth: Target,
}

impl Opaque {
    pub(crate) fn new(parts: &Parts<'_>) -> Result<Self, GpuError> {
        let module = parts.gpu.shader("pass/opaque", parts.linker.link("pass/opaque")?)?;
        let pipeline = draw::Draw {
            label: "opaque",
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
        let surface = Target::new(parts, "opaque surface", SURFACE_FORMAT, usage)?;
        let depth = Target::new(parts, "opaque depth", DEPTH_FORMAT, TextureUsages::RENDER_ATTACHMENT)?;
        Ok(Self { pipeline, surface, depth })
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        let targets = [Some(self.surface.cleared(NO_SURFACE))];
        recording.draw("opaque", &self.pipeline, groups, None, &targets, Some(self.depth.cleared_depth()));
    }
}
