//! Depth peeling: each pass draws all fragments and keeps the nearest one behind what the last pass kept (Mammen 1989, Everitt 2001).
//!
//! A fragment is shaded when it passes both depth tests, even if a nearer one replaces it later in the pass, as on a GPU.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};

use crate::contract::{
    Compositing, Fragment, Gathering, Memory, MethodInfo, PixelSite, RETRACE_PARAMETER, Visitor,
};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "peel",
    title: "layer after layer, each in a pass over all fragments: the nearest one behind the last",
    paper: "Everitt 2001, Interactive Order-Independent Transparency; Mammen 1989",
    bias: "what lies behind the last layer is not drawn; the background shines through in its stead",
    parameters: &[
        ParameterInfo {
            key: "layers",
            // What shows the motor well enough (ST section 5).
            default: "10",
            range: ParameterRange::Count(1, 64),
            what: "passes, one layer each; fewer where nothing is left",
        },
        RETRACE_PARAMETER,
    ],
    alignment_px: 1,
};

/// Depth peeling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peel {
    layers: u32,
    each_pass: bool,
}

/// What has been peeled, and what the pass at work has found.
#[derive(Clone, Copy, Debug)]
pub struct Peeled {
    /// Of the layer peeled last; all fragments are behind the first value.
    last: (f32, u32),
    next: Option<Next>,
    rgb_premul: Vec3,
    visibility: f32,
}

/// The nearest fragment of a pass so far.
#[derive(Clone, Copy, Debug)]
struct Next {
    place: (f32, u32),
    alpha: f32,
    rgb_straight: Vec3,
}

impl Peel {
    pub(crate) fn new(values: &Values) -> Self {
        Self { layers: values.count("layers"), each_pass: values.text(RETRACE_PARAMETER.key) == "on" }
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.compositing(self)
    }
}

impl Peeled {
    /// With what the pass has found behind what was there before: colour and visibility.
    fn blended(&self) -> (Vec3, f32) {
        self.next.map_or((self.rgb_premul, self.visibility), |next| {
            let rgb = self.rgb_premul + self.visibility * next.alpha * next.rgb_straight;
            (rgb, self.visibility * (1.0 - next.alpha))
        })
    }
}

impl Compositing for Peel {
    type Pixel = Peeled;

    fn gathering(&self) -> Gathering {
        Gathering::Unordered { each_pass: self.each_pass }
    }

    fn pass_count(&self) -> usize {
        self.layers as usize
    }

    fn pass_name(&self, _: usize) -> &'static str {
        "peel"
    }

    fn memory(&self) -> Memory {
        // Depth of the last layer; colour and alpha of the next one in 16-bit floats.
        Memory::Bounded(12)
    }

    fn begin(&self, _: &PixelSite) -> Peeled {
        Peeled { last: (f32::NEG_INFINITY, 0), next: None, rgb_premul: Vec3::ZERO, visibility: 1.0 }
    }

    fn begin_pass(&self, pixel: &mut Peeled, pass: usize) -> ControlFlow<()> {
        if pass == 0 {
            return ControlFlow::Continue(());
        }
        (pixel.rgb_premul, pixel.visibility) = pixel.blended();
        let Some(peeled) = pixel.next.take() else { return ControlFlow::Break(()) };
        pixel.last = peeled.place;
        ControlFlow::Continue(())
    }

    fn add(
        &self,
        pixel: &mut Peeled,
        _: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        let place = fragment.place(0);
        if place > pixel.last && pixel.next.is_none_or(|next| place < next.place) {
            pixel.next = Some(Next { place, alpha: fragment.alpha, rgb_straight: shade() });
        }
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Peeled, _: usize) -> f32 {
        pixel.blended().1
    }

    fn resolve(&self, pixel: &Peeled) -> Vec3 {
        pixel.blended().0
    }
}
