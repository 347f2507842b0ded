//! The exact answer: every fragment, shaded, front to back (STD section 3.1, Listing 2).

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{bibliography, choice, parameter::Values};

use crate::contract::{
    Fragment, MIN_VISIBILITY, Memory, MethodInfo, OrderedCompositing, PixelSite, Traversal, Visitor,
};

choice! {
    /// How the fragments are found.
    enum Trace {
        /// [`Traversal::Sorted`].
        Sorted = "sorted",
        /// [`Traversal::Continuation`].
        Continuation = "continuation",
    }
}

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "baseline",
    title: "every fragment shaded, front to back: the exact answer",
    paper: "Brüll, Kern, Grosch (STD), section 3.1",
    works: &[&bibliography::STD],
    bias: "none; what lies behind a visibility of 0.001 is left out",
    parameters: &[Trace::parameter(
        "trace",
        Trace::Sorted,
        "all hits in one traversal, then sorted; or ray after ray as the paper does: the same picture",
    )],
    alignment_px: 1,
    constants: &[],
    tables: &[],
};

/// The exact answer, by either traversal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Baseline {
    traversal: Traversal,
}

/// What remains visible and what has been seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Accumulated {
    rgb_premul: Vec3,
    visibility: f32,
}

impl Baseline {
    pub(super) fn new(values: &Values) -> Self {
        let traversal = match values.choice("trace") {
            Trace::Sorted => Traversal::Sorted,
            Trace::Continuation => Traversal::Continuation,
        };
        Self { traversal }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.ordered(self)
    }
}

impl OrderedCompositing for Baseline {
    type Pixel = Accumulated;

    fn traversal(&self) -> Traversal {
        self.traversal
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn memory(&self) -> Memory {
        match self.traversal {
            Traversal::Continuation => Memory::Bounded(0),
            // Depth, opacity and what to shade.
            Traversal::Sorted => Memory::PerFragment(12),
        }
    }

    fn begin(&self, _: &PixelSite) -> Accumulated {
        Accumulated { rgb_premul: Vec3::ZERO, visibility: 1.0 }
    }

    fn add(
        &self,
        pixel: &mut Accumulated,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        pixel.rgb_premul += pixel.visibility * fragment.alpha * shade();
        pixel.visibility *= 1.0 - fragment.alpha;
        if pixel.visibility > MIN_VISIBILITY { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn transmittance(&self, pixel: &Accumulated) -> f32 {
        pixel.visibility
    }

    fn resolve(&self, pixel: &Accumulated) -> Vec3 {
        pixel.rgb_premul
    }
}
