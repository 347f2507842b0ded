//! The ground of the arena: a ring of stone under an evening sky, pillars with banners, terraces, braziers
//! and hills.
//!
//! The sun has nearly set behind the figures (-Z), so that everything stands against the light.

use std::f32::consts::TAU;

use glam::{Affine3A, IVec2, Quat, Vec2, Vec3};
use sheer_scene::{
    environment::{Environment, Lobe},
    model::{AlphaMode, Material, TextureRef},
};

use super::paint;
use crate::{
    builder::SceneBuilder,
    kit::{furniture, palette::Palette},
    paint::{Noise, smoothstep},
    rng::Rng,
    shape::{Model, Shape, Vertex},
};

/// The fighting floor, up to its kerb.
pub(super) const FLOOR_RADIUS: f32 = 10.0;
/// Pillars stand on this circle, around the floor.
const PILLAR_RADIUS: f32 = 11.8;
const PILLAR_COUNT: u32 = 14;
const PILLAR_HEIGHT: f32 = 5.4;
/// The wall at the foot of the terraces, and the outer edge of all.
const WALL_RADIUS: f32 = 14.2;
pub(super) const ARENA_RADIUS: f32 = 21.0;
/// Directions of the braziers, as shares of a turn from +Z to +X; they stand just within the kerb.
const BRAZIER_TURNS: [f32; 6] = [0.14, 0.30, 0.43, 0.525, 0.70, 0.86];
const BRAZIER_RADIUS: f32 = 9.1;
/// Direction in which the sun sets, as a share of a turn: seen between two pillars from where the still
/// camera stands, and through the gate, so that its light reaches the floor.
const SUN_TURN: f32 = 0.542;
const GATE_TURN: f32 = 0.545;
/// The hills open to a valley there, within this share of a turn.
const VALLEY_TURN: f32 = 0.07;
const BRAZIER_SCALE: f32 = 1.25;

fn towards_sun() -> Vec3 {
    around(SUN_TURN, 1.0, 0.27).normalize()
}

/// Deep blue above, embers at the horizon where the sun goes down, and a cool glow opposite.
pub(super) fn dusk() -> Environment {
    let low_sun = around(SUN_TURN, 1.0, 0.105).normalize();
    let lobe = |direction: Vec3, radiance: Vec3, sharpness: f32| Lobe { direction, radiance, sharpness };
    Environment {
        zenith: Vec3::new(0.022, 0.050, 0.150),
        horizon: Vec3::new(0.135, 0.10, 0.16),
        ground: Vec3::new(0.040, 0.036, 0.045),
        lobes: vec![
            lobe(low_sun, Vec3::new(0.42, 0.125, 0.06), 5.0),
            lobe(low_sun, Vec3::new(0.62, 0.23, 0.05), 22.0),
            lobe(low_sun, Vec3::new(1.3, 0.66, 0.20), 200.0),
            lobe(low_sun, Vec3::new(7.0, 4.4, 1.9), 2600.0),
            lobe(Vec3::new(0.5, 0.55, 0.67).normalize(), Vec3::new(0.085, 0.13, 0.24), 2.5),
        ],
        ..Environment::black()
    }
}

/// A point at a share of a turn from +Z to +X.
pub(super) fn around(turn: f32, radius: f32, height: f32) -> Vec3 {
    let (sin, cos) = (TAU * turn).sin_cos();
    Vec3::new(radius * sin, height, radius * cos)
}

/// Points at which the fires of the braziers burn.
pub(super) fn braziers() -> [Vec3; 6] {
    BRAZIER_TURNS.map(|turn| around(turn, BRAZIER_RADIUS, 0.86 * BRAZIER_SCALE))
}

/// Builds everything that is opaque or cut out and stands still.
pub(super) fn raise(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    builder.sun(towards_sun(), Vec3::new(3.6, 2.05, 1.05));
    put_floor(builder, palette, seed);
    put_terraces(builder, palette, seed);
    put_pillars(builder, palette, seed);
    put_braziers(builder, palette, seed);
    put_hills(builder, palette, seed);
}

fn put_floor(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let stains = Noise { seed: seed.wrapping_add(600) }.fractal(IVec2::splat(9), 4);
    let mut floor = Model::default();
    let cell = 0.5;
    let cells = (WALL_RADIUS / cell) as i32 + 2;
    for row in -cells..cells {
        for column in -cells..cells {
            let corner = Vec3::new(column as f32, 0.0, row as f32) * cell;
            let radius = (corner + Vec3::new(0.5, 0.0, 0.5) * cell).length();
            // Slabs to fight on; sand lies around the ring, a step lower.
            let (material, tint, drop) = if radius < FLOOR_RADIUS + 0.3 {
                (palette.slabs, Vec3::new(1.0, 0.95, 0.92), 0.0)
            } else {
                (palette.plaster, Vec3::new(0.36, 0.29, 0.22), 0.22)
            };
            let corner = corner - Vec3::Y * drop;
            if radius < WALL_RADIUS + cell {
                floor.paint(material, tint).panel(corner + Vec3::Z * cell, Vec3::X * cell, -Vec3::Z * cell);
            }
        }
    }
    let kerb = [
        (FLOOR_RADIUS + 0.75, -0.25),
        (FLOOR_RADIUS + 0.72, 0.10),
        (FLOOR_RADIUS + 0.62, 0.17),
        (FLOOR_RADIUS, 0.17),
        (FLOOR_RADIUS - 0.06, 0.0),
    ];
    floor.paint(palette.ashlar, Vec3::new(0.78, 0.72, 0.70)).lathe(Vec3::ZERO, &kerb, 128);
    // Inlays: bands of dark stone, and brass between them.
    let band = |model: &mut Model, material, tint, from: f32, to: f32, lift: f32| {
        model.paint(material, tint).lathe(Vec3::ZERO, &[(to, lift), (from, lift)], 128);
    };
    for (from, to) in [(7.6, 8.2), (2.6, 2.9)] {
        band(&mut floor, palette.plaster, Vec3::new(0.13, 0.11, 0.13), from, to, 0.004);
    }
    for (from, to) in [(7.56, 7.64), (8.16, 8.24), (2.87, 2.93), (2.57, 2.63), (5.2, 5.26)] {
        band(&mut floor, palette.metal, Vec3::new(0.62, 0.42, 0.18), from, to, 0.006);
    }
    let brass = floor.paint(palette.metal, Vec3::new(0.62, 0.42, 0.18));
    for ray in 0..16 {
        let turn = ray as f32 / 16.0;
        let (from, to) = (around(turn, 2.9, 0.005), around(turn, 7.6, 0.005));
        let side = around(turn + 0.25, 0.025, 0.0);
        brass.quad([from - side, from + side, to + side, to - side]);
    }
    // Broad stains, soot around the middle, and shade at the foot of the wall.
    floor.shade(|p, _| {
        let stain = stains.at(Vec2::new(p.x, p.z) / 40.0 + 0.5);
        let radius = Vec2::new(p.x, p.z).length();
        (0.84 + 0.30 * stain) * (0.6 + 0.4 * smoothstep(0.0, 2.4, WALL_RADIUS - radius))
    });
    builder.put("floor", floor);
}

/// A block between two turns and two radii, without its underside.
fn arc_block(shape: &mut Shape, turns: [f32; 2], radii: [f32; 2], heights: [f32; 2]) {
    let p = |turn: usize, radius: usize, height: usize| around(turns[turn], radii[radius], heights[height]);
    shape.quad([p(1, 0, 0), p(0, 0, 0), p(0, 0, 1), p(1, 0, 1)]);
    shape.quad([p(0, 1, 0), p(1, 1, 0), p(1, 1, 1), p(0, 1, 1)]);
    shape.quad([p(1, 0, 1), p(0, 0, 1), p(0, 1, 1), p(1, 1, 1)]);
    shape.quad([p(0, 0, 0), p(0, 1, 0), p(0, 1, 1), p(0, 0, 1)]);
    shape.quad([p(1, 1, 0), p(1, 0, 0), p(1, 0, 1), p(1, 1, 1)]);
}

/// Five steps of stone for those who watch, open where the sun stands.
fn put_terraces(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let mut rng = Rng::new(seed, "terraces");
    let mut terraces = Model::default();
    let count = 60;
    for index in 0..count {
        let turns = [index as f32 / count as f32, (index as f32 + 1.0) / count as f32];
        let middle = 0.5 * (turns[0] + turns[1]);
        let from_gate = (middle - GATE_TURN).abs();
        if from_gate < 0.046 {
            continue;
        }
        let rows = if from_gate < 0.064 { 2 } else { 5 };
        for row in 0..rows {
            let near = WALL_RADIUS + 1.36 * row as f32;
            let high = 1.35 + 0.62 * row as f32 + rng.about(0.0, 0.012);
            let tint = Vec3::new(0.66, 0.60, 0.60) * rng.about(1.0, 0.1);
            let stone = terraces.paint(palette.ashlar, tint);
            stone.shift_uv(Vec2::new(rng.unit(), 0.0));
            arc_block(stone, turns, [near, near + 1.44], [-0.3, high]);
        }
        if rows == 5 {
            // A parapet with merlons behind the last row.
            let high = if index % 2 == 0 { 5.3 } else { 4.7 };
            let stone = terraces.paint(palette.ashlar, Vec3::new(0.56, 0.51, 0.52));
            arc_block(stone, turns, [ARENA_RADIUS - 0.5, ARENA_RADIUS], [0.0, high]);
        }
    }
    builder.put("terraces", terraces);
    // Two towers guard the gate.
    for turn in [GATE_TURN - 0.06, GATE_TURN + 0.06] {
        let mut tower = Model::default();
        let profile = [
            (1.75, -0.3),
            (1.75, 0.5),
            (1.5, 0.7),
            (1.42, 5.6),
            (1.7, 5.9),
            (1.75, 6.5),
            (1.45, 6.52),
            (1.4, 6.3),
            (0.0, 6.3),
        ];
        tower.paint(palette.ashlar, Vec3::new(0.62, 0.56, 0.56)).lathe(Vec3::ZERO, &profile, 28);
        for merlon in 0..8 {
            let at = merlon as f32 / 8.0;
            let stone = tower.paint(palette.ashlar, Vec3::new(0.6, 0.54, 0.54));
            arc_block(stone, [at, at + 0.07], [1.4, 1.75], [6.5, 7.05]);
        }
        builder.put_at(
            "gate tower",
            tower,
            Affine3A::from_translation(around(turn, 0.5 * (WALL_RADIUS + ARENA_RADIUS), 0.0)),
        );
    }
}

/// How much of a pillar still stands.
fn pillar_height(index: u32) -> f32 {
    match index {
        // Those in front of the cameras, and a few that time has broken.
        0 | 13 => 0.0,
        3 => 3.1,
        5 => 4.1,
        9 => 2.2,
        _ => PILLAR_HEIGHT,
    }
}

fn pillar(palette: &Palette, height: f32, rng: &mut Rng) -> Model {
    let mut model = Model::default();
    let stone = model.paint(palette.ashlar, Vec3::new(0.80, 0.73, 0.70));
    stone.block(Vec3::new(-0.72, -0.3, -0.72), Vec3::new(0.72, 0.42, 0.72));
    stone.lathe(Vec3::ZERO, &[(0.66, 0.42), (0.68, 0.55), (0.60, 0.66), (0.52, 0.74)], 24);
    let shaft: Vec<(f32, f32)> = (0..=8)
        .map(|step| (0.52 - 0.06 * step as f32 / 8.0, 0.74 + (height - 1.4) * step as f32 / 8.0))
        .collect();
    let whole = height >= PILLAR_HEIGHT;
    // Fluted: the shaft is a cylinder of twelve staves.
    for stave in 0..12 {
        let turn = stave as f32 / 12.0;
        let cut = if whole { 0.0 } else { rng.between(-0.45, 0.35) };
        let shape = model.paint(palette.ashlar, Vec3::new(0.80, 0.73, 0.70));
        for pair in shaft.windows(2) {
            let top = if pair[1].1 >= shaft[8].1 { cut } else { 0.0 };
            let p = |turn: f32, (radius, height): (f32, f32), inset: f32, lift: f32| {
                around(turn, radius - inset, height + lift)
            };
            let (a, b, c) = (turn, turn + 1.0 / 24.0, turn + 1.0 / 12.0);
            shape.quad([
                p(a, pair[0], 0.05, 0.0),
                p(b, pair[0], 0.0, 0.0),
                p(b, pair[1], 0.0, top),
                p(a, pair[1], 0.05, top),
            ]);
            shape.quad([
                p(b, pair[0], 0.0, 0.0),
                p(c, pair[0], 0.05, 0.0),
                p(c, pair[1], 0.05, top),
                p(b, pair[1], 0.0, top),
            ]);
        }
        let (edge, tip) = (shaft[8].0, shaft[8].1 + cut);
        shape.triangle([
            around(turn, edge, tip),
            around(turn + 1.0 / 12.0, edge, tip),
            Vec3::Y * (shaft[8].1 - 0.1),
        ]);
    }
    if whole {
        let top = height - 0.66;
        let stone = model.paint(palette.ashlar, Vec3::new(0.80, 0.73, 0.70));
        stone.lathe(Vec3::Y * top, &[(0.46, 0.0), (0.54, 0.06), (0.50, 0.12), (0.68, 0.34)], 24);
        stone.block(Vec3::new(-0.74, top + 0.34, -0.74), Vec3::new(0.74, top + 0.66, 0.74));
    }
    model
}

fn put_pillars(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let mut rng = Rng::new(seed, "pillars");
    let texture = builder.texture("banner", move || paint::banner(seed));
    let cloth = builder.material(Material {
        name: "banner".to_owned(),
        base_colour_texture: Some(TextureRef::new(texture)),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        roughness: 0.9,
        double_sided: true,
        ..Material::default()
    });
    let turn_of = |index: u32| (index as f32 + 0.5) / PILLAR_COUNT as f32;
    for index in 0..PILLAR_COUNT {
        let height = pillar_height(index);
        if height == 0.0 {
            continue;
        }
        let place = Affine3A::from_rotation_translation(
            Quat::from_rotation_y(TAU * turn_of(index)),
            around(turn_of(index), PILLAR_RADIUS, 0.0),
        );
        builder.put_at("pillar", pillar(palette, height, &mut rng), place);
        if height < PILLAR_HEIGHT {
            builder.put_at("rubble", rubble(palette, &mut rng), place);
            continue;
        }
        // The heroes' hang on the left, the raiders' on the right.
        let left = turn_of(index) > 0.5;
        let tint = if left { Vec3::new(0.10, 0.20, 0.62) } else { Vec3::new(0.62, 0.055, 0.04) };
        let mut banner = Model::default();
        hang_banner(banner.paint(cloth, tint), rng.about(0.0, 0.6));
        let iron = banner.paint(palette.iron, Vec3::splat(0.05));
        iron.tube(&[(Vec3::new(-0.62, 4.34, -0.66), 0.03), (Vec3::new(0.62, 4.34, -0.66), 0.03)], 6);
        builder.put_at("banner", banner, place);
        // A beam of stone joins two pillars that are whole.
        let next = index + 1;
        if next < PILLAR_COUNT && pillar_height(next) >= PILLAR_HEIGHT {
            let mut beam = Model::default();
            let stone = beam.paint(palette.ashlar, Vec3::new(0.74, 0.68, 0.66));
            let steps = 4;
            for step in 0..steps {
                let turn = |step: u32| turn_of(index) + step as f32 / (steps * PILLAR_COUNT) as f32;
                let turns = [turn(step), turn(step + 1)];
                arc_block(stone, turns, [PILLAR_RADIUS - 0.6, PILLAR_RADIUS + 0.6], [5.4, 5.95]);
                arc_block(stone, turns, [PILLAR_RADIUS - 0.75, PILLAR_RADIUS + 0.75], [5.95, 6.15]);
            }
            builder.put("architrave", beam);
        }
    }
}

/// A banner on the side of a pillar that looks to the middle of the arena.
fn hang_banner(shape: &mut Shape, sway: f32) {
    let (columns, rows) = (6, 14);
    let (width, length) = (1.05, 2.75);
    let first = shape.positions.len() as u32;
    for row in 0..=rows {
        let down = row as f32 / rows as f32;
        for column in 0..=columns {
            let across = column as f32 / columns as f32 - 0.5;
            let wave = 0.10 * down * (6.0 * down + 5.0 * across + sway).sin();
            let slope = 0.5 * down * (6.0 * down + 5.0 * across + sway).cos() / width;
            shape.vertex(Vertex {
                position: Vec3::new(-across * width, 4.34 - length * down, -0.68 - wave),
                normal: Vec3::new(-slope, 0.0, -1.0).normalize(),
                uv: Vec2::new(across + 0.5, down),
            });
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let at = first + row * (columns + 1) + column;
            let below = at + columns + 1;
            shape.indices.extend([[at, below, below + 1], [at, below + 1, at + 1]]);
        }
    }
}

/// What fell off a broken pillar.
fn rubble(palette: &Palette, rng: &mut Rng) -> Model {
    let mut model = Model::default();
    for _ in 0..9 {
        let size = Vec3::new(rng.between(0.15, 0.5), rng.between(0.12, 0.35), rng.between(0.15, 0.45));
        let mut stone = Model::default();
        stone
            .paint(palette.ashlar, Vec3::new(0.78, 0.71, 0.68) * rng.about(1.0, 0.12))
            .block(-0.5 * size, 0.5 * size);
        let away = Vec2::from_angle(rng.between(0.0, TAU)) * rng.between(0.85, 1.7);
        // Beside the floor, which is a step lower there.
        let turned =
            Quat::from_rotation_y(rng.between(0.0, TAU)) * Quat::from_rotation_z(rng.about(0.0, 0.3));
        let at = Vec3::new(away.x, 0.42 * size.y - 0.22, away.y.abs());
        model.append(&stone, Affine3A::from_rotation_translation(turned, at));
    }
    model
}

fn put_braziers(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let mut rng = Rng::new(seed, "braziers");
    let bowl = builder.prop("brazier", furniture::fire_bowl(palette, &mut rng));
    for fire in braziers() {
        let place = Affine3A::from_scale_rotation_translation(
            Vec3::splat(BRAZIER_SCALE),
            Quat::from_rotation_y(rng.between(0.0, TAU)),
            fire.with_y(0.0),
        );
        builder.place(&bowl, place);
        // The lamp hangs above the flames, which would swallow its light.
        builder.lamp("brazier", fire + Vec3::Y * 0.75, Vec3::new(15.0, 6.0, 1.6), 7.5);
    }
}

/// Ridges around the valley, bluer with distance.
fn put_hills(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let noise = Noise { seed: seed.wrapping_add(610) };
    let mut hills = Model::default();
    let land = hills.paint(palette.plaster, Vec3::new(0.05, 0.045, 0.05));
    land.lathe(Vec3::Y * -0.35, &[(160.0, 0.0), (ARENA_RADIUS - 8.0, 0.0)], 48);
    let count = 180;
    for (ridge, (radius, height, tint)) in [
        (70.0, 7.0, Vec3::new(0.10, 0.085, 0.11)),
        (110.0, 19.0, Vec3::new(0.17, 0.14, 0.21)),
        (150.0, 36.0, Vec3::new(0.26, 0.21, 0.33)),
    ]
    .into_iter()
    .enumerate()
    {
        let relief = noise.fractal(IVec2::new(9 + 4 * ridge as i32, 5), 5);
        let top = |index: u32| {
            let turn = (index % count) as f32 / count as f32;
            let relief = relief.at(Vec2::new(turn, 0.29 * ridge as f32 + 0.1));
            let open = smoothstep(0.1 * VALLEY_TURN, VALLEY_TURN, (turn - SUN_TURN).abs());
            around(turn, radius, height * (0.75 + 0.8 * relief).max(0.15) * (0.22 + 0.78 * open))
        };
        let shape = hills.paint(palette.plaster, tint);
        for index in 0..count {
            let (a, b) = (top(index), top(index + 1));
            shape.quad([b.with_y(-1.0), a.with_y(-1.0), a, b]);
        }
    }
    builder.put("hills", hills);
}
