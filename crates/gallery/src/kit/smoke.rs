//! What smoke is made of: an atlas of puffs and the material that shows them.

use glam::{IVec2, Vec2, Vec3};
use rayon::prelude::*;
use sheer_image::Image;
use sheer_scene::model::{AlphaMode, Material, ShadingModel, TextureRef};

use crate::{
    builder::SceneBuilder,
    paint::{Fractal, Noise, Octave, Spot, paint_colour, smoothstep},
    rng::Rng,
};

/// Columns and rows of the atlas.
pub(crate) const ATLAS: [u32; 2] = [4, 4];

/// Texels along the edge of a puff.
const PUFF_SIZE: u32 = 128;

/// Sixteen puffs: lumps of warped noise that thin out towards the rim of an inscribed disc. The colour holds
/// what light inside the puff does: folds are a little darker than lobes.
pub(crate) fn puff_atlas(seed: u32) -> Image<[u8; 4]> {
    let [columns, rows] = ATLAS;
    let noise = |tile: u32| Noise { seed: seed.wrapping_mul(31).wrapping_add(tile) };
    let puffs: Vec<Puff> = (0..columns * rows).into_par_iter().map(|tile| Puff::new(noise(tile))).collect();
    // All puffs have the same directions from their middles, which are slow to come by.
    let directions = Image::par_from_fn(PUFF_SIZE, PUFF_SIZE, |x, y| {
        let p = Vec2::new(along_puff(x), along_puff(y));
        Vec2::from_angle(p.y.atan2(p.x))
    });
    let directions = directions.expect("small");
    paint_colour(columns * PUFF_SIZE, |Spot { texel: (x, y), .. }| {
        let texel = (x % PUFF_SIZE, y % PUFF_SIZE);
        puffs[(y / PUFF_SIZE * columns + x / PUFF_SIZE) as usize].at(texel, directions[texel])
    })
}

/// Where the middle of a texel lies along the edge of its puff, -1 to 1.
fn along_puff(texel: u32) -> f32 {
    (texel as f32 + 0.5) / PUFF_SIZE as f32 * 2.0 - 1.0
}

/// The noise that a puff is made of.
struct Puff {
    swirls: Fractal,
    warp: [Image<f32>; 2],
}

impl Puff {
    fn new(noise: Noise) -> Self {
        let octave = |octave: u32| {
            let layer = Noise { seed: noise.seed.wrapping_add(octave.wrapping_mul(0x51ed)) };
            // Wider than any octave of a puff, so that nothing shows twice.
            let noise = layer.gradient(IVec2::splat(64));
            Octave { noise, scale: Vec2::splat((1 << octave) as f32), shift: 20.0 }
        };
        let swirls = Fractal { octaves: (0..4).map(octave).collect(), gain: 0.6 };
        // Domain warping turns clouds of noise into curls.
        let warp = [3.0, -7.0].map(|shift| {
            let points: Vec<f32> = (0..PUFF_SIZE).map(|at| along_puff(at) * 1.3 + shift).collect();
            swirls.coarse_sheet(&points, &points, 3)
        });
        Self { swirls, warp }
    }

    /// Colour and alpha of a texel that lies in a direction from the middle.
    fn at(&self, texel: (u32, u32), direction: Vec2) -> (Vec3, f32) {
        let p = Vec2::new(along_puff(texel.0), along_puff(texel.1));
        let radius = p.length();
        let curled = p + 0.45 * Vec2::new(self.warp[0][texel], self.warp[1][texel]);
        let body = self.swirls.at(curled * 1.9);
        // Billows: creases where the folded noise crosses zero, lobes between.
        let billow = self.swirls.coarse_at(curled * 2.6 + 11.0, 3).abs();
        let wobble = 0.22 * self.swirls.coarse_at(direction * 1.4, 2);
        let envelope = 1.0 - smoothstep(0.25, 0.93, radius + wobble + 0.18 * body);
        let rim = 1.0 - smoothstep(0.80, 0.97, radius);
        let density = envelope * rim * (0.62 + 0.75 * body + 0.55 * billow).clamp(0.0, 1.0);
        let value = 0.80 + 0.20 * smoothstep(-0.1, 0.5, body + 0.6 * billow);
        (Vec3::splat(value), density)
    }
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
