//! Compiles pipelines, each once a device: see [`Compiled`].

use std::sync::Mutex;

use wgpu::{
    BindGroupLayout, BindGroupLayoutEntry, ColorTargetState, ColorWrites, ComputePipeline, ErrorFilter,
    RenderPipeline, ShaderModule,
};

use crate::{
    compiled::{Compiled, RenderKey},
    device::{Gpu, lock},
};

/// Makes something that can be refused: then it is not kept, and [`Gpu::check`] tells why. The lock is not
/// held, for a driver may take half a minute.
fn made<T: Clone>(
    gpu: &Gpu,
    compiled: &Mutex<Compiled>,
    make: impl FnOnce(Option<&wgpu::PipelineCache>) -> T,
    keep: impl FnOnce(&mut Compiled, T),
) -> T {
    let driver_cache = lock(compiled).driver_cache.clone();
    let device = gpu.device();
    let scopes =
        [ErrorFilter::Validation, ErrorFilter::Internal].map(|filter| device.push_error_scope(filter));
    let pipeline = make(driver_cache.as_ref());
    let errors: Vec<_> =
        scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).collect();
    let mut compiled = lock(compiled);
    compiled.pipeline_count += 1;
    if errors.is_empty() {
        keep(&mut compiled, pipeline.clone());
    }
    drop(compiled);
    gpu.note(errors);
    pipeline
}

fn pipeline_layout(device: &wgpu::Device, label: &str, groups: &[BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().map(Some).collect();
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}

/// The layout of a bind group by its entries.
pub(crate) fn layout(gpu: &Gpu, label: &str, entries: &[BindGroupLayoutEntry]) -> BindGroupLayout {
    let compiled = gpu.compiled();
    let mut compiled = lock(&compiled);
    if let Some(layout) = compiled.layouts.get(entries) {
        return layout.clone();
    }
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(label), entries };
    let layout = gpu.device().create_bind_group_layout(&descriptor);
    compiled.layouts.insert(entries.to_vec(), layout.clone());
    layout
}

/// A compute pipeline over these groups.
pub(crate) fn compute_pipeline(
    gpu: &Gpu,
    label: &str,
    groups: &[&BindGroupLayout],
    module: &ShaderModule,
    entry_point: &str,
) -> ComputePipeline {
    let groups: Vec<_> = groups.iter().copied().cloned().collect();
    let key = (module.clone(), entry_point.to_owned(), groups);
    let compiled = gpu.compiled();
    if let Some(pipeline) = lock(&compiled).compute.get(&key) {
        return pipeline.clone();
    }
    let make = |cache: Option<&wgpu::PipelineCache>| {
        let device = gpu.device();
        let layout = pipeline_layout(&device, label, &key.2);
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: Some(&layout),
            module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache,
        })
    };
    made(gpu, &compiled, make, |compiled, pipeline| {
        compiled.compute.insert(key.clone(), pipeline);
    })
}

/// A render pipeline without vertex buffers, over lists of triangles.
pub(crate) fn render_pipeline(gpu: &Gpu, label: &str, key: &RenderKey) -> RenderPipeline {
    let compiled = gpu.compiled();
    if let Some(pipeline) = lock(&compiled).render.get(key) {
        return pipeline.clone();
    }
    let make = |cache: Option<&wgpu::PipelineCache>| {
        let device = gpu.device();
        let layout = pipeline_layout(&device, label, &key.groups);
        let targets = key
            .targets
            .iter()
            .map(|&(format, blend)| Some(ColorTargetState { format, blend, write_mask: ColorWrites::ALL }));
        let targets: Vec<_> = targets.collect();
        let compilation_options = wgpu::PipelineCompilationOptions::default();
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &key.module,
                entry_point: Some(key.vertex),
                compilation_options: compilation_options.clone(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &key.module,
                entry_point: Some(&key.fragment),
                compilation_options,
                targets: &targets,
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: key.depth.map(|(format, compare)| wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(true),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: key.samples, ..Default::default() },
            multiview_mask: None,
            cache,
        })
    };
    made(gpu, &compiled, make, |compiled, pipeline| {
        compiled.render.insert(key.clone(), pipeline);
    })
}
