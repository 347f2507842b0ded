//! The records of a scene, and the numbers that stand for their choices.
//!
//! A WGSL `vec3f` takes 12 bytes but starts at a multiple of 16, so that each is followed by a scalar here.

use glam::{UVec2, Vec2, Vec3};
use sheer_scene::model::{Filter, LevelFilter, ShadingModel, Wrap};

use crate::shader::declaration::shader_struct;

/// In place of an index or offset: there is none.
pub(crate) const NONE: u32 = u32::MAX;

/// Numbers of [`Object::look`].
pub(crate) const LOOK_RIGID: u32 = 0;
pub(crate) const LOOK_DEFORMED: u32 = 1;
pub(crate) const LOOK_QUAD: u32 = 2;

/// Numbers of [`Light::kind`].
pub(crate) const LIGHT_DIRECTIONAL: u32 = 0;
pub(crate) const LIGHT_POINT: u32 = 1;
pub(crate) const LIGHT_SPOT: u32 = 2;

/// Indices into [`Material::textures`]. The normal comes last of those that are shaded by: it replaces what
/// the others multiply.
pub(crate) const TEXTURE_BASE_COLOUR: usize = 0;
pub(crate) const TEXTURE_METALLIC_ROUGHNESS: usize = 1;
pub(crate) const TEXTURE_EMISSIVE: usize = 2;
pub(crate) const TEXTURE_OCCLUSION: usize = 3;
pub(crate) const TEXTURE_NORMAL: usize = 4;
/// These are looked up wherever a surface is shaded.
pub(crate) const SHADED_TEXTURE_COUNT: usize = 5;
pub(crate) const TEXTURE_THICKNESS: usize = 5;
pub(crate) const TEXTURE_COUNT: usize = 6;

/// The numbers that shaders know the records' choices by, to be emitted as WGSL constants.
pub(crate) const CONSTANTS: &[(&str, u32)] = &[
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
    ("SHADED_TEXTURE_COUNT", SHADED_TEXTURE_COUNT as u32),
    ("TEXTURE_THICKNESS", TEXTURE_THICKNESS as u32),
    ("TEXTURE_COUNT", TEXTURE_COUNT as u32),
    ("MODEL_METALLIC_ROUGHNESS", ShadingModel::MetallicRoughness as u32),
    ("MODEL_UNLIT", ShadingModel::Unlit as u32),
    ("MODEL_SMOKE", ShadingModel::Smoke as u32),
    ("MODEL_FIBRE", ShadingModel::Fibre as u32),
    ("MODEL_LUMINOUS", ShadingModel::Luminous as u32),
    ("WRAP_REPEAT", Wrap::Repeat as u32),
    ("WRAP_MIRRORED_REPEAT", Wrap::MirroredRepeat as u32),
    ("WRAP_CLAMP_TO_EDGE", Wrap::ClampToEdge as u32),
    ("FILTER_LINEAR", Filter::Linear as u32),
    ("FILTER_NEAREST", Filter::Nearest as u32),
    ("LEVELS_LINEAR", LevelFilter::Linear as u32),
    ("LEVELS_NEAREST", LevelFilter::Nearest as u32),
    ("LEVELS_NONE", LevelFilter::None as u32),
];

/// What the any-hit test reads: as the frame stores it.
pub(crate) type Opacity = sheer_scene::TriangleOpacity;

shader_struct! {
    /// What the any-hit test reads of a triangle.
    struct Opacity = sheer_scene::TriangleOpacity {
        /// Of the three vertices, the texture's transform included.
        uv: [Vec2; 3],
        /// Factor at each vertex.
        alpha: [f32; 3],
        /// Index into the textures, or NO_TEXTURE.
        texture: u32,
        /// Alpha test; negative: none.
        cutoff: f32,
        /// Factor after the alpha test.
        opacity: f32,
        /// Texels of the texture along a world unit.
        texel_density: f32,
        /// Fills the size up to a multiple of 8.
        padding: u32,
    }
}

shader_struct! {
    /// Where a mesh's lists lie in the attribute and index buffers.
    struct MeshOffsets {
        /// Where its first triangle begins in the index buffer, in indices.
        first_index: u32,
        /// Vertices of the mesh.
        vertex_count: u32,
        /// Offset into the attributes, in floats: three a vertex.
        positions: u32,
        /// The same, three a vertex, or NONE.
        normals: u32,
        /// The same, four a vertex, or NONE.
        tangents: u32,
        /// The same, four a vertex, or NONE.
        colours: u32,
        /// The same, two a vertex, set after set.
        uv_sets: u32,
        /// Sets of texture coordinates.
        uv_set_count: u32,
    }
}

shader_struct! {
    /// An object, and where its vertex attributes come from.
    struct Object {
        /// InstanceID() of STD Listing 4.
        id: u32,
        /// GeometryIndex() of STD Listing 4.
        geometry: u32,
        /// Index into the materials.
        material: u32,
        /// The first of its triangles among those of the frame.
        first_triangle: u32,
        /// One of the numbers `LOOK_…`.
        look: u32,
        /// Of a deformed mesh: its first entry in the deformed normals, or NONE.
        first_deformed_normal: u32,
        /// Nowhere for a quad, which has no mesh.
        mesh: MeshOffsets,
        /// Rigid: columns of `normal_from_object`, then of `vector_from_object`. Quad: right, up, tile
        /// origin, tile size, tint, and nothing. Scalars, since 100,000 quads move every frame and columns of
        /// `vec3f` would take a third more.
        axes: [f32; 18],
    }
}

shader_struct! {
    /// A material's use of a texture; the first three are `texture_from_mesh_uv`.
    struct TextureUse {
        /// First column of the matrix: what a step in u adds.
        x_axis: Vec2,
        /// Second column of the matrix: what a step in v adds.
        y_axis: Vec2,
        /// Third column of the matrix: where the mesh's origin goes.
        translation: Vec2,
        /// Index into the textures, or NONE.
        texture: u32,
        /// Which set of texture coordinates is looked up by.
        uv_set: u32,
    }
}

shader_struct! {
    /// A material, but for what `Opacity` holds of it. Colours are linear.
    struct Material {
        /// Linear, straight: without its opacity.
        base_colour: Vec3,
        /// One of the numbers `MODEL_…`.
        model: u32,
        /// Radiance that the surface sends out itself, linear.
        emissive: Vec3,
        /// Share, 0 to 1.
        metallic: f32,
        /// Perceptual, 0 to 1.
        roughness: f32,
        /// Share of the light that passes and takes on colour, 0 to 1.
        transmission: f32,
        /// Factor on x and y of a normal map.
        normal_scale: f32,
        /// Share of the occlusion map, 0 to 1.
        occlusion_strength: f32,
        /// What the body under the surface absorbs of red, green and blue a world unit.
        absorption: Vec3,
        /// Of that body, in units of the mesh; 0 without one, or where it absorbs nothing.
        thickness: f32,
        /// By `TEXTURE_BASE_COLOUR`, …: a list, so that a shader samples in one place; drivers that inline
        /// everything take half a minute to compile five copies.
        textures: [TextureUse; TEXTURE_COUNT],
    }
}

shader_struct! {
    /// A texture: where it lies in the atlas and how it is looked up. Its levels have records of their own,
    /// of which only the place counts.
    struct Texture {
        /// Column and row of its upper left texel in its layer.
        origin: UVec2,
        /// Width and height, texels.
        size: UVec2,
        /// Numbers `WRAP_…` in u and v.
        wrap: UVec2,
        /// Index of its layer of the atlas.
        layer: u32,
        /// One of the numbers `FILTER_…`.
        filtering: u32,
        /// 1 if the colour channels are sRGB-encoded.
        srgb: u32,
        /// Of minified texels: one of the numbers `FILTER_…`.
        minified_filtering: u32,
        /// One of the numbers `LEVELS_…`.
        level_filtering: u32,
        /// Index of the record of the first level after the image, which the others follow.
        first_level: u32,
        /// Levels after the image.
        last_level: u32,
        /// Fills the last row.
        padding: u32,
    }
}

shader_struct! {
    /// A punctual light at the time of the frame (`KHR_lights_punctual`).
    struct Light {
        /// World; without meaning for a directional light.
        position: Vec3,
        /// One of the numbers `LIGHT_…`.
        kind: u32,
        /// World, unit length: where the light goes.
        direction: Vec3,
        /// World units, at most the largest float: shaders need not know infinity.
        range: f32,
        /// Linear; at distance 1 of a point or spot.
        intensity: Vec3,
        /// Cosine of half the angle within which a spot is at full strength.
        inner_cosine: f32,
        /// Cosine of half the angle beyond which a spot sheds no light.
        outer_cosine: f32,
        /// Fills the last row.
        padding: [u32; 3],
    }
}

shader_struct! {
    /// A lobe of the environment: a spherical Gaussian, `radiance · exp(sharpness · (cos - 1))` (Wang et al.
    /// 2009).
    struct Lobe {
        /// World, unit length.
        direction: Vec3,
        /// Grows as the lobe becomes narrow.
        sharpness: f32,
        /// Linear, in the middle.
        radiance: Vec3,
        /// Fills the last row.
        padding: u32,
    }
}
