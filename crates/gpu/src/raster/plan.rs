//! How a method is drawn, as it says itself: [`Raster`]. [`DrawnPasses`](super::passes::DrawnPasses) carries
//! passes out.
//!
//! Shaders are in `shaders/method/<id>.wgsl`; `composited` there says what becomes of a pixel in
//! `shaders/pass/front.wgsl`, always the last step. [`Composite`](super::composite::Composite) comes after
//! it.

use sheer_render::{
    Method,
    contract::{
        Binding, NoRaster, OrderedCompositing, Passes, Raster, Resource, Selection, ShaderConstant, Step,
        StepKind, Threshold, UnorderedCompositing, Visitor,
    },
};
use wgpu::{Features, TextureFormat};

use super::format::{blend_features, texture_format};
use crate::{
    error::GpuError,
    shader::{Linker, binding, constants::of_constant, linked::Linked},
};

/// All methods are linked into this piece; it imports their own as `method`.
const PIECE: &str = "pass/front";
/// The entry point of the last step.
pub(super) const ENTRY_POINT: &str = Step::FINAL_ENTRY_POINT;

struct RasterOf;

impl Visitor for RasterOf {
    type Output = Option<Result<Raster, NoRaster>>;

    fn threshold(self, _: &impl Threshold) -> Self::Output {
        None
    }

    fn selection(self, _: &impl Selection) -> Self::Output {
        None
    }

    fn ordered(self, _: &impl OrderedCompositing) -> Self::Output {
        None
    }

    fn unordered(self, method: &impl UnorderedCompositing) -> Self::Output {
        Some(method.raster())
    }
}

/// How a method is drawn that takes its fragments in any order; none for all others, which go by a
/// [`Search`](crate::ray::Search).
///
/// # Errors
/// The method cannot be drawn with these parameters.
pub(crate) fn raster_of(method: &Method) -> Result<Option<Raster>, GpuError> {
    let raster = method.visit(RasterOf).transpose();
    raster.map_err(|NoRaster { what, instead }| GpuError::Unsupported {
        what: format!("{method} is not drawn by raster: {what}"),
        instead: instead.map_or_else(
            || "take --backend cpu".to_owned(),
            |instead| format!("{instead}, or --backend cpu"),
        ),
    })
}

/// The shader of a method that has all entry points of its steps.
pub(crate) fn link(raster: &Raster, linker: Linker) -> Result<Linked, GpuError> {
    let Raster::Passes(passes) = raster else { return linker.link(PIECE) };
    // What several techniques bind has its number in all shaders.
    let is_own = |binding: &Binding| binding::ALL.iter().all(|(name, _)| *name != binding.name);
    let bindings = passes.bindings().into_iter().filter(is_own);
    let numbers = bindings.map(|Binding { name, number }| ShaderConstant::count(name, number));
    let constants = passes.constants.iter().copied().chain(numbers);
    linker.constants(constants.map(|constant| of_constant(&constant).to_string()).collect()).link(PIECE)
}

/// The format of a target that passes draw to.
fn target_format(passes: &Passes, index: usize) -> Option<TextureFormat> {
    match passes.resources[index] {
        Resource::Target { format, .. } => Some(texture_format(format)),
        Resource::Depth { .. } | Resource::Storage { .. } => None,
    }
}

/// What a device has to be capable of to blend into all targets that are blended into.
pub(crate) fn blending_features(passes: &Passes) -> Features {
    let mut features = Features::empty();
    for step in &passes.steps {
        if let StepKind::Draw { targets, .. } = &step.kind {
            let blended = targets.iter().filter(|(_, blend)| blend.is_some());
            for format in blended.filter_map(|&(index, _)| target_format(passes, index)) {
                features |= blend_features(format);
            }
        }
    }
    features
}

/// Bytes a sample of the targets of a pass, the most of all passes.
pub(crate) fn most_target_bytes(passes: &Passes) -> u32 {
    let bytes = passes.steps.iter().map(|step| match &step.kind {
        StepKind::Draw { targets, .. } => {
            let formats = targets.iter().filter_map(|&(index, _)| target_format(passes, index));
            formats.filter_map(|format| format.target_pixel_byte_cost()).sum()
        }
        StepKind::Pixels => 0,
    });
    bytes.max().unwrap_or(0)
}
