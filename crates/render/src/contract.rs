//! What a transparency method is to the backends. A backend runs any method and names none.
//!
//! * [`Threshold`]: one shaded fragment a pixel. The method gives a threshold, the backend alone decides by [`keeps`].
//! * [`Selection`]: one shaded fragment a pixel, too, but one threshold for the whole ray, held against the coverage accumulated.
//! * [`Compositing`]: fragments are handed over and the method adds them up.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    blue_noise::blue_noise_64,
    colour::Premul,
    parameter::{ParameterInfo, ParameterRange, Values},
    threshold_map::{ThresholdMap, std_maps},
};

/// Alpha below this is not there (STD Listing 2, `MIN_ALPHA`): it saves the shading of what nobody sees.
pub const MIN_ALPHA: f32 = 0.01;
/// What lies behind this visibility is not looked for (STD Listing 2, `MIN_VISIBILITY`).
pub const MIN_VISIBILITY: f32 = 0.001;

/// A method's entry in lists, help and docs.
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    /// The word on the command line, the module, later the shader.
    pub id: &'static str,
    /// A line on what it does.
    pub title: &'static str,
    /// Paper and section.
    pub paper: &'static str,
    /// What its result is biased in, in words.
    pub bias: &'static str,
    /// Keys it takes.
    pub parameters: &'static [ParameterInfo],
    /// Motion vectors are aligned to multiples of this many pixels (STD section 3.3.1); 1: not at all.
    pub alignment_px: u32,
}

/// What a threshold may depend on, for `N` hits at once: 1 in single-ray code, 8 or 16 in tiles.
#[derive(Clone, Copy, Debug)]
pub struct Site<const N: usize> {
    /// Column and row of the pixel, from the upper left.
    pub pixel: [[u32; N]; 2],
    /// Frame index, with the seed mixed in where randomness is wanted: see [`Self::seed`].
    pub frame: u32,
    /// Seed of the run.
    pub seed: u32,
    /// `InstanceID()` of STD Listing 4.
    pub instance: [u32; N],
    /// `GeometryIndex()`.
    pub geometry: [u32; N],
    /// `PrimitiveIndex()`.
    pub primitive: [u32; N],
    /// `HitKind()`: 0 front, 1 back.
    pub back: [u32; N],
    /// Hit point in world: x, y, z.
    pub position: [[f32; N]; 3],
    /// Hit point in the space of its object, before it moves and bends. This and the next are only filled for methods that ask for them by
    /// [`Threshold::uses_object_space`].
    pub position_in_object: [[f32; N]; 3],
    /// Length that a pixel covers there, along its longer axis; may be infinite.
    pub footprint_in_object: [f32; N],
}

impl<const N: usize> Default for Site<N> {
    fn default() -> Self {
        let none = [0; N];
        Self {
            pixel: [none; 2],
            frame: 0,
            seed: 0,
            instance: none,
            geometry: none,
            primitive: none,
            back: none,
            position: [[0.0; N]; 3],
            position_in_object: [[0.0; N]; 3],
            footprint_in_object: [0.0; N],
        }
    }
}

/// Side of the blue noise tile, pixels.
pub const BLUE_NOISE_SIDE: u32 = 64;

/// Tables that thresholds are made from, built once a process.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// The 288 maps of STD section 3.3.
    pub std_maps: &'static [ThresholdMap],
    /// 64×64 blue noise in (0, 1), row-major.
    pub blue_noise: &'static [f32],
}

impl Tables {
    /// Builds the tables on first use.
    #[must_use]
    pub fn get() -> Self {
        Self { std_maps: std_maps(), blue_noise: blue_noise_64().values() }
    }

    /// The blue noise of a pixel, in (0, 1): `BlueNoise64x64Tex[pixel % 64]` of STD Listings 1 and 4.
    #[must_use]
    #[inline]
    pub fn blue_noise_at(&self, pixel: [u32; 2]) -> f32 {
        let [x, y] = pixel.map(|coordinate| coordinate % BLUE_NOISE_SIDE);
        self.blue_noise[(y * BLUE_NOISE_SIDE + x) as usize]
    }
}

/// Family of methods that keep or drop a hit by comparing its alpha with a threshold.
pub trait Threshold: Sync {
    /// Whether the method wants to know where on its object a hit lies, which costs the backend some work a hit.
    fn uses_object_space(&self) -> bool {
        false
    }

    /// Thresholds in [0, 1) for `N` hits.
    fn threshold<const N: usize>(&self, site: &Site<N>, tables: &Tables) -> [f32; N];
}

/// The decision of STD Listings 3 and 4, with both ends exact: next to nothing is never kept, opaque always.
#[must_use]
#[inline]
pub fn keeps(alpha: f32, threshold: impl FnOnce() -> f32) -> bool {
    alpha >= MIN_ALPHA && (alpha >= 1.0 || alpha >= threshold())
}

/// Family of methods that hold one threshold a pixel against the coverage accumulated front to back, `1 - Π (1 - alpha)`. The fragment
/// with which the coverage first exceeds it is the one shaded, the background if it never does. With a threshold uniform in [0, 1) each
/// fragment comes with its share of the pixel, and layers cannot mask one another. The price: the backend needs the hits in order.
pub trait Selection: Sync {
    /// Threshold in [0, 1) of the pixel at column and row `pixel`, in a frame of a run with a seed.
    fn threshold(&self, pixel: [u32; 2], frame: u32, seed: u32, tables: &Tables) -> f32;
}

/// The hybrid of exact and stochastic (STD section 3.4): fragments are shaded and composited front to back until the visibility has fallen
/// to a share, then one stochastic ray stands for the rest. The backend wraps it around any [`Threshold`] or [`Selection`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hybrid {
    /// Visibility from which on the stochastic ray takes over, 0 to 1: 0 is exact, 1 purely stochastic.
    pub visibility: f32,
    /// The most fragments that are composited before, however much is visible; `None` for no such limit. The paper's fall-back to a
    /// k-buffer where many faint layers would each be shaded; here the rest is sampled, so nothing is dropped.
    pub layers: Option<u32>,
}

impl Hybrid {
    /// No exact part at all.
    pub const NONE: Self = Self { visibility: 1.0, layers: None };

    /// The keys for it.
    pub(crate) const PARAMETERS: &[ParameterInfo] = &[
        ParameterInfo {
            key: "hybrid",
            default: "1",
            range: ParameterRange::Real(0.0, 1.0),
            what: "exact until visibility falls to this, one stochastic ray for the rest; 0 is the baseline",
        },
        ParameterInfo {
            key: "layers",
            default: "0",
            range: ParameterRange::Count(0, 64),
            what: "with hybrid below 1: at most so many exact fragments; 0 for no limit",
        },
    ];

    pub(crate) fn new(values: &Values) -> Self {
        let layers = values.count("layers");
        Self { visibility: values.real("hybrid"), layers: (layers > 0).then_some(layers) }
    }
}

/// The key for the correction of coverage (STD section 3.2.1), which every [`Threshold`] and [`Selection`] takes. The backend applies it to
/// the opacity that is held against a threshold, not to fragments that are composited exactly, nor to shadows.
pub(crate) const CORRECTION_PARAMETER: ParameterInfo = ParameterInfo {
    key: "correction",
    default: "none",
    range: ParameterRange::Choice(&["none", "dlss"]),
    what: "opacity to coverage before the threshold; dlss: STD Eq. 5; on the command line also a file of `sheer calibrate`",
};

/// How the backend finds the fragments of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gathering {
    /// All hits of the ray in one traversal, bounded by the first opaque one, then sorted.
    Sorted,
    /// One ray after the other, each starting where the last one ended.
    Continuation,
}

/// Family of methods that add up fragments. They arrive front to back.
pub trait Compositing: Sync {
    /// What is kept of a pixel.
    type Pixel;

    /// How fragments are to be found.
    fn gathering(&self) -> Gathering;

    /// An empty pixel.
    fn begin(&self) -> Self::Pixel;

    /// Adds a fragment of the given opacity; `shade` gives its radiance and is the costly part. `Break` ends the pixel.
    fn add(&self, pixel: &mut Self::Pixel, alpha: f32, shade: impl FnOnce() -> Vec3) -> ControlFlow<()>;

    /// The pixel without its background.
    fn resolve(&self, pixel: Self::Pixel) -> Premul;
}

/// A backend's reaction to each family.
pub trait Visitor {
    /// What comes of it.
    type Output;
    /// The method decides by threshold.
    fn threshold(self, method: &impl Threshold) -> Self::Output;
    /// The method selects one fragment by the accumulated coverage.
    fn selection(self, method: &impl Selection) -> Self::Output;
    /// The method adds fragments up.
    fn compositing(self, method: &impl Compositing) -> Self::Output;
}
