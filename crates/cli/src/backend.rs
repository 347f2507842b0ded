//! What renders: the processor or a GPU. Commands that take `--backend` have one loop for both, over [`Renderer`].

use std::{borrow::Cow, env, fs, sync::Arc};

use sheer_gpu::{Gpu, GpuPathChoice};
use sheer_image::Planes;
use sheer_render::{Antialiasing, Counters, Method, Moment, Settings, StepTime, Timings, contract::Memory};
use sheer_scene::{CameraChoice, Scene};

use crate::{
    args::{Backend, BackendArguments},
    failure::Misuse,
};

/// A backend: makes stages and pipelines of its own kind, and works with them.
pub(crate) trait Renderer {
    /// A scene at a time.
    type Stage;
    /// A method and its accumulated history.
    type Pipeline;

    /// The word on the command line.
    fn word(&self) -> &'static str;
    /// What it runs on.
    fn adapter(&self) -> String;
    /// Prepares a scene.
    fn stage(
        &self,
        scene: Arc<Scene>,
        camera: &CameraChoice,
        threads: Option<usize>,
    ) -> anyhow::Result<Self::Stage>;
    /// How many threads work for a stage.
    fn threads(&self, stage: &Self::Stage) -> usize;
    /// Moves everything to a moment.
    fn advance(&self, stage: &mut Self::Stage, moment: Moment) -> anyhow::Result<()>;
    /// Prepares a method.
    fn pipeline(
        &self,
        method: &Method,
        antialiasing: Antialiasing,
        settings: Settings,
    ) -> anyhow::Result<Self::Pipeline>;
    /// Renders frame `index` of a stage that has been advanced to it.
    fn render(
        &self,
        pipeline: &mut Self::Pipeline,
        stage: &mut Self::Stage,
        index: u32,
    ) -> anyhow::Result<(Counters, Timings)>;
    /// The picture so far.
    fn planes<'p>(&self, pipeline: &'p Self::Pipeline) -> anyhow::Result<Cow<'p, Planes>>;
    /// What the passes of the last frame took by the device's own clock; none where there is no such clock.
    fn steps<'p>(&self, pipeline: &'p Self::Pipeline) -> &'p [StepTime];
    /// What the user should know of how a method is run.
    fn notes<'p>(&self, pipeline: &'p Self::Pipeline) -> &'p [String];
    /// Bytes a pixel that a method stores beyond colour and depth, where `hits_per_pixel` is the mean of its fragments.
    fn bytes_per_pixel(&self, pipeline: &Self::Pipeline, hits_per_pixel: f64) -> f64;
}

/// The processor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cpu;

impl Renderer for Cpu {
    type Stage = sheer_render::Stage;
    type Pipeline = sheer_render::Pipeline;

    fn word(&self) -> &'static str {
        Backend::Cpu.word()
    }

    /// The processor's name where the system tells it, its architecture otherwise.
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
    ) -> anyhow::Result<Self::Stage> {
        Ok(sheer_render::Stage::new(scene, camera, threads)?)
    }

    fn threads(&self, stage: &Self::Stage) -> usize {
        stage.threads()
    }

    fn advance(&self, stage: &mut Self::Stage, moment: Moment) -> anyhow::Result<()> {
        stage.advance(moment);
        Ok(())
    }

    fn pipeline(
        &self,
        method: &Method,
        antialiasing: Antialiasing,
        settings: Settings,
    ) -> anyhow::Result<Self::Pipeline> {
        Ok(sheer_render::Pipeline::new(method.clone(), antialiasing, settings)?)
    }

    fn render(
        &self,
        pipeline: &mut Self::Pipeline,
        stage: &mut Self::Stage,
        index: u32,
    ) -> anyhow::Result<(Counters, Timings)> {
        Ok(pipeline.render(stage, index)?)
    }

    fn planes<'p>(&self, pipeline: &'p Self::Pipeline) -> anyhow::Result<Cow<'p, Planes>> {
        Ok(Cow::Borrowed(pipeline.planes()))
    }

    fn steps<'p>(&self, _: &'p Self::Pipeline) -> &'p [StepTime] {
        &[]
    }

    fn notes<'p>(&self, _: &'p Self::Pipeline) -> &'p [String] {
        &[]
    }

    /// What a rasteriser would store, as the method's paper has it.
    fn bytes_per_pixel(&self, pipeline: &Self::Pipeline, hits_per_pixel: f64) -> f64 {
        match pipeline.method().memory() {
            Memory::Bounded(bytes) => f64::from(bytes),
            // Lists take their fragments from a pool that all pixels share: the mean is what fills it.
            Memory::PerFragment(bytes) => f64::from(bytes) * hits_per_pixel,
        }
    }
}

/// A device of wgpu, by rays or by raster.
#[derive(Clone, Debug)]
pub(crate) struct OnGpu {
    gpu: Arc<Gpu>,
    path: GpuPathChoice,
}

impl Renderer for OnGpu {
    type Stage = sheer_gpu::GpuStage;
    type Pipeline = sheer_gpu::GpuPipeline;

    fn word(&self) -> &'static str {
        Backend::Gpu(self.path).word()
    }

    fn adapter(&self) -> String {
        self.gpu.description()
    }

    fn stage(
        &self,
        scene: Arc<Scene>,
        camera: &CameraChoice,
        threads: Option<usize>,
    ) -> anyhow::Result<Self::Stage> {
        Ok(sheer_gpu::GpuStage::new(&self.gpu, scene, camera, threads)?)
    }

    fn threads(&self, stage: &Self::Stage) -> usize {
        stage.threads()
    }

    fn advance(&self, stage: &mut Self::Stage, moment: Moment) -> anyhow::Result<()> {
        Ok(stage.advance(moment)?)
    }

    fn pipeline(
        &self,
        method: &Method,
        antialiasing: Antialiasing,
        settings: Settings,
    ) -> anyhow::Result<Self::Pipeline> {
        Ok(sheer_gpu::GpuPipeline::new(&self.gpu, self.path, method.clone(), antialiasing, settings)?)
    }

    fn render(
        &self,
        pipeline: &mut Self::Pipeline,
        stage: &mut Self::Stage,
        index: u32,
    ) -> anyhow::Result<(Counters, Timings)> {
        Ok(pipeline.render(stage, index)?)
    }

    fn planes<'p>(&self, pipeline: &'p Self::Pipeline) -> anyhow::Result<Cow<'p, Planes>> {
        Ok(Cow::Owned(pipeline.planes()?))
    }

    fn steps<'p>(&self, pipeline: &'p Self::Pipeline) -> &'p [StepTime] {
        pipeline.steps()
    }

    fn notes<'p>(&self, pipeline: &'p Self::Pipeline) -> &'p [String] {
        pipeline.notes()
    }

    /// What has been allocated, whether it is filled or not.
    fn bytes_per_pixel(&self, pipeline: &Self::Pipeline, _: f64) -> f64 {
        pipeline.method_bytes_per_pixel()
    }
}

/// Something that can be done on every backend.
pub(crate) trait Task {
    /// Does it.
    fn run_on(&self, renderer: &impl Renderer) -> anyhow::Result<()>;
}

impl BackendArguments {
    /// Does something on what the user has chosen.
    pub(crate) fn run(&self, task: &impl Task) -> anyhow::Result<()> {
        match self.gpu()? {
            None => task.run_on(&Cpu),
            Some(gpu) => task.run_on(&gpu),
        }
    }

    /// Opens the GPU that the user has chosen; none for the processor.
    pub(crate) fn gpu(&self) -> anyhow::Result<Option<OnGpu>> {
        match self.backend {
            Backend::Cpu if self.adapter.is_some() => {
                Err(Misuse("--adapter is for --backend gpu, gpu:ray or gpu:raster".to_owned()).into())
            }
            Backend::Cpu => Ok(None),
            Backend::Gpu(path) => {
                let gpu = Gpu::new(&self.adapter.clone().unwrap_or_default())?;
                Ok(Some(OnGpu { gpu, path }))
            }
        }
    }
}
