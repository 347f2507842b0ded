//! A frame on its way to the device: what passes have in common when they are recorded.

use crate::{shader::numbers::GROUP_SIDE, timing::Timer};

/// Groups 0 and 1, as passes bind them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Groups<'a> {
    pub(crate) scene: &'a wgpu::BindGroup,
    pub(crate) pass: &'a wgpu::BindGroup,
}

/// A frame that is being recorded.
pub(crate) struct Recording<'a> {
    pub(crate) encoder: &'a mut wgpu::CommandEncoder,
    pub(crate) timer: &'a mut Timer,
    /// Columns and rows of pixels.
    pub(crate) size: [u32; 2],
    /// How many triangles are drawn in a pass over all of them.
    pub(crate) triangle_count: u32,
}

impl Recording<'_> {
    /// A compute pass whose time counts as that of step `name`.
    pub(crate) fn compute_pass(&mut self, name: &'static str) -> wgpu::ComputePass<'_> {
        let timestamp_writes = self.timer.compute_writes(name);
        self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes })
    }

    /// One invocation a pixel, in a pass whose time counts as that of step `name`.
    pub(crate) fn for_each_pixel(
        &mut self,
        name: &'static str,
        pipeline: &wgpu::ComputePipeline,
        groups: &Groups<'_>,
        own: Option<&wgpu::BindGroup>,
    ) {
        let [width, height] = self.size;
        let mut pass = self.compute_pass(name);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, groups.scene, &[]);
        pass.set_bind_group(1, groups.pass, &[]);
        if let Some(own) = own {
            pass.set_bind_group(2, own, &[]);
        }
        pass.dispatch_workgroups(width.div_ceil(GROUP_SIDE), height.div_ceil(GROUP_SIDE), 1);
    }
}
