//! Pipelines that draw all triangles.

use wgpu::{BlendState, ColorTargetState, ColorWrites, CompareFunction, TextureFormat};

use super::{format::DEPTH_FORMAT, parts::Parts};
use crate::recording::{Groups, Recording};

/// How all triangles are drawn in a pass.
pub(crate) struct Draw<'a> {
    pub(crate) label: &'static str,
    pub(crate) module: &'a wgpu::ShaderModule,
    pub(crate) vertex: &'static str,
    pub(crate) fragment: &'static str,
    /// Layout of group 2.
    pub(crate) group: Option<&'a wgpu::BindGroupLayout>,
    pub(crate) targets: &'a [(TextureFormat, Option<BlendState>)],
    /// Which fragments pass the depth test; they write their depth.
    pub(crate) depth: Option<CompareFunction>,
    /// Samples that a pixel of the targets has.
    pub(crate) samples: u32,
}

impl Draw<'_> {
    pub(crate) fn build(&self, parts: &Parts<'_>) -> wgpu::RenderPipeline {
        let device = parts.gpu.device();
        let mut groups = vec![Some(&parts.layouts.scene), Some(&parts.layouts.pass)];
        groups.extend(self.group.map(Some));
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let targets = self
            .targets
            .iter()
            .map(|&(format, blend)| Some(ColorTargetState { format, blend, write_mask: ColorWrites::ALL }));
        let targets: Vec<_> = targets.collect();
        let compilation_options = wgpu::PipelineCompilationOptions::default();
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: self.module,
                entry_point: Some(self.vertex),
                compilation_options: compilation_options.clone(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: self.module,
                entry_point: Some(self.fragment),
                compilation_options,
                targets: &targets,
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: self.depth.map(|compare| wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: self.samples, ..Default::default() },
            multiview_mask: None,
            cache: None,
        })
    }
}

impl Recording<'_> {
    /// Draws all triangles in a pass whose time counts as that of step `name`.
    pub(crate) fn draw(
        &mut self,
        name: &'static str,
        pipeline: &wgpu::RenderPipeline,
        groups: &Groups<'_>,
        own: Option<&wgpu::BindGroup>,
        targets: &[Option<wgpu::RenderPassColorAttachment<'_>>],
        depth: Option<wgpu::RenderPassDepthStencilAttachment<'_>>,
    ) {
        let timestamp_writes = self.timer.render_writes(name);
        let mut pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(name),
            color_attachments: targets,
            depth_stencil_attachment: depth,
            timestamp_writes,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, groups.scene, &[]);
        pass.set_bind_group(1, groups.pass, &[]);
        if let Some(own) = own {
            pass.set_bind_group(2, own, &[]);
        }
        pass.draw(0..3 * self.triangle_count, 0..1);
    }
}
