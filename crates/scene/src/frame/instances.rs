//! Instances that share the triangles of their mesh, which a frame then does not copy to world space.
//!
//! Their triangles have numbers as if they were copied, between those that never move and those that do. All
//! that is asked of one is made on the way, by the arithmetic of the copy and so with its bits.

use std::ops::Range;

use glam::{Affine3A, Mat3, Vec2, Vec3};

use super::{
    attribute::{VertexLists, gather},
    deform::normal_matrix,
    storage::{Look, MIRRORED, OPAQUE, Object, SINGLE_SIDED, TINTED, TriangleOpacity},
};
use crate::model::{AlphaMode, Instance, Material, Mesh, SceneParts, TextureRef};

/// Meshes of fewer triangles are copied: an instance takes as much memory by itself, and rays longer to find
/// it.
pub const LEAST_SHARED: usize = 16;

/// Which instances share the triangles of their mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sharing {
    /// Meshes are shared in scenes where this saves as many triangles. Each takes 150 bytes or more with its
    /// part of an acceleration structure, and is hit faster if it lies in world space by itself.
    pub least_saved: u64,
    /// The triangles are copied all the same, in the same order: for a device that cannot do without.
    pub flattened: bool,
}

impl Sharing {
    /// As by default, but copied.
    pub const FLATTENED: Self = Self { least_saved: 1 << 20, flattened: true };

    /// Tells of each instance of the scene whether it shares its triangles, or would if they were not copied.
    /// Those that change otherwise than by moving do not.
    pub(super) fn choose(self, parts: &SceneParts, changes: impl Fn(u32) -> bool) -> Vec<bool> {
        let is_rigid = |index: u32| {
            let instance = &parts.instances[index as usize];
            let mesh = &parts.meshes[instance.mesh as usize];
            !changes(index)
                && instance.skin.is_none()
                && mesh.morph_targets.is_empty()
                && mesh.indices.len() >= LEAST_SHARED
        };
        let indices = 0..parts.instances.len() as u32;
        let mesh_of = |index: u32| parts.instances[index as usize].mesh as usize;
        let mut counts = vec![0_u64; parts.meshes.len()];
        for index in indices.clone().filter(|&index| is_rigid(index)) {
            counts[mesh_of(index)] += 1;
        }
        let saved: u64 = counts
            .iter()
            .zip(&parts.meshes)
            .map(|(&count, mesh)| count.saturating_sub(1) * mesh.indices.len() as u64)
            .sum();
        let worthwhile = saved >= self.least_saved;
        indices.map(|index| worthwhile && is_rigid(index) && counts[mesh_of(index)] > 1).collect()
    }
}

impl Default for Sharing {
    fn default() -> Self {
        Self { least_saved: Self::FLATTENED.least_saved, flattened: false }
    }
}

/// An instance that shares the triangles of its mesh.
#[derive(Clone, Debug)]
pub struct MeshInstance {
    pub(super) object: Object,
    /// Index into the scene's instances.
    pub(super) source: u32,
    mesh: u32,
    world_from_object: Affine3A,
    previous_world_from_object: Affine3A,
    /// As of a triangle that is stored.
    flags: u32,
    /// Index of its mesh's first entry in [`Instances::opacities`].
    first_opacity: u32,
}

impl MeshInstance {
    /// Index into the scene's meshes.
    #[must_use]
    pub fn mesh(&self) -> u32 {
        self.mesh
    }

    /// Where it is; its vertices are in world where `transform_point3` takes those of the mesh.
    #[must_use]
    pub fn world_from_object(&self) -> &Affine3A {
        &self.world_from_object
    }

    /// Number of its first triangle in the frame.
    #[must_use]
    pub fn first_triangle(&self) -> u32 {
        self.object.first_triangle
    }

    pub(super) fn flags(&self) -> u32 {
        self.flags
    }

    /// Corners of a triangle of its mesh, world.
    pub(super) fn corners(&self, mesh: &Mesh, primitive: usize) -> [Vec3; 3] {
        corners(&self.world_from_object, mesh, primitive)
    }

    /// The same in the previous frame.
    pub(super) fn previous_corners(&self, mesh: &Mesh, primitive: usize) -> [Vec3; 3] {
        corners(&self.previous_world_from_object, mesh, primitive)
    }

    /// Whether it is where it was in the previous frame.
    pub(super) fn is_still(&self) -> bool {
        self.world_from_object == self.previous_world_from_object
    }

    /// Takes it from where it was in the previous frame to where it is.
    pub(super) fn move_to(&mut self, previous: Affine3A, world_from_object: Affine3A) {
        self.previous_world_from_object = previous;
        self.world_from_object = world_from_object;
        self.object.look = rigid_look(self.mesh, &world_from_object);
        self.flags = self.flags & !MIRRORED | mirror_flag(&world_from_object);
    }
}

fn corners(world_from_object: &Affine3A, mesh: &Mesh, primitive: usize) -> [Vec3; 3] {
    mesh.indices[primitive].map(|vertex| world_from_object.transform_point3(mesh.positions[vertex as usize]))
}

/// How a mesh looks that an affine map takes to the world.
pub(super) fn rigid_look(mesh: u32, world_from_object: &Affine3A) -> Look {
    let vector_from_object = Mat3::from(world_from_object.matrix3);
    Look::Rigid { mesh, normal_from_object: normal_matrix(vector_from_object), vector_from_object }
}

pub(super) fn mirror_flag(world_from_object: &Affine3A) -> u32 {
    if world_from_object.matrix3.determinant() < 0.0 { MIRRORED } else { 0 }
}

/// The flags that all triangles of a material have.
pub(super) fn material_flags(material: &Material) -> u32 {
    let sides = if material.double_sided { 0 } else { SINGLE_SIDED };
    let opaque = material.alpha_mode == AlphaMode::Opaque && material.opacity >= 1.0;
    sides | tint_flag(material) | if opaque { OPAQUE } else { 0 }
}

pub(super) fn tint_flag(material: &Material) -> u32 {
    if material.transmission > 0.0 { TINTED } else { 0 }
}

/// What the any-hit test reads of a triangle of a mesh, from the density of texels on.
pub(super) fn mesh_opacity(
    material: &Material,
    lists: VertexLists<'_>,
    corners: [u32; 3],
    density: impl Fn(&[Vec2; 3], u32) -> f32,
) -> TriangleOpacity {
    let vertices = corners.map(|corner| corner as usize);
    let alpha = gather(lists.colours, vertices).map_or([1.0; 3], |colours| colours.map(|colour| colour.w));
    let uvs = |used: &TextureRef| lists.corner_uvs(vertices, used.uv_set);
    TriangleOpacity::new(material, alpha, uvs, density)
}

/// All instances of a frame that share the triangles of their mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Instances {
    /// In the order of their triangles.
    list: Vec<MeshInstance>,
    /// Numbers of their triangles.
    numbers: Range<u32>,
    /// Opacities of their meshes' triangles, without the density of texels, which goes by the instance.
    pub(super) opacities: Vec<TriangleOpacity>,
    /// Numbers of triangles are divided by 2 to the power of this to find their instance.
    shift: u32,
    /// Index of the instance in which each of these parts begins.
    starts: Vec<u32>,
}

impl Instances {
    /// Instances of a scene, by index and place, whose triangles have the numbers from `first` on.
    pub(super) fn new(parts: &SceneParts, placed: &[(u32, Affine3A)], first: u32) -> Self {
        let mut instances = Self { numbers: first..first, ..Self::default() };
        let mut first_opacities = vec![None; parts.meshes.len()];
        for &(source, world_from_object) in placed {
            let Instance { mesh: mesh_index, id, geometry, .. } = parts.instances[source as usize];
            let mesh = &parts.meshes[mesh_index as usize];
            let material = &parts.materials[mesh.material as usize];
            let flags = material_flags(material);
            let first_opacity = *first_opacities[mesh_index as usize].get_or_insert_with(|| {
                let first = instances.opacities.len() as u32;
                if flags & OPAQUE == 0 {
                    let lists = VertexLists::new(mesh, None);
                    let entries = mesh.indices.iter();
                    let entries = entries.map(|&corners| mesh_opacity(material, lists, corners, |_, _| 0.0));
                    instances.opacities.extend(entries);
                }
                first
            });
            let look = rigid_look(mesh_index, &world_from_object);
            let first_triangle = instances.numbers.end;
            let object = Object { id, geometry, material: mesh.material, first_triangle, look };
            instances.list.push(MeshInstance {
                object,
                source,
                mesh: mesh_index,
                world_from_object,
                previous_world_from_object: world_from_object,
                flags: flags | mirror_flag(&world_from_object),
                first_opacity,
            });
            instances.numbers.end += mesh.indices.len() as u32;
        }

        // Parts about half as long as an instance is on average: few instances begin in each.
        let mean = instances.numbers.len() / instances.list.len().max(1);
        instances.shift = mean.max(2).ilog2() - 1;
        let part_count = (instances.numbers.len() >> instances.shift) as u32 + 1;
        let begins = |part: u32| first + (part << instances.shift);
        instances.starts =
            (0..part_count).map(|part| instances.search(begins(part), 0..instances.list.len())).collect();
        instances
    }

    pub(super) fn list(&self) -> &[MeshInstance] {
        &self.list
    }

    pub(super) fn list_mut(&mut self) -> &mut [MeshInstance] {
        &mut self.list
    }

    /// Numbers of their triangles.
    pub(super) fn numbers(&self) -> Range<u32> {
        self.numbers.clone()
    }

    /// The instance among some in which a triangle lies: the last that begins before it or with it.
    fn search(&self, triangle: u32, among: Range<usize>) -> u32 {
        let behind =
            self.list[among.clone()].partition_point(|instance| instance.first_triangle() <= triangle);
        (among.start + behind).saturating_sub(1) as u32
    }

    /// The instance to which a triangle of [`Self::numbers`] belongs, and the triangle's index in its mesh.
    pub(super) fn find(&self, triangle: u32) -> (&MeshInstance, usize) {
        let part = ((triangle - self.numbers.start) >> self.shift) as usize;
        let start = self.starts[part] as usize;
        let end = self.starts.get(part + 1).map_or(self.list.len(), |&next| next as usize + 1);
        let instance = &self.list[self.search(triangle, start..end) as usize];
        (instance, (triangle - instance.first_triangle()) as usize)
    }

    /// The opacity of a triangle of an instance's mesh; without the density of texels.
    pub(super) fn opacity(&self, instance: &MeshInstance, primitive: usize) -> &TriangleOpacity {
        &self.opacities[instance.first_opacity as usize + primitive]
    }
}
