//! Sheer on a device, in an encoder and into a texture of a program's own: `examples/own_device.rs`.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::{
    Arc,
    atomic::{AtomicU32, Ordering},
};

use glam::{Affine3A, Vec3};
use sheer_gpu::{
    Gpu, GpuError, GpuPath, GpuPathChoice, GpuPipeline, GpuStage, Needs, Picture,
    wgpu::{self, Features, Limits, TextureFormat},
};
use sheer_image::Planes;
use sheer_lab::picture;
use sheer_render::{Antialiasing, Background, Method, Settings, Stage, backend::Cpu};
use sheer_scene::{
    CameraChoice, Scene,
    camera::Camera,
    model::{Instance, Material, Mesh, ShadingModel},
};

#[expect(dead_code, reason = "the program's `main` is not run here")]
#[path = "../../examples/own_device.rs"]
mod program;

use program::{BACKGROUND_RGB, FRAMES, Program, SIZE, TRIANGLE, TRIANGLE_RGB, VIEW, glass};

/// As in `twin.rs`: colours differ by no more than half floats do, twice; few pixels are edges.
const COLOUR: f32 = 1.0 / 1024.0;
const COLOUR_SHARE: f64 = 0.002;
/// From here on no edge is met by any of the jittered samples.
const REACH_PX: f32 = 1.0;

fn method(text: &str) -> Method {
    text.parse().unwrap()
}

/// The program's picture, with its half floats as floats.
fn read(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<[f32; 4]> {
    let [width, height] = SIZE;
    let bytes_per_row = (8 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let device = gpu.device();
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(bytes_per_row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(bytes_per_row), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    gpu.queue().submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let bytes = buffer.get_mapped_range(..).unwrap();
    let half = |bytes: &[u8]| float_of_half(u16::from_le_bytes([bytes[0], bytes[1]]));
    let rows = bytes.chunks_exact(bytes_per_row as usize);
    rows.flat_map(|row| row[..8 * width as usize].chunks_exact(8))
        .map(|pixel| [0, 2, 4, 6].map(|at| half(&pixel[at..])))
        .collect()
}

/// IEEE 754 binary16, of numbers that are finite.
fn float_of_half(bits: u16) -> f32 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    assert!(exponent < 31, "no number");
    let magnitude = if exponent == 0 {
        fraction / 1024.0 * 2.0_f32.powi(-14)
    } else {
        (1.0 + fraction / 1024.0) * 2.0_f32.powi(exponent - 15)
    };
    sign * magnitude
}

/// The same by `sheer render`: the glass and the triangle in one scene, on the CPU.
fn on_cpu(triangle_rgb: [f32; 3]) -> (Stage, Planes) {
    let mut parts = glass();
    let mesh = parts.meshes.len() as u32;
    parts.meshes.push(Mesh {
        material: parts.materials.len() as u32,
        positions: TRIANGLE.map(Vec3::from).to_vec(),
        indices: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    parts.instances.push(Instance {
        mesh,
        id: mesh,
        node_from_object: Affine3A::IDENTITY,
        ..Instance::default()
    });
    parts.materials.push(Material {
        model: ShadingModel::Luminous,
        base_colour: Vec3::from(triangle_rgb).extend(1.0),
        ..Material::default()
    });
    let camera = CameraChoice::Own(Camera::still("view", VIEW.pose(SIZE).unwrap()));
    let mut stage = Stage::new(Arc::new(Scene::new(parts).unwrap()), &camera, None).unwrap();
    let background = Background::Colour(BACKGROUND_RGB.into());
    let settings = Settings { size: SIZE, background, ..Settings::default() };
    let antialiasing = Antialiasing::LAYERED;
    let planes = picture(&Cpu, &mut stage, &method("joint"), antialiasing, settings, FRAMES).unwrap().0;
    (stage, planes)
}

/// How many of some pixels differ by more than [`COLOUR`].
#[derive(Debug, Default)]
struct Difference {
    pixels: usize,
    others: usize,
}

impl Difference {
    fn share(&self) -> f64 {
        self.others as f64 / self.pixels as f64
    }
}

fn differing(expected: &Planes, found: &[[f32; 4]], counts: impl Fn((u32, u32)) -> bool) -> Difference {
    let mut difference = Difference::default();
    for (at, (expected, found)) in (0..).zip(expected.colour.as_slice().iter().zip(found)) {
        if counts((at % SIZE[0], at / SIZE[0])) {
            let is_other = expected.iter().zip(found).any(|(a, b)| (a - b).abs() > COLOUR);
            difference.pixels += 1;
            difference.others += usize::from(is_other);
        }
    }
    difference
}

#[test]
fn a_triangle_and_glass_of_a_programs_own_are_what_sheer_render_shows() {
    let program = Program::new(&method("joint")).unwrap();
    let (stage, expected) = on_cpu(TRIANGLE_RGB);
    let (_, darker) = on_cpu(TRIANGLE_RGB.map(|value| 0.99 * value));
    let is_inside = |pixel| !stage.is_near_edge(pixel, SIZE, REACH_PX);
    for path in [GpuPathChoice::Raster, GpuPathChoice::Ray] {
        assert_eq!(program.run(method("joint"), path).unwrap(), 0, "somebody waited for the device");
        let found = read(&program.gpu, &program.picture);
        let all = differing(&expected, &found, |_| true);
        let inside = differing(&expected, &found, is_inside);
        assert!(inside.pixels > found.len() / 2, "{path:?}: {inside:?}");
        let shows_same = all.share() <= COLOUR_SHARE && inside.others == 0;
        assert!(shows_same, "{path:?}: {all:?}, away from edges {inside:?}");
        // Negative control: a triangle that is hardly darker is another picture.
        let inside = differing(&darker, &found, is_inside);
        assert!(inside.share() > 0.05, "{path:?}: {inside:?}");
    }
}

/// A device with these features and limits.
fn open(features: Features, limits: Limits) -> (wgpu::Adapter, wgpu::Device, wgpu::Queue) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).unwrap();
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: features,
        required_limits: limits,
        ..wgpu::DeviceDescriptor::default()
    }))
    .unwrap();
    (adapter, device, queue)
}

fn std_on(gpu: &Arc<Gpu>, size: [u32; 2]) -> Result<GpuPipeline, GpuError> {
    let settings = Settings { size, ..Settings::default() };
    GpuPipeline::new(gpu, GpuPathChoice::Raster, method("std"), Antialiasing::TAA, settings)
}

#[test]
fn what_a_device_was_opened_without_is_told_by_name() {
    let (adapter, device, queue) = open(Features::empty(), Limits::default());
    let error = Gpu::from_wgpu(&adapter, device, queue).unwrap_err();
    assert!(matches!(error, GpuError::Lacks { .. }), "{error}");
    let error = error.to_string();
    assert!(error.contains("max_storage_buffers_per_shader_stage") && error.contains("has 8"), "{error}");

    let needs = Needs::of(&method("moments"), GpuPath::Raster).unwrap();
    let (adapter, device, queue) = open(needs.features - Features::FLOAT32_BLENDABLE, needs.limits);
    let gpu = Gpu::from_wgpu(&adapter, device, queue).unwrap();
    let settings = Settings { size: [16, 9], ..Settings::default() };
    let refused =
        GpuPipeline::new(&gpu, GpuPathChoice::Raster, method("moments"), Antialiasing::NONE, settings);
    let error = refused.unwrap_err().to_string();
    assert!(error.contains("without FLOAT32_BLENDABLE;"), "{error}");
}

/// The texture of a program, for pictures of std.
fn target(device: &wgpu::Device, format: TextureFormat, [width, height]: [u32; 2]) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Records and submits a frame.
fn frame(
    pipeline: &mut GpuPipeline,
    stage: &mut GpuStage,
    index: u32,
    view: &wgpu::TextureView,
) -> Result<(), GpuError> {
    let gpu = Arc::clone(stage.gpu());
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    pipeline.record(&mut encoder, stage, index, &Picture::new(view))?;
    gpu.queue().submit([encoder.finish()]);
    Ok(())
}

#[test]
fn a_programs_device_keeps_its_callbacks_and_compiles_nothing_twice() {
    let needs = Needs::of(&method("std"), GpuPath::Raster).unwrap();
    let (adapter, device, queue) = open(needs.features, needs.limits);
    // The program's own callbacks, set before: they hear of no error of Sheer's, and of the loss.
    let [errors, losses] = [(); 2].map(|()| Arc::new(AtomicU32::new(0)));
    let count = Arc::clone(&errors);
    device.on_uncaptured_error(Arc::new(move |_| {
        count.fetch_add(1, Ordering::Relaxed);
    }));
    let count = Arc::clone(&losses);
    device.set_device_lost_callback(move |_, _| {
        count.fetch_add(1, Ordering::Relaxed);
    });
    let gpu = Gpu::from_wgpu(&adapter, device.clone(), queue).unwrap();
    let mut stage =
        GpuStage::new(&gpu, Scene::new(glass()).unwrap(), &CameraChoice::Default, Some(1)).unwrap();
    let error = std_on(&gpu, [60_000, 60_000]).unwrap_err();
    assert!(matches!(error, GpuError::Limit { .. }), "{error}");

    // A format that takes fewer bits, and one of a swapchain; both in other sizes.
    let mut pipeline = std_on(&gpu, [16, 9]).unwrap();
    for (index, format) in (0..).zip([TextureFormat::Rgba16Float, TextureFormat::Bgra8UnormSrgb]) {
        frame(&mut pipeline, &mut stage, index, &target(&device, format, [20, 8])).unwrap();
    }
    let compiled = gpu.pipelines_compiled();
    assert!(compiled > 0);
    pipeline.resize([32, 18]).unwrap();
    pipeline.reset_history();
    let view = target(&device, TextureFormat::Rgba16Float, [32, 18]);
    frame(&mut pipeline, &mut stage, 2, &view).unwrap();
    let mut same = std_on(&gpu, [32, 18]).unwrap();
    frame(&mut same, &mut stage, 0, &view).unwrap();
    assert_eq!(gpu.pipelines_compiled(), compiled, "a size or a switch of methods has compiled something");
    assert_eq!(same.planes().unwrap().colour.size(), (32, 18));

    // What a program does wrong is told it: a format that floats cannot be drawn to.
    let view = target(&device, TextureFormat::Rgba8Uint, [32, 18]);
    let error = frame(&mut same, &mut stage, 1, &view).unwrap_err();
    assert!(matches!(error, GpuError::Refused { .. }), "{error}");
    assert_eq!(errors.load(Ordering::Relaxed), 0, "an error of Sheer's went to the program's callback");

    device.destroy();
    let view = target(&device, TextureFormat::Rgba16Float, [32, 18]);
    for _ in 0..2 {
        let error = frame(&mut same, &mut stage, 2, &view).unwrap_err();
        assert!(matches!(error, GpuError::DeviceLost { .. }), "{error}");
    }
    assert_eq!(gpu.generation(), 0);
    device.poll(wgpu::PollType::Poll).ok();
    assert_eq!(losses.load(Ordering::Relaxed), 1, "the program's callback was replaced");
}
