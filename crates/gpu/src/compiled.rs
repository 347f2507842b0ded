//! Shaders and pipelines that a device has compiled: each once, whatever asks for it.
//!
//! Compiling is what takes longest when a method is switched or a picture gets another size, and most passes
//! differ in neither: those that shade are the same for all methods. A pipeline is known by its shader's
//! whole text, its entry points and layouts, so that nothing depends on who asks first. Layouts are shared as
//! well, for pipelines are known by them.

use std::{collections::HashMap, sync::Arc};

use wgpu::{
    BindGroupLayout, BindGroupLayoutEntry, BlendState, CompareFunction, ComputePipeline, RenderPipeline,
    ShaderModule, TextureFormat,
};

/// What a compute pipeline is known by.
pub(crate) type ComputeKey = (ShaderModule, String, Vec<BindGroupLayout>);

/// What a render pipeline is known by.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RenderKey {
    pub(crate) module: ShaderModule,
    pub(crate) vertex: &'static str,
    pub(crate) fragment: String,
    pub(crate) groups: Vec<BindGroupLayout>,
    pub(crate) targets: Vec<(TextureFormat, Option<BlendState>)>,
    /// Format of the depth buffer, and which fragments pass the test; they write their depth.
    pub(crate) depth: Option<(TextureFormat, CompareFunction)>,
    pub(crate) samples: u32,
}

/// Everything compiled with one device.
#[derive(Debug, Default)]
pub(crate) struct Compiled {
    pub(crate) layouts: HashMap<Vec<BindGroupLayoutEntry>, BindGroupLayout>,
    /// By their whole text.
    modules: HashMap<Arc<str>, ShaderModule>,
    pub(crate) compute: HashMap<ComputeKey, ComputePipeline>,
    pub(crate) render: HashMap<RenderKey, RenderPipeline>,
    /// See [`Gpu::use_pipeline_cache`](crate::Gpu::use_pipeline_cache).
    pub(crate) driver_cache: Option<wgpu::PipelineCache>,
    /// How many pipelines were made so far.
    pub(crate) pipeline_count: u64,
}

impl Compiled {
    pub(crate) fn module(&self, text: &str) -> Option<ShaderModule> {
        self.modules.get(text).cloned()
    }

    pub(crate) fn keep_module(&mut self, text: &str, module: &ShaderModule) {
        self.modules.insert(text.into(), module.clone());
    }
}
