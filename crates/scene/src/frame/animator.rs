//! Plays a scene: what each moment adds to the frame.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};
use rayon::prelude::*;

use super::{
    Frame, FrameLight, Object,
    attribute::{QUAD_UVS, VertexLists},
    deform::{deform, morph_attributes},
    footprint::texel_density,
    instances::{
        Instances, MeshInstance, Sharing, material_flags, mesh_opacity, mirror_flag, rigid_look, tint_flag,
    },
    pose::{NodePose, camera_pose, instance_moves, moving_nodes},
    property::{Changing, Properties},
    storage::{Look, OPAQUE, StaticCounts, TriangleOpacity},
};
use crate::{
    camera::{Camera, CameraPose},
    model::{LightKind, SceneParts, TextureRef},
    particle::{ParticleState, ParticleSystem},
    scene::Scene,
};

/// Plays a scene: holds the frame and recomputes what moves.
#[derive(Clone, Debug)]
pub struct Animator {
    camera: Camera,
    /// A pose of the caller's, which takes the camera's place.
    own_pose: Option<CameraPose>,
    /// Instances that move or change their opacity and whose triangles are stored, in the order of these.
    moving: Vec<u32>,
    first_particle_id: u32,
    /// The quads of each particle system in the frame, ascending by their index.
    quads: Vec<Vec<Quad>>,
    frame: Frame,
}

/// A living particle.
#[derive(Clone, Debug)]
struct Quad {
    /// Its index in the system.
    index: usize,
    alpha: f32,
    /// Unit axes in which u grows and v falls, world.
    axes: (Vec3, Vec3),
    /// In world, those of the lower edge first, counter-clockwise seen from the camera.
    corners: [Vec3; 4],
    /// The same in the previous frame.
    previous_corners: [Vec3; 4],
}

/// Where quads were in the previous frame.
#[derive(Clone, Copy)]
enum Before<'a> {
    /// Where they are.
    Here,
    /// Where the frame had them that the animator showed last.
    AsShown(&'a [Quad]),
    /// That has to be worked out.
    Elsewhere,
}

impl Animator {
    /// Prepares a scene seen through a camera of it (see [`Scene::camera`]), at time zero.
    #[must_use]
    pub fn new(scene: Arc<Scene>, camera: Camera) -> Self {
        Self::with_sharing(scene, camera, Sharing::default())
    }

    /// The same with another choice of what is stored once.
    #[must_use]
    pub fn with_sharing(scene: Arc<Scene>, camera: Camera, sharing: Sharing) -> Self {
        let parts = scene.parts();

        // Four lots: what shares its triangles lies in the middle, stored or not.
        let (node_moves, changing) = (&moving_nodes(parts), &Changing::of(parts));
        let is_shared = &sharing.choose(parts, |index| changing.has(parts, index));
        let lot = |moves: bool, shared: bool| {
            (0..parts.instances.len() as u32).filter(move |&index| {
                let is_moving = instance_moves(parts, node_moves, index) || changing.has(parts, index);
                is_moving == moves && is_shared[index as usize] == shared
            })
        };
        let (mut still, mut moving): (Vec<u32>, Vec<u32>) = (lot(false, false).collect(), Vec::new());
        let (mut shared, mut still_shared) = (Vec::new(), 0);
        if sharing.flattened {
            still.extend(lot(false, true));
            moving.extend(lot(true, true));
        } else {
            shared.extend(lot(false, true));
            still_shared = shared.len();
            shared.extend(lot(true, true));
        }
        moving.extend(lot(true, false));

        let camera_pose = camera_pose(parts, &camera, 0.0);
        let frame = Frame {
            scene: Arc::clone(&scene),
            time_secs: 0.0,
            camera: camera_pose,
            previous_camera: camera_pose,
            static_counts: StaticCounts::default(),
            triangles: Vec::new(),
            previous_moving: Vec::new(),
            triangle_object: Vec::new(),
            objects: Vec::new(),
            opacity_slot: Vec::new(),
            opacities: Vec::new(),
            deformed_normals: Vec::new(),
            morphed_attributes: Vec::new(),
            properties: Properties::at(parts, 0.0),
            instances: Instances::default(),
            lights: Vec::new(),
            is_still: true,
        };
        let first_particle_id = parts.instances.iter().map(|instance| instance.id + 1).max().unwrap_or(0);
        let mut animator =
            Self { camera, own_pose: None, moving, first_particle_id, quads: Vec::new(), frame };
        let pose = NodePose::at(parts, 0.0);
        for index in still {
            animator.emit_instance(&pose, index);
        }
        let frame = &mut animator.frame;
        frame.deformed_normals.clear();
        frame.static_counts = StaticCounts {
            triangles: frame.triangles.len(),
            objects: frame.objects.len(),
            opacities: frame.opacities.len(),
            instances: still_shared,
        };
        let placed: Vec<(u32, Affine3A)> =
            shared.into_iter().map(|index| (index, world_from_object(parts, &pose, index))).collect();
        frame.instances = Instances::new(parts, &placed, frame.triangles.len() as u32);
        animator.advance(0.0, 0.0);
        animator
    }

    /// The frame of the last [`Self::advance`].
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// From the next [`Self::advance`] on, the scene is seen from this pose, and no longer from its camera,
    /// until another is given: for cameras that a user moves. Motion vectors point to the pose of the frame
    /// before, whichever it was.
    pub fn look_from(&mut self, pose: CameraPose) {
        self.own_pose = Some(pose);
    }

    /// Moves to a time; motion vectors will point to where things were at `previous_secs`.
    pub fn advance(&mut self, time_secs: f32, previous_secs: f32) -> &Frame {
        let scene = Arc::clone(&self.frame.scene);
        let (shown_secs, shown_camera) = (self.frame.time_secs, self.frame.camera);
        self.frame.time_secs = time_secs;
        let pose_at = |time_secs| camera_pose(scene.parts(), &self.camera, time_secs);
        (self.frame.camera, self.frame.previous_camera) = match self.own_pose {
            Some(pose) => (pose, self.frame.camera),
            None => (pose_at(time_secs), pose_at(previous_secs)),
        };

        // Materials and visibility, which are those of the moment also where things were.
        self.frame.properties = Properties::at(scene.parts(), time_secs);
        let previous_properties =
            (previous_secs != time_secs).then(|| Properties::at(scene.parts(), previous_secs));

        // Meshes: first where they were, then where they are.
        self.truncate_to_static();
        let has_lights = !scene.parts().lights.is_empty();
        let still_instances = self.frame.static_counts.instances;
        let moves = !self.moving.is_empty() || still_instances < self.frame.instances().len();
        let previous_pose = ((moves || has_lights) && previous_secs != time_secs)
            .then(|| NodePose::at(scene.parts(), previous_secs));
        if let Some(pose) = &previous_pose {
            self.emit_moving(pose);
        }
        let mut previous = std::mem::take(&mut self.frame.previous_moving);
        previous.clear();
        previous.extend_from_slice(&self.frame.triangles[self.frame.static_count()..]);
        let previous_attributes = std::mem::take(&mut self.frame.morphed_attributes);
        let previous_normals = std::mem::take(&mut self.frame.deformed_normals);
        self.truncate_to_static();
        let pose = NodePose::at(scene.parts(), time_secs);
        self.emit_moving(&pose);
        if previous_secs == time_secs {
            previous.clear();
            previous.extend_from_slice(&self.frame.triangles[self.frame.static_count()..]);
        }
        self.frame.previous_moving = previous;
        for instance in &mut self.frame.instances.list_mut()[still_instances..] {
            let now = world_from_object(scene.parts(), &pose, instance.source);
            let before = previous_pose.as_ref();
            let before = before.map_or(now, |pose| world_from_object(scene.parts(), pose, instance.source));
            instance.move_to(before, now);
        }

        let is_same = previous_secs == time_secs && self.frame.previous_camera == self.frame.camera;
        let was_shown = previous_secs == shown_secs && self.frame.previous_camera == shown_camera;
        let mut shown = std::mem::take(&mut self.quads).into_iter();
        let mut next_id = self.first_particle_id;
        for system in &scene.parts().particles {
            let shown = shown.next();
            let before = match &shown {
                _ if is_same => Before::Here,
                Some(quads) if was_shown => Before::AsShown(quads),
                _ => Before::Elsewhere,
            };
            self.emit_particles(system, next_id, time_secs, previous_secs, before);
            next_id += system.particles.len() as u32;
        }
        self.frame.lights.clear();
        self.frame.lights.extend(lights_at(scene.parts(), &pose, &self.frame.properties));

        // Particles change their opacity even where they stay.
        let frame = &mut self.frame;
        let lives = previous_secs != time_secs && !scene.parts().particles.is_empty();
        frame.is_still = frame.camera == frame.previous_camera
            && !lives
            && frame.previous_moving == frame.triangles[frame.static_counts.triangles..]
            && frame.instances()[still_instances..].iter().all(MeshInstance::is_still)
            && (previous_secs == time_secs
                || (previous_attributes == frame.morphed_attributes
                    && previous_normals == frame.deformed_normals))
            && previous_properties.as_ref().is_none_or(|previous| *previous == frame.properties)
            && previous_pose.is_none_or(|pose| {
                lights_at(scene.parts(), &pose, &frame.properties).eq(frame.lights.iter().copied())
            });
        &self.frame
    }

    fn truncate_to_static(&mut self) {
        let frame = &mut self.frame;
        let StaticCounts { triangles, objects, opacities, instances: _ } = frame.static_counts;
        frame.triangles.truncate(triangles);
        frame.triangle_object.truncate(triangles);
        frame.opacity_slot.truncate(triangles);
        frame.objects.truncate(objects);
        frame.opacities.truncate(opacities);
        frame.deformed_normals.clear();
        frame.morphed_attributes.clear();
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
        if self.frame.properties.hides(instance.node) {
            return;
        }
        let mesh = &parts.meshes[instance.mesh as usize];
        let material = &self.frame.materials()[mesh.material as usize].clone();
        let world_from_object = world_from_object(parts, pose, index);
        let frame = &mut self.frame;

        // Triangles in world, and where their other attributes come from.
        let deforms = instance.skin.is_some() || !mesh.morph_targets.is_empty();
        let morphed = if deforms { morph_attributes(parts, pose, index) } else { None };
        let look = if deforms {
            let first_normal = (!mesh.normals.is_empty()).then_some(frame.deformed_normals.len() as u32);
            let positions = deform(parts, pose, index, world_from_object, &mut frame.deformed_normals);
            frame
                .triangles
                .extend(mesh.indices.iter().map(|corners| corners.map(|corner| positions[corner as usize])));
            let attributes = morphed.as_ref().map(|_| frame.morphed_attributes.len() as u32);
            Look::Deformed { mesh: instance.mesh, first_normal, attributes }
        } else {
            let corner = |corner: u32| world_from_object.transform_point3(mesh.positions[corner as usize]);
            frame.triangles.par_extend(mesh.indices.par_iter().map(|corners| corners.map(corner)));
            rigid_look(instance.mesh, &world_from_object)
        };
        // A skinned mesh does not follow its own node (glTF 2.0, 3.7.3.3).
        let mirrored = if instance.skin.is_none() { mirror_flag(&world_from_object) } else { 0 };

        // The object, and what the triangles share: flags, and that they are its triangles.
        let object = Object {
            id: instance.id,
            geometry: instance.geometry,
            material: mesh.material,
            first_triangle: frame.next_number(),
            look,
        };
        let flags = mirrored | material_flags(material);
        let count = mesh.indices.len();
        let first_triangle = frame.triangle_object.len();
        frame.triangle_object.extend(std::iter::repeat_n(frame.objects.len() as u32, count));
        frame.objects.push(object);
        // What is opaque all over needs no table; of all else the any-hit test reads an entry a triangle.
        if flags & OPAQUE != 0 {
            frame.opacity_slot.extend(std::iter::repeat_n(flags, count));
            frame.morphed_attributes.extend(morphed);
            return;
        }
        let lists = VertexLists::new(mesh, morphed.as_ref());
        for (primitive, corners) in mesh.indices.iter().enumerate() {
            let corners_in_world = &frame.triangles[first_triangle + primitive];
            let density = |uvs: &[Vec2; 3], texture: u32| {
                texel_density(corners_in_world, uvs, scene.samplers()[texture as usize].size())
            };
            frame.opacity_slot.push(flags | frame.opacities.len() as u32);
            frame.opacities.push(mesh_opacity(material, lists, *corners, density));
        }
        frame.morphed_attributes.extend(morphed);
    }

    /// Appends the living particles of a system.
    fn emit_particles(
        &mut self,
        system: &ParticleSystem,
        first_id: u32,
        time_secs: f32,
        previous_secs: f32,
        before: Before<'_>,
    ) {
        let scene = Arc::clone(&self.frame.scene);
        let material = &self.frame.materials()[system.material as usize].clone();
        let (camera, previous_camera) = (self.frame.camera, self.frame.previous_camera);
        let count = system.particles.len();
        let quads: Vec<Quad> = (0..count)
            .into_par_iter()
            .filter_map(|index| {
                let particle = system.state_at(index, time_secs)?;
                let alpha = particle.alpha * system.near_factor(camera.view_depth(particle.centre));
                if alpha <= 0.0 {
                    return None;
                }
                let axes = quad_axes(&camera, particle.rotation_rad);
                let corners = quad_corners(&particle, axes);
                let known = match before {
                    Before::Here => Some(corners),
                    Before::AsShown(quads) => find(quads, index, count).map(|quad| quad.corners),
                    Before::Elsewhere => None,
                };
                let previous_corners = known.unwrap_or_else(|| {
                    system.state_at(index, previous_secs).map_or(corners, |particle| {
                        quad_corners(&particle, quad_axes(&previous_camera, particle.rotation_rad))
                    })
                });
                Some(Quad { index, alpha, axes, corners, previous_corners })
            })
            .collect();

        // Each list by itself: the numbers of what is appended are known.
        let frame = &mut self.frame;
        let first_number = frame.next_number();
        let first_object = frame.objects.len() as u32;
        let first_slot = tint_flag(material) | frame.opacities.len() as u32;
        let triangles = || (0..2 * quads.len()).into_par_iter().with_min_len(LEAST_TASK);
        frame.triangles.par_extend(triangles().map(|place| half(&quads[place / 2].corners, place % 2)));
        let previous = triangles().map(|place| half(&quads[place / 2].previous_corners, place % 2));
        frame.previous_moving.par_extend(previous);
        frame.triangle_object.par_extend(triangles().map(|place| first_object + place as u32 / 2));
        frame.opacity_slot.par_extend(triangles().map(|place| first_slot + place as u32));
        frame.opacities.par_extend(triangles().map(|place| {
            let quad = &quads[place / 2];
            let (tile_origin, tile_size) = system.tile(system.particles[quad.index].tile);
            let uvs = |_: &TextureRef| QUAD_UVS[place % 2].map(|local| tile_origin + local * tile_size);
            let density = |uvs: &[Vec2; 3], texture: u32| {
                texel_density(&half(&quad.corners, place % 2), uvs, scene.samplers()[texture as usize].size())
            };
            TriangleOpacity::new(material, [quad.alpha; 3], uvs, density)
        }));
        let objects = quads.par_iter().enumerate().with_min_len(LEAST_TASK);
        frame.objects.par_extend(objects.map(|(place, quad)| {
            let particle = &system.particles[quad.index];
            let (tile_origin, tile_size) = system.tile(particle.tile);
            let (right, up) = quad.axes;
            Object {
                id: first_id + quad.index as u32,
                geometry: 0,
                material: system.material,
                first_triangle: first_number + 2 * place as u32,
                look: Look::Quad { right, up, tile_origin, tile_size, tint: particle.tint },
            }
        }));
        self.quads.push(quads);
    }
}

/// The quad of a particle of a system of so many among those that live, which are ascending by their index.
fn find(quads: &[Quad], index: usize, count: usize) -> Option<&Quad> {
    // As many places before its index, at most, as there are particles that do not live.
    let first = (index + quads.len()).saturating_sub(count);
    let near = quads.get(first..quads.len().min(index + 1))?;
    let place = near.partition_point(|quad| quad.index < index);
    near.get(place).filter(|quad| quad.index == index)
}

/// Triangles of particles that a task appends at least.
const LEAST_TASK: usize = 1024;

fn lights_at<'a>(
    parts: &'a SceneParts,
    pose: &'a NodePose,
    properties: &'a Properties,
) -> impl Iterator<Item = FrameLight> + 'a {
    let of_surroundings = parts.environment.light.iter().map(|light| FrameLight {
        position: Vec3::ZERO,
        direction: -light.direction,
        intensity: light.irradiance,
        kind: LightKind::Directional,
    });
    let of_nodes = parts.lights.iter().enumerate().map(|(index, light)| {
        let world_from_node = pose.world_from_node[light.node as usize];
        FrameLight {
            position: world_from_node.translation.into(),
            direction: world_from_node.transform_vector3(Vec3::NEG_Z).normalize_or(Vec3::NEG_Y),
            intensity: properties.intensity(index, light.node, light.intensity),
            kind: properties.kind(index, light.kind),
        }
    });
    of_nodes.chain(of_surroundings)
}

/// The lights of a scene at a time.
#[must_use]
pub fn scene_lights(scene: &Scene, time_secs: f32) -> Vec<FrameLight> {
    let parts = scene.parts();
    let (pose, properties) = (NodePose::at(parts, time_secs), Properties::at(parts, time_secs));
    lights_at(parts, &pose, &properties).collect()
}

/// Where an instance is that its node moves.
fn world_from_object(parts: &SceneParts, pose: &NodePose, index: u32) -> Affine3A {
    let instance = &parts.instances[index as usize];
    pose.world_from_node[instance.node as usize] * instance.node_from_object
}

impl Frame {
    /// The number of the triangle that is stored next: behind those of instances, once these are there.
    fn next_number(&self) -> u32 {
        self.triangle_object.len() as u32 + self.instances.numbers().len() as u32
    }
}

/// Unit axes of a quad that faces the camera, turned in its plane.
fn quad_axes(camera: &CameraPose, rotation_rad: f32) -> (Vec3, Vec3) {
    let axes = camera.world_from_camera.matrix3;
    let (right, up) = (Vec3::from(axes.x_axis), Vec3::from(axes.y_axis));
    let (sin, cos) = rotation_rad.sin_cos();
    (right * cos + up * sin, up * cos - right * sin)
}

/// Lower left, lower right, upper right, upper left.
fn quad_corners(particle: &ParticleState, (right, up): (Vec3, Vec3)) -> [Vec3; 4] {
    let (centre, right, up) = (particle.centre, right * particle.half_size, up * particle.half_size);
    [centre - right - up, centre + right - up, centre + right + up, centre - right + up]
}

/// One of the two triangles of a quad, its corners in the order of [`QUAD_UVS`].
fn half(&[low_left, low_right, high_right, high_left]: &[Vec3; 4], which: usize) -> [Vec3; 3] {
    if which == 0 { [low_left, low_right, high_right] } else { [low_left, high_right, high_left] }
}
