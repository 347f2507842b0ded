//! Bind groups that all passes have in common: 0 the scene and the frame, 1 the pixels that come of it and
//! the shadow maps.

use wgpu::{BindGroupEntry, BindGroupLayoutEntry, BufferBindingType, ShaderStages};

use crate::{
    compile::layout,
    device::Gpu,
    resource::bind_group::{buffer_entry, group_of, read_only_entry, whole},
    shader::binding::{BIND_COUNTERS, BIND_FRAME, BIND_LAYERS, BIND_PIXELS, BIND_SURFACES, BIND_TABLES},
};

/// Layouts of groups 0 and 1.
#[derive(Debug)]
pub(crate) struct Layouts {
    /// The layout of group 0: the scene and the frame.
    pub(crate) scene: wgpu::BindGroupLayout,
    /// The layout of group 1: what passes write, and the shadow maps.
    pub(crate) pass: wgpu::BindGroupLayout,
}

impl Layouts {
    /// `scene` lays out the stage's part of group 0, `more` what group 1 has beside what all passes write:
    /// the layers of the pixels and the shadow maps, where there are any.
    pub(crate) fn new(gpu: &Gpu, scene: &[BindGroupLayoutEntry], more: &[BindGroupLayoutEntry]) -> Self {
        let [group_0, group_1] = Self::entries(scene, more);
        Self { scene: layout(gpu, "scene", &group_0), pass: layout(gpu, "pass", &group_1) }
    }

    /// The entries of groups 0 and 1.
    pub(crate) fn entries(
        scene: &[BindGroupLayoutEntry],
        more: &[BindGroupLayoutEntry],
    ) -> [Vec<BindGroupLayoutEntry>; 2] {
        let every = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let writers = ShaderStages::FRAGMENT | ShaderStages::COMPUTE;
        let mut group_0 = vec![
            buffer_entry(BIND_FRAME, every, BufferBindingType::Uniform),
            read_only_entry(BIND_TABLES, every),
        ];
        group_0.extend(scene);
        let written = [BIND_PIXELS, BIND_COUNTERS, BIND_SURFACES];
        let read_write = BufferBindingType::Storage { read_only: false };
        let mut group_1 = written.map(|binding| buffer_entry(binding, writers, read_write)).to_vec();
        group_1.extend(more);
        [group_0, group_1]
    }

    /// What group 1 has of the layers.
    pub(crate) fn layers_entry() -> BindGroupLayoutEntry {
        let read_write = BufferBindingType::Storage { read_only: false };
        buffer_entry(BIND_LAYERS, ShaderStages::COMPUTE, read_write)
    }

    /// Group 0; `stage` binds what the scene consists of.
    pub(crate) fn scene_group(
        &self,
        device: &wgpu::Device,
        frame: &wgpu::Buffer,
        tables: &wgpu::Buffer,
        stage: Vec<BindGroupEntry<'_>>,
    ) -> wgpu::BindGroup {
        let entries = [vec![whole(BIND_FRAME, frame), whole(BIND_TABLES, tables)], stage].concat();
        group_of(device, "scene", &self.scene, &entries)
    }

    /// Group 1; `more` binds the layers and the shadow maps, where there are any.
    pub(crate) fn pass_group<'a>(
        &self,
        device: &wgpu::Device,
        [pixels, counters, surfaces]: [&'a wgpu::Buffer; 3],
        more: impl IntoIterator<Item = BindGroupEntry<'a>>,
    ) -> wgpu::BindGroup {
        let mut entries =
            vec![whole(BIND_PIXELS, pixels), whole(BIND_COUNTERS, counters), whole(BIND_SURFACES, surfaces)];
        entries.extend(more);
        group_of(device, "pass", &self.pass, &entries)
    }
}
