//! Texture lookup: trilinear in linear light, with the alpha channel kept apart for the any-hit test.
//!
//! How much of a texture a lookup sees, its footprint, comes with it. Which levels that is takes the bits of
//! the footprint instead of a logarithm, which devices round otherwise: the exponent is the level, and the
//! mantissa the weight of the next, linear from one level to the next instead of logarithmic.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use glam::{Vec2, Vec4};
use rayon::prelude::*;

use self::{
    alpha_map::AlphaMap,
    mip_chain::{AlphaUse, Level},
};
pub use self::{decoding::decode_tables, mip_chain::MipChain};
use crate::model::{AlphaMode, Filter, LevelFilter, Minification, SceneParts, Texture, Wrap};

mod alpha_map;
mod decoding;
mod mip_chain;

/// How many lookups at most share a long footprint among them: more keep distant ground sharper at grazing
/// angles, for as much more time a fragment.
pub const MOST_PROBES: u32 = 2;
/// The mantissa from which on the next level is the nearer one: the root of 2, by the logarithm of sizes.
pub const NEXT_LEVEL: f32 = std::f32::consts::SQRT_2 - 1.0;

/// Probes less far apart than this share of their footprint are as good as one: what they could tell apart is
/// the square of it.
pub const LEAST_GAP: f32 = 0.01;

/// A texture ready for lookups.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    chain: Arc<MipChain>,
    /// For textures whose alpha materials ask for, unless they are mirrored.
    alpha_map: Option<Arc<AlphaMap>>,
    decode: &'static [f32; 256],
    wrap: [Wrap; 2],
    filter: Filter,
    minification: Minification,
}

/// What a lookup sees of a texture: an ellipse, taken for a strip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    /// Its longer axis from end to end, texture coordinates.
    pub(crate) axis: Vec2,
    /// How long that is, texels.
    pub(crate) length: f32,
    /// How wide it is, texels; no more than its length.
    pub(crate) width: f32,
}

/// The first texture whose levels are the same, for each texture.
fn owners(parts: &SceneParts, alpha_uses: &[AlphaUse]) -> Vec<usize> {
    let mut first = HashMap::new();
    let owner = |(index, texture): (usize, &Texture)| {
        // What levels depend on.
        let has_levels = texture.minification.levels != LevelFilter::None;
        let alpha_use = match alpha_uses[index] {
            AlphaUse::None => None,
            AlphaUse::Blend => Some(None),
            AlphaUse::Test { cutoff } => Some(Some(cutoff.to_bits())),
        };
        let made_of = (Arc::as_ptr(&texture.image), has_levels.then_some((texture.srgb, alpha_use)));
        *first.entry(made_of).or_insert(index)
    };
    parts.textures.iter().enumerate().map(owner).collect()
}

/// Bytes that levels will take beyond those of one chain for each image: the same image is another one for
/// each cutoff that its alpha is tested against, and has a map of its alpha for each way to wrap it.
#[must_use]
pub fn level_bytes(parts: &SceneParts) -> u64 {
    let owners = owners(parts, &alpha_uses(parts));
    let (mut images, mut chains, mut maps) = (HashSet::new(), HashSet::new(), HashSet::new());
    let bytes = |(index, texture): (usize, &Texture)| {
        let texels = texture.image.as_slice().len() as u64;
        let is_new_image = images.insert(Arc::as_ptr(&texture.image));
        let is_new_chain = chains.insert(owners[index]);
        let is_new_map = maps.insert((owners[index], texture.wrap));
        // A byte of alpha, and a third of five below.
        let of_chain = if is_new_chain && !is_new_image { 3 * texels } else { 0 };
        of_chain + if is_new_map && !is_new_chain { AlphaMap::TEXEL_BYTES * texels } else { 0 }
    };
    parts.textures.iter().enumerate().map(bytes).fold(0, u64::saturating_add)
}

/// Samplers of all textures. Textures share levels that are the same.
pub(crate) fn samplers(parts: &SceneParts) -> Vec<Sampler> {
    let alpha_uses = alpha_uses(parts);
    let owners = owners(parts, &alpha_uses);
    let chains: Vec<Option<Arc<MipChain>>> = (0..parts.textures.len())
        .into_par_iter()
        .map(|index| {
            let texture = &parts.textures[index];
            (owners[index] == index).then(|| {
                Arc::new(match texture.minification.levels {
                    LevelFilter::None => MipChain::of_one(&texture.image),
                    _ => MipChain::new(&texture.image, texture.srgb, alpha_uses[index]),
                })
            })
        })
        .collect();
    let chain = |owner: usize| chains[owner].as_ref().expect("an owner has made its chain");
    // Maps are shared, too, by those that are wrapped alike.
    let mut maps: HashMap<(usize, [Wrap; 2]), Option<Arc<AlphaMap>>> = HashMap::new();
    let samplers = parts.textures.iter().zip(owners).zip(alpha_uses).map(|((texture, owner), alpha_use)| {
        let chain = chain(owner);
        let make_map = || AlphaMap::new(chain, texture.wrap).map(Arc::new);
        let map = (alpha_use != AlphaUse::None)
            .then(|| maps.entry((owner, texture.wrap)).or_insert_with(make_map).clone());
        Sampler::new(texture, Arc::clone(chain), map.flatten())
    });
    samplers.collect()
}

/// What materials use the alpha of each texture for. A test comes before anything else, and of several tests
/// the first: a level has one alpha.
fn alpha_uses(parts: &SceneParts) -> Vec<AlphaUse> {
    let mut uses = vec![AlphaUse::None; parts.textures.len()];
    for material in &parts.materials {
        let Some(used) = &material.base_colour_texture else { continue };
        let known = &mut uses[used.texture as usize];
        let factor = material.base_colour.w;
        match (material.alpha_mode, *known) {
            (AlphaMode::Opaque, _) | (_, AlphaUse::Test { .. }) => {}
            (AlphaMode::Mask { cutoff }, _) if cutoff > 0.0 && cutoff <= factor => {
                *known = AlphaUse::Test { cutoff: cutoff / factor };
            }
            (AlphaMode::Mask { .. } | AlphaMode::Blend, _) => *known = AlphaUse::Blend,
        }
    }
    uses
}

impl Footprint {
    /// No larger than a texel.
    #[cfg(test)]
    pub(crate) const POINT: Self = Self { axis: Vec2::ZERO, length: 0.0, width: 0.0 };

    /// As wide as it is long, texels.
    pub(crate) fn round(width: f32) -> Self {
        Self { axis: Vec2::ZERO, length: width, width }
    }
}

/// The level whose texels are next in size below a footprint of more than one texel, and the weight of the
/// level after it.
#[inline]
fn level_of(footprint: f32) -> (u32, f32) {
    let bits = footprint.to_bits();
    let mantissa = f32::from_bits((bits & 0x007f_ffff) | 1.0_f32.to_bits());
    ((bits >> 23) - 127, mantissa - 1.0)
}

/// The two texels on either side of a lookup, wrapped into the image, and the weight of the second.
#[inline]
fn neighbours(coordinate: f32, size: usize, wrap: Wrap, filter: Filter) -> ([usize; 2], f32) {
    let position = coordinate * size as f32;
    match filter {
        Filter::Nearest => {
            let texel = wrapped(floor(position), size, wrap);
            ([texel, texel], 0.0)
        }
        Filter::Linear => {
            let low = floor(position - 0.5);
            let texels = [wrapped(low, size, wrap), wrapped(low.wrapping_add(1), size, wrap)];
            (texels, position - 0.5 - low as f32)
        }
    }
}

/// Any texel index as one inside the image.
#[inline]
fn wrapped(texel: i32, size: usize, wrap: Wrap) -> usize {
    let size_i = size as i32;
    // Nearly all lookups fall inside, and a division costs as much as the rest of the lookup.
    if (texel as u32) < size as u32 {
        return texel as usize;
    }
    let inside = match wrap {
        Wrap::Repeat if size.is_power_of_two() => texel & (size_i - 1),
        Wrap::Repeat => texel.rem_euclid(size_i),
        Wrap::ClampToEdge => texel.clamp(0, size_i - 1),
        Wrap::MirroredRepeat => {
            let turn = texel.rem_euclid(size_i.saturating_mul(2));
            if turn < size_i { turn } else { 2 * size_i - 1 - turn }
        }
    };
    inside as usize
}

/// The next lower whole number, without the library call that `f32::floor` is on a plain x86-64.
#[inline]
fn floor(value: f32) -> i32 {
    let truncated = value as i32;
    truncated.wrapping_sub(i32::from((truncated as f32) > value))
}

impl Sampler {
    fn new(texture: &Texture, chain: Arc<MipChain>, alpha_map: Option<Arc<AlphaMap>>) -> Self {
        Self {
            chain,
            alpha_map,
            decode: &decode_tables()[usize::from(texture.srgb)],
            wrap: texture.wrap,
            filter: texture.filter,
            minification: texture.minification,
        }
    }

    pub(crate) fn chain(&self) -> &Arc<MipChain> {
        &self.chain
    }

    /// Width and height of the image, texels.
    pub(crate) fn size(&self) -> Vec2 {
        let [width, height] = self.chain.levels()[0].size;
        Vec2::new(width as f32, height as f32)
    }

    /// Colour and alpha at a point: linear, not multiplied. A long footprint is covered by several lookups
    /// side by side, each as long as the footprint is wide, if [`MOST_PROBES`] are enough for that.
    pub(crate) fn sample(&self, uv: Vec2, footprint: &Footprint) -> Vec4 {
        if footprint.length > 1.0 {
            self.sample_minified(uv, footprint)
        } else {
            self.sample_level(0, uv, self.filter)
        }
    }

    fn sample_minified(&self, uv: Vec2, footprint: &Footprint) -> Vec4 {
        let probe = footprint.width.max(footprint.length / MOST_PROBES as f32).max(1.0);
        let gap = (footprint.length - probe) / (footprint.length * (MOST_PROBES - 1) as f32);
        if gap >= LEAST_GAP && self.minification.levels != LevelFilter::None {
            // From one end to the other, the middle of all in the middle.
            let first = uv - footprint.axis * (0.5 * (MOST_PROBES - 1) as f32 * gap);
            let probes = (0..MOST_PROBES)
                .map(|index| self.sample_round(first + footprint.axis * (index as f32 * gap), probe));
            return probes.sum::<Vec4>() * (1.0 / MOST_PROBES as f32);
        }
        self.sample_round(uv, probe)
    }

    /// The same with a footprint as wide as it is long, at least one texel.
    fn sample_round(&self, uv: Vec2, footprint: f32) -> Vec4 {
        let (level, weight) = self.levels_of(footprint);
        let texel = self.sample_level(level, uv, self.minification.filter);
        if weight == 0.0 {
            return texel;
        }
        texel.lerp(self.sample_level(level + 1, uv, self.minification.filter), weight)
    }

    fn sample_level(&self, level: u32, uv: Vec2, filter: Filter) -> Vec4 {
        let level = &self.chain.levels()[level as usize];
        let texels = level.texels.as_slice();
        let ([a, b, c, d], [fx, fy]) = self.around(level, uv, filter);
        let texel = |index: usize| {
            let [r, g, b, a] = texels[index].map(usize::from);
            Vec4::new(self.decode[r], self.decode[g], self.decode[b], a as f32 / 255.0)
        };
        texel(a).lerp(texel(b), fx).lerp(texel(c).lerp(texel(d), fx), fy)
    }

    /// Alpha, 0 to 1, with a footprint as wide as it is long, texels.
    pub(crate) fn sample_alpha(&self, uv: Vec2, footprint: f32) -> f32 {
        if footprint > 1.0 {
            let (level, weight) = self.levels_of(footprint);
            let alpha = self.alpha_at(level, uv, self.minification.filter);
            if weight == 0.0 {
                return alpha;
            }
            alpha + (self.alpha_at(level + 1, uv, self.minification.filter) - alpha) * weight
        } else {
            self.alpha_at(0, uv, self.filter)
        }
    }

    #[inline(always)]
    fn alpha_at(&self, level: u32, uv: Vec2, filter: Filter) -> f32 {
        let mapped = self.alpha_map.as_ref().and_then(|map| map.at(level, uv, filter));
        mapped.unwrap_or_else(|| self.level_alpha(level, uv, filter))
    }

    /// The plain evaluation of alpha at a point of a level.
    #[cold]
    fn level_alpha(&self, level: u32, uv: Vec2, filter: Filter) -> f32 {
        let level = &self.chain.levels()[level as usize];
        let texels = level.texels.as_slice();
        let ([a, b, c, d], [fx, fy]) = self.around(level, uv, filter);
        let texel = |index: usize| f32::from(texels[index][3]);
        let upper = texel(a) + (texel(b) - texel(a)) * fx;
        let lower = texel(c) + (texel(d) - texel(c)) * fx;
        (upper + (lower - upper) * fy) * (1.0 / 255.0)
    }

    /// The level to look up for a footprint of at least a texel, and the weight of the next one; 0 where
    /// there is none.
    #[inline]
    fn levels_of(&self, footprint: f32) -> (u32, f32) {
        let last = self.chain.levels().len() as u32 - 1;
        let (level, weight) = level_of(footprint);
        let (level, weight) = match self.minification.levels {
            LevelFilter::Linear => (level, weight),
            LevelFilter::Nearest => (level + u32::from(weight > NEXT_LEVEL), 0.0),
            LevelFilter::None => (0, 0.0),
        };
        if level < last { (level, weight) } else { (last, 0.0) }
    }

    /// The four texels around a place, row by row, and the weights of the right and the lower ones.
    #[inline]
    fn around(&self, level: &Level, uv: Vec2, filter: Filter) -> ([usize; 4], [f32; 2]) {
        let [width, height] = level.size;
        let ([left, right], fx) = neighbours(uv.x, width, self.wrap[0], filter);
        let ([top, bottom], fy) = neighbours(uv.y, height, self.wrap[1], filter);
        let (top, bottom) = (top * width, bottom * width);
        ([top + left, top + right, bottom + left, bottom + right], [fx, fy])
    }
}

#[cfg(test)]
mod tests {
    use sheer_core::hash::{Pcg32, pcg3d};
    use sheer_image::Image;

    use super::*;
    use crate::model::{Material, TextureRef};

    fn sampler(wrap: Wrap, filter: Filter) -> Sampler {
        let image =
            Image::from_fn(2, 1, |x, _| if x == 0 { [0, 0, 0, 0] } else { [255, 255, 255, 255] }).unwrap();
        let texture = Texture {
            name: String::new(),
            image: Arc::new(image),
            srgb: true,
            wrap: [wrap; 2],
            filter,
            minification: Minification::default(),
        };
        of(texture)
    }

    fn of(texture: Texture) -> Sampler {
        let parts = SceneParts { textures: vec![texture], ..SceneParts::default() };
        samplers(&parts).remove(0)
    }

    fn blended(texture: Texture) -> Sampler {
        let material = Material {
            base_colour_texture: Some(TextureRef::new(0)),
            alpha_mode: AlphaMode::Blend,
            ..Material::default()
        };
        let parts =
            SceneParts { textures: vec![texture], materials: vec![material], ..SceneParts::default() };
        samplers(&parts).remove(0)
    }

    /// Whether lookups through the map of a sampler give the bits of the plain evaluation, at random places,
    /// near texels' middles and edges, far away and nowhere.
    fn map_is_plain(sampler: &Sampler, seed: u32) -> bool {
        let plain = Sampler { alpha_map: None, ..sampler.clone() };
        let mut random = Pcg32::new(seed.into(), 1);
        let size = sampler.size();
        (0..3000).all(|index| {
            let spread = [1.0, 2.0, 40.0, 1e5, 1e9][index % 5];
            let mut uv = Vec2::new(random.range(-spread, spread), random.range(-spread, spread));
            if index % 3 == 0 {
                uv = ((uv * size * 2.0).round() * 0.5) / size;
            }
            if index % 100 == 0 {
                uv.x = [f32::NAN, f32::INFINITY, -0.0, f32::MIN_POSITIVE][index / 100 % 4];
            }
            let footprint =
                [0.0, 1.0, random.range(1.0, 3.0), random.range(1.0, 300.0), f32::NAN][index / 5 % 5];
            let [mapped, plain] = [sampler, &plain].map(|sampler| sampler.sample_alpha(uv, footprint));
            mapped.to_bits() == plain.to_bits() || mapped.is_nan() && plain.is_nan()
        })
    }

    #[test]
    fn maps_of_alpha_give_the_bits_of_the_plain_evaluation() {
        let levels = [LevelFilter::Linear, LevelFilter::Nearest, LevelFilter::None];
        let filters = [Filter::Linear, Filter::Nearest];
        let wraps = [Wrap::Repeat, Wrap::ClampToEdge, Wrap::MirroredRepeat];
        for (seed, [width, height]) in (0..).zip([[32, 32], [37, 5], [1, 9], [64, 1], [1, 1], [48, 16]]) {
            let texel = |x: u32, y: u32| [pcg3d([x, y, seed])[0] as u8; 4];
            let image = Arc::new(Image::from_fn(width, height, texel).unwrap());
            for (u, v) in wraps.into_iter().flat_map(|u| wraps.map(|v| (u, v))) {
                for (filter, levels) in
                    filters.into_iter().flat_map(|filter| levels.map(|levels| (filter, levels)))
                {
                    let sampler = blended(Texture {
                        name: String::new(),
                        image: Arc::clone(&image),
                        srgb: true,
                        wrap: [u, v],
                        filter,
                        minification: Minification { filter, levels },
                    });
                    let is_mirrored = [u, v].contains(&Wrap::MirroredRepeat);
                    assert_eq!(sampler.alpha_map.is_none(), is_mirrored);
                    assert!(
                        map_is_plain(&sampler, seed),
                        "{width}×{height} {u:?} {v:?} {filter:?} {levels:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_map_that_is_wrapped_otherwise_is_found() {
        let texture = |wrap| Texture {
            name: String::new(),
            image: Arc::new(Image::from_fn(37, 5, |x, y| [pcg3d([x, y, 7])[0] as u8; 4]).unwrap()),
            srgb: true,
            wrap,
            filter: Filter::Linear,
            minification: Minification::default(),
        };
        let repeated = blended(texture([Wrap::Repeat; 2]));
        for wrap in [[Wrap::ClampToEdge, Wrap::Repeat], [Wrap::Repeat, Wrap::ClampToEdge]] {
            let wrong = Sampler { alpha_map: blended(texture(wrap)).alpha_map, ..repeated.clone() };
            assert!(!map_is_plain(&wrong, 1), "{wrap:?}");
        }
    }

    #[test]
    fn textures_share_maps_that_are_the_same_and_have_none_that_nobody_asks_for() {
        let image = Arc::new(Image::filled(4, 4, [255; 4]).unwrap());
        let texture = |wrap| Texture {
            name: String::new(),
            image: Arc::clone(&image),
            srgb: true,
            wrap: [wrap; 2],
            filter: Filter::Linear,
            minification: Minification::default(),
        };
        let material = |texture| Material {
            base_colour_texture: Some(TextureRef::new(texture)),
            alpha_mode: AlphaMode::Blend,
            ..Material::default()
        };
        let wraps = [Wrap::Repeat, Wrap::Repeat, Wrap::ClampToEdge, Wrap::Repeat];
        let parts = SceneParts {
            textures: wraps.map(texture).to_vec(),
            materials: (0..3).map(material).collect(),
            ..SceneParts::default()
        };
        let samplers = samplers(&parts);
        let map = |index: usize| samplers[index].alpha_map.as_ref();
        assert!(Arc::ptr_eq(map(0).unwrap(), map(1).unwrap()));
        assert!(!Arc::ptr_eq(map(0).unwrap(), map(2).unwrap()) && map(3).is_none());
        // A second chain, for the use without alpha, and a second map.
        assert_eq!(level_bytes(&parts), 16 * (2 + 3));
    }

    #[test]
    fn both_lookups_agree_on_alpha() {
        let sampler = sampler(Wrap::Repeat, Filter::Linear);
        for step in -40..40 {
            let uv = Vec2::new(step as f32 * 0.07, 0.3);
            for footprint in [0.0, 1.0, 1.3, 2.0, 5.0, f32::INFINITY, f32::NAN] {
                let alpha = sampler.sample(uv, &Footprint::round(footprint)).w;
                assert!((alpha - sampler.sample_alpha(uv, footprint)).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn wrapping_holds_tiles_or_mirrors_the_edge() {
        let at = |wrap, u| sampler(wrap, Filter::Nearest).sample_alpha(Vec2::new(u, 0.0), 0.0);
        assert_eq!(at(Wrap::ClampToEdge, 7.0), 1.0);
        assert_eq!(at(Wrap::Repeat, 1.2), 0.0);
        assert_eq!(at(Wrap::MirroredRepeat, 1.2), 1.0);
        assert_eq!(at(Wrap::Repeat, -0.2), 1.0);
    }

    #[test]
    fn absurd_coordinates_stay_inside() {
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            for u in [f32::NAN, f32::INFINITY, -1e30, 1e30] {
                let _ = sampler(wrap, Filter::Linear).sample(Vec2::new(u, u), &Footprint::POINT);
            }
        }
    }

    /// A chequerboard of black and white texels.
    fn chequerboard(minification: Minification) -> Sampler {
        let image = Image::from_fn(64, 64, |x, y| [if (x + y) % 2 == 0 { 255 } else { 0 }; 4]).unwrap();
        of(Texture {
            name: String::new(),
            image: Arc::new(image),
            srgb: true,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
            minification,
        })
    }

    /// Texture coordinates all over the image, in the middles of texels.
    fn places() -> impl Iterator<Item = Vec2> {
        (0..64_u16).map(|index| Vec2::new(f32::from(index) + 0.5, f32::from(index * 7 % 64) + 0.5) / 64.0)
    }

    #[test]
    fn one_lookup_with_a_footprint_sees_the_mean_of_a_chequerboard_and_one_without_a_texel() {
        let sampler = chequerboard(Minification::default());
        for uv in places() {
            let grey = sampler.sample(uv, &Footprint::round(8.0));
            // Half the light: as near as a byte comes to it.
            assert!((grey.x - 0.5).abs() < 0.005 && (grey.w - 0.5).abs() < 0.005, "{grey}");
            let texel = sampler.sample(uv, &Footprint::POINT);
            assert!((texel.x - 0.5).abs() > 0.49, "{texel}");
            let across = Footprint { axis: Vec2::new(8.0 / 64.0, 0.0), length: 8.0, width: 1.0 };
            let probed = sampler.sample(uv, &across);
            assert!((probed.x - 0.5).abs() < 0.01, "{probed}");
        }
    }

    #[test]
    fn a_long_footprint_blurs_along_its_axis_alone() {
        // Stripes of eight texels.
        let image = Image::from_fn(64, 64, |x, _| [if x / 8 % 2 == 0 { 255 } else { 0 }; 4]).unwrap();
        let texture = Texture {
            name: String::new(),
            image: Arc::new(image),
            srgb: false,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
            minification: Minification::default(),
        };
        let sampler = of(texture);
        let middle = Vec2::new(4.0 / 64.0, 0.3);
        let strip = |axis: Vec2| Footprint { axis: axis * (8.0 / 64.0), length: 8.0, width: 2.0 };
        assert!(sampler.sample(middle, &strip(Vec2::Y)).x > 0.99);
        assert!(sampler.sample(middle + Vec2::new(4.0 / 64.0, 0.0), &strip(Vec2::X)).x < 0.6);
        assert!(sampler.sample(middle, &Footprint::round(16.0)).x < 0.7, "round, it would blur both ways");
    }

    #[test]
    fn levels_follow_the_footprint_without_a_step() {
        let sampler = chequerboard(Minification::default());
        let at = |footprint: f32| sampler.sample_alpha(Vec2::splat(0.5 / 64.0), footprint);
        for edge in [1.0_f32, 2.0, 4.0, 64.0, 128.0] {
            assert!((at(edge.next_down()) - at(edge.next_up())).abs() < 1e-5, "{edge}");
        }
        assert_eq!([1.0, 1.5, 2.0, 7.0].map(level_of), [(0, 0.0), (0, 0.5), (1, 0.0), (2, 0.75)]);
    }

    #[test]
    fn a_sampler_without_levels_and_one_that_takes_the_nearest_are_obeyed() {
        let of = |levels| chequerboard(Minification { filter: Filter::Linear, levels });
        let (none, nearest) = (of(LevelFilter::None), of(LevelFilter::Nearest));
        for uv in places() {
            let far = Footprint { axis: Vec2::new(0.5, 0.0), length: 32.0, width: 8.0 };
            assert_eq!(none.sample(uv, &far), none.sample(uv, &Footprint::POINT));
            assert_eq!(none.sample_alpha(uv, 8.0), none.sample_alpha(uv, 0.0));
            assert_eq!(nearest.sample_alpha(uv, 1.4), nearest.sample_alpha(uv, 0.0));
            assert!((nearest.sample_alpha(uv, 1.5) - 0.5).abs() < 0.005);
        }
        assert_eq!(none.chain.levels().len(), 1);
    }

    #[test]
    fn alpha_is_kept_for_the_test_of_the_material_that_has_one() {
        let mut parts = SceneParts::default();
        let texture = || Texture {
            name: String::new(),
            image: Arc::new(Image::filled(2, 2, [255; 4]).unwrap()),
            srgb: true,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
            minification: Minification::default(),
        };
        parts.textures = (0..3).map(|_| texture()).collect();
        let material = |texture: u32, alpha_mode| Material {
            base_colour: Vec4::new(1.0, 1.0, 1.0, 0.8),
            base_colour_texture: Some(TextureRef::new(texture)),
            alpha_mode,
            ..Material::default()
        };
        parts.materials = vec![
            material(0, AlphaMode::Blend),
            material(0, AlphaMode::Mask { cutoff: 0.4 }),
            material(0, AlphaMode::Mask { cutoff: 0.6 }),
            material(1, AlphaMode::Opaque),
            material(2, AlphaMode::Mask { cutoff: 0.9 }),
        ];
        assert_eq!(alpha_uses(&parts), [AlphaUse::Test { cutoff: 0.5 }, AlphaUse::None, AlphaUse::Blend]);
    }
}
