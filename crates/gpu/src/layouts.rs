//! Bind groups that all passes have in common: 0 the scene and the frame, 1 the pixels that come of it and the shadow maps.

use wgpu::{BindGroupEntry, BindGroupLayoutEntry, BufferBindingType, ShaderStages};

use crate::resource::bind_group::{buffer_entry, group_of, layout, read_only_entry, whole};

/// Binding of the uniform of shaders/shared/frame.wgsl.
const FRAME: u32 = 0;
/// Binding of the tables of shaders/shared/tables.wgsl.
const TABLES: u32 = 14;
/// Binding of the surfaces of shaders/shared/pass.wgsl.
const SURFACES: u32 = 5;

/// Layouts of groups 0 and 1.
#[derive(Debug)]
pub(crate) struct Layouts {
    /// Group 0.
    pub(crate) scene: wgpu::BindGroupLayout,
    /// Group 1.
    pub(crate) pass: wgpu::BindGroupLayout,
}

impl Layouts {
    /// `scene` lays out the stage's part of group 0, `maps` the shadow maps' part of group 1, which is empty without maps.
    pub(crate) fn new(
        device: &wgpu::Device,
        scene: &[BindGroupLayoutEntry],
        maps: &[BindGroupLayoutEntry],
    ) -> Self {
        let every = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let writers = ShaderStages::FRAGMENT | ShaderStages::COMPUTE;
        let mut group_0 =
            vec![buffer_entry(FRAME, every, BufferBindingType::Uniform), read_only_entry(TABLES, every)];
        group_0.extend(scene);
        let read_write = BufferBindingType::Storage { read_only: false };
        let mut group_1 = [0, 1, SURFACES].map(|binding| buffer_entry(binding, writers, read_write)).to_vec();
        group_1.extend(maps);
        Self { scene: layout(device, "scene", &group_0), pass: layout(device, "pass", &group_1) }
    }

    /// Group 0; `stage` binds what the scene consists of.
    pub(crate) fn scene_group(
        &self,
        device: &wgpu::Device,
        frame: &wgpu::Buffer,
        tables: &wgpu::Buffer,
        stage: Vec<BindGroupEntry<'_>>,
    ) -> wgpu::BindGroup {
        let entries = [vec![whole(FRAME, frame), whole(TABLES, tables)], stage].concat();
        group_of(device, "scene", &self.scene, &entries)
    }

    /// Group 1; `maps` binds the shadow maps, if there are any.
    pub(crate) fn pass_group<'a>(
        &self,
        device: &wgpu::Device,
        [pixels, counters, surfaces]: [&'a wgpu::Buffer; 3],
        maps: impl IntoIterator<Item = BindGroupEntry<'a>>,
    ) -> wgpu::BindGroup {
        let mut entries = vec![whole(0, pixels), whole(1, counters), whole(SURFACES, surfaces)];
        entries.extend(maps);
        group_of(device, "pass", &self.pass, &entries)
    }
}
