//! The raster path: all triangles are drawn, pass after pass, without vertex buffers.
//!
//! Every method starts from the nearest opaque surface of each pixel or makes it itself. One-fragment methods go by a visibility buffer
//! ([`visibility`]); those that need fragments in order by a list a pixel ([`list`]); those that take them in any order by what their plan says
//! ([`plan`], [`family`]); `stochastic` by targets of several samples a pixel ([`stochastic`]).

use sheer_render::{Method, Settings};

use self::{
    family::Family,
    parts::Parts,
    stochastic::{Sampling, Stochastic},
    visibility::Visibility,
};
pub(crate) use self::{list::Lists, plan::Plan};
use crate::{
    device::Gpu,
    error::GpuError,
    layouts::Layouts,
    ray::Search,
    recording::{Groups, Recording},
    shader::Linker,
};

mod composite;
mod draw;
mod family;
mod format;
mod list;
mod opaque;
mod parts;
mod plan;
pub(crate) mod stochastic;
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
