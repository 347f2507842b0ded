//! Methods that composite fragments front to back.

use std::ops::ControlFlow;

use glam::Vec3;

use super::fragment::{Fragment, Memory, PixelSite};

/// How the backend finds the fragments of a pixel in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traversal {
    /// All hits of the ray in one traversal, bounded by the first opaque one, then sorted.
    Sorted,
    /// One ray after the other, each starting where the last one ended (STD Listing 2).
    Continuation,
}

/// Family of methods that add up fragments front to back, equal depths in the order of the scene's triangles.
/// Each pixel has one sample. What is opaque is the last fragment, with an alpha of 1; the background comes
/// behind it only where [`Self::transmittance`] leaves something of it.
pub trait OrderedCompositing: Sync {
    /// What is kept of a pixel.
    type Pixel;

    /// How fragments are to be found.
    fn traversal(&self) -> Traversal;

    /// Whether the result is nothing but OVER of all fragments: then a GPU takes it from its exact search,
    /// and no shader of the method's own is needed. Other ordered methods have no GPU version.
    fn is_exact(&self) -> bool {
        false
    }

    /// What it stores of a pixel.
    fn memory(&self) -> Memory;

    /// A pixel that no fragment has been added to.
    fn begin(&self, site: &PixelSite) -> Self::Pixel;

    /// Adds the next fragment; `shade` gives its linear radiance and is the costly part. `Break` ends the
    /// pixel.
    fn add(
        &self,
        pixel: &mut Self::Pixel,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()>;

    /// Share of the background that is seen, 0 to 1.
    fn transmittance(&self, pixel: &Self::Pixel) -> f32;

    /// Light of all fragments that reaches the eye: linear, premultiplied.
    fn resolve(&self, pixel: &Self::Pixel) -> Vec3;
}
