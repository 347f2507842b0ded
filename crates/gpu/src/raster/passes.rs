//! Carries out the passes that a method asks for: makes its targets and buffers and records its steps.

use std::collections::BTreeMap;

use sheer_render::contract::{Passes, Resource, Step, StepKind};
use wgpu::{
    BindGroupLayoutEntry, BufferBindingType, BufferUsages, ShaderStages, TextureFormat, TextureUsages,
};

use super::{
    composite::Composite,
    draw::Draw,
    format::{DEPTH_FORMAT, blend_state, texture_format},
    opaque::Opaque,
    parts::Parts,
    plan::blending_features,
};
use crate::{
    compile::{compute_pipeline, layout},
    error::GpuError,
    recording::{Groups, Recording},
    resource::{
        bind_group::{buffer_entry, group_of, texture_entry, texture_in, whole},
        buffer::pixel_buffer,
        target::Target,
    },
    shader::{binding::BIND_OPAQUE_SURFACES, linked::Linked},
};

/// The passes of a method, ready to be recorded, and the resources that they ask for.
#[derive(Debug)]
pub(super) struct DrawnPasses {
    opaque: Opaque,
    resources: Vec<DeviceResource>,
    /// One for each entry point that a step names.
    programs: BTreeMap<&'static str, Program>,
    /// The steps in their order, each with what it binds in group 2.
    steps: Vec<(Step, wgpu::BindGroup)>,
    composite: Composite,
}

/// A resource on the device.
#[derive(Debug)]
enum DeviceResource {
    Texture { target: Target, format: TextureFormat, clear: wgpu::Color },
    Buffer(wgpu::Buffer),
}

/// An entry point, ready to run.
#[derive(Debug)]
struct Program {
    /// The layout of group 2.
    layout: wgpu::BindGroupLayout,
    pipeline: Runnable,
}

#[derive(Debug)]
enum Runnable {
    Draw(wgpu::RenderPipeline),
    Pixels(wgpu::ComputePipeline),
}

impl DeviceResource {
    fn new(parts: &Parts<'_>, resource: Resource) -> Result<Self, GpuError> {
        let drawn_to = TextureUsages::RENDER_ATTACHMENT;
        Ok(match resource {
            Resource::Target { label, format, clear: [r, g, b, a] } => {
                let (format, clear) = (texture_format(format), wgpu::Color { r, g, b, a });
                let usage = drawn_to | TextureUsages::TEXTURE_BINDING;
                Self::Texture {
                    target: Target::new(parts.gpu, parts.size, label, format, usage)?,
                    format,
                    clear,
                }
            }
            Resource::Depth { label } => {
                let target = Target::new(parts.gpu, parts.size, label, DEPTH_FORMAT, drawn_to)?;
                Self::Texture { target, format: DEPTH_FORMAT, clear: wgpu::Color::WHITE }
            }
            Resource::Storage { label, bytes_per_pixel } => Self::Buffer(pixel_buffer(
                parts.gpu,
                parts.size,
                label,
                [bytes_per_pixel, 0],
                BufferUsages::COPY_DST,
            )?),
        })
    }

    fn bytes(&self) -> u64 {
        match self {
            Self::Texture { target, .. } => target.bytes(),
            Self::Buffer(buffer) => buffer.size(),
        }
    }

    fn layout_entry(&self, binding: u32, stage: ShaderStages) -> BindGroupLayoutEntry {
        match self {
            Self::Texture { format, .. } => {
                let uint = format.sample_type(None, None) == Some(wgpu::TextureSampleType::Uint);
                let floats = wgpu::TextureSampleType::Float { filterable: false };
                let sample_type = if uint { wgpu::TextureSampleType::Uint } else { floats };
                texture_entry(binding, stage, sample_type, false)
            }
            Self::Buffer(_) => buffer_entry(binding, stage, BufferBindingType::Storage { read_only: false }),
        }
    }

    fn entry(&self, binding: u32) -> wgpu::BindGroupEntry<'_> {
        match self {
            Self::Texture { target, .. } => texture_in(binding, &target.view),
            Self::Buffer(buffer) => whole(binding, buffer),
        }
    }

    /// As a texture; passes draw to nothing else.
    fn texture(&self) -> (&Target, TextureFormat, wgpu::Color) {
        match self {
            Self::Texture { target, format, clear } => (target, *format, *clear),
            Self::Buffer(_) => unreachable!("passes draw to targets"),
        }
    }
}

impl Program {
    fn new(
        parts: &Parts<'_>,
        module: &wgpu::ShaderModule,
        step: &Step,
        resources: &[DeviceResource],
    ) -> Result<Self, GpuError> {
        let stage = match step.kind {
            StepKind::Draw { .. } => ShaderStages::FRAGMENT,
            StepKind::Pixels => ShaderStages::COMPUTE,
        };
        let mut entries =
            vec![texture_entry(BIND_OPAQUE_SURFACES, stage, wgpu::TextureSampleType::Uint, false)];
        entries.extend(
            step.bound.iter().map(|&(binding, index)| resources[index].layout_entry(binding.number, stage)),
        );
        let layout = layout(parts.gpu, step.entry_point, &entries);
        let pipeline = match &step.kind {
            StepKind::Draw { targets, depth } => {
                let targets: Vec<_> = targets
                    .iter()
                    .map(|&(index, blend)| (resources[index].texture().1, blend.map(blend_state)))
                    .collect();
                let draw = Draw {
                    label: step.name,
                    module,
                    vertex: "vs_transparent",
                    fragment: step.entry_point,
                    group: Some(&layout),
                    targets: &targets,
                    depth: depth.map(|_| wgpu::CompareFunction::Less),
                    samples: 1,
                };
                Runnable::Draw(draw.build(parts))
            }
            StepKind::Pixels => {
                let groups = [&parts.layouts.scene, &parts.layouts.pass, &layout];
                Runnable::Pixels(compute_pipeline(parts.gpu, step.name, &groups, module, step.entry_point))
            }
        };
        parts.gpu.check(step.entry_point)?;
        Ok(Self { layout, pipeline })
    }
}

impl DrawnPasses {
    /// `shader` has the entry points that the passes name.
    pub(super) fn new(parts: &Parts<'_>, passes: Passes, shader: &Linked) -> Result<Self, GpuError> {
        let features = blending_features(&passes);
        let Passes { resources, steps, .. } = passes;
        let opaque = Opaque::new(parts)?;
        let made = resources.into_iter().map(|resource| DeviceResource::new(parts, resource));
        let resources = made.collect::<Result<Vec<_>, _>>()?;
        if !parts.gpu.features().contains(features) {
            return Err(GpuError::Unsupported {
                what: format!("{} lacks {features:?}, which the method needs", parts.gpu.report().name),
                instead: "take another method, or --backend cpu".to_owned(),
            });
        }
        let module = parts.gpu.shader(shader)?;
        let mut programs = BTreeMap::new();
        for step in &steps {
            if !programs.contains_key(step.entry_point) {
                programs.insert(step.entry_point, Program::new(parts, &module, step, &resources)?);
            }
        }
        let with_group = |step: Step| {
            let mut entries = vec![texture_in(BIND_OPAQUE_SURFACES, &opaque.surface.view)];
            entries.extend(step.bound.iter().map(|&(binding, index)| resources[index].entry(binding.number)));
            let layout = &programs[step.entry_point].layout;
            let group = group_of(&parts.gpu.device(), step.name, layout, &entries);
            (step, group)
        };
        let steps = steps.into_iter().map(with_group).collect();
        parts.gpu.check(&shader.piece)?;
        let composite = Composite::new(parts, &opaque)?;
        Ok(Self { opaque, resources, programs, steps, composite })
    }

    pub(super) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        self.opaque.record(recording, groups);
        for resource in &self.resources {
            if let DeviceResource::Buffer(buffer) = resource {
                recording.encoder.clear_buffer(buffer, 0, None);
            }
        }
        for (step, group) in &self.steps {
            match (&step.kind, &self.programs[step.entry_point].pipeline) {
                (StepKind::Draw { targets, depth }, Runnable::Draw(pipeline)) => {
                    let attached = |&(index, _): &(usize, _)| {
                        let (target, _, clear) = self.resources[index].texture();
                        Some(target.cleared(clear))
                    };
                    let targets: Vec<_> = targets.iter().map(attached).collect();
                    let depth = depth.map(|index| self.resources[index].texture().0.cleared_depth());
                    recording.draw(step.name, pipeline, groups, Some(group), &targets, depth);
                }
                (StepKind::Pixels, Runnable::Pixels(pipeline)) => {
                    recording.for_each_pixel(step.name, pipeline, groups, Some(group));
                }
                _ => unreachable!("a program is made for its step's work"),
            }
        }
        self.composite.record(recording, groups);
    }

    /// What the times of the passes are reported as, in their order.
    #[cfg(test)]
    pub(super) fn steps(passes: &Passes) -> Vec<&'static str> {
        let own = passes.steps.iter().map(|step| step.name);
        [Opaque::STEP].into_iter().chain(own).chain([Composite::STEP]).collect()
    }

    /// Bytes of everything that the passes ask for.
    pub(super) fn bytes(&self) -> u64 {
        self.resources.iter().map(DeviceResource::bytes).sum()
    }
}
