//! The GPU backend: the same scenes, the same methods and the same pictures as on the CPU, by ray query or by
//! raster through wgpu.

mod accel;
mod backend;
mod compile;
mod compiled;
mod device;
mod error;
mod foreign;
mod frame;
mod layouts;
mod needs;
mod opaque_input;
mod path;
mod picture;
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
mod view;

pub use crate::{
    backend::GpuBackend,
    device::{AdapterChoice, AdapterReport, Gpu, Tracer, adapters},
    error::GpuError,
    needs::Needs,
    opaque_input::Opaque,
    path::{GpuPath, GpuPathChoice},
    picture::Picture,
    pipeline::GpuPipeline,
    stage::GpuStage,
    view::View,
};
/// The version of wgpu whose devices are taken.
pub use wgpu;
