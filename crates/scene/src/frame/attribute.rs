//! Vertex attributes at the corners of a triangle, and between them.

use glam::{Vec2, Vec4};

use super::storage::MorphedAttributes;
use crate::model::Mesh;

/// Corners of a particle quad's two triangles in its tile, lower left first: they run counter-clockwise seen
/// from the camera.
pub(super) const QUAD_UVS: [[Vec2; 3]; 2] = [[Vec2::Y, Vec2::ONE, Vec2::X], [Vec2::Y, Vec2::X, Vec2::ZERO]];

/// Colours and texture coordinates of a mesh's vertices at the moment.
#[derive(Clone, Copy)]
pub(super) struct VertexLists<'a> {
    pub(super) colours: &'a [Vec4],
    uv_sets: &'a [Vec<Vec2>],
}

impl<'a> VertexLists<'a> {
    /// The mesh's own but for those that are morphed.
    pub(super) fn new(mesh: &'a Mesh, morphed: Option<&'a MorphedAttributes>) -> Self {
        let own = Self { colours: &mesh.colours, uv_sets: &mesh.uv_sets };
        let Some(MorphedAttributes { colours, uv_sets }) = morphed else { return own };
        Self {
            colours: if colours.is_empty() { own.colours } else { colours },
            uv_sets: if uv_sets.is_empty() { own.uv_sets } else { uv_sets },
        }
    }

    /// Texture coordinates of three vertices; (0, 0) where the mesh lacks the set.
    pub(super) fn corner_uvs(&self, vertices: [usize; 3], uv_set: u32) -> [Vec2; 3] {
        let set = self.uv_sets.get(uv_set as usize);
        set.map_or([Vec2::ZERO; 3], |set| vertices.map(|vertex| set[vertex]))
    }
}

/// The entries of three vertices; none of an empty list.
pub(super) fn gather<T: Copy>(list: &[T], vertices: [usize; 3]) -> Option<[T; 3]> {
    (!list.is_empty()).then(|| vertices.map(|vertex| list[vertex]))
}

/// The mean of three values by barycentric weights.
pub(super) fn mix<T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(
    weights: [f32; 3],
    [a, b, c]: [T; 3],
) -> T {
    a * weights[0] + b * weights[1] + c * weights[2]
}
