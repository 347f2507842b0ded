//! One device for all tests of this crate, and how a shader of theirs is run on it.

use std::sync::{Arc, LazyLock};

use sheer_render::Method;
use wgpu::{BufferUsages, ShaderStages};

use crate::{
    compile::{compute_pipeline, layout},
    device::{AdapterChoice, Gpu, Tracer},
    pipeline::{base_linker, with_glass},
    resource::bind_group::group_of,
    shader::{
        Linker,
        constant::{self, Constant},
        linked::Linked,
    },
    tables::Tables,
};

/// Floats that the piece probe/surface answers a query with.
pub(super) const ANSWER_LENGTH: usize = 36;

/// The best adapter's device, shared by all tests of the process.
pub(super) static GPU: LazyLock<Arc<Gpu>> = LazyLock::new(|| {
    Gpu::new(&AdapterChoice::Best).expect("the tests need a Vulkan driver: `cargo xtask setup` installs one")
});

/// A device that binds no storage buffer of more bytes than these.
pub(super) fn small_device(max_storage_bytes: u64) -> (wgpu::Device, wgpu::Queue) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).unwrap();
    let required_limits =
        wgpu::Limits { max_storage_buffer_binding_size: max_storage_bytes, ..adapter.limits() };
    let descriptor = wgpu::DeviceDescriptor { required_limits, ..wgpu::DeviceDescriptor::default() };
    pollster::block_on(adapter.request_device(&descriptor)).unwrap()
}

/// Whether the processor stands in for a GPU: its arithmetic is then that of Rust.
pub(super) fn is_software() -> bool {
    GPU.report().kind == "software"
}

/// A piece with all that it imports; rays are traced through our own tree.
pub(super) fn link(piece: &str) -> Linked {
    linker().link(piece).unwrap()
}

/// The same for scenes with coloured glass.
pub(super) fn link_with_glass(piece: &str) -> Linked {
    with_glass(linker()).link(piece).unwrap()
}

fn linker() -> Linker {
    let method: Method = "std".parse().unwrap();
    base_linker(Tracer::Bvh)
        .method(&method)
        .constants(Tables::new(&[], [0, 0]).constants())
        .constants(constant::text(&[Constant::new("ANSWER_LENGTH", ANSWER_LENGTH as u32)]))
}

/// A buffer that holds these bytes, and at least 64, since none may be empty.
pub(super) fn buffer(bytes: &[u8], usage: BufferUsages) -> wgpu::Buffer {
    let usage = usage | BufferUsages::COPY_DST;
    let buffer = crate::resource::buffer::buffer(&GPU.device(), "test", bytes.len().max(64) as u64, usage);
    GPU.queue().write_buffer(&buffer, 0, bytes);
    buffer
}

/// A buffer of so many bytes for a shader's results.
pub(super) fn results(bytes: usize) -> wgpu::Buffer {
    buffer(&vec![0; bytes], BufferUsages::STORAGE | BufferUsages::COPY_SRC)
}

/// The compute pipeline of a test's shader, whose entry point is `cs_probe`.
pub(super) fn pipeline(shader: &Linked, groups: &[&[wgpu::BindGroupLayoutEntry]]) -> wgpu::ComputePipeline {
    let module = GPU.shader(shader).unwrap();
    let layouts: Vec<_> = groups.iter().map(|entries| layout(&GPU, "probe", entries)).collect();
    let layouts: Vec<_> = layouts.iter().collect();
    let pipeline = compute_pipeline(&GPU, "probe", &layouts, &module, "cs_probe");
    GPU.check("a probe").unwrap();
    pipeline
}

/// Runs so many workgroups and reads back what `results` holds then.
pub(super) fn run(
    pipeline: &wgpu::ComputePipeline,
    groups: &[&[wgpu::BindGroupEntry<'_>]],
    workgroups: u32,
    results: &wgpu::Buffer,
) -> Vec<u8> {
    let device = GPU.device();
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        for (index, entries) in (0..).zip(groups) {
            let group = group_of(&device, "probe", &pipeline.get_bind_group_layout(index), entries);
            pass.set_bind_group(index, &group, &[]);
        }
        pass.dispatch_workgroups(workgroups, 1, 1);
    }
    let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
    let copy = crate::resource::buffer::buffer(&device, "copy", results.size(), usage);
    encoder.copy_buffer_to_buffer(results, 0, &copy, 0, results.size());
    GPU.queue().submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
    GPU.wait().unwrap();
    let bytes = copy.get_mapped_range(..).unwrap();
    bytes.to_vec()
}

/// Where tests' shaders run.
pub(super) const COMPUTE: ShaderStages = ShaderStages::COMPUTE;
