//! The raster path: all triangles are drawn, pass after pass, without vertex buffers.
//!
//! A vertex shader takes its triangle from the buffers of the scene, and a fragment is the hit of its pixel's
//! ray with that triangle, by the arithmetic of the ray path: so both paths see the same points, opacities
//! and depths, and differ at most in which pixels a triangle covers at its edges.
//!
//! Every method starts from the nearest opaque surface of each pixel or makes it itself. One-fragment methods
//! go by a visibility buffer ([`visibility`]); those that need fragments in order by a list a pixel
//! ([`list`]); those that take them in any order by what they say themselves ([`plan`]): lists, passes of
//! their own ([`passes`]) or targets of several samples a pixel ([`multisample`]). What differs from method
//! to method is data or a piece of shader, so that no file here names one.
//!
//! Fragments are put together in front of the opaque surface by one pass for all ([`composite`]), since it
//! shades.

#[cfg(test)]
use std::collections::BTreeSet;

use sheer_render::{Method, Settings, contract::Raster};

#[cfg(test)]
use self::composite::Composite;
pub(crate) use self::list::Lists;
use self::{
    multisample::{MultisamplePasses, Sampling},
    parts::Parts,
    passes::DrawnPasses,
    visibility::Visibility,
};
#[cfg(test)]
use crate::ray::Shade;
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
mod format;
mod list;
pub(crate) mod multisample;
mod opaque;
mod parts;
mod passes;
pub(crate) mod plan;
mod visibility;

/// How a method is drawn.
#[derive(Debug)]
enum Technique {
    Visibility(Box<Visibility>),
    Lists(Box<Lists>),
    Passes(Box<DrawnPasses>),
    Multisample(Box<MultisamplePasses>),
}

/// A method on the raster path.
#[derive(Debug)]
pub(crate) struct RasterPath {
    technique: Technique,
}

impl RasterPath {
    /// The most storage buffers that a pass binds in group 2: heads and nodes of lists, or the two chains of
    /// the k-buffer.
    pub(crate) const MOST_OWN_STORAGE_BUFFERS: u32 = 2;

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

    /// The steps of a method, in their order and each once.
    #[cfg(test)]
    pub(crate) fn steps(method: &Method) -> Result<Vec<&'static str>, GpuError> {
        let search = Search::of(method);
        let mut steps = match search {
            Some(search) if !search.needs_order() => Visibility::STEPS.to_vec(),
            Some(search) if search.is_pure() => [&Lists::STEPS[..], &[Shade::STEP]].concat(),
            Some(_) => Lists::STEPS.to_vec(),
            None => match plan::raster_of(method)? {
                Some(Raster::Passes(passes)) => DrawnPasses::steps(&passes),
                Some(Raster::Multisample(_)) => MultisamplePasses::STEPS.to_vec(),
                _ => [&Lists::STEPS[..], &[Composite::STEP]].concat(),
            },
        };
        let mut seen = BTreeSet::new();
        steps.retain(|step| seen.insert(*step));
        Ok(steps)
    }

    fn unordered(parts: &Parts<'_>, method: &Method) -> Result<Technique, GpuError> {
        let Some(raster) = plan::raster_of(method)? else {
            return Err(GpuError::Unsupported {
                what: format!("method {} has no GPU version", method.info().id),
                instead: "take --backend cpu".to_owned(),
            });
        };
        let linker = parts.method_linker.clone();
        Ok(match raster {
            Raster::Lists => {
                Technique::Lists(Box::new(Lists::planned(parts, &plan::link(&raster, linker)?)?))
            }
            Raster::Passes(passes) => {
                let shader = plan::link(&Raster::Passes(passes.clone()), linker)?;
                Technique::Passes(Box::new(DrawnPasses::new(parts, passes, &shader)?))
            }
            Raster::Multisample(multisample) => {
                let sampling = Sampling::new(multisample, parts.gpu.report())?;
                Technique::Multisample(Box::new(MultisamplePasses::new(parts, sampling)?))
            }
        })
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        match &self.technique {
            Technique::Visibility(visibility) => visibility.record(recording, groups),
            Technique::Lists(lists) => lists.record(recording, groups),
            Technique::Passes(passes) => passes.record(recording, groups),
            Technique::Multisample(passes) => passes.record(recording, groups),
        }
    }

    /// Bytes of what the method keeps, beyond the pixels that come of it.
    pub(crate) fn method_bytes(&self) -> u64 {
        match &self.technique {
            Technique::Visibility(visibility) => visibility.bytes(),
            Technique::Lists(lists) => lists.bytes(),
            Technique::Passes(passes) => passes.bytes(),
            Technique::Multisample(passes) => passes.bytes(),
        }
    }
}
