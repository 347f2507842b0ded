//! Depth peeling: each pass draws all fragments and keeps the nearest one behind what the last pass kept
//! (Mammen 1989, Everitt 2001).
//!
//! A fragment is shaded when it passes both depth tests, even if a nearer one replaces it later in the pass,
//! as on a GPU.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use crate::contract::{
    Binding, Fragment, Memory, MethodInfo, NoRaster, Passes, PixelSite, Raster, Resource, Retrace, Step,
    StepKind, TargetFormat, UnorderedCompositing, Visitor,
};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "peel",
    title: "layer after layer, each in a pass over all fragments: the nearest one behind the last",
    paper: "Everitt 2001, Interactive Order-Independent Transparency; Mammen 1989",
    works: &[&bibliography::EVERITT_2001, &bibliography::MAMMEN_1989],
    bias: "what lies behind the last layer is not drawn; the background shines through in its stead",
    parameters: &[
        ParameterInfo {
            key: "layers",
            // What shows the motor well enough (ST section 5).
            default: "10",
            range: ParameterRange::Count(1, 64),
            what: "passes, one layer each; fewer where nothing is left",
        },
        Retrace::PARAMETER,
    ],
    alignment_px: 1,
    constants: &[],
    tables: &[],
};

/// Depth peeling with a bound on the layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peel {
    layers: u32,
    retrace: Retrace,
}

/// What has been peeled, and what the pass at work has found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peeled {
    /// Sort key of the layer peeled last; its first value lies in front of all fragments.
    last: (f32, u32),
    next: Option<Next>,
    rgb_premul: Vec3,
    visibility: f32,
}

/// The nearest fragment of a pass so far.
#[derive(Clone, Copy, Debug)]
struct Next {
    sort_key: (f32, u32),
    alpha: f32,
    rgb_straight: Vec3,
}

impl Peel {
    pub(super) fn new(values: &Values) -> Self {
        Self { layers: values.count("layers"), retrace: values.choice(Retrace::PARAMETER.key) }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.unordered(self)
    }
}

impl Peeled {
    /// Colour and visibility of what has been peeled with the layer that the pass has found composited behind
    /// it.
    fn blended(&self) -> (Vec3, f32) {
        self.next.map_or((self.rgb_premul, self.visibility), |next| {
            let rgb = self.rgb_premul + self.visibility * next.alpha * next.rgb_straight;
            (rgb, self.visibility * (1.0 - next.alpha))
        })
    }
}

impl UnorderedCompositing for Peel {
    type Pixel = Peeled;

    fn retrace(&self) -> Retrace {
        self.retrace
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

    /// Two layers take turns: one is looked for behind the other.
    fn raster(&self) -> Result<Raster, NoRaster> {
        const FURTHEST: [f64; 4] = [u32::MAX as f64, u32::MAX as f64, 0.0, 0.0];
        const DEPTH: usize = 2;
        const PEELED: usize = 3;
        const LAYER_KEYS: Binding = Binding::new("BIND_LAYER_KEYS", 1);
        const PEELED_LAYERS: Binding = Binding::new("BIND_PEELED_LAYERS", 2);
        let layer = |label| Resource::Target { label, format: TargetFormat::Rg32Uint, clear: FURTHEST };
        let resources = vec![
            layer("even layer"),
            layer("odd layer"),
            Resource::Depth { label: "peel depth" },
            Resource::Storage { label: "peeled layers", bytes_per_pixel: 16 },
        ];
        let mut steps = Vec::new();
        for number in 0..self.layers as usize {
            let [this, last] = [number % 2, (number + 1) % 2];
            steps.push(Step {
                name: "peel",
                entry_point: if number == 0 { "fs_first" } else { "fs_next" },
                kind: StepKind::Draw { targets: vec![(this, None)], depth: Some(DEPTH) },
                bound: if number == 0 { Vec::new() } else { vec![(LAYER_KEYS, last)] },
            });
            let bound = vec![(LAYER_KEYS, this), (PEELED_LAYERS, PEELED)];
            steps.push(Step { name: "blend", entry_point: "cs_blend", kind: StepKind::Pixels, bound });
        }
        steps.push(Step::last(vec![(PEELED_LAYERS, PEELED)]));
        Ok(Raster::Passes(Passes { resources, steps, constants: Vec::new() }))
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
        pixel.last = peeled.sort_key;
        ControlFlow::Continue(())
    }

    fn add(
        &self,
        pixel: &mut Peeled,
        _: usize,
        fragment: &Fragment<'_>,
        shade: impl FnOnce() -> Vec3,
    ) -> ControlFlow<()> {
        let sort_key = fragment.sort_key(0);
        if sort_key > pixel.last && pixel.next.is_none_or(|next| sort_key < next.sort_key) {
            pixel.next = Some(Next { sort_key, alpha: fragment.alpha, rgb_straight: shade() });
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
