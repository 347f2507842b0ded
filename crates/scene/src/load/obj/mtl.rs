//! MTL: the materials beside an OBJ file, and the images that they name.
//!
//! Colours are taken as meant for the display, as modellers show them. `d` is opacity and wins over `Tr`,
//! which is what is missing of it; `map_d` multiplies it, by the alpha of an image that has some and its
//! brightness otherwise. `Tf` colours the light that glass lets through.

use std::{collections::HashMap, sync::Arc};

use glam::{Affine2, Mat2, Vec2, Vec3, Vec4};
use sheer_core::colour::linear_from_srgb;
use sheer_image::{Image, TextureLimits, decode_texture};

use crate::{
    SceneError,
    load::{
        gltf::read_beside,
        source::Source,
        text::{self, Line, next_number, shown},
    },
    model::{AlphaMode, Material, Texture, TextureRef, Wrap},
};

/// What all images of a file may take in memory when decoded.
const IMAGE_BYTES: u64 = 6 << 30;
/// Share of the light that passes glass whose opacity is not given: it keeps a body to see.
const GLASS_SHARE: f32 = 0.85;
/// A material's transmission is below 1.
const MOST_TRANSMISSION: f32 = 0.99;
/// Display value of what has no material.
const GREY_SRGB: f32 = 0.735;
/// Words that change the look where the material model has nothing for them.
const WITHOUT_EFFECT: &[&str] =
    &["map_Ks", "map_bump", "bump", "disp", "decal", "refl", "map_refl", "aniso", "Ps", "Pc"];

/// A material as the file describes it.
#[derive(Clone, Debug)]
struct Described {
    diffuse: Vec3,
    emissive: Vec3,
    dissolve: Option<f32>,
    /// `Tr`.
    transparency: Option<f32>,
    /// `Tf`: the share of light that passes, red, green and blue.
    filter: Option<Vec3>,
    shininess: Option<f32>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    illumination: u32,
    maps: HashMap<Slot, Map>,
}

impl Default for Described {
    fn default() -> Self {
        Self {
            diffuse: Vec3::splat(GREY_SRGB),
            emissive: Vec3::ZERO,
            dissolve: None,
            transparency: None,
            filter: None,
            shininess: None,
            roughness: None,
            metallic: None,
            illumination: 2,
            maps: HashMap::new(),
        }
    }
}

/// What an image is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Slot {
    Diffuse,
    Dissolve,
    Emissive,
    Normal,
}

/// A use of an image.
#[derive(Clone, Debug)]
struct Map {
    file: String,
    /// Where the statement stands, for messages.
    place: String,
    scale: Vec2,
    offset: Vec2,
    clamp: bool,
}

/// The materials of the given names, the textures they use; a name without a material is grey.
pub(super) fn read(
    source: &Source<'_>,
    libraries: &[(String, String)],
    names: &[String],
) -> Result<(Vec<Material>, Vec<Texture>), SceneError> {
    let mut described: HashMap<String, Described> = HashMap::new();
    for (place, name) in libraries {
        read_libraries(source, place, name, &mut described)?;
    }
    let mut textures = Textures { source, images: HashMap::new(), used_bytes: 0, textures: Vec::new() };
    let mut materials = Vec::new();
    for name in names {
        let found = described.get(name);
        if found.is_none() && !name.is_empty() {
            source.lost(
                format_args!("material '{}'", shown(name.as_bytes())),
                "no material file has it; what uses it is grey",
            )?;
        }
        let mut material = textures.material(found.unwrap_or(&Described::default()))?;
        material.name.clone_from(name);
        materials.push(material);
    }
    Ok((materials, textures.textures))
}

/// Reads what `mtllib` names: one file, whose name may contain blanks, or several.
fn read_libraries(
    source: &Source<'_>,
    place: &str,
    names: &str,
    described: &mut HashMap<String, Described>,
) -> Result<(), SceneError> {
    let whole = read_beside(names, source.path, source.options);
    let files: Vec<(String, Result<Vec<u8>, String>)> = if whole.is_ok() || !names.contains(' ') {
        vec![(names.to_owned(), whole)]
    } else {
        let each = names.split_whitespace();
        each.map(|name| (name.to_owned(), read_beside(name, source.path, source.options))).collect()
    };
    for (name, bytes) in files {
        match bytes {
            Ok(bytes) => read_library(source, &name, &bytes, described)?,
            Err(problem) => source.lost(place, format!("its materials are not there: {problem}"))?,
        }
    }
    Ok(())
}

fn read_library(
    source: &Source<'_>,
    name: &str,
    bytes: &[u8],
    described: &mut HashMap<String, Described>,
) -> Result<(), SceneError> {
    let name = shown(name.as_bytes());
    let mut current: Option<(String, Described)> = None;
    for line in text::lines(bytes) {
        let Some(word) = line.words().next() else { continue };
        if word == b"newmtl" {
            if let Some((name, finished)) = current.replace((line.rest(), Described::default())) {
                described.entry(name).or_insert(finished);
            }
            continue;
        }
        let Some((_, material)) = &mut current else { continue };
        let place = format!("{name}, {}", line.place());
        match material.read_line(&line, &place) {
            Ok(true) => {}
            Ok(false) => {
                let word = String::from_utf8_lossy(word);
                if WITHOUT_EFFECT.iter().any(|known| known.eq_ignore_ascii_case(&word)) {
                    source.repaired(&name, format!("'{word}' has no effect here"));
                }
            }
            Err(problem) => source.lost(place, format!("the line was left out: {problem}"))?,
        }
    }
    if let Some((name, finished)) = current {
        described.entry(name).or_insert(finished);
    }
    Ok(())
}

impl Described {
    /// Takes a statement; false if it is none that has an effect.
    fn read_line(&mut self, line: &Line<'_>, place: &str) -> Result<bool, String> {
        let mut words = line.words();
        let word = words.next().unwrap_or_default();
        match word {
            b"Kd" => self.diffuse = colour(&mut words)?,
            b"Ke" => self.emissive = colour(&mut words)?,
            b"Tf" => self.filter = Some(colour(&mut words)?),
            b"d" => {
                // A halo fades towards the rim, which needs a view; its factor holds where it is met head on.
                let mut words = words.skip_while(|word| *word == b"-halo");
                self.dissolve = Some(next_number(&mut words)?);
            }
            b"Tr" => self.transparency = Some(next_number(&mut words)?),
            b"Ns" => self.shininess = Some(next_number(&mut words)?),
            b"Pr" => self.roughness = Some(next_number(&mut words)?),
            b"Pm" => self.metallic = Some(next_number(&mut words)?),
            b"illum" => self.illumination = next_number(&mut words)?,
            b"map_Kd" | b"map_kd" => self.map(Slot::Diffuse, line, place)?,
            b"map_d" | b"map_D" | b"map_Tr" => self.map(Slot::Dissolve, line, place)?,
            b"map_Ke" | b"map_ke" => self.map(Slot::Emissive, line, place)?,
            b"norm" | b"map_Kn" => self.map(Slot::Normal, line, place)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// `map_Kd -s 2 2 1 -clamp on name of file.png`.
    fn map(&mut self, slot: Slot, line: &Line<'_>, place: &str) -> Result<(), String> {
        let rest = line.rest();
        let mut map = Map {
            file: String::new(),
            place: place.to_owned(),
            scale: Vec2::ONE,
            offset: Vec2::ZERO,
            clamp: false,
        };
        let mut rest = rest.as_str();
        while let Some((option, after)) =
            rest.split_once(char::is_whitespace).filter(|_| rest.starts_with('-'))
        {
            let mut after = after.trim_start();
            let mut numbers = [None::<f32>; 3];
            let (least, most) = match option {
                "-s" | "-o" | "-t" => (1, 3),
                "-mm" => (2, 2),
                "-bm" | "-boost" | "-texres" => (1, 1),
                "-clamp" | "-blendu" | "-blendv" | "-cc" | "-imfchan" | "-type" => {
                    let (value, next) = after.split_once(char::is_whitespace).unwrap_or((after, ""));
                    map.clamp |= option == "-clamp" && value == "on";
                    rest = next.trim_start();
                    continue;
                }
                _ => break,
            };
            for (index, number) in numbers.iter_mut().enumerate().take(most) {
                let (word, next) = after.split_once(char::is_whitespace).unwrap_or((after, ""));
                *number = word.parse().ok();
                if number.is_none() {
                    if index < least {
                        return Err(format!("'{}' needs a number", shown(option.as_bytes())));
                    }
                    break;
                }
                after = next.trim_start();
            }
            let or = |default: f32| Vec2::new(numbers[0].unwrap_or(default), numbers[1].unwrap_or(default));
            match option {
                "-s" => map.scale = or(1.0),
                "-o" => map.offset = or(0.0),
                _ => {}
            }
            rest = after;
        }
        map.file = rest.trim().trim_matches('"').to_owned();
        if map.file.is_empty() {
            return Err("it names no image".to_owned());
        }
        self.maps.insert(slot, map);
        Ok(())
    }

    /// Opacity, without its map.
    fn opacity(&self) -> f32 {
        let opacity = self.dissolve.or(self.transparency.map(|transparency| 1.0 - transparency));
        unit(opacity.unwrap_or(1.0))
    }

    /// Whether light is meant to pass through what is there: ray-traced glass, with or without refraction.
    fn is_glass(&self) -> bool {
        matches!(self.illumination, 4 | 6 | 7 | 9)
    }
}

/// Three numbers, or one for all.
fn colour<'w>(words: &mut impl Iterator<Item = &'w [u8]>) -> Result<Vec3, String> {
    let first = words.next().ok_or("a colour needs three numbers")?;
    if matches!(first, b"spectral" | b"xyz") {
        return Err(format!("colours by '{}' are not read; give red, green and blue", shown(first)));
    }
    let red: f32 = text::number(first)?;
    let Some(green) = words.next() else { return Ok(Vec3::splat(red)) };
    let green = text::number(green)?;
    let colour = Vec3::new(red, green, words.next().map_or(Ok(green), text::number)?);
    if colour.is_finite() { Ok(colour.max(Vec3::ZERO)) } else { Err("a colour is not finite".to_owned()) }
}

fn unit(value: f32) -> f32 {
    // What is not a number becomes 0.
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

fn linear(colour: Vec3) -> Vec3 {
    colour.min(Vec3::ONE).map(linear_from_srgb)
}

type Texels = Arc<Image<[u8; 4]>>;

/// Images and textures as materials ask for them.
struct Textures<'s, 'a> {
    source: &'s Source<'a>,
    /// By name; none where it could not be read, which has been said.
    images: HashMap<String, Option<Texels>>,
    used_bytes: u64,
    textures: Vec<Texture>,
}

impl Textures<'_, '_> {
    fn material(&mut self, described: &Described) -> Result<Material, SceneError> {
        let diffuse = described.maps.get(&Slot::Diffuse);
        let dissolve = described.maps.get(&Slot::Dissolve);
        // Opacity: a factor, and what an image takes away.
        let colours = diffuse.map(|map| self.image(map)).transpose()?.flatten();
        let mask = dissolve.map(|map| self.image(map)).transpose()?.flatten();
        let is_transparent = |image: &Texels| image.as_slice().iter().any(|texel| texel[3] < 255);
        let has_own_alpha = colours.as_ref().is_some_and(is_transparent);
        let factor = described.opacity();
        let mut material = Material {
            // Some exporters write black under an image.
            base_colour: match (&colours, described.diffuse == Vec3::ZERO) {
                (Some(_), true) => Vec4::ONE,
                _ => linear(described.diffuse).extend(1.0),
            },
            emissive: described.emissive,
            metallic: unit(described.metallic.unwrap_or(0.0)),
            roughness: described.roughness.map_or_else(|| roughness(described.shininess), unit),
            double_sided: true,
            ..Material::default()
        };
        material.base_colour.w = factor;
        if factor < 1.0 || mask.is_some() || has_own_alpha {
            material.alpha_mode = AlphaMode::Blend;
        }
        let base = match (colours, mask) {
            (None, None) => None,
            (Some(colours), None) => Some(colours),
            (colours, Some(mask)) => Some(self.masked(colours, &mask)?),
        };
        if let (Some(image), Some(map)) = (base, diffuse.or(dissolve)) {
            material.base_colour_texture = Some(self.texture(image, map, true));
        }
        if let Some(map) = described.maps.get(&Slot::Emissive)
            && let Some(image) = self.image(map)?
        {
            material.emissive_texture = Some(self.texture(image, map, true));
            if material.emissive == Vec3::ZERO {
                material.emissive = Vec3::ONE;
            }
        }
        if let Some(map) = described.maps.get(&Slot::Normal)
            && let Some(image) = self.image(map)?
        {
            material.normal_texture = Some(self.texture(image, map, false));
        }
        apply_filter(described, &mut material);
        Ok(material)
    }

    /// The texels of a file beside the OBJ; a path that leads elsewhere is tried by its last name.
    fn image(&mut self, map: &Map) -> Result<Option<Texels>, SceneError> {
        if let Some(image) = self.images.get(&map.file) {
            return Ok(image.clone());
        }
        let source = self.source;
        let last_name = map.file.rsplit(['/', '\\']).next().unwrap_or(&map.file);
        let mut bytes = read_beside(&map.file, source.path, source.options);
        if bytes.is_err()
            && last_name != map.file
            && let Ok(found) = read_beside(last_name, source.path, source.options)
        {
            source.repaired(
                &map.place,
                format!("'{}' was taken from beside the file", shown(last_name.as_bytes())),
            );
            bytes = Ok(found);
        }
        let decoded = bytes.and_then(|bytes| self.decode(&bytes, &map.file));
        let image = match decoded {
            Ok(image) => Some(Arc::new(image)),
            Err(problem) => {
                source.lost(&map.place, format!("its image was left out: {problem}"))?;
                None
            }
        };
        self.images.insert(map.file.clone(), image.clone());
        Ok(image)
    }

    fn decode(&mut self, bytes: &[u8], name: &str) -> Result<Image<[u8; 4]>, String> {
        let left = IMAGE_BYTES - self.used_bytes;
        let default = TextureLimits::default();
        let limits = TextureLimits { max_bytes: default.max_bytes.min(left), ..default };
        let image =
            decode_texture(bytes, &shown(name.as_bytes()), limits).map_err(|error| error.to_string())?;
        self.used_bytes += size_of_val(image.as_slice()) as u64;
        Ok(image)
    }

    /// Colours with the alpha of a mask, in the size of the larger.
    fn masked(&mut self, colours: Option<Texels>, mask: &Texels) -> Result<Texels, SceneError> {
        let by_alpha = mask.as_slice().iter().any(|texel| texel[3] < 255);
        let (width, height) = colours.as_ref().map_or(mask.size(), |colours| {
            (colours.width().max(mask.width()), colours.height().max(mask.height()))
        });
        let nearest = |image: &Texels, x: u32, y: u32| {
            let scaled =
                |at: u32, side: u32, whole: u32| (u64::from(at) * u64::from(side) / u64::from(whole)) as u32;
            image[(scaled(x, image.width(), width), scaled(y, image.height(), height))]
        };
        let image = Image::par_from_fn(width, height, |x, y| {
            let [r, g, b, _] = colours.as_ref().map_or([255; 4], |colours| nearest(colours, x, y));
            let mask = nearest(mask, x, y);
            // Brightness as displayed, as other readers take it.
            let grey = (mask[..3].iter().map(|value| u16::from(*value)).sum::<u16>() / 3) as u8;
            [r, g, b, if by_alpha { mask[3] } else { grey }]
        });
        let image = image.map_err(|error| self.source.fault("map_d", error.to_string()))?;
        self.used_bytes += size_of_val(image.as_slice()) as u64;
        Ok(Arc::new(image))
    }

    fn texture(&mut self, image: Texels, map: &Map, srgb: bool) -> TextureRef {
        let wrap = if map.clamp { Wrap::ClampToEdge } else { Wrap::Repeat };
        let known = self.textures.iter().position(|known| {
            Arc::ptr_eq(&known.image, &image) && known.srgb == srgb && known.wrap == [wrap; 2]
        });
        let texture = known.unwrap_or_else(|| {
            self.textures.push(Texture {
                name: map.file.clone(),
                image,
                srgb,
                wrap: [wrap; 2],
                filter: Default::default(),
                minification: Default::default(),
            });
            self.textures.len() - 1
        });
        // The file counts v upwards, textures here downwards.
        let offset = Vec2::new(map.offset.x, 1.0 - map.scale.y - map.offset.y);
        TextureRef {
            transform: Affine2::from_mat2_translation(Mat2::from_diagonal(map.scale), offset),
            ..TextureRef::new(texture as u32)
        }
    }
}

/// A perceptual roughness whose highlight is as wide as that of a Phong exponent (Karis 2013, *Specular BRDF
/// Reference*: exponent = 2 / roughness⁴ - 2); matt where none is given.
fn roughness(shininess: Option<f32>) -> f32 {
    shininess.map_or(1.0, |exponent| unit((2.0 / (exponent.max(0.0) + 2.0)).powf(0.25)))
}

/// `Tf`: the colour of what passes. Exporters write a white one into every material, so that grey counts only
/// for glass, which is ray-traced or has some opacity left out.
fn apply_filter(described: &Described, material: &mut Material) {
    let Some(filter) = described.filter else { return };
    let filter = filter.clamp(Vec3::ZERO, Vec3::ONE);
    let strongest = filter.max_element();
    let is_grey = strongest - filter.min_element() < 1e-3;
    let opacity = material.base_colour.w;
    if strongest == 0.0 || (is_grey && !described.is_glass()) {
        return;
    }
    // Of glass that is said to be opaque a little stays, to be seen.
    let through = if opacity < 1.0 { 1.0 - opacity } else { GLASS_SHARE };
    let transmission = (through * strongest).min(MOST_TRANSMISSION);
    material.transmission = transmission;
    material.base_colour = (filter / strongest).extend(1.0 - transmission);
    material.alpha_mode = AlphaMode::Blend;
}
