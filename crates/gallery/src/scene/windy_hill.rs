//! `windy-hill`: a girl sits on a hill in the wind; hairs, grass cards, scarf and kite are transparent and
//! shadow one another and what is opaque (ST Fig. 1).

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, IVec2, Quat, Vec2, Vec3, Vec4};
use rayon::prelude::*;
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
    environment::{Environment, Lobe},
    model::{AlphaMode, Material, ShadingModel, TextureRef},
    particle::{Particle, ParticleSystem, Turbulence},
};

use crate::{
    builder::SceneBuilder,
    kit::{
        body::Form,
        foliage::{Habit, tree},
        girl, grass, hair,
        palette::Palette,
        smoke::{ATLAS, puff_atlas},
        wind::{self, Sway},
    },
    paint::{Fractal, Noise, smoothstep},
    rng::Rng,
    seed::SEED,
    shape::{Model, Shape, Vertex},
};

pub(crate) const PARAMETERS: &[ParameterInfo] = &[
    ParameterInfo {
        key: "hairs",
        default: "15000",
        range: ParameterRange::Count(0, 200_000),
        what: "how many hairs she has",
    },
    ParameterInfo {
        key: "cards",
        default: "6000",
        range: ParameterRange::Count(0, 100_000),
        what: "how many cards of grass and flowers there are",
    },
    ParameterInfo {
        key: "alpha",
        default: "0.5",
        range: ParameterRange::Real(0.0, 1.0),
        what: "opacity of hairs and cloth",
    },
    ParameterInfo {
        key: "wind",
        default: "1.0",
        range: ParameterRange::Real(0.2, 1.5),
        what: "its strength; 1 is a fresh breeze",
    },
    SEED,
];

const YFOV_RAD: f32 = 0.52;
/// Hairs of an object: few enough that those of one seldom meet in a pixel.
const LOCK_SIZE: u32 = 50;
/// How far from the girl grass grows as cards, metres.
const MEADOW_RADIUS: f32 = 6.5;
/// Where she looks, as a turn around +Y from +Z: away from the camera and into the wind.
const GIRL_TURN_RAD: f32 = -1.80;
const EYE: Vec3 = Vec3::new(0.70, 0.86, 3.3);
const TARGET: Vec3 = Vec3::new(0.62, 0.83, 0.0);
const MILL: Vec3 = Vec3::new(-12.8, -5.0, -36.0);
const KITE: Vec3 = Vec3::new(3.2, 2.25, -4.4);

fn towards_sun() -> Vec3 {
    Vec3::new(0.66, 0.52, -0.42).normalize()
}

fn sky() -> Environment {
    Environment {
        zenith: Vec3::new(0.10, 0.25, 0.58),
        horizon: Vec3::new(0.74, 0.80, 0.85),
        ground: Vec3::new(0.14, 0.17, 0.07),
        lobes: vec![
            Lobe { direction: towards_sun(), radiance: Vec3::new(1.1, 0.95, 0.7), sharpness: 7.0 },
            Lobe { direction: towards_sun(), radiance: Vec3::new(6.0, 5.2, 3.8), sharpness: 140.0 },
        ],
        ..Environment::black()
    }
}

/// Blows towards +X and a little towards the camera.
fn breeze(strength: f32) -> Vec3 {
    Vec3::new(1.0, 0.0, 0.16).normalize() * strength
}

pub(crate) fn build(values: &Values) -> Result<Scene, SceneError> {
    let seed = values.count(SEED.key);
    let mut builder = SceneBuilder::new("windy-hill", sky());
    let palette = Palette::new(&mut builder, seed);
    builder.sun(towards_sun(), Vec3::new(5.8, 4.9, 3.6));
    put_land(&mut builder, &palette, seed);
    put_mill(&mut builder, &palette);
    put_props(&mut builder, &palette, seed);
    put_clouds(&mut builder, seed);
    let swaying = builder.swaying_node("wind", wind::weights());
    put_girl(&mut builder, swaying, values);
    put_kite(&mut builder, swaying, values);
    put_grass(&mut builder, swaying, values);

    let lens = Lens::Perspective { yfov_rad: YFOV_RAD };
    builder.camera(Camera::fixed("static", YFOV_RAD, EYE, TARGET));
    builder.camera(Camera::orbit(lens, Vec3::new(0.30, 0.78, 0.0), EYE));
    let key = |time_secs, eye, target| CameraKey { time_secs, eye, target };
    builder.camera(Camera {
        name: "path".to_owned(),
        lens,
        clip: ClipPlanes::NONE,
        motion: CameraMotion::Path {
            keys: vec![
                key(0.0, Vec3::new(1.9, 0.70, 3.6), Vec3::new(0.5, 0.80, 0.0)),
                key(5.0, Vec3::new(0.7, 0.90, 2.6), Vec3::new(0.5, 0.84, 0.0)),
                key(10.0, Vec3::new(-0.6, 1.05, 2.3), Vec3::new(0.3, 0.84, 0.0)),
            ],
        },
    });
    builder.finish()
}

/// The ground: a rounded top, a valley, and ridges beyond it.
struct Ground {
    bumps: Fractal,
    relief: Fractal,
}

impl Ground {
    fn new(noise: Noise) -> Self {
        Self { bumps: noise.fractal(IVec2::splat(6), 3), relief: noise.fractal(IVec2::new(9, 5), 4) }
    }

    fn height(&self, x: f32, z: f32) -> f32 {
        let radius = Vec2::new(x, z).length();
        let top = -0.016 * radius * radius / (1.0 + 0.0022 * radius * radius);
        let bumps = 0.05 * smoothstep(0.6, 2.5, radius) * self.bumps.at(Vec2::new(x, z) / 24.0 + 0.5);
        let far = smoothstep(25.0, 60.0, radius);
        let turn = z.atan2(x) / TAU + 0.5;
        let relief = self.relief.at(Vec2::new(turn, 0.5 + radius / 400.0));
        top + bumps + far * (3.0 * relief + 12.0 * (0.55 + relief) * smoothstep(60.0, 120.0, radius))
    }
}

fn put_land(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let noise = Noise { seed: seed.wrapping_add(900) };
    let ground = Ground::new(noise);
    let mut land = Model::default();
    let (rings, sides) = (64, 144);
    // Ever wider rings, from under her out to the ridges.
    let radius = |ring: u32| 140.0 * (ring as f32 / rings as f32).powf(2.6);
    let point = |ring: u32, side: u32| {
        let direction = Vec2::from_angle(TAU * side as f32 / sides as f32) * radius(ring);
        Vec3::new(direction.x, ground.height(direction.x, direction.y), direction.y)
    };
    let shape = land.paint(palette.meadow, Vec3::ONE);
    for ring in 0..=rings {
        for side in 0..=sides {
            let position = point(ring, side);
            // Slopes over a span as wide as the mesh is coarse there.
            let span = 0.05 + 0.02 * radius(ring);
            let height = |dx: f32, dz: f32| ground.height(position.x + dx * span, position.z + dz * span);
            let slope = Vec2::new(height(1.0, 0.0) - height(-1.0, 0.0), height(0.0, 1.0) - height(0.0, -1.0));
            let normal = Vec3::new(-slope.x, 2.0 * span, -slope.y).normalize();
            shape.vertex(Vertex { position, normal, uv: Vec2::new(position.x, position.z) });
        }
    }
    for ring in 0..rings {
        for side in 0..sides {
            let at = ring * (sides + 1) + side;
            let out = at + sides + 1;
            shape.indices.push([at, out + 1, out]);
            // The innermost ring is a point.
            if ring > 0 {
                shape.indices.push([at, at + 1, out + 1]);
            }
        }
    }
    // Sunlit turf, drier patches, and air that turns what is far blue.
    let patches = noise.fractal(IVec2::splat(14), 4);
    land.tint(palette.meadow, |p, _| {
        let patch = patches.at(Vec2::new(p.x, p.z) / 280.0 + 0.5);
        let haze = smoothstep(25.0, 130.0, p.with_y(0.0).length());
        let turf = Vec3::new(1.05, 1.25, 0.75) * (1.0 + 0.5 * patch);
        turf.lerp(Vec3::new(0.95, 1.35, 2.6), 0.8 * haze)
    });
    builder.put("land", land);
}

/// A windmill on the next hill, its sails of cloth.
fn put_mill(builder: &mut SceneBuilder, palette: &Palette) {
    let mut mill = Model::default();
    let wall = [(2.7, -2.0), (2.35, 1.5), (1.85, 5.0), (1.55, 7.4), (1.62, 7.5)];
    mill.paint(palette.plaster, Vec3::new(0.92, 0.89, 0.82)).lathe(MILL, &wall, 40);
    let cap = [(1.85, 7.45), (1.75, 7.8), (1.25, 8.7), (0.5, 9.4), (0.0, 9.6)];
    mill.paint(palette.planks, Vec3::new(0.30, 0.12, 0.08)).lathe(MILL, &cap, 40);
    let facing = (EYE - MILL).with_y(0.0).normalize();
    let across = Vec3::Y.cross(facing);
    let dark = mill.paint(palette.timber, Vec3::splat(0.14));
    for height in [1.6, 4.6] {
        let half = Vec3::Y * 0.55;
        let at = MILL + facing * (2.45 - 0.15 * height) + Vec3::Y * height + across * 0.3;
        dark.beam(at - half, at + half, across, 0.65, 0.3);
    }
    let hub = MILL + Vec3::Y * 8.1 + facing * 2.3;
    let timber = mill.paint(palette.timber, Vec3::splat(0.5));
    timber.beam(hub - facing * 1.6, hub + facing * 0.2, Vec3::Y, 0.28, 0.28);
    builder.put("mill", mill);

    let cloth = builder.material(Material {
        name: "sailcloth".to_owned(),
        base_colour: Vec4::new(0.92, 0.88, 0.78, 0.75),
        alpha_mode: AlphaMode::Blend,
        roughness: 0.9,
        double_sided: true,
        ..Material::default()
    });
    let mut sails = Model::default();
    for blade in 0..4 {
        let turn = Quat::from_axis_angle(facing, TAU * (blade as f32 / 4.0 + 0.09));
        let (out, side) = (turn * Vec3::Y, turn * across);
        let timber = sails.paint(palette.timber, Vec3::splat(0.45));
        timber.beam(Vec3::ZERO, out * 5.6, side, 0.16, 0.16);
        timber.beam(out * 1.1 + side * 1.25, out * 5.6 + side * 1.25, side, 0.08, 0.08);
        for bar in 0..=9 {
            let at = out * (1.1 + 0.5 * bar as f32);
            timber.beam(at, at + side * 1.25, out, 0.06, 0.06);
        }
        sails.paint(cloth, Vec3::ONE).panel(
            out * 1.1 + facing * 0.06,
            side * 1.25,
            out * 4.5 + facing * 0.25,
        );
    }
    builder.spin("sails", sails, hub, wind::turns(facing));
}

/// What stands still near her: boulders, a fence, a tree.
fn put_props(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let mut rng = Rng::new(seed, "windy hill");
    let noise = Noise { seed: seed.wrapping_add(900) };
    let ground = Ground::new(noise);
    let on_ground = |x: f32, z: f32| Vec3::new(x, ground.height(x, z), z);
    let stone =
        builder.material(Material { name: "stone".to_owned(), roughness: 0.9, ..Material::default() });
    let mut stones = Model::default();
    for (x, z, size) in [(1.42, -0.62, 0.27), (1.75, -0.35, 0.14), (-1.35, 0.35, 0.19), (-1.05, 0.55, 0.10)] {
        let radii = Vec3::new(1.0, 0.7, 0.85) * size;
        Form::Ellipsoid { centre: on_ground(x, z) + Vec3::Y * (0.2 * size), radii }
            .mesh(stones.paint(stone, Vec3::ONE), 0.0);
    }
    let lumps = noise.fractal(IVec2::splat(9), 4);
    stones.warp(stone, |p, n| {
        let at = Vec2::new(p.x + 0.7 * p.y, p.z - 0.6 * p.y);
        let lump = lumps.at(at / 4.0 + 0.5);
        p + n * (0.10 * lump)
    });
    let lichens = noise.fractal(IVec2::splat(16), 4);
    stones.tint(stone, |p, n| {
        let at = Vec2::new(p.x + 0.7 * p.y, p.z - 0.6 * p.y);
        let lichen = smoothstep(0.05, 0.35, lichens.at(at / 2.0 + 0.25));
        let grey = Vec3::new(0.42, 0.35, 0.27).lerp(Vec3::new(0.52, 0.48, 0.24), 0.7 * lichen);
        grey * (0.6 + 0.4 * smoothstep(-0.6, 0.6, n.y))
    });
    builder.put("stones", stones);

    let mut fence = Model::default();
    let wood = fence.paint(palette.timber, Vec3::new(0.62, 0.56, 0.50));
    let post = |index: i32| on_ground(-3.4 + 1.35 * index as f32, -2.9 - 0.55 * index as f32);
    for index in 0..8 {
        let (here, next) = (post(index), post(index + 1));
        let top = here + Vec3::new(rng.about(0.0, 0.05), rng.about(0.86, 0.05), rng.about(0.0, 0.03));
        wood.beam(here - Vec3::Y * 0.2, top, Vec3::X, 0.10, 0.09);
        for height in [0.38, 0.70] {
            let sag = Vec3::Y * rng.about(height, 0.04);
            wood.beam(here + sag, next + Vec3::Y * rng.about(height, 0.04), Vec3::Y, 0.085, 0.035);
        }
    }
    builder.put("fence", fence);

    let habit =
        Habit { height: 5.4, radius: 1.9, clear: 0.22, clump_count: 20, cards_per_clump: 60, turning: 0.08 };
    let oak = tree(palette, &mut rng, habit);
    // It has grown with the wind.
    let lean = Affine3A::from_cols(
        Vec3::X.into(),
        Vec3::new(0.26, 1.0, 0.04).into(),
        Vec3::Z.into(),
        on_ground(9.0, -15.0).into(),
    );
    builder.put_at("tree", oak, lean);
}

/// Fair-weather clouds: heaps of puffs with flat feet.
fn put_clouds(builder: &mut SceneBuilder, seed: u32) {
    let mut rng = Rng::new(seed, "clouds");
    let atlas = TextureRef::new(builder.texture("cloud puffs", move || puff_atlas(seed.wrapping_add(5))));
    // A cloud is so thick that light from all around comes out of it again: what single scattering lacks is
    // added as a glow.
    let material = builder.material(Material {
        name: "cloud".to_owned(),
        model: ShadingModel::Smoke,
        base_colour_texture: Some(atlas),
        emissive: Vec3::new(0.36, 0.40, 0.46),
        emissive_texture: Some(atlas),
        alpha_mode: AlphaMode::Blend,
        double_sided: true,
        ..Material::default()
    });
    let mut particles = Vec::new();
    for (x, y, z, size) in [
        (-62.0, 25.0, -125.0, 11.0),
        (-20.0, 20.0, -140.0, 7.0),
        (34.0, 33.0, -120.0, 10.0),
        (74.0, 20.0, -130.0, 9.0),
        (10.0, 13.5, -150.0, 5.0),
        (-85.0, 30.0, 60.0, 12.0),
        (30.0, 26.0, 130.0, 12.0),
        (95.0, 24.0, 70.0, 10.0),
    ] {
        for _ in 0..70 {
            let out = rng.gaussian() * Vec3::new(0.85, 0.30, 0.5);
            // Higher in the middle, flat below.
            let heap = (1.0 - 0.25 * out.x * out.x).max(0.2);
            let rise = (out.y.abs() * heap + 0.35 * heap * rng.unit()).max(0.02);
            let half_size = size * rng.between(0.36, 0.66) * (0.55 + 0.45 * heap);
            let white = 0.74 + 0.24 * smoothstep(0.0, 0.6, rise);
            particles.push(Particle {
                birth_secs: 0.0,
                lifetime_secs: f32::INFINITY,
                origin: Vec3::new(x, y, z) + Vec3::new(out.x * 1.5, rise, out.z) * size,
                velocity: Vec3::ZERO,
                acceleration: Vec3::ZERO,
                half_size: [half_size; 2],
                rotation_rad: rng.between(0.0, TAU),
                spin_rad_per_sec: 0.0,
                alpha: rng.between(0.45, 0.85),
                tint: Vec3::new(white * 0.98, white, white * 1.03),
                tile: rng.below(ATLAS[0] * ATLAS[1]),
            });
        }
    }
    builder.particles(ParticleSystem {
        name: "clouds".to_owned(),
        material,
        atlas: ATLAS,
        particles,
        loop_secs: None,
        turbulence: Turbulence::default(),
        fade: [0.0; 2],
        near_fade: [1.0, 0.2],
    });
}

fn world_from_girl() -> Affine3A {
    Affine3A::from_rotation_y(GIRL_TURN_RAD)
}

/// Cloth so thin that it is lit like the threads it is woven of: from both sides.
fn cloth(name: &str) -> Material {
    Material {
        name: name.to_owned(),
        model: ShadingModel::Fibre,
        alpha_mode: AlphaMode::Blend,
        roughness: 0.8,
        double_sided: true,
        ..Material::default()
    }
}

fn put_girl(builder: &mut SceneBuilder, swaying: u32, values: &Values) {
    let (count, alpha, seed) = (values.count("hairs"), values.real("alpha"), values.count(SEED.key));
    let plain = |name: &str, roughness| Material { name: name.to_owned(), roughness, ..Material::default() };
    let wardrobe = girl::Wardrobe {
        skin: builder.material(plain("skin", 0.55)),
        linen: builder.material(Material { double_sided: true, ..plain("linen", 0.9) }),
    };
    builder.put_at("girl", girl::figure(wardrobe), world_from_girl());
    let wind = world_from_girl().inverse().transform_vector3(breeze(values.real("wind")));
    let scarf = builder.material(cloth("scarf"));
    let poses = Sway::POSES.map(|sway| {
        let mut shape = Shape::default();
        girl::scarf(&mut shape, alpha, wind, sway);
        girl::placed(scarf, &shape, world_from_girl())
    });
    builder.sway("scarf", swaying, &poses);

    let material = builder.material(hair::material("hair", 0.38));
    let hairs = girl::hairs(count, seed, wind);
    // Dealt out one after the other, so that hairs that lie over one another belong to different objects.
    let lock_count = count.div_ceil(LOCK_SIZE) as usize;
    let locks: Vec<_> = (0..lock_count)
        .into_par_iter()
        .map(|lock| {
            Sway::POSES.map(|sway| {
                let mut shape = Shape::default();
                for hair in hairs.iter().skip(lock).step_by(lock_count) {
                    hair.build(&mut shape, alpha, sway);
                }
                girl::placed(material, &shape, world_from_girl())
            })
        })
        .collect();
    for poses in locks {
        builder.sway("lock", swaying, &poses);
    }
}

/// A kite of thin cloth over crossed sticks, with a tail, on a string from her hands.
fn put_kite(builder: &mut SceneBuilder, swaying: u32, values: &Values) {
    let alpha = values.real("alpha");
    let silk = builder.material(cloth("kite"));
    let stick =
        builder.material(Material { name: "stick".to_owned(), roughness: 0.7, ..Material::default() });
    let poses = Sway::POSES.map(|sway| {
        let mut model = Model::default();
        kite(&mut model, [silk, stick], alpha, sway);
        model
    });
    builder.sway("kite", swaying, &poses);
}

fn kite(model: &mut Model, [silk, stick]: [u32; 2], alpha: f32, sway: Sway) {
    let rock = Quat::from_rotation_z(-0.42 + 0.10 * sway.billow(0.4)) * Quat::from_rotation_x(-0.35);
    let middle = KITE + Vec3::new(0.05 * sway.flutter(1.0), 0.14 * sway.billow(0.0), 0.0);
    let at = |x: f32, y: f32| middle + rock * Vec3::new(x, y, 0.04 * (1.0 - x.abs() * 3.0));
    let [top, left, right, foot] = [at(0.0, 0.34), at(-0.30, 0.12), at(0.30, 0.12), at(0.0, -0.46)];
    let heart = at(0.0, 0.12);
    for (corners, colour) in [
        ([heart, top, left], Vec3::new(0.95, 0.62, 0.10)),
        ([heart, right, top], Vec3::new(0.85, 0.12, 0.08)),
        ([heart, left, foot], Vec3::new(0.85, 0.12, 0.08)),
        ([heart, foot, right], Vec3::new(0.95, 0.62, 0.10)),
    ] {
        let shape = model.paint(silk, Vec3::ONE);
        shape.brush(colour.extend((1.5 * alpha).min(1.0)));
        patch(shape, corners, rock * Vec3::X);
    }
    let wood = model.paint(stick, Vec3::new(0.35, 0.22, 0.12));
    wood.tube(&[(top, 0.006), (foot, 0.006)], 5);
    wood.tube(&[(left, 0.006), (heart, 0.006), (right, 0.006)], 5);
    // A tail with bows, and the string.
    let tail = |way: f32| {
        let swing = 0.16 * way * sway.billow(4.0 * way + 1.0) + 0.05 * way * sway.flutter(9.0 * way);
        foot + Vec3::new(0.75 * way, -0.75 * way + 0.25 * way * way + swing, 0.1 * way)
    };
    let line = |at: &dyn Fn(f32) -> Vec3, radius: f32| -> Vec<(Vec3, f32)> {
        (0..=24).map(|i| (at(i as f32 / 24.0), radius)).collect()
    };
    wood.tube(&line(&tail, 0.003), 4);
    let hand = world_from_girl().transform_point3(Vec3::new(0.0, 0.40, 0.37));
    let string = |way: f32| hand.lerp(heart, way) - Vec3::Y * (0.30 * (PI * way).sin());
    wood.brush(Vec4::new(0.85, 0.83, 0.78, 1.0));
    wood.tube(&line(&string, 0.0014), 4);
    for bow in 1..=6 {
        let (knot, turn) = (tail(bow as f32 / 6.0), 0.6 * bow as f32);
        let wing = Vec3::new(turn.cos(), 0.3, turn.sin()) * 0.07;
        let shape = model.paint(silk, Vec3::ONE);
        shape.brush(Vec4::new(0.06, 0.26, 0.60, (1.5 * alpha).min(1.0)));
        for side in [wing, -wing] {
            patch(shape, [knot, knot + side + Vec3::Y * 0.035, knot + side - Vec3::Y * 0.035], Vec3::Y);
        }
    }
}

/// A triangle of cloth whose threads run this way.
fn patch(shape: &mut Shape, corners: [Vec3; 3], threads: Vec3) {
    let vertex = |position: Vec3| shape.vertex(Vertex { position, normal: threads, uv: Vec2::ZERO });
    let triangle = corners.map(vertex);
    shape.indices.push(triangle);
}

/// Cards all around her, each an object of its own.
fn put_grass(builder: &mut SceneBuilder, swaying: u32, values: &Values) {
    let (count, seed) = (values.count("cards"), values.count(SEED.key));
    let noise = Noise { seed: seed.wrapping_add(900) };
    let ground = Ground::new(noise);
    let patches = noise.fractal(IVec2::splat(14), 3);
    let atlas = builder.texture("grass", move || grass::atlas(seed));
    let material = builder.material(Material {
        name: "grass".to_owned(),
        model: ShadingModel::Fibre,
        base_colour_texture: Some(TextureRef::new(atlas)),
        alpha_mode: AlphaMode::Blend,
        roughness: 0.5,
        double_sided: true,
        ..Material::default()
    });
    let mut rng = Rng::new(seed, "grass");
    let wind = breeze(values.real("wind"));
    for _ in 0..count {
        let place = loop {
            let place = grass::strewn(&mut rng, MEADOW_RADIUS);
            // Not through her skirt, nor in front of the lens.
            if place.length() > 0.44 && place.distance(Vec2::new(EYE.x, EYE.z)) > 0.9 {
                break place;
            }
        };
        let foot = Vec3::new(place.x, ground.height(place.x, place.y) - 0.02, place.y);
        let patch = patches.at(place / 16.0 + 0.5);
        // Trodden down near her, high further out.
        let height = (0.26 + 0.16 * patch) * (0.65 + 0.5 * smoothstep(0.4, 1.3, place.length()));
        let card = grass::Card::at(foot, height.max(0.12), &mut rng);
        let poses = Sway::POSES.map(|sway| {
            let mut shape = Shape::default();
            card.build(&mut shape, wind, sway);
            Model::from_shape(material, shape)
        });
        builder.sway("card", swaying, &poses);
    }
}

#[cfg(test)]
mod tests {
    use sheer_scene::{Animator, CameraChoice};
    use std::sync::Arc;

    use super::*;
    use crate::catalogue;

    fn small() -> Scene {
        catalogue::build("windy-hill:hairs=130,cards=40").unwrap()
    }

    /// Triangles by the name of their mesh, at a time.
    fn triangles(animator: &mut Animator, name: &str, time_secs: f32) -> Vec<[Vec3; 3]> {
        let frame = animator.advance(time_secs, time_secs);
        let parts = frame.scene().parts();
        let named = |triangle: &u32| {
            let id = frame.object(*triangle).id;
            let instance = parts.instances.iter().find(|instance| instance.id == id);
            instance.is_some_and(|instance| parts.meshes[instance.mesh as usize].name == name)
        };
        let all = frame.static_count() as u32..frame.triangles().len() as u32;
        all.filter(named).map(|triangle| frame.triangles()[triangle as usize]).collect()
    }

    /// Farthest that a corner has gone.
    fn way(one: &[[Vec3; 3]], other: &[[Vec3; 3]]) -> f32 {
        let corners = one.iter().flatten().zip(other.iter().flatten());
        corners.map(|(one, other)| one.distance(*other)).fold(0.0, f32::max)
    }

    #[test]
    fn there_are_as_many_hairs_and_cards_as_asked_for() {
        let scene = small();
        let parts = scene.parts();
        let count = |name: &str| {
            let meshes = parts.meshes.iter().filter(|mesh| mesh.name == name);
            meshes.fold((0, 0), |(count, triangles), mesh| (count + 1, triangles + mesh.indices.len() as u32))
        };
        assert_eq!(count("lock"), (3, 130 * hair::triangle_count(girl::SEGMENTS as u32)));
        assert_eq!(count("card").0, 40);
        let bare = catalogue::build("windy-hill:hairs=0,cards=0").unwrap();
        assert!(!bare.parts().meshes.iter().any(|mesh| mesh.name == "lock" || mesh.name == "card"));
    }

    #[test]
    fn hair_grass_cloth_and_sails_move_and_the_loop_closes() {
        let scene = Arc::new(small());
        let camera = scene.camera(&CameraChoice::Default).unwrap();
        let mut animator = Animator::new(scene, camera);
        for (name, least) in [("lock", 0.05), ("card", 0.01), ("scarf", 0.1), ("kite", 0.1), ("sails", 1.0)] {
            let start = triangles(&mut animator, name, 0.0);
            assert!(!start.is_empty(), "{name}");
            let later = triangles(&mut animator, name, 0.23 * wind::LOOP_SECS);
            assert!(way(&start, &later) > least, "{name}: {}", way(&start, &later));
            let round = triangles(&mut animator, name, wind::LOOP_SECS);
            assert!(way(&start, &round) < 1e-4, "{name}: {}", way(&start, &round));
        }
    }

    #[test]
    fn roots_of_hairs_and_feet_of_cards_hold_still() {
        let scene = small();
        for mesh in &scene.parts().meshes {
            let stride = match mesh.name.as_str() {
                "lock" => 2 * girl::SEGMENTS + 1,
                "card" => mesh.positions.len(),
                _ => continue,
            };
            assert_eq!(mesh.morph_targets.len(), Sway::POSES.len() - 1);
            for target in &mesh.morph_targets {
                // The corners at the root may turn, their middle stays.
                let still = |thing: &[Vec3]| (thing[0] + thing[1]).length() < 1e-6;
                assert!(target.positions.chunks_exact(stride).all(still), "{}", mesh.name);
            }
            // A single target may be the moment at which a card stands straight.
            let moved = mesh.morph_targets.iter().flat_map(|target| &target.positions);
            assert!(moved.into_iter().any(|moved| moved.length() > 0.005), "{}", mesh.name);
        }
    }

    #[test]
    fn cards_are_blended_with_soft_alpha() {
        let scene = small();
        let grass = scene.parts().materials.iter().find(|material| material.name == "grass").unwrap();
        assert_eq!(grass.alpha_mode, AlphaMode::Blend);
        let texture = grass.base_colour_texture.unwrap().texture as usize;
        let texels = scene.parts().textures[texture].image.as_slice();
        let share = |range: std::ops::RangeInclusive<u8>| {
            texels.iter().filter(|texel| range.contains(&texel[3])).count() as f32 / texels.len() as f32
        };
        assert!(share(26..=242) > 0.15 && share(0..=2) > 0.2, "{} {}", share(26..=242), share(0..=2));
    }
}
