//! A device that the caller has opened.

use std::sync::Arc;

use crate::{device::Gpu, error::GpuError, needs::Needs, path::GpuPath};

impl Gpu {
    /// A device of the caller's own, opened with at least what [`Needs`] asks for. It stays the caller's: no
    /// callback is set on it, errors are caught by scopes, and when it is lost, calls say so
    /// ([`GpuError::DeviceLost`]) and go on saying so. Rays are traced by the device where it was opened with
    /// `EXPERIMENTAL_RAY_QUERY`.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] names the features and limits without which nothing runs;
    /// [`GpuPipeline::new`](crate::GpuPipeline::new) names those that a method needs beside.
    pub fn from_wgpu(
        adapter: &wgpu::Adapter,
        device: wgpu::Device,
        queue: wgpu::Queue,
    ) -> Result<Arc<Self>, GpuError> {
        let gpu = Self::of_caller(adapter, device, queue);
        Needs::of_path(GpuPath::Ray).check(&gpu.report().name, &gpu.device())?;
        Ok(gpu)
    }
}
