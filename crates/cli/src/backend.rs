//! From `--backend` and `--adapter` to what renders. Commands have one body for all backends, over
//! [`Backend`].

use sheer_core::text::MemorySize;
use sheer_gpu::{Gpu, GpuBackend};
use sheer_render::{Backend, backend::Cpu};

use crate::{
    args::{BackendArguments, BackendChoice},
    failure::Misuse,
    graphics,
};

/// Something that can be done on every backend.
pub(crate) trait Task {
    /// Does it.
    fn run_on<B: Backend + 'static>(&self, backend: &B) -> anyhow::Result<()>;
}

impl BackendArguments {
    /// Does something on what the user has chosen.
    pub(crate) fn run(&self, task: &impl Task) -> anyhow::Result<()> {
        match self.gpu()? {
            None => task.run_on(&Cpu),
            Some(gpu) => graphics::guarded(MemorySize(0), || task.run_on(&gpu)),
        }
    }

    /// Opens the GPU that the user has chosen; none for the processor.
    pub(crate) fn gpu(&self) -> anyhow::Result<Option<GpuBackend>> {
        match self.backend {
            BackendChoice::Cpu if self.adapter.is_some() => {
                Err(Misuse("--adapter is for --backend gpu, gpu:ray or gpu:raster".to_owned()).into())
            }
            BackendChoice::Cpu => Ok(None),
            BackendChoice::Gpu(path) => {
                let choice = self.adapter.clone().unwrap_or_default();
                let gpu = graphics::guarded(graphics::RENDERING, || Ok(Gpu::new(&choice)?))?;
                Ok(Some(GpuBackend::new(gpu, path)))
            }
        }
    }
}
