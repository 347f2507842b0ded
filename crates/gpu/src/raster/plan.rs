//! What methods with an unordered gathering need on the raster path, as data: targets, memory, passes. [`Family`](super::family::Family) carries
//! it out.
//!
//! Shaders are in `shaders/method/<id>.wgsl`; `composited` there says what becomes of a pixel in `shaders/pass/front.wgsl`, always the last step.
//! [`Composite`](super::composite::Composite) comes after it.

use sheer_render::{
    Method,
    method::{adaptive, kbuffer, list, mlab, moments, peel, weighted},
};
use wgpu::{BlendState, Color, Features, TextureFormat};

use super::format::{ADD, MULTIPLY, TAIL_FORMATS};
use crate::{
    error::GpuError,
    shader::{
        Linker,
        constant::{self, Constant},
    },
};

/// How a method is drawn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Plan {
    /// All fragments go to a list a pixel first ([`Lists`](super::list::Lists)); the last step takes them from there.
    Lists,
    /// Passes over all triangles with memory of their own.
    Passes(Passes),
}

/// Memory and the steps that use it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Passes {
    /// What a pixel has.
    pub(super) resources: Vec<Resource>,
    /// In the order in which they run. Those with one entry point are alike but for the resources they use.
    pub(super) steps: Vec<Step>,
    /// Constants that the shader has beside the method's parameters.
    pub(super) constants: String,
    /// What the device has to be capable of.
    pub(super) features: Features,
}

/// Something of the picture's size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Resource {
    /// A texture that is drawn to, from `clear` on, and read by later steps.
    Target {
        /// For the driver's messages.
        label: &'static str,
        /// Of a texel.
        format: TextureFormat,
        /// What each step that draws to it starts from.
        clear: Color,
    },
    /// A depth buffer; each step that tests against it starts from the furthest depth.
    Depth {
        /// For the driver's messages.
        label: &'static str,
    },
    /// A buffer that shaders read and write; zero at the start of a frame.
    Storage {
        /// For the driver's messages.
        label: &'static str,
        /// How much of it a pixel has.
        bytes_per_pixel: u64,
    },
}

/// A pass.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Step {
    /// What its time is reported as.
    pub(super) name: &'static str,
    /// In the method's shader.
    pub(super) entry_point: &'static str,
    /// What it runs over.
    pub(super) work: Work,
    /// Bindings of group 2 and the indices into [`Passes::resources`] of what is bound there. Binding 0 is the opaque surface.
    pub(super) bound: Vec<(u32, usize)>,
}

/// What a step runs over.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Work {
    /// The fragments of all triangles.
    Draw {
        /// Indices of what is drawn to, and how it is blended with what is there.
        targets: Vec<(usize, Option<BlendState>)>,
        /// Index of the depth buffer, if only the nearest fragment stays.
        depth: Option<usize>,
    },
    /// All pixels.
    Pixels,
}

/// The last step.
fn front(bound: Vec<(u32, usize)>) -> Step {
    Step { name: "front", entry_point: Plan::ENTRY_POINT, work: Work::Pixels, bound }
}

/// Makes the plan of a method, by its parameters.
type Make = fn(&Method) -> Result<Plan, GpuError>;

/// A way to draw each method, by its id.
const PLANS: &[(&str, Make)] = &[
    (weighted::INFO.id, |_| Ok(Plan::Passes(weighted()))),
    (moments::INFO.id, |method| Ok(Plan::Passes(moments(method)))),
    (peel::INFO.id, |method| Ok(Plan::Passes(peel(count(method, "layers"))))),
    (kbuffer::INFO.id, |method| Ok(Plan::Passes(kbuffer(count(method, "k"))))),
    (list::INFO.id, list_of_one_sample),
    (mlab::INFO.id, |_| Ok(Plan::Lists)),
    (adaptive::INFO.id, |_| Ok(Plan::Lists)),
];

impl Plan {
    /// All methods are linked into this piece; it imports their own as `method`.
    pub(super) const PIECE: &str = "pass/front";
    /// Of the last step.
    pub(super) const ENTRY_POINT: &str = "cs_front";

    /// None for methods that are drawn in another way.
    ///
    /// # Errors
    /// The method cannot be drawn with these parameters.
    pub(crate) fn of(method: &Method) -> Result<Option<Self>, GpuError> {
        let plan = PLANS.iter().find(|(id, _)| *id == method.info().id);
        plan.map(|(_, plan)| plan(method)).transpose()
    }

    /// The shader that has all entry points.
    pub(crate) fn link(&self, linker: Linker) -> Result<String, GpuError> {
        let constants = match self {
            Self::Lists => String::new(),
            Self::Passes(passes) => passes.constants.clone(),
        };
        linker.constants(constants).link(Self::PIECE)
    }
}

fn count(method: &Method, key: &str) -> u32 {
    method.value(key).parse().expect("checked against its range")
}

/// A pixel's list knows one ray.
fn list_of_one_sample(method: &Method) -> Result<Plan, GpuError> {
    if count(method, "samples") > 1 {
        return Err(GpuError::Unsupported {
            what: format!("{method} blends several samples a pixel, which the GPU does not"),
            instead: "take list with --taa, or --backend cpu".to_owned(),
        });
    }
    Ok(Plan::Lists)
}

/// Sums of radiance and of weights in the 16 bits of the papers.
const SUMS: TextureFormat = TextureFormat::Rgba16Float;

fn target(label: &'static str, format: TextureFormat) -> Resource {
    Resource::Target { label, format, clear: Color::TRANSPARENT }
}

fn transmittance(label: &'static str, format: TextureFormat) -> Resource {
    Resource::Target { label, format, clear: Color::WHITE }
}

fn weighted() -> Passes {
    let [least, most] = weighted::WEIGHTS;
    let constants = [Constant::new("WEIGHT_LEAST", least), Constant::new("WEIGHT_MOST", most)];
    Passes {
        resources: vec![
            target("weighted sums", SUMS),
            transmittance("weighted transmittance", TextureFormat::R16Float),
        ],
        steps: vec![
            Step {
                name: "blend",
                entry_point: "fs_blend",
                work: Work::Draw { targets: vec![(0, Some(ADD)), (1, Some(MULTIPLY))], depth: None },
                bound: Vec::new(),
            },
            front(vec![(1, 0), (2, 1)]),
        ],
        constants: constant::text(&constants),
        features: Features::empty(),
    }
}

fn moments(method: &Method) -> Passes {
    let order = count(method, "order");
    let (bias, towards) = moments::published_bias(order as usize);
    let mut four = [0.0; 4];
    four.iter_mut().zip(towards).for_each(|(four, towards)| *four = *towards as f32);
    let constants = [Constant::new("MOMENT_BIAS", bias as f32), Constant::new("MOMENT_TOWARDS", four)];
    let mut resources = vec![
        target("blended sums", SUMS),
        target("absorbance", TextureFormat::R32Float),
        target("moments 1 to 4", TextureFormat::Rgba32Float),
    ];
    match order {
        4 => {}
        6 => resources.push(target("moments 5 and 6", TextureFormat::Rg32Float)),
        _ => resources.push(target("moments 5 to 8", TextureFormat::Rgba32Float)),
    }
    // At order 4 the first four stand in for the further ones, which nothing looks at.
    let sums = vec![(1, 1), (2, 2), (3, resources.len() - 1)];
    let targets = (1..resources.len()).map(|index| (index, Some(ADD))).collect();
    Passes {
        resources,
        steps: vec![
            Step {
                name: "moments",
                entry_point: "fs_moments",
                work: Work::Draw { targets, depth: None },
                bound: Vec::new(),
            },
            Step {
                name: "blend",
                entry_point: "fs_blend",
                work: Work::Draw { targets: vec![(0, Some(ADD))], depth: None },
                bound: sums,
            },
            front(vec![(1, 1), (4, 0)]),
        ],
        constants: constant::text(&constants),
        features: Features::FLOAT32_BLENDABLE,
    }
}

/// Two layers take turns: one is looked for behind the other.
fn peel(layers: u32) -> Passes {
    let clear = Color { r: u32::MAX.into(), g: u32::MAX.into(), b: 0.0, a: 0.0 };
    let layer = |label| Resource::Target { label, format: TextureFormat::Rg32Uint, clear };
    let resources = vec![
        layer("even layer"),
        layer("odd layer"),
        Resource::Depth { label: "peel depth" },
        Resource::Storage { label: "peeled layers", bytes_per_pixel: 16 },
    ];
    let mut steps = Vec::new();
    for number in 0..layers as usize {
        let [this, last] = [number % 2, (number + 1) % 2];
        steps.push(Step {
            name: "peel",
            entry_point: if number == 0 { "fs_first" } else { "fs_next" },
            work: Work::Draw { targets: vec![(this, None)], depth: Some(2) },
            bound: if number == 0 { Vec::new() } else { vec![(1, last)] },
        });
        let bound = vec![(1, this), (2, 3)];
        steps.push(Step { name: "blend", entry_point: "cs_blend", work: Work::Pixels, bound });
    }
    steps.push(front(vec![(2, 3)]));
    Passes { resources, steps, constants: String::new(), features: Features::empty() }
}

fn kbuffer(k: u32) -> Passes {
    let bytes_per_pixel = u64::from(4 * k);
    let [sums, products] = TAIL_FORMATS;
    let resources = vec![
        Resource::Storage { label: "kept depths", bytes_per_pixel },
        Resource::Storage { label: "kept triangles", bytes_per_pixel },
        target("tail sums", sums),
        transmittance("tail transmittance", products),
    ];
    let draw = |name, entry_point, bound| {
        let targets = vec![(2, Some(ADD)), (3, Some(MULTIPLY))];
        Step { name, entry_point, work: Work::Draw { targets, depth: None }, bound }
    };
    let steps = vec![
        draw("keep", "fs_keep", vec![(1, 0)]),
        draw("claim", "fs_claim", vec![(1, 0), (2, 1)]),
        front(vec![(2, 1), (3, 2), (4, 3)]),
    ];
    Passes { resources, steps, constants: String::new(), features: Features::empty() }
}
