//! Frames one after the other: clock, method, accumulation.

use std::time::Instant;

use sheer_image::{ImageError, Planes};
use sheer_scene::SceneError;

use crate::{
    cpu::{self, Background, Counters, FrameSettings, StepTime},
    method::Method,
    shadow::Shadow,
    stage::Stage,
    temporal::{Antialiasing, History, jitter},
};

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The scene cannot be seen as asked.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The picture cannot be made.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The operating system gives no threads.
    #[error("cannot start the rendering threads: {0}; try fewer with --threads")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The shadow maps are too large.
    #[error(
        "the shadow maps of {lights} lights would take {mebibytes} MiB; give --shadow a lower resolution= or less of what it keeps of a texel"
    )]
    ShadowMaps {
        /// How many lights there are.
        lights: usize,
        /// What their maps would take at least.
        mebibytes: usize,
    },
}

/// What all frames of a run have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Seed of the dithering.
    pub seed: u32,
    /// What lies behind everything.
    pub background: Background,
    /// How light is shadowed.
    pub shadow: Shadow,
    /// Time of the first frame, seconds.
    pub start_secs: f32,
    /// Index of the first frame.
    pub first_frame: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: [960, 540],
            seed: 0,
            background: Background::Environment,
            shadow: Shadow::default(),
            start_secs: 0.0,
            first_frame: 0,
        }
    }
}

/// Frames a second of an animated run.
const FRAMES_PER_SEC: f32 = 30.0;

/// Maps frame indices to time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    start_secs: f32,
    first_frame: u32,
    stands: bool,
}

/// A point in time and the one its motion vectors point to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Seconds.
    pub time_secs: f32,
    /// Seconds, of the frame before.
    pub previous_secs: f32,
}

impl Clock {
    /// The clock of a run: it stands still for plain accumulation, which adds up one moment.
    #[must_use]
    pub fn new(settings: &Settings, antialiasing: Antialiasing) -> Self {
        Self {
            start_secs: settings.start_secs,
            first_frame: settings.first_frame,
            stands: antialiasing == Antialiasing::Accumulate,
        }
    }

    /// The moment of frame `index`, counted from the run's first. A single frame counts as moving if the run's frames do.
    #[must_use]
    pub fn at(&self, index: u32) -> Moment {
        let time_of = |index: u32| self.start_secs + index as f32 / FRAMES_PER_SEC;
        if self.stands {
            let time_secs = time_of(self.first_frame);
            return Moment { time_secs, previous_secs: time_secs };
        }
        let index = self.first_frame + index;
        Moment { time_secs: time_of(index), previous_secs: time_of(index.saturating_sub(1)) }
    }
}

/// What a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timings {
    /// Animation and acceleration structure, milliseconds.
    pub build_ms: f64,
    /// Tracing and shading, shadow maps included.
    pub trace_ms: f64,
    /// Making shadow maps, a part of `trace_ms`.
    pub shadow_ms: f64,
    /// Adding up over time, which frame times leave out (STD section 4).
    pub resolve_ms: f64,
}

impl Timings {
    /// The whole pass including acceleration structure builds, without temporal anti-aliasing (STD section 4).
    #[must_use]
    pub fn frame_ms(&self) -> f64 {
        self.build_ms + self.trace_ms
    }
}

/// A method and its accumulated history.
#[derive(Clone, Debug)]
pub struct Pipeline {
    method: Method,
    settings: Settings,
    history: History,
    steps: Vec<StepTime>,
}

impl Pipeline {
    /// Nothing rendered yet.
    ///
    /// # Errors
    /// [`RenderError::Image`] if the size is zero or too much for the memory.
    pub fn new(method: Method, antialiasing: Antialiasing, settings: Settings) -> Result<Self, RenderError> {
        let history = History::new(antialiasing, settings.size)?;
        Ok(Self { method, settings, history, steps: Vec::new() })
    }

    /// The clock to advance the stage by.
    #[must_use]
    pub fn clock(&self) -> Clock {
        Clock::new(&self.settings, self.history.antialiasing())
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> &Method {
        &self.method
    }

    /// Renders frame `index`, counted from the run's first, of a stage that has been advanced to it, and adds it to the history.
    ///
    /// # Errors
    /// [`RenderError::Image`] if the size is zero or too much for the memory.
    pub fn render(&mut self, stage: &Stage, index: u32) -> Result<(Counters, Timings), RenderError> {
        let frame = self.settings.first_frame + index;
        let jitter = jitter(self.history.antialiasing(), frame);
        let Settings { size, seed, background, shadow, .. } = self.settings;
        let settings = FrameSettings { size, frame, seed, jitter, background, shadow };
        let rendered = cpu::render(stage, &self.method, &settings)?;
        self.steps = rendered.steps;
        let start = Instant::now();
        stage.pool().install(|| self.history.add(rendered.planes, self.method.alignment_px(), &settings))?;
        let timings = Timings {
            build_ms: stage.build_ms(),
            trace_ms: rendered.trace_ms,
            shadow_ms: rendered.shadow_ms,
            resolve_ms: start.elapsed().as_secs_f64() * 1e3,
        };
        Ok((rendered.counters, timings))
    }

    /// Where the time of the last frame went, for compositing methods with an unordered gathering.
    #[must_use]
    pub fn steps(&self) -> &[StepTime] {
        &self.steps
    }

    /// The picture so far: colour accumulated, everything else of the last frame.
    #[must_use]
    pub fn planes(&self) -> &Planes {
        self.history.planes()
    }
}
