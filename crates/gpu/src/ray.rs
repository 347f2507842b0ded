//! The ray path: one pixel an invocation of a compute shader, traced by the device or through our own tree.
//!
//! Methods of one shaded fragment take two passes: `pass/find`, which knows the method, leaves what it has
//! found in 16 bytes a pixel, and `pass/shade`, which is the same for all of them. Hybrids and the exact
//! answer shade several fragments a pixel and do so in the pass that finds them, `pass/hybrid`, by one loop
//! with a single place that shades. Both are for the sake of compilers that inline everything: a software
//! driver compiles each place that shades for half a minute, and with two passes does so once for all methods
//! of one fragment.
//!
//! What a method asks for is a [`Search`]: which piece finds the fragment of its stochastic ray, how many
//! fragments are exact, and how many one traversal keeps. The raster path links the same pieces over lists
//! instead of rays.

use sheer_render::{
    LayerSplit, Method,
    contract::{Hybrid, OrderedCompositing, Selection, Threshold, Traversal, UnorderedCompositing, Visitor},
};

use crate::{
    compile::compute_pipeline,
    device::Gpu,
    error::GpuError,
    layouts::Layouts,
    recording::{Groups, Recording},
    shader::{
        Linker,
        constant::{self, Constant},
        linked::Linked,
    },
};

/// Fragments that one traversal keeps in order. More are found by a further ray; each takes 16 bytes of
/// registers or local memory.
const LAYER_CAPACITY: u32 = 8;

/// The piece for methods that decide hit by hit.
const FIND_THRESHOLD: &str = "pass/find_threshold";

/// How a method looks for its fragments by rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Search {
    /// The piece that finds the fragment of a stochastic ray.
    find: &'static str,
    /// Up to where fragments are exact.
    pub(crate) hybrid: Hybrid,
    /// How many fragments one traversal keeps in order.
    layer_capacity: u32,
    /// How pixels are split into layers, if they are.
    split: Option<LayerSplit>,
}

struct SearchOf<'a>(&'a Method);

impl Visitor for SearchOf<'_> {
    type Output = Option<Search>;

    fn threshold(self, _: &impl Threshold) -> Option<Search> {
        Some(Search {
            find: FIND_THRESHOLD,
            hybrid: self.0.hybrid(),
            layer_capacity: LAYER_CAPACITY,
            split: None,
        })
    }

    fn selection(self, _: &impl Selection) -> Option<Search> {
        Some(Search {
            find: "pass/find_selection",
            hybrid: self.0.hybrid(),
            layer_capacity: LAYER_CAPACITY,
            split: None,
        })
    }

    /// Nothing but the exact search stands for an ordered method; its fragments could be handed to none
    /// other.
    fn ordered(self, method: &impl OrderedCompositing) -> Option<Search> {
        let layer_capacity = match method.traversal() {
            Traversal::Sorted => LAYER_CAPACITY,
            Traversal::Continuation => 1,
        };
        let exact = Search { find: "pass/find_nothing", hybrid: Hybrid::EXACT, layer_capacity, split: None };
        method.is_exact().then_some(exact)
    }

    fn unordered(self, _: &impl UnorderedCompositing) -> Option<Search> {
        None
    }
}

impl Search {
    /// None for methods that want their fragments in any order: those are a rasteriser's.
    pub(crate) fn of(method: &Method) -> Option<Self> {
        method.visit(SearchOf(method))
    }

    /// The same search when pixels are split into layers, which a hybrid's are not: its exact fragments and
    /// the stochastic one behind them are a single layer.
    pub(crate) fn with_layers(self, split: Option<LayerSplit>) -> Self {
        Self { split: split.filter(|_| self.is_pure()), ..self }
    }

    /// Whether it leaves what it has found of the layers of each pixel.
    pub(crate) fn splits_layers(self) -> bool {
        self.split.is_some()
    }

    /// Whether the method shades one fragment a pixel and nothing else: then finding it and shading it are
    /// two passes.
    pub(crate) fn is_pure(self) -> bool {
        self.hybrid == Hybrid::NONE
    }

    /// The piece that goes through what is found, and its entry point.
    pub(crate) fn piece(self) -> (&'static str, &'static str) {
        match self.split {
            Some(_) => ("pass/find_layers", "cs_find"),
            None if self.is_pure() => ("pass/find", "cs_find"),
            None => ("pass/hybrid", "cs_trace"),
        }
    }

    /// The shader of the ray path.
    pub(crate) fn link(self, linker: Linker) -> Result<Linked, GpuError> {
        self.finding(linker).alias("tail", "shared/tail_none").link(self.piece().0)
    }

    /// What the search says to the pieces that go through what is found.
    pub(crate) fn finding(self, linker: Linker) -> Linker {
        let choose =
            if self.find == FIND_THRESHOLD { "pass/choose_threshold" } else { "pass/choose_selection" };
        linker.alias("find", self.find).alias("choose", choose).constants(self.constants())
    }

    /// Whether fragments have to be met front to back.
    pub(crate) fn needs_order(self) -> bool {
        self.hybrid != Hybrid::NONE || self.find != FIND_THRESHOLD || self.split.is_some()
    }

    /// Emitted for the shader.
    fn constants(self) -> String {
        let least_share = self.split.map_or(0.0, |split| split.least_share);
        constant::text(&[
            Constant::new("LAYER_CAPACITY", self.layer_capacity),
            Constant::new("LEAST_SHARE", least_share),
        ])
    }
}

/// The pass that traces a method's rays, and the one that shades where that is another.
#[derive(Debug)]
pub(crate) struct RayPath {
    trace: wgpu::ComputePipeline,
    shade: Option<Shade>,
}

impl RayPath {
    /// What the time of its first pass is reported as.
    const STEP: &str = "trace";

    pub(crate) fn new(
        gpu: &Gpu,
        method: &Method,
        search: Search,
        linker: &Linker,
        layouts: &Layouts,
    ) -> Result<Self, GpuError> {
        let (piece, entry_point) = search.piece();
        let module = gpu.shader(&search.link(linker.clone().method(method))?)?;
        let groups = [&layouts.scene, &layouts.pass];
        let trace = compute_pipeline(gpu, Self::STEP, &groups, &module, entry_point);
        gpu.check(piece)?;
        let shade = search.is_pure().then(|| Shade::new(gpu, linker, layouts)).transpose()?;
        Ok(Self { trace, shade })
    }

    /// The steps of a method, in their order.
    #[cfg(test)]
    pub(crate) fn steps(search: Search) -> Vec<&'static str> {
        if search.is_pure() { vec![Self::STEP, Shade::STEP] } else { vec![Self::STEP] }
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        recording.for_each_pixel(Self::STEP, &self.trace, groups, None);
        if let Some(shade) = &self.shade {
            shade.record(recording, groups);
        }
    }
}

/// The pass that shades the one fragment of each pixel, the same for all methods and paths.
#[derive(Debug)]
pub(crate) struct Shade(wgpu::ComputePipeline);

impl Shade {
    /// What the time of the pass is reported as.
    pub(crate) const STEP: &str = "shade";

    pub(crate) fn new(gpu: &Gpu, linker: &Linker, layouts: &Layouts) -> Result<Self, GpuError> {
        let piece = "pass/shade";
        let module = gpu.shader(&linker.link(piece)?)?;
        let pipeline = compute_pipeline(gpu, "shade", &[&layouts.scene, &layouts.pass], &module, "cs_shade");
        gpu.check(piece)?;
        Ok(Self(pipeline))
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        recording.for_each_pixel(Self::STEP, &self.0, groups, None);
    }
}

/// The pass that tells that each pixel is a single layer, after methods that do not tell layers apart.
#[derive(Debug)]
pub(crate) struct OneLayer(wgpu::ComputePipeline);

impl OneLayer {
    /// What the time of the pass is reported as.
    pub(crate) const STEP: &str = "layers";

    pub(crate) fn new(gpu: &Gpu, linker: &Linker, layouts: &Layouts) -> Result<Self, GpuError> {
        let piece = "pass/one_layer";
        let module = gpu.shader(&linker.link(piece)?)?;
        let groups = [&layouts.scene, &layouts.pass];
        let pipeline = compute_pipeline(gpu, Self::STEP, &groups, &module, "cs_one_layer");
        gpu.check(piece)?;
        Ok(Self(pipeline))
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        recording.for_each_pixel(Self::STEP, &self.0, groups, None);
    }
}
