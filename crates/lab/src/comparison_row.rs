//! What programs read of a comparison: names and types of the rows of `report.json`, and of what Python gets.

use serde::Serialize;

use crate::{AgainstTruth, ForeignJudged, Measured, Reference};

/// A method in comparison with a reference. Qualities are means over the last half of the frames, when the
/// history has settled; against the truth over the last quarter.
#[derive(Clone, Debug, Serialize)]
pub struct ComparisonRow {
    /// As it is typed; the name of pictures of another program.
    pub method: String,
    /// As it is typed.
    pub aa: String,
    /// Of pictures of another program, which `method` names: their file or pattern.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pictures: Option<String>,
    /// What the qualities are against: `same`, `baseline` under the same anti-aliasing, or `truth`, the exact
    /// answer with many samples a pixel at the moment of each frame (`truth:samples=N` if not 32).
    pub reference: String,
    /// Milliseconds a frame with acceleration structure builds, without temporal anti-aliasing. These, and
    /// what was counted, are null for pictures of another program.
    pub ms_median: Option<f64>,
    /// Of the fastest frame.
    pub ms_min: Option<f64>,
    /// Of the slowest.
    pub ms_max: Option<f64>,
    /// Of the displayed image; 1: equal.
    pub ssim: f64,
    /// Of the displayed image; null where it equals the reference.
    pub psnr_db: Option<f64>,
    /// Of the differences of successive displayed frames; null where they equal those of the reference, or
    /// for one frame.
    pub tpsnr_db: Option<f64>,
    /// ColorVideoVDP of the displayed clip in just-objectionable differences, 10: no visible one; where it
    /// was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vdp_jod: Option<f64>,
    /// Of the displayed image; 0: equal.
    pub flip: Option<f64>,
    /// Standard deviation of the displayed error over time; null for a single picture of another program.
    pub flicker: Option<f64>,
    /// Mean error in linear light, with its sign, in the pixels that were uncovered during the last 8 frames;
    /// against the truth, and where there are some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ghosting: Option<f64>,
    /// Mean error in linear light, with its sign; null for pictures of another program that are made for a
    /// display.
    pub bias: Option<f64>,
    /// Root mean square error in linear light; null likewise.
    pub rms: Option<f64>,
    /// Fragments shaded for a pixel of a frame.
    pub shaded_per_pixel: Option<f64>,
    /// Hits tested or composited for a pixel of a frame.
    pub hits_per_pixel: Option<f64>,
    /// What the method stores beyond colour and depth: by its paper on the CPU (of an unbounded one, bytes a
    /// fragment times the mean of hits for a pixel), what was allocated on a GPU.
    pub memory_bytes_per_pixel: Option<f64>,
    /// Fragments merged for want of a place, for a pixel of a frame.
    pub merged_per_pixel: Option<f64>,
}

impl ComparisonRow {
    /// What programs read of a method; nothing if it was not held against the reference.
    #[must_use]
    pub fn new(measured: &Measured, reference: Reference) -> Option<Self> {
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
    #[must_use]
    pub fn of_foreign(foreign: &ForeignJudged, pattern: &str, reference: Reference) -> Option<Self> {
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
