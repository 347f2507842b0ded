//! The A-buffer: every fragment is stored, then sorted and blended.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::parameter::Values;

use crate::contract::{Compositing, Fragment, Gathering, Memory, MethodInfo, PixelSite, Visitor};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "list",
    title: "every fragment stored in a list a pixel, then sorted and blended: exact, without a bound on memory",
    paper: "Carpenter 1984, The A-buffer, an Antialiased Hidden Surface Method",
    bias: "none",
    parameters: &[],
    alignment_px: 1,
};

/// The A-buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct List;

/// A fragment with its place in depth.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    place: (f32, u32),
    alpha: f32,
    rgb_straight: Vec3,
}

impl List {
    pub(crate) fn new(_: &Values) -> Self {
        Self
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.compositing(self)
    }
}

impl Compositing for List {
    type Pixel = Vec<Entry>;

    fn gathering(&self) -> Gathering {
        Gathering::Unordered { each_pass: false }
    }

    fn memory(&self) -> Memory {
        // Colour and alpha in 16-bit floats, depth, link to the next.
        Memory::PerFragment(16)
    }

    fn begin(&self, _: &PixelSite) -> Vec<Entry> {
        Vec::new()
    }

    fn add(
        &self,
        pixel: &mut Vec<Entry>,
        _: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        let entry = Entry { place: fragment.place(0), alpha: fragment.alpha, rgb_straight: shade() };
        let at = pixel.partition_point(|other| other.place <= entry.place);
        pixel.insert(at, entry);
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Vec<Entry>, _: usize) -> f32 {
        pixel.iter().map(|entry| 1.0 - entry.alpha).product()
    }

    fn resolve(&self, pixel: &Vec<Entry>) -> Vec3 {
        let blended = pixel.iter().fold((Vec3::ZERO, 1.0), |(rgb, visibility), entry| {
            (rgb + visibility * entry.alpha * entry.rgb_straight, visibility * (1.0 - entry.alpha))
        });
        blended.0
    }
}
