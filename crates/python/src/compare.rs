//! Methods held against the exact answer.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
    types::PyString,
};
use sheer_lab::{Clip, ComparisonRow, Progress, Reference, Truth, with_reference};
use sheer_metrics::LEAST_VDP_SIDE_PX;
use sheer_render::{Stage, backend::Cpu};

use crate::{
    camera::camera_choice,
    error::{Raise as _, SheerError, check_signals, unlocked},
    run::{Keywords, antialiasing, check_run, method},
    scene::{PyScene, warn},
};

/// Width and height if nothing is said: those of `sheer compare`, to which a test holds it.
const SIZE: (u32, u32) = (400, 225);

/// Plays a clip with several methods and holds each against the exact answer: what `sheer compare` does.
///
/// scene: a Scene, or what `open` takes.
/// methods: one name or several, as in "std:hybrid=0.5"; "baseline" always takes part as the reference.
/// aa: one or several of "none", "accumulate", "taa" and "layered".
/// reference: "same" (baseline under the same anti-aliasing), "truth" (baseline with many samples a pixel at
/// the moment of each frame, "truth:samples=N") or both.
/// size: width and height, pixels; (400, 225) if not given.
/// vdp: judge clips with ColorVideoVDP as well.
/// Other keywords are those of `render`.
///
/// Returns a dict for each method under each anti-aliasing against each reference, with the names of
/// `report.json`: method, aa, reference, ms_median, ms_min, ms_max, ssim, psnr_db, tpsnr_db, vdp_jod (where
/// it was asked for), flip, flicker, ghosting (against the truth), bias, rms, shaded_per_pixel,
/// hits_per_pixel, memory_bytes_per_pixel, merged_per_pixel. psnr_db and tpsnr_db are None where nothing
/// differs. Figures are means over the last half of the frames, against the truth over the last quarter.
/// SSIM, PSNR and FLIP are of what a display shows, rms and bias of linear light.
///
/// Other threads of Python run meanwhile. KeyboardInterrupt ends it after the frame that is being rendered.
#[pyfunction]
#[pyo3(signature = (scene, methods, *, aa=None, reference=None, size=None, frames=32, vdp=false, first_frame=0, time=0.0, fps=30.0, camera=None, background="env", shadow=None, tone=None, exposure=0.0, seed=0, threads=None))]
#[expect(clippy::too_many_arguments, reason = "they are keywords to whoever calls this")]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyAny>,
    methods: &Bound<'py, PyAny>,
    aa: Option<&Bound<'py, PyAny>>,
    reference: Option<&Bound<'py, PyAny>>,
    size: Option<(u32, u32)>,
    frames: u32,
    vdp: bool,
    first_frame: u32,
    time: f32,
    fps: f32,
    camera: Option<&Bound<'py, PyAny>>,
    background: &str,
    shadow: Option<&str>,
    tone: Option<&str>,
    exposure: f32,
    seed: u32,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let size = size.unwrap_or(SIZE);
    let keywords = Keywords { size, first_frame, time, fps, background, shadow, tone, exposure, seed };
    let settings = keywords.settings()?;
    check_run(frames, threads)?;
    if vdp && settings.size.into_iter().any(|side| side < LEAST_VDP_SIDE_PX) {
        let problem =
            format!("vdp judges pictures from {LEAST_VDP_SIDE_PX} pixels a side up; give a larger size");
        return Err(PyValueError::new_err(problem));
    }
    let texts = |given: Option<&Bound<'py, PyAny>>, default: &str, what: &str| match given {
        Some(given) => texts(given, what),
        None => Ok(vec![default.to_owned()]),
    };
    let methods = texts(Some(methods), "", "methods")?;
    let methods = methods.iter().map(|text| method(text)).collect::<PyResult<Vec<_>>>()?;
    let methods = with_reference(without_repeats(methods)).map_err(|error| error.raise())?;
    let antialiasings = texts(aa, "layered", "aa")?;
    let antialiasings = antialiasings.iter().map(|text| antialiasing(text)).collect::<PyResult<Vec<_>>>()?;
    let references = texts(reference, "same", "reference")?;
    let references = references.iter().map(|text| text.parse()).collect::<Result<Vec<Reference>, _>>();
    let references = without_repeats(references.map_err(|error| error.raise())?);
    let truth = Truth::among(&references, settings).map_err(|error| error.raise())?;
    let scene = PyScene::of_any(scene)?.framed_for(settings.size);
    let choice = camera_choice(camera, &scene)?;

    let watch = Watch::default();
    let rows = unlocked(py, || {
        let mut truth = truth;
        let mut stage = Stage::new(Arc::clone(&scene), &choice, threads).map_err(|error| error.raise())?;
        let mut rows = Vec::new();
        for antialiasing in without_repeats(antialiasings) {
            let clip = Clip { settings, antialiasing, frame_count: frames, keeps_frames: vdp };
            let measured = clip.play(&Cpu, &mut stage, &methods, truth.as_mut(), &watch);
            for measured in measured.map_err(|error| error.raise())? {
                rows.extend(
                    references.iter().filter_map(|&reference| ComparisonRow::new(&measured, reference)),
                );
            }
        }
        serde_json::to_string(&rows).map_err(|error| SheerError::new_err(error.to_string()))
    })?;
    for warning in watch.0.into_inner().unwrap_or_else(PoisonError::into_inner) {
        warn(py, &warning)?;
    }
    // The text of the reports, read by Python: names and types cannot differ.
    py.import("json")?.call_method1("loads", (rows,))
}

/// Gathers warnings, and looks whether somebody has pressed the keys that interrupt.
#[derive(Default)]
struct Watch(Mutex<Vec<String>>);

impl Progress for Watch {
    fn expect(&self, _: u64) {}
    fn name(&self, _: &str) {}
    fn step(&self) {}
    fn note(&self, _: &str) {}

    fn go_on(&self) -> sheer_lab::Result<()> {
        check_signals()
    }

    fn warn(&self, text: &str) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_owned());
    }
}

/// One text or several.
fn texts(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<String>> {
    if let Ok(text) = given.cast::<PyString>() {
        return Ok(vec![text.to_string()]);
    }
    let texts: Vec<String> = given
        .extract()
        .map_err(|_| PyTypeError::new_err(format!("{what}: give a name or a list of names")))?;
    if texts.is_empty() {
        return Err(PyValueError::new_err(format!("{what}: give one name at least")));
    }
    Ok(texts)
}

/// Each thing once, in the order in which they came first.
fn without_repeats<T: PartialEq>(things: Vec<T>) -> Vec<T> {
    let mut once: Vec<T> = Vec::new();
    for thing in things {
        if !once.contains(&thing) {
            once.push(thing);
        }
    }
    once
}
