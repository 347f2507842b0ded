//! The GPU backend: the same scenes, the same methods and the same pictures as on the CPU, by ray query or by raster through wgpu.

mod accel;
mod bindings;
mod bvh;
mod device;
mod error;
mod frame;
mod pipeline;
mod pixels;
#[cfg(test)]
mod probe;
mod raster;
mod ray;
mod recording;
pub mod scene;
mod shader;
mod shadow;
mod stage;
mod tables;
mod temporal;
mod timing;
#[cfg(test)]
mod traversal_tests;

pub use crate::{
    device::{AdapterChoice, AdapterReport, Gpu, Tracer, adapters},
    error::GpuError,
    pipeline::{Path, PathChoice, Pipeline},
    stage::Stage,
};
