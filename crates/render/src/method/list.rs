//! The A-buffer: every fragment is stored, then sorted and blended.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use crate::contract::{
    Fragment, Memory, MethodInfo, NoRaster, PixelSite, Placement, Raster, Samples, UnorderedCompositing,
    Visitor,
};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "list",
    title: "every fragment stored in a list a pixel, then sorted and blended: exact, without a bound on memory",
    paper: "Carpenter 1984, The A-buffer, an Antialiased Hidden Surface Method",
    works: &[&bibliography::CARPENTER_1984],
    bias: "none",
    parameters: &[ParameterInfo {
        key: "samples",
        default: "1",
        range: ParameterRange::Count(1, Samples::MOST),
        what: "samples spread over the pixel, each of which blends the fragments that cover it: exact edges; 1: the pixel's one ray",
    }],
    alignment_px: 1,
    constants: &[],
    tables: &[],
};

/// The A-buffer with a number of samples a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct List {
    samples: Samples,
}

/// A fragment that is stored.
#[derive(Clone, Copy, Debug)]
struct Entry {
    coverage: u64,
    alpha: f32,
    rgb_straight: Vec3,
    /// Index of its first depth in [`Fragments::depths`].
    first_depth: usize,
    /// Breaks ties of equal depths: [`Fragment::order`].
    order: u32,
}

/// All fragments of a pixel.
#[derive(Clone, Debug, Default)]
pub(super) struct Fragments {
    entries: Vec<Entry>,
    /// Depths of all entries, one after the other: as many for each as the pixel has rays.
    depths: Vec<f32>,
}

impl Fragments {
    /// Fragments that cover a sample, front to back.
    fn at(&self, sample: usize) -> Vec<&Entry> {
        let ray_count = self.depths.len() / self.entries.len().max(1);
        let depth = |entry: &Entry| self.depths[entry.first_depth + sample.min(ray_count - 1)];
        let mut covering: Vec<&Entry> =
            self.entries.iter().filter(|entry| entry.coverage >> sample & 1 != 0).collect();
        covering.sort_unstable_by(|a, b| depth(a).total_cmp(&depth(b)).then(a.order.cmp(&b.order)));
        covering
    }
}

impl List {
    pub(super) fn new(values: &Values) -> Self {
        let count = values.count("samples");
        let placement = if count == 1 { Placement::Centre } else { Placement::Box };
        Self { samples: Samples { count, placement } }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.unordered(self)
    }
}

impl UnorderedCompositing for List {
    type Pixel = Fragments;

    fn samples(&self) -> Samples {
        self.samples
    }

    fn memory(&self) -> Memory {
        // Colour and alpha in 16-bit floats, depth, link to the next; of several samples a mask, and a depth
        // each.
        let samples = self.samples.count;
        Memory::PerFragment(if samples == 1 { 16 } else { 12 + samples.div_ceil(8) + 4 * samples })
    }

    fn raster(&self) -> Result<Raster, NoRaster> {
        if self.samples.count > 1 {
            let what =
                "it blends several samples a pixel, and the list of a pixel on a GPU has one".to_owned();
            return Err(NoRaster { what, instead: Some("take samples=1 with -a taa") });
        }
        Ok(Raster::Lists)
    }

    fn begin(&self, _: &PixelSite) -> Fragments {
        Fragments::default()
    }

    fn add(
        &self,
        pixel: &mut Fragments,
        _: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        let &Fragment { coverage, alpha, depths, order, .. } = fragment;
        let first_depth = pixel.depths.len();
        pixel.depths.extend_from_slice(depths);
        let sort_key = |entry: &Entry| (pixel.depths[entry.first_depth], entry.order);
        // In one order whatever that of arrival, so that not even rounding tells them apart; of one sample it
        // is the final one.
        let at = pixel.entries.partition_point(|other| sort_key(other) < (depths[0], order));
        pixel.entries.insert(at, Entry { coverage, alpha, rgb_straight: shade(), first_depth, order });
        ControlFlow::Continue(())
    }

    fn transmittance(&self, pixel: &Fragments, sample: usize) -> f32 {
        let covering = pixel.entries.iter().filter(|entry| entry.coverage >> sample & 1 != 0);
        covering.map(|entry| 1.0 - entry.alpha).product()
    }

    fn resolve(&self, pixel: &Fragments) -> Vec3 {
        let blended = |sample: usize| {
            let sum = pixel.at(sample).iter().fold((Vec3::ZERO, 1.0), |(rgb, visibility), entry| {
                (rgb + visibility * entry.alpha * entry.rgb_straight, visibility * (1.0 - entry.alpha))
            });
            sum.0
        };
        let count = self.samples.count as usize;
        (0..count).map(blended).sum::<Vec3>() / count as f32
    }
}
