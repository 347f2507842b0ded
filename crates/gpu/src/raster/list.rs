//! Fragments in order through a list a pixel: the exact answer, selection, and the hybrid of STD section 3.5.

use wgpu::{BufferBindingType, BufferUsages, ShaderStages, TextureSampleType, TextureUsages};

use super::{
    composite::Composite,
    draw::Draw,
    format::{ADD, MULTIPLY, TAIL_FORMATS},
    opaque::Opaque,
    parts::Parts,
    plan,
};
use crate::{
    compile::compute_pipeline,
    error::GpuError,
    ray::{Search, Shade},
    recording::{Groups, Recording},
    resource::{
        bind_group::{buffer_entry, group, texture_entry, texture_in, whole},
        buffer::{pixel_buffer, storage_limit},
        target::Target,
    },
    shader::{
        Linker,
        binding::{
            BIND_LIST_HEADS, BIND_LIST_NODES, BIND_OPAQUE_SURFACES, BIND_TAIL_SUMS, BIND_TAIL_TRANSMITTANCE,
        },
        linked::Linked,
        record::pixel::ListNode,
    },
};

/// Nodes that the pool holds for each pixel of the picture, on average: more than most scenes fill, 256
/// bytes.
const NODES_PER_PIXEL: u64 = 32;
/// What a fragment takes.
const NODE_BYTES: u64 = size_of::<ListNode>() as u64;
/// The first node; one more counts the nodes.
const HEAD_BYTES: u64 = 4;

/// Lists of all transparent fragments.
#[derive(Debug)]
pub(crate) struct Lists {
    opaque: Opaque,
    capture: wgpu::RenderPipeline,
    resolve: wgpu::ComputePipeline,
    heads: wgpu::Buffer,
    nodes: wgpu::Buffer,
    tail: [Target; 2],
    capture_group: wgpu::BindGroup,
    resolve_group: wgpu::BindGroup,
    after: After,
}

/// What is left to do when the lists have been gone through.
#[derive(Debug)]
enum After {
    /// The pixels are made.
    Nothing,
    /// Shade one fragment a pixel.
    Shade(Shade),
    /// Composite the light of the lists over what is opaque.
    Composite(Composite),
}

/// Nodes for so many pixels, as far as one binding goes.
fn node_bytes_per_pixel(parts: &Parts<'_>) -> u64 {
    let [width, height] = parts.size.map(u64::from);
    let most = storage_limit(&parts.gpu.device().limits()) / (width * height).max(1);
    (NODE_BYTES * NODES_PER_PIXEL).min(most / NODE_BYTES * NODE_BYTES)
}

impl Lists {
    /// What the times of its passes are reported as, in their order, but for those of [`After`].
    pub(super) const STEPS: [&str; 3] = [Opaque::STEP, "capture", "resolve"];

    pub(super) fn new(parts: &Parts<'_>, search: Search) -> Result<Self, GpuError> {
        let (piece, entry_point) = search.piece();
        let shader = Self::linker(parts.method_linker.clone(), search).link(piece)?;
        let mut lists = Self::resolved_by(parts, entry_point, &shader)?;
        if search.is_pure() {
            lists.after = After::Shade(Shade::new(parts.gpu, parts.linker, parts.layouts)?);
        }
        Ok(lists)
    }

    /// What makes pixels of lists as of rays.
    pub(crate) fn linker(linker: Linker, search: Search) -> Linker {
        search.finding(linker).alias("camera", "shared/traverse_list").alias("tail", "shared/listed")
    }

    /// With the shader of a plan for what becomes of the lists.
    pub(super) fn planned(parts: &Parts<'_>, shader: &Linked) -> Result<Self, GpuError> {
        let mut lists = Self::resolved_by(parts, plan::ENTRY_POINT, shader)?;
        lists.after = After::Composite(Composite::new(parts, &lists.opaque)?);
        Ok(lists)
    }

    /// With a shader of the caller's for what becomes of the lists, with its entry point.
    fn resolved_by(parts: &Parts<'_>, entry_point: &str, shader: &Linked) -> Result<Self, GpuError> {
        let gpu = parts.gpu;
        // Memory: the lists, and sums of the fragments that find the pool full.
        let opaque = Opaque::new(parts)?;
        let heads = pixel_buffer(
            parts.gpu,
            parts.size,
            "list heads",
            [HEAD_BYTES, HEAD_BYTES],
            BufferUsages::COPY_DST,
        )?;
        let nodes = pixel_buffer(
            parts.gpu,
            parts.size,
            "list nodes",
            [node_bytes_per_pixel(parts), 0],
            BufferUsages::empty(),
        )?;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let [sums, transmittance] = TAIL_FORMATS;
        let tail = [
            Target::new(gpu, parts.size, "tail sums", sums, usage)?,
            Target::new(gpu, parts.size, "tail transmittance", transmittance, usage)?,
        ];

        // The pass that fills the lists.
        let (fragment, compute) = (ShaderStages::FRAGMENT, ShaderStages::COMPUTE);
        let read_write = BufferBindingType::Storage { read_only: false };
        let read_only = BufferBindingType::Storage { read_only: true };
        let buffers = [
            texture_in(BIND_OPAQUE_SURFACES, &opaque.surface.view),
            whole(BIND_LIST_HEADS, &heads),
            whole(BIND_LIST_NODES, &nodes),
        ];
        let layout = [
            texture_entry(BIND_OPAQUE_SURFACES, fragment, TextureSampleType::Uint, false),
            buffer_entry(BIND_LIST_HEADS, fragment, read_write),
            buffer_entry(BIND_LIST_NODES, fragment, read_write),
        ];
        let (capture_layout, capture_group) = group(gpu, "capture", &layout, &buffers);
        let module = gpu.shader(&parts.linker.link("pass/capture")?)?;
        let capture = Draw {
            label: "capture",
            module: &module,
            vertex: "vs_transparent",
            fragment: "fs_capture",
            group: Some(&capture_layout),
            targets: &[(sums, Some(ADD)), (transmittance, Some(MULTIPLY))],
            depth: None,
            samples: 1,
        };
        let capture = capture.build(parts);
        gpu.check("pass/capture")?;

        // The pass that makes pixels of them.
        let unfilterable = TextureSampleType::Float { filterable: false };
        let layout = [
            texture_entry(BIND_OPAQUE_SURFACES, compute, TextureSampleType::Uint, false),
            buffer_entry(BIND_LIST_HEADS, compute, read_only),
            buffer_entry(BIND_LIST_NODES, compute, read_only),
            texture_entry(BIND_TAIL_SUMS, compute, unfilterable, false),
            texture_entry(BIND_TAIL_TRANSMITTANCE, compute, unfilterable, false),
        ];
        let mut bindings = buffers.to_vec();
        bindings.extend([
            texture_in(BIND_TAIL_SUMS, &tail[0].view),
            texture_in(BIND_TAIL_TRANSMITTANCE, &tail[1].view),
        ]);
        let (resolve_layout, resolve_group) = group(gpu, "resolve", &layout, &bindings);
        let module = gpu.shader(shader)?;
        let groups = [&parts.layouts.scene, &parts.layouts.pass, &resolve_layout];
        let resolve = compute_pipeline(gpu, "resolve", &groups, &module, entry_point);
        gpu.check(&shader.piece)?;
        let after = After::Nothing;
        Ok(Self { opaque, capture, resolve, heads, nodes, tail, capture_group, resolve_group, after })
    }

    pub(super) fn record(&self, recording: &mut Recording<'_>, groups: &Groups<'_>) {
        let [_, capture, resolve] = Self::STEPS;
        self.opaque.record(recording, groups);
        recording.encoder.clear_buffer(&self.heads, 0, None);
        let [sums, transmittance] = &self.tail;
        let targets =
            [Some(sums.cleared(wgpu::Color::TRANSPARENT)), Some(transmittance.cleared(wgpu::Color::WHITE))];
        recording.draw(capture, &self.capture, groups, Some(&self.capture_group), &targets, None);
        recording.for_each_pixel(resolve, &self.resolve, groups, Some(&self.resolve_group));
        match &self.after {
            After::Nothing => {}
            After::Shade(shade) => shade.record(recording, groups),
            After::Composite(composite) => composite.record(recording, groups),
        }
    }

    /// Heads, nodes and tail.
    pub(super) fn bytes(&self) -> u64 {
        self.heads.size() + self.nodes.size() + self.tail.iter().map(Target::bytes).sum::<u64>()
    }
}
