//! Materials, lights and visibility at a time.

use glam::{Vec3, Vec4};

use crate::model::{AlphaMode, Factor, LightKind, Material, Property, SceneParts, TextureRef, TextureSlot};

/// What animations make of materials, lights and visibility at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Properties {
    /// All materials, if one of them is animated.
    pub(super) materials: Vec<Material>,
    /// Intensity of each light, if that of one is animated.
    intensities: Vec<Vec3>,
    /// Shape of each light, if that of one is animated.
    kinds: Vec<LightKind>,
    /// Whether each node is hidden, by itself or a parent, if the visibility of one is animated.
    hidden: Vec<bool>,
}

impl Properties {
    pub(super) fn at(parts: &SceneParts, time_secs: f32) -> Self {
        let mut properties = Self::default();
        for animation in &parts.animations {
            let time_secs = animation.looped(time_secs);
            for property in &animation.properties {
                properties.apply(parts, property, time_secs);
            }
        }
        // What is taken out of an alpha comes after whatever sets it.
        for animation in &parts.animations {
            let time_secs = animation.looped(time_secs);
            for property in &animation.properties {
                properties.transmit(parts, property, time_secs);
            }
        }
        properties.kinds.iter_mut().for_each(|kind| *kind = kind.with_nested_cones());
        // What hangs on a hidden node is hidden: parents stand before their children.
        for index in 0..properties.hidden.len() {
            let parent = parts.nodes[index].parent;
            properties.hidden[index] |= parent.is_some_and(|parent| properties.hidden[parent as usize]);
        }
        properties
    }

    fn apply(&mut self, parts: &SceneParts, property: &Property, time_secs: f32) {
        match property {
            Property::BaseColour { material, factor } => {
                let colour = factor.value_at(time_secs).max(Vec4::ZERO).min(Vec3::MAX.extend(1.0));
                self.material(parts, *material).base_colour = colour;
            }
            Property::Emissive { material, factor, strength } => {
                let emissive = factor.value_at(time_secs) * strength.value_at(time_secs);
                self.material(parts, *material).emissive = emissive.clamp(Vec3::ZERO, Vec3::MAX);
            }
            Property::Factor { material, which, value } => {
                let material = self.material(parts, *material);
                let value = value.value_at(time_secs);
                let unit = value.clamp(0.0, 1.0);
                match which {
                    Factor::AlphaCutoff => {
                        if let AlphaMode::Mask { cutoff } = &mut material.alpha_mode {
                            *cutoff = value;
                        }
                    }
                    Factor::Metallic => material.metallic = unit,
                    Factor::Roughness => material.roughness = unit,
                    Factor::NormalScale => material.normal_scale = value,
                    Factor::OcclusionStrength => material.occlusion_strength = unit,
                }
            }
            Property::TextureTransform { material, slot, offset, rotation_rad, scale } => {
                if let Some(used) = self.material(parts, *material).texture_mut(*slot) {
                    used.transform = TextureRef::transform_of(
                        offset.value_at(time_secs),
                        rotation_rad.value_at(time_secs),
                        scale.value_at(time_secs),
                    );
                }
            }
            Property::LightIntensity { lights, colour, intensity } => {
                if self.intensities.is_empty() {
                    self.intensities.extend(parts.lights.iter().map(|light| light.intensity));
                }
                let value = colour.value_at(time_secs) * intensity.value_at(time_secs);
                for &light in lights {
                    self.intensities[light as usize] = value.clamp(Vec3::ZERO, Vec3::MAX);
                }
            }
            Property::LightShape { lights, which, value } => {
                if self.kinds.is_empty() {
                    self.kinds.extend(parts.lights.iter().map(|light| light.kind));
                }
                let value = value.value_at(time_secs);
                lights.iter().for_each(|&light| self.kinds[light as usize].set(*which, value));
            }
            // What a camera sees is part of its pose, and `Self::transmit` is for the other.
            Property::Lens { .. } | Property::Transmission { .. } => {}
            Property::Visibility { node, visible } => {
                self.hidden.resize(parts.nodes.len(), false);
                self.hidden[*node as usize] = visible.value_at(time_secs) < 0.5;
            }
        }
    }

    fn transmit(&mut self, parts: &SceneParts, property: &Property, time_secs: f32) {
        /// The transmission of a material is below 1.
        const MOST: f32 = 1.0 - f32::EPSILON;
        if let Property::Transmission { material, share, lowers_alpha } = property {
            let material = self.material(parts, *material);
            let at_rest =
                std::mem::replace(&mut material.transmission, share.value_at(time_secs).clamp(0.0, MOST));
            if *lowers_alpha {
                let alpha = material.base_colour.w * (1.0 - material.transmission) / (1.0 - at_rest);
                material.base_colour.w = alpha.min(1.0);
            }
        }
    }

    fn material(&mut self, parts: &SceneParts, index: u32) -> &mut Material {
        if self.materials.is_empty() {
            self.materials.clone_from(&parts.materials);
        }
        &mut self.materials[index as usize]
    }

    /// Intensity of a light, which is `at_rest` unless it is animated.
    pub(super) fn intensity(&self, light: usize, node: u32, at_rest: Vec3) -> Vec3 {
        if self.hides(node) {
            return Vec3::ZERO;
        }
        self.intensities.get(light).copied().unwrap_or(at_rest)
    }

    /// Shape of a light, which is `at_rest` unless it is animated.
    pub(super) fn kind(&self, light: usize, at_rest: LightKind) -> LightKind {
        self.kinds.get(light).copied().unwrap_or(at_rest)
    }

    /// Whether a node is hidden.
    pub(super) fn hides(&self, node: u32) -> bool {
        self.hidden.get(node as usize).copied().unwrap_or(false)
    }
}

/// What makes geometry or its opacity another one without moving it.
pub(super) struct Changing {
    /// Materials whose opacity changes.
    materials: Vec<bool>,
    /// Nodes that are shown and hidden.
    nodes: Vec<bool>,
}

impl Changing {
    pub(super) fn of(parts: &SceneParts) -> Self {
        let mut changing =
            Self { materials: vec![false; parts.materials.len()], nodes: vec![false; parts.nodes.len()] };
        for property in parts.animations.iter().flat_map(|animation| &animation.properties) {
            match property {
                Property::BaseColour { material, .. }
                | Property::Transmission { material, .. }
                | Property::Factor { material, which: Factor::AlphaCutoff, .. }
                | Property::TextureTransform { material, slot: TextureSlot::BaseColour, .. } => {
                    let is_opaque = parts.materials[*material as usize].alpha_mode == AlphaMode::Opaque;
                    changing.materials[*material as usize] |= !is_opaque;
                }
                Property::Visibility { node, .. } => changing.nodes[*node as usize] = true,
                Property::Emissive { .. }
                | Property::Factor { .. }
                | Property::TextureTransform { .. }
                | Property::LightIntensity { .. }
                | Property::LightShape { .. }
                | Property::Lens { .. } => {}
            }
        }
        for (index, node) in parts.nodes.iter().enumerate() {
            changing.nodes[index] |= node.parent.is_some_and(|parent| changing.nodes[parent as usize]);
        }
        changing
    }

    /// Whether an instance has to be made anew for each frame, even if it does not move.
    pub(super) fn has(&self, parts: &SceneParts, instance: u32) -> bool {
        let instance = &parts.instances[instance as usize];
        let material = parts.meshes[instance.mesh as usize].material;
        self.materials[material as usize] || self.nodes[instance.node as usize]
    }
}
