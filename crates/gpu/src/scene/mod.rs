//! A scene on the GPU: what never moves is sent once, what moves every frame.

use std::iter;

use glam::Vec3;
use sheer_scene::{Frame, model::MorphTarget};

use self::{atlas::Atlas, records::MorphedOffsets};
use crate::{
    error::GpuError,
    resource::list::{ListBuffer, STORAGE},
    shader::{
        binding::{
            BIND_ATLAS, BIND_ATTRIBUTES, BIND_DEFORMED_NORMALS, BIND_ENVIRONMENT_MAP, BIND_INDICES,
            BIND_LIGHTS, BIND_LOBES, BIND_MATERIALS, BIND_OBJECTS, BIND_OPACITIES, BIND_POSITIONS,
            BIND_PREVIOUS_POSITIONS, BIND_TEXTURES, BIND_TRIANGLES,
        },
        record::scene::{Light, Lobe, Material, MeshOffsets, Object, Opacity, Texture},
    },
};

pub(crate) mod atlas;
mod environment_map;
mod records;

/// How many bindings of group 0 a scene has.
const BINDING_COUNT: usize = 14;
/// Which they are, in the order of [`SceneBuffers::resources`].
const BINDINGS: [u32; BINDING_COUNT] = [
    BIND_POSITIONS,
    BIND_PREVIOUS_POSITIONS,
    BIND_TRIANGLES,
    BIND_OBJECTS,
    BIND_OPACITIES,
    BIND_ATTRIBUTES,
    BIND_INDICES,
    BIND_DEFORMED_NORMALS,
    BIND_MATERIALS,
    BIND_TEXTURES,
    BIND_ATLAS,
    BIND_LIGHTS,
    BIND_LOBES,
    BIND_ENVIRONMENT_MAP,
];

/// The lists of `shaders/shared/scene.wgsl`, filled from a frame.
#[derive(Debug)]
pub struct SceneBuffers {
    positions: ListBuffer,
    previous_positions: ListBuffer,
    triangles: ListBuffer,
    objects: ListBuffer,
    opacities: ListBuffer,
    attributes: ListBuffer,
    indices: ListBuffer,
    deformed_normals: ListBuffer,
    materials: ListBuffer,
    textures: ListBuffer,
    atlas: wgpu::TextureView,
    atlas_bytes: u64,
    lights: ListBuffer,
    lobes: ListBuffer,
    environment_map: wgpu::TextureView,
    environment_map_bytes: u64,
    /// Where each mesh lies in `attributes` and `indices`.
    meshes: Vec<MeshOffsets>,
    /// What `attributes` holds, in a scene that morphs some of it: what is morphed comes after the meshes'.
    morphing: Option<Morphing>,
    /// What `triangles` and `objects` hold: the frame has it in another form.
    triangle_words: Vec<[u32; 2]>,
    object_records: Vec<Object>,
}

/// The contents of a buffer of attributes that grows with each frame.
#[derive(Debug)]
struct Morphing {
    attributes: Vec<f32>,
    /// How many of them are the meshes' own.
    own_count: usize,
}

impl SceneBuffers {
    /// Makes the buffers and the atlas and sends a frame.
    ///
    /// # Errors
    /// [`GpuError::Limit`] names the first list that the device does not allow.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, frame: &Frame) -> Result<Self, GpuError> {
        let parts = frame.scene().parts();
        let (mut attributes, mut indices) = (Vec::new(), Vec::new());
        let meshes = parts
            .meshes
            .iter()
            .map(|mesh| MeshOffsets::append(mesh, &mut attributes, &mut indices))
            .collect();
        let atlas = Atlas::new(frame.scene(), &device.limits())?;
        let materials: Vec<_> = frame.materials().iter().map(Material::new).collect();
        let textures = Texture::all(&parts.textures, &atlas);
        let lobes: Vec<_> = parts.environment.lobes.iter().map(Lobe::new).collect();

        let mut geometry = STORAGE | wgpu::BufferUsages::VERTEX;
        if device.features().contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY) {
            geometry |= wgpu::BufferUsages::BLAS_INPUT;
        }
        let view = wgpu::TextureViewDescriptor {
            label: Some("scene atlas"),
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..wgpu::TextureViewDescriptor::default()
        };
        let environment_map = environment_map::upload(device, queue, frame.scene())?;
        let mut buffers = Self {
            positions: ListBuffer::new::<[Vec3; 3]>(device, "triangle positions", geometry),
            previous_positions: ListBuffer::new::<[Vec3; 3]>(device, "previous positions", STORAGE),
            triangles: ListBuffer::new::<[u32; 2]>(device, "triangle words", STORAGE),
            objects: ListBuffer::new::<Object>(device, "objects", STORAGE),
            opacities: ListBuffer::new::<Opacity>(device, "opacities", STORAGE),
            attributes: ListBuffer::filled(device, queue, "vertex attributes", &attributes)?,
            indices: ListBuffer::filled(device, queue, "vertex indices", &indices)?,
            deformed_normals: ListBuffer::new::<Vec3>(device, "deformed normals", STORAGE),
            materials: ListBuffer::filled(device, queue, "materials", &materials)?,
            textures: ListBuffer::filled(device, queue, "textures", &textures)?,
            atlas: atlas.upload(device, queue, frame.scene()).create_view(&view),
            atlas_bytes: atlas.bytes(),
            lights: ListBuffer::new::<Light>(device, "lights", STORAGE),
            lobes: ListBuffer::filled(device, queue, "environment lobes", &lobes)?,
            environment_map_bytes: environment_map::bytes(&environment_map),
            environment_map: environment_map.create_view(&wgpu::TextureViewDescriptor::default()),
            meshes,
            morphing: None,
            triangle_words: Vec::new(),
            object_records: Vec::new(),
        };
        let morphs = |target: &MorphTarget| {
            !target.colours.is_empty() || target.uv_sets.iter().any(|set| !set.is_empty())
        };
        if parts.meshes.iter().flat_map(|mesh| &mesh.morph_targets).any(morphs) {
            let own_count = attributes.len();
            buffers.morphing = Some(Morphing { attributes, own_count });
        }
        buffers.update(device, queue, frame)?;
        Ok(buffers)
    }

    /// Sends what has moved since the last frame of the same animator. Returns whether a buffer had to grow:
    /// then bind groups that hold it must be made anew.
    ///
    /// # Errors
    /// [`GpuError::Limit`] names the first list that the device does not allow.
    pub fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &Frame,
    ) -> Result<bool, GpuError> {
        let still = frame.static_counts();
        self.triangle_words.truncate(still.triangles);
        let first = self.triangle_words.len();
        let words = iter::zip(&frame.triangle_objects()[first..], &frame.opacity_slots()[first..]);
        self.triangle_words.extend(words.map(|(&object, &slot)| [object, slot]));
        self.object_records.truncate(still.objects);
        let first = self.object_records.len();
        let mut attributes_grew = false;
        let mut morphed = Vec::new();
        if let Some(Morphing { attributes, own_count }) = &mut self.morphing {
            attributes.truncate(*own_count);
            morphed.extend(
                frame.morphed_attributes().iter().map(|lists| MorphedOffsets::append(lists, attributes)),
            );
            attributes_grew = self.attributes.send(device, queue, *own_count, attributes)?;
        }
        let objects =
            frame.objects()[first..].iter().map(|object| Object::new(object, &self.meshes, &morphed));
        self.object_records.extend(objects);
        let materials_grew = if frame.animates_materials() {
            let materials: Vec<_> = frame.materials().iter().map(Material::new).collect();
            self.materials.send(device, queue, 0, &materials)?
        } else {
            false
        };
        let lights: Vec<_> = frame.lights().iter().map(Light::new).collect();

        let grown = [
            attributes_grew,
            materials_grew,
            self.positions.send(device, queue, still.triangles, frame.triangles())?,
            self.previous_positions.send(device, queue, 0, frame.previous_moving())?,
            self.triangles.send(device, queue, still.triangles, &self.triangle_words)?,
            self.objects.send(device, queue, still.objects, &self.object_records)?,
            self.opacities.send(device, queue, still.opacities, frame.opacities())?,
            self.deformed_normals.send(device, queue, 0, frame.deformed_normals())?,
            self.lights.send(device, queue, 0, &lights)?,
        ];
        Ok(grown.contains(&true))
    }

    /// The scene's part of group 0.
    #[must_use]
    pub fn entries(&self) -> [wgpu::BindGroupEntry<'_>; BINDING_COUNT] {
        let resources = self.resources();
        std::array::from_fn(|index| wgpu::BindGroupEntry {
            binding: BINDINGS[index],
            resource: match resources[index] {
                Resource::List(buffer) => buffer.wgpu().as_entire_binding(),
                Resource::Texture(view) => wgpu::BindingResource::TextureView(view),
            },
        })
    }

    /// What [`Self::entries`] fill.
    #[must_use]
    pub fn layout_entries() -> [wgpu::BindGroupLayoutEntry; BINDING_COUNT] {
        std::array::from_fn(|index| wgpu::BindGroupLayoutEntry {
            binding: BINDINGS[index],
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
            ty: match BINDINGS[index] {
                BIND_ATLAS => wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Uint,
                    view_dimension: wgpu::TextureViewDimension::D2Array,
                    multisampled: false,
                },
                BIND_ENVIRONMENT_MAP => wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                _ => wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            },
            count: None,
        })
    }

    /// Nine floats a triangle, world: also the input of an acceleration structure where the device traces
    /// rays, and of a vertex stage.
    #[must_use]
    pub fn positions(&self) -> &wgpu::Buffer {
        self.positions.wgpu()
    }

    /// Bytes of device memory that it all takes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let lists = self.resources().into_iter().map(|resource| match resource {
            Resource::List(buffer) => buffer.bytes(),
            Resource::Texture(_) => 0,
        });
        self.atlas_bytes + self.environment_map_bytes + lists.sum::<u64>()
    }

    /// What is bound, in the order of the bindings.
    fn resources(&self) -> [Resource<'_>; BINDING_COUNT] {
        [
            Resource::List(&self.positions),
            Resource::List(&self.previous_positions),
            Resource::List(&self.triangles),
            Resource::List(&self.objects),
            Resource::List(&self.opacities),
            Resource::List(&self.attributes),
            Resource::List(&self.indices),
            Resource::List(&self.deformed_normals),
            Resource::List(&self.materials),
            Resource::List(&self.textures),
            Resource::Texture(&self.atlas),
            Resource::List(&self.lights),
            Resource::List(&self.lobes),
            Resource::Texture(&self.environment_map),
        ]
    }
}

/// What a binding of the scene holds.
enum Resource<'a> {
    List(&'a ListBuffer),
    Texture(&'a wgpu::TextureView),
}
