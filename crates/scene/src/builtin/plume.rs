//! `plume`: smoke rises from a fire bowl in an empty court, lit from the side so that it shades itself (ST Fig. 8).

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::{
    ParameterInfo, ParameterRange, SEED, Values,
    chance::Chance,
    furniture,
    palette::Palette,
    shape::Model,
    smoke::{self, ATLAS},
    stage::Stage,
};
use crate::{
    SceneError,
    camera::{Camera, CameraKey, CameraMotion, Lens},
    environment::{Environment, Lobe},
    particle::{Particle, ParticleSystem, Turbulence},
    scene::Scene,
};

pub(super) const PARAMETERS: &[ParameterInfo] = &[
    ParameterInfo {
        key: "particles",
        default: "100000",
        range: ParameterRange::Count(0, 1_000_000),
        what: "how many quads the plume is made of",
    },
    ParameterInfo {
        key: "density",
        default: "1.0",
        range: ParameterRange::Real(0.0, 3.0),
        what: "factor on the opacity of every puff",
    },
    SEED,
];

const LOOP_SECS: f32 = 12.0;
/// How high the smoke gets before it has dissolved.
const HEIGHT: f32 = 6.6;

pub(super) fn build(values: &Values<'_>) -> Result<Scene, SceneError> {
    let towards_sun = Vec3::new(-0.86, 0.42, 0.12).normalize();
    let environment = Environment {
        zenith: Vec3::new(0.055, 0.075, 0.12),
        horizon: Vec3::new(0.10, 0.105, 0.13),
        ground: Vec3::new(0.05, 0.045, 0.045),
        lobes: vec![
            Lobe { direction: towards_sun, radiance: Vec3::new(1.6, 1.15, 0.7), sharpness: 7.0 },
            Lobe {
                direction: Vec3::new(0.8, 0.3, -0.5).normalize(),
                radiance: Vec3::new(0.10, 0.16, 0.30),
                sharpness: 3.0,
            },
        ],
    };
    let mut stage = Stage::new("plume", environment);
    let palette = Palette::new(&mut stage, values.seed());
    stage.sun(towards_sun, Vec3::new(4.6, 3.9, 3.0));
    put_court(&mut stage, &palette, values.seed());

    let material = smoke::material(&mut stage, values.seed());
    stage.particles(ParticleSystem {
        name: "plume".to_owned(),
        material,
        atlas: ATLAS,
        particles: plume(values.count("particles"), values.real("density"), values.seed()),
        loop_secs: Some(LOOP_SECS),
        turbulence: Turbulence { amplitude: 0.11, scale: 2.2, speed: 0.06 },
        fade: [0.06, 0.55],
        near_fade: [0.9, 0.2],
    });

    stage.camera(Camera::fixed("static", 0.62, Vec3::new(1.4, 2.2, 11.4), Vec3::new(0.35, 3.05, 0.0)));
    let key = |time_secs, eye, target| CameraKey { time_secs, eye, target };
    stage.camera(Camera {
        name: "path".to_owned(),
        lens: Lens::Perspective { yfov_rad: 0.62 },
        motion: CameraMotion::Path {
            keys: vec![
                key(0.0, Vec3::new(5.2, 1.6, 9.6), Vec3::new(0.4, 2.9, 0.0)),
                key(5.0, Vec3::new(0.6, 2.4, 10.4), Vec3::new(0.4, 3.1, 0.0)),
                key(10.0, Vec3::new(-4.6, 3.2, 9.0), Vec3::new(0.3, 3.2, 0.0)),
            ],
        },
    });
    stage.finish()
}

/// A round floor of slabs with a stone rim around the fire, and a curved wall behind it.
fn put_court(stage: &mut Stage, palette: &Palette, seed: u32) {
    let mut chance = Chance::new(seed, "court");
    let mut court = Model::default();
    court.paint(palette.slabs, Vec3::splat(0.75)).panel(
        Vec3::new(-30.0, 0.0, 30.0),
        Vec3::X * 60.0,
        Vec3::Z * -60.0,
    );
    court.paint(palette.ashlar, Vec3::splat(0.7)).lathe(
        Vec3::ZERO,
        &[(1.9, 0.0), (1.88, 0.14), (1.5, 0.15), (1.48, 0.06), (0.0, 0.06)],
        64,
    );
    stage.put("court", court);
    let bowl = stage.prop("fire bowl", furniture::fire_bowl(palette, &mut chance));
    let world_from_bowl = Affine3A::from_rotation_translation(Quat::IDENTITY, Vec3::Y * 0.06);
    stage.place(&bowl, world_from_bowl);
    stage.lamp("embers", Vec3::new(0.0, 1.25, 0.0), Vec3::new(5.0, 1.7, 0.4), 9.0);
}

/// Puffs of smoke on three strands that wind around one another, widen and lean with the wind.
fn plume(count: u32, density: f32, seed: u32) -> Vec<Particle> {
    let mut chance = Chance::new(seed, "plume");
    // The same optical depth whatever the count: more puffs are smaller and so many more a ray meets.
    let scale = (100_000.0 / count.max(1) as f32).powf(1.0 / 3.0).clamp(0.5, 3.0);
    (0..count)
        .map(|index| {
            let birth_secs = LOOP_SECS * (index as f32 + chance.unit()) / count as f32;
            // Pulses: the fire breathes, which makes the heads of mushrooms.
            let pulse = (TAU * birth_secs * 7.0 / LOOP_SECS).sin();
            let strand = index % 3;
            let turn = strand as f32 / 3.0 + birth_secs / LOOP_SECS * 4.0;
            let winding = Vec2::from_angle(TAU * turn);
            let lifetime_secs = LOOP_SECS * chance.between(0.82, 1.0);
            let spread = chance.gaussian();
            let origin =
                Vec3::new(winding.x * 0.14, 0.95, winding.y * 0.14) + spread * Vec3::new(0.13, 0.05, 0.13);
            let top = HEIGHT * (1.0 + 0.10 * pulse) * chance.between(0.93, 1.04);
            let aim = Vec3::new(winding.x * 0.75 + 1.5, top, winding.y * 0.75)
                + spread * Vec3::new(0.42, 0.25, 0.42) * (1.0 + 0.35 * pulse);
            // Fast at first, slowing as it cools; the wind takes hold gradually.
            let ease = Vec3::new(0.55, -0.55, 0.55);
            let acceleration = (aim - origin) * ease * 2.0 / (lifetime_secs * lifetime_secs);
            let velocity = (aim - origin) / lifetime_secs - 0.5 * acceleration * lifetime_secs;
            Particle {
                birth_secs,
                lifetime_secs,
                origin,
                velocity,
                acceleration,
                half_size: [0.05 * scale, chance.between(0.16, 0.30) * scale],
                rotation_rad: chance.between(0.0, TAU),
                spin_rad_per_sec: chance.about(0.0, 0.6),
                alpha: (density * chance.between(0.07, 0.20)).min(1.0),
                tint: smoke::tint(&mut chance),
                tile: chance.below(ATLAS[0] * ATLAS[1]),
            }
        })
        .collect()
}
