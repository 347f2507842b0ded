//! Methods that composite fragments in the order in which the scene is drawn.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{choice, parameter::ParameterInfo};

use super::{
    fragment::{Fragment, Memory, PixelSite, Samples},
    raster::{NoRaster, Raster},
};

choice! {
    /// Whether each pass finds the fragments of a pixel anew.
    pub enum Retrace {
        /// They are kept from the first pass on, which is faster.
        Off = "off",
        /// They are traced again, as a rasteriser without lists draws the scene again. The picture is the
        /// same.
        On = "on",
    }
}

impl Retrace {
    /// The key for it, for methods of several passes.
    pub const PARAMETER: ParameterInfo = Self::parameter(
        "retrace",
        Self::Off,
        "trace the fragments anew for each pass, as a rasteriser renders them anew; the same picture, times as on a GPU",
    );
}

/// A cross-bilateral filter over the light of a method's fragments (ST section 6): pixels count by their
/// distance and by the difference of their total alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerFilter {
    /// Neighbours up to this distance in rows and columns count, pixels.
    pub radius_px: u32,
    /// Standard deviation of the Gaussian over distance, pixels.
    pub sigma_px: f32,
    /// Standard deviation of the Gaussian over differences of total alpha.
    pub sigma_alpha: f32,
}

/// Family of methods that add up all fragments in front of what is opaque, in the order in which the scene
/// lists its triangles: what a rasteriser hands over. What is opaque is no fragment but part of the
/// background, which the backend shades by itself and adds by what [`Self::transmittance`] leaves of it.
pub trait UnorderedCompositing: Sync {
    /// What is kept of a pixel.
    type Pixel;

    /// The samples of a pixel.
    fn samples(&self) -> Samples {
        Samples::ONE
    }

    /// How often all fragments are handed over.
    fn pass_count(&self) -> usize {
        1
    }

    /// What a pass does, for tables of times.
    fn pass_name(&self, pass: usize) -> &'static str {
        let _ = pass;
        "blend"
    }

    /// Where the fragments of further passes come from.
    fn retrace(&self) -> Retrace {
        Retrace::Off
    }

    /// Whether any order of the fragments gives the same pixel, but for rounding.
    fn is_order_independent(&self) -> bool {
        true
    }

    /// Whether chance decides what is kept of a fragment.
    fn is_random(&self) -> bool {
        false
    }

    /// What it stores of a pixel.
    fn memory(&self) -> Memory;

    /// How a GPU draws it.
    ///
    /// # Errors
    /// It cannot be drawn by raster, or not with these parameters.
    fn raster(&self) -> Result<Raster, NoRaster> {
        Err(NoRaster { what: "it has no raster version".to_owned(), instead: None })
    }

    /// A filter that the backend lays over what [`Self::resolve`] gives of all pixels, before the background
    /// is put behind it.
    fn layer_filter(&self) -> Option<LayerFilter> {
        None
    }

    /// A pixel that no fragment has been added to.
    fn begin(&self, site: &PixelSite) -> Self::Pixel;

    /// Comes before each pass; `Break` leaves this and all further passes out.
    fn begin_pass(&self, pixel: &mut Self::Pixel, pass: usize) -> ControlFlow<()> {
        let _ = (pixel, pass);
        ControlFlow::Continue(())
    }

    /// Adds a fragment; `shade` gives its linear radiance and is the costly part. `Break` ends the pass.
    fn add(
        &self,
        pixel: &mut Self::Pixel,
        pass: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()>;

    /// Share of the background that is seen at a sample, 0 to 1.
    fn transmittance(&self, pixel: &Self::Pixel, sample: usize) -> f32;

    /// Light of all fragments that reaches the eye: linear, premultiplied.
    fn resolve(&self, pixel: &Self::Pixel) -> Vec3;

    /// Fragments that found no room of their own in bounded memory and were merged with others.
    fn merged_count(&self, pixel: &Self::Pixel) -> u32 {
        let _ = pixel;
        0
    }
}
