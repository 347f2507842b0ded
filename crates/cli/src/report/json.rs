//! Machine-readable reports. Names and types are the contract of `report.json` and of what `bench`, `verify`
//! and `devices` write with `--json`.

use serde::Serialize;
use sheer_core::parameter::Choice as _;
use sheer_image::Tone;
use sheer_lab::{AgainstTruth, ForeignJudged, Judged, Measured, Reference, Tally, verify::Check};
use sheer_render::{Antialiasing, Method};

use crate::version::{COMMIT, VERSION};

/// How figures came about, in front of every report.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Run {
    /// As it was asked for.
    pub(crate) scene: String,
    /// Identifies the scene's contents.
    pub(crate) scene_hash: String,
    /// The asked-for camera, or `default`.
    pub(crate) camera: String,
    /// `--alpha`.
    pub(crate) alpha: Option<f32>,
    /// Width and height, pixels.
    pub(crate) size: [u32; 2],
    /// How many.
    pub(crate) frames: u32,
    /// Index of the first frame.
    pub(crate) first_frame: u32,
    /// Time of frame 0, seconds.
    pub(crate) time_secs: f32,
    /// `--shadow` with all its keys.
    pub(crate) shadow: String,
    /// `--environment`.
    pub(crate) environment: String,
    /// `--environment-strength`.
    pub(crate) environment_strength: f32,
    /// `--tone`, of displayed pictures.
    pub(crate) tone: &'static str,
    /// `--exposure`, stops, of displayed pictures.
    pub(crate) exposure_ev: f32,
    /// What rendered.
    pub(crate) backend: &'static str,
    /// The processor, or the GPU with its driver.
    pub(crate) adapter: String,
    /// Seed of the dithering.
    pub(crate) seed: u32,
    /// Of this program.
    pub(crate) version: &'static str,
    /// Of this program, or `unknown`.
    pub(crate) commit: &'static str,
    /// How many rendered.
    pub(crate) threads: usize,
}

/// What `sheer metrics` writes with `--json`.
#[derive(Debug, Serialize)]
pub(crate) struct JudgedPictures<'a> {
    /// What the pictures are held against, as it was named.
    reference: &'a str,
    /// Width and height, pixels.
    size: [u32; 2],
    /// `--tone`, of pictures that were stored in linear light.
    tone: &'static str,
    /// `--exposure`, stops, of the same.
    exposure_ev: f32,
    /// Of this program.
    version: &'static str,
    /// Of this program, or `unknown`.
    commit: &'static str,
    rows: Vec<JudgedRow<'a>>,
}

/// A picture or a clip in comparison with the reference; names and units as in [`ComparisonRow`].
#[derive(Debug, Serialize)]
struct JudgedRow<'a> {
    picture: &'a str,
    frames: u32,
    ssim: f64,
    psnr_db: Option<f64>,
    tpsnr_db: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vdp_jod: Option<f64>,
    flip: f64,
    /// Null for one frame.
    flicker: Option<f64>,
    bias: f64,
    rms: f64,
}

impl<'a> JudgedPictures<'a> {
    pub(crate) fn new(reference: &'a str, size: [u32; 2], tone: &Tone, judged: &'a [Judged]) -> Self {
        let row = |judged: &'a Judged| {
            let Judged { frames, ssim, psnr_db, tpsnr_db, vdp_jod, flip, flicker, bias, rms, .. } = *judged;
            let picture = &judged.name;
            JudgedRow { picture, frames, ssim, psnr_db, tpsnr_db, vdp_jod, flip, flicker, bias, rms }
        };
        Self {
            reference,
            size,
            tone: tone.curve.word(),
            exposure_ev: tone.exposure_ev,
            version: VERSION,
            commit: COMMIT,
            rows: judged.iter().map(row).collect(),
        }
    }
}

/// `report.json` of `sheer compare`.
#[derive(Debug, Serialize)]
pub(crate) struct Comparison {
    #[serde(flatten)]
    pub(crate) run: Run,
    /// The method that the others are compared with.
    pub(crate) reference: String,
    /// One for each method under each anti-aliasing against each reference, `baseline` among them; after them
    /// one for the pictures of each other program, likewise.
    pub(crate) rows: Vec<ComparisonRow>,
}

/// A method in comparison with a reference. Qualities are means over the last half of the frames, when the
/// history has settled; against the truth over the last quarter.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ComparisonRow {
    pub(crate) method: String,
    pub(crate) aa: String,
    /// Of pictures of another program, which `method` names: their file or pattern.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) pictures: Option<String>,
    /// What the qualities are against: `same`, `baseline` under the same anti-aliasing, or `truth`, the exact
    /// answer with many samples a pixel at the moment of each frame (`truth:samples=N` if not 32).
    pub(crate) reference: String,
    /// Milliseconds a frame with acceleration structure builds, without temporal anti-aliasing. These, and
    /// what was counted, are null for pictures of another program.
    pub(crate) ms_median: Option<f64>,
    pub(crate) ms_min: Option<f64>,
    pub(crate) ms_max: Option<f64>,
    /// Of the displayed image; 1: equal.
    pub(crate) ssim: f64,
    /// Of the displayed image; null where it equals the reference.
    pub(crate) psnr_db: Option<f64>,
    /// Of the differences of successive displayed frames; null where they equal those of the reference, or
    /// for one frame.
    pub(crate) tpsnr_db: Option<f64>,
    /// ColorVideoVDP of the displayed clip in just-objectionable differences, 10: no visible one; where it
    /// was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) vdp_jod: Option<f64>,
    /// Of the displayed image; 0: equal.
    pub(crate) flip: Option<f64>,
    /// Standard deviation of the displayed error over time; null for a single picture of another program.
    pub(crate) flicker: Option<f64>,
    /// Mean error in linear light, with its sign, in the pixels that were uncovered during the last 8 frames;
    /// against the truth, and where there are some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) ghosting: Option<f64>,
    /// Mean error in linear light, with its sign; null for pictures of another program that are made for a
    /// display.
    pub(crate) bias: Option<f64>,
    /// Root mean square error in linear light; null likewise.
    pub(crate) rms: Option<f64>,
    /// Fragments shaded for a pixel of a frame.
    pub(crate) shaded_per_pixel: Option<f64>,
    /// Hits tested or composited for a pixel of a frame.
    pub(crate) hits_per_pixel: Option<f64>,
    /// What the method stores beyond colour and depth: by its paper on the CPU (of an unbounded one, bytes a
    /// fragment times the mean of hits for a pixel), what was allocated on a GPU.
    pub(crate) memory_bytes_per_pixel: Option<f64>,
    /// Fragments merged for want of a place, for a pixel of a frame.
    pub(crate) merged_per_pixel: Option<f64>,
}

impl ComparisonRow {
    /// What programs read of a method; nothing if it was not held against the reference.
    pub(crate) fn new(measured: &Measured, reference: Reference) -> Option<Self> {
        let against_same = Self {
            method: measured.method.to_string(),
            aa: measured.antialiasing.to_string(),
            pictures: None,
            reference: reference.to_string(),
            ms_median: Some(measured.ms_median),
            ms_min: Some(measured.ms_min),
            ms_max: Some(measured.ms_max),
            ssim: measured.ssim,
            psnr_db: measured.psnr_db,
            tpsnr_db: measured.tpsnr_db,
            vdp_jod: measured.vdp_jod,
            flip: Some(measured.flip),
            flicker: Some(measured.flicker),
            ghosting: None,
            bias: Some(measured.bias),
            rms: Some(measured.rms),
            shaded_per_pixel: Some(measured.shaded_per_pixel),
            hits_per_pixel: Some(measured.hits_per_pixel),
            memory_bytes_per_pixel: Some(measured.memory_bytes_per_pixel),
            merged_per_pixel: Some(measured.merged_per_pixel),
        };
        match reference {
            Reference::Same => Some(against_same),
            Reference::Truth { .. } => Some(against_same.against(measured.against_truth.as_ref()?)),
        }
    }

    /// What programs read of pictures of another program; nothing if they were not held against the
    /// reference.
    pub(crate) fn of_foreign(foreign: &ForeignJudged, pattern: &str, reference: Reference) -> Option<Self> {
        let (judged, ghosting) = match reference {
            Reference::Same => (&foreign.against_same, None),
            Reference::Truth { .. } => (foreign.against_truth.as_ref()?, foreign.ghosting),
        };
        let linear = |error: f64| foreign.in_linear_light.then_some(error);
        Some(Self {
            method: judged.name.clone(),
            aa: foreign.antialiasing.to_string(),
            pictures: Some(pattern.to_owned()),
            reference: reference.to_string(),
            ms_median: None,
            ms_min: None,
            ms_max: None,
            ssim: judged.ssim,
            psnr_db: judged.psnr_db,
            tpsnr_db: judged.tpsnr_db,
            vdp_jod: judged.vdp_jod,
            flip: Some(judged.flip),
            flicker: judged.flicker,
            ghosting: ghosting.and_then(linear),
            bias: linear(judged.bias),
            rms: linear(judged.rms),
            shaded_per_pixel: None,
            hits_per_pixel: None,
            memory_bytes_per_pixel: None,
            merged_per_pixel: None,
        })
    }

    /// The same row with the qualities against the truth.
    fn against(self, truth: &AgainstTruth) -> Self {
        // Every field but the error map is named, so that a new one cannot be forgotten.
        let &AgainstTruth {
            ssim,
            psnr_db,
            tpsnr_db,
            vdp_jod,
            flip,
            flicker,
            ghosting,
            bias,
            rms,
            error_map: _,
        } = truth;
        let [flip, flicker, bias, rms] = [flip, flicker, bias, rms].map(Some);
        Self { ssim, psnr_db, tpsnr_db, vdp_jod, flip, flicker, ghosting, bias, rms, ..self }
    }
}

/// `sheer bench --json`.
#[derive(Debug, Serialize)]
pub(crate) struct Benchmark {
    #[serde(flatten)]
    pub(crate) run: Run,
    pub(crate) rows: Vec<BenchmarkRow>,
}

/// What a method costs.
#[derive(Debug, Serialize)]
pub(crate) struct BenchmarkRow {
    pub(crate) method: String,
    pub(crate) aa: String,
    /// Milliseconds of each frame, with acceleration structure builds.
    pub(crate) ms: Vec<f64>,
    pub(crate) ms_median: f64,
    pub(crate) ms_min: f64,
    pub(crate) ms_max: f64,
    /// Half of the frames lie within so many milliseconds of one another: third less first quartile.
    pub(crate) ms_spread: f64,
    /// Median over that of the first row.
    pub(crate) ratio: f64,
    /// Animation and acceleration structure, part of `ms`.
    pub(crate) build_ms_median: f64,
    /// Making shadow maps, part of `ms`.
    pub(crate) shadow_ms_median: f64,
    /// Adding frames up over time, no part of `ms`.
    pub(crate) resolve_ms_median: f64,
    /// A frame with all that it takes, and its ratio to that of the first row.
    pub(crate) whole_ms_median: f64,
    pub(crate) whole_ratio: f64,
    /// Camera and shadow rays a frame, mean.
    pub(crate) rays: f64,
    /// Fragments shaded a frame, mean.
    pub(crate) shaded: f64,
    /// Million rays a second of tracing and shading.
    pub(crate) mray_per_s: f64,
    /// The passes of a frame by the GPU's own clock, in order; missing where it has none and on the
    /// processor.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) steps: Vec<Step>,
}

impl BenchmarkRow {
    /// What the frames of a method cost, beside those of the first one.
    pub(crate) fn new(method: &Method, antialiasing: Antialiasing, tally: &Tally, first: &Tally) -> Self {
        Self {
            method: method.to_string(),
            aa: antialiasing.to_string(),
            ms: tally.frame_ms(),
            ms_median: tally.ms(0.5),
            ms_min: tally.ms(0.0),
            ms_max: tally.ms(1.0),
            ms_spread: tally.ms(0.75) - tally.ms(0.25),
            ratio: tally.ms(0.5) / first.ms(0.5),
            build_ms_median: tally.build_ms(),
            shadow_ms_median: tally.shadow_ms(),
            resolve_ms_median: tally.resolve_ms(),
            whole_ms_median: tally.whole_ms(),
            whole_ratio: tally.whole_ms() / first.whole_ms(),
            rays: tally.rays(),
            shaded: tally.shaded(),
            mray_per_s: tally.mray_per_s(),
            steps: tally.steps().map(|(name, ms_median)| Step { name, ms_median }).collect(),
        }
    }
}

/// A pass of a frame.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Step {
    pub(crate) name: &'static str,
    pub(crate) ms_median: f64,
}

/// `sheer devices --json`.
#[derive(Debug, Serialize)]
pub(crate) struct Devices {
    pub(crate) version: &'static str,
    pub(crate) commit: &'static str,
    /// The one that is taken where none is named comes first.
    pub(crate) devices: Vec<Device>,
}

/// A GPU and what it can run.
#[derive(Debug, Serialize)]
pub(crate) struct Device {
    /// What `--adapter` takes.
    pub(crate) index: usize,
    pub(crate) name: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `unknown`.
    #[serde(rename = "type")]
    pub(crate) kind: &'static str,
    pub(crate) driver: String,
    /// The interface it is reached through.
    pub(crate) api: String,
    /// Whether it traces rays itself.
    pub(crate) ray_query: bool,
    /// Whether it times passes itself.
    pub(crate) timestamps: bool,
    /// Samples a pixel that pictures may have beside one.
    pub(crate) msaa: Vec<u32>,
    /// The largest buffer that a shader reads.
    pub(crate) max_storage_bytes: u64,
    /// Backends that run on it.
    pub(crate) paths: Vec<&'static str>,
    /// The one that `--backend gpu` is for methods that go by rays; null if it does not run.
    pub(crate) automatic: Option<&'static str>,
}

/// `sheer verify --json`.
#[derive(Debug, Serialize)]
pub(crate) struct Verification {
    pub(crate) version: &'static str,
    pub(crate) commit: &'static str,
    pub(crate) checks: Vec<Check>,
}

/// A report as text with a final line break.
pub(crate) fn text(report: &impl Serialize) -> anyhow::Result<String> {
    Ok(serde_json::to_string_pretty(report)? + "\n")
}
