//! How a GPU draws a method that takes its fragments in any order: targets, memory and passes, as plain data.
//! A backend carries it out and names no method.
//!
//! Entry points are those of the method's shader, `shaders/method/<id>.wgsl`.

use super::info::ShaderConstant;

/// How a method is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Raster {
    /// All fragments go to a list a pixel first; [`Step::FINAL_ENTRY_POINT`] takes them from there.
    Lists,
    /// Passes over all triangles with targets and buffers of their own.
    Passes(Passes),
    /// Targets of several samples a pixel, of which chance lets a fragment cover some (ST).
    Multisample(Multisample),
}

/// Why a method cannot be drawn by raster.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoRaster {
    /// What stands in the way.
    pub what: String,
    /// What to ask for instead, on the same device.
    pub instead: Option<&'static str>,
}

/// Memory and the steps that use it.
#[derive(Clone, Debug, PartialEq)]
pub struct Passes {
    /// What each pixel has.
    pub resources: Vec<Resource>,
    /// The passes in the order in which they run. Those with one entry point are alike but for the resources
    /// they use.
    pub steps: Vec<Step>,
    /// Constants of the shader that follow from the method's parameters.
    pub constants: Vec<ShaderConstant>,
}

/// Something of the picture's size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resource {
    /// A texture that is drawn to and read by later steps.
    Target {
        /// Its name in the driver's messages.
        label: &'static str,
        /// What a texel holds.
        format: TargetFormat,
        /// What each step that draws to it starts from: red, green, blue, alpha.
        clear: [f64; 4],
    },
    /// A depth buffer; each step that tests against it starts from the furthest depth.
    Depth {
        /// Its name in the driver's messages.
        label: &'static str,
    },
    /// A buffer that shaders read and write; zero at the start of a frame.
    Storage {
        /// Its name in the driver's messages.
        label: &'static str,
        /// How much of it a pixel has.
        bytes_per_pixel: u64,
    },
}

impl Passes {
    /// The places where something is bound, each once.
    #[must_use]
    pub fn bindings(&self) -> Vec<Binding> {
        let mut bindings: Vec<_> =
            self.steps.iter().flat_map(|step| &step.bound).map(|&(binding, _)| binding).collect();
        bindings.sort_by_key(|binding| binding.number);
        bindings.dedup();
        bindings
    }
}

impl Resource {
    /// A target that starts from 0.
    #[must_use]
    pub const fn sums(label: &'static str, format: TargetFormat) -> Self {
        Self::Target { label, format, clear: [0.0; 4] }
    }

    /// A target that starts from 1.
    #[must_use]
    pub const fn products(label: &'static str, format: TargetFormat) -> Self {
        Self::Target { label, format, clear: [1.0; 4] }
    }
}

/// What a texel of a target holds; `R` to `Rgba` is the number of channels, then come bits and kind of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetFormat {
    /// One channel, a 16-bit float.
    R16Float,
    /// Four channels, 16-bit floats.
    Rgba16Float,
    /// One channel, a 32-bit float.
    R32Float,
    /// Two channels, 32-bit floats.
    Rg32Float,
    /// Four channels, 32-bit floats.
    Rgba32Float,
    /// Two channels, 32-bit unsigned whole numbers.
    Rg32Uint,
}

/// A pass over all triangles or all pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What its time is reported as.
    pub name: &'static str,
    /// Name of a function in the method's shader.
    pub entry_point: &'static str,
    /// What it runs over.
    pub kind: StepKind,
    /// Indices in [`Passes::resources`] of what is bound, and where.
    pub bound: Vec<(Binding, usize)>,
}

/// A place of bind group 2, under the name that shaders know its number by. Number 0 is the opaque surface of
/// the pixel, whatever the method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// The WGSL constant for the number: `BIND_` and what is bound there.
    pub name: &'static str,
    /// Within the group; from 1 on.
    pub number: u32,
}

impl Binding {
    /// Radiance times alpha, and alpha, of fragments that no memory was left for.
    pub const TAIL_SUMS: Self = Self::new("BIND_TAIL_SUMS", 3);
    /// The product of the transmittances of these fragments.
    pub const TAIL_TRANSMITTANCE: Self = Self::new("BIND_TAIL_TRANSMITTANCE", 4);

    /// A place under a name.
    #[must_use]
    pub const fn new(name: &'static str, number: u32) -> Self {
        Self { name, number }
    }
}

impl Step {
    /// The entry point of the last step of all methods, which leaves the light of a pixel's fragments and
    /// their transmittance.
    pub const FINAL_ENTRY_POINT: &str = "cs_front";

    /// The step that ends the plan of every method.
    #[must_use]
    pub fn last(bound: Vec<(Binding, usize)>) -> Self {
        Self { name: "front", entry_point: Self::FINAL_ENTRY_POINT, kind: StepKind::Pixels, bound }
    }
}

/// What a step runs over.
#[derive(Clone, Debug, PartialEq)]
pub enum StepKind {
    /// The fragments of all triangles.
    Draw {
        /// Indices of the targets, and how a fragment is blended with what is there; `None` replaces it.
        targets: Vec<(usize, Option<Blend>)>,
        /// Index of the depth buffer, if only the nearest fragment stays.
        depth: Option<usize>,
    },
    /// Each pixel of the picture once.
    Pixels,
}

/// How the blending unit joins a fragment with what is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// Each channel is the sum of both.
    Add,
    /// Each channel is the product of both.
    Multiply,
}

/// Rounds of drawing to targets of several samples. The hardware's samples are a divisor of
/// [`Self::samples`], the rest becomes rounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Multisample {
    /// Samples of a pixel in each pass.
    pub samples: u32,
    /// How often these are drawn anew.
    pub passes: u32,
    /// What a sample keeps.
    pub keeps: SampleContent,
    /// Whether a pixel's sums are scaled to its exact total alpha (ST section 3.3).
    pub is_corrected: bool,
}

/// What a sample keeps of the nearest fragment that covers it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleContent {
    /// Its colour: the estimator of ST section 3.1.
    Colour,
    /// Its depth, by which a second pass weighs all fragments: the estimator of ST section 3.4.
    Depth,
}
