//! A frame's lists as they are stored, for whoever copies them elsewhere: to a GPU, say. What never moves stands first in each.

use glam::{Mat3, Vec2, Vec3};

use super::{Frame, Object};

/// The triangle is opaque all over and has no [`TriangleOpacity`].
pub const OPAQUE: u32 = 1 << 31;
/// Its back is not there for camera rays.
pub const SINGLE_SIDED: u32 = 1 << 30;
/// Its object is mirrored: its front is the side that sees its vertices clockwise.
pub const MIRRORED: u32 = 1 << 29;
/// Its material transmits light in its colour.
pub const TINTED: u32 = 1 << 28;
/// The bits of a triangle's word that are an index into [`Frame::opacities`].
pub const SLOT: u32 = TINTED - 1;
/// In place of a texture's index: none.
pub const NO_TEXTURE: u32 = u32::MAX;

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
        /// Its vertices' normals lie in [`Frame::deformed_normals`] from here on; none if `None`.
        first_normal: Option<u32>,
    },
    /// A particle quad.
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

/// What the any-hit test reads, gathered a triangle: 48 bytes instead of a walk through object, mesh and material.
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
}

/// How many entries of a frame's lists never change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StaticCounts {
    /// Of [`Frame::triangles`], [`Frame::triangle_objects`] and [`Frame::opacity_slots`].
    pub triangles: usize,
    /// Of [`Frame::objects`].
    pub objects: usize,
    /// Of [`Frame::opacities`].
    pub opacities: usize,
}

impl Object {
    /// Where its vertex attributes come from.
    #[must_use]
    pub fn look(&self) -> &Look {
        &self.look
    }
}

impl Frame {
    /// How much of each list never changes.
    #[must_use]
    pub fn static_counts(&self) -> StaticCounts {
        self.static_counts
    }

    /// Where the triangles from [`Self::static_count`] on were in the previous frame, world.
    #[must_use]
    pub fn previous_moving(&self) -> &[[Vec3; 3]] {
        &self.previous_moving
    }

    /// Each triangle's index into [`Self::objects`].
    #[must_use]
    pub fn triangle_objects(&self) -> &[u32] {
        &self.triangle_object
    }

    /// All objects.
    #[must_use]
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Each triangle's flags ([`OPAQUE`], [`SINGLE_SIDED`], [`MIRRORED`], [`TINTED`]), and in the bits of [`SLOT`] its index into
    /// [`Self::opacities`] unless it is opaque.
    #[must_use]
    pub fn opacity_slots(&self) -> &[u32] {
        &self.opacity_slot
    }

    /// The opacities of all triangles that are not opaque.
    #[must_use]
    pub fn opacities(&self) -> &[TriangleOpacity] {
        &self.opacities
    }

    /// World normals of the vertices of skinned and morphed meshes; see [`Look::Deformed`].
    #[must_use]
    pub fn deformed_normals(&self) -> &[Vec3] {
        &self.deformed_normals
    }
}
