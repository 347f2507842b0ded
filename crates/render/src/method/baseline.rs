//! The exact answer: every fragment, shaded, front to back (STD section 3.1, Listing 2).

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    colour::Premul,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use crate::contract::{Compositing, Gathering, MIN_VISIBILITY, MethodInfo, Visitor};

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

    fn begin(&self) -> Accumulated {
        Accumulated { rgb_premul: Vec3::ZERO, visibility: 1.0 }
    }

    fn add(&self, pixel: &mut Accumulated, alpha: f32, shade: impl FnOnce() -> Vec3) -> ControlFlow<()> {
        pixel.rgb_premul += pixel.visibility * alpha * shade();
        pixel.visibility *= 1.0 - alpha;
        if pixel.visibility > MIN_VISIBILITY { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn resolve(&self, pixel: Accumulated) -> Premul {
        Premul { rgb: pixel.rgb_premul, alpha: 1.0 - pixel.visibility }
    }
}
