//! The k-buffer: places for k fragments, sorted; what finds none is merged on the spot (Bavoil et al. 2007).
//!
//! The paper frees a place by blending the nearest fragment into the picture, which is exact where fragments come nearly sorted, no further
//! than k places from where they belong; it sorts geometry beforehand for that. Fragments that come in any order want the opposite, which
//! is the default here: the k nearest stay, and all others go into one tail behind them. The tail has no depth. A fragment that a nearer
//! one pushes out of its place is in front of all that the tail holds, since it was among the nearest when those were not; one that
//! comes too late for a place is put behind it, which is a guess.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};

use super::stack::{Layer, MOST_PLACES, Stack};
use crate::contract::{Compositing, Fragment, Gathering, Memory, MethodInfo, PixelSite, Visitor};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "kbuffer",
    title: "the k nearest fragments sorted, all others merged in the order in which they come",
    paper: "Bavoil et al. 2007, Multi-Fragment Effects on the GPU Using the k-Buffer",
    bias: "beyond k fragments the order of those merged is guessed; nothing is dropped",
    parameters: &[
        ParameterInfo {
            key: "k",
            default: "8",
            range: ParameterRange::Count(1, MOST_PLACES),
            what: "places for fragments",
        },
        ParameterInfo {
            key: "overflow",
            default: "tail",
            range: ParameterRange::Choice(&["tail", "front"]),
            what: "what makes room: the furthest fragment, merged into a tail; or as in the paper the nearest, blended in front",
        },
    ],
    alignment_px: 1,
};

/// The k-buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kbuffer {
    k: u32,
    overflow: Overflow,
}

/// Which fragment makes room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Overflow {
    Tail,
    Front,
}

/// The fragments kept and those that were not.
#[derive(Clone, Debug)]
pub struct Kept {
    kept: Stack,
    merged: Layer,
    merged_count: u32,
}

impl Kbuffer {
    pub(crate) fn new(values: &Values) -> Self {
        let overflow = match values.text("overflow") {
            "front" => Overflow::Front,
            _ => Overflow::Tail,
        };
        Self { k: values.count("k"), overflow }
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.compositing(self)
    }

    fn blended(self, pixel: &Kept) -> Layer {
        let kept = pixel.kept.blended();
        match self.overflow {
            Overflow::Tail => kept.over(&pixel.merged),
            Overflow::Front => pixel.merged.over(&kept),
        }
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
        // A place: colour and transmittance in 16-bit floats, depth. What is merged has no depth.
        Memory::Bounded(12 * self.k + 8)
    }

    fn begin(&self, _: &PixelSite) -> Kept {
        Kept { kept: Stack::EMPTY, merged: Layer::CLEAR, merged_count: 0 }
    }

    fn add(
        &self,
        pixel: &mut Kept,
        _: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        let k = self.k as usize;
        let at = pixel.kept.insert(Layer::new(fragment, shade()));
        if pixel.kept.layers().len() > k {
            pixel.merged_count += 1;
            pixel.merged = match self.overflow {
                Overflow::Front => pixel.merged.over(&pixel.kept.take_nearest()),
                Overflow::Tail if at == k => pixel.merged.over(&pixel.kept.take_furthest()),
                Overflow::Tail => pixel.kept.take_furthest().over(&pixel.merged),
            };
        }
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Kept, _: usize) -> f32 {
        self.blended(pixel).transmittance
    }

    fn resolve(&self, pixel: &Kept) -> Vec3 {
        self.blended(pixel).rgb_premul
    }

    fn merged_count(&self, pixel: &Kept) -> u32 {
        pixel.merged_count
    }
}
