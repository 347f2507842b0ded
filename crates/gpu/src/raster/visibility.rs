//! One fragment a pixel through a visibility buffer (STD section 3.5).

use wgpu::{BufferBindingType, BufferUsages, ShaderStages, TextureUsages};

use super::{
    draw::Draw,
    format::{DEPTH_FORMAT, NO_SURFACE, SURFACE_FORMAT},
    parts::Parts,
};
use crate::{
    compile::compute_pipeline,
    error::GpuError,
    ray::Shade,
    recording::{Groups, Recording},
    resource::{
        bind_group::{buffer_entry, group, texture_entry, texture_in, whole},
        buffer::pixel_buffer,
        target::Target,
    },
    shader::{
        binding::{BIND_TESTED, BIND_VISIBLE_SURFACES},
        record::pixel::Tested,
    },
};

/// What a pixel keeps of the fragments that were tested.
const TESTED_BYTES: u64 = size_of::<Tested>() as u64;

/// The passes of a threshold method.
#[derive(Debug)]
pub(super) struct Visibility {
    draw: wgpu::RenderPipeline,
    collect: wgpu::ComputePipeline,
    shade: Shade,
    surface: Target,
    depth: Target,
    tested: wgpu::Buffer,
    draw_group: wgpu::BindGroup,
    collect_group: wgpu::BindGroup,
}

impl Visibility {
    /// What the times of its passes are reported as, in their order.
    pub(super) const STEPS: [&str; 3] = ["visibility", "collect", Shade::STEP];

    pub(super) fn new(parts: &Parts<'_>) -> Result<Self, GpuError> {
        let gpu = parts.gpu;
        let fragment = ShaderStages::FRAGMENT;
        let read_write = BufferBindingType::Storage { read_only: false };
        let read_only = BufferBindingType::Storage { read_only: true };
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let surface = Target::new(gpu, parts.size, "visible surface", SURFACE_FORMAT, usage)?;
        let depth =
            Target::new(gpu, parts.size, "visible depth", DEPTH_FORMAT, TextureUsages::RENDER_ATTACHMENT)?;
        let tested = pixel_buffer(
            parts.gpu,
            parts.size,
            "tested fragments",
            [TESTED_BYTES, 0],
            BufferUsages::COPY_DST,
        )?;

        let (draw_layout, draw_group) = group(
            gpu,
            "visibility",
            &[buffer_entry(BIND_TESTED, fragment, read_write)],
            &[whole(BIND_TESTED, &tested)],
        );
        let module = gpu.shader(&parts.method_linker.link("pass/visibility")?)?;
        let draw = Draw {
            label: "visibility",
            module: &module,
            vertex: "vs_all",
            fragment: "fs_visibility",
            group: Some(&draw_layout),
            targets: &[(SURFACE_FORMAT, None)],
            depth: Some(wgpu::CompareFunction::Less),
            samples: 1,
        };
        let draw = draw.build(parts);
        gpu.check("pass/visibility")?;

        let compute = ShaderStages::COMPUTE;
        let uint = wgpu::TextureSampleType::Uint;
        let (collect_layout, collect_group) = group(
            gpu,
            "collect",
            &[
                texture_entry(BIND_VISIBLE_SURFACES, compute, uint, false),
                buffer_entry(BIND_TESTED, compute, read_only),
            ],
            &[texture_in(BIND_VISIBLE_SURFACES, &surface.view), whole(BIND_TESTED, &tested)],
        );
        let linker = parts.method_linker.clone().alias("find", "pass/find_visible");
        let module = gpu.shader(&linker.link("pass/find")?)?;
        let groups = [&parts.layouts.scene, &parts.layouts.pass, &collect_layout];
        let collect = compute_pipeline(gpu, "collect", &groups, &module, "cs_find");
        gpu.check("pass/find")?;
        let shade = Shade::new(gpu, parts.linker, parts.layouts)?;
        Ok(Self { draw, collect, shade, surface, depth, tested, draw_group, collect_group })
    }

    pub(super) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        let [draw, collect, _] = Self::STEPS;
        recording.encoder.clear_buffer(&self.tested, 0, None);
        let targets = [Some(self.surface.cleared(NO_SURFACE))];
        let depth = Some(self.depth.cleared_depth());
        recording.draw(draw, &self.draw, groups, Some(&self.draw_group), &targets, depth);
        recording.for_each_pixel(collect, &self.collect, groups, Some(&self.collect_group));
        self.shade.record(recording, groups);
    }

    /// The visibility buffer, its depth, and what was tested.
    pub(super) fn bytes(&self) -> u64 {
        self.surface.bytes() + self.depth.bytes() + self.tested.size()
    }
}
