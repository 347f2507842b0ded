//! The scene: validation of its parts, its bounds and its default view.

use std::{collections::HashMap, sync::Arc};

use glam::{Affine3A, Vec3};

use crate::{
    SceneError,
    camera::{Camera, CameraMotion, CameraPose, Lens},
    content_hash,
    environment::Environment,
    framing::framing_camera,
    memory::SceneMemory,
    model::{AlphaMode, Keys, Mesh, Property, SceneParts, Track, Transform},
    texture::{MipChain, Sampler, samplers},
};

/// A scene that has been validated once: every index is in range, every number finite, every parent before
/// its children. Immutable.
#[derive(Clone, Debug)]
pub struct Scene {
    parts: SceneParts,
    /// Lowest and highest corner of everything at time zero.
    bounds: [Vec3; 2],
    /// Samplers, one for each texture of the parts.
    samplers: Vec<Sampler>,
    /// Width of the picture by its height, for which a view is made up.
    aspect: f32,
}

/// Which camera to look through (`--camera`).
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CameraChoice {
    /// The scene's first, or a three-quarter view where it has none.
    #[default]
    Default,
    /// The scene's camera of that name, or a circle around the middle of the scene that starts from the
    /// default view.
    Orbit,
    /// By name; built-in scenes have `static` and `path`, and every scene has a `static` one: its default
    /// camera at time zero.
    Named(String),
    /// A camera of the caller's own; one that hangs on a node hangs on that of the scene.
    Own(Camera),
}

/// The shape of a picture for which a view is made up unless the caller says: that of the default size.
const DEFAULT_ASPECT: f32 = 16.0 / 9.0;
/// Of a sphere around a point: what is reckoned from it does not vanish.
const LEAST_RADIUS: f32 = 1e-20;

impl Scene {
    /// Validates the parts and prepares lookups into their textures.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] names the first part that is wrong.
    pub fn new(parts: SceneParts) -> Result<Self, SceneError> {
        validate(&parts).map_err(|(place, problem)| SceneError::Invalid {
            scene: parts.name.clone(),
            place,
            problem,
        })?;
        let bounds = bounds_at_rest(&parts);
        let samplers = samplers(&parts);
        Ok(Self { parts, bounds, samplers, aspect: DEFAULT_ASPECT })
    }

    pub(crate) fn samplers(&self) -> &[Sampler] {
        &self.samplers
    }

    /// The levels of each texture of the parts; textures share those that are the same.
    pub fn mip_chains(&self) -> impl ExactSizeIterator<Item = &Arc<MipChain>> {
        self.samplers.iter().map(Sampler::chain)
    }

    /// The parts that the scene was made of.
    #[must_use]
    pub fn parts(&self) -> &SceneParts {
        &self.parts
    }

    /// The name by which reports call the scene.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.parts.name
    }

    /// Identifies what the scene holds: another part, or another value of one, is another hash; another name
    /// for the same is not. It takes about a nanosecond for each byte of vertices and texels.
    #[must_use]
    pub fn content_hash(&self) -> u64 {
        content_hash::of_parts(&self.parts)
    }

    /// What the scene takes in memory until its first ray is traced on the CPU, roughly.
    #[must_use]
    pub fn memory(&self) -> SceneMemory {
        SceneMemory::of(&self.parts)
    }

    /// Lowest and highest corner of a box around everything at rest, world; the cube of side 1 around the
    /// origin if there is nothing.
    #[must_use]
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    /// Centre and radius of a sphere around everything at rest; the radius is positive.
    #[must_use]
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        let [low, high] = self.bounds;
        // Halves first: the sum of two large numbers may be none.
        (0.5 * low + 0.5 * high, (0.5 * high - 0.5 * low).length().max(LEAST_RADIUS))
    }

    /// The same scene, whose default view, where it has no camera, fills a picture of `width` by `height`
    /// pixels.
    #[must_use]
    pub fn framed_for(mut self, [width, height]: [u32; 2]) -> Self {
        self.aspect = width.max(1) as f32 / height.max(1) as f32;
        self
    }

    /// The same scene with every material's opacity set to `alpha`, 0 to 1: opaque surfaces become that
    /// transparent, blended ones take it in place of their own factor (texture alpha stays), alpha-tested
    /// ones keep their cut-outs.
    #[must_use]
    pub fn with_alpha(mut self, alpha: f32) -> Self {
        for material in &mut self.parts.materials {
            material.opacity = alpha.clamp(0.0, 1.0);
            if material.alpha_mode == AlphaMode::Blend {
                material.base_colour.w = 1.0;
            }
        }
        let properties = self.parts.animations.iter_mut().flat_map(|animation| &mut animation.properties);
        for property in properties {
            match property {
                Property::BaseColour { factor, .. } => {
                    factor.values.iter_mut().for_each(|colour| colour.w = 0.0);
                    factor.key_values_mut().for_each(|colour| colour.w = 1.0);
                }
                Property::Transmission { lowers_alpha, .. } => *lowers_alpha = false,
                _ => {}
            }
        }
        self
    }

    /// The same scene in other surroundings.
    #[must_use]
    pub fn with_environment(mut self, environment: Environment) -> Self {
        self.parts.environment = environment;
        self
    }

    /// Resolves a camera choice to a camera.
    ///
    /// # Errors
    /// [`SceneError::NoCamera`] lists the cameras there are.
    pub fn camera(&self, choice: &CameraChoice) -> Result<Camera, SceneError> {
        match choice {
            CameraChoice::Default => Ok(self.default_camera()),
            CameraChoice::Own(camera) => Ok(camera.clone()),
            CameraChoice::Orbit => {
                if let Some(camera) = self.parts.cameras.iter().find(|camera| camera.name == "orbit") {
                    return Ok(camera.clone());
                }
                let start = self.default_camera();
                let pose = crate::frame::camera_pose(&self.parts, &start, 0.0);
                let (centre, radius) = self.bounding_sphere();
                // Orbit what the default view looks at: the point on its axis nearest to the middle of the
                // scene.
                let along = (centre - pose.eye()).dot(pose.forward()).max(0.1 * radius);
                let target = pose.eye() + pose.forward() * along;
                Ok(Camera::orbit(pose.lens, target, pose.eye()))
            }
            CameraChoice::Named(name) => {
                if let Some(camera) = self.parts.cameras.iter().find(|camera| camera.name == *name) {
                    return Ok(camera.clone());
                }
                if name == "static" {
                    let mut camera = self.default_camera();
                    let pose = crate::frame::camera_pose(&self.parts, &camera, 0.0);
                    camera.motion = CameraMotion::Still { world_from_camera: pose.world_from_camera };
                    return Ok(camera);
                }
                let mut names: Vec<&str> =
                    self.parts.cameras.iter().map(|camera| camera.name.as_str()).collect();
                for common in ["static", "orbit"] {
                    if !names.contains(&common) {
                        names.push(common);
                    }
                }
                let available = names.join(", ");
                Err(SceneError::NoCamera { scene: self.parts.name.clone(), wanted: name.clone(), available })
            }
        }
    }

    /// Where a camera of the scene is at a time.
    #[must_use]
    pub fn pose(&self, camera: &Camera, time_secs: f32) -> CameraPose {
        crate::frame::camera_pose(&self.parts, camera, time_secs)
    }

    fn default_camera(&self) -> Camera {
        let first = self.parts.cameras.first();
        first.cloned().unwrap_or_else(|| framing_camera(&self.parts, self.aspect))
    }
}

/// A place in the scene and what is wrong there.
type Fault = (String, String);

fn check(holds: bool, place: impl FnOnce() -> String, problem: &str) -> Result<(), Fault> {
    if holds { Ok(()) } else { Err((place(), problem.to_owned())) }
}

fn validate(parts: &SceneParts) -> Result<(), Fault> {
    validate_nodes(parts)?;
    validate_materials(parts)?;
    for (index, mesh) in parts.meshes.iter().enumerate() {
        validate_mesh(mesh, parts).map_err(|problem| (format!("mesh {index} '{}'", mesh.name), problem))?;
    }
    validate_instances(parts)?;
    validate_animations(parts)?;
    validate_particles(parts)?;
    validate_view(parts)
}

fn validate_nodes(parts: &SceneParts) -> Result<(), Fault> {
    for (index, node) in parts.nodes.iter().enumerate() {
        let place = || format!("node {index} '{}'", node.name);
        let parent_first = node.parent.is_none_or(|parent| (parent as usize) < index);
        check(parent_first, place, "its parent does not stand before it")?;
        check(node.transform.to_affine().is_finite(), place, "its transform is not finite")?;
    }
    for (index, skin) in parts.skins.iter().enumerate() {
        let place = || format!("skin {index} '{}'", skin.name);
        let joints_exist = skin.joints.iter().all(|&joint| (joint as usize) < parts.nodes.len());
        check(joints_exist, place, "a joint is not a node")?;
        check(
            skin.joints.len() == skin.inverse_bind.len(),
            place,
            "joints and inverse bind matrices differ in number",
        )?;
        check(
            skin.inverse_bind.iter().all(Affine3A::is_finite),
            place,
            "an inverse bind matrix is not finite",
        )?;
    }
    Ok(())
}

fn validate_materials(parts: &SceneParts) -> Result<(), Fault> {
    for (index, texture) in parts.textures.iter().enumerate() {
        let place = || format!("texture {index} '{}'", texture.name);
        check(texture.image.width() > 0 && texture.image.height() > 0, place, "its image is empty")?;
    }
    for (index, material) in parts.materials.iter().enumerate() {
        let place = || format!("material {index} '{}'", material.name);
        let textures = [
            material.base_colour_texture,
            material.metallic_roughness_texture,
            material.normal_texture,
            material.occlusion_texture,
            material.emissive_texture,
            material.thickness_texture,
        ];
        let exist = textures.iter().flatten().all(|used| (used.texture as usize) < parts.textures.len());
        check(exist, place, "it uses a texture that is not there")?;
        let finite = material.base_colour.is_finite() && material.emissive.is_finite();
        check(finite, place, "a factor is not finite")?;
        let ranged = [material.opacity, material.metallic, material.roughness, material.base_colour.w];
        check(ranged.iter().all(|value| (0.0..=1.0).contains(value)), place, "a factor is not in [0, 1]")?;
        check((0.0..1.0).contains(&material.transmission), place, "its transmission is not in [0, 1)")?;
        let body = [material.thickness].into_iter().chain(material.absorption.to_array());
        let is_sound = body.into_iter().all(|value| value >= 0.0 && value.is_finite());
        check(is_sound, place, "its thickness or absorption is below 0 or not finite")?;
    }
    Ok(())
}

fn validate_mesh(mesh: &Mesh, parts: &SceneParts) -> Result<(), String> {
    let vertex_count = mesh.positions.len();
    let fits = |length: usize| length == 0 || length == vertex_count;
    let say = |holds: bool, problem: &str| if holds { Ok(()) } else { Err(problem.to_owned()) };
    say((mesh.material as usize) < parts.materials.len(), "its material is not there")?;
    say(mesh.positions.iter().all(|position| position.is_finite()), "a position is not finite")?;
    say(fits(mesh.normals.len()), "normals and positions differ in number")?;
    say(fits(mesh.tangents.len()), "tangents and positions differ in number")?;
    say(mesh.tangents.is_empty() || !mesh.normals.is_empty(), "there are tangents without normals")?;
    say(fits(mesh.colours.len()), "colours and positions differ in number")?;
    say(
        mesh.uv_sets.iter().all(|set| set.len() == vertex_count),
        "a texture coordinate set is too short or long",
    )?;
    let in_range = mesh.indices.iter().flatten().all(|&index| (index as usize) < vertex_count);
    say(in_range, "an index is out of range")?;
    let influence_count = vertex_count.checked_mul(mesh.influences_per_vertex);
    say(influence_count == Some(mesh.influences.len()), "joint influences and positions differ in number")?;
    for target in &mesh.morph_targets {
        say(
            fits(target.positions.len()) && fits(target.normals.len()) && fits(target.tangents.len()),
            "a morph target is too short or long",
        )?;
        let uvs = &target.uv_sets;
        say(
            fits(target.colours.len()) && uvs.iter().all(|set| fits(set.len())),
            "a morph target is too short or long",
        )?;
        say(
            (target.colours.is_empty() || !mesh.colours.is_empty())
                && (target.tangents.is_empty() || !mesh.tangents.is_empty())
                && uvs.len() <= mesh.uv_sets.len(),
            "a morph target moves what the mesh does not have",
        )?;
        let vectors = target.positions.iter().chain(&target.normals).chain(&target.tangents);
        let finite = vectors.into_iter().all(|delta| delta.is_finite())
            && target.colours.iter().all(|delta| delta.is_finite())
            && uvs.iter().flatten().all(|delta| delta.is_finite());
        say(finite, "a morph displacement is not finite")?;
    }
    Ok(())
}

fn validate_instances(parts: &SceneParts) -> Result<(), Fault> {
    // Many instances may share a mesh with many influences.
    let most_joints: Vec<usize> = parts.meshes.iter().map(joint_count).collect();
    for (index, instance) in parts.instances.iter().enumerate() {
        let place = || format!("instance {index}");
        check((instance.node as usize) < parts.nodes.len(), place, "its node is not there")?;
        let mesh = parts.meshes.get(instance.mesh as usize);
        let mesh = mesh.ok_or_else(|| (place(), "its mesh is not there".to_owned()))?;
        check(instance.node_from_object.is_finite(), place, "its transform is not finite")?;
        let weights_fit = instance.morph_weights.len() == mesh.morph_targets.len();
        check(weights_fit, place, "morph weights and targets differ in number")?;
        if let Some(skin) = instance.skin {
            let skin = parts.skins.get(skin as usize);
            let skin = skin.ok_or_else(|| (place(), "its skin is not there".to_owned()))?;
            let joints_exist = most_joints[instance.mesh as usize] <= skin.joints.len();
            check(joints_exist, place, "a vertex refers to a joint that its skin does not have")?;
        }
    }
    Ok(())
}

fn keys_hold<T>(keys: &Keys<T>) -> bool {
    let times = &keys.times_secs;
    !times.is_empty()
        && keys.values.len() == times.len() * keys.interpolation.values_per_key()
        && times.iter().all(|time| time.is_finite())
        && times.windows(2).all(|pair| pair[0] < pair[1])
}

fn validate_property(property: &Property, parts: &SceneParts) -> Result<(), String> {
    let material = |index: &u32| (*index as usize) < parts.materials.len();
    let light = |index: &u32| (*index as usize) < parts.lights.len();
    let (exists, whole) = match property {
        Property::BaseColour { material: index, factor } => (material(index), keys_hold(factor)),
        Property::Emissive { material: index, factor, strength } => {
            (material(index), keys_hold(factor) && keys_hold(strength))
        }
        Property::Factor { material: index, value, .. } => (material(index), keys_hold(value)),
        Property::TextureTransform { material: index, offset, rotation_rad, scale, .. } => {
            (material(index), keys_hold(offset) && keys_hold(rotation_rad) && keys_hold(scale))
        }
        Property::Transmission { material: index, share, .. } => (material(index), keys_hold(share)),
        Property::LightIntensity { lights, colour, intensity } => {
            (lights.iter().all(light), keys_hold(colour) && keys_hold(intensity))
        }
        Property::LightShape { lights, value, .. } => (lights.iter().all(light), keys_hold(value)),
        Property::Lens { cameras, value, .. } => {
            (cameras.iter().all(|camera| (*camera as usize) < parts.cameras.len()), keys_hold(value))
        }
        Property::Visibility { node, visible } => ((*node as usize) < parts.nodes.len(), keys_hold(visible)),
    };
    if !exists {
        return Err("what it changes is not there".to_owned());
    }
    if !whole {
        return Err("its keys are not in order, or too few or many values belong to them".to_owned());
    }
    Ok(())
}

/// How many joints the vertices of a mesh refer to, by the greatest of their numbers.
fn joint_count(mesh: &Mesh) -> usize {
    mesh.influences.iter().map(|influence| usize::from(influence.joint) + 1).max().unwrap_or(0)
}

fn validate_animations(parts: &SceneParts) -> Result<(), Fault> {
    // The least and greatest number of weights that the instances at each node have.
    let mut weight_counts: HashMap<u32, [usize; 2]> = HashMap::new();
    for instance in &parts.instances {
        let count = instance.morph_weights.len();
        let [least, greatest] = weight_counts.entry(instance.node).or_insert([count; 2]);
        (*least, *greatest) = (count.min(*least), count.max(*greatest));
    }
    for (index, animation) in parts.animations.iter().enumerate() {
        for (number, property) in animation.properties.iter().enumerate() {
            validate_property(property, parts).map_err(|problem| {
                (format!("animation {index} '{}', property {number}", animation.name), problem)
            })?;
        }
        for (number, channel) in animation.channels.iter().enumerate() {
            let place = || format!("animation {index} '{}', channel {number}", animation.name);
            let node = parts.nodes.get(channel.node as usize);
            let node = node.ok_or_else(|| (place(), "its node is not there".to_owned()))?;
            let (whole, moves) = match &channel.track {
                Track::Translation(keys) | Track::Scale(keys) => (keys_hold(keys), true),
                Track::Rotation(keys) => (keys_hold(keys), true),
                Track::MorphWeights(keys) => (keys_hold(keys), false),
            };
            check(whole, place, "its keys are not in order, or too few or many values belong to them")?;
            let is_trs = matches!(node.transform, Transform::Trs { .. });
            check(!moves || is_trs, place, "its node has a matrix, which cannot be animated")?;
            if let Track::MorphWeights(keys) = &channel.track {
                let fits = |count: &usize| keys.values.iter().all(|weights| weights.len() == *count);
                let fit = weight_counts.get(&channel.node).is_none_or(|counts| counts.iter().all(fits));
                check(fit, place, "its weights and the mesh's morph targets differ in number")?;
            }
        }
    }
    Ok(())
}

fn validate_particles(parts: &SceneParts) -> Result<(), Fault> {
    for (index, system) in parts.particles.iter().enumerate() {
        let place = || format!("particle system {index} '{}'", system.name);
        check((system.material as usize) < parts.materials.len(), place, "its material is not there")?;
        check(system.atlas.iter().all(|&tiles| tiles > 0), place, "its atlas has no tiles")?;
        check(system.loop_secs.is_none_or(|secs| secs > 0.0), place, "its loop is not longer than nothing")?;
        let stirred = system.turbulence.amplitude == 0.0 || system.turbulence.scale > 0.0;
        check(stirred, place, "its turbulence has no scale")?;
        for particle in &system.particles {
            let finite = particle.origin.is_finite()
                && particle.velocity.is_finite()
                && particle.acceleration.is_finite()
                && particle.half_size.iter().all(|size| size.is_finite() && *size >= 0.0);
            check(finite, place, "a particle's motion or size is not finite")?;
            check((0.0..=1.0).contains(&particle.alpha), place, "a particle's alpha is not in [0, 1]")?;
            let lives = particle.lifetime_secs > 0.0
                && (particle.lifetime_secs.is_finite()
                    || (system.fade == [0.0; 2] && system.loop_secs.is_none()));
            check(lives, place, "a particle's lifetime is not positive, or endless with a fade or a loop")?;
        }
    }
    Ok(())
}

fn validate_view(parts: &SceneParts) -> Result<(), Fault> {
    for (index, light) in parts.lights.iter().enumerate() {
        let place = || format!("light {index} '{}'", light.name);
        check((light.node as usize) < parts.nodes.len(), place, "its node is not there")?;
        check(light.intensity.is_finite(), place, "its intensity is not finite")?;
    }
    for (index, camera) in parts.cameras.iter().enumerate() {
        let place = || format!("camera {index} '{}'", camera.name);
        let sees = match camera.lens {
            Lens::Perspective { yfov_rad } => yfov_rad > 0.0 && yfov_rad < std::f32::consts::PI,
            Lens::Orthographic { half_height } => half_height > 0.0 && half_height.is_finite(),
        };
        check(sees, place, "its field of view is empty or too wide")?;
        let clips = 0.0 <= camera.clip.near && camera.clip.near < camera.clip.far;
        check(clips, place, "its near plane is not in front of its far one")?;
        match &camera.motion {
            CameraMotion::Node(node) => {
                check((*node as usize) < parts.nodes.len(), place, "its node is not there")?;
            }
            CameraMotion::Still { world_from_camera } => {
                check(world_from_camera.is_finite(), place, "its place is not finite")?;
            }
            CameraMotion::Path { keys } => {
                let in_order = keys.windows(2).all(|pair| pair[0].time_secs < pair[1].time_secs);
                check(!keys.is_empty() && in_order, place, "its path has no keys, or they are not in order")?;
            }
            CameraMotion::Orbit { period_secs, .. } => {
                check(*period_secs > 0.0, place, "its orbit takes no time")?;
            }
        }
    }
    check(parts.exposure > 0.0 && parts.exposure.is_finite(), || "exposure".to_owned(), "it is not positive")
}

/// Corners of a box around everything at rest; the unit cube if there is nothing.
fn bounds_at_rest(parts: &SceneParts) -> [Vec3; 2] {
    let mut low = Vec3::INFINITY;
    let mut high = Vec3::NEG_INFINITY;
    for_each_point_at_rest(parts, &mut |point| {
        low = low.min(point);
        high = high.max(point);
    });
    if low.x > high.x { [Vec3::splat(-0.5), Vec3::splat(0.5)] } else { [low, high] }
}

/// Calls `visit` with each vertex at time zero and each particle's origin, in world.
fn for_each_point_at_rest(parts: &SceneParts, visit: &mut impl FnMut(Vec3)) {
    crate::frame::for_each_vertex_over_time(parts, &[0.0], visit);
    parts.particles.iter().flat_map(|system| &system.particles).for_each(|particle| visit(particle.origin));
}
