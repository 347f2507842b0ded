//! What stands in the square: fountain, lamp posts, benches, barrels, crates, a stall, a fire bowl. Each
//! stands at the origin.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3};
use sheer_core::colour::linear_from_hex;

use crate::{
    kit::{foliage::planting, leaf::Cluster, palette::Palette},
    rng::Rng,
    shape::Model,
};

/// Cast iron, almost black.
fn cast_iron() -> Vec3 {
    linear_from_hex(0x24302c)
}

/// A point at a share of a turn around +Y.
fn around(turn: f32, radius: f32, height: f32) -> Vec3 {
    let (sin, cos) = (TAU * turn).sin_cos();
    Vec3::new(radius * cos, height, radius * sin)
}

/// A round basin on two steps, with a column that carries a bowl and an urn.
pub(crate) fn fountain(palette: &Palette) -> Model {
    let mut model = Model::default();
    // Two steps lead up to the basin.
    let steps = model.paint(palette.slabs, Vec3::splat(1.15));
    steps.lathe(Vec3::ZERO, &[(3.75, -0.1), (3.75, 0.15), (3.30, 0.15), (3.30, 0.30), (2.5, 0.30)], 64);
    let stone = model.paint(palette.ashlar, Vec3::new(1.0, 0.97, 0.93));
    // The wall of the basin, then the column that bears the upper bowl, then what crowns it.
    let wall = [
        (2.86, 0.30),
        (2.86, 0.42),
        (2.74, 0.48),
        (2.68, 0.62),
        (2.72, 0.80),
        (2.88, 0.86),
        (2.90, 0.96),
        (2.86, 1.0),
        (2.46, 1.0),
        (2.42, 0.95),
        (2.42, 0.5),
    ];
    stone.lathe(Vec3::ZERO, &wall, 64);
    let column = [
        (0.75, 0.3),
        (0.75, 1.05),
        (0.62, 1.12),
        (0.50, 1.2),
        (0.34, 1.32),
        (0.28, 1.5),
        (0.26, 2.0),
        (0.30, 2.14),
        (0.44, 2.22),
        (0.95, 2.34),
        (1.22, 2.50),
        (1.30, 2.62),
        (1.32, 2.70),
        (1.24, 2.72),
        (1.10, 2.60),
    ];
    stone.lathe(Vec3::ZERO, &column, 40);
    let upper = [
        (0.26, 2.55),
        (0.22, 2.9),
        (0.30, 2.96),
        (0.30, 3.04),
        (0.17, 3.1),
        (0.13, 3.3),
        (0.24, 3.46),
        (0.36, 3.66),
        (0.38, 3.86),
        (0.30, 3.96),
        (0.34, 4.02),
        (0.20, 4.10),
        (0.08, 4.30),
        (0.0, 4.42),
    ];
    stone.lathe(Vec3::ZERO, &upper, 32);
    // Water stands in both bowls.
    let water = model.paint(palette.water, Vec3::ONE);
    water.lathe(Vec3::ZERO, &[(2.43, 0.84), (0.0, 0.84)], 48);
    water.lathe(Vec3::ZERO, &[(1.2, 2.655), (0.0, 2.655)], 32);
    model.shade(|p, n| {
        if n.y < -0.2 {
            0.7
        } else if p.y < 0.5 && n.y < 0.5 {
            0.85
        } else {
            1.0
        }
    });
    model
}

/// A street lamp with a six-sided lantern.
pub(crate) fn lamp_post(palette: &Palette) -> Model {
    let mut model = Model::default();
    let iron = model.paint(palette.iron, cast_iron());
    let post = [
        (0.24, 0.0),
        (0.24, 0.12),
        (0.19, 0.18),
        (0.17, 0.55),
        (0.19, 0.62),
        (0.12, 0.72),
        (0.085, 0.9),
        (0.075, 2.2),
        (0.095, 2.26),
        (0.095, 2.34),
        (0.065, 2.42),
        (0.055, 3.45),
        (0.10, 3.52),
        (0.10, 3.58),
        (0.05, 3.64),
        (0.05, 3.80),
        (0.16, 3.88),
    ];
    iron.lathe(Vec3::ZERO, &post, 16);
    // The lantern widens upwards; bars at its edges, a roof and a knob on it.
    let (low, high) = (3.88, 4.42);
    for side in 0..6 {
        let turn = side as f32 / 6.0;
        iron.tube(&[(around(turn, 0.165, low), 0.013), (around(turn, 0.265, high), 0.013)], 5);
    }
    let roof = [
        (0.27, high - 0.02),
        (0.31, high),
        (0.27, high + 0.03),
        (0.12, high + 0.18),
        (0.10, high + 0.24),
        (0.05, high + 0.27),
        (0.035, high + 0.33),
        (0.0, high + 0.40),
    ];
    iron.lathe(Vec3::ZERO, &roof, 12);
    iron.tube(&[(Vec3::new(-0.32, 3.3, 0.0), 0.018), (Vec3::new(0.32, 3.3, 0.0), 0.018)], 6);
    let glass = model.paint(palette.lantern, Vec3::ONE);
    for side in 0..6 {
        let (a, b) = ((side as f32 + 1.0) / 6.0, side as f32 / 6.0);
        let corners =
            [around(a, 0.155, low), around(b, 0.155, low), around(b, 0.255, high), around(a, 0.255, high)];
        glass.quad(corners);
    }
    model
}

/// A park bench of wooden slats, looking along +Z.
pub(crate) fn bench(palette: &Palette) -> Model {
    let mut model = Model::default();
    let half = 0.88;
    let wood = model.paint(palette.timber, linear_from_hex(0x9a6a3e));
    for slat in 0..4 {
        let z = -0.20 + 0.125 * slat as f32;
        wood.beam(Vec3::new(-half, 0.46, z), Vec3::new(half, 0.46, z), Vec3::Z, 0.10, 0.035);
    }
    for slat in 0..3 {
        let s = slat as f32;
        let at = Vec3::new(0.0, 0.60 + 0.145 * s, -0.285 - 0.045 * s);
        wood.beam(at - Vec3::X * half, at + Vec3::X * half, Vec3::new(0.0, 1.0, -0.3), 0.11, 0.03);
    }
    let iron = model.paint(palette.iron, cast_iron());
    for x in [-0.66, 0.66] {
        let beam =
            |from: (f32, f32), to: (f32, f32)| (Vec3::new(x, from.0, from.1), Vec3::new(x, to.0, to.1));
        for (from, to) in [
            beam((0.0, 0.24), (0.44, 0.19)),
            beam((0.0, -0.30), (0.44, -0.22)),
            beam((0.43, -0.27), (0.43, 0.23)),
            beam((0.43, -0.22), (0.98, -0.41)),
            beam((0.66, -0.28), (0.66, 0.20)),
            beam((0.66, 0.20), (0.43, 0.21)),
        ] {
            iron.beam(from, to, Vec3::X, 0.05, 0.045);
        }
    }
    model
}

/// An oak barrel with iron hoops.
pub(crate) fn barrel(palette: &Palette) -> Model {
    let mut model = Model::default();
    let wood = model.paint(palette.planks, linear_from_hex(0xa87848));
    let staves = [
        (0.27, 0.0),
        (0.315, 0.15),
        (0.34, 0.33),
        (0.345, 0.45),
        (0.34, 0.57),
        (0.315, 0.75),
        (0.27, 0.90),
        (0.24, 0.90),
        (0.24, 0.86),
        (0.0, 0.86),
    ];
    wood.lathe(Vec3::ZERO, &staves, 24);
    let iron = model.paint(palette.iron, Vec3::new(0.09, 0.085, 0.08));
    for (height, radius) in [(0.08, 0.297), (0.27, 0.336), (0.61, 0.338), (0.80, 0.301)] {
        iron.lathe(
            Vec3::ZERO,
            &[(radius, height - 0.025), (radius + 0.008, height), (radius, height + 0.025)],
            24,
        );
    }
    model
}

/// A wooden crate with an edge of `size`, on the ground.
pub(crate) fn crate_box(palette: &Palette, size: f32) -> Model {
    let mut model = Model::default();
    let half = 0.5 * size;
    let wood = model.paint(palette.planks, linear_from_hex(0xb08a58));
    wood.block(Vec3::new(-half, 0.02, -half) * 0.97, Vec3::new(half, 2.0 * half, half) * 0.97);
    let frame = model.paint(palette.timber, linear_from_hex(0xc09a68));
    let (edge, out) = (0.07, 0.02);
    for turn in 0..4 {
        let turned = Affine3A::from_rotation_y(turn as f32 * 0.25 * TAU);
        let mut beam = |from: Vec3, to: Vec3, side: Vec3| {
            let [from, to] = [from, to].map(|p| turned.transform_point3(p));
            frame.beam(from, to, turned.transform_vector3(side), edge, 2.0 * out);
        };
        let (low, high) = (0.5 * edge, size - 0.5 * edge);
        let z = half - 0.5 * out;
        beam(Vec3::new(-half, low, z), Vec3::new(half, low, z), Vec3::Y);
        beam(Vec3::new(-half, high, z), Vec3::new(half, high, z), Vec3::Y);
        beam(Vec3::new(half - 0.5 * edge, edge, z), Vec3::new(half - 0.5 * edge, size - edge, z), Vec3::X);
        beam(Vec3::new(-half + 0.5 * edge, edge, z), Vec3::new(-half + 0.5 * edge, size - edge, z), Vec3::X);
    }
    model
}

/// A stone trough with a clipped bush.
pub(crate) fn planter(palette: &Palette, rng: &mut Rng) -> Model {
    let mut model = Model::default();
    let stone = model.paint(palette.ashlar, Vec3::splat(0.9));
    let profile = [
        (0.34, 0.0),
        (0.36, 0.06),
        (0.40, 0.10),
        (0.48, 0.50),
        (0.54, 0.54),
        (0.54, 0.62),
        (0.46, 0.62),
        (0.44, 0.54),
    ];
    stone.lathe(Vec3::ZERO, &profile, 20);
    model.paint(palette.bark, Vec3::splat(0.4)).lathe(Vec3::ZERO, &[(0.45, 0.56), (0.0, 0.56)], 20);
    for layer in 0..5 {
        let (radius, height) = (0.48 - 0.06 * (layer as f32 - 1.2).abs(), 0.62 + 0.17 * layer as f32);
        let reach = Vec3::new(radius, 0.16, radius);
        let bed = (Vec3::Y * height - reach, Vec3::Y * (height + 0.16) + reach);
        planting(&mut model, palette, rng, Cluster::Hedge, bed, 44);
    }
    model
}

/// A market stall under a striped roof, looking along +Z.
pub(crate) fn stall(palette: &Palette, rng: &mut Rng) -> Model {
    let mut model = Model::default();
    let (half, deep) = (1.35, 0.75);
    let wood = model.paint(palette.timber, linear_from_hex(0x8a623c));
    for x in [-half, half] {
        wood.beam(Vec3::new(x, 0.0, deep), Vec3::new(x, 2.15, deep), Vec3::X, 0.08, 0.08);
        wood.beam(Vec3::new(x, 0.0, -deep), Vec3::new(x, 2.55, -deep), Vec3::X, 0.08, 0.08);
    }
    for (y, z) in [(2.15, deep), (2.55, -deep)] {
        wood.beam(Vec3::new(-half - 0.2, y, z), Vec3::new(half + 0.2, y, z), Vec3::Y, 0.07, 0.07);
    }
    let boards = model.paint(palette.planks, linear_from_hex(0x9a7448));
    boards.block(Vec3::new(-half - 0.05, 0.86, -0.35), Vec3::new(half + 0.05, 0.92, deep + 0.1));
    boards.block(Vec3::new(-half, 0.25, deep - 0.06), Vec3::new(half, 0.86, deep - 0.02));
    let cloth = model.paint(palette.awning, Vec3::ONE);
    let (front, back) =
        (Vec3::new(-half - 0.25, 2.06, deep + 0.35), Vec3::new(-half - 0.25, 2.66, -deep - 0.1));
    let run = Vec3::X * (2.0 * half + 0.5);
    cloth.panel(front, run, back - front);
    cloth.panel(front - Vec3::Y * 0.22, run, Vec3::Y * 0.22);
    // Fruit in shallow boxes: little heaps of balls.
    let fruits = [0xc8641e, 0xa02418, 0xb8a02a, 0x5c7a24].map(linear_from_hex);
    for (index, colour) in fruits.into_iter().enumerate() {
        let x = -half + 0.36 + 0.66 * index as f32;
        let tray = model.paint(palette.planks, linear_from_hex(0xc8a878));
        tray.block(Vec3::new(x - 0.28, 0.92, -0.1), Vec3::new(x + 0.28, 0.98, 0.62));
        for row in 0..4 {
            for column in 0..4 {
                let at = Vec3::new(
                    x - 0.20 + 0.133 * column as f32 + rng.about(0.0, 0.015),
                    1.02 + rng.about(0.02, 0.02),
                    0.02 + 0.16 * row as f32 + rng.about(0.0, 0.015),
                );
                let r = rng.between(0.062, 0.072);
                let ball = [(0.0, -r), (0.7 * r, -0.7 * r), (r, 0.0), (0.7 * r, 0.7 * r), (0.0, r)];
                model.paint(palette.iron, colour * rng.between(0.7, 1.2)).lathe(at, &ball, 8);
            }
        }
    }
    model
}

/// A café table with two chairs under a parasol.
pub(crate) fn cafe_table(palette: &Palette, rng: &mut Rng, cloth: Vec3) -> Model {
    let mut model = Model::default();
    let iron = model.paint(palette.iron, cast_iron());
    iron.lathe(Vec3::ZERO, &[(0.26, 0.0), (0.24, 0.03), (0.03, 0.07), (0.025, 0.70), (0.025, 2.45)], 12);
    model.paint(palette.planks, linear_from_hex(0xb08860)).lathe(
        Vec3::ZERO,
        &[(0.0, 0.70), (0.42, 0.70), (0.43, 0.715), (0.42, 0.73), (0.0, 0.73)],
        24,
    );
    // Eight gores, each a flat sail that falls from the pole.
    let sail = model.paint(palette.iron, cloth);
    for gore in 0..8 {
        let (a, b) = (gore as f32 / 8.0, (gore as f32 + 1.0) / 8.0);
        let (outer_a, outer_b) = (around(a, 1.25, 2.02), around(b, 1.25, 2.02));
        let top = Vec3::Y * 2.46;
        let drop = Vec3::Y * 0.14;
        sail.triangle([outer_b, outer_a, top]);
        sail.triangle([outer_a, outer_b, top - Vec3::Y * 0.02]);
        sail.quad([outer_b - drop, outer_a - drop, outer_a, outer_b]);
        sail.quad([outer_a - drop, outer_b - drop, outer_b, outer_a]);
    }
    for side in [0.0, 0.5] {
        let turn = side + rng.about(0.1, 0.06);
        let place = Affine3A::from_rotation_translation(
            Quat::from_rotation_y(-TAU * turn - 0.25 * TAU),
            around(turn, 0.72, 0.0),
        );
        model.append(&chair(palette), place);
    }
    model
}

/// A folding chair, looking along +Z.
fn chair(palette: &Palette) -> Model {
    let mut model = Model::default();
    let iron = model.paint(palette.iron, cast_iron());
    for x in [-0.19, 0.19] {
        iron.beam(Vec3::new(x, 0.0, 0.19), Vec3::new(x, 0.84, -0.24), Vec3::X, 0.025, 0.018);
        iron.beam(Vec3::new(x * 0.86, 0.0, -0.22), Vec3::new(x * 0.86, 0.45, 0.18), Vec3::X, 0.025, 0.018);
    }
    let wood = model.paint(palette.timber, linear_from_hex(0xa87a4a));
    for slat in 0..5 {
        let z = -0.13 + 0.075 * slat as f32;
        wood.beam(Vec3::new(-0.2, 0.455, z), Vec3::new(0.2, 0.455, z), Vec3::Z, 0.058, 0.018);
    }
    for y in [0.66, 0.78] {
        let z = 0.19 - 0.43 * y / 0.84 + 0.02;
        wood.beam(Vec3::new(-0.2, y, z), Vec3::new(0.2, y, z), Vec3::Y, 0.07, 0.018);
    }
    model
}

/// An iron fire bowl on a stone foot, with logs and embers.
pub(crate) fn fire_bowl(palette: &Palette, rng: &mut Rng) -> Model {
    let mut model = Model::default();
    let iron = model.paint(palette.iron, Vec3::new(0.06, 0.055, 0.05));
    let bowl = [
        (0.0, 0.42),
        (0.25, 0.45),
        (0.45, 0.55),
        (0.58, 0.70),
        (0.62, 0.84),
        (0.65, 0.86),
        (0.62, 0.88),
        (0.58, 0.84),
        (0.52, 0.70),
        (0.35, 0.58),
    ];
    iron.lathe(Vec3::ZERO, &bowl, 32);
    let foot = model.paint(palette.ashlar, Vec3::splat(0.75));
    let profile = [
        (0.46, 0.0),
        (0.46, 0.10),
        (0.40, 0.14),
        (0.22, 0.20),
        (0.15, 0.28),
        (0.14, 0.34),
        (0.20, 0.38),
        (0.20, 0.43),
        (0.12, 0.44),
    ];
    foot.lathe(Vec3::ZERO, &profile, 28);
    model.paint(palette.embers, Vec3::ONE).lathe(Vec3::ZERO, &[(0.56, 0.76), (0.25, 0.80), (0.0, 0.82)], 24);
    for log in 0..6 {
        let turn = log as f32 / 6.0 + rng.about(0.0, 0.05);
        let (low, high) = (around(turn, 0.46, 0.80), around(turn + 0.5, 0.10, 1.06 + rng.about(0.0, 0.08)));
        let radius = rng.between(0.045, 0.065);
        let bark = model.paint(palette.bark, Vec3::splat(0.22));
        bark.shift_uv(Vec2::new(rng.unit(), rng.unit()));
        bark.tube(&[(low, radius), (low.lerp(high, 0.5), radius * 1.05), (high, radius * 0.9)], 9);
    }
    model
}
