//! MTL: the materials beside an OBJ file, and the images that they name.
//!
//! Colours are taken as meant for the display, as modellers show them. `d` is opacity and wins over `Tr`,
//! which is what is missing of it; `map_d` multiplies it, by the alpha of an image that has some and its
//! brightness otherwise. `Tf` colours the light that glass lets through.

use std::{
    collections::{HashMap, HashSet},
    path::PathBuf,
    sync::Arc,
};

use glam::{Affine2, Mat2, Vec2, Vec3, Vec4};
use sheer_core::colour::linear_from_srgb;
use sheer_image::{Image, TextureLimits, decode_texture, texture_size};
use sheer_scene::{
    cost::{DECODING_BYTES, TEXEL_BYTES},
    model::{AlphaMode, Material, Texture, TextureRef, Wrap},
};

use crate::{
    LoadError,
    gltf::{path_beside, read_beside, spelt_otherwise},
    source::{self, Source},
    text::{self, Line, next_number, shown},
};

/// What all images of a file may take in memory when decoded, where no other limit is set.
const IMAGE_BYTES: u64 = 6 << 30;
/// The longest side of an image that is put together from others.
const LONGEST_SIDE: u32 = 8192;
/// Share of the light that passes glass whose opacity is not given: it keeps a body to see.
const GLASS_SHARE: f32 = 0.85;
/// A material's transmission is below 1.
const MOST_TRANSMISSION: f32 = 0.99;
/// Display value of what has no material.
const GREY_SRGB: f32 = 0.735;
/// Words that change the look where the material model has nothing for them.
const WITHOUT_EFFECT: &[&str] = &[
    "map_Ks", "map_Ns", "map_Pr", "map_Pm", "map_Ps", "map_RMA", "map_ORM", "map_Tf", "map_bump", "bump",
    "disp", "decal", "refl", "map_refl", "aniso", "Ps", "Pc",
];

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
    /// `map_Ka`, which most write beside `map_Kd` with the same image.
    ambient_map_place: Option<String>,
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
            ambient_map_place: None,
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

impl Map {
    /// Factor and distance that take the coordinates of a mesh to those of the image, both with v downwards;
    /// in the file it grows upwards.
    fn layout(&self) -> (Vec2, Vec2) {
        (self.scale, Vec2::new(self.offset.x, 1.0 - self.scale.y - self.offset.y))
    }
}

/// The materials of the given names, the textures they use; a name without a material is grey.
pub(super) fn read(
    source: &Source<'_>,
    libraries: &[(String, String)],
    names: &[String],
) -> Result<(Vec<Material>, Vec<Texture>), LoadError> {
    let mut library = Library { source, described: HashMap::new(), read: HashSet::new() };
    for (place, name) in libraries {
        library.read_all(place, name)?;
    }
    let described = library.described;
    let mut textures = Textures {
        source,
        found: HashMap::new(),
        images: HashMap::new(),
        masked: HashMap::new(),
        texture_of: HashMap::new(),
        bytes_left: IMAGE_BYTES,
        textures: Vec::new(),
    };
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
        material.name = source::name(name);
        materials.push(material);
    }
    Ok((materials, textures.textures))
}

/// Where a file is that another names, which may have been written on another machine, and its name there:
/// where it is not, it is looked for beside the file, and whatever the case of its letters.
fn find(source: &Source<'_>, place: &str, name: &str) -> Option<(PathBuf, String)> {
    let last_name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let otherwise = |name: &str| spelt_otherwise(name, source.path, source.options);
    let candidates: [&dyn Fn() -> Option<String>; 4] =
        [&|| Some(name.to_owned()), &|| otherwise(name), &|| Some(last_name.to_owned()), &|| {
            otherwise(last_name)
        }];
    let is_there = |candidate: String| {
        let path = path_beside(&candidate, source.path, source.options)?;
        path.exists().then_some((path, candidate))
    };
    let found = candidates.into_iter().find_map(|candidate| is_there(candidate()?))?;
    if found.1 != name {
        let [taken, named] = [found.1.as_str(), name].map(|name| shown(name.as_bytes()));
        source.repaired(place, format!("'{taken}' was taken from beside the file for '{named}'"));
    }
    Some(found)
}

/// The materials of all files that were read.
struct Library<'s, 'a> {
    source: &'s Source<'a>,
    described: HashMap<String, Described>,
    /// Each is read once, however often and by whatever way it is named.
    read: HashSet<PathBuf>,
}

impl Library<'_, '_> {
    /// Reads what `mtllib` names: one file, whose name may contain blanks, or several.
    fn read_all(&mut self, place: &str, names: &str) -> Result<(), LoadError> {
        let quoted = names.strip_prefix('"').and_then(|names| names.strip_suffix('"'));
        let names = quoted.unwrap_or(names);
        let is_several = names.contains(' ') && {
            let whole = read_beside(names, self.source.path, self.source.options).is_ok();
            let first = names.split_whitespace().next().unwrap_or_default();
            !whole && first.to_ascii_lowercase().ends_with(".mtl")
        };
        if !is_several {
            return self.read_one(place, names);
        }
        names.split_whitespace().try_for_each(|name| self.read_one(place, name))
    }

    fn read_one(&mut self, place: &str, name: &str) -> Result<(), LoadError> {
        let source = self.source;
        let found = find(source, place, name);
        if let Some((path, _)) = &found
            && !self.read.insert(path.clone())
        {
            return Ok(());
        }
        let name = found.as_ref().map_or(name, |(_, name)| name);
        match read_beside(name, source.path, source.options) {
            Ok(bytes) => self.take_in(name, &bytes),
            Err(problem) => source.lost(place, format!("its materials are not there: {problem}")),
        }
    }

    fn take_in(&mut self, name: &str, bytes: &[u8]) -> Result<(), LoadError> {
        let source = self.source;
        source.take(bytes.len(), "materials")?;
        let name = shown(name.as_bytes());
        let mut current: Option<(String, Described)> = None;
        for line in text::lines(bytes) {
            let Some(word) = line.words().next() else { continue };
            if word == b"newmtl" {
                source.take(line.text.len() + size_of::<(String, Described)>() * 2, "materials")?;
                if let Some((name, finished)) = current.replace((line.rest(), Described::default())) {
                    self.described.entry(name).or_insert(finished);
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
            self.described.entry(name).or_insert(finished);
        }
        Ok(())
    }
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
            b"map_Ka" | b"map_ka" => self.ambient_map_place = Some(place.to_owned()),
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

/// An image, and whether one of its texels is transparent.
#[derive(Clone)]
struct Picture {
    texels: Texels,
    is_transparent: bool,
}

/// How an image lies on another one: coordinates there times a factor and plus a distance are those in it,
/// both from the upper left.
#[derive(Clone, Copy, PartialEq)]
struct Overlay {
    factor: Vec2,
    distance: Vec2,
    clamp: bool,
}

impl Overlay {
    /// How a map lies on one of the same mesh.
    fn new(base: &Map, map: &Map) -> Self {
        let [(base_scale, base_offset), (scale, offset)] = [base, map].map(Map::layout);
        let factor = scale / base_scale;
        let distance = offset - factor * base_offset;
        let is_finite = factor.is_finite() && distance.is_finite();
        let (factor, distance) = if is_finite { (factor, distance) } else { (Vec2::ONE, Vec2::ZERO) };
        Self { factor, distance, clamp: map.clamp }
    }

    /// Whether it is right on every repetition of the base.
    fn repeats(self, base: &Map) -> bool {
        let is_plain = self.factor == Vec2::ONE && self.distance == Vec2::ZERO;
        let is_whole = self.factor.fract() == Vec2::ZERO && self.factor.min_element() >= 1.0;
        is_plain || (is_whole && !self.clamp && !base.clamp)
    }

    /// The nearest texel at a place of the base.
    fn texel(self, image: &Texels, at: Vec2) -> [u8; 4] {
        let at = self.factor * at + self.distance;
        let texel = |at: f32, side: u32| {
            let at = if self.clamp { at.clamp(0.0, 1.0) } else { at - at.floor() };
            ((at * side as f32) as u32).min(side - 1)
        };
        image[(texel(at.x, image.width()), texel(at.y, image.height()))]
    }

    /// The size of a base in which no texel is lost.
    fn base_size(self, image: &Texels) -> [u32; 2] {
        let (width, height) = image.size();
        let spread =
            |side: u32, factor: f32| ((side as f32 * factor.abs()) as u32).clamp(1, side.max(LONGEST_SIDE));
        [spread(width, self.factor.x), spread(height, self.factor.y)]
    }

    fn bits(self) -> [u32; 5] {
        let [a, b] = self.factor.to_array();
        let [c, d] = self.distance.to_array();
        [a.to_bits(), b.to_bits(), c.to_bits(), d.to_bits(), u32::from(self.clamp)]
    }
}

/// Which images lie on a base, and how.
type Combination = [(*const Image<[u8; 4]>, [u32; 5]); 2];

/// Images and textures as materials ask for them.
struct Textures<'s, 'a> {
    source: &'s Source<'a>,
    /// Where they lie and what they are called there, by the name that the file has for them.
    found: HashMap<String, (PathBuf, String)>,
    /// By where they lie, or their name; none where it could not be read, which has been said.
    images: HashMap<PathBuf, Option<Picture>>,
    /// Images of colours with the alpha of others.
    masked: HashMap<Combination, Texels>,
    bytes_left: u64,
    textures: Vec<Texture>,
    /// Index of each texture by its image, whether that is sRGB, and whether it is clamped.
    texture_of: HashMap<(*const Image<[u8; 4]>, bool, bool), u32>,
}

impl Textures<'_, '_> {
    fn material(&mut self, described: &Described) -> Result<Material, LoadError> {
        let diffuse = described.maps.get(&Slot::Diffuse);
        let dissolve = described.maps.get(&Slot::Dissolve);
        if let Some(place) = described.ambient_map_place.as_ref().filter(|_| diffuse.is_none()) {
            self.source.repaired(place, "'map_Ka' has no effect here without 'map_Kd'");
        }
        // Opacity: a factor, and what an image takes away.
        let colours = diffuse.map(|map| self.image(map)).transpose()?.flatten();
        let mask = dissolve.map(|map| self.image(map)).transpose()?.flatten();
        let has_own_alpha = colours.as_ref().is_some_and(|image| image.is_transparent);
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
        let base = match (colours.zip(diffuse), mask.zip(dissolve)) {
            (None, None) => None,
            (Some((colours, map)), None) => Some((colours.texels, map)),
            (None, Some((mask, map))) => {
                Some((self.masked(None, &mask, map, [Overlay::new(map, map); 2])?, map))
            }
            (Some((colours, map)), Some((mask, mask_map))) => {
                // On the one that is repeated less often both are right.
                let overlays = |base: &Map| [map, mask_map].map(|map| Overlay::new(base, map));
                let fits = |base: &&Map| overlays(base).into_iter().all(|overlay| overlay.repeats(base));
                let base = [map, mask_map].into_iter().find(fits);
                if base.is_none() {
                    let what =
                        "it is laid out otherwise than 'map_Kd', and right in the first tile of that alone";
                    self.source.repaired(&mask_map.place, what);
                }
                let base = base.unwrap_or(map);
                Some((self.masked(Some(&colours), &mask, base, overlays(base))?, base))
            }
        };
        if let Some((image, map)) = base {
            material.base_colour_texture = Some(self.texture(image, map, true));
        }
        if let Some(map) = described.maps.get(&Slot::Emissive)
            && let Some(image) = self.image(map)?
        {
            material.emissive_texture = Some(self.texture(image.texels, map, true));
            if material.emissive == Vec3::ZERO {
                material.emissive = Vec3::ONE;
            }
        }
        if let Some(map) = described.maps.get(&Slot::Normal)
            && let Some(image) = self.image(map)?
        {
            material.normal_texture = Some(self.texture(image.texels, map, false));
        }
        apply_filter(described, &mut material);
        Ok(material)
    }

    /// The texels of a file beside the OBJ.
    fn image(&mut self, map: &Map) -> Result<Option<Picture>, LoadError> {
        let source = self.source;
        let (path, name) = match self.found.get(&map.file) {
            Some(found) => found.clone(),
            None => {
                let found = find(source, &map.place, &map.file);
                let found = found.unwrap_or_else(|| (PathBuf::from(&map.file), map.file.clone()));
                self.found.insert(map.file.clone(), found.clone());
                found
            }
        };
        if let Some(image) = self.images.get(&path) {
            return Ok(image.clone());
        }
        let image = match read_beside(&name, source.path, source.options) {
            Ok(bytes) => self.decode(&bytes, map)?,
            Err(problem) => {
                source.lost(&map.place, format!("its image was left out: {problem}"))?;
                None
            }
        };
        self.images.insert(path, image.clone());
        Ok(image)
    }

    fn decode(&mut self, bytes: &[u8], map: &Map) -> Result<Option<Picture>, LoadError> {
        let last_name = map.file.rsplit(['/', '\\']).next().unwrap_or_default();
        let name = shown(last_name.as_bytes());
        let limits = TextureLimits::default();
        let decoded =
            texture_size(bytes, &name, limits).map_err(|error| error.to_string()).and_then(|size| {
                if let Err(problem) = self.take(size, map) {
                    return Ok(Err(problem));
                }
                decode_texture(bytes, &name, limits).map(Ok).map_err(|error| error.to_string())
            });
        match decoded {
            Ok(image) => {
                let texels = Arc::new(image?);
                let is_transparent = texels.as_slice().iter().any(|texel| texel[3] < 255);
                Ok(Some(Picture { texels, is_transparent }))
            }
            Err(problem) => {
                self.source.lost(&map.place, format!("its image was left out: {problem}"))?;
                Ok(None)
            }
        }
    }

    /// Takes the memory of an image before it is there.
    fn take(&mut self, (width, height): (u32, u32), map: &Map) -> Result<(), LoadError> {
        let texels = u64::from(width) * u64::from(height);
        let left = self.bytes_left.checked_sub(texels * TEXEL_BYTES);
        self.bytes_left = left.ok_or_else(|| {
            self.source
                .limit(&map.place, "the images of the file take too much memory; scale them down".to_owned())
        })?;
        // What decoding takes on top is free again afterwards.
        let at_once = texels * (TEXEL_BYTES + DECODING_BYTES);
        if at_once > self.source.memory_left() {
            self.source.take(usize::try_from(at_once).unwrap_or(usize::MAX), &map.place)?;
        }
        self.source.take((texels * TEXEL_BYTES) as usize, &map.place)
    }

    /// Colours, or white, with the alpha of a mask, as both lie on a base.
    fn masked(
        &mut self,
        colours: Option<&Picture>,
        mask: &Picture,
        base: &Map,
        [colours_on_base, mask_on_base]: [Overlay; 2],
    ) -> Result<Texels, LoadError> {
        let colours_at = colours.map_or(std::ptr::null(), |colours| Arc::as_ptr(&colours.texels));
        let key = [(colours_at, colours_on_base.bits()), (Arc::as_ptr(&mask.texels), mask_on_base.bits())];
        if let Some(texels) = self.masked.get(&key) {
            return Ok(Arc::clone(texels));
        }
        let colours = colours.map(|colours| &colours.texels);
        let sizes = [
            mask_on_base.base_size(&mask.texels),
            colours.map_or([1; 2], |colours| colours_on_base.base_size(colours)),
        ];
        let [width, height] = [0, 1].map(|side| sizes[0][side].max(sizes[1][side]));
        self.take((width, height), base)?;
        let image = Image::par_from_fn(width, height, |x, y| {
            let at = (Vec2::new(x as f32, y as f32) + 0.5) / Vec2::new(width as f32, height as f32);
            let [r, g, b, _] = colours.map_or([255; 4], |colours| colours_on_base.texel(colours, at));
            let texel = mask_on_base.texel(&mask.texels, at);
            // Brightness as displayed, as other readers take it.
            let grey = (texel[..3].iter().map(|value| u16::from(*value)).sum::<u16>() / 3) as u8;
            [r, g, b, if mask.is_transparent { texel[3] } else { grey }]
        });
        let texels = Arc::new(image.map_err(|error| self.source.fault(&base.place, error.to_string()))?);
        self.masked.insert(key, Arc::clone(&texels));
        Ok(texels)
    }

    fn texture(&mut self, image: Texels, map: &Map, srgb: bool) -> TextureRef {
        let wrap = if map.clamp { Wrap::ClampToEdge } else { Wrap::Repeat };
        let textures = &mut self.textures;
        let texture = *self.texture_of.entry((Arc::as_ptr(&image), srgb, map.clamp)).or_insert_with(|| {
            textures.push(Texture {
                name: source::name(&map.file),
                image,
                srgb,
                wrap: [wrap; 2],
                filter: Default::default(),
                minification: Default::default(),
            });
            textures.len() as u32 - 1
        });
        let (scale, offset) = map.layout();
        TextureRef {
            transform: Affine2::from_mat2_translation(Mat2::from_diagonal(scale), offset),
            ..TextureRef::new(texture)
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
