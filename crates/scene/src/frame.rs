//! Scene + time → frame: world-space triangles with ids, opacity and surfaces.
//!
//! Triangles that never move come first and are made once; those of animated nodes, skins and morphs follow,
//! then particle quads. So an acceleration structure over the first part can be kept. Positions of the
//! previous frame are kept beside the moving ones: they give the motion vectors.
//!
//! Where a mesh is drawn so often that copies would fill the memory, its instances share its triangles
//! ([`Sharing`]): these have numbers, between those that never move and those that do, but are not stored.

use std::{ops::Range, sync::Arc};

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use crate::{
    camera::CameraPose,
    model::{LightKind, Material, Mesh},
    scene::Scene,
};

mod animator;
mod attribute;
mod deform;
mod footprint;
mod instances;
mod memory;
mod pose;
mod property;
mod storage;
mod succession;
mod surface;

use attribute::{QUAD_UVS, mix};
use footprint::texel_density;
use instances::Instances;
use property::Properties;

pub use animator::{Animator, scene_lights};
pub(crate) use deform::for_each_vertex_over_time;
pub use footprint::{HEAD_ON, LEAST_GRAZING};
pub use instances::{LEAST_SHARED, MeshInstance, Sharing};
pub use memory::FrameSize;
pub(crate) use pose::camera_pose;
pub use storage::{
    Look, MIRRORED, MorphedAttributes, NO_TEXTURE, OPAQUE, Object, SINGLE_SIDED, SLOT, StaticCounts, TINTED,
    TriangleOpacity,
};
pub use succession::{GONE, MovingObjects};
pub use surface::{Beam, Surface, Transmitted};

/// Which side of a triangle is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceSide {
    /// The side from which the vertices run counter-clockwise.
    Front,
    /// The side from which the vertices run clockwise.
    Back,
}

/// A light at the time of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameLight {
    /// Position in world; without meaning for directional lights.
    pub position: Vec3,
    /// Unit direction in which it shines.
    pub direction: Vec3,
    /// Linear RGB times intensity, as in [`crate::model::Light::intensity`].
    pub intensity: Vec3,
    /// The shape of its light.
    pub kind: LightKind,
}

/// The geometry of one moment.
#[derive(Clone, Debug)]
pub struct Frame {
    scene: Arc<Scene>,
    time_secs: f32,
    camera: CameraPose,
    previous_camera: CameraPose,
    static_counts: StaticCounts,
    triangles: Vec<[Vec3; 3]>,
    /// Where the triangles that are not static were in the previous frame.
    previous_moving: Vec<[Vec3; 3]>,
    triangle_object: Vec<u32>,
    objects: Vec<Object>,
    /// A triangle's flags, and its index into `opacities` unless it is opaque.
    opacity_slot: Vec<u32>,
    opacities: Vec<TriangleOpacity>,
    deformed_normals: Vec<Vec3>,
    morphed_attributes: Vec<MorphedAttributes>,
    properties: Properties,
    instances: Instances,
    lights: Vec<FrameLight>,
    is_still: bool,
}

impl Frame {
    /// The scene that is played.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The moment that is shown, seconds.
    #[must_use]
    pub fn time_secs(&self) -> f32 {
        self.time_secs
    }

    /// The camera at the time of the frame.
    #[must_use]
    pub fn camera(&self) -> &CameraPose {
        &self.camera
    }

    /// The camera in the previous frame.
    #[must_use]
    pub fn previous_camera(&self) -> &CameraPose {
        &self.previous_camera
    }

    /// Whether the previous frame shows the same: camera, geometry and lights are where they were, and
    /// nothing looks otherwise.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.is_still
    }

    /// All materials at the time of the frame, in the order of the scene's.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        let animated = &self.properties.materials;
        if animated.is_empty() { &self.scene.parts().materials } else { animated }
    }

    /// Whether [`Self::materials`] are others in other frames.
    #[must_use]
    pub fn animates_materials(&self) -> bool {
        !self.properties.materials.is_empty()
    }

    /// The triangles that are stored, in world space; the first [`Self::static_count`] never move. Without
    /// [`Self::instances`] they are all, and their places are their numbers.
    #[must_use]
    pub fn triangles(&self) -> &[[Vec3; 3]] {
        &self.triangles
    }

    /// How many of the stored triangles never move.
    #[must_use]
    pub fn static_count(&self) -> usize {
        self.static_counts.triangles
    }

    /// The instances that share the triangles of their mesh, in the order of their triangles.
    #[must_use]
    pub fn instances(&self) -> &[MeshInstance] {
        self.instances.list()
    }

    /// Numbers of the triangles of [`Self::instances`]. They follow on those of the stored triangles that
    /// never move; the other stored ones are numbered from their end on.
    #[must_use]
    pub fn instanced_triangles(&self) -> Range<u32> {
        self.instances.numbers()
    }

    /// How many triangles there are, stored or not; they are numbered from 0 on.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len() + self.instances.numbers().len()
    }

    /// Where a triangle is stored; none that belongs to one of [`Self::instances`].
    #[inline]
    fn stored(&self, triangle: u32) -> Option<usize> {
        let Range { start, end } = self.instances.numbers();
        if (start..end).contains(&triangle) {
            return None;
        }
        Some((if triangle < start { triangle } else { triangle - (end - start) }) as usize)
    }

    fn scene_mesh(&self, instance: &MeshInstance) -> &Mesh {
        &self.scene.parts().meshes[instance.mesh() as usize]
    }

    /// The corners of a triangle, world.
    #[must_use]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        match self.stored(triangle) {
            Some(place) => self.triangles[place],
            None => {
                let (instance, primitive) = self.instances.find(triangle);
                instance.corners(self.scene_mesh(instance), primitive)
            }
        }
    }

    /// Where the corners of a triangle were in the previous frame, world.
    fn previous_corners(&self, triangle: u32) -> [Vec3; 3] {
        match self.stored(triangle) {
            Some(place) => match place.checked_sub(self.static_counts.triangles) {
                Some(moving) => self.previous_moving[moving],
                None => self.triangles[place],
            },
            None => {
                let (instance, primitive) = self.instances.find(triangle);
                instance.previous_corners(self.scene_mesh(instance), primitive)
            }
        }
    }

    /// Lowest and highest corner of all triangles, along the axes of a space that is turned against the
    /// world; infinite and the wrong way round without any.
    #[must_use]
    pub fn bounds_in(&self, space_from_world: Mat3) -> [Vec3; 2] {
        let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let grown = |[low, high]: [Vec3; 2], triangle: [Vec3; 3]| {
            let corners = triangle.map(|corner| space_from_world * corner);
            [corners.into_iter().fold(low, Vec3::min), corners.into_iter().fold(high, Vec3::max)]
        };
        let joined = |[low, high]: [Vec3; 2], [other_low, other_high]: [Vec3; 2]| {
            [low.min(other_low), high.max(other_high)]
        };
        let stored = self.triangles.par_iter().fold(|| nothing, |bounds, &triangle| grown(bounds, triangle));
        let of_instance = |instance: &MeshInstance| {
            let mesh = self.scene_mesh(instance);
            (0..mesh.indices.len()).map(|primitive| instance.corners(mesh, primitive)).fold(nothing, grown)
        };
        let instanced = self.instances.list().par_iter().map(of_instance);
        stored.chain(instanced).reduce(|| nothing, joined)
    }

    /// The lights at the time of the frame.
    #[must_use]
    pub fn lights(&self) -> &[FrameLight] {
        &self.lights
    }

    /// The object a triangle belongs to.
    #[must_use]
    pub fn object(&self, triangle: u32) -> &Object {
        match self.stored(triangle) {
            Some(place) => &self.objects[self.triangle_object[place] as usize],
            None => &self.instances.find(triangle).0.object,
        }
    }

    /// Index of a triangle within its object, as `PrimitiveIndex()`.
    #[must_use]
    pub fn primitive(&self, triangle: u32) -> u32 {
        triangle - self.object(triangle).first_triangle
    }

    /// Corners of a triangle in the space of its object, where they never move: those of the mesh, not
    /// skinned or morphed, or of a square of side 1 for a particle.
    #[must_use]
    pub fn corners_in_object(&self, triangle: u32) -> [Vec3; 3] {
        let object = self.object(triangle);
        let primitive = (triangle - object.first_triangle) as usize;
        match object.look {
            Look::Quad { .. } => QUAD_UVS[primitive & 1].map(|corner| corner.extend(0.0)),
            Look::Rigid { mesh, .. } | Look::Deformed { mesh, .. } => {
                let mesh = &self.scene.parts().meshes[mesh as usize];
                mesh.indices[primitive].map(|vertex| mesh.positions[vertex as usize])
            }
        }
    }

    /// The side of a triangle that a ray meets which sees its vertices counter-clockwise (or not): mirrored
    /// objects are turned around.
    #[must_use]
    pub fn side(&self, triangle: u32, counter_clockwise: bool) -> FaceSide {
        let mirrored = self.flags(triangle) & MIRRORED != 0;
        if counter_clockwise != mirrored { FaceSide::Front } else { FaceSide::Back }
    }

    /// Whether the triangle is opaque all over.
    #[must_use]
    pub fn is_opaque(&self, triangle: u32) -> bool {
        self.flags(triangle) & OPAQUE != 0
    }

    /// A triangle's flags; the bits of [`SLOT`] mean nothing.
    #[inline]
    fn flags(&self, triangle: u32) -> u32 {
        match self.stored(triangle) {
            Some(place) => self.opacity_slot[place],
            None => self.instances.find(triangle).0.flags(),
        }
    }

    /// Opacity of a point of a triangle, 0 to 1: OPAQUE materials 1, MASK materials 0 or 1, BLEND materials
    /// their alpha. `u` and `v` are the barycentric weights of the second and third vertex, `width` is that
    /// of the beam that sees it, world units; 0 looks at the texture's texels themselves.
    #[must_use]
    #[inline]
    pub fn opacity(&self, triangle: u32, u: f32, v: f32, width: f32) -> f32 {
        let Some(place) = self.stored(triangle) else {
            return self.instance_opacity(triangle, u, v, None, width);
        };
        let slot = self.opacity_slot[place];
        if slot & OPAQUE != 0 { 1.0 } else { self.stored_opacity(slot, u, v, width) }
    }

    /// Opacity of a point of a triangle for a camera ray: that of [`Self::opacity`], but the back of a
    /// single-sided surface is not there.
    #[must_use]
    #[inline]
    pub fn opacity_for_camera(
        &self,
        triangle: u32,
        u: f32,
        v: f32,
        counter_clockwise: bool,
        width: f32,
    ) -> f32 {
        let Some(place) = self.stored(triangle) else {
            return self.instance_opacity(triangle, u, v, Some(counter_clockwise), width);
        };
        let slot = self.opacity_slot[place];
        let front = counter_clockwise != (slot & MIRRORED != 0);
        if slot & SINGLE_SIDED != 0 && !front {
            0.0
        } else if slot & OPAQUE != 0 {
            1.0
        } else {
            self.stored_opacity(slot, u, v, width)
        }
    }

    /// No point of a triangle has more opacity than this, which is found without its texture.
    #[must_use]
    #[inline]
    pub fn most_opacity(&self, triangle: u32) -> f32 {
        /// More than the roundings between the corners and of the texture add up to.
        const ROUNDING: f32 = 1.0 + 8.0 * f32::EPSILON;
        let Some(place) = self.stored(triangle) else { return 1.0 };
        let slot = self.opacity_slot[place];
        if slot & OPAQUE != 0 {
            return 1.0;
        }
        let entry = &self.opacities[(slot & SLOT) as usize];
        let [a, b, c] = entry.alpha;
        let alpha = if entry.cutoff >= 0.0 { 1.0 } else { a.max(b).max(c) * ROUNDING };
        (alpha * entry.opacity).clamp(0.0, 1.0)
    }

    /// Whether the light that passes a triangle takes its colour.
    #[must_use]
    #[inline]
    pub fn is_tinted(&self, triangle: u32) -> bool {
        self.flags(triangle) & TINTED != 0
    }

    /// Whether the light that passes a surface somewhere takes its colour.
    #[must_use]
    pub fn tints_light(&self) -> bool {
        self.materials().iter().any(|material| material.transmission > 0.0)
    }

    #[inline]
    fn stored_opacity(&self, slot: u32, u: f32, v: f32, width: f32) -> f32 {
        let entry = &self.opacities[(slot & SLOT) as usize];
        self.table_opacity(entry, entry.texel_density, u, v, width)
    }

    /// Opacity of a triangle of an instance; for a camera ray, which sees its vertices counter-clockwise or
    /// not, the back of a single-sided surface is not there.
    fn instance_opacity(
        &self,
        triangle: u32,
        u: f32,
        v: f32,
        counter_clockwise: Option<bool>,
        width: f32,
    ) -> f32 {
        let (instance, primitive) = self.instances.find(triangle);
        let flags = instance.flags();
        let front = counter_clockwise.is_none_or(|ccw| ccw != (flags & MIRRORED != 0));
        if flags & SINGLE_SIDED != 0 && !front {
            return 0.0;
        }
        if flags & OPAQUE != 0 {
            return 1.0;
        }
        let entry = self.instances.opacity(instance, primitive);
        // Without a texture or a width it goes into nothing.
        let density = if entry.texture == NO_TEXTURE || width == 0.0 {
            0.0
        } else {
            let corners = instance.corners(self.scene_mesh(instance), primitive);
            texel_density(&corners, &entry.uv, self.scene.samplers()[entry.texture as usize].size())
        };
        self.table_opacity(entry, density, u, v, width)
    }

    #[inline]
    fn table_opacity(&self, entry: &TriangleOpacity, texel_density: f32, u: f32, v: f32, width: f32) -> f32 {
        let w = 1.0 - u - v;
        // From the first vertex on, not as a weighted sum: three equal alphas give exactly theirs, so that 1
        // stays opaque.
        let [first, second, third] = entry.alpha;
        let mut alpha = first + u * (second - first) + v * (third - first);
        if entry.texture != NO_TEXTURE {
            let uv = w * entry.uv[0] + u * entry.uv[1] + v * entry.uv[2];
            let footprint = width * texel_density;
            alpha *= self.scene.samplers()[entry.texture as usize].sample_alpha(uv, footprint);
        }
        if entry.cutoff >= 0.0 {
            alpha = f32::from(alpha >= entry.cutoff);
        }
        (alpha * entry.opacity).clamp(0.0, 1.0)
    }

    /// Where a point of a triangle is, and where it was in the previous frame, world.
    #[must_use]
    pub fn positions(&self, triangle: u32, u: f32, v: f32) -> [Vec3; 2] {
        let weights = [1.0 - u - v, u, v];
        [mix(weights, self.corners(triangle)), mix(weights, self.previous_corners(triangle))]
    }
}

impl Object {
    /// Where its vertex attributes come from.
    #[must_use]
    pub fn look(&self) -> &Look {
        &self.look
    }
}

// The lists as they are stored, for whoever copies them elsewhere.
impl Frame {
    /// How much of each list never changes.
    #[must_use]
    pub fn static_counts(&self) -> StaticCounts {
        self.static_counts
    }

    /// Where the stored triangles from [`Self::static_count`] on were in the previous frame, world.
    #[must_use]
    pub fn previous_moving(&self) -> &[[Vec3; 3]] {
        &self.previous_moving
    }

    /// Each stored triangle's index into [`Self::objects`].
    #[must_use]
    pub fn triangle_objects(&self) -> &[u32] {
        &self.triangle_object
    }

    /// The objects of stored triangles: instances in the order of the scene, those that never move first,
    /// then particles. Where [`Sharing::flattened`] has copied the triangles of instances, these are in the
    /// middle.
    #[must_use]
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Each stored triangle's flags ([`OPAQUE`], [`SINGLE_SIDED`], [`MIRRORED`], [`TINTED`]), and in the bits
    /// of [`SLOT`] its index into [`Self::opacities`] unless it is opaque.
    #[must_use]
    pub fn opacity_slots(&self) -> &[u32] {
        &self.opacity_slot
    }

    /// The opacities of all stored triangles that are not opaque.
    #[must_use]
    pub fn opacities(&self) -> &[TriangleOpacity] {
        &self.opacities
    }

    /// World normals, and directions of tangents, of the vertices of skinned and morphed meshes; see
    /// [`Look::Deformed`].
    #[must_use]
    pub fn deformed_normals(&self) -> &[Vec3] {
        &self.deformed_normals
    }

    /// Colours and texture coordinates of meshes that morph them; see [`Look::Deformed`].
    #[must_use]
    pub fn morphed_attributes(&self) -> &[MorphedAttributes] {
        &self.morphed_attributes
    }
}
