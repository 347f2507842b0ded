//! The ray path: one pixel an invocation of a compute shader, traced by the device or through our own tree.

use sheer_render::{
    Method,
    contract::{Hybrid, OrderedCompositing, Selection, Threshold, Traversal, UnorderedCompositing, Visitor},
};

use crate::{
    device::Gpu,
    error::GpuError,
    layouts::Layouts,
    recording::{Groups, Recording, compute_pipeline},
    shader::Linker,
};

/// Fragments that one traversal keeps in order. More are found by a further ray; each takes 16 bytes of registers or local memory.
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
    /// Fragments a traversal.
    layer_capacity: u32,
}

struct SearchOf<'a>(&'a Method);

impl Visitor for SearchOf<'_> {
    type Output = Option<Search>;

    fn threshold(self, _: &impl Threshold) -> Option<Search> {
        Some(Search { find: FIND_THRESHOLD, hybrid: self.0.hybrid(), layer_capacity: LAYER_CAPACITY })
    }

    fn selection(self, _: &impl Selection) -> Option<Search> {
        Some(Search { find: "pass/find_selection", hybrid: self.0.hybrid(), layer_capacity: LAYER_CAPACITY })
    }

    /// Nothing but the exact search stands for an ordered method; its fragments could be handed to none other.
    fn ordered(self, method: &impl OrderedCompositing) -> Option<Search> {
        let layer_capacity = match method.traversal() {
            Traversal::Sorted => LAYER_CAPACITY,
            Traversal::Continuation => 1,
        };
        let exact = Search { find: "pass/find_nothing", hybrid: Hybrid::EXACT, layer_capacity };
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

    /// Whether the method shades one fragment a pixel and nothing else: then finding it and shading it are two passes.
    pub(crate) fn is_pure(self) -> bool {
        self.hybrid == Hybrid::NONE
    }

    /// The piece that goes through what is found, and its entry point.
    pub(crate) fn piece(self) -> (&'static str, &'static str) {
        if self.is_pure() { ("pass/find", "cs_find") } else { ("pass/hybrid", "cs_trace") }
    }

    /// The shader of the ray path.
    pub(crate) fn link(self, linker: Linker) -> Result<String, GpuError> {
        let linker = linker.alias("find", self.find).alias("tail", "shared/tail_none");
        linker.constants(self.constants()).link(self.piece().0)
    }

    /// The piece that finds the fragment of a stochastic ray.
    pub(crate) fn find(self) -> &'static str {
        self.find
    }

    /// Whether fragments have to be met front to back.
    pub(crate) fn needs_order(self) -> bool {
        self.hybrid != Hybrid::NONE || self.find != FIND_THRESHOLD
    }

    /// Emitted for the shader.
    pub(crate) fn constants(self) -> String {
        format!("const LAYER_CAPACITY: u32 = {}u;\n", self.layer_capacity)
    }
}

/// The shaders of a method.
#[derive(Debug)]
pub(crate) struct RayPath {
    trace: wgpu::ComputePipeline,
    shade: Option<Shade>,
}

impl RayPath {
    pub(crate) fn new(
        gpu: &Gpu,
        method: &Method,
        search: Search,
        linker: &Linker,
        layouts: &Layouts,
    ) -> Result<Self, GpuError> {
        let (piece, entry_point) = search.piece();
        let module = gpu.shader(piece, search.link(linker.clone().method(method))?)?;
        let groups = [&layouts.scene, &layouts.pass];
        let trace = compute_pipeline(&gpu.device(), "trace", &groups, &module, entry_point);
        gpu.check(piece)?;
        let shade = search.is_pure().then(|| Shade::new(gpu, linker, layouts)).transpose()?;
        Ok(Self { trace, shade })
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        recording.for_each_pixel("trace", &self.trace, groups, None);
        if let Some(shade) = &self.shade {
            shade.record(recording, groups);
        }
    }
}

/// The pass that shades the one fragment of each pixel, the same for all methods and paths.
#[derive(Debug)]
pub(crate) struct Shade(wgpu::ComputePipeline);

impl Shade {
    pub(crate) fn new(gpu: &Gpu, linker: &Linker, layouts: &Layouts) -> Result<Self, GpuError> {
        let piece = "pass/shade";
        let module = gpu.shader(piece, linker.link(piece)?)?;
        let pipeline =
            compute_pipeline(&gpu.device(), "shade", &[&layouts.scene, &layouts.pass], &module, "cs_shade");
        gpu.check(piece)?;
        Ok(Self(pipeline))
    }

    pub(crate) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        recording.for_each_pixel("shade", &self.0, groups, None);
    }
}
