//! Pictures, and sequences of them.

use pyo3::{exceptions::PyValueError, prelude::*};
use sheer_image::{Metadata, Planes};
use sheer_lab::{Exposure, LabError};
use sheer_render::{
    Antialiasing, Clock, Method, Pipeline, Settings, Stage,
    backend::{Backend as _, Cpu},
    limits::{MOST_FRAMES, MOST_SAMPLES},
    temporal::jitter,
};

use crate::{
    camera::camera_choice,
    error::{Raise as _, check_signals, unlocked},
    picture::{Origin, PyPicture},
    run::{Keywords, antialiasing, check, check_run, method},
    scene::PyScene,
};

/// Renders a picture on the processor.
///
/// scene: a Scene, or what `open` takes.
/// method: how transparency is resolved, as in "std" or "std:hybrid=0.5"; `methods()` lists the names.
/// aa: "none" (one sample through each pixel centre, of the first frame), "accumulate" (the mean of the
/// frames of one moment), "taa" or "layered" (frames play and add up; the picture is the last of them).
/// size: width and height, pixels; (960, 540) if not given.
/// frames: how many are rendered for the picture.
/// samples: the mean of so many samples a pixel of the first frame's own moment instead, in place of aa and
/// frames; shutter: the share of the time between frames that it is exposed, 0 to 1.
/// raw: the first frame as it is rendered, jittered as aa wants it and not added up; `info` has the jitter.
/// first_frame, time, fps: the index of the first frame, the time of frame 0 in seconds, frames a second.
/// camera: the name of one of the scene's cameras, "orbit", a Camera, or None for the scene's first.
/// background: "env" (the scene's surroundings), "none" (transparent) or an sRGB colour "#rrggbb".
/// shadow: the shadow technique, "deep" if not given. tone, exposure: curve ("pbr-neutral" if not given) and
/// stops of what a display shows; linear light does not depend on them.
/// seed: of the dithering: the same seed makes the same picture.
/// threads: how many to use, all processors if not given; the picture is the same.
///
/// Other threads of Python run meanwhile. KeyboardInterrupt ends it after the sample that is being rendered.
/// Raises ValueError for what cannot be, SheerError for what goes wrong.
#[pyfunction]
#[pyo3(signature = (scene, method="joint", *, aa="layered", size=None, frames=32, samples=None, shutter=0.0, raw=false, first_frame=0, time=0.0, fps=30.0, camera=None, background="env", shadow=None, tone=None, exposure=0.0, seed=0, threads=None))]
#[expect(clippy::too_many_arguments, reason = "they are keywords to whoever calls this")]
pub(crate) fn render(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    method: &str,
    aa: &str,
    size: Option<(u32, u32)>,
    frames: u32,
    samples: Option<u32>,
    shutter: f32,
    raw: bool,
    first_frame: u32,
    time: f32,
    fps: f32,
    camera: Option<&Bound<'_, PyAny>>,
    background: &str,
    shadow: Option<&str>,
    tone: Option<&str>,
    exposure: f32,
    seed: u32,
    threads: Option<usize>,
) -> PyResult<PyPicture> {
    let size = size.unwrap_or(Settings::default().size.into());
    let keywords = Keywords { size, first_frame, time, fps, background, shadow, tone, exposure, seed };
    let settings = Settings { raw, ..keywords.settings()? };
    check_run(frames, threads)?;
    let plan = Plan::new(method, aa, settings, exposed(samples, shutter, raw)?)?;
    // A frame that is not added up owes nothing to the ones before it.
    let count = if plan.is_added_up() { frames } else { 1 };
    let scene = PyScene::of_any(scene)?;
    let (planes, origin) = unlocked_player(py, &scene, camera, plan, threads, |mut player| {
        for _ in 0..count {
            player.step()?;
        }
        let origin = player.origin()?;
        Ok((player.pipeline.into_planes(), origin))
    })?;
    PyPicture::new(py, planes, origin)
}

/// Renders a clip: an iterator of pictures, one a frame, each rendered when it is asked for.
///
/// Keywords are those of `render`, but for
/// frames: how many pictures.
/// samples: each picture is the mean of so many samples of its own moment, in place of aa.
/// warm_up: under "taa" and "layered", frames that are rendered before the first one and not handed out, so
/// that a part of a clip fits to the part before; what they need if not given, none before frame 0.
#[pyfunction]
#[pyo3(signature = (scene, method="joint", *, aa="layered", size=None, frames=32, samples=None, shutter=0.0, raw=false, warm_up=None, first_frame=0, time=0.0, fps=30.0, camera=None, background="env", shadow=None, tone=None, exposure=0.0, seed=0, threads=None))]
#[expect(clippy::too_many_arguments, reason = "they are keywords to whoever calls this")]
pub(crate) fn sequence(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    method: &str,
    aa: &str,
    size: Option<(u32, u32)>,
    frames: u32,
    samples: Option<u32>,
    shutter: f32,
    raw: bool,
    warm_up: Option<u32>,
    first_frame: u32,
    time: f32,
    fps: f32,
    camera: Option<&Bound<'_, PyAny>>,
    background: &str,
    shadow: Option<&str>,
    tone: Option<&str>,
    exposure: f32,
    seed: u32,
    threads: Option<usize>,
) -> PyResult<PySequence> {
    let size = size.unwrap_or(Settings::default().size.into());
    let keywords = Keywords { size, first_frame, time, fps, background, shadow, tone, exposure, seed };
    let settings = Settings { raw, ..keywords.settings()? };
    check_run(frames, threads)?;
    let plan = Plan::new(method, aa, settings, exposed(samples, shutter, raw)?)?;
    check(
        warm_up.is_none_or(|warm_up| warm_up <= MOST_FRAMES),
        "warm_up",
        warm_up.unwrap_or(0),
        format!("a number up to {MOST_FRAMES}"),
    )?;
    let before = match warm_up {
        _ if !plan.is_added_up() || plan.antialiasing.info().time_stands_still => 0,
        warm_up => warm_up.unwrap_or(plan.antialiasing.info().warm_up_frames).min(first_frame),
    };
    let plan = Plan { settings: Settings { first_frame: first_frame - before, ..plan.settings }, ..plan };
    let scene = PyScene::of_any(scene)?;
    let player = unlocked_player(py, &scene, camera, plan, threads, Ok)?;
    Ok(PySequence { player, hidden: before, left: frames })
}

/// A clip that is rendered frame by frame: an iterator of pictures.
#[pyclass(name = "Sequence", module = "sheer")]
pub(crate) struct PySequence {
    player: Player,
    /// Frames that are rendered before the next one and not handed out.
    hidden: u32,
    /// Pictures that are still to come.
    left: u32,
}

#[pymethods]
impl PySequence {
    fn __iter__(this: Py<Self>) -> Py<Self> {
        this
    }

    fn __len__(&self) -> usize {
        self.left as usize
    }

    fn __next__(&mut self, py: Python<'_>) -> PyResult<Option<PyPicture>> {
        if self.left == 0 {
            return Ok(None);
        }
        let Self { player, hidden, .. } = self;
        let (planes, origin) = unlocked(py, || {
            let mut frame = || -> sheer_lab::Result<(Planes, Origin)> {
                while *hidden > 0 {
                    player.step()?;
                    *hidden -= 1;
                }
                player.step()?;
                Ok((player.pipeline.planes().clone(), player.origin()?))
            };
            frame().map_err(|error| error.raise())
        })?;
        self.left -= 1;
        PyPicture::new(py, planes, origin).map(Some)
    }
}

/// What is to be rendered.
struct Plan {
    method: Method,
    antialiasing: Antialiasing,
    settings: Settings,
    exposure: Option<Exposure>,
}

/// How frames are exposed, if they are.
fn exposed(samples: Option<u32>, shutter: f32, raw: bool) -> PyResult<Option<Exposure>> {
    let Some(samples) = samples else {
        check(shutter == 0.0, "shutter", shutter, "samples as well, which are spread over it".to_owned())?;
        return Ok(None);
    };
    check(
        (1..=MOST_SAMPLES).contains(&samples),
        "samples",
        samples,
        format!("a number from 1 to {MOST_SAMPLES}"),
    )?;
    check(
        (0.0..=1.0).contains(&shutter),
        "shutter",
        shutter,
        "a share of the time between frames from 0 to 1".to_owned(),
    )?;
    if raw {
        return Err(PyValueError::new_err("raw is one sample as it is rendered: leave samples out"));
    }
    Ok(Some(Exposure { samples, shutter, part: None }))
}

impl Plan {
    fn new(name: &str, aa: &str, settings: Settings, exposure: Option<Exposure>) -> PyResult<Self> {
        let antialiasing = antialiasing(aa)?;
        let antialiasing = if exposure.is_some() { Antialiasing::ACCUMULATE } else { antialiasing };
        Ok(Self { method: method(name)?, antialiasing, settings, exposure })
    }

    fn is_added_up(&self) -> bool {
        self.exposure.is_none() && self.antialiasing != Antialiasing::NONE && !self.settings.raw
    }
}

/// A stage and a pipeline at a frame.
struct Player {
    plan: Plan,
    stage: Stage,
    pipeline: Pipeline,
    /// How many frames have been rendered.
    count: u32,
    /// What all frames have in common.
    metadata: Metadata,
}

/// Prepares a run and does something with it, while other threads of Python run.
fn unlocked_player<T: Send>(
    py: Python<'_>,
    scene: &PyScene,
    camera: Option<&Bound<'_, PyAny>>,
    plan: Plan,
    threads: Option<usize>,
    task: impl FnOnce(Player) -> sheer_lab::Result<T> + Send,
) -> PyResult<T> {
    let framed = scene.framed_for(plan.settings.size);
    let choice = camera_choice(camera, &framed)?;
    let Settings { background, shadow, frames_per_sec, seed, .. } = plan.settings;
    let mut metadata = Metadata::default()
        .with("scene", scene.text())
        .with("method", &plan.method)
        .with("aa", plan.antialiasing)
        .with("shadow", shadow)
        .with("background", background)
        .with("fps", frames_per_sec)
        .with("seed", seed)
        .with("backend", Cpu.name())
        .with("version", env!("CARGO_PKG_VERSION"));
    if let Some(Exposure { samples, shutter, .. }) = plan.exposure {
        metadata = metadata.with("samples", samples).with("shutter", shutter);
    }
    unlocked(py, || {
        let stage = Stage::new(framed, &choice, threads).map_err(|error| error.raise())?;
        let settings = plan.exposure.map_or(plan.settings, |exposure| exposure.settings(plan.settings));
        let pipeline = Pipeline::new(plan.method.clone(), plan.antialiasing, settings);
        let pipeline = pipeline.map_err(|error| error.raise())?;
        let player = Player { plan, stage, pipeline, count: 0, metadata };
        task(player).map_err(|error| error.raise())
    })
}

impl Player {
    /// Renders the next frame.
    fn step(&mut self) -> sheer_lab::Result<()> {
        let Self { plan, stage, pipeline, count, .. } = self;
        match plan.exposure {
            Some(exposure) => {
                let frame = plan.settings.first_frame + *count;
                exposure.render(&Cpu, stage, pipeline, &plan.settings, frame, |_| check_signals())?;
            }
            None => {
                stage.advance(pipeline.clock().at(*count));
                pipeline.render(stage, *count)?;
                check_signals()?;
            }
        }
        *count += 1;
        Ok(())
    }

    /// What the picture of the last frame has beside its planes.
    fn origin(&self) -> sheer_lab::Result<Origin> {
        let Plan { antialiasing, settings, exposure, .. } = &self.plan;
        let share = Cpu.display_share(&self.stage, settings, *antialiasing).map_err(LabError::from)?;
        let frame = settings.first_frame + self.count - 1;
        let stands = exposure.is_none() && antialiasing.info().time_stands_still;
        let shown = if stands { settings.first_frame } else { frame };
        let clock = Clock::new(&Settings { first_frame: shown, ..*settings }, Antialiasing::NONE);
        let mut metadata =
            self.metadata.clone().with("frame", frame).with("time_secs", clock.at(0).time_secs);
        if settings.raw {
            let offset = jitter(*antialiasing, frame);
            metadata = metadata.with("jitter.X", offset.x).with("jitter.Y", offset.y);
        }
        Ok(Origin { share, tone: settings.tone, metadata })
    }
}
