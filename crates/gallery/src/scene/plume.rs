//! `plume`: smoke rises from a fire bowl in an empty court, lit from the side so that it shades itself (ST
//! Fig. 8).

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3};
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
    environment::{Environment, Lobe},
    particle::{Particle, ParticleSystem, Turbulence},
};

use crate::{
    builder::SceneBuilder,
    kit::{
        furniture,
        palette::Palette,
        smoke::{self, ATLAS},
    },
    rng::Rng,
    seed::SEED,
    shape::Model,
};

pub(crate) const PARAMETERS: &[ParameterInfo] = &[
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

pub(crate) fn build(values: &Values) -> Result<Scene, SceneError> {
    let towards_sun = Vec3::new(-0.84, 0.40, 0.30).normalize();
    let environment = Environment {
        zenith: Vec3::new(0.035, 0.050, 0.085),
        horizon: Vec3::new(0.085, 0.085, 0.095),
        ground: Vec3::new(0.05, 0.045, 0.045),
        lobes: vec![
            Lobe { direction: towards_sun, radiance: Vec3::new(1.6, 1.15, 0.7), sharpness: 7.0 },
            Lobe {
                direction: Vec3::new(0.8, 0.3, -0.5).normalize(),
                radiance: Vec3::new(0.10, 0.16, 0.30),
                sharpness: 3.0,
            },
        ],
        ..Environment::black()
    };
    let mut builder = SceneBuilder::new("plume", environment);
    let palette = Palette::new(&mut builder, values.count(SEED.key));
    builder.sun(towards_sun, Vec3::new(8.6, 7.2, 5.4));
    put_court(&mut builder, &palette, values.count(SEED.key));

    let material = smoke::material(&mut builder, values.count(SEED.key));
    builder.particles(ParticleSystem {
        name: "plume".to_owned(),
        material,
        atlas: ATLAS,
        particles: plume(values.count("particles"), values.real("density"), values.count(SEED.key)),
        loop_secs: Some(LOOP_SECS),
        turbulence: Turbulence { amplitude: 0.11, scale: 2.2, speed: 0.06 },
        fade: [0.06, 0.55],
        near_fade: [0.9, 0.2],
    });

    builder.camera(Camera::fixed("static", 0.68, Vec3::new(1.6, 2.1, 12.2), Vec3::new(0.55, 3.65, 0.0)));
    let key = |time_secs, eye, target| CameraKey { time_secs, eye, target };
    builder.camera(Camera {
        name: "path".to_owned(),
        lens: Lens::Perspective { yfov_rad: 0.68 },
        clip: ClipPlanes::NONE,
        motion: CameraMotion::Path {
            keys: vec![
                key(0.0, Vec3::new(5.6, 1.5, 10.4), Vec3::new(0.5, 3.4, 0.0)),
                key(5.0, Vec3::new(0.6, 2.2, 11.6), Vec3::new(0.5, 3.5, 0.0)),
                key(10.0, Vec3::new(-5.0, 3.0, 10.6), Vec3::new(0.6, 3.4, 0.0)),
            ],
        },
    });
    builder.finish()
}

/// A round floor of slabs with a stone rim around the fire, and a curved wall behind it.
fn put_court(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let mut rng = Rng::new(seed, "court");
    let mut court = Model::default();
    court.paint(palette.slabs, Vec3::new(0.50, 0.47, 0.45)).panel(
        Vec3::new(-30.0, 0.0, 30.0),
        Vec3::X * 60.0,
        Vec3::Z * -60.0,
    );
    court.paint(palette.ashlar, Vec3::splat(0.7)).lathe(
        Vec3::ZERO,
        &[(1.9, 0.0), (1.88, 0.14), (1.5, 0.15), (1.48, 0.06), (0.0, 0.06)],
        64,
    );
    builder.put("court", court);
    let bowl = builder.prop("fire bowl", furniture::fire_bowl(palette, &mut rng));
    let world_from_bowl = Affine3A::from_rotation_translation(Quat::IDENTITY, Vec3::Y * 0.06);
    builder.place(&bowl, world_from_bowl);
    builder.lamp("embers", Vec3::new(0.0, 1.25, 0.0), Vec3::new(5.0, 1.7, 0.4), 9.0);
}

/// Puffs of smoke in rings that the fire breathes out: each ring rises, widens, curls around its own core and
/// leans with the wind.
fn plume(count: u32, density: f32, seed: u32) -> Vec<Particle> {
    let mut rng = Rng::new(seed, "plume");
    // The same optical depth whatever the count: fewer puffs are larger.
    let scale = (100_000.0 / count.max(1) as f32).powf(0.4).clamp(0.6, 3.0);
    let rings: Vec<Ring> = (0..RING_COUNT).map(|index| Ring::new(index, &mut rng)).collect();
    (0..count)
        .map(|index| {
            let ring = &rings[index as usize % rings.len()];
            // Most puffs lie on the ring's core, some in its middle, some trail behind as haze.
            let around = Vec2::from_angle(rng.between(0.0, TAU));
            let strand = Vec3::new(around.x, 0.0, around.y);
            let (reach, stray) = match rng.unit() {
                share if share < 0.62 => (1.0, 0.34),
                share if share < 0.88 => (rng.unit(), 0.5),
                _ => (1.25, 0.8),
            };
            let lag_secs = rng.gaussian().x * ring.spread_secs;
            let lifetime_secs = LOOP_SECS * rng.between(0.80, 1.0);
            // Five lobes make the ring a cauliflower.
            let lobe = 1.0 + 0.22 * (5.0 * around.y.atan2(around.x) + ring.phase).sin();
            let out = (strand * reach * lobe + rng.gaussian() * stray * 0.5) * ring.width;
            let origin =
                Vec3::Y * 0.95 + strand * reach * 0.22 + rng.gaussian() * Vec3::new(0.07, 0.04, 0.07);
            let aim = ring.aim + out * Vec3::new(1.0, 0.75, 1.0);
            // Fast at first, slowing as it cools; the wind takes hold gradually, and the ring widens evenly.
            let late = Vec3::new(ring.aim.x * 0.8, (aim - origin).y * -0.55, ring.aim.z * 0.8);
            let acceleration = late * 2.0 / (lifetime_secs * lifetime_secs);
            let velocity = (aim - origin) / lifetime_secs - 0.5 * acceleration * lifetime_secs;
            Particle {
                birth_secs: ring.birth_secs + lag_secs,
                lifetime_secs,
                origin,
                velocity,
                acceleration,
                half_size: [0.045 * scale, rng.between(0.15, 0.30) * scale],
                rotation_rad: rng.between(0.0, TAU),
                spin_rad_per_sec: rng.about(0.0, 0.6),
                alpha: (density * rng.between(0.08, 0.24)).min(1.0),
                tint: smoke::tint(&mut rng),
                tile: rng.below(ATLAS[0] * ATLAS[1]),
            }
        })
        .collect()
}

/// A ring of smoke: what the fire breathes out at once.
struct Ring {
    birth_secs: f32,
    /// How long the breath takes.
    spread_secs: f32,
    /// Where its middle is when it has dissolved.
    aim: Vec3,
    /// Radius of the ring when it has dissolved, metres.
    width: f32,
    phase: f32,
}

const RING_COUNT: u32 = 13;

impl Ring {
    fn new(index: u32, rng: &mut Rng) -> Self {
        let big = index.is_multiple_of(2);
        let sway = Vec2::from_angle(TAU * 0.381_966 * index as f32) * rng.between(0.15, 0.55);
        Self {
            birth_secs: LOOP_SECS * (index as f32 + rng.about(0.0, 0.25)) / RING_COUNT as f32,
            spread_secs: if big { 0.22 } else { 0.34 },
            aim: Vec3::new(1.9 + sway.x, HEIGHT * rng.between(0.92, 1.12), sway.y),
            width: if big { rng.between(1.35, 1.7) } else { rng.between(0.85, 1.15) },
            phase: rng.between(0.0, TAU),
        }
    }
}
