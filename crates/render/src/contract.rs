//! What a transparency method is to the backends. A backend runs any method and names none.
//!
//! * [`Threshold`]: one shaded fragment a pixel. The method gives a threshold, the backend alone decides by [`keeps`].
//! * [`Selection`]: one shaded fragment a pixel, too, but one threshold for the whole ray, held against the coverage accumulated.
//! * [`Compositing`]: fragments are handed over and the method adds them up.

use std::ops::ControlFlow;

use glam::Vec3;
use sheer_core::{
    blue_noise::blue_noise_64,
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
    /// Nothing but the exact part: the baseline.
    pub const EXACT: Self = Self { visibility: 0.0, layers: None };

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

/// The key for the alignment of motion vectors (STD section 3.3.1), which every method takes whose pattern is fixed to the screen.
pub(crate) const ALIGNMENT_PARAMETER: ParameterInfo = ParameterInfo {
    key: "align",
    default: AlignmentRule::Random.word(),
    range: ParameterRange::Choice(&AlignmentRule::WORDS),
    what: "under taa: align motion vectors to the dithering pattern, at random as in the paper; off shows what that prevents; \
           round: to the nearest place; dead: as in the authors' code, where the least motion counts as none and history is \
           clipped to a box",
};

/// To which of the multiples of a pattern's side a motion vector goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlignmentRule {
    /// One of the four nearest, drawn by bilinear weight, so that the mean motion stays what it is (STD
    /// Listing 5).
    Random,
    /// None of them: the vector stays as it is.
    Off,
    /// The nearest, which lags behind slow motion (STD section 3.3.1 says so and does not do it).
    Nearest,
    /// As [`Self::Random`] after a component shorter than [`Self::DEAD_ZONE`] of the picture's side has
    /// become 0; and what rectifies the history clips it to a box, not to an ellipsoid. So does the authors'
    /// own code (Falcor's `TAA` pass and their `DitherVBuffer2`).
    DeadZone,
}

impl AlignmentRule {
    /// All, in the order in which they are listed.
    pub const ALL: [Self; 4] = [Self::Random, Self::Off, Self::Nearest, Self::DeadZone];
    /// Share of the picture's width, or height, below which a component of the motion counts as none, with
    /// [`Self::DeadZone`].
    pub const DEAD_ZONE: f32 = 1e-4;
    const WORDS: [&str; Self::ALL.len()] =
        [Self::ALL[0].word(), Self::ALL[1].word(), Self::ALL[2].word(), Self::ALL[3].word()];

    /// The word on the command line.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Random => "on",
            Self::Off => "off",
            Self::Nearest => "round",
            Self::DeadZone => "dead",
        }
    }

    pub(crate) fn new(values: &Values) -> Self {
        let word = values.text(ALIGNMENT_PARAMETER.key);
        let rule = Self::ALL.into_iter().find(|rule| rule.word() == word);
        rule.expect("the value was checked against the words of all rules")
    }
}

/// How the motion vectors of a method's transparent fragments are aligned to its dithering pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alignment {
    /// Side of the pattern, pixels.
    pub side_px: u32,
    /// What becomes of a vector.
    pub rule: AlignmentRule,
}

impl Alignment {
    /// Motion vectors stay as they are.
    pub const NONE: Self = Self { side_px: 1, rule: AlignmentRule::Off };
}

/// How the backend finds the fragments of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gathering {
    /// All hits of the ray in one traversal, bounded by the first opaque one, then sorted: front to back.
    Sorted,
    /// One ray after the other, each starting where the last one ended: front to back.
    Continuation,
    /// All hits in front of what is opaque, in the order in which the scene lists its triangles: what a rasteriser hands over.
    Unordered {
        /// Trace the fragments anew for each pass, as a rasteriser without lists renders the geometry anew; or keep them, which is
        /// faster and gives the same picture.
        each_pass: bool,
    },
}

/// The key for [`Gathering::Unordered`], for methods of several passes.
pub const RETRACE_PARAMETER: ParameterInfo = ParameterInfo {
    key: "retrace",
    default: "off",
    range: ParameterRange::Choice(&["off", "on"]),
    what: "trace the fragments anew for each pass, as a rasteriser renders them anew; the same picture, times as on a GPU",
};

/// The samples of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples {
    /// How many, 1 to [`Self::MOST`].
    pub count: u32,
    /// Where they lie.
    pub placement: Placement,
}

/// Where the samples of a pixel lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// All where the pixel's one ray goes through: a surface covers all of them or none.
    Centre,
    /// Spread evenly over the pixel, so that their mean is its box filter.
    Box,
    /// Spread over 2×2 pixels by the density of a Gaussian, so that their mean is the filter of ST section 3.5.
    Gaussian,
}

impl Samples {
    /// A mask has one bit a sample.
    pub const MOST: u32 = 64;
    /// One sample, where the pixel's ray goes through.
    pub const ONE: Self = Self { count: 1, placement: Placement::Centre };

    /// All samples as a mask.
    #[must_use]
    pub fn all(self) -> u64 {
        u64::MAX >> (Self::MOST - self.count)
    }
}

/// A pixel that a compositing method is about to fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelSite {
    /// Column and row, from the upper left.
    pub pixel: [u32; 2],
    /// Frame index.
    pub frame: u32,
    /// Seed of the run.
    pub seed: u32,
    /// No fragment of the frame is nearer or further than these, scene units along the view axis; both above 0.
    pub depth_range: [f32; 2],
}

/// The part of a triangle that a pixel sees, transparent and in front of everything opaque.
#[derive(Clone, Copy, Debug)]
pub struct Fragment<'a> {
    /// Opacity, [`MIN_ALPHA`] to below 1, at the covered sample nearest to the pixel centre, where it is shaded, too. Ordered gatherings
    /// end with a fragment of 1, where something opaque is.
    pub alpha: f32,
    /// Samples that it covers, one bit each; never none.
    pub coverage: u64,
    /// Depth at each sample, scene units along the view axis; samples that are not covered hold anything. Only one where all samples lie
    /// in the centre.
    pub depths: &'a [f32],
    /// The triangle's place in the scene: breaks ties of equal depths, so that no order of drawing shows.
    pub order: u32,
    /// `InstanceID()` of STD Listing 4.
    pub instance: u32,
    /// `GeometryIndex()`.
    pub geometry: u32,
    /// `PrimitiveIndex()`.
    pub primitive: u32,
    /// `HitKind()`: false front, true back.
    pub is_back: bool,
}

impl Fragment<'_> {
    /// Depth at a covered sample, with its tie-breaker: the order of all fragments there.
    #[must_use]
    #[inline]
    pub fn place(&self, sample: usize) -> (f32, u32) {
        (self.depths[sample.min(self.depths.len() - 1)], self.order)
    }

    /// Depth where it is shaded.
    #[must_use]
    #[inline]
    pub fn depth(&self) -> f32 {
        self.depths[(self.coverage.trailing_zeros() as usize).min(self.depths.len() - 1)]
    }
}

/// What a method stores for a pixel on a GPU, beyond the colour and depth targets that all methods have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// So many bytes, whatever the scene.
    Bounded(u32),
    /// So many bytes a fragment: there is no bound.
    PerFragment(u32),
}

/// A cross-bilateral filter over the light of a method's fragments (ST section 6): pixels count by their distance and by the difference of
/// their total alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerFilter {
    /// Neighbours up to this distance in rows and columns count, pixels.
    pub radius_px: u32,
    /// Standard deviation of the Gaussian over distance, pixels.
    pub sigma_px: f32,
    /// Standard deviation of the Gaussian over differences of total alpha.
    pub sigma_alpha: f32,
}

/// Family of methods that add up fragments. In an unordered gathering what is opaque is no fragment but part of the background, which the
/// backend shades by itself and adds by what [`Self::transmittance`] leaves of it; in an ordered one it is the last fragment.
pub trait Compositing: Sync {
    /// What is kept of a pixel.
    type Pixel;

    /// How fragments are to be found.
    fn gathering(&self) -> Gathering;

    /// The samples of a pixel; more than one only with [`Gathering::Unordered`].
    fn samples(&self) -> Samples {
        Samples::ONE
    }

    /// How often all fragments are handed over; more than once only with [`Gathering::Unordered`].
    fn pass_count(&self) -> usize {
        1
    }

    /// What a pass does, for tables of times.
    fn pass_name(&self, pass: usize) -> &'static str {
        let _ = pass;
        "blend"
    }

    /// Whether any order of the fragments gives the same pixel, but for rounding. Methods with an ordered gathering see only one order.
    fn is_order_independent(&self) -> bool {
        true
    }

    /// What it stores.
    fn memory(&self) -> Memory;

    /// A filter that the backend lays over what [`Self::resolve`] gives of all pixels, before the background is put behind it; only with
    /// [`Gathering::Unordered`].
    fn layer_filter(&self) -> Option<LayerFilter> {
        None
    }

    /// An empty pixel.
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

    /// Fragments that found no place of their own in bounded memory and were merged with others.
    fn merged_count(&self, pixel: &Self::Pixel) -> u32 {
        let _ = pixel;
        0
    }
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
