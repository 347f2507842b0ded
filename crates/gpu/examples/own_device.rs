//! A program with a device, passes and textures of its own: it draws a triangle, Sheer draws two panes of
//! glass that cross each other and the triangle's plane. Sixty-four frames go into a texture of the
//! program's; nothing is read back and nobody waits before the last one.

use std::{error::Error, sync::Arc};

use sheer_gpu::{Gpu, GpuPath, GpuPathChoice, GpuPipeline, GpuStage, Needs, Opaque, Picture, View, wgpu};
use sheer_render::{Antialiasing, Method, Settings};
use sheer_scene::{
    CameraChoice, Scene, SceneParts,
    camera::Camera,
    model::{AlphaMode, Instance, Material, Mesh, Node, ShadingModel},
};

pub(crate) const SIZE: [u32; 2] = [192, 128];
pub(crate) const FRAMES: u32 = 64;
/// What the program draws, counter-clockwise, world; its colour and that of everything behind it are linear.
pub(crate) const TRIANGLE: [[f32; 3]; 3] = [[-0.9, -0.7, 0.0], [0.9, -0.7, 0.0], [0.0, 0.9, 0.0]];
pub(crate) const TRIANGLE_RGB: [f32; 3] = [0.9, 0.5, 0.1];
pub(crate) const BACKGROUND_RGB: [f32; 3] = [0.1, 0.2, 0.3];
/// Three units in front of the triangle; depth is reversed, without a far plane.
pub(crate) const VIEW: View = View {
    world_from_view: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 3.0, 1.0]],
    clip_from_view: [
        [2.0 * 128.0 / 192.0, 0.0, 0.0, 0.0],
        [0.0, 2.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, -1.0],
        [0.0, 0.0, 0.1, 0.0],
    ],
};
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

const TRIANGLE_WGSL: &str = "
    struct Camera { clip_from_view: mat4x4f, corners: array<vec4f, 3>, rgb: vec4f }
    @group(0) @binding(0) var<uniform> camera: Camera;
    @vertex fn vs(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
        return camera.clip_from_view * camera.corners[index];
    }
    @fragment fn fs() -> @location(0) vec4f { return camera.rgb; }";

/// The glass: two panes that lean against each other.
pub(crate) fn glass() -> SceneParts {
    let mut parts = SceneParts { name: "glass".to_owned(), exposure: 1.0, ..SceneParts::default() };
    parts.nodes.push(Node::default());
    for (index, (side, rgba)) in (0..).zip([(1.0, [0.2, 0.6, 1.0, 0.5]), (-1.0, [0.3, 1.0, 0.4, 0.35])]) {
        parts.materials.push(Material {
            model: ShadingModel::Luminous,
            base_colour: rgba.into(),
            alpha_mode: AlphaMode::Blend,
            double_sided: true,
            ..Material::default()
        });
        let corners = [
            [-0.8, -0.6, -0.5 * side],
            [0.8, -0.6, 0.6 * side],
            [0.8, 0.5, 0.6 * side],
            [-0.8, 0.5, -0.5 * side],
        ];
        parts.meshes.push(Mesh {
            material: index,
            positions: corners.map(Into::into).to_vec(),
            indices: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        });
        parts.instances.push(Instance { mesh: index, id: index, ..Instance::default() });
    }
    parts
}

/// The program's own device and what it draws with.
pub(crate) struct Program {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) picture: wgpu::Texture,
    opaque: wgpu::TextureView,
    depth: wgpu::TextureView,
    uniform: wgpu::Buffer,
    group: wgpu::BindGroup,
    draw: wgpu::RenderPipeline,
}

impl Program {
    pub(crate) fn new(method: &Method) -> Result<Self, Box<dyn Error>> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        // What Sheer needs is asked for with what the program needs itself: here nothing.
        let needs = Needs::of(method, GpuPath::Raster)?.and(Needs::of(method, GpuPath::Ray)?);
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            required_features: needs.features,
            required_limits: needs.limits,
            ..wgpu::DeviceDescriptor::default()
        }))?;
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let bound = wgpu::TextureUsages::TEXTURE_BINDING;
        let view = |texture: wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4 * 32,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let source = wgpu::ShaderSource::Wgsl(TRIANGLE_WGSL.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let draw = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                targets: &[Some(COLOUR_FORMAT.into())],
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &draw.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        Ok(Self {
            picture: texture(COLOUR_FORMAT, wgpu::TextureUsages::COPY_SRC),
            opaque: view(texture(COLOUR_FORMAT, bound)),
            depth: view(texture(DEPTH_FORMAT, bound)),
            uniform,
            group,
            draw,
            gpu: Gpu::from_wgpu(&adapter, device, queue)?,
        })
    }

    /// The program's own pass.
    fn draw_triangle(&self, encoder: &mut wgpu::CommandEncoder, [x, y]: [f32; 2]) {
        let mut clip_from_view = VIEW.clip_from_view;
        // The sample of each pixel is moved into its centre.
        clip_from_view[2][0] = 2.0 * x / SIZE[0] as f32;
        clip_from_view[2][1] = -2.0 * y / SIZE[1] as f32;
        let in_view = TRIANGLE.map(|[x, y, z]| [x, y, z - VIEW.world_from_view[3][2], 1.0]);
        let [red, green, blue] = TRIANGLE_RGB;
        let words: Vec<f32> = [&clip_from_view[..], &in_view, &[[red, green, blue, 1.0]]].concat().concat();
        self.gpu.queue().write_buffer(&self.uniform, 0, bytemuck::cast_slice(&words));
        let [r, g, b] = BACKGROUND_RGB.map(f64::from);
        let ops = wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
            store: wgpu::StoreOp::Store,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.opaque,
                depth_slice: None,
                resolve_target: None,
                ops,
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.draw);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// All frames; how often the device was waited for meanwhile.
    pub(crate) fn run(&self, method: Method, choice: GpuPathChoice) -> Result<u64, Box<dyn Error>> {
        let settings = Settings { size: SIZE, ..Settings::default() };
        let mut pipeline = GpuPipeline::with_opaque(
            &self.gpu,
            choice,
            method,
            Antialiasing::LAYERED,
            settings,
            DEPTH_FORMAT,
        )?;
        let camera = CameraChoice::Own(Camera::still("program", VIEW.pose(SIZE)?));
        let mut stage = GpuStage::new(&self.gpu, Scene::new(glass())?, &camera, Some(1))?;
        let view = self.picture.create_view(&wgpu::TextureViewDescriptor::default());
        let opaque = Opaque::new(&self.opaque, &self.depth, VIEW.clip_from_view).still();
        let waits_before = self.gpu.wait_count();
        for index in 0..FRAMES {
            stage.look_through(&VIEW, SIZE)?;
            stage.advance(pipeline.clock().at(index))?;
            let mut encoder =
                self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.draw_triangle(&mut encoder, pipeline.jitter(index));
            pipeline.record_over(&mut encoder, &mut stage, index, &opaque, &Picture::new(&view))?;
            self.gpu.queue().submit([encoder.finish()]);
        }
        Ok(self.gpu.wait_count() - waits_before)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let method: Method = "joint".parse()?;
    let program = Program::new(&method)?;
    let waits = program.run(method, GpuPathChoice::Raster)?;
    eprintln!("{FRAMES} frames on {}; waited {waits} times", program.gpu.description());
    Ok(())
}
