//! Puts a scene together: hands out indices and object ids, so that the scenes themselves speak of things.
//!
//! Kits bring whole palettes of materials, of which a scene uses a few, and painting their textures takes
//! longer than all the rest. So a texture comes as the function that paints it: [`SceneBuilder::finish`]
//! leaves out what no surface has, and paints what is left in parallel.

use std::{mem, sync::Arc};

use glam::{Affine3A, Mat3, Quat, Vec3};
use rayon::prelude::*;
use sheer_image::Image;
use sheer_scene::{
    Scene, SceneError,
    camera::Camera,
    environment::Environment,
    model::{
        Animation, Channel, Filter, Influence, Instance, Keys, Light, LightKind, Material, Mesh,
        Minification, MorphTarget, Node, SceneParts, Skin, Texture, Track, Transform, Wrap,
    },
    particle::ParticleSystem,
};

use crate::{
    paint::Painting,
    shape::{Model, Shape},
};

/// Paints images that belong together, of the same surface.
type Painter = Box<dyn FnOnce() -> Vec<Image<[u8; 4]>> + Send>;

/// A scene in the making.
pub(crate) struct SceneBuilder {
    /// Everything but the textures.
    parts: SceneParts,
    textures: Vec<PlannedTexture>,
    paintings: Vec<Painter>,
}

/// A texture whose image is painted once it is known that something shows it.
struct PlannedTexture {
    name: String,
    srgb: bool,
    /// Index of the function that paints it, and which of the function's images it is.
    painting: usize,
    layer: usize,
}

/// Meshes that are placed together.
#[derive(Clone)]
pub(crate) struct Prop {
    name: String,
    meshes: Vec<u32>,
}

impl SceneBuilder {
    pub(crate) fn new(name: &str, environment: Environment) -> Self {
        Self {
            parts: SceneParts { name: name.to_owned(), exposure: 1.0, environment, ..SceneParts::default() },
            textures: Vec::new(),
            paintings: Vec::new(),
        }
    }

    /// Adds a tiling texture of sRGB colours; returns its index. It is painted only if something shows it.
    pub(crate) fn texture(
        &mut self,
        name: &str,
        paint: impl FnOnce() -> Image<[u8; 4]> + Send + 'static,
    ) -> u32 {
        self.paintings.push(Box::new(move || vec![paint()]));
        self.plan_texture(name.to_owned(), true, 0)
    }

    /// Adds the three tiling textures of a painted surface; returns the indices of its colours, its normals,
    /// and its occlusion and roughness. They are painted only if something shows them.
    pub(crate) fn painted_surface(
        &mut self,
        name: &str,
        paint: impl FnOnce() -> Painting + Send + 'static,
    ) -> [u32; 3] {
        self.paintings.push(Box::new(move || {
            let Painting { colour, normal, surface } = paint();
            vec![colour, normal, surface]
        }));
        let layers = [("colour", true), ("normal", false), ("surface", false)];
        std::array::from_fn(|layer| {
            let (kind, srgb) = layers[layer];
            self.plan_texture(format!("{name} {kind}"), srgb, layer)
        })
    }

    /// A texture of the last function.
    fn plan_texture(&mut self, name: String, srgb: bool, layer: usize) -> u32 {
        let painting = self.paintings.len() - 1;
        self.textures.push(PlannedTexture { name, srgb, painting, layer });
        self.textures.len() as u32 - 1
    }

    /// Adds a material; returns its index.
    pub(crate) fn material(&mut self, material: Material) -> u32 {
        self.parts.materials.push(material);
        self.parts.materials.len() as u32 - 1
    }

    /// Adds the meshes of a model, one a material, to be placed any number of times.
    pub(crate) fn prop(&mut self, name: &str, model: Model) -> Prop {
        let first = self.parts.meshes.len() as u32;
        self.parts.meshes.extend(model.into_shapes().map(|(material, shape)| mesh(name, material, shape)));
        Prop { name: name.to_owned(), meshes: (first..self.parts.meshes.len() as u32).collect() }
    }

    /// Places a prop as one object: its meshes share an object id.
    pub(crate) fn place(&mut self, prop: &Prop, world_from_object: Affine3A) {
        let node = self.node(&prop.name, Transform::Matrix(world_from_object));
        self.hang(prop, node);
    }

    /// Places a prop as one object that moves with the clip.
    pub(crate) fn place_moving(&mut self, prop: &Prop, rest: Transform, tracks: Vec<Track>) {
        let node = self.node(&prop.name, rest);
        self.hang(prop, node);
        self.move_by("clip", node, tracks);
    }

    /// Hangs a prop on a node, as an object of its own that goes where the node goes.
    pub(crate) fn hang(&mut self, prop: &Prop, node: u32) {
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

    /// Adds a node whose instances are mixed from their poses by these weights (see [`Self::sway`]).
    pub(crate) fn swaying_node(&mut self, name: &str, weights: Keys<Vec<f32>>) -> u32 {
        let node = self.node(name, Transform::IDENTITY);
        self.move_by(name, node, vec![Track::MorphWeights(weights)]);
        node
    }

    /// Places a model as one object that sways: `poses` are the model at rest and then with each weight of
    /// the node at 1, vertex by vertex.
    pub(crate) fn sway(&mut self, name: &str, node: u32, poses: &[Model]) {
        let Some((rest, extremes)) = poses.split_first() else { return };
        let prop = self.prop(name, rest.clone());
        let own = &mut self.parts.meshes[prop.meshes[0] as usize..];
        for extreme in extremes {
            for (mesh, (_, shape)) in own.iter_mut().zip(extreme.clone().into_shapes()) {
                let minus =
                    |pose: &[Vec3], rest: &[Vec3]| pose.iter().zip(rest).map(|(p, r)| *p - *r).collect();
                mesh.morph_targets.push(MorphTarget {
                    positions: minus(&shape.positions, &mesh.positions),
                    normals: minus(&shape.normals, &mesh.normals),
                    ..MorphTarget::default()
                });
            }
        }
        let first = self.parts.instances.len();
        self.hang(&prop, node);
        let weights = vec![0.0; extremes.len()];
        self.parts.instances[first..]
            .iter_mut()
            .for_each(|instance| instance.morph_weights = weights.clone());
    }

    /// Places a model that turns around a point of the world.
    pub(crate) fn spin(&mut self, name: &str, model: Model, around: Vec3, turns: Keys<Quat>) {
        let prop = self.prop(name, model);
        let node = self.node(name, Transform::from_translation(around));
        self.move_by(name, node, vec![Track::Rotation(turns)]);
        self.hang(&prop, node);
    }

    /// Adds tracks to the animation of that name, which loops by its longest.
    fn move_by(&mut self, animation: &str, node: u32, tracks: Vec<Track>) {
        let animations = &mut self.parts.animations;
        let at = animations.iter().position(|known| known.name == animation).unwrap_or_else(|| {
            animations.push(Animation { name: animation.to_owned(), ..Animation::default() });
            animations.len() - 1
        });
        animations[at].channels.extend(tracks.into_iter().map(|track| Channel { node, track }));
    }

    /// Adds a node that can be animated, in its parent's space or the world.
    pub(crate) fn joint(&mut self, name: &str, parent: Option<u32>, translation: Vec3) -> u32 {
        let joint = self.node(name, Transform::from_translation(translation));
        self.parts.nodes[joint as usize].parent = parent;
        joint
    }

    /// Hangs a model on a chain of joints that bends it: `influences` says of a vertex which joints pull at
    /// it, `origin_in_object` where each joint lies in the space of the model.
    pub(crate) fn drape(
        &mut self,
        name: &str,
        model: Model,
        joints: Vec<u32>,
        origin_in_object: &[Vec3],
        influences: impl Fn(Vec3) -> [Influence; 4],
    ) {
        let prop = self.prop(name, model);
        for &mesh in &prop.meshes {
            let mesh = &mut self.parts.meshes[mesh as usize];
            mesh.influences = mesh.positions.iter().flat_map(|&position| influences(position)).collect();
            mesh.influences_per_vertex = 4;
        }
        let node = joints[0];
        let inverse_bind = origin_in_object.iter().map(|&origin| Affine3A::from_translation(-origin));
        self.parts.skins.push(Skin { name: name.to_owned(), joints, inverse_bind: inverse_bind.collect() });
        let first = self.parts.instances.len();
        self.hang(&prop, node);
        let skin = Some(self.parts.skins.len() as u32 - 1);
        self.parts.instances[first..].iter_mut().for_each(|instance| instance.skin = skin);
    }

    /// Adds an animation; it loops by its own duration.
    pub(crate) fn animate(&mut self, animation: Animation) {
        self.parts.animations.push(animation);
    }

    /// Adds a model and places it once, as it stands.
    pub(crate) fn put(&mut self, name: &str, model: Model) {
        self.put_at(name, model, Affine3A::IDENTITY);
    }

    /// Adds a model and places it once.
    pub(crate) fn put_at(&mut self, name: &str, model: Model, world_from_object: Affine3A) {
        let prop = self.prop(name, model);
        self.place(&prop, world_from_object);
    }

    /// Adds the sun: `towards` points to it, `illuminance` is what it gives to a surface that faces it.
    pub(crate) fn sun(&mut self, towards: Vec3, illuminance: Vec3) {
        let node = self.aimed("sun", Vec3::ZERO, towards);
        self.light("sun", node, illuminance, LightKind::Directional);
    }

    /// Adds a spotlight that looks at a point, in candela; its cone is full inside the first angle and ends
    /// at the second.
    pub(crate) fn spot(&mut self, name: &str, at: Vec3, target: Vec3, candela: Vec3, cones_rad: [f32; 2]) {
        let node = self.aimed(name, at, at - target);
        let [inner_cone_rad, outer_cone_rad] = cones_rad;
        let kind = LightKind::Spot { range: f32::INFINITY, inner_cone_rad, outer_cone_rad };
        self.light(name, node, candela, kind);
    }

    /// A node whose -Z leads away from `back`.
    fn aimed(&mut self, name: &str, translation: Vec3, back: Vec3) -> u32 {
        let back = back.normalize();
        let right = Vec3::Y.cross(back).normalize();
        let rotation = Quat::from_mat3(&Mat3::from_cols(right, back.cross(right), back));
        self.node(name, Transform::Trs { translation, rotation, scale: Vec3::ONE })
    }

    /// Adds a lamp that shines all around, in candela.
    pub(crate) fn lamp(&mut self, name: &str, at: Vec3, candela: Vec3, range: f32) {
        let node = self.node(name, Transform::from_translation(at));
        self.lamp_on(name, node, candela, range);
    }

    /// Adds a lamp that shines all around, in candela, on a node that may move.
    pub(crate) fn lamp_on(&mut self, name: &str, node: u32, candela: Vec3, range: f32) {
        self.light(name, node, candela, LightKind::Point { range });
    }

    /// Adds a particle system.
    pub(crate) fn particles(&mut self, system: ParticleSystem) {
        self.parts.particles.push(system);
    }

    /// Adds a camera; the first one is the scene's default.
    pub(crate) fn camera(&mut self, camera: Camera) {
        self.parts.cameras.push(camera);
    }

    /// Leaves out what nothing shows, paints the textures and validates the scene.
    pub(crate) fn finish(mut self) -> Result<Scene, SceneError> {
        self.drop_unused_materials();
        self.paint_used_textures();
        Scene::new(self.parts)
    }

    /// Drops the materials that neither a mesh nor a particle has; the others keep their order.
    fn drop_unused_materials(&mut self) {
        let SceneParts { materials, meshes, particles, .. } = &mut self.parts;
        let of_meshes = meshes.iter_mut().map(|mesh| &mut mesh.material);
        let of_particles = particles.iter_mut().map(|system| &mut system.material);
        *materials = keep_used(mem::take(materials), of_meshes.chain(of_particles).collect());
    }

    /// Paints the textures that the materials have and drops the others.
    fn paint_used_textures(&mut self) {
        // Textures that no material has are dropped before anything is painted.
        let references = self.parts.materials.iter_mut().flat_map(|material| {
            let Material {
                base_colour_texture,
                metallic_roughness_texture,
                normal_texture,
                occlusion_texture,
                emissive_texture,
                ..
            } = material;
            [
                base_colour_texture,
                metallic_roughness_texture,
                normal_texture,
                occlusion_texture,
                emissive_texture,
            ]
        });
        let indices = references.flatten().map(|reference| &mut reference.texture).collect();
        let planned = keep_used(mem::take(&mut self.textures), indices);

        // One painting may be several textures: each is painted once, side by side with the others.
        let mut used = vec![false; self.paintings.len()];
        planned.iter().for_each(|texture| used[texture.painting] = true);
        let paintings = mem::take(&mut self.paintings).into_par_iter().zip(used);
        let images: Vec<Vec<Arc<Image<[u8; 4]>>>> = paintings
            .map(|(paint, used)| if used { paint().into_iter().map(Arc::new).collect() } else { Vec::new() })
            .collect();
        // What was planned becomes what the scene holds.
        let painted = |texture: PlannedTexture| Texture {
            name: texture.name,
            image: Arc::clone(&images[texture.painting][texture.layer]),
            srgb: texture.srgb,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
            minification: Minification::default(),
        };
        self.parts.textures = planned.into_iter().map(painted).collect();
    }

    fn node(&mut self, name: &str, transform: Transform) -> u32 {
        self.parts.nodes.push(Node { name: name.to_owned(), parent: None, transform });
        self.parts.nodes.len() as u32 - 1
    }

    fn light(&mut self, name: &str, node: u32, intensity: Vec3, kind: LightKind) {
        self.parts.lights.push(Light { name: name.to_owned(), node, intensity, kind });
    }
}

/// The items that an index refers to, in their order; the indices follow them.
fn keep_used<T>(items: Vec<T>, indices: Vec<&mut u32>) -> Vec<T> {
    let mut used = vec![false; items.len()];
    indices.iter().for_each(|index| used[**index as usize] = true);
    let mut next = 0;
    let renumbered: Vec<u32> = used
        .iter()
        .map(|&used| {
            let index = next;
            next += u32::from(used);
            index
        })
        .collect();
    indices.into_iter().for_each(|index| *index = renumbered[*index as usize]);
    items.into_iter().zip(used).filter_map(|(item, used)| used.then_some(item)).collect()
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

#[cfg(test)]
mod tests {
    use sheer_scene::model::TextureRef;

    use super::*;

    #[test]
    fn what_nothing_shows_is_neither_kept_nor_painted() {
        let mut builder = SceneBuilder::new("test", Environment::black());
        let unseen = builder.texture("unseen", || unreachable!("nothing shows it"));
        let seen = builder.texture("seen", || Image::from_fn(2, 2, |_, _| [1, 2, 3, 255]).unwrap());
        let [_, material] = [unseen, seen].map(|texture| {
            let base_colour_texture = Some(TextureRef::new(texture));
            builder.material(Material { base_colour_texture, ..Material::default() })
        });
        let mut model = Model::default();
        model.paint(material, Vec3::ONE).panel(Vec3::ZERO, Vec3::X, Vec3::Y);
        builder.put("panel", model);

        let scene = builder.finish().unwrap();
        let [material] = scene.parts().materials.as_slice() else { panic!("one is shown") };
        let [texture] = scene.parts().textures.as_slice() else { panic!("one is shown") };
        assert_eq!((scene.parts().meshes[0].material, texture.name.as_str()), (0, "seen"));
        assert_eq!(material.base_colour_texture, Some(TextureRef::new(0)));
    }
}
