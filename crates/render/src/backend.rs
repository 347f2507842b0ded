//! What renders: the processor here, a GPU in a crate of its own. Programs that measure, compare or write
//! pictures are written once, over [`Backend`].
//!
//! A backend makes stages and pipelines of its own kind and is handed them back for every step, so that a
//! stage of one device never meets the pipeline of another: the compiler sees to it. Alternatives were trait
//! objects, which would have to check that at run time, and a trait of the pipeline alone, which could not
//! say what a stage is.

use std::{borrow::Cow, env, error::Error, fs, sync::Arc};

use sheer_image::{DisplayShare, Planes};
use sheer_scene::{CameraChoice, CameraPose, Scene};

use crate::{
    contract::Memory,
    cost::{Counters, StepTime, Timings},
    cpu::display_share,
    error::RenderError,
    method::Method,
    pipeline::Pipeline,
    settings::Settings,
    stage::{Moment, Stage},
    temporal::Antialiasing,
};

/// A renderer with its stages and pipelines.
///
/// A frame is made in three steps: [`advance`](Self::advance) the stage, [`render`](Self::render) it, read
/// its [`planes`](Self::planes).
pub trait Backend {
    /// A scene at a time, ready to be rendered.
    type Stage;
    /// A method and its accumulated history.
    type Pipeline;
    /// Why there is no picture.
    type Error: Error + Send + Sync + 'static;

    /// The name by which it is asked for: `cpu`, `gpu`, `gpu:ray`, `gpu:raster`.
    fn name(&self) -> &'static str;

    /// What it runs on: the processor, or the GPU with its driver.
    fn adapter(&self) -> String;

    /// Prepares a scene at time zero. `threads`: how many to use, all the processor's by default.
    ///
    /// # Errors
    /// The scene has no such camera, is too large, or there are no threads.
    fn stage(
        &self,
        scene: Arc<Scene>,
        camera: &CameraChoice,
        threads: Option<usize>,
    ) -> Result<Self::Stage, Self::Error>;

    /// How many threads of the processor work for a stage.
    fn threads(&self, stage: &Self::Stage) -> usize;

    /// From the next [`advance`](Self::advance) on, the scene is seen from this pose, see
    /// [`Stage::look_from`].
    fn look_from(&self, stage: &mut Self::Stage, pose: CameraPose);

    /// Moves everything to a moment.
    ///
    /// # Errors
    /// What moves has outgrown its memory.
    fn advance(&self, stage: &mut Self::Stage, moment: Moment) -> Result<(), Self::Error>;

    /// Prepares a method; nothing is rendered yet.
    ///
    /// # Errors
    /// The backend does not run the method ([`is_unsupported`](Self::is_unsupported)), or the picture is too
    /// large.
    fn pipeline(
        &self,
        method: &Method,
        antialiasing: Antialiasing,
        settings: Settings,
    ) -> Result<Self::Pipeline, Self::Error>;

    /// Whether an error says that the backend does not run what was asked for, rather than that something
    /// went wrong.
    fn is_unsupported(&self, error: &Self::Error) -> bool;

    /// The method by which the CPU draws the same numbers: itself, but where the backend's samples come in
    /// rounds of its own.
    ///
    /// # Errors
    /// The backend does not run the method.
    fn twin(&self, method: &Method) -> Result<Method, Self::Error>;

    /// Renders frame `index`, counted from the run's first, of a stage that has been advanced to it, and adds
    /// it to the history.
    ///
    /// # Errors
    /// There is not enough memory, or the device is lost.
    fn render(
        &self,
        pipeline: &mut Self::Pipeline,
        stage: &mut Self::Stage,
        index: u32,
    ) -> Result<(Counters, Timings), Self::Error>;

    /// Forgets what has been added up, see [`Pipeline::reset_history`].
    fn reset_history(&self, pipeline: &mut Self::Pipeline);

    /// The picture so far: linear premultiplied colour accumulated, but for [`Settings::raw`], everything
    /// else of the last frame.
    ///
    /// # Errors
    /// The device is lost, or there is no memory to read it back to.
    fn planes<'p>(&self, pipeline: &'p Self::Pipeline) -> Result<Cow<'p, Planes>, Self::Error>;

    /// How much of what each pixel of a picture shows is display-referred, at the moment that the stage has
    /// been advanced to.
    ///
    /// # Errors
    /// There is not enough memory.
    fn display_share(
        &self,
        stage: &Self::Stage,
        settings: &Settings,
        antialiasing: Antialiasing,
    ) -> Result<DisplayShare, Self::Error>;

    /// Where the time of the last frame went, by [`step_clock`](Self::step_clock); empty where it is not
    /// known.
    fn steps<'p>(&self, pipeline: &'p Self::Pipeline) -> &'p [StepTime];

    /// What the times of [`steps`](Self::steps) count.
    fn step_clock(&self) -> StepClock;

    /// What the user should know of how a method is run.
    fn notes<'p>(&self, pipeline: &'p Self::Pipeline) -> &'p [String];

    /// Bytes a pixel that a method stores beyond colour and depth; `hits_per_pixel`: the mean number of its
    /// fragments.
    fn bytes_per_pixel(&self, pipeline: &Self::Pipeline, hits_per_pixel: f64) -> f64;
}

/// What the times of the steps of a frame count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepClock {
    /// Milliseconds that passed on the device: they add up to the frame's.
    Device,
    /// Milliseconds of all threads together: the frame waits for a share of them.
    Threads,
}

/// The processor.
#[derive(Clone, Copy, Debug)]
pub struct Cpu;

impl Backend for Cpu {
    type Stage = Stage;
    type Pipeline = Pipeline;
    type Error = RenderError;

    fn name(&self) -> &'static str {
        "cpu"
    }

    /// The processor's name where the system knows it, its architecture otherwise.
    fn adapter(&self) -> String {
        let described = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let named = described.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        named.map_or_else(|| env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
    }

    fn stage(
        &self,
        scene: Arc<Scene>,
        camera: &CameraChoice,
        threads: Option<usize>,
    ) -> Result<Stage, RenderError> {
        Stage::new(scene, camera, threads)
    }

    fn threads(&self, stage: &Stage) -> usize {
        stage.threads()
    }

    fn look_from(&self, stage: &mut Stage, pose: CameraPose) {
        stage.look_from(pose);
    }

    fn advance(&self, stage: &mut Stage, moment: Moment) -> Result<(), RenderError> {
        stage.advance(moment);
        Ok(())
    }

    fn pipeline(
        &self,
        method: &Method,
        antialiasing: Antialiasing,
        settings: Settings,
    ) -> Result<Pipeline, RenderError> {
        Pipeline::new(method.clone(), antialiasing, settings)
    }

    /// The processor runs every method.
    fn is_unsupported(&self, _: &RenderError) -> bool {
        false
    }

    fn twin(&self, method: &Method) -> Result<Method, RenderError> {
        Ok(method.clone())
    }

    fn render(
        &self,
        pipeline: &mut Pipeline,
        stage: &mut Stage,
        index: u32,
    ) -> Result<(Counters, Timings), RenderError> {
        pipeline.render(stage, index)
    }

    fn reset_history(&self, pipeline: &mut Pipeline) {
        pipeline.reset_history();
    }

    fn planes<'p>(&self, pipeline: &'p Pipeline) -> Result<Cow<'p, Planes>, RenderError> {
        Ok(Cow::Borrowed(pipeline.planes()))
    }

    fn display_share(
        &self,
        stage: &Stage,
        settings: &Settings,
        antialiasing: Antialiasing,
    ) -> Result<DisplayShare, RenderError> {
        display_share(stage, settings, antialiasing)
    }

    fn steps<'p>(&self, pipeline: &'p Pipeline) -> &'p [StepTime] {
        pipeline.steps()
    }

    fn step_clock(&self) -> StepClock {
        StepClock::Threads
    }

    fn notes<'p>(&self, _: &'p Pipeline) -> &'p [String] {
        &[]
    }

    /// What a rasteriser would store, as the method's paper has it.
    fn bytes_per_pixel(&self, pipeline: &Pipeline, hits_per_pixel: f64) -> f64 {
        match pipeline.method().memory() {
            Memory::Bounded(bytes) => f64::from(bytes),
            // Lists take their fragments from a pool that all pixels share: the mean is what fills it.
            Memory::PerFragment(bytes) => f64::from(bytes) * hits_per_pixel,
        }
    }
}
