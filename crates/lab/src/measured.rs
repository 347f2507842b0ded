//! What came of a method in a clip, and its figures as a table.

use sheer_image::Image;
use sheer_render::{Antialiasing, Method};

use crate::{
    Reference, Seeded,
    figures::{Column, Figures, Name},
};

/// How a method does against the truth ([`Truth`](crate::Truth)): means over the last quarter of the frames.
#[derive(Clone, Debug)]
pub struct AgainstTruth {
    /// Structural similarity of the displayed picture; 1: equal.
    pub ssim: f64,
    /// Peak signal-to-noise ratio of the displayed picture, decibels; none where it equals the truth.
    pub psnr_db: Option<f64>,
    /// Of the differences of successive displayed frames; none where they equal those of the truth, or for
    /// one frame.
    pub tpsnr_db: Option<f64>,
    /// ColorVideoVDP of the displayed clip in just-objectionable differences, 10: no visible one; where
    /// frames were kept.
    pub vdp_jod: Option<f64>,
    /// FLIP of the displayed picture; 0: equal.
    pub flip: f64,
    /// Standard deviation of the displayed error over time.
    pub flicker: f64,
    /// Mean error in linear light, with its sign, in the pixels that were uncovered during the last 8 frames;
    /// none where there are none.
    pub ghosting: Option<f64>,
    /// Mean error in linear light, with its sign.
    pub bias: f64,
    /// Root mean square error in linear light.
    pub rms: f64,
    /// Where the error of the last frame is, as in [`Measured::error_map`].
    pub error_map: Image<[u8; 4]>,
}

impl AgainstTruth {
    /// The means of runs that differ in their seeds alone; the error map is that of the first.
    fn mean(runs: &[&Self]) -> Self {
        let mean =
            |of: &dyn Fn(&Self) -> f64| runs.iter().map(|run| of(run)).sum::<f64>() / runs.len() as f64;
        let mean_of_some = |of: &dyn Fn(&Self) -> Option<f64>| {
            runs.iter().map(|run| of(run)).sum::<Option<f64>>().map(|sum| sum / runs.len() as f64)
        };
        Self {
            ssim: mean(&|run| run.ssim),
            psnr_db: mean_of_some(&|run| run.psnr_db),
            tpsnr_db: mean_of_some(&|run| run.tpsnr_db),
            vdp_jod: mean_of_some(&|run| run.vdp_jod),
            flip: mean(&|run| run.flip),
            flicker: mean(&|run| run.flicker),
            ghosting: mean_of_some(&|run| run.ghosting),
            bias: mean(&|run| run.bias),
            rms: mean(&|run| run.rms),
            error_map: runs[0].error_map.clone(),
        }
    }
}

/// What came of a method in a clip. Qualities are against the reference under the same anti-aliasing, means
/// over the last half of the frames, when the history has settled.
#[derive(Clone, Debug)]
pub struct Measured {
    /// With all its parameters.
    pub method: Method,
    /// How frames were added up.
    pub antialiasing: Antialiasing,
    /// Milliseconds of each frame with acceleration structure builds, without temporal anti-aliasing.
    pub frame_ms: Vec<f64>,
    /// Median of `frame_ms`.
    pub ms_median: f64,
    /// Least of `frame_ms`.
    pub ms_min: f64,
    /// Most of `frame_ms`.
    pub ms_max: f64,
    /// Structural similarity of the displayed picture; 1: equal.
    pub ssim: f64,
    /// Peak signal-to-noise ratio of the displayed picture, decibels; none where it equals the reference.
    pub psnr_db: Option<f64>,
    /// Of the differences of successive displayed frames; none where they equal those of the reference, or
    /// for one frame.
    pub tpsnr_db: Option<f64>,
    /// ColorVideoVDP of the displayed clip in just-objectionable differences, 10: no visible one; where
    /// frames were kept.
    pub vdp_jod: Option<f64>,
    /// FLIP of the displayed picture; 0: equal.
    pub flip: f64,
    /// Standard deviation of the displayed error over time.
    pub flicker: f64,
    /// Mean error in linear light, with its sign.
    pub bias: f64,
    /// Root mean square error in linear light.
    pub rms: f64,
    /// Against the truth, where it is asked for.
    pub against_truth: Option<AgainstTruth>,
    /// Fragments shaded for a pixel of a frame.
    pub shaded_per_pixel: f64,
    /// Hits tested or composited for a pixel of a frame.
    pub hits_per_pixel: f64,
    /// What the method stores beyond colour and depth: by its paper on the CPU, what was allocated on a GPU.
    pub memory_bytes_per_pixel: f64,
    /// Fragments merged for want of a place, for a pixel of a frame.
    pub merged_per_pixel: f64,
    /// The last frame as a display shows it: sRGB, straight alpha.
    pub picture: Image<[u8; 4]>,
    /// Where its error is, in false colours up to [`ERROR_FULL_SCALE`](crate::ERROR_FULL_SCALE); the
    /// reference has none.
    pub error_map: Option<Image<[u8; 4]>>,
}

impl Measured {
    /// The means of runs that differ in their seeds alone; method, frame times and pictures are those of the
    /// first.
    ///
    /// # Panics
    /// Without a run.
    pub(crate) fn mean(runs: &[Self]) -> Self {
        let mean = |of: &dyn Fn(&Self) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
        // What has no figure in one run, as it equals the reference, has none on average.
        let mean_of_some = |of: &dyn Fn(&Self) -> Option<f64>| {
            runs.iter().map(of).sum::<Option<f64>>().map(|sum| sum / runs.len() as f64)
        };
        let against_truth: Option<Vec<&AgainstTruth>> =
            runs.iter().map(|run| run.against_truth.as_ref()).collect();
        let first = runs.first().expect("a mean is of one run at least");
        // Every field is named, so that a new one cannot be forgotten.
        Self {
            method: first.method.clone(),
            antialiasing: first.antialiasing,
            frame_ms: first.frame_ms.clone(),
            ms_median: mean(&|run| run.ms_median),
            ms_min: mean(&|run| run.ms_min),
            ms_max: mean(&|run| run.ms_max),
            ssim: mean(&|run| run.ssim),
            psnr_db: mean_of_some(&|run| run.psnr_db),
            tpsnr_db: mean_of_some(&|run| run.tpsnr_db),
            vdp_jod: mean_of_some(&|run| run.vdp_jod),
            flip: mean(&|run| run.flip),
            flicker: mean(&|run| run.flicker),
            bias: mean(&|run| run.bias),
            rms: mean(&|run| run.rms),
            against_truth: against_truth.map(|runs| AgainstTruth::mean(&runs)),
            shaded_per_pixel: mean(&|run| run.shaded_per_pixel),
            hits_per_pixel: mean(&|run| run.hits_per_pixel),
            memory_bytes_per_pixel: mean(&|run| run.memory_bytes_per_pixel),
            merged_per_pixel: mean(&|run| run.merged_per_pixel),
            picture: first.picture.clone(),
            error_map: first.error_map.clone(),
        }
    }
}

/// What frames cost.
const TIMES: &[Column<Measured>] = &[
    Column {
        title: "ms",
        meaning: "Median time of a frame in milliseconds: animation, acceleration structure, tracing and shading. Adding frames up over time is not counted.",
        decimals: 1,
        is_optional: false,
        is_time: true,
        value: |row| Some(row.ms_median),
    },
    Column {
        title: "min",
        meaning: "Time of the fastest frame, milliseconds.",
        decimals: 1,
        is_optional: false,
        is_time: true,
        value: |row| Some(row.ms_min),
    },
    Column {
        title: "max",
        meaning: "Time of the slowest frame, milliseconds.",
        decimals: 1,
        is_optional: false,
        is_time: true,
        value: |row| Some(row.ms_max),
    },
];

/// Against the reference under the same anti-aliasing.
const AGAINST_SAME: &[Column<Measured>] = &[
    Column {
        title: "SSIM",
        meaning: "Structural similarity to the exact picture as displayed. 1 is the same picture; above 0.98 few people see a difference.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.ssim),
    },
    Column {
        title: "PSNR dB",
        meaning: "Peak signal-to-noise ratio of the displayed picture in decibels: 6 more means half the error. A dash: no error at all.",
        decimals: 2,
        is_optional: false,
        is_time: false,
        value: |row| row.psnr_db,
    },
    Column {
        title: "tPSNR dB",
        meaning: "Peak signal-to-noise ratio of the change from one frame to the next in decibels: what shimmers lowers it, a steady error does not. A dash: no error at all, or a single frame.",
        decimals: 2,
        is_optional: false,
        is_time: false,
        value: |row| row.tpsnr_db,
    },
    Column {
        title: "VDP JOD",
        meaning: "ColorVideoVDP: quality of the clip to a viewer before a 30 inch 4K monitor in an office. 10 is no visible difference; at 9, three in four viewers prefer the exact one.",
        decimals: 3,
        is_optional: true,
        is_time: false,
        value: |row| row.vdp_jod,
    },
    Column {
        title: "FLIP",
        meaning: "Difference that an eye would notice when the two pictures alternate on a display. 0 is none, 1 the most.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.flip),
    },
    Column {
        title: "flicker",
        meaning: "How much the error changes from frame to frame: its standard deviation over time, display white being 1. A steady error does not flicker; nor does motion that the exact picture shares. Cleanest on a still clip.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.flicker),
    },
    Column {
        title: "RMS",
        meaning: "Root mean square error in linear light.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.rms),
    },
    Column {
        title: "bias",
        meaning: "Mean error in linear light with its sign, over all pixels and the last half of the frames: what remains when noise averages out. Above 0 is too bright. For a bias that is more than chance, take a still clip of 512 frames or more, whose last half has 256.",
        decimals: 5,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.bias),
    },
];

/// Against the truth.
const AGAINST_TRUTH: &[Column<Measured>] = &[
    Column {
        title: "truth SSIM",
        meaning: "Structural similarity to the truth: to the exact answer with many samples a pixel at the moment of the frame, without any history. 1 is the same picture.",
        decimals: 4,
        is_optional: true,
        is_time: false,
        value: |row| Some(of_truth(row)?.ssim),
    },
    Column {
        title: "truth PSNR dB",
        meaning: "Peak signal-to-noise ratio of the displayed picture against the truth, decibels. A dash: no error at all.",
        decimals: 2,
        is_optional: true,
        is_time: false,
        value: |row| of_truth(row)?.psnr_db,
    },
    Column {
        title: "truth tPSNR dB",
        meaning: "Peak signal-to-noise ratio of the change from one frame to the next against that of the truth, decibels: what shimmers lowers it, and what lags behind. A dash: no error at all, or a single frame.",
        decimals: 2,
        is_optional: true,
        is_time: false,
        value: |row| of_truth(row)?.tpsnr_db,
    },
    Column {
        title: "truth VDP JOD",
        meaning: "ColorVideoVDP of the clip against the truth's. 10 is no visible difference.",
        decimals: 3,
        is_optional: true,
        is_time: false,
        value: |row| of_truth(row)?.vdp_jod,
    },
    Column {
        title: "truth FLIP",
        meaning: "Difference to the truth that an eye would notice. 0 is none, 1 the most.",
        decimals: 4,
        is_optional: true,
        is_time: false,
        value: |row| Some(of_truth(row)?.flip),
    },
    Column {
        title: "truth flicker",
        meaning: "How much the error against the truth changes from frame to frame: its standard deviation over time, display white being 1.",
        decimals: 4,
        is_optional: true,
        is_time: false,
        value: |row| Some(of_truth(row)?.flicker),
    },
    Column {
        title: "ghosting",
        meaning: "Mean error against the truth in linear light, with its sign, in the pixels whose surface was hidden behind a nearer one in the last 8 frames: what is left there of what has gone. 0 is none; above 0 ghosts are too bright. A dash: nothing was uncovered.",
        decimals: 5,
        is_optional: true,
        is_time: false,
        value: |row| of_truth(row)?.ghosting,
    },
    Column {
        title: "truth RMS",
        meaning: "Root mean square error against the truth in linear light.",
        decimals: 4,
        is_optional: true,
        is_time: false,
        value: |row| Some(of_truth(row)?.rms),
    },
    Column {
        title: "truth bias",
        meaning: "Mean error against the truth in linear light with its sign, over all pixels and the frames that are judged.",
        decimals: 5,
        is_optional: true,
        is_time: false,
        value: |row| Some(of_truth(row)?.bias),
    },
];

fn of_truth(row: &Measured) -> Option<&AgainstTruth> {
    row.against_truth.as_ref()
}

/// Why frames cost what they do.
const COSTS: &[Column<Measured>] = &[
    Column {
        title: "shaded/px",
        meaning: "Fragments shaded for a pixel of a frame. Shading is what costs; one-fragment methods stay at 1 or below, since sky is not shaded.",
        decimals: 2,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.shaded_per_pixel),
    },
    Column {
        title: "hits/px",
        meaning: "Surfaces that the rays of a pixel met and tested or blended.",
        decimals: 2,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.hits_per_pixel),
    },
    Column {
        title: "bytes/px",
        meaning: "What the method stores for a pixel beyond colour and depth. On the CPU, what its paper asks of a GPU, a list without bound with the mean of its fragments; on a GPU, what was allocated.",
        decimals: 0,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.memory_bytes_per_pixel),
    },
    Column {
        title: "merged/px",
        meaning: "Fragments of a pixel that found no place of their own in bounded memory and were merged with others. 0 where nothing overflowed.",
        decimals: 2,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.merged_per_pixel),
    },
];

/// What a row is.
const NAMES: [Name<Measured>; 2] =
    [("method", |row| row.method.to_string()), ("aa", |row| row.antialiasing.to_string())];

/// All figures, in the order in which they are shown: of the qualities those against these references.
fn columns(references: &[Reference]) -> impl Iterator<Item = &'static Column<Measured>> {
    let shows_same = references.contains(&Reference::Same);
    let shows_truth = references.iter().any(|reference| matches!(reference, Reference::Truth { .. }));
    let of_same = if shows_same { AGAINST_SAME } else { &[] };
    let of_truth = if shows_truth { AGAINST_TRUTH } else { &[] };
    TIMES.iter().chain(of_same).chain(of_truth).chain(COSTS)
}

/// The table, with the qualities against these references; the anti-aliasing is named where it is asked for.
/// Of several seeds it has means with their intervals.
#[must_use]
pub fn figures<'r>(
    rows: impl IntoIterator<Item = &'r Seeded<Measured>>,
    names_aa: bool,
    references: &[Reference],
) -> Figures {
    Figures::over_seeds(if names_aa { &NAMES } else { &NAMES[..1] }, columns(references), rows)
}

/// The method and the columns of these titles.
#[must_use]
pub fn selected_figures<'r>(rows: impl IntoIterator<Item = &'r Measured>, titles: &[&str]) -> Figures {
    let columns = [TIMES, AGAINST_SAME, AGAINST_TRUTH, COSTS].into_iter().flatten();
    let columns = columns.filter(|column| titles.contains(&column.title));
    Figures::new(&NAMES[..1], columns, rows)
}
