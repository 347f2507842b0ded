//! Scene records as shaders read them: `shaders/shared/scene.wgsl` declares the same structs, and a test compares the two through naga.
//!
//! A WGSL `vec3f` takes 12 bytes but starts at a multiple of 16, so that each is followed by a scalar here.

use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Vec2, Vec3};
use sheer_scene::{
    FrameLight, Look, Object as FrameObject,
    environment::Lobe as EnvironmentLobe,
    model::{
        Filter, LightKind, Material as SceneMaterial, Mesh, ShadingModel, Texture as SceneTexture,
        TextureRef, Wrap,
    },
};

use super::atlas::Region;

/// In place of an index or offset: there is none.
pub const NONE: u32 = u32::MAX;

/// Numbers of [`Object::look`].
const LOOK_RIGID: u32 = 0;
const LOOK_DEFORMED: u32 = 1;
const LOOK_QUAD: u32 = 2;

/// Numbers of [`Light::kind`].
const LIGHT_DIRECTIONAL: u32 = 0;
const LIGHT_POINT: u32 = 1;
const LIGHT_SPOT: u32 = 2;

/// Indices into [`Material::textures`]. The normal comes last: it replaces what the others multiply.
const TEXTURE_BASE_COLOUR: usize = 0;
const TEXTURE_METALLIC_ROUGHNESS: usize = 1;
const TEXTURE_EMISSIVE: usize = 2;
const TEXTURE_OCCLUSION: usize = 3;
const TEXTURE_NORMAL: usize = 4;
const TEXTURE_COUNT: usize = 5;

/// The numbers that shaders know the records' choices by, to be emitted as WGSL constants.
pub const CONSTANTS: &[(&str, u32)] = &[
    ("NONE", NONE),
    ("LOOK_RIGID", LOOK_RIGID),
    ("LOOK_DEFORMED", LOOK_DEFORMED),
    ("LOOK_QUAD", LOOK_QUAD),
    ("LIGHT_DIRECTIONAL", LIGHT_DIRECTIONAL),
    ("LIGHT_POINT", LIGHT_POINT),
    ("LIGHT_SPOT", LIGHT_SPOT),
    ("TEXTURE_BASE_COLOUR", TEXTURE_BASE_COLOUR as u32),
    ("TEXTURE_METALLIC_ROUGHNESS", TEXTURE_METALLIC_ROUGHNESS as u32),
    ("TEXTURE_EMISSIVE", TEXTURE_EMISSIVE as u32),
    ("TEXTURE_OCCLUSION", TEXTURE_OCCLUSION as u32),
    ("TEXTURE_NORMAL", TEXTURE_NORMAL as u32),
    ("TEXTURE_COUNT", TEXTURE_COUNT as u32),
    ("MODEL_METALLIC_ROUGHNESS", ShadingModel::MetallicRoughness as u32),
    ("MODEL_UNLIT", ShadingModel::Unlit as u32),
    ("MODEL_SMOKE", ShadingModel::Smoke as u32),
    ("MODEL_FIBRE", ShadingModel::Fibre as u32),
    ("WRAP_REPEAT", Wrap::Repeat as u32),
    ("WRAP_MIRRORED_REPEAT", Wrap::MirroredRepeat as u32),
    ("WRAP_CLAMP_TO_EDGE", Wrap::ClampToEdge as u32),
    ("FILTER_LINEAR", Filter::Linear as u32),
    ("FILTER_NEAREST", Filter::Nearest as u32),
];

/// What the any-hit test reads: as the frame stores it.
pub(crate) type Opacity = sheer_scene::TriangleOpacity;

/// Where a mesh's lists lie in the attribute and index buffers.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MeshOffsets {
    /// Of its first triangle, in indices.
    pub first_index: u32,
    pub vertex_count: u32,
    /// Offsets into the attributes, in floats: three a vertex.
    pub positions: u32,
    /// Three a vertex, or [`NONE`].
    pub normals: u32,
    /// Four a vertex, or [`NONE`].
    pub tangents: u32,
    /// Four a vertex, or [`NONE`].
    pub colours: u32,
    /// Two a vertex, set after set.
    pub uv_sets: u32,
    pub uv_set_count: u32,
}

impl MeshOffsets {
    /// Of a quad, which has no mesh.
    const NOWHERE: Self = Self {
        first_index: 0,
        vertex_count: 0,
        positions: NONE,
        normals: NONE,
        tangents: NONE,
        colours: NONE,
        uv_sets: 0,
        uv_set_count: 0,
    };

    /// Appends a mesh's lists to the buffers' contents.
    pub(crate) fn append(mesh: &Mesh, attributes: &mut Vec<f32>, indices: &mut Vec<u32>) -> Self {
        let first_index = indices.len() as u32;
        indices.extend(mesh.indices.as_flattened());
        let mut list = |floats: &[f32]| {
            let offset = attributes.len() as u32;
            attributes.extend_from_slice(floats);
            if floats.is_empty() { NONE } else { offset }
        };
        let offsets = Self {
            first_index,
            vertex_count: mesh.positions.len() as u32,
            positions: list(bytemuck::cast_slice(&mesh.positions)),
            normals: list(bytemuck::cast_slice(&mesh.normals)),
            tangents: list(bytemuck::cast_slice(&mesh.tangents)),
            colours: list(bytemuck::cast_slice(&mesh.colours)),
            uv_sets: attributes.len() as u32,
            uv_set_count: mesh.uv_sets.len() as u32,
        };
        mesh.uv_sets.iter().for_each(|set| attributes.extend_from_slice(bytemuck::cast_slice(set)));
        offsets
    }
}

/// An object, and where its vertex attributes come from.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Object {
    pub id: u32,
    pub geometry: u32,
    pub material: u32,
    pub first_triangle: u32,
    /// [`LOOK_RIGID`], …
    pub look: u32,
    /// Of a deformed mesh: its first entry in the deformed normals, or [`NONE`].
    pub first_deformed_normal: u32,
    pub mesh: MeshOffsets,
    /// Rigid: columns of `normal_from_object`, then of `vector_from_object`. Quad: right, up, tile origin, tile size, tint, and nothing.
    /// Scalars, since 100,000 quads move every frame and columns of `vec3f` would take a third more.
    pub axes: [f32; 18],
}

impl Object {
    pub(crate) fn new(object: &FrameObject, meshes: &[MeshOffsets]) -> Self {
        let mut record = Self {
            id: object.id,
            geometry: object.geometry,
            material: object.material,
            first_triangle: object.first_triangle,
            look: LOOK_QUAD,
            first_deformed_normal: NONE,
            mesh: MeshOffsets::NOWHERE,
            axes: [0.0; 18],
        };
        match *object.look() {
            Look::Rigid { mesh, normal_from_object, vector_from_object } => {
                record.look = LOOK_RIGID;
                record.mesh = meshes[mesh as usize];
                let columns = |matrix: &Mat3| matrix.to_cols_array();
                record.axes[..9].copy_from_slice(&columns(&normal_from_object));
                record.axes[9..].copy_from_slice(&columns(&vector_from_object));
            }
            Look::Deformed { mesh, first_normal } => {
                record.look = LOOK_DEFORMED;
                record.mesh = meshes[mesh as usize];
                record.first_deformed_normal = first_normal.unwrap_or(NONE);
            }
            Look::Quad { right, up, tile_origin, tile_size, tint } => {
                record.axes[..3].copy_from_slice(&right.to_array());
                record.axes[3..6].copy_from_slice(&up.to_array());
                record.axes[6..8].copy_from_slice(&tile_origin.to_array());
                record.axes[8..10].copy_from_slice(&tile_size.to_array());
                record.axes[10..13].copy_from_slice(&tint.to_array());
            }
        }
        record
    }
}

/// A material's use of a texture.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct TextureUse {
    /// Columns of `texture_from_mesh_uv`.
    pub x_axis: Vec2,
    pub y_axis: Vec2,
    pub translation: Vec2,
    /// Index into the textures, or [`NONE`].
    pub texture: u32,
    pub uv_set: u32,
}

impl TextureUse {
    fn new(used: Option<&TextureRef>) -> Self {
        let of = |used: &TextureRef| Self {
            x_axis: used.transform.matrix2.x_axis,
            y_axis: used.transform.matrix2.y_axis,
            translation: used.transform.translation,
            texture: used.texture,
            uv_set: used.uv_set,
        };
        used.map_or(Self { texture: NONE, ..Self::zeroed() }, of)
    }
}

/// A material, but for what [`Opacity`] holds of it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Material {
    pub base_colour: Vec3,
    /// The shading model's number.
    pub model: u32,
    pub emissive: Vec3,
    pub metallic: f32,
    pub roughness: f32,
    pub transmission: f32,
    pub normal_scale: f32,
    pub occlusion_strength: f32,
    /// By `TEXTURE_BASE_COLOUR`, …: a list, so that a shader samples in one place; drivers that inline
    /// everything take half a minute to compile five copies.
    pub textures: [TextureUse; TEXTURE_COUNT],
}

impl Material {
    pub(crate) fn new(material: &SceneMaterial) -> Self {
        let mut textures = [None; TEXTURE_COUNT];
        textures[TEXTURE_BASE_COLOUR] = material.base_colour_texture;
        textures[TEXTURE_METALLIC_ROUGHNESS] = material.metallic_roughness_texture;
        textures[TEXTURE_EMISSIVE] = material.emissive_texture;
        textures[TEXTURE_OCCLUSION] = material.occlusion_texture;
        textures[TEXTURE_NORMAL] = material.normal_texture;
        Self {
            base_colour: material.base_colour.truncate(),
            model: material.model as u32,
            emissive: material.emissive,
            metallic: material.metallic,
            roughness: material.roughness,
            transmission: material.transmission,
            normal_scale: material.normal_scale,
            occlusion_strength: material.occlusion_strength,
            textures: textures.map(|used| TextureUse::new(used.as_ref())),
        }
    }
}

/// A texture: where it lies in the atlas and how it is looked up.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Texture {
    /// Of its upper left texel in its layer.
    pub origin: [u32; 2],
    /// Width and height, texels.
    pub size: [u32; 2],
    /// Numbers of the wrap modes in u and v.
    pub wrap: [u32; 2],
    pub layer: u32,
    /// The filter's number.
    pub filtering: u32,
    /// 1 if the colour channels are sRGB-encoded.
    pub srgb: u32,
    pub padding: u32,
}

impl Texture {
    pub(crate) fn new(texture: &SceneTexture, region: Region) -> Self {
        Self {
            origin: region.origin,
            size: [texture.image.width(), texture.image.height()],
            wrap: texture.wrap.map(|wrap| wrap as u32),
            layer: region.layer,
            filtering: texture.filter as u32,
            srgb: u32::from(texture.srgb),
            padding: 0,
        }
    }
}

/// A punctual light at the time of the frame.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Light {
    pub position: Vec3,
    /// [`LIGHT_DIRECTIONAL`], …
    pub kind: u32,
    pub direction: Vec3,
    /// World units, at most the largest float: shaders need not know infinity.
    pub range: f32,
    pub intensity: Vec3,
    /// Cosines of the cone's half angles; of a spot alone.
    pub inner_cosine: f32,
    pub outer_cosine: f32,
    pub padding: [u32; 3],
}

impl Light {
    pub(crate) fn new(light: &FrameLight) -> Self {
        let (kind, range, cone_rad) = match light.kind {
            LightKind::Directional => (LIGHT_DIRECTIONAL, f32::MAX, [0.0; 2]),
            LightKind::Point { range } => (LIGHT_POINT, range, [0.0; 2]),
            LightKind::Spot { range, inner_cone_rad, outer_cone_rad } => {
                (LIGHT_SPOT, range, [inner_cone_rad, outer_cone_rad])
            }
        };
        let [inner_cosine, outer_cosine] = cone_rad.map(f32::cos);
        Self {
            position: light.position,
            kind,
            direction: light.direction,
            range: range.min(f32::MAX),
            intensity: light.intensity,
            inner_cosine,
            outer_cosine,
            padding: [0; 3],
        }
    }
}

/// A lobe of the environment.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Lobe {
    pub direction: Vec3,
    pub sharpness: f32,
    pub radiance: Vec3,
    pub padding: u32,
}

impl Lobe {
    pub(crate) fn new(lobe: &EnvironmentLobe) -> Self {
        Self { direction: lobe.direction, sharpness: lobe.sharpness, radiance: lobe.radiance, padding: 0 }
    }
}
