//! The exact answer: every fragment, shaded, front to back (STD section 3.1, Listing 2).

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};

use crate::contract::{
    Compositing, Fragment, Gathering, MIN_VISIBILITY, Memory, MethodInfo, PixelSite, Visitor,
};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "baseline",
    title: "every fragment shaded, front to back: the exact answer",
    paper: "Brüll, Kern, Grosch (STD), section 3.1",
    bias: "none; what lies behind a visibility of 0.001 is left out",
    parameters: &[ParameterInfo {
        key: "trace",
        default: "sorted",
        range: ParameterRange::Choice(&["sorted", "continuation"]),
        what: "all hits in one traversal, then sorted; or ray after ray as the paper does: the same picture",
    }],
    alignment_px: 1,
};

/// The exact answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baseline {
    gathering: Gathering,
}

/// What remains visible and what has been seen.
#[derive(Clone, Copy, Debug)]
pub struct Accumulated {
    rgb_premul: Vec3,
    visibility: f32,
}

impl Baseline {
    pub(crate) fn new(values: &Values) -> Self {
        let gathering = match values.text("trace") {
            "continuation" => Gathering::Continuation,
            _ => Gathering::Sorted,
        };
        Self { gathering }
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.compositing(self)
    }
}

impl Compositing for Baseline {
    type Pixel = Accumulated;

    fn gathering(&self) -> Gathering {
        self.gathering
    }

    fn memory(&self) -> Memory {
        match self.gathering {
            Gathering::Continuation => Memory::Bounded(0),
            // Depth, opacity and what to shade.
            Gathering::Sorted | Gathering::Unordered { .. } => Memory::PerFragment(12),
        }
    }

    fn begin(&self, _: &PixelSite) -> Accumulated {
        Accumulated { rgb_premul: Vec3::ZERO, visibility: 1.0 }
    }

    fn add(
        &self,
        pixel: &mut Accumulated,
        _: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        pixel.rgb_premul += pixel.visibility * fragment.alpha * shade();
        pixel.visibility *= 1.0 - fragment.alpha;
        if pixel.visibility > MIN_VISIBILITY { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn transmittance(&self, pixel: &Accumulated, _: usize) -> f32 {
        pixel.visibility
    }

    fn resolve(&self, pixel: &Accumulated) -> Vec3 {
        pixel.rgb_premul
    }
}
