//! A frame's lists as they are stored, for whoever copies them elsewhere: to a GPU, say. What never moves
//! stands first in each.

use glam::{Mat3, Vec2, Vec3, Vec4};

use crate::model::{AlphaMode, Material, TextureRef};

/// The triangle is opaque all over and has no [`TriangleOpacity`].
pub const OPAQUE: u32 = 1 << 31;
/// The back of the triangle is not there for camera rays.
pub const SINGLE_SIDED: u32 = 1 << 30;
/// The triangle belongs to a mirrored object: its front is the side that sees its vertices clockwise.
pub const MIRRORED: u32 = 1 << 29;
/// The material transmits light in its colour.
pub const TINTED: u32 = 1 << 28;
/// The bits of a triangle's word that are an index into [`Frame::opacities`](super::Frame::opacities).
pub const SLOT: u32 = TINTED - 1;
/// Stands for the index of a texture where there is none.
pub const NO_TEXTURE: u32 = u32::MAX;

/// A thing with an identity: one primitive of one instance, or one particle quad.
#[derive(Clone, Debug)]
pub struct Object {
    /// Identity of the instance or particle, stable over time: `InstanceID()` of STD Listing 4.
    pub id: u32,
    /// Which primitive of the instance it is: `GeometryIndex()` of STD Listing 4.
    pub geometry: u32,
    /// Index into the scene's materials.
    pub material: u32,
    /// Number of its first triangle; the others follow.
    pub first_triangle: u32,
    pub(super) look: Look,
}

/// Where an object's vertex attributes come from.
#[derive(Clone, Debug)]
pub enum Look {
    /// The mesh's own, moved rigidly (or at least affinely).
    Rigid {
        /// Index into the scene's meshes.
        mesh: u32,
        /// Takes normals along, up to their length.
        normal_from_object: Mat3,
        /// Takes vectors to world.
        vector_from_object: Mat3,
    },
    /// A skinned or morphed mesh.
    Deformed {
        /// Index into the scene's meshes.
        mesh: u32,
        /// Its vertices' normals lie in [`Frame::deformed_normals`](super::Frame::deformed_normals) from here
        /// on, behind them, where the mesh has tangents, as many directions of these; none if `None`.
        first_normal: Option<u32>,
        /// Index into [`Frame::morphed_attributes`](super::Frame::morphed_attributes) of a mesh that morphs
        /// colours or texture coordinates.
        attributes: Option<u32>,
    },
    /// A particle quad, which carries its attributes itself.
    Quad {
        /// Unit axis in world in which the tile's u grows.
        right: Vec3,
        /// Unit axis in world in which the tile's v falls.
        up: Vec3,
        /// Upper left corner of its tile, texture coordinates.
        tile_origin: Vec2,
        /// Width and height of its tile, texture coordinates.
        tile_size: Vec2,
        /// Linear factor on the base colour.
        tint: Vec3,
    },
}

/// Vertex attributes of a morphed mesh that are not the mesh's own at the moment; empty lists are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphedAttributes {
    /// As [`Mesh::colours`](crate::model::Mesh::colours).
    pub colours: Vec<Vec4>,
    /// As [`Mesh::uv_sets`](crate::model::Mesh::uv_sets): all of them, if any is morphed.
    pub uv_sets: Vec<Vec<Vec2>>,
}

impl Look {
    /// World units a unit of the mesh, the mean of all directions; 1 where it is bent.
    pub(super) fn scale(&self) -> f32 {
        match self {
            Self::Rigid { vector_from_object, .. } => vector_from_object.determinant().abs().cbrt(),
            Self::Deformed { .. } | Self::Quad { .. } => 1.0,
        }
    }
}

/// What the any-hit test reads, gathered a triangle: 56 bytes instead of a walk through object, mesh and
/// material.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct TriangleOpacity {
    /// Texture coordinates of the three vertices, the texture's transform included.
    pub uv: [Vec2; 3],
    /// Factor at each vertex.
    pub alpha: [f32; 3],
    /// Index into the scene's textures, or [`NO_TEXTURE`].
    pub texture: u32,
    /// Alpha test; negative: none.
    pub cutoff: f32,
    /// Factor after the alpha test.
    pub opacity: f32,
    /// Texels of the texture along a world unit: a footprint of so many units times this is one in texels.
    pub texel_density: f32,
    /// Fills the size up to a multiple of 8, as a GPU has it.
    pub padding: u32,
}

/// How many entries of a frame's lists never change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StaticCounts {
    /// Length of what never changes in [`Frame::triangles`](super::Frame::triangles),
    /// [`Frame::triangle_objects`](super::Frame::triangle_objects) and
    /// [`Frame::opacity_slots`](super::Frame::opacity_slots).
    pub triangles: usize,
    /// Length of what never changes in [`Frame::objects`](super::Frame::objects).
    pub objects: usize,
    /// Length of what never changes in [`Frame::opacities`](super::Frame::opacities).
    pub opacities: usize,
    /// Length of what never moves in [`Frame::instances`](super::Frame::instances).
    pub instances: usize,
}

impl TriangleOpacity {
    /// Gathers what a material and its corners say: alpha at each vertex, `uvs` for the texture it uses, and
    /// for these coordinates the density of the texture's texels.
    pub(super) fn new(
        material: &Material,
        vertex_alpha: [f32; 3],
        uvs: impl Fn(&TextureRef) -> [Vec2; 3],
        density: impl Fn(&[Vec2; 3], u32) -> f32,
    ) -> Self {
        let opaque = material.alpha_mode == AlphaMode::Opaque;
        let texture = material.base_colour_texture.filter(|_| !opaque);
        let uv =
            texture.map_or([Vec2::ZERO; 3], |used| uvs(&used).map(|uv| used.transform.transform_point2(uv)));
        Self {
            uv,
            alpha: if opaque { [1.0; 3] } else { vertex_alpha.map(|alpha| alpha * material.base_colour.w) },
            texture: texture.map_or(NO_TEXTURE, |used| used.texture),
            cutoff: if let AlphaMode::Mask { cutoff } = material.alpha_mode { cutoff.max(0.0) } else { -1.0 },
            opacity: material.opacity,
            texel_density: texture.map_or(0.0, |used| density(&uv, used.texture)),
            padding: 0,
        }
    }
}
