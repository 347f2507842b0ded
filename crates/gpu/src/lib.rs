//! The GPU backend: the same scenes, the same methods and the same pictures as on the CPU, by ray query or by
//! raster through wgpu.

mod accel;
mod backend;
mod device;
mod error;
mod frame;
mod layouts;
mod path;
mod pipeline;
mod pixels;
mod raster;
mod ray;
mod recording;
mod resource;
pub mod scene;
mod shader;
mod shadow;
mod stage;
mod tables;
mod temporal;
#[cfg(test)]
mod tests;
mod timing;

pub use crate::{
    backend::GpuBackend,
    device::{AdapterChoice, AdapterReport, Gpu, Tracer, adapters},
    error::GpuError,
    path::{GpuPath, GpuPathChoice},
    pipeline::GpuPipeline,
    stage::GpuStage,
};
