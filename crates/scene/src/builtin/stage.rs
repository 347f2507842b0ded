//! Puts a scene together: hands out indices and object ids, so that the scenes themselves speak of things.

use std::sync::Arc;

use glam::{Affine3A, Mat3, Quat, Vec3};
use sheer_image::Image;

use super::shape::{Model, Shape};
use crate::{
    SceneError,
    camera::Camera,
    environment::Environment,
    model::{
        Animation, Channel, Filter, Instance, Light, LightKind, Material, Mesh, Node, SceneParts, Texture,
        Track, Transform, Wrap,
    },
    particle::ParticleSystem,
    scene::Scene,
};

/// A scene in the making.
pub(super) struct Stage {
    parts: SceneParts,
}

/// Meshes that are placed together.
#[derive(Clone)]
pub(super) struct Prop {
    name: String,
    meshes: Vec<u32>,
}

impl Stage {
    pub(super) fn new(name: &str, environment: Environment) -> Self {
        Self {
            parts: SceneParts { name: name.to_owned(), exposure: 1.0, environment, ..SceneParts::default() },
        }
    }

    /// Adds a tiling texture; returns its index.
    pub(super) fn texture(&mut self, name: &str, image: Image<[u8; 4]>, srgb: bool) -> u32 {
        self.parts.textures.push(Texture {
            name: name.to_owned(),
            image: Arc::new(image),
            srgb,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
        });
        self.parts.textures.len() as u32 - 1
    }

    /// Adds a material; returns its index.
    pub(super) fn material(&mut self, material: Material) -> u32 {
        self.parts.materials.push(material);
        self.parts.materials.len() as u32 - 1
    }

    /// Adds the meshes of a model, one a material, to be placed any number of times.
    pub(super) fn prop(&mut self, name: &str, model: Model) -> Prop {
        let first = self.parts.meshes.len() as u32;
        self.parts.meshes.extend(model.into_shapes().map(|(material, shape)| mesh(name, material, shape)));
        Prop { name: name.to_owned(), meshes: (first..self.parts.meshes.len() as u32).collect() }
    }

    /// Places a prop as one object: its meshes share an object id.
    pub(super) fn place(&mut self, prop: &Prop, world_from_object: Affine3A) {
        let node = self.node(&prop.name, Transform::Matrix(world_from_object));
        self.draw(prop, node);
    }

    /// Places a prop as one object that moves: the clip plays all tracks at once.
    pub(super) fn place_moving(&mut self, prop: &Prop, rest: Transform, tracks: Vec<Track>) {
        let node = self.node(&prop.name, rest);
        self.draw(prop, node);
        if self.parts.animations.is_empty() {
            self.parts.animations.push(Animation { name: "clip".to_owned(), channels: Vec::new() });
        }
        let channels = tracks.into_iter().map(|track| Channel { node, track });
        self.parts.animations[0].channels.extend(channels);
    }

    fn draw(&mut self, prop: &Prop, node: u32) {
        let id = self.parts.instances.last().map_or(0, |last| last.id + 1);
        self.parts.instances.extend((0..).zip(&prop.meshes).map(|(geometry, &mesh)| Instance {
            node,
            node_from_object: Affine3A::IDENTITY,
            mesh,
            id,
            geometry,
            skin: None,
            morph_weights: Vec::new(),
        }));
    }

    /// Adds a model and places it once, as it stands.
    pub(super) fn put(&mut self, name: &str, model: Model) {
        self.put_at(name, model, Affine3A::IDENTITY);
    }

    /// Adds a model and places it once.
    pub(super) fn put_at(&mut self, name: &str, model: Model, world_from_object: Affine3A) {
        let prop = self.prop(name, model);
        self.place(&prop, world_from_object);
    }

    /// Adds the sun: `towards` points to it, `illuminance` is what it gives to a surface that faces it.
    pub(super) fn sun(&mut self, towards: Vec3, illuminance: Vec3) {
        let back = towards.normalize();
        let right = Vec3::Y.cross(back).normalize();
        let rotation = Quat::from_mat3(&Mat3::from_cols(right, back.cross(right), back));
        let node = self.node("sun", Transform::Trs { translation: Vec3::ZERO, rotation, scale: Vec3::ONE });
        self.light("sun", node, illuminance, LightKind::Directional);
    }

    /// Adds a lamp that shines all around, in candela.
    pub(super) fn lamp(&mut self, name: &str, at: Vec3, candela: Vec3, range: f32) {
        let node = self.node(name, Transform::from_translation(at));
        self.light(name, node, candela, LightKind::Point { range });
    }

    pub(super) fn particles(&mut self, system: ParticleSystem) {
        self.parts.particles.push(system);
    }

    /// Adds a camera; the first one is the scene's default.
    pub(super) fn camera(&mut self, camera: Camera) {
        self.parts.cameras.push(camera);
    }

    pub(super) fn finish(self) -> Result<Scene, SceneError> {
        Scene::new(self.parts)
    }

    fn node(&mut self, name: &str, transform: Transform) -> u32 {
        self.parts.nodes.push(Node { name: name.to_owned(), parent: None, transform });
        self.parts.nodes.len() as u32 - 1
    }

    fn light(&mut self, name: &str, node: u32, intensity: Vec3, kind: LightKind) {
        self.parts.lights.push(Light { name: name.to_owned(), node, intensity, kind });
    }
}

fn mesh(name: &str, material: u32, shape: Shape) -> Mesh {
    Mesh {
        name: name.to_owned(),
        material,
        positions: shape.positions,
        normals: shape.normals,
        uv_sets: vec![shape.uvs],
        colours: shape.colours,
        indices: shape.indices,
        ..Mesh::default()
    }
}
