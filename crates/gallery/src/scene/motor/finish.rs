//! What the motor is made of: metals and paints, all of one opacity.

use glam::Vec3;
use sheer_core::colour::linear_from_hex;
use sheer_scene::model::{AlphaMode, Material};

use crate::{builder::SceneBuilder, rng::Rng};

/// Indices of the materials that parts are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finish {
    /// Cast aluminium of block and heads.
    pub(super) cast: u32,
    /// Bright steel of what is ground or polished.
    pub(super) steel: u32,
    /// Forged steel of crankshaft, rods and brackets.
    pub(super) dark: u32,
    pub(super) brass: u32,
    pub(super) copper: u32,
    /// Aluminium anodised in blue.
    pub(super) blue: u32,
    /// Manifolds that glow with heat.
    pub(super) orange: u32,
    /// The colour of the maker: belt and covers.
    pub(super) accent: u32,
    pub(super) rubber: u32,
    pub(super) ceramic: u32,
    /// Clear covers that show what turns behind them.
    pub(super) glass: u32,
    /// The plate it stands on.
    pub(super) slate: u32,
}

/// What is sold as red, green, violet or yellow.
const ACCENTS: [u32; 4] = [0xc8_20_1c, 0x1c_8a_4a, 0x6a_3c_b8, 0xe0_a0_18];

impl Finish {
    pub(super) fn new(builder: &mut SceneBuilder, alpha: f32, seed: u32) -> Self {
        let mut rng = Rng::new(seed, "finish");
        let mut material = |name: &str, hex: u32, metallic: f32, roughness: f32| {
            // No two batches of paint are quite alike.
            let batch = Vec3::ONE + 0.03 * rng.gaussian();
            let colour = (linear_from_hex(hex) * batch).clamp(Vec3::ZERO, Vec3::ONE);
            builder.material(Material {
                name: name.to_owned(),
                base_colour: colour.extend(alpha),
                alpha_mode: AlphaMode::Blend,
                metallic,
                roughness,
                double_sided: true,
                ..Material::default()
            })
        };
        Self {
            cast: material("cast aluminium", 0xb4_bd_c8, 0.55, 0.42),
            steel: material("bright steel", 0xd8_dc_e2, 0.9, 0.22),
            dark: material("forged steel", 0x6c_74_80, 0.85, 0.34),
            brass: material("brass", 0xe6_b0_4a, 0.9, 0.25),
            copper: material("copper", 0xd8_7a_52, 0.9, 0.28),
            blue: material("blue anodised", 0x1c_5c_c8, 0.5, 0.28),
            orange: material("hot manifold", 0xe8_6a_1e, 0.45, 0.38),
            accent: material("accent", ACCENTS[seed as usize % ACCENTS.len()], 0.25, 0.3),
            rubber: material("rubber", 0x2a_2c_30, 0.0, 0.6),
            ceramic: material("ceramic", 0xf4_f2_ec, 0.0, 0.25),
            glass: material("clear cover", 0x5c_86_a0, 0.0, 0.15),
            slate: material("slate", 0x2c_34_40, 0.0, 0.3),
        }
    }
}
