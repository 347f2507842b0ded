//! The k-buffer: k fragments, sorted; when there is one too many the nearest is blended into the picture and
//! makes room (Bavoil et al. 2007).
//!
//! That is exact where fragments come nearly sorted, none of them more than k positions from where it
//! belongs, and the paper sorts geometry beforehand for it. Here it comes in any order: what arrives too late
//! is blended behind what it should hide. To merge the furthest instead is multi-layer alpha blending, which
//! has a name of its own in the table.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use super::stack::{Layer, MOST_LAYERS, Stack};
use crate::contract::{
    Binding, Blend, Fragment, Memory, MethodInfo, NoRaster, Passes, PixelSite, Raster, Resource, Step,
    StepKind, TargetFormat, UnorderedCompositing, Visitor,
};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "kbuffer",
    title: "k fragments sorted; of one too many the nearest is blended into the picture",
    paper: "Bavoil et al. 2007, Multi-Fragment Effects on the GPU Using the k-Buffer",
    works: &[&bibliography::BAVOIL_2007],
    bias: "a fragment that comes more than k places too late is blended behind what it should hide; nothing is dropped",
    parameters: &[ParameterInfo {
        key: "k",
        default: "8",
        range: ParameterRange::Count(1, MOST_LAYERS),
        what: "places for fragments",
    }],
    alignment_px: 1,
    constants: &[],
    tables: &[],
};

/// The k-buffer with room for `k` fragments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kbuffer {
    k: u32,
}

/// The fragments kept, and what has been blended in front of them.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    kept: Stack,
    blended: Layer,
    merged_count: u32,
}

impl Kbuffer {
    pub(super) fn new(values: &Values) -> Self {
        Self { k: values.count("k") }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.unordered(self)
    }

    fn all(pixel: &Kept) -> Layer {
        pixel.blended.over(&pixel.kept.blended())
    }
}

impl UnorderedCompositing for Kbuffer {
    type Pixel = Kept;

    fn is_order_independent(&self) -> bool {
        false
    }

    fn memory(&self) -> Memory {
        // A fragment: colour and transmittance in 16-bit floats, depth. What has been blended has no depth.
        Memory::Bounded(12 * self.k + 8)
    }

    /// The k nearest depths are found first, then the fragments that have them; all others are summed up
    /// without order.
    fn raster(&self) -> Result<Raster, NoRaster> {
        let bytes_per_pixel = u64::from(4 * self.k);
        let resources = vec![
            Resource::Storage { label: "kept depths", bytes_per_pixel },
            Resource::Storage { label: "kept triangles", bytes_per_pixel },
            Resource::sums("tail sums", TargetFormat::Rgba16Float),
            Resource::products("tail transmittance", TargetFormat::R16Float),
        ];
        const KEPT_DEPTHS: Binding = Binding::new("BIND_KEPT_DEPTHS", 1);
        const KEPT_TRIANGLES: Binding = Binding::new("BIND_KEPT_TRIANGLES", 2);
        let draw = |name, entry_point, bound| {
            let targets = vec![(2, Some(Blend::Add)), (3, Some(Blend::Multiply))];
            Step { name, entry_point, kind: StepKind::Draw { targets, depth: None }, bound }
        };
        let steps = vec![
            draw("keep", "fs_keep", vec![(KEPT_DEPTHS, 0)]),
            draw("claim", "fs_claim", vec![(KEPT_DEPTHS, 0), (KEPT_TRIANGLES, 1)]),
            Step::last(vec![(KEPT_TRIANGLES, 1), (Binding::TAIL_SUMS, 2), (Binding::TAIL_TRANSMITTANCE, 3)]),
        ];
        Ok(Raster::Passes(Passes { resources, steps, constants: Vec::new() }))
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
