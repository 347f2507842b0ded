//! Scene + time → frame: world-space triangles with ids, opacity and surfaces.
//!
//! Triangles that never move come first and are made once; those of animated nodes, skins and morphs follow, then particle quads. So an
//! acceleration structure over the first part can be kept. Positions of the previous frame are kept beside the moving ones: they give the
//! motion vectors.

use std::sync::Arc;

use glam::{Affine3A, Mat3, Quat, Vec2, Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::{
    camera::{Camera, CameraMotion, CameraPose, pose_on_rails},
    keys::value_at,
    model::{AlphaMode, LightKind, Material, Mesh, SceneParts, ShadingModel, TextureRef, Track, Transform},
    particle::ParticleSystem,
    scene::Scene,
};

/// Which side of a triangle is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceSide {
    /// Its vertices run counter-clockwise.
    Front,
    /// They run clockwise.
    Back,
}

/// A thing with an identity: one primitive of one instance, or one particle quad.
#[derive(Clone, Debug)]
pub struct Object {
    /// As `InstanceID()` of STD Listing 4; stable over time.
    pub id: u32,
    /// As `GeometryIndex()` of STD Listing 4.
    pub geometry: u32,
    /// Index into the scene's materials.
    pub material: u32,
    /// Index of its first triangle in [`Frame::triangles`].
    pub first_triangle: u32,
    look: Look,
}

/// Where an object's vertex attributes come from.
#[derive(Clone, Debug)]
enum Look {
    /// The mesh's own, moved rigidly (or at least affinely).
    Rigid { mesh: u32, normal_from_object: Mat3, vector_from_object: Mat3 },
    /// A skinned or morphed mesh: normals lie in [`Frame::deformed_normals`] from `first_normal` on; none if `None`.
    Deformed { mesh: u32, first_normal: Option<u32> },
    /// A particle quad: unit axes in world, its tile of the atlas, and its factors.
    Quad { right: Vec3, up: Vec3, tile_origin: Vec2, tile_size: Vec2, tint: Vec3 },
}

/// A light at the time of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameLight {
    /// Position in world; without meaning for directional lights.
    pub position: Vec3,
    /// Unit direction in which it shines.
    pub direction: Vec3,
    /// As in [`crate::model::Light::intensity`].
    pub intensity: Vec3,
    /// Its shape.
    pub kind: LightKind,
}

/// Everything shading needs to know of a point on a surface. Colours are linear.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Point in world.
    pub position: Vec3,
    /// Where this point of the surface was in the previous frame, world.
    pub previous_position: Vec3,
    /// Unit normal of the triangle, towards the viewer.
    pub geometric_normal: Vec3,
    /// Unit normal for shading, towards the viewer's side.
    pub normal: Vec3,
    /// Which side is seen.
    pub side: FaceSide,
    /// Reflectance, or radiance if unlit.
    pub base_colour: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Emitted radiance.
    pub emissive: Vec3,
    /// Share of environment light that arrives, 0 to 1.
    pub occlusion: f32,
    /// How light meets it.
    pub model: ShadingModel,
}

const OPAQUE: u32 = 1 << 31;
const SINGLE_SIDED: u32 = 1 << 30;
const MIRRORED: u32 = 1 << 29;
const SLOT: u32 = MIRRORED - 1;
const NO_TEXTURE: u32 = u32::MAX;

/// What the any-hit test reads, gathered a triangle: 48 bytes instead of a walk through object, mesh and material.
#[derive(Clone, Copy, Debug)]
struct TriangleOpacity {
    uv: [Vec2; 3],
    /// Factor at each vertex.
    alpha: [f32; 3],
    texture: u32,
    /// Alpha test; negative: none.
    cutoff: f32,
    /// Factor after the alpha test.
    opacity: f32,
}

/// The geometry of one moment.
#[derive(Clone, Debug)]
pub struct Frame {
    scene: Arc<Scene>,
    time_secs: f32,
    camera: CameraPose,
    previous_camera: CameraPose,
    static_count: usize,
    triangles: Vec<[Vec3; 3]>,
    /// Of the triangles from `static_count` on.
    previous_moving: Vec<[Vec3; 3]>,
    triangle_object: Vec<u32>,
    objects: Vec<Object>,
    /// A triangle's flags, and its index into `opacities` unless it is opaque.
    opacity_slot: Vec<u32>,
    opacities: Vec<TriangleOpacity>,
    deformed_normals: Vec<Vec3>,
    lights: Vec<FrameLight>,
}

impl Frame {
    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Seconds.
    #[must_use]
    pub fn time_secs(&self) -> f32 {
        self.time_secs
    }

    /// The camera now.
    #[must_use]
    pub fn camera(&self) -> &CameraPose {
        &self.camera
    }

    /// The camera in the previous frame.
    #[must_use]
    pub fn previous_camera(&self) -> &CameraPose {
        &self.previous_camera
    }

    /// All triangles in world space; the first [`Self::static_count`] never move.
    #[must_use]
    pub fn triangles(&self) -> &[[Vec3; 3]] {
        &self.triangles
    }

    /// How many triangles never move.
    #[must_use]
    pub fn static_count(&self) -> usize {
        self.static_count
    }

    /// Lights now.
    #[must_use]
    pub fn lights(&self) -> &[FrameLight] {
        &self.lights
    }

    /// The object a triangle belongs to.
    #[must_use]
    pub fn object(&self, triangle: u32) -> &Object {
        &self.objects[self.triangle_object[triangle as usize] as usize]
    }

    /// Index of a triangle within its object, as `PrimitiveIndex()`.
    #[must_use]
    pub fn primitive(&self, triangle: u32) -> u32 {
        triangle - self.object(triangle).first_triangle
    }

    /// Corners of a triangle in the space of its object, where they never move: those of the mesh, not skinned or morphed, or of a square
    /// of side 1 for a particle.
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

    /// The side of a triangle that a ray meets which sees its vertices counter-clockwise (or not): mirrored objects are turned around.
    #[must_use]
    pub fn side(&self, triangle: u32, counter_clockwise: bool) -> FaceSide {
        let mirrored = self.opacity_slot[triangle as usize] & MIRRORED != 0;
        if counter_clockwise != mirrored { FaceSide::Front } else { FaceSide::Back }
    }

    /// Whether the triangle is opaque all over.
    #[must_use]
    pub fn is_opaque(&self, triangle: u32) -> bool {
        self.opacity_slot[triangle as usize] & OPAQUE != 0
    }

    /// Opacity of a point of a triangle, 0 to 1: OPAQUE materials 1, MASK materials 0 or 1, BLEND materials their alpha.
    /// `u` and `v` are the barycentric weights of the second and third vertex.
    #[must_use]
    #[inline]
    pub fn opacity(&self, triangle: u32, u: f32, v: f32) -> f32 {
        let slot = self.opacity_slot[triangle as usize];
        if slot & OPAQUE != 0 { 1.0 } else { self.table_opacity(slot, u, v) }
    }

    /// The same for a camera ray: the back of a single-sided surface is not there.
    #[must_use]
    #[inline]
    pub fn opacity_for_camera(&self, triangle: u32, u: f32, v: f32, counter_clockwise: bool) -> f32 {
        let slot = self.opacity_slot[triangle as usize];
        let front = counter_clockwise != (slot & MIRRORED != 0);
        if slot & SINGLE_SIDED != 0 && !front {
            0.0
        } else if slot & OPAQUE != 0 {
            1.0
        } else {
            self.table_opacity(slot, u, v)
        }
    }

    #[inline]
    fn table_opacity(&self, slot: u32, u: f32, v: f32) -> f32 {
        let entry = &self.opacities[(slot & SLOT) as usize];
        let w = 1.0 - u - v;
        // From the first vertex on, not as a weighted sum: three equal alphas give exactly theirs, so that 1 stays opaque.
        let [first, second, third] = entry.alpha;
        let mut alpha = first + u * (second - first) + v * (third - first);
        if entry.texture != NO_TEXTURE {
            let uv = w * entry.uv[0] + u * entry.uv[1] + v * entry.uv[2];
            alpha *= self.scene.samplers()[entry.texture as usize].sample_alpha(uv);
        }
        if entry.cutoff >= 0.0 {
            alpha = f32::from(alpha >= entry.cutoff);
        }
        (alpha * entry.opacity).clamp(0.0, 1.0)
    }

    /// The surface at a point of a triangle, seen by a ray that finds its vertices counter-clockwise (or not).
    #[must_use]
    pub fn surface(&self, triangle: u32, u: f32, v: f32, counter_clockwise: bool) -> Surface {
        let weights = [1.0 - u - v, u, v];
        let corners = self.triangles[triangle as usize];
        let position = mix(weights, corners);
        let previous_position = match (triangle as usize).checked_sub(self.static_count) {
            Some(moving) => mix(weights, self.previous_moving[moving]),
            None => position,
        };
        let object = self.object(triangle);
        let material = &self.scene.parts().materials[object.material as usize];
        let side = self.side(triangle, counter_clockwise);
        let winding_normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let geometric_normal = if counter_clockwise { winding_normal } else { -winding_normal };
        // The outward normal is that of the front side.
        let outward = if side == FaceSide::Front { geometric_normal } else { -geometric_normal };
        let attributes = self.attributes(object, triangle, weights, corners, outward);

        let mut surface = Surface {
            position,
            previous_position,
            geometric_normal,
            normal: attributes.normal,
            side,
            base_colour: material.base_colour.truncate() * attributes.tint,
            metallic: material.metallic,
            roughness: material.roughness,
            emissive: material.emissive,
            occlusion: 1.0,
            model: material.model,
        };
        self.apply_textures(material, &attributes, &mut surface);
        if side == FaceSide::Back && surface.model != ShadingModel::Smoke {
            surface.normal = -surface.normal;
        }
        surface
    }

    /// Interpolated vertex attributes.
    fn attributes(
        &self,
        object: &Object,
        triangle: u32,
        weights: [f32; 3],
        corners: [Vec3; 3],
        outward: Vec3,
    ) -> Attributes<'_> {
        let primitive = (triangle - object.first_triangle) as usize;
        let mesh_of = |mesh: u32| {
            let mesh = &self.scene.parts().meshes[mesh as usize];
            (mesh, mesh.indices[primitive].map(|index| index as usize))
        };
        match &object.look {
            Look::Quad { right, up, tile_origin, tile_size, tint } => {
                let local_corners = QUAD_UVS[primitive & 1];
                let uvs = local_corners.map(|local| *tile_origin + local * *tile_size);
                // A sphere inscribed in the quad; the corners outside it look sideways.
                let disc = mix(weights, local_corners) * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
                let height = (1.0 - disc.length_squared()).max(0.05).sqrt();
                let normal = (*right * disc.x + *up * disc.y + right.cross(*up) * height).normalize();
                Attributes { weights, corners, normal, tangent: None, tint: *tint, uvs: CornerUvs::Quad(uvs) }
            }
            Look::Rigid { mesh, normal_from_object, vector_from_object } => {
                let (mesh, vertices) = mesh_of(*mesh);
                let normal = gather(&mesh.normals, vertices)
                    .map(|normals| *normal_from_object * mix(weights, normals));
                let tangent = gather(&mesh.tangents, vertices).map(|tangents| {
                    let tangent = mix(weights, tangents);
                    (*vector_from_object * tangent.xyz()).extend(tangent.w)
                });
                self.mesh_attributes(mesh, vertices, weights, corners, normal.unwrap_or(outward), tangent)
            }
            Look::Deformed { mesh, first_normal } => {
                let (mesh, vertices) = mesh_of(*mesh);
                let normal = first_normal.map(|first| {
                    mix(weights, vertices.map(|vertex| self.deformed_normals[first as usize + vertex]))
                });
                self.mesh_attributes(mesh, vertices, weights, corners, normal.unwrap_or(outward), None)
            }
        }
    }

    fn mesh_attributes<'a>(
        &'a self,
        mesh: &'a Mesh,
        vertices: [usize; 3],
        weights: [f32; 3],
        corners: [Vec3; 3],
        normal: Vec3,
        tangent: Option<Vec4>,
    ) -> Attributes<'a> {
        let tint =
            gather(&mesh.colours, vertices).map_or(Vec3::ONE, |colours| mix(weights, colours).truncate());
        let normal = normal.normalize_or(Vec3::Y);
        Attributes { weights, corners, normal, tangent, tint, uvs: CornerUvs::Mesh { mesh, vertices } }
    }

    /// Multiplies textures into the surface and bends its normal.
    fn apply_textures(&self, material: &Material, attributes: &Attributes<'_>, surface: &mut Surface) {
        let sample = |used: &TextureRef| {
            let uv = mix(attributes.weights, attributes.uvs.of(used));
            self.scene.samplers()[used.texture as usize].sample(uv)
        };
        if let Some(used) = &material.base_colour_texture {
            surface.base_colour *= sample(used).truncate();
        }
        if let Some(used) = &material.metallic_roughness_texture {
            let texel = sample(used);
            surface.roughness *= texel.y;
            surface.metallic *= texel.z;
        }
        if let Some(used) = &material.emissive_texture {
            surface.emissive *= sample(used).truncate();
        }
        if let Some(used) = &material.occlusion_texture {
            surface.occlusion = 1.0 + material.occlusion_strength * (sample(used).x - 1.0);
        }
        if let Some(used) = &material.normal_texture {
            let texel = sample(used).truncate() * 2.0 - Vec3::ONE;
            let bent = texel * Vec3::new(material.normal_scale, material.normal_scale, 1.0);
            surface.normal = attributes.bend(used, bent);
        }
    }
}

/// Corners of a quad's two triangles, in its tile: the order in which [`quad_corners`] emits them.
const QUAD_UVS: [[Vec2; 3]; 2] = [[Vec2::Y, Vec2::ONE, Vec2::X], [Vec2::Y, Vec2::X, Vec2::ZERO]];

/// Vertex attributes at a point of a triangle.
struct Attributes<'a> {
    weights: [f32; 3],
    corners: [Vec3; 3],
    /// Unit, outward.
    normal: Vec3,
    /// World, with the bitangent's sign in w.
    tangent: Option<Vec4>,
    tint: Vec3,
    uvs: CornerUvs<'a>,
}

/// Texture coordinates of a triangle's corners.
enum CornerUvs<'a> {
    Quad([Vec2; 3]),
    Mesh { mesh: &'a Mesh, vertices: [usize; 3] },
}

impl CornerUvs<'_> {
    fn of(&self, used: &TextureRef) -> [Vec2; 3] {
        let raw = match self {
            Self::Quad(uvs) => *uvs,
            Self::Mesh { mesh, vertices } => corner_uvs(mesh, *vertices, used.uv_set),
        };
        raw.map(|uv| used.transform.transform_point2(uv))
    }
}

impl Attributes<'_> {
    /// A tangent-space normal in world. Without a given tangent it follows the texture's u axis across the triangle.
    fn bend(&self, used: &TextureRef, in_tangent: Vec3) -> Vec3 {
        let (tangent, bitangent_sign) = match self.tangent {
            Some(tangent) => (tangent.truncate(), tangent.w),
            None => {
                let [a, b, c] = self.corners;
                let [uv_a, uv_b, uv_c] = self.uvs.of(used);
                let (to_b, to_c) = (uv_b - uv_a, uv_c - uv_a);
                let area = to_b.perp_dot(to_c);
                (((b - a) * to_c.y - (c - a) * to_b.y) * area.signum(), self.handedness(area))
            }
        };
        let tangent = (tangent - self.normal * self.normal.dot(tangent)).normalize_or_zero();
        if tangent == Vec3::ZERO {
            return self.normal;
        }
        let bitangent = self.normal.cross(tangent) * bitangent_sign;
        (tangent * in_tangent.x + bitangent * in_tangent.y + self.normal * in_tangent.z)
            .normalize_or(self.normal)
    }

    /// Sign of `normal × tangent` against the direction in which the image's v falls: up in the image is +Y of a normal map.
    fn handedness(&self, uv_area: f32) -> f32 {
        let winding = (self.corners[1] - self.corners[0]).cross(self.corners[2] - self.corners[0]);
        -(uv_area.signum() * winding.dot(self.normal).signum())
    }
}

fn corner_uvs(mesh: &Mesh, vertices: [usize; 3], uv_set: u32) -> [Vec2; 3] {
    mesh.uv_sets.get(uv_set as usize).map_or([Vec2::ZERO; 3], |set| vertices.map(|vertex| set[vertex]))
}

fn gather<T: Copy>(list: &[T], vertices: [usize; 3]) -> Option<[T; 3]> {
    (!list.is_empty()).then(|| vertices.map(|vertex| list[vertex]))
}

fn mix<T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(
    weights: [f32; 3],
    [a, b, c]: [T; 3],
) -> T {
    a * weights[0] + b * weights[1] + c * weights[2]
}

/// Plays a scene: holds the frame and recomputes what moves.
#[derive(Clone, Debug)]
pub struct Animator {
    camera: Camera,
    /// Instances that move, in the order of their triangles.
    moving: Vec<u32>,
    static_objects: usize,
    static_opacities: usize,
    first_particle_id: u32,
    frame: Frame,
}

impl Animator {
    /// Prepares a scene seen through a camera of it (see [`Scene::camera`]), at time zero.
    #[must_use]
    pub fn new(scene: Arc<Scene>, camera: Camera) -> Self {
        let parts = scene.parts();
        let node_moves = moving_nodes(parts);
        let pose = camera_pose(&scene, &camera, 0.0);
        let (moving, still): (Vec<u32>, Vec<u32>) =
            (0..parts.instances.len() as u32).partition(|&index| instance_moves(parts, &node_moves, index));
        let first_particle_id = parts.instances.iter().map(|instance| instance.id + 1).max().unwrap_or(0);
        let frame = Frame {
            scene: Arc::clone(&scene),
            time_secs: 0.0,
            camera: pose,
            previous_camera: pose,
            static_count: 0,
            triangles: Vec::new(),
            previous_moving: Vec::new(),
            triangle_object: Vec::new(),
            objects: Vec::new(),
            opacity_slot: Vec::new(),
            opacities: Vec::new(),
            deformed_normals: Vec::new(),
            lights: Vec::new(),
        };
        let mut animator =
            Self { camera, moving, static_objects: 0, static_opacities: 0, first_particle_id, frame };
        let pose = NodePose::at(scene.parts(), 0.0);
        for index in still {
            animator.emit_instance(&pose, index);
        }
        animator.frame.deformed_normals.clear();
        animator.frame.static_count = animator.frame.triangles.len();
        animator.static_objects = animator.frame.objects.len();
        animator.static_opacities = animator.frame.opacities.len();
        animator.advance(0.0, 0.0);
        animator
    }

    /// The frame of the last [`Self::advance`].
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Moves to a time; motion vectors will point to where things were at `previous_secs`.
    pub fn advance(&mut self, time_secs: f32, previous_secs: f32) -> &Frame {
        let scene = Arc::clone(&self.frame.scene);
        self.frame.time_secs = time_secs;
        self.frame.camera = camera_pose(&scene, &self.camera, time_secs);
        self.frame.previous_camera = camera_pose(&scene, &self.camera, previous_secs);

        // Meshes: first where they were, then where they are.
        self.truncate_to_static();
        if !self.moving.is_empty() && previous_secs != time_secs {
            self.emit_moving(&NodePose::at(scene.parts(), previous_secs));
        }
        let mut previous = std::mem::take(&mut self.frame.previous_moving);
        previous.clear();
        previous.extend_from_slice(&self.frame.triangles[self.frame.static_count..]);
        self.truncate_to_static();
        let pose = NodePose::at(scene.parts(), time_secs);
        self.emit_moving(&pose);
        if previous_secs == time_secs {
            previous.clear();
            previous.extend_from_slice(&self.frame.triangles[self.frame.static_count..]);
        }
        self.frame.previous_moving = previous;

        let mut next_id = self.first_particle_id;
        for system in &scene.parts().particles {
            self.emit_particles(system, next_id, time_secs, previous_secs);
            next_id += system.particles.len() as u32;
        }
        self.frame.lights.clear();
        self.frame.lights.extend(scene.parts().lights.iter().map(|light| {
            let world_from_node = pose.world_from_node[light.node as usize];
            FrameLight {
                position: world_from_node.translation.into(),
                direction: world_from_node.transform_vector3(Vec3::NEG_Z).normalize_or(Vec3::NEG_Y),
                intensity: light.intensity,
                kind: light.kind,
            }
        }));
        &self.frame
    }

    fn truncate_to_static(&mut self) {
        let frame = &mut self.frame;
        frame.triangles.truncate(frame.static_count);
        frame.triangle_object.truncate(frame.static_count);
        frame.opacity_slot.truncate(frame.static_count);
        frame.objects.truncate(self.static_objects);
        frame.opacities.truncate(self.static_opacities);
        frame.deformed_normals.clear();
    }

    fn emit_moving(&mut self, pose: &NodePose) {
        for index in self.moving.clone() {
            self.emit_instance(pose, index);
        }
    }

    /// Appends an instance's object, triangles and opacities to the frame.
    fn emit_instance(&mut self, pose: &NodePose, index: u32) {
        let scene = Arc::clone(&self.frame.scene);
        let parts = scene.parts();
        let instance = &parts.instances[index as usize];
        let mesh = &parts.meshes[instance.mesh as usize];
        let material = &parts.materials[mesh.material as usize];
        let world_from_object = pose.world_from_node[instance.node as usize] * instance.node_from_object;
        let frame = &mut self.frame;

        let deforms = instance.skin.is_some() || !mesh.morph_targets.is_empty();
        let look = if deforms {
            let first_normal = (!mesh.normals.is_empty()).then_some(frame.deformed_normals.len() as u32);
            let positions = deform(parts, pose, index, world_from_object, &mut frame.deformed_normals);
            frame
                .triangles
                .extend(mesh.indices.iter().map(|corners| corners.map(|corner| positions[corner as usize])));
            Look::Deformed { mesh: instance.mesh, first_normal }
        } else {
            let vector_from_object = Mat3::from(world_from_object.matrix3);
            let corner = |corner: u32| world_from_object.transform_point3(mesh.positions[corner as usize]);
            frame.triangles.par_extend(mesh.indices.par_iter().map(|corners| corners.map(corner)));
            let normal_from_object = normal_matrix(vector_from_object);
            Look::Rigid { mesh: instance.mesh, normal_from_object, vector_from_object }
        };
        // A skinned mesh does not follow its own node (glTF 2.0, 3.7.3.3).
        let mirrored = instance.skin.is_none() && world_from_object.matrix3.determinant() < 0.0;

        let object = Object {
            id: instance.id,
            geometry: instance.geometry,
            material: mesh.material,
            first_triangle: frame.triangle_object.len() as u32,
            look,
        };
        let mut flags = if mirrored { MIRRORED } else { 0 };
        flags |= if material.double_sided { 0 } else { SINGLE_SIDED };
        let count = mesh.indices.len();
        frame.triangle_object.extend(std::iter::repeat_n(frame.objects.len() as u32, count));
        frame.objects.push(object);
        if material.alpha_mode == AlphaMode::Opaque && material.opacity >= 1.0 {
            frame.opacity_slot.extend(std::iter::repeat_n(flags | OPAQUE, count));
            return;
        }
        for corners in &mesh.indices {
            let vertices = corners.map(|corner| corner as usize);
            let alpha =
                gather(&mesh.colours, vertices).map_or([1.0; 3], |colours| colours.map(|colour| colour.w));
            let uvs = |used: &TextureRef| corner_uvs(mesh, vertices, used.uv_set);
            frame.opacity_slot.push(flags | frame.opacities.len() as u32);
            frame.opacities.push(TriangleOpacity::new(material, alpha, uvs));
        }
    }

    /// Appends the living particles of a system.
    fn emit_particles(&mut self, system: &ParticleSystem, first_id: u32, time_secs: f32, previous_secs: f32) {
        let scene = Arc::clone(&self.frame.scene);
        let material = &scene.parts().materials[system.material as usize];
        let (camera, previous_camera) = (self.frame.camera, self.frame.previous_camera);
        let quads: Vec<_> = (0..system.particles.len())
            .into_par_iter()
            .filter_map(|index| {
                let puff = system.puff(index, time_secs)?;
                let alpha = puff.alpha * system.near_factor(camera.view_depth(puff.centre));
                if alpha <= 0.0 {
                    return None;
                }
                let (right, up) = quad_axes(&camera, puff.rotation_rad);
                let corners = quad_corners(puff.centre, right * puff.half_size, up * puff.half_size);
                let before = system.puff(index, previous_secs).map_or(corners, |puff| {
                    let (right, up) = quad_axes(&previous_camera, puff.rotation_rad);
                    quad_corners(puff.centre, right * puff.half_size, up * puff.half_size)
                });
                Some((index, alpha, right, up, corners, before))
            })
            .collect();

        let frame = &mut self.frame;
        for (index, alpha, right, up, corners, before) in quads {
            let particle = &system.particles[index];
            let (tile_origin, tile_size) = system.tile(particle.tile);
            let object = Object {
                id: first_id + index as u32,
                geometry: 0,
                material: system.material,
                first_triangle: frame.triangles.len() as u32,
                look: Look::Quad { right, up, tile_origin, tile_size, tint: particle.tint },
            };
            for (half, local) in QUAD_UVS.iter().enumerate() {
                let uvs = |_: &TextureRef| local.map(|local| tile_origin + local * tile_size);
                frame.triangles.push(corners[half]);
                frame.previous_moving.push(before[half]);
                frame.triangle_object.push(frame.objects.len() as u32);
                frame.opacity_slot.push(frame.opacities.len() as u32);
                frame.opacities.push(TriangleOpacity::new(material, [alpha; 3], uvs));
            }
            frame.objects.push(object);
        }
    }
}

impl TriangleOpacity {
    fn new(material: &Material, vertex_alpha: [f32; 3], uvs: impl Fn(&TextureRef) -> [Vec2; 3]) -> Self {
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
        }
    }
}

/// Unit axes of a quad that faces the camera, turned in its plane.
fn quad_axes(camera: &CameraPose, rotation_rad: f32) -> (Vec3, Vec3) {
    let axes = camera.world_from_camera.matrix3;
    let (right, up) = (Vec3::from(axes.x_axis), Vec3::from(axes.y_axis));
    let (sin, cos) = rotation_rad.sin_cos();
    (right * cos + up * sin, up * cos - right * sin)
}

/// Two triangles, counter-clockwise seen from the camera, corners in the order of [`QUAD_UVS`].
fn quad_corners(centre: Vec3, right: Vec3, up: Vec3) -> [[Vec3; 3]; 2] {
    let (low_left, low_right) = (centre - right - up, centre + right - up);
    let (high_right, high_left) = (centre + right + up, centre - right + up);
    [[low_left, low_right, high_right], [low_left, high_right, high_left]]
}

/// The matrix that takes normals along with an affine map; also right for mirrored and flattened ones.
fn normal_matrix(vector_from_object: Mat3) -> Mat3 {
    let Mat3 { x_axis, y_axis, z_axis } = vector_from_object;
    // The cofactor matrix: inverse transpose times the determinant, without dividing by it.
    let cofactors = Mat3::from_cols(y_axis.cross(z_axis), z_axis.cross(x_axis), x_axis.cross(y_axis));
    if vector_from_object.determinant() < 0.0 { -cofactors } else { cofactors }
}

/// World positions of a morphed and skinned instance; its unit normals are appended to `normals`.
fn deform(
    parts: &SceneParts,
    pose: &NodePose,
    index: u32,
    world_from_object: Affine3A,
    normals: &mut Vec<Vec3>,
) -> Vec<Vec3> {
    let instance = &parts.instances[index as usize];
    let mesh = &parts.meshes[instance.mesh as usize];
    let animated = pose.morph_weights.iter().find(|(node, _)| *node == instance.node);
    let weights = animated.map_or(&instance.morph_weights, |(_, weights)| weights);

    let mut positions = mesh.positions.clone();
    let mut own_normals = mesh.normals.clone();
    for (target, &weight) in mesh.morph_targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        positions
            .iter_mut()
            .zip(&target.positions)
            .for_each(|(position, delta)| *position += *delta * weight);
        own_normals.iter_mut().zip(&target.normals).for_each(|(normal, delta)| *normal += *delta * weight);
    }

    let joints: Vec<Affine3A> = instance.skin.map_or_else(Vec::new, |skin| {
        let skin = &parts.skins[skin as usize];
        let world_from_joint = skin.joints.iter().map(|&joint| pose.world_from_node[joint as usize]);
        world_from_joint.zip(&skin.inverse_bind).map(|(world, bind)| world * *bind).collect()
    });
    let rigid = normal_matrix(Mat3::from(world_from_object.matrix3));
    for (vertex, position) in positions.iter_mut().enumerate() {
        let normal = own_normals.get_mut(vertex);
        let per_vertex = mesh.influences_per_vertex;
        if joints.is_empty() || per_vertex == 0 {
            *position = world_from_object.transform_point3(*position);
            if let Some(normal) = normal {
                *normal = (rigid * *normal).normalize_or_zero();
            }
            continue;
        }
        let influences = &mesh.influences[vertex * per_vertex..][..per_vertex];
        let mut blended = Affine3A::ZERO;
        for influence in influences {
            let joint = &joints[usize::from(influence.joint)];
            blended.matrix3 += joint.matrix3 * influence.weight;
            blended.translation += joint.translation * influence.weight;
        }
        *position = blended.transform_point3(*position);
        if let Some(normal) = normal {
            *normal = (normal_matrix(Mat3::from(blended.matrix3)) * *normal).normalize_or_zero();
        }
    }
    normals.extend(own_normals);
    positions
}

/// All nodes at one moment.
struct NodePose {
    world_from_node: Vec<Affine3A>,
    /// Animated morph weights by node.
    morph_weights: Vec<(u32, Vec<f32>)>,
}

impl NodePose {
    fn at(parts: &SceneParts, time_secs: f32) -> Self {
        let mut local: Vec<Transform> = parts.nodes.iter().map(|node| node.transform).collect();
        let mut morph_weights = Vec::new();
        for animation in &parts.animations {
            let duration_secs =
                animation.channels.iter().map(|channel| channel.track.end_secs()).fold(0.0, f32::max);
            let time_secs = if duration_secs > 0.0 { time_secs.rem_euclid(duration_secs) } else { time_secs };
            for channel in &animation.channels {
                match (&channel.track, &mut local[channel.node as usize]) {
                    (Track::Translation(keys), Transform::Trs { translation, .. }) => {
                        *translation = value_at(keys, time_secs)
                    }
                    (Track::Rotation(keys), Transform::Trs { rotation, .. }) => {
                        *rotation = unit(value_at(keys, time_secs))
                    }
                    (Track::Scale(keys), Transform::Trs { scale, .. }) => *scale = value_at(keys, time_secs),
                    (Track::MorphWeights(keys), _) => {
                        morph_weights.push((channel.node, value_at(keys, time_secs)))
                    }
                    // Validation has refused animated matrices.
                    (_, Transform::Matrix(_)) => {}
                }
            }
        }
        let mut world_from_node: Vec<Affine3A> = Vec::with_capacity(parts.nodes.len());
        for (node, transform) in parts.nodes.iter().zip(local) {
            let parent = node.parent.map_or(Affine3A::IDENTITY, |parent| world_from_node[parent as usize]);
            world_from_node.push(parent * transform.to_affine());
        }
        Self { world_from_node, morph_weights }
    }
}

/// A quaternion made unit again; the identity if it has no direction.
fn unit(rotation: Quat) -> Quat {
    if rotation.length_squared() > 1e-12 { rotation.normalize() } else { Quat::IDENTITY }
}

impl Track {
    fn end_secs(&self) -> f32 {
        match self {
            Self::Translation(keys) | Self::Scale(keys) => keys.end_secs(),
            Self::Rotation(keys) => keys.end_secs(),
            Self::MorphWeights(keys) => keys.end_secs(),
        }
    }
}

/// Which nodes an animation moves, directly or through a parent.
fn moving_nodes(parts: &SceneParts) -> Vec<bool> {
    let mut moves = vec![false; parts.nodes.len()];
    for channel in parts.animations.iter().flat_map(|animation| &animation.channels) {
        moves[channel.node as usize] |= !matches!(channel.track, Track::MorphWeights(_));
    }
    for (index, node) in parts.nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            moves[index] |= moves[parent as usize];
        }
    }
    moves
}

/// Deformed instances always count as moving: their normals live with the frame.
fn instance_moves(parts: &SceneParts, node_moves: &[bool], index: u32) -> bool {
    let instance = &parts.instances[index as usize];
    let mesh = &parts.meshes[instance.mesh as usize];
    instance.skin.is_some() || !mesh.morph_targets.is_empty() || node_moves[instance.node as usize]
}

/// Where a camera is at a time.
pub(crate) fn camera_pose(scene: &Scene, camera: &Camera, time_secs: f32) -> CameraPose {
    if let Some(pose) = pose_on_rails(camera.lens, &camera.motion, time_secs) {
        return pose;
    }
    let CameraMotion::Node(node) = camera.motion else {
        unreachable!("only a camera on a node has no rails");
    };
    let world_from_node = NodePose::at(scene.parts(), time_secs).world_from_node[node as usize];
    let (_, rotation, translation) = world_from_node.to_scale_rotation_translation();
    CameraPose {
        world_from_camera: Affine3A::from_rotation_translation(unit(rotation), translation),
        lens: camera.lens,
    }
}

/// Calls `visit` with the world position of each vertex of each instance at time zero.
pub(crate) fn for_each_vertex_at_rest(parts: &SceneParts, visit: &mut impl FnMut(Vec3)) {
    let pose = NodePose::at(parts, 0.0);
    for (index, instance) in parts.instances.iter().enumerate() {
        let mesh = &parts.meshes[instance.mesh as usize];
        let world_from_object = pose.world_from_node[instance.node as usize] * instance.node_from_object;
        if instance.skin.is_some() || !mesh.morph_targets.is_empty() {
            deform(parts, &pose, index as u32, world_from_object, &mut Vec::new())
                .into_iter()
                .for_each(&mut *visit);
        } else {
            mesh.positions.iter().for_each(|&position| visit(world_from_object.transform_point3(position)));
        }
    }
}
