//! What smoke is made of: an atlas of puffs and the material that shows them.

use glam::{IVec2, Vec2, Vec3};
use sheer_image::Image;
use sheer_scene::model::{AlphaMode, Material, ShadingModel, TextureRef};

use crate::{
    builder::SceneBuilder,
    paint::{Noise, paint_colour, smoothstep},
    rng::Rng,
};

/// Columns and rows of the atlas.
pub(crate) const ATLAS: [u32; 2] = [4, 4];

/// Sixteen puffs, 128 texels each: lumps of warped noise that thin out towards the rim of an inscribed disc.
/// The colour holds what light inside the puff does: folds are a little darker than lobes.
pub(crate) fn puff_atlas(seed: u32) -> Image<[u8; 4]> {
    paint_colour(512, |uv| {
        let scaled = uv * Vec2::new(ATLAS[0] as f32, ATLAS[1] as f32);
        let tile = scaled.floor();
        let p = (scaled - tile) * 2.0 - 1.0;
        let noise = Noise { seed: seed.wrapping_mul(31).wrapping_add((tile.y * 4.0 + tile.x) as u32) };
        puff(noise, p)
    })
}

/// Colour and alpha of one puff at `p` in [-1, 1]².
fn puff(noise: Noise, p: Vec2) -> (Vec3, f32) {
    let radius = p.length();
    let everywhere = IVec2::splat(64);
    let fractal = |at: Vec2, octaves: u32| {
        let mut sum = 0.0;
        for octave in 0..octaves {
            let scale = (1 << octave) as f32;
            let layer = Noise { seed: noise.seed.wrapping_add(octave.wrapping_mul(0x51ed)) };
            sum += layer.gradient(at * scale + 20.0, everywhere) / scale;
        }
        sum * 0.6
    };
    // Domain warping turns clouds of noise into curls.
    let warp = Vec2::new(fractal(p * 1.3 + 3.0, 3), fractal(p * 1.3 - 7.0, 3));
    let curled = p + 0.45 * warp;
    let body = fractal(curled * 1.9, 4);
    // Billows: creases where the folded noise crosses zero, lobes between.
    let billow = (fractal(curled * 2.6 + 11.0, 3)).abs();
    let wobble = 0.22 * fractal(Vec2::from_angle(p.y.atan2(p.x)) * 1.4, 2);
    let envelope = 1.0 - smoothstep(0.25, 0.93, radius + wobble + 0.18 * body);
    let rim = 1.0 - smoothstep(0.80, 0.97, radius);
    let density = envelope * rim * (0.62 + 0.75 * body + 0.55 * billow).clamp(0.0, 1.0);
    let value = 0.80 + 0.20 * smoothstep(-0.1, 0.5, body + 0.6 * billow);
    (Vec3::splat(value), density)
}

/// The material of all smoke: what it looks like beyond its light is in its atlas and in each particle's
/// tint.
pub(crate) fn material(builder: &mut SceneBuilder, seed: u32) -> u32 {
    let atlas = builder.texture("puffs", move || puff_atlas(seed));
    builder.material(Material {
        name: "smoke".to_owned(),
        model: ShadingModel::Smoke,
        base_colour_texture: Some(TextureRef::new(atlas)),
        alpha_mode: AlphaMode::Blend,
        double_sided: true,
        ..Material::default()
    })
}

/// A light grey that varies a little, now warmer, now cooler.
pub(crate) fn tint(rng: &mut Rng) -> Vec3 {
    let warmth = rng.about(0.0, 0.03);
    Vec3::new(0.70 + warmth, 0.70, 0.70 - warmth) * rng.between(0.86, 1.06)
}
