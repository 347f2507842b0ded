//! Machine-readable reports. Names and types are the contract of `report.json` and of what `bench`, `verify`
//! and `devices` write with `--json`.

use serde::{Serialize, Serializer, ser::Error as _};
use serde_json::{Map, Value};
use sheer_core::parameter::Choice as _;
use sheer_image::Tone;
use sheer_lab::{ComparisonRow, Estimate, Judged, Seeded, Tally, verify::Check};
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
    /// How many seeds, from `seed` on, rows are means over; missing where it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) seeds: Option<u32>,
    /// Of this program.
    pub(crate) version: &'static str,
    /// Of this program, or `unknown`.
    pub(crate) commit: &'static str,
    /// How many rendered.
    pub(crate) threads: usize,
}

/// A row of what was measured with one seed or several.
///
/// With several, measured numbers are means over them; `seeds` says over how many, and `ci95` has, under the
/// same names, half of the 95 % confidence interval of each: 0 of what is the same with every seed, null of
/// what a single run was timed for, or of a mean that there is not. Lists are those of the first seed.
#[derive(Debug)]
pub(crate) struct Row<R>(pub(crate) Seeded<R>);

impl<R: Serialize> Serialize for Row<R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.averaged().map_err(S::Error::custom)?.serialize(serializer)
    }
}

/// A row as it is, or its means.
#[derive(Serialize)]
#[serde(untagged)]
enum Averaged<'a, R> {
    Once(&'a R),
    Mean(Map<String, Value>),
}

impl<R: Serialize> Row<R> {
    /// What names of times begin with, which even a run differs in that stands for all seeds.
    const TIME_PREFIX: &'static str = "ms_";

    fn averaged(&self) -> serde_json::Result<Averaged<'_, R>> {
        let Self(runs) = self;
        if runs.count() == 1 && !runs.is_once_for_all() {
            return Ok(Averaged::Once(runs.first()));
        }
        let fields = |run: &R| match serde_json::to_value(run) {
            Ok(Value::Object(fields)) => Ok(fields),
            Ok(other) => Err(serde_json::Error::custom(format_args!("a row is an object, not {other}"))),
            Err(error) => Err(error),
        };
        let fields = runs.try_map(fields)?;
        let mut means = fields.first().clone();
        let mut intervals = Map::new();
        for (name, mean) in &mut means {
            // Numbers of frames are no figures.
            if !fields.runs().any(|fields| fields.get(name).is_some_and(Value::is_f64)) {
                continue;
            }
            let figure = |fields: &Map<String, Value>| fields.get(name)?.as_f64();
            let estimate = fields.estimate(name.starts_with(Self::TIME_PREFIX), figure);
            let Estimate { mean: value, half_width } = estimate;
            *mean = value.into();
            intervals.insert(name.clone(), half_width.into());
        }
        means.insert("seeds".to_owned(), fields.count().into());
        means.insert("ci95".to_owned(), intervals.into());
        Ok(Averaged::Mean(means))
    }
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
    rows: Vec<Row<JudgedRow<'a>>>,
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
    pub(crate) fn new(reference: &'a str, size: [u32; 2], tone: &Tone, judged: &'a [Seeded<Judged>]) -> Self {
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
            rows: judged.iter().map(|judged| Row(judged.map(row))).collect(),
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
    pub(crate) rows: Vec<Row<ComparisonRow>>,
}

/// `sheer bench --json`.
#[derive(Debug, Serialize)]
pub(crate) struct Benchmark {
    #[serde(flatten)]
    pub(crate) run: Run,
    pub(crate) rows: Vec<Row<BenchmarkRow>>,
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
    /// What the frames of a method cost, beside those of the first one with the same seed.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Figures {
        name: &'static str,
        ms_median: f64,
        error: Option<f64>,
        frames: u32,
        ms: Vec<f64>,
    }

    fn figures(ms_median: f64, error: Option<f64>) -> Figures {
        Figures { name: "std", ms_median, error, frames: 4, ms: vec![ms_median] }
    }

    fn json(runs: Seeded<Figures>) -> String {
        serde_json::to_string(&Row(runs)).unwrap()
    }

    #[test]
    fn rows_of_one_seed_are_as_they_were() {
        let once = Seeded::of(vec![figures(2.0, Some(0.5))]).unwrap();
        assert_eq!(json(once), r#"{"name":"std","ms_median":2.0,"error":0.5,"frames":4,"ms":[2.0]}"#);
    }

    #[test]
    fn rows_of_several_seeds_have_means_and_intervals_under_the_same_names() {
        let value = |runs| serde_json::from_str::<Value>(&json(runs)).unwrap();
        let two = value(Seeded::of(vec![figures(2.0, Some(0.5)), figures(2.0, Some(1.5))]).unwrap());
        assert_eq!((&two["ms_median"], &two["error"]), (&2.0.into(), &1.0.into()));
        assert_eq!((&two["name"], &two["frames"], &two["seeds"]), (&"std".into(), &4.into(), &2.into()));
        assert_eq!((&two["ms"][0], &two["ci95"]["ms_median"]), (&2.0.into(), &0.0.into()));
        // Student's t of one degree of freedom times half the difference.
        let expected = (0.475 * std::f64::consts::PI).tan() * 0.5;
        assert!((two["ci95"]["error"].as_f64().unwrap() - expected).abs() < 1e-6, "{two}");
        assert!(two["ci95"].get("frames").is_none() && two["ci95"].get("ms").is_none(), "{two}");

        let missing = value(Seeded::of(vec![figures(2.0, None), figures(3.0, Some(1.5))]).unwrap());
        assert!(missing["error"].is_null() && missing["ci95"]["error"].is_null(), "{missing}");
        let once = value(Seeded::once_for_all(figures(2.0, Some(0.5))));
        assert_eq!((&once["seeds"], &once["ci95"]["error"]), (&1.into(), &0.0.into()));
        assert!(once["ci95"]["ms_median"].is_null() && once["ms_median"] == 2.0, "{once}");
    }
}
