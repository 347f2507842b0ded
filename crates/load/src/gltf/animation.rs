//! Animations: the first one, and every further one that moves nothing moved already.

use std::collections::{HashMap, HashSet};

use glam::{Quat, Vec2, Vec3, Vec4};
use sheer_scene::model::{
    Animation, Channel, Interpolation, Keys, Node, Property, SceneParts, TextureSlot, Track, Transform,
};

use super::{
    document::Document,
    node::{Hierarchy, unit_rotation},
    pointer::{self, Pointed},
    schema::{self, Index},
};
use crate::{Clip, LoadError, LoadWarning};

/// Where what an animation changes is in the scene.
pub(super) struct Targets<'t> {
    pub hierarchy: &'t Hierarchy,
    /// Scene index of each material of the file that is drawn.
    pub materials: &'t [Option<u32>],
    /// Of the materials of the scene that transmit the same all over what they do with a factor of 1.
    pub transmissions: &'t HashMap<u32, f32>,
    /// Index in the file of each light of the scene.
    pub lights: &'t [Index],
    /// Index in the file of each camera of the scene.
    pub cameras: &'t [Index],
}

/// The animations that play together, and all that there are. Nodes with a matrix that are animated get their
/// transform taken apart.
pub(super) fn read(
    document: &Document<'_>,
    targets: &Targets<'_>,
    parts: &mut SceneParts,
) -> Result<(Vec<Animation>, Vec<Clip>), LoadError> {
    let mut clips: Vec<Clip> = (document.root.animations.iter())
        .map(|clip| Clip { name: clip.name.clone().unwrap_or_default(), duration_secs: 0.0, plays: false })
        .collect();
    let mut taken: HashSet<String> = HashSet::new();
    let mut animations = Vec::new();
    for (index, animation) in document.root.animations.iter().enumerate() {
        let place = format!("animations[{index}]");
        if !document.choices.plays(index) {
            continue;
        }
        let mut pointers =
            animation.channels.iter().filter_map(|channel| pointer::of_target(&channel.target));
        if pointers.any(|pointer| taken.contains(&pointer)) {
            document.warn(LoadWarning::AnimationSkipped { place: document.titled(&place) });
            continue;
        }
        let mut read = Animation { name: animation.name.clone().unwrap_or_default(), ..Animation::default() };
        let mut composed = HashMap::new();
        for (number, channel) in animation.channels.iter().enumerate() {
            let place = format!("{place}.channels[{number}]");
            let Some(pointer) = pointer::of_target(&channel.target) else { continue };
            if !taken.insert(pointer.clone()) {
                document.repaired(&place, "another channel moves the same property: left out");
                continue;
            }
            let reader = ChannelReader { document, targets, animation, channel, place: &place };
            document.salvage(reader.read(&pointer, &mut read, &mut composed, parts), "left out")?;
        }
        if !read.channels.is_empty() || !read.properties.is_empty() {
            clips[index].plays = true;
            clips[index].duration_secs = read.duration_secs();
            animations.push(read);
        }
    }
    // What an animation would have shown that is not played stays hidden.
    let is_animated = |node: u32| {
        let mut properties = animations.iter().flat_map(|animation| &animation.properties);
        properties
            .any(|property| matches!(property, Property::Visibility { node: other, .. } if *other == node))
    };
    let hidden: Vec<Property> = (targets.hierarchy.hidden_at_rest.iter())
        .filter(|&&node| !is_animated(node))
        .map(|&node| Property::Visibility { node, visible: Keys::constant(0.0) })
        .collect();
    if !hidden.is_empty() {
        animations.push(Animation { properties: hidden, ..Animation::default() });
    }
    Ok((animations, clips))
}

/// A property that several channels make up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Composed {
    /// Of a material of the scene.
    Emissive(u32),
    /// Of a material of the scene.
    TextureTransform(u32, TextureSlot),
    /// Of a light of the file.
    Light(Index),
}

/// Where in an animation the properties are that several channels make up.
type ComposedAt = HashMap<Composed, usize>;

/// The scene's indices of what has an index in the file.
fn hung(file_indices: &[Index], wanted: Index) -> Vec<u32> {
    (0..).zip(file_indices).filter(|(_, index)| **index == wanted).map(|(at, _)| at).collect()
}

/// One channel and what it belongs to.
struct ChannelReader<'c, 'd, 'a> {
    document: &'d Document<'a>,
    targets: &'c Targets<'c>,
    animation: &'d schema::Animation,
    channel: &'d schema::AnimationChannel,
    place: &'c str,
}

impl ChannelReader<'_, '_, '_> {
    /// Adds what the channel changes.
    fn read(
        &self,
        pointer: &str,
        read: &mut Animation,
        composed: &mut ComposedAt,
        parts: &mut SceneParts,
    ) -> Result<(), LoadError> {
        let Some(pointed) = pointer::parse(pointer) else {
            self.cannot_be_animated(pointer);
            return Ok(());
        };
        match pointed {
            Pointed::Node { node, path } => {
                let sorted = self.targets.hierarchy.sorted(self.document, node, self.place)?;
                let Some(track) = self.track(node, path)? else { return Ok(()) };
                if !matches!(track, Track::MorphWeights(_)) {
                    take_apart(self.document, &mut parts.nodes[sorted as usize], self.place);
                }
                read.channels.push(Channel { node: sorted, track });
            }
            Pointed::Visibility { node } => {
                let node = self.targets.hierarchy.sorted(self.document, node, self.place)?;
                read.properties.push(Property::Visibility { node, visible: self.keys(|[value]| value)? });
            }
            Pointed::Lens { camera, which } => {
                self.document.get(&self.document.root.cameras, camera, "camera", self.place)?;
                let cameras = hung(self.targets.cameras, camera);
                let value = self.keys(|[value]| value)?;
                read.properties.push(Property::Lens { cameras, which, value });
            }
            Pointed::LightColour { light } | Pointed::LightIntensity { light } => {
                self.light(pointed, light, &mut read.properties, composed)?;
            }
            Pointed::LightShape { light, which } => {
                let all = &self.document.root.extensions.lights_punctual.lights;
                self.document.get(all, light, "light", self.place)?;
                let lights = hung(self.targets.lights, light);
                let value = self.keys(|[value]| value)?;
                read.properties.push(Property::LightShape { lights, which, value });
            }
            Pointed::BaseColour { material }
            | Pointed::Transmission { material }
            | Pointed::EmissiveFactor { material }
            | Pointed::EmissiveStrength { material }
            | Pointed::Factor { material, .. }
            | Pointed::TextureTransform { material, .. } => {
                let all = &self.document.root.materials;
                let described = self.document.get(all, material, "material", self.place)?;
                // One that nothing is drawn in has no effect anyway.
                if let Some(index) = self.targets.materials[material] {
                    self.material(pointer, pointed, described, index, &mut read.properties, composed, parts)?;
                }
            }
        }
        Ok(())
    }

    fn cannot_be_animated(&self, pointer: &str) {
        let (place, pointer) = (self.document.titled(self.place), pointer.to_owned());
        self.document.warn(LoadWarning::NotAnimated { place, pointer });
    }

    /// A light of the file, which hangs on any number of nodes.
    fn light(
        &self,
        pointed: Pointed<'_>,
        light: Index,
        properties: &mut Vec<Property>,
        composed: &mut ComposedAt,
    ) -> Result<(), LoadError> {
        let all = &self.document.root.extensions.lights_punctual.lights;
        let described = self.document.get(all, light, "light", self.place)?;
        let at = *composed.entry(Composed::Light(light)).or_insert_with(|| {
            properties.push(Property::LightIntensity {
                lights: hung(self.targets.lights, light),
                colour: Keys::constant(described.color.into()),
                intensity: Keys::constant(described.intensity),
            });
            properties.len() - 1
        });
        if let Property::LightIntensity { colour, intensity, .. } = &mut properties[at] {
            match pointed {
                Pointed::LightColour { .. } => *colour = self.keys(<Vec3 as From<[f32; 3]>>::from)?,
                _ => *intensity = self.keys(|[value]| value)?,
            }
        }
        Ok(())
    }

    /// A value of a material, by its description and its index in the scene.
    #[expect(clippy::too_many_arguments, reason = "the parts of one scene and of one file, each used once")]
    fn material(
        &self,
        pointer: &str,
        pointed: Pointed<'_>,
        described: &schema::Material,
        material: u32,
        properties: &mut Vec<Property>,
        composed: &mut ComposedAt,
        parts: &SceneParts,
    ) -> Result<(), LoadError> {
        match pointed {
            Pointed::BaseColour { .. } if described.extensions.specular_glossiness.is_some() => {
                self.cannot_be_animated(pointer);
            }
            Pointed::BaseColour { .. } => {
                let mut factor = self.keys(Vec4::from_array)?;
                // Of what transmits light the alpha is lowered, and was none before where it is opaque.
                let at_rest = &parts.materials[material as usize];
                let fades = described.alpha_mode.as_deref() == Some("BLEND");
                if fades && self.targets.transmissions.contains_key(&material) {
                    let kept = 1.0 - at_rest.transmission;
                    factor.values.iter_mut().for_each(|colour| colour.w *= kept);
                } else if described.extensions.transmission.is_some() {
                    factor.values.iter_mut().for_each(|colour| colour.w = 0.0);
                    factor.key_values_mut().for_each(|colour| colour.w = at_rest.base_colour.w);
                }
                properties.push(Property::BaseColour { material, factor });
            }
            Pointed::Transmission { .. } => match self.targets.transmissions.get(&material) {
                Some(most) => {
                    let share = self.keys(|[value]| value * most)?;
                    properties.push(Property::Transmission { material, share, lowers_alpha: true });
                }
                None => self.cannot_be_animated(pointer),
            },
            Pointed::Factor { which, .. } => {
                properties.push(Property::Factor { material, which, value: self.keys(|[value]| value)? });
            }
            Pointed::EmissiveFactor { .. } | Pointed::EmissiveStrength { .. } => {
                let at = *composed.entry(Composed::Emissive(material)).or_insert_with(|| {
                    let given = described.extensions.emissive_strength.as_ref();
                    properties.push(Property::Emissive {
                        material,
                        factor: Keys::constant(described.emissive_factor.into()),
                        strength: Keys::constant(given.map_or(1.0, |emissive| emissive.emissive_strength)),
                    });
                    properties.len() - 1
                });
                if let Property::Emissive { factor, strength, .. } = &mut properties[at] {
                    match pointed {
                        Pointed::EmissiveFactor { .. } => {
                            *factor = self.keys(<Vec3 as From<[f32; 3]>>::from)?;
                        }
                        _ => *strength = self.keys(|[value]| value)?,
                    }
                }
            }
            Pointed::TextureTransform { slot, part, .. } => {
                let at = *composed.entry(Composed::TextureTransform(material, slot)).or_insert_with(|| {
                    let rest = texture_transform(described, slot);
                    properties.push(Property::TextureTransform {
                        material,
                        slot,
                        offset: Keys::constant(rest.offset.into()),
                        rotation_rad: Keys::constant(rest.rotation),
                        scale: Keys::constant(rest.scale.into()),
                    });
                    properties.len() - 1
                });
                if let Property::TextureTransform { offset, rotation_rad, scale, .. } = &mut properties[at] {
                    match part {
                        "offset" => *offset = self.keys(<Vec2 as From<[f32; 2]>>::from)?,
                        "rotation" => *rotation_rad = self.keys(|[value]| value)?,
                        _ => *scale = self.keys(<Vec2 as From<[f32; 2]>>::from)?,
                    }
                }
            }
            Pointed::Node { .. }
            | Pointed::Visibility { .. }
            | Pointed::Lens { .. }
            | Pointed::LightColour { .. }
            | Pointed::LightIntensity { .. }
            | Pointed::LightShape { .. } => {}
        }
        Ok(())
    }

    /// Key times, how to go from one to the next, and where the values are.
    fn sampled(&self) -> Result<(Vec<f32>, Interpolation, Output<'_, '_>), LoadError> {
        let Self { document, place, .. } = *self;
        let samplers = &self.animation.samplers;
        let sampler = document.get(samplers, self.channel.sampler, "animation sampler", place)?;
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => {
                let problem = format!(
                    "interpolation '{other}' is not LINEAR, STEP or CUBICSPLINE; export the file again"
                );
                return Err(document.fault(place, problem));
            }
        };
        let times_secs = key_times(document, sampler.input, place)?;
        let value_count = times_secs.len() * interpolation.values_per_key();
        let output = Output { document, accessor: sampler.output, value_count, place };
        Ok((times_secs, interpolation, output))
    }

    fn keys<const N: usize, T>(&self, convert: impl Fn([f32; N]) -> T) -> Result<Keys<T>, LoadError> {
        let (times_secs, interpolation, output) = self.sampled()?;
        Ok(Keys { times_secs, values: output.values(convert)?, interpolation })
    }

    fn track(&self, node: Index, path: &str) -> Result<Option<Track>, LoadError> {
        let Self { document, place, .. } = *self;
        Ok(Some(match path {
            "translation" => Track::Translation(self.keys(<Vec3 as From<[f32; 3]>>::from)?),
            "scale" => Track::Scale(self.keys(<Vec3 as From<[f32; 3]>>::from)?),
            "rotation" => {
                let mut keys = self.keys(Quat::from_array)?;
                // Tangents, which stand before and after each spline key, have any length.
                let rotations = keys.key_values_mut();
                rotations.for_each(|value| *value = unit_rotation(document, value.to_array(), place));
                Track::Rotation(keys)
            }
            _ => {
                let Some(target_count) = morph_target_count(document, node) else {
                    document.repaired(
                        place,
                        "it moves the morph weights of a node without morph targets: left out",
                    );
                    return Ok(None);
                };
                let (times_secs, interpolation, output) = self.sampled()?;
                let values = output.weights(target_count)?;
                Track::MorphWeights(Keys { times_secs, values, interpolation })
            }
        }))
    }
}

/// How the file lays out a texture of a material.
fn texture_transform(described: &schema::Material, slot: TextureSlot) -> schema::TextureTransform {
    let metallic = described.pbr_metallic_roughness.as_ref();
    let info = match slot {
        TextureSlot::BaseColour => metallic.and_then(|metallic| metallic.base_color_texture.as_ref()),
        TextureSlot::MetallicRoughness => {
            metallic.and_then(|metallic| metallic.metallic_roughness_texture.as_ref())
        }
        TextureSlot::Normal => described.normal_texture.as_ref(),
        TextureSlot::Occlusion => described.occlusion_texture.as_ref(),
        TextureSlot::Emissive => described.emissive_texture.as_ref(),
    };
    info.and_then(|info| info.extensions.transform.clone()).unwrap_or_default()
}

/// Key times made strictly increasing: keys at one time, a common way to write a jump, are moved apart by the
/// least bits.
fn key_times(document: &Document<'_>, accessor: Index, place: &str) -> Result<Vec<f32>, LoadError> {
    let mut times = document.scalars(accessor, place)?;
    if times.is_empty() {
        return Err(
            document.fault(place, format!("accessor {accessor} holds no key times; export the file again"))
        );
    }
    // What the file says, and what became of it.
    let (mut last_read, mut last) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
    for (key, time) in times.iter_mut().enumerate() {
        let is_sound = time.is_finite() && *time >= last_read;
        last_read = *time;
        if is_sound && *time <= last {
            *time = last.next_up();
            document.repaired(place, "keys at the same time were moved apart");
        }
        if !is_sound {
            let problem = format!(
                "key {key} of accessor {accessor} is not later than the one before it; sort the keys and export the file again"
            );
            return Err(document.fault(place, problem));
        }
        last = *time;
    }
    Ok(times)
}

/// How many weights the mesh at a node has; `None` without a mesh or targets.
fn morph_target_count(document: &Document<'_>, node: Index) -> Option<usize> {
    let mesh = document.root.meshes.get(document.root.nodes.get(node)?.mesh?)?;
    mesh.primitives.first().map(|primitive| primitive.targets.len()).filter(|&count| count > 0)
}

/// The values of a sampler.
struct Output<'d, 'a> {
    document: &'d Document<'a>,
    accessor: Index,
    value_count: usize,
    place: &'d str,
}

impl Output<'_, '_> {
    fn values<const N: usize, T>(&self, convert: impl Fn([f32; N]) -> T) -> Result<Vec<T>, LoadError> {
        let values = self.document.floats::<N>(self.accessor, self.place)?;
        self.check_count(values.len(), self.value_count)?;
        self.check_finite(values.iter().flatten())?;
        Ok(values.into_iter().map(convert).collect())
    }

    /// One list of weights a value.
    fn weights(&self, target_count: usize) -> Result<Vec<Vec<f32>>, LoadError> {
        let values = self.document.scalars(self.accessor, self.place)?;
        self.check_count(values.len(), self.value_count.saturating_mul(target_count))?;
        self.check_finite(&values)?;
        self.document.charge(
            self.value_count,
            size_of::<Vec<f32>>() + target_count * size_of::<f32>(),
            self.place,
        )?;
        Ok(values.chunks_exact(target_count).map(<[f32]>::to_vec).collect())
    }

    fn check_count(&self, found: usize, wanted: usize) -> Result<(), LoadError> {
        if found == wanted {
            return Ok(());
        }
        let problem = format!(
            "accessor {} holds {found} values where its keys need {wanted}; export the file again",
            self.accessor
        );
        Err(self.document.fault(self.place, problem))
    }

    fn check_finite<'v>(&self, values: impl IntoIterator<Item = &'v f32>) -> Result<(), LoadError> {
        if values.into_iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        let problem = format!(
            "accessor {} holds a value that is not finite; repair the animation and export the file again",
            self.accessor
        );
        Err(self.document.fault(self.place, problem))
    }
}

/// Makes the transform of a node one that can be animated.
fn take_apart(document: &Document<'_>, node: &mut Node, place: &str) {
    if let Transform::Matrix(matrix) = node.transform {
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        let transform = Transform::Trs { translation, rotation, scale };
        node.transform = if transform.to_affine().is_finite() { transform } else { Transform::IDENTITY };
        document.repaired(place, "it moves a node with a matrix, which was taken apart");
    }
}
