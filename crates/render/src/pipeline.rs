//! Frames one after the other: clock, method, accumulation.

use std::time::Instant;

use sheer_image::Planes;

use crate::{
    clock::Clock,
    cost::{Counters, StepTime, Timings},
    cpu::Transparency,
    error::RenderError,
    method::Method,
    settings::{FrameSettings, Settings},
    stage::Stage,
    temporal::{self, Antialiasing, History, jitter},
};

/// A method and its accumulated history. `M`: a [`Method`], or one of the caller's own.
#[derive(Clone, Debug)]
pub struct Pipeline<M = Method> {
    method: M,
    antialiasing: Antialiasing,
    settings: Settings,
    history: History,
    steps: Vec<StepTime>,
}

impl Pipeline {
    /// Renders with a method of the table; nothing rendered yet.
    ///
    /// # Errors
    /// [`RenderError::Image`] if the size is zero or too much for the memory, [`RenderError::Crop`] if the
    /// crop is not within it.
    pub fn new(method: Method, antialiasing: Antialiasing, settings: Settings) -> Result<Self, RenderError> {
        Self::with_own(method, antialiasing, settings)
    }
}

impl<M: Transparency> Pipeline<M> {
    /// Renders with a method of the caller's own, see [`Transparency`]; nothing rendered yet.
    ///
    /// # Errors
    /// [`RenderError::Image`] if the size is zero or too much for the memory, [`RenderError::Crop`] if the
    /// crop is not within it.
    pub fn with_own(method: M, antialiasing: Antialiasing, settings: Settings) -> Result<Self, RenderError> {
        let size = settings.size;
        if let Some(crop) = settings.crop.filter(|crop| !crop.is_within(size)) {
            return Err(RenderError::Crop { crop, size });
        }
        let (added_up, _) = temporal::of_run(&settings, antialiasing);
        let history = History::new(added_up, settings.region().size())?;
        Ok(Self { method, antialiasing, settings, history, steps: Vec::new() })
    }

    /// The clock to advance the stage by.
    #[must_use]
    pub fn clock(&self) -> Clock {
        Clock::new(&self.settings, self.antialiasing)
    }

    /// The method that frames are rendered with.
    #[must_use]
    pub fn method(&self) -> &M {
        &self.method
    }

    /// Renders frame `index`, counted from the run's first, of a stage that has been advanced to it, and adds
    /// it to the history.
    ///
    /// # Errors
    /// [`RenderError::Image`] if the size is zero or too much for the memory, [`RenderError::Crop`] if the
    /// crop is not within it.
    pub fn render(&mut self, stage: &Stage, index: u32) -> Result<(Counters, Timings), RenderError> {
        let frame = self.settings.first_frame + index;
        let jitter = jitter(self.antialiasing, frame);
        let (_, layers) = temporal::of_run(&self.settings, self.antialiasing);
        let settings =
            FrameSettings { run: self.settings, frame, jitter, layers, is_still: stage.frame().is_still() };
        let rendered = self.method.render(stage, &settings)?;
        self.steps = rendered.steps;
        let start = Instant::now();
        let (history, alignment) = (&mut self.history, self.method.alignment());
        stage.pool().install(|| history.add(rendered.planes, alignment, &settings))?;
        let timings = Timings {
            build_ms: stage.build_ms(),
            trace_ms: rendered.trace_ms,
            shadow_ms: rendered.shadow_ms,
            resolve_ms: start.elapsed().as_secs_f64() * 1e3,
        };
        Ok((rendered.counters, timings))
    }

    /// Forgets what has been added up: the next frame shows something else, after a cut or a jump of the
    /// camera.
    pub fn reset_history(&mut self) {
        self.history.reset();
    }

    /// Where the time of the last frame went, for compositing methods with an unordered gathering.
    #[must_use]
    pub fn steps(&self) -> &[StepTime] {
        &self.steps
    }

    /// The picture so far: colour accumulated, but for [`Settings::raw`], everything else of the last frame.
    #[must_use]
    pub fn planes(&self) -> &Planes {
        self.history.planes()
    }

    /// The same, given up: for whoever wants no copy.
    #[must_use]
    pub fn into_planes(self) -> Planes {
        self.history.into_planes()
    }
}
