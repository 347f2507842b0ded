//! Multi-layer alpha blending: k layers with colour, transmittance and depth; of one too many the two
//! furthest become one (Salvi and Vaidyanathan 2014, section 3).
//!
//! A merged layer keeps the depth of its front, so that what comes later is put before or behind all of it.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use super::stack::{Layer, MOST_LAYERS, Stack};
use crate::contract::{
    Fragment, Memory, MethodInfo, NoRaster, PixelSite, Raster, UnorderedCompositing, Visitor,
};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "mlab",
    title: "k layers a pixel; of one too many the two furthest are blended into one",
    paper: "Salvi, Vaidyanathan 2014, Multi-Layer Alpha Blending",
    works: &[&bibliography::SALVI_VAIDYANATHAN_2014],
    bias: "what belongs inside a blended layer comes behind it; nothing is dropped",
    parameters: &[ParameterInfo {
        key: "k",
        default: "4",
        range: ParameterRange::Count(1, MOST_LAYERS),
        what: "layers",
    }],
    alignment_px: 1,
    constants: &[],
    tables: &[],
};

/// Multi-layer alpha blending with `k` layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mlab {
    k: u32,
}

/// The layers of a pixel.
#[derive(Clone, Debug)]
pub(super) struct Layers {
    stack: Stack,
    merged_count: u32,
}

impl Mlab {
    pub(super) fn new(values: &Values) -> Self {
        Self { k: values.count("k") }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.unordered(self)
    }
}

impl UnorderedCompositing for Mlab {
    type Pixel = Layers;

    fn is_order_independent(&self) -> bool {
        false
    }

    fn memory(&self) -> Memory {
        // A layer: colour and transmittance in 16-bit floats, depth.
        Memory::Bounded(12 * self.k)
    }

    fn raster(&self) -> Result<Raster, NoRaster> {
        Ok(Raster::Lists)
    }

    fn begin(&self, _: &PixelSite) -> Layers {
        Layers { stack: Stack::EMPTY, merged_count: 0 }
    }

    fn add(
        &self,
        pixel: &mut Layers,
        _: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        pixel.stack.insert(Layer::new(fragment, shade()));
        if pixel.stack.layers().len() > self.k as usize {
            pixel.merged_count += 1;
            pixel.stack.merge_furthest();
        }
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Layers, _: usize) -> f32 {
        pixel.stack.blended().transmittance
    }

    fn resolve(&self, pixel: &Layers) -> Vec3 {
        pixel.stack.blended().rgb_premul
    }

    fn merged_count(&self, pixel: &Layers) -> u32 {
        pixel.merged_count
    }
}
