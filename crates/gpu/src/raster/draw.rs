//! Pipelines that draw all triangles.

use wgpu::{BlendState, CompareFunction, TextureFormat};

use super::{format::DEPTH_FORMAT, parts::Parts};
use crate::{
    compile::render_pipeline,
    compiled::RenderKey,
    recording::{Groups, Recording},
};

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
        let mut groups = vec![parts.layouts.scene.clone(), parts.layouts.pass.clone()];
        groups.extend(self.group.cloned());
        let key = RenderKey {
            module: self.module.clone(),
            vertex: self.vertex,
            fragment: self.fragment.to_owned(),
            groups,
            targets: self.targets.to_vec(),
            depth: self.depth.map(|compare| (DEPTH_FORMAT, compare)),
            samples: self.samples,
        };
        render_pipeline(parts.gpu, self.label, &key)
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
