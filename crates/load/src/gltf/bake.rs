//! Textures that have to be computed: what the scene model has no slot for becomes part of a texture it has.

use std::sync::Arc;

use glam::Vec3;
use sheer_core::colour::{linear_from_srgb, srgb_from_linear};
use sheer_image::Image;
use sheer_scene::model::{AlphaMode, Material, TextureRef};

use super::{
    image::Images,
    texels::{Source, Texels},
};

/// Reflectance of a dielectric at normal incidence (glTF 2.0, appendix B.2.2).
const DIELECTRIC_SPECULAR: f32 = 0.04;

/// Computed textures and the slots they go to, numbered from the first of them.
#[derive(Default)]
pub(super) struct Baked {
    pub textures: Vec<Texels>,
    base_colour: Option<TextureRef>,
    metallic_roughness: Option<TextureRef>,
    /// A transmission that is the same all over was taken out of the alpha of the base colour.
    pub is_even: bool,
    /// What is not as the file says.
    pub shortcoming: Option<&'static str>,
}

impl Baked {
    /// Puts the textures into the material's slots, the first of them being number `first` of all.
    pub(super) fn assign(&self, material: &mut Material, first: u32) {
        let shifted = |used: TextureRef| TextureRef { texture: used.texture + first, ..used };
        if let Some(used) = self.base_colour {
            material.base_colour_texture = Some(shifted(used));
        }
        if let Some(used) = self.metallic_roughness {
            material.metallic_roughness_texture = Some(shifted(used));
        }
    }
}

/// Images of different sizes laid over each other; the nearest texel of each is read.
struct Stack {
    size: (u32, u32),
    layers: Vec<Option<Arc<Image<[u8; 4]>>>>,
}

impl Stack {
    fn new(used: &[Option<TextureRef>], textures: &[Texels], images: &Images) -> Self {
        let image = |used: TextureRef| Arc::clone(images.of(&textures[used.texture as usize].source));
        let layers: Vec<_> = used.iter().map(|used| used.map(image)).collect();
        let larger =
            |size: (u32, u32), image: &Arc<Image<_>>| (size.0.max(image.width()), size.1.max(image.height()));
        let size = layers.iter().flatten().fold((1, 1), larger);
        Self { size, layers }
    }

    /// A texel of a layer, 0 to 1; white where there is no layer.
    fn texel(&self, layer: usize, x: u32, y: u32) -> [f32; 4] {
        let Some(image) = &self.layers[layer] else { return [1.0; 4] };
        let scaled =
            |at: u32, whole: u32, size: u32| (u64::from(at) * u64::from(size) / u64::from(whole)) as u32;
        let at = (scaled(x, self.size.0, image.width()), scaled(y, self.size.1, image.height()));
        image[at].map(|value| f32::from(value) / 255.0)
    }

    /// Mean of a channel of a layer, 0 to 1.
    fn mean(&self, images: &Images, layer: usize, channel: usize) -> f32 {
        self.layers[layer].as_ref().map_or(1.0, |image| images.statistics(image).means[channel])
    }
}

/// Where the textures given all lie, if they lie at one place.
fn common_place(used: &[Option<TextureRef>]) -> Option<TextureRef> {
    let place = used.iter().flatten().next().copied()?;
    let same = |other: &TextureRef| other.uv_set == place.uv_set && other.transform == place.transform;
    used.iter().flatten().all(same).then_some(place)
}

/// Lowers the alpha of a material by what it transmits: `alpha · (1 - strength · transmission · (1 -
/// metallic))`, since metals transmit nothing (`KHR_materials_transmission`). What differs from texel to
/// texel goes into the base colour texture. Shadows take the base colour.
pub(super) fn transmission(
    material: &mut Material,
    strength: f32,
    texture: Option<TextureRef>,
    textures: &[Texels],
    images: &mut Images,
) -> Result<Baked, String> {
    let metallic = material.metallic;
    let metal_texture = material.metallic_roughness_texture.filter(|_| metallic > 0.0);
    // The most that any texel transmits.
    material.transmission = if metal_texture.is_some() { strength } else { strength * (1.0 - metallic) };
    let used = [material.base_colour_texture, texture, metal_texture];
    let stack = Stack::new(&used, textures, images);
    let varies = texture.is_some() || metal_texture.is_some();
    let place = common_place(&used).filter(|_| varies);
    let Some(place) = place else {
        // The same everywhere, or taken as the same where the textures are laid out differently.
        let kept = 1.0 - strength * stack.mean(images, 1, 0) * (1.0 - metallic * stack.mean(images, 2, 2));
        let is_opaque = stack.layers[0].as_ref().is_none_or(|image| images.statistics(image).is_opaque);
        let is_even = lower_evenly(material, kept, is_opaque) && !varies;
        let shortcoming =
            "its transmission is the same all over: the textures that it depends on are laid out differently";
        let shortcoming = varies.then_some(shortcoming);
        return Ok(Baked { is_even, shortcoming, ..Baked::default() });
    };

    let (mode, factor) = (material.alpha_mode, material.base_colour.w);
    let texel = |x: u32, y: u32| {
        let [red, green, blue, alpha] = stack.texel(0, x, y);
        let covered = match mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask { cutoff } => f32::from(alpha * factor >= cutoff),
            AlphaMode::Blend => alpha,
        };
        let metal = metallic * stack.texel(2, x, y)[2];
        let kept = 1.0 - strength * stack.texel(1, x, y)[0] * (1.0 - metal);
        [red, green, blue, covered * kept].map(byte)
    };
    let source = images.make(stack.size, texel)?;
    let like = &textures[place.texture as usize];
    if mode != AlphaMode::Blend {
        material.base_colour.w = 1.0;
        material.alpha_mode = AlphaMode::Blend;
    }
    Ok(Baked {
        textures: vec![Texels {
            name: format!("{} with transmission", like.name),
            source,
            srgb: true,
            ..like.clone()
        }],
        base_colour: Some(TextureRef { texture: 0, ..place }),
        ..Baked::default()
    })
}

/// One factor for the whole material. Where the alpha of the texture is to be ignored or tested, it must stay
/// out of the blending, and the factor goes to the opacity that is applied after that: then it is false that
/// the alpha was lowered.
fn lower_evenly(material: &mut Material, kept: f32, has_opaque_texels: bool) -> bool {
    match material.alpha_mode {
        AlphaMode::Blend => {
            material.base_colour.w *= kept;
            true
        }
        AlphaMode::Opaque if has_opaque_texels => {
            material.alpha_mode = AlphaMode::Blend;
            material.base_colour.w = kept;
            true
        }
        AlphaMode::Opaque | AlphaMode::Mask { .. } => {
            material.opacity *= kept;
            false
        }
    }
}

/// A surface in the terms of `KHR_materials_pbrSpecularGlossiness`, linear.
#[derive(Clone, Copy, Debug)]
pub(super) struct Glossy {
    pub diffuse: Vec3,
    pub specular: Vec3,
    pub glossiness: f32,
}

/// A surface in the terms of glTF 2.0, linear.
#[derive(Clone, Copy, Debug)]
pub(super) struct Metallic {
    pub base_colour: Vec3,
    pub metallic: f32,
    pub roughness: f32,
}

impl Glossy {
    /// The metallic-roughness surface whose diffuse and specular colours are nearest (the inverse of the
    /// mapping in the extension's appendix: diffuse = base·(1 - 0.04)·(1 - metallic), specular = mix(0.04,
    /// base, metallic), solved for brightness).
    pub(super) fn to_metallic(self) -> Metallic {
        let brightness = |colour: Vec3| (colour * colour).dot(Vec3::new(0.299, 0.587, 0.114)).sqrt();
        let rest = 1.0 - self.specular.max_element();
        let (diffuse, specular) = (brightness(self.diffuse), brightness(self.specular));
        let metallic = if specular <= DIELECTRIC_SPECULAR {
            0.0
        } else {
            // Eliminating the base colour leaves a quadratic equation in the metallic factor.
            let a = DIELECTRIC_SPECULAR;
            let b = diffuse * rest / (1.0 - a) + specular - 2.0 * a;
            let c = a - specular;
            ((-b + (b * b - 4.0 * a * c).max(0.0).sqrt()) / (2.0 * a)).clamp(0.0, 1.0)
        };
        let from_diffuse = self.diffuse * (rest / (1.0 - DIELECTRIC_SPECULAR) / (1.0 - metallic).max(1e-4));
        let from_specular = (self.specular - DIELECTRIC_SPECULAR * (1.0 - metallic)) / metallic.max(1e-4);
        // Each estimate is good where its share of the light is large.
        let base_colour = from_diffuse.lerp(from_specular, metallic * metallic).clamp(Vec3::ZERO, Vec3::ONE);
        Metallic { base_colour, metallic, roughness: 1.0 - self.glossiness }
    }
}

/// Converts a textured specular-glossiness material; its base colour slot holds the diffuse texture, which
/// keeps its alpha.
pub(super) fn glossy(
    material: &Material,
    factors: Glossy,
    texture: Option<TextureRef>,
    textures: &[Texels],
    images: &mut Images,
) -> Result<Baked, String> {
    let used = [material.base_colour_texture, texture];
    let stack = Stack::new(&used, textures, images);
    // Two textures laid out differently cannot be mixed: the diffuse one gives the place.
    let Some(place) = used[0].or(used[1]) else { return Ok(Baked::default()) };
    let separate = common_place(&used).is_none();
    let specular_mean = separate.then(|| [0, 1, 2, 3].map(|channel| stack.mean(images, 1, channel)));

    let convert = |x: u32, y: u32| {
        let linear = |[red, green, blue, _]: [f32; 4]| Vec3::new(red, green, blue).map(linear_from_srgb);
        let shiny = specular_mean.unwrap_or_else(|| stack.texel(1, x, y));
        let surface = Glossy {
            diffuse: factors.diffuse * linear(stack.texel(0, x, y)),
            specular: factors.specular * linear(shiny),
            glossiness: factors.glossiness * shiny[3],
        };
        surface.to_metallic()
    };
    let base = images.make(stack.size, |x, y| {
        let colour = convert(x, y).base_colour.map(srgb_from_linear);
        [colour.x, colour.y, colour.z, stack.texel(0, x, y)[3]].map(byte)
    })?;
    let rough = images.make(stack.size, |x, y| {
        let surface = convert(x, y);
        [0.0, surface.roughness, surface.metallic, 1.0].map(byte)
    })?;
    let like = &textures[place.texture as usize];
    let made = |what: &str, source: Source, srgb: bool| Texels {
        name: format!("{} as {what}", like.name),
        source,
        srgb,
        ..like.clone()
    };
    Ok(Baked {
        textures: vec![made("base colour", base, true), made("metallic-roughness", rough, false)],
        base_colour: Some(TextureRef { texture: 0, ..place }),
        metallic_roughness: Some(TextureRef { texture: 1, ..place }),
        shortcoming: separate
            .then_some("its specular colour is the same all over: its textures are laid out differently"),
        is_even: false,
    })
}

fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mapping of the extension's appendix from metallic-roughness to specular-glossiness.
    fn to_glossy(surface: Metallic) -> Glossy {
        let diffuse = surface.base_colour * (1.0 - DIELECTRIC_SPECULAR) * (1.0 - surface.metallic);
        let specular = Vec3::splat(DIELECTRIC_SPECULAR).lerp(surface.base_colour, surface.metallic);
        let rest = 1.0 - specular.max_element();
        Glossy { diffuse: diffuse / rest.max(1e-4), specular, glossiness: 1.0 - surface.roughness }
    }

    #[test]
    fn specular_glossiness_goes_there_and_back() {
        for metallic in [0.0, 1.0] {
            for base_colour in [Vec3::new(0.8, 0.2, 0.1), Vec3::splat(0.5), Vec3::new(0.1, 0.6, 0.9)] {
                let back = to_glossy(Metallic { base_colour, metallic, roughness: 0.3 }).to_metallic();
                assert!(
                    back.base_colour.abs_diff_eq(base_colour, 0.02),
                    "{back:?} from {base_colour} {metallic}"
                );
                assert!(
                    (back.metallic - metallic).abs() < 0.02 && (back.roughness - 0.3).abs() < 1e-6,
                    "{back:?}"
                );
            }
        }
    }

    #[test]
    fn even_transmission_keeps_alpha_tests_and_ignored_alpha() {
        let lowered = |alpha_mode, has_opaque_texels| {
            let mut material = Material { alpha_mode, ..Material::default() };
            lower_evenly(&mut material, 0.25, has_opaque_texels);
            (material.alpha_mode, material.base_colour.w, material.opacity)
        };
        assert_eq!(lowered(AlphaMode::Blend, false), (AlphaMode::Blend, 0.25, 1.0));
        assert_eq!(lowered(AlphaMode::Opaque, true), (AlphaMode::Blend, 0.25, 1.0));
        assert_eq!(lowered(AlphaMode::Opaque, false), (AlphaMode::Opaque, 1.0, 0.25));
        let mask = AlphaMode::Mask { cutoff: 0.5 };
        assert_eq!(lowered(mask, false), (mask, 1.0, 0.25));
    }
}
