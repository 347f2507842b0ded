//! The k-buffer: places for k fragments, sorted; when they are full the nearest is blended into the picture and makes room (Bavoil et al.
//! 2007).
//!
//! That is exact where fragments come nearly sorted, none of them more than k places from where it belongs, and the paper sorts geometry
//! beforehand for it. Here it comes in any order: what arrives too late is blended behind what it should hide. To merge the furthest
//! instead is multi-layer alpha blending, which has a name of its own in the table.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};

use super::stack::{Layer, MOST_PLACES, Stack};
use crate::contract::{Compositing, Fragment, Gathering, Memory, MethodInfo, PixelSite, Visitor};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "kbuffer",
    title: "k fragments sorted; of one too many the nearest is blended into the picture",
    paper: "Bavoil et al. 2007, Multi-Fragment Effects on the GPU Using the k-Buffer",
    bias: "a fragment that comes more than k places too late is blended behind what it should hide; nothing is dropped",
    parameters: &[ParameterInfo {
        key: "k",
        default: "8",
        range: ParameterRange::Count(1, MOST_PLACES),
        what: "places for fragments",
    }],
    alignment_px: 1,
};

/// The k-buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kbuffer {
    k: u32,
}

/// The fragments kept, and what has been blended in front of them.
#[derive(Clone, Debug)]
pub struct Kept {
    kept: Stack,
    blended: Layer,
    merged_count: u32,
}

impl Kbuffer {
    pub(crate) fn new(values: &Values) -> Self {
        Self { k: values.count("k") }
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.compositing(self)
    }

    fn all(pixel: &Kept) -> Layer {
        pixel.blended.over(&pixel.kept.blended())
    }
}

impl Compositing for Kbuffer {
    type Pixel = Kept;

    fn gathering(&self) -> Gathering {
        Gathering::Unordered { each_pass: false }
    }

    fn is_order_independent(&self) -> bool {
        false
    }

    fn memory(&self) -> Memory {
        // A place: colour and transmittance in 16-bit floats, depth. What has been blended has no depth.
        Memory::Bounded(12 * self.k + 8)
    }

    fn begin(&self, _: &PixelSite) -> Kept {
        Kept { kept: Stack::EMPTY, blended: Layer::CLEAR, merged_count: 0 }
    }

    fn add(
        &self,
        pixel: &mut Kept,
        _: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        pixel.kept.insert(Layer::new(fragment, shade()));
        if pixel.kept.layers().len() > self.k as usize {
            pixel.merged_count += 1;
            pixel.blended = pixel.blended.over(&pixel.kept.take_nearest());
        }
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Kept, _: usize) -> f32 {
        Self::all(pixel).transmittance
    }

    fn resolve(&self, pixel: &Kept) -> Vec3 {
        Self::all(pixel).rgb_premul
    }

    fn merged_count(&self, pixel: &Kept) -> u32 {
        pixel.merged_count
    }
}
