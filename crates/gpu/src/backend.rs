//! A device as a [`Backend`]: what measures and compares on the processor does so on a GPU.

use std::{borrow::Cow, sync::Arc};

use sheer_image::{DisplayShare, Planes};
use sheer_render::{
    Antialiasing, Counters, Method, Moment, Settings, StepTime, Timings,
    backend::{Backend, StepClock},
    contract::Raster,
};
use sheer_scene::{CameraChoice, CameraPose, Scene};

use crate::{
    device::Gpu,
    error::GpuError,
    path::GpuPathChoice,
    pipeline::GpuPipeline,
    raster::{multisample::Sampling, plan::raster_of},
    stage::GpuStage,
};

/// A device of wgpu, by rays or by raster.
#[derive(Clone, Debug)]
pub struct GpuBackend {
    gpu: Arc<Gpu>,
    path: GpuPathChoice,
}

impl GpuBackend {
    /// An opened device and how pixels come about on it.
    #[must_use]
    pub fn new(gpu: Arc<Gpu>, path: GpuPathChoice) -> Self {
        Self { gpu, path }
    }
}

impl Backend for GpuBackend {
    type Stage = GpuStage;
    type Pipeline = GpuPipeline;
    type Error = GpuError;

    fn name(&self) -> &'static str {
        self.path.name()
    }

    fn adapter(&self) -> String {
        self.gpu.description()
    }

    fn stage(
        &self,
        scene: Arc<Scene>,
        camera: &CameraChoice,
        threads: Option<usize>,
    ) -> Result<GpuStage, GpuError> {
        GpuStage::new(&self.gpu, scene, camera, threads)
    }

    fn threads(&self, stage: &GpuStage) -> usize {
        stage.threads()
    }

    fn look_from(&self, stage: &mut GpuStage, pose: CameraPose) {
        stage.look_from(pose);
    }

    fn advance(&self, stage: &mut GpuStage, moment: Moment) -> Result<(), GpuError> {
        stage.advance(moment)
    }

    fn pipeline(
        &self,
        method: &Method,
        antialiasing: Antialiasing,
        settings: Settings,
    ) -> Result<GpuPipeline, GpuError> {
        GpuPipeline::new(&self.gpu, self.path, method.clone(), antialiasing, settings)
    }

    fn is_unsupported(&self, error: &GpuError) -> bool {
        matches!(error, GpuError::Unsupported { .. })
    }

    /// Samples of stochastic transparency are drawn in rounds of as many as the hardware has.
    fn twin(&self, method: &Method) -> Result<Method, GpuError> {
        match raster_of(method)? {
            Some(Raster::Multisample(multisample)) => {
                Ok(Sampling::new(multisample, self.gpu.report())?.twin(method))
            }
            _ => Ok(method.clone()),
        }
    }

    fn render(
        &self,
        pipeline: &mut GpuPipeline,
        stage: &mut GpuStage,
        index: u32,
    ) -> Result<(Counters, Timings), GpuError> {
        pipeline.render(stage, index)
    }

    fn reset_history(&self, pipeline: &mut GpuPipeline) {
        pipeline.reset_history();
    }

    fn planes<'p>(&self, pipeline: &'p GpuPipeline) -> Result<Cow<'p, Planes>, GpuError> {
        Ok(Cow::Owned(pipeline.planes()?))
    }

    /// Found on the processor: nothing is shaded, and most scenes need no ray.
    fn display_share(
        &self,
        stage: &GpuStage,
        settings: &Settings,
        antialiasing: Antialiasing,
    ) -> Result<DisplayShare, GpuError> {
        stage.display_share(settings, antialiasing)
    }

    fn steps<'p>(&self, pipeline: &'p GpuPipeline) -> &'p [StepTime] {
        pipeline.steps()
    }

    fn step_clock(&self) -> StepClock {
        StepClock::Device
    }

    fn notes<'p>(&self, pipeline: &'p GpuPipeline) -> &'p [String] {
        pipeline.notes()
    }

    /// What has been allocated, whether it is filled or not.
    fn bytes_per_pixel(&self, pipeline: &GpuPipeline, _: f64) -> f64 {
        pipeline.method_bytes_per_pixel()
    }
}
