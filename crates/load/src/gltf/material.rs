//! Materials and their textures.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    sync::Arc,
};

use glam::{Vec2, Vec3, Vec4};
use sheer_scene::model::{
    AlphaMode, Filter, LevelFilter, Material, Minification, ShadingModel, Texture, TextureRef, Wrap,
};

use super::{
    bake,
    document::Document,
    image, pointer,
    schema::{self, Index, TextureInfo},
    texels::{Source, Texels},
};
use crate::{LoadError, LoadWarning};

/// How much of what a surface transmits counts as not covered. A little below one, so that clear glass keeps
/// a body to see.
const TRANSMISSION_SHARE: f32 = 0.85;

/// The materials used so far.
pub(super) struct Materials<'d, 'a> {
    document: &'d Document<'a>,
    materials: Vec<Material>,
    /// Scene index of each material of the file; the last is the default material.
    index_of: Vec<Option<u32>>,
    textures: Vec<Texels>,
    /// Scene index of each texture of the file, as sRGB colour or as linear data.
    texture_of: BTreeMap<(Index, bool), u32>,
    /// What to make of the images once they are decoded.
    bakes: Vec<Bake>,
    /// Materials of the file whose transmission is animated.
    fading: HashSet<Index>,
}

/// Something to compute when the images are decoded.
struct Bake {
    /// Index into the scene's materials.
    material: usize,
    /// Path of the material in the file.
    place: String,
    what: BakeKind,
}

enum BakeKind {
    /// Transmission becomes lower alpha.
    Transmission { strength: f32, texture: Option<TextureRef> },
    /// Specular-glossiness becomes metallic-roughness; the base colour slot holds the diffuse texture.
    Glossy { factors: bake::Glossy, texture: Option<TextureRef> },
}

/// Materials and textures of the scene, and of the materials that transmit the same all over, by their index,
/// what they do with a factor of 1.
type Finished = (Vec<Material>, Vec<Texture>, HashMap<u32, f32>);

/// A texture with its image decoded.
fn decoded(texels: &Texels, images: &image::Images) -> Texture {
    Texture {
        name: texels.name.clone(),
        image: Arc::clone(images.of(&texels.source)),
        srgb: texels.srgb,
        wrap: texels.wrap,
        filter: texels.filter,
        minification: texels.minification,
    }
}

impl<'d, 'a> Materials<'d, 'a> {
    pub(super) fn new(document: &'d Document<'a>) -> Self {
        Self {
            document,
            materials: Vec::new(),
            index_of: vec![None; document.root.materials.len() + 1],
            textures: Vec::new(),
            texture_of: BTreeMap::new(),
            bakes: Vec::new(),
            fading: pointer::animated_transmissions(document).collect(),
        }
    }

    /// Scene index of each material of the file that is drawn.
    pub(super) fn index_of(&self) -> &[Option<u32>] {
        &self.index_of
    }

    /// Scene index of a material of the file, or of the default one.
    pub(super) fn index(&mut self, material: Option<Index>, place: &str) -> Result<u32, LoadError> {
        let all = &self.document.root.materials;
        let found = match material {
            Some(index) => {
                let found = self.document.get(all, index, "material", place).map(|_| index);
                self.document.salvage(found, "drawn in the default material")?
            }
            None => None,
        };
        let slot = found.unwrap_or(all.len());
        if let Some(index) = self.index_of[slot] {
            return Ok(index);
        }
        let read = match all.get(slot) {
            Some(described) => self.read(slot, described)?,
            None => Material { name: "default".to_owned(), metallic: 1.0, ..Material::default() },
        };
        let index = self.materials.len() as u32;
        self.materials.push(read);
        self.index_of[slot] = Some(index);
        Ok(index)
    }
}

impl Materials<'_, '_> {
    fn read(&mut self, index: Index, described: &schema::Material) -> Result<Material, LoadError> {
        let place = format!("materials[{index}]");
        let fault = |problem: String| {
            self.document.fault(&place, format!("{problem}; correct it and export the file again"))
        };
        // What both models have in common.
        let alpha_mode = match described.alpha_mode.as_deref() {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask { cutoff: described.alpha_cutoff.unwrap_or(0.5) },
            Some("BLEND") => AlphaMode::Blend,
            Some(other) => {
                let fault = fault(format!("alpha mode '{other}' is not OPAQUE, MASK or BLEND"));
                self.document.lose(fault, "taken for OPAQUE")?;
                AlphaMode::Opaque
            }
        };
        let extensions = &described.extensions;
        let strength =
            extensions.emissive_strength.as_ref().map_or(1.0, |emissive| emissive.emissive_strength);
        let mut emissive = Vec3::from(described.emissive_factor) * strength;
        if !emissive.is_finite() {
            self.document.lose(fault("its emissive factor is not finite".to_owned()), "it does not shine")?;
            emissive = Vec3::ZERO;
        }
        let info =
            |slot: &Option<TextureInfo>, value: fn(&TextureInfo) -> f32| slot.as_ref().map_or(1.0, value);
        let mut material = Material {
            name: described.name.clone().unwrap_or_default(),
            model: if extensions.unlit.is_some() {
                ShadingModel::Unlit
            } else {
                ShadingModel::MetallicRoughness
            },
            alpha_mode,
            normal_texture: self.texture(&described.normal_texture, false, &place, "normalTexture")?,
            normal_scale: info(&described.normal_texture, |info| info.scale),
            occlusion_texture: self.texture(
                &described.occlusion_texture,
                false,
                &place,
                "occlusionTexture",
            )?,
            occlusion_strength: info(&described.occlusion_texture, |info| info.strength).clamp(0.0, 1.0),
            emissive,
            emissive_texture: self.texture(&described.emissive_texture, true, &place, "emissiveTexture")?,
            double_sided: described.double_sided,
            ..Material::default()
        };

        // Of a file that has both models the core's is the fallback for those who do not know the other
        // (KHR_materials_pbrSpecularGlossiness, "Best Practices"); unlit materials are defined by the core's.
        let is_unlit = extensions.unlit.is_some();
        match (&described.pbr_metallic_roughness, &extensions.specular_glossiness) {
            (given, Some(glossy)) if given.is_none() || !is_unlit => {
                self.read_specular_glossiness(&mut material, glossy, &place)?;
            }
            (given, _) => {
                let default = schema::MetallicRoughness::default();
                let given = given.as_ref().unwrap_or(&default);
                material.base_colour = self.factor(given.base_color_factor, &place)?;
                material.base_colour_texture =
                    self.texture(&given.base_color_texture, true, &place, "baseColorTexture")?;
                material.metallic = unit(given.metallic_factor);
                material.roughness = unit(given.roughness_factor);
                material.metallic_roughness_texture = self.texture(
                    &given.metallic_roughness_texture,
                    false,
                    &place,
                    "metallicRoughnessTexture",
                )?;
            }
        }
        // Transmission lowers the opacity, which is worked out when the images are there.
        if let Some(transmission) = &extensions.transmission {
            let texture =
                self.texture(&transmission.transmission_texture, false, &place, "transmissionTexture")?;
            let factor = unit(transmission.transmission_factor);
            if factor > 0.0 || self.fading.contains(&index) {
                let titled = self.document.titled(&place);
                self.document.warn(LoadWarning::UnrefractedTransmission { material: titled });
                if let Some(volume) = &extensions.volume {
                    self.read_volume(&mut material, volume, &place)?;
                }
                self.bakes.push(Bake {
                    material: self.materials.len(),
                    place,
                    what: BakeKind::Transmission { strength: TRANSMISSION_SHARE * factor, texture },
                });
            }
        }
        Ok(material)
    }

    /// `KHR_materials_volume`: Beer and Lambert's law, by the colour that is left after a distance.
    fn read_volume(
        &mut self,
        material: &mut Material,
        volume: &schema::Volume,
        place: &str,
    ) -> Result<(), LoadError> {
        let &schema::Volume { thickness_factor, attenuation_distance, .. } = volume;
        let colour = Vec3::from(volume.attenuation_color);
        let is_sound = thickness_factor >= 0.0
            && thickness_factor.is_finite()
            && attenuation_distance > 0.0
            && colour.is_finite();
        if !is_sound {
            let what = "its KHR_materials_volume has a thickness below 0, a distance that is not above 0, or a \
                        number that is not finite; what it absorbs was left out";
            self.document.repaired(place, what);
            return Ok(());
        }
        // Without a thickness the surface has no body; what is black is so from the least thickness on.
        if thickness_factor > 0.0 {
            let left = colour.clamp(Vec3::splat(f32::MIN_POSITIVE), Vec3::ONE);
            material.absorption = (-left.map(f32::ln) / attenuation_distance).min(Vec3::MAX);
            material.thickness = thickness_factor;
            material.thickness_texture =
                self.texture(&volume.thickness_texture, false, place, "thicknessTexture")?;
        }
        Ok(())
    }

    /// `KHR_materials_pbrSpecularGlossiness`: without textures converted here, else texel by texel when they
    /// are decoded.
    fn read_specular_glossiness(
        &mut self,
        material: &mut Material,
        glossy: &schema::SpecularGlossiness,
        place: &str,
    ) -> Result<(), LoadError> {
        let diffuse = self.factor(glossy.diffuse_factor, place)?;
        let factors = bake::Glossy {
            diffuse: diffuse.truncate(),
            specular: Vec3::from(glossy.specular_factor).clamp(Vec3::ZERO, Vec3::ONE),
            glossiness: unit(glossy.glossiness_factor),
        };
        material.base_colour_texture =
            self.texture(&glossy.diffuse_texture, true, place, "diffuseTexture")?;
        let texture =
            self.texture(&glossy.specular_glossiness_texture, true, place, "specularGlossinessTexture")?;
        if material.base_colour_texture.is_none() && texture.is_none() {
            let converted = factors.to_metallic();
            material.base_colour = converted.base_colour.extend(diffuse.w);
            material.metallic = converted.metallic;
            material.roughness = converted.roughness;
        } else {
            material.base_colour = Vec3::ONE.extend(diffuse.w);
            (material.metallic, material.roughness) = (1.0, 1.0);
            self.bakes.push(Bake {
                material: self.materials.len(),
                place: place.to_owned(),
                what: BakeKind::Glossy { factors, texture },
            });
        }
        Ok(())
    }

    fn factor(&self, factor: [f32; 4], place: &str) -> Result<Vec4, LoadError> {
        let factor = Vec4::from(factor);
        if !factor.is_finite() {
            let problem = "its colour factor is not finite; correct it and export the file again";
            self.document.lose(self.document.fault(place, problem), "taken for white")?;
            return Ok(Vec4::ONE);
        }
        Ok(factor.max(Vec4::ZERO).min(Vec3::MAX.extend(1.0)))
    }

    /// A use of a texture by a property of the material at a place; nothing where it is broken.
    fn texture(
        &mut self,
        info: &Option<TextureInfo>,
        srgb: bool,
        place: &str,
        property: &str,
    ) -> Result<Option<TextureRef>, LoadError> {
        let Some(info) = info else { return Ok(None) };
        let found = self.texture_use(info, srgb, &format!("{place}.{property}"));
        Ok(self.document.salvage(found, "drawn without it")?.flatten())
    }

    fn texture_use(
        &mut self,
        info: &TextureInfo,
        srgb: bool,
        place: &str,
    ) -> Result<Option<TextureRef>, LoadError> {
        let document = self.document;
        // The image, in the best of the formats that the file offers.
        let described = document.get(&document.root.textures, info.index, "texture", place)?;
        let texture_place = format!("textures[{}]", info.index);
        let extensions = &described.extensions;
        let mut offered: Vec<Index> = [extensions.basisu.source, extensions.webp.source, described.source]
            .into_iter()
            .flatten()
            .collect();
        let Some(&last) = offered.last() else {
            document.repaired(&texture_place, "it has no image in a known format and was left out");
            return Ok(None);
        };
        let exists = |image: Index| document.get(&document.root.images, image, "image", &texture_place);
        if !offered.iter().any(|&image| exists(image).is_ok()) {
            exists(last)?;
        }
        for missing in offered.extract_if(.., |image| exists(*image).is_err()) {
            document.salvage(exists(missing), "another image of its texture is drawn")?;
        }
        // A texture that is used as colour and as data is two textures here.
        let texture = match self.texture_of.get(&(info.index, srgb)) {
            Some(&texture) => texture,
            None => {
                let sampler = described
                    .sampler
                    .map(|sampler| document.get(&document.root.samplers, sampler, "sampler", &texture_place));
                let (wrap, filter, minification) =
                    sampler.transpose()?.map_or_else(Default::default, sampling);
                let texture = self.textures.len() as u32;
                self.textures.push(Texels {
                    name: described.name.clone().unwrap_or_default(),
                    source: Source::File(offered),
                    srgb,
                    wrap,
                    filter,
                    minification,
                });
                self.texture_of.insert((info.index, srgb), texture);
                texture
            }
        };
        // How this material lays it out.
        let mut used = TextureRef { uv_set: info.tex_coord, ..TextureRef::new(texture) };
        if let Some(transform) = &info.extensions.transform {
            used.transform = TextureRef::transform_of(
                Vec2::from(transform.offset),
                transform.rotation,
                Vec2::from(transform.scale),
            );
            used.uv_set = transform.tex_coord.unwrap_or(used.uv_set);
            if !used.transform.is_finite() {
                return Err(document.fault(
                    place,
                    "a KHR_texture_transform is not finite; correct it and export the file again",
                ));
            }
        }
        Ok(Some(used))
    }

    /// Decodes the images, makes the textures that need computing, and gives all up.
    pub(super) fn finish(mut self) -> Result<Finished, LoadError> {
        let wanted: Vec<&[Index]> = self.textures.iter().filter_map(Texels::file_images).collect();
        let mut images = image::Images::decode(self.document, &wanted)?;
        let mut bakes = std::mem::take(&mut self.bakes);
        self.forget_lost(&images, &mut bakes);
        let mut transmissions = HashMap::new();
        for Bake { material: number, place, what } in bakes {
            let material = &mut self.materials[number];
            let baked = match what {
                BakeKind::Transmission { strength, texture } => {
                    bake::transmission(material, strength, texture, &self.textures, &mut images)
                }
                BakeKind::Glossy { factors, texture } => {
                    bake::glossy(material, factors, texture, &self.textures, &mut images)
                }
            };
            let mut baked = baked.map_err(|problem| self.document.limit(&place, problem))?;
            if let Some(shortcoming) = baked.shortcoming {
                self.document.repaired(&place, shortcoming);
            }
            baked.assign(material, self.textures.len() as u32);
            self.textures.append(&mut baked.textures);
            if baked.is_even {
                transmissions.insert(number as u32, TRANSMISSION_SHARE * (1.0 - material.metallic));
            }
        }
        let (materials, textures) = self.keep_used(&images);
        Ok((materials, textures, transmissions))
    }

    /// Takes away the textures whose images are lost.
    fn forget_lost(&mut self, images: &image::Images, bakes: &mut [Bake]) {
        let textures = &self.textures;
        let is_lost = |used: &mut TextureRef| !images.has(&textures[used.texture as usize].source);
        for material in &mut self.materials {
            for slot in slots(material) {
                slot.take_if(is_lost);
            }
        }
        for bake in bakes {
            let (BakeKind::Transmission { texture, .. } | BakeKind::Glossy { texture, .. }) = &mut bake.what;
            texture.take_if(is_lost);
        }
    }

    /// Leaves out the textures that only served to make others.
    fn keep_used(mut self, images: &image::Images) -> (Vec<Material>, Vec<Texture>) {
        let mut kept = Vec::new();
        let mut new_index = vec![None; self.textures.len()];
        for material in &mut self.materials {
            for used in slots(material).into_iter().flatten() {
                let old = used.texture as usize;
                used.texture = *new_index[old].get_or_insert_with(|| {
                    kept.push(decoded(&self.textures[old], images));
                    kept.len() as u32 - 1
                });
            }
        }
        (self.materials, kept)
    }
}

/// All places of a material for a texture.
fn slots(material: &mut Material) -> [&mut Option<TextureRef>; 6] {
    [
        &mut material.base_colour_texture,
        &mut material.metallic_roughness_texture,
        &mut material.normal_texture,
        &mut material.occlusion_texture,
        &mut material.emissive_texture,
        &mut material.thickness_texture,
    ]
}

fn unit(factor: f32) -> f32 {
    // What is not a number becomes 0.
    if factor > 0.0 { factor.min(1.0) } else { 0.0 }
}

/// Wrapping and filters of a sampler (glTF 2.0, 3.8.4.2); an unknown number means the default.
fn sampling(sampler: &schema::Sampler) -> ([Wrap; 2], Filter, Minification) {
    let wrap = |code: Option<u32>| match code {
        Some(33071) => Wrap::ClampToEdge,
        Some(33648) => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    };
    let filter = if sampler.mag_filter == Some(9728) { Filter::Nearest } else { Filter::Linear };
    let (within, levels) = match sampler.min_filter {
        Some(9728) => (Filter::Nearest, LevelFilter::None),
        Some(9729) => (Filter::Linear, LevelFilter::None),
        Some(9984) => (Filter::Nearest, LevelFilter::Nearest),
        Some(9985) => (Filter::Linear, LevelFilter::Nearest),
        Some(9986) => (Filter::Nearest, LevelFilter::Linear),
        _ => (Filter::Linear, LevelFilter::Linear),
    };
    ([wrap(sampler.wrap_s), wrap(sampler.wrap_t)], filter, Minification { filter: within, levels })
}
