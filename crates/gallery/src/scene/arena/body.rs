//! What the figures of the arena are made of: knights, mages, raiders and a golem, each part in the space of
//! its joint.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};
use sheer_core::colour::linear_from_hex;
use sheer_scene::model::Material;

use super::figure::{Body, Build};
use crate::{
    builder::SceneBuilder,
    kit::palette::Palette,
    rng::Rng,
    shape::{Model, Shape, Vertex},
};

/// Materials of the figures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wardrobe {
    /// Polished steel; the vertices give its colour.
    steel: u32,
    cloth: u32,
    wood: u32,
    /// Rough rock of the golem.
    stone: u32,
    /// What glows in its cracks.
    lava: u32,
    /// Crystals and eyes, by team.
    glow: [u32; 2],
}

/// Heroes wear blue and gold, raiders black and red.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Team {
    Heroes,
    Raiders,
}

impl Wardrobe {
    pub(super) fn new(builder: &mut SceneBuilder, palette: &Palette) -> Self {
        let plain = |name: &str, roughness: f32, metallic: f32, emissive: Vec3| Material {
            name: name.to_owned(),
            roughness,
            metallic,
            emissive,
            double_sided: true,
            ..Material::default()
        };
        Self {
            steel: builder.material(plain("steel", 0.34, 0.9, Vec3::ZERO)),
            cloth: builder.material(plain("cloth", 0.85, 0.0, Vec3::ZERO)),
            wood: palette.timber,
            stone: palette.plaster,
            lava: builder.material(plain("lava", 0.6, 0.0, Vec3::new(1.25, 0.19, 0.015))),
            glow: [Vec3::new(0.7, 1.9, 3.0), Vec3::new(1.8, 0.08, 0.03)]
                .map(|emissive| builder.material(plain("glow", 0.3, 0.0, emissive))),
        }
    }

    fn glow(&self, team: Team) -> u32 {
        self.glow[team as usize]
    }
}

/// A grown person of heroic proportions, 1.85 m tall.
const PERSON: Build = Build {
    thigh: 0.44,
    shin: 0.46,
    toe: 0.19,
    heel: 0.07,
    hip: 0.11,
    shoulder: 0.26,
    shoulder_height: 0.47,
    neck: 0.56,
    stoop: 0.0,
    upper_arm: 0.29,
};
const FOREARM: f32 = 0.27;

/// Adds an ellipsoid whose axes are those of the shape.
fn ball(shape: &mut Shape, centre: Vec3, radii: Vec3) {
    let mut unit = shape.like();
    let profile: Vec<(f32, f32)> = (0..=7)
        .map(|step| {
            let (sin, cos) = (PI * step as f32 / 7.0).sin_cos();
            // Exactly zero at the poles: the sine of π is not.
            (if step % 7 == 0 { 0.0 } else { sin }, -cos)
        })
        .collect();
    unit.lathe(Vec3::ZERO, &profile, 12);
    shape.append(&unit, Affine3A::from_scale_rotation_translation(radii, Quat::IDENTITY, centre));
}

/// A tapered limb that hangs down from its joint.
fn sleeve(shape: &mut Shape, length: f32, top: f32, bottom: f32) {
    let profile = [
        (0.0, -length - 0.5 * bottom),
        (0.8 * bottom, -length - 0.3 * bottom),
        (bottom, -length),
        (0.55 * (top + bottom), -0.55 * length),
        (top, -0.1 * length),
        (0.85 * top, 0.45 * top),
        (0.0, 0.8 * top),
    ];
    shape.lathe(Vec3::ZERO, &profile, 10);
}

/// A four-sided spike from a square base of edge `width` to a tip.
fn spike(shape: &mut Shape, base: Vec3, tip: Vec3, width: f32) {
    let side = (tip - base).any_orthogonal_vector().normalize() * (0.71 * width);
    let other = side.cross((tip - base).normalize());
    let corners = [base + side, base + other, base - side, base - other];
    for index in 0..4 {
        let (a, b) = (corners[index], corners[(index + 1) % 4]);
        let outwards = (b - a).cross(tip - a).dot(0.5 * (a + b) - base) > 0.0;
        shape.triangle(if outwards { [a, b, tip] } else { [b, a, tip] });
    }
}

/// Which way a blade or a staff points in the space of the forearm: upwards and forwards once the elbow is
/// bent.
const GRIP: Vec3 = Vec3::new(0.0, -0.45, 0.893);

/// A cape in the space of the chest, painted on both sides.
fn cape(model: &mut Model, wardrobe: &Wardrobe, tint: Vec3, length: f32) {
    let shape = model.paint(wardrobe.cloth, tint);
    let (columns, rows) = (8, 12);
    let first = shape.positions.len() as u32;
    for row in 0..=rows {
        let down = row as f32 / rows as f32;
        for column in 0..=columns {
            let across = column as f32 / columns as f32 * 2.0 - 1.0;
            let width = 0.23 + 0.20 * down;
            // Folds deepen towards the hem.
            let fold = 0.05 * down * (across * 9.0).sin() - 0.05 * across * across;
            let slope = 0.45 * down * (across * 9.0).cos() / width - 0.1 * across / width;
            shape.vertex(Vertex {
                position: Vec3::new(
                    across * width,
                    PERSON.shoulder_height + 0.03 - length * down,
                    -0.15 - fold,
                ),
                normal: Vec3::new(-slope, 0.0, -1.0).normalize(),
                uv: Vec2::new(across * width, down * length),
            });
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let at = first + row * (columns + 1) + column;
            let below = at + columns + 1;
            shape.indices.extend([[at, at + 1, below + 1], [at, below + 1, below]]);
        }
    }
}

fn leg(wardrobe: &Wardrobe, tint: Vec3) -> [Model; 2] {
    let [mut thigh, mut shin] = [Model::default(), Model::default()];
    sleeve(thigh.paint(wardrobe.cloth, Vec3::splat(0.05)), PERSON.thigh, 0.105, 0.075);
    let steel = shin.paint(wardrobe.steel, tint);
    ball(steel, Vec3::new(0.0, 0.0, 0.03), Vec3::new(0.085, 0.09, 0.085));
    sleeve(steel, PERSON.shin - 0.08, 0.085, 0.06);
    ball(steel, Vec3::new(0.0, 0.055 - PERSON.shin, 0.06), Vec3::new(0.07, 0.055, 0.14));
    [thigh, shin]
}

fn arm(wardrobe: &Wardrobe, tint: Vec3) -> [Model; 2] {
    let [mut upper, mut fore] = [Model::default(), Model::default()];
    let steel = upper.paint(wardrobe.steel, tint);
    sleeve(steel, PERSON.upper_arm, 0.075, 0.06);
    ball(steel, Vec3::new(0.0, 0.02, 0.0), Vec3::new(0.135, 0.10, 0.14));
    ball(steel, Vec3::new(0.0, -0.07, 0.0), Vec3::new(0.115, 0.07, 0.12));
    let steel = fore.paint(wardrobe.steel, tint);
    sleeve(steel, FOREARM, 0.068, 0.058);
    ball(steel, Vec3::Y * -FOREARM, Vec3::new(0.06, 0.07, 0.06));
    [upper, fore]
}

/// Hips, chest and head of somebody in plate.
fn armour(wardrobe: &Wardrobe, steel_tint: Vec3, cloth_tint: Vec3) -> [Model; 3] {
    let [mut hips, mut chest, mut head] = [Model::default(), Model::default(), Model::default()];
    hips.paint(wardrobe.cloth, cloth_tint).lathe(
        Vec3::ZERO,
        &[(0.27, -0.42), (0.22, -0.15), (0.165, 0.06)],
        14,
    );
    ball(hips.paint(wardrobe.steel, steel_tint), Vec3::Y * 0.02, Vec3::new(0.185, 0.10, 0.15));
    let mut plate = Model::default();
    let breast = [
        (0.13, 0.0),
        (0.165, 0.10),
        (0.225, 0.27),
        (0.235, 0.36),
        (0.20, 0.47),
        (0.11, 0.54),
        (0.085, 0.58),
        (0.0, 0.58),
    ];
    plate.paint(wardrobe.steel, steel_tint).lathe(Vec3::ZERO, &breast, 16);
    chest.append(&plate, Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.78)));
    let tabard = chest.paint(wardrobe.cloth, cloth_tint);
    tabard.box_of(Vec3::new(-0.075, 0.02, 0.13), Vec3::X * 0.15, Vec3::new(0.0, 0.42, 0.035), Vec3::Z * 0.03);
    let helmet = [
        (0.085, -0.04),
        (0.085, 0.03),
        (0.125, 0.05),
        (0.138, 0.15),
        (0.13, 0.23),
        (0.09, 0.30),
        (0.0, 0.33),
    ];
    head.paint(wardrobe.steel, steel_tint).lathe(Vec3::ZERO, &helmet, 14);
    head.paint(wardrobe.cloth, Vec3::splat(0.01))
        .block(Vec3::new(-0.09, 0.145, 0.06), Vec3::new(0.09, 0.175, 0.138));
    [hips, chest, head]
}

/// Somebody in bright plate with a sword, a shield, a crest and a cape.
pub(super) fn knight(wardrobe: &Wardrobe, tint: Vec3) -> Body {
    let steel = linear_from_hex(0xc9ccd4);
    let [hips, chest, mut head] = armour(wardrobe, steel, tint);
    let crest = head.paint(wardrobe.cloth, tint * 1.3);
    for step in 0..7 {
        let turn = 0.32 * step as f32 - 0.35;
        let (sin, cos) = turn.sin_cos();
        let root = Vec3::new(0.0, 0.16 + 0.15 * cos, -0.13 * sin);
        crest.beam(root, root + Vec3::new(0.0, 0.13 * cos + 0.02, -0.17 * sin - 0.05), Vec3::X, 0.05, 0.09);
    }
    let arms = [arm(wardrobe, steel), arm(wardrobe, steel)];
    let [[right_upper, mut right], [left_upper, mut left]] = arms;
    let hand = Vec3::Y * -FOREARM;
    let blade = right.paint(wardrobe.steel, linear_from_hex(0xe4e8f0));
    blade.beam(hand + GRIP * 0.10, hand + GRIP * 0.95, Vec3::Y, 0.065, 0.016);
    spike(blade, hand + GRIP * 0.95, hand + GRIP * 1.10, 0.035);
    let hilt = right.paint(wardrobe.steel, linear_from_hex(0xc08a2c));
    hilt.beam(hand + GRIP * 0.09 - Vec3::X * 0.13, hand + GRIP * 0.09 + Vec3::X * 0.13, GRIP, 0.04, 0.04);
    hilt.beam(hand - GRIP * 0.14, hand + GRIP * 0.09, Vec3::X, 0.035, 0.035);
    // The shield stands upright before the fist when the elbow is bent: its top is towards +Z of the forearm.
    let rim = left.paint(wardrobe.steel, linear_from_hex(0xc08a2c));
    heater(rim, hand - Vec3::Y * 0.09, 0.30, 0.50, 0.03);
    heater(left.paint(wardrobe.cloth, tint), hand - Vec3::Y * 0.122, 0.265, 0.455, 0.02);
    heater(left.paint(wardrobe.steel, linear_from_hex(0xd8c27a)), hand - Vec3::Y * 0.14, 0.09, 0.16, 0.02);
    let mut mantle = Model::default();
    cape(&mut mantle, wardrobe, tint, 1.15);
    Body {
        build: PERSON,
        hips,
        chest,
        head,
        arms: [[right_upper, right], [left_upper, left]],
        legs: [leg(wardrobe, steel), leg(wardrobe, steel)],
        cape: Some((mantle, 1.15)),
    }
}

/// A heater shield of half-width `half` and half-height `tall`, facing -Y with its top towards +Z, `thick`
/// thick.
fn heater(shape: &mut Shape, centre: Vec3, half: f32, tall: f32, thick: f32) {
    let outline: Vec<Vec3> = [(-1.0, 0.9), (0.0, 1.0), (1.0, 0.9), (0.92, 0.0), (0.55, -0.62), (0.0, -1.0)]
        .into_iter()
        .chain([(-0.55, -0.62), (-0.92, 0.0)])
        .map(|(x, z)| centre + Vec3::new(half * x, 0.35 * half * x * x, tall * z))
        .collect();
    let back = Vec3::Y * thick;
    for index in 0..outline.len() {
        let (a, b) = (outline[index], outline[(index + 1) % outline.len()]);
        shape.triangle([centre, b, a]);
        shape.triangle([centre + back, a + back, b + back]);
        shape.quad([a, b, b + back, a + back]);
    }
}

/// Somebody in a robe and a pointed hat, with a staff that carries a crystal at its head.
pub(super) fn mage(wardrobe: &Wardrobe, team: Team, tint: Vec3) -> Body {
    let [mut hips, mut chest, mut head] = [Model::default(), Model::default(), Model::default()];
    let gold = linear_from_hex(0xc89a3c);
    // A robe down to the ground, with a golden hem and belt.
    let robe = [(0.46, -0.86), (0.37, -0.62), (0.27, -0.30), (0.19, -0.05), (0.16, 0.08)];
    hips.paint(wardrobe.cloth, tint).lathe(Vec3::ZERO, &robe, 18);
    hips.paint(wardrobe.cloth, gold * 0.8).lathe(Vec3::ZERO, &[(0.467, -0.865), (0.44, -0.79)], 18);
    ball(hips.paint(wardrobe.cloth, gold * 0.5), Vec3::Y * 0.03, Vec3::new(0.185, 0.05, 0.16));
    let mut torso = Model::default();
    // The chest under a golden collar, flattened from front to back.
    let cloth = [(0.15, 0.0), (0.17, 0.15), (0.215, 0.34), (0.21, 0.44), (0.10, 0.55), (0.0, 0.56)];
    torso.paint(wardrobe.cloth, tint).lathe(Vec3::ZERO, &cloth, 14);
    torso.paint(wardrobe.cloth, gold * 0.7).lathe(
        Vec3::ZERO,
        &[(0.36, 0.33), (0.30, 0.44), (0.13, 0.55)],
        16,
    );
    chest.append(&torso, Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.8)));
    let skin =
        head.paint(wardrobe.cloth, linear_from_hex(if team == Team::Heroes { 0xc08a68 } else { 0x5c6a58 }));
    ball(skin, Vec3::Y * 0.12, Vec3::new(0.10, 0.14, 0.115));
    let beard = head.paint(wardrobe.cloth, linear_from_hex(0xb8b2a8));
    spike(beard, Vec3::new(0.0, 0.09, 0.07), Vec3::new(0.0, -0.24, 0.14), 0.14);
    let hat = head.paint(wardrobe.cloth, tint * 0.85);
    let cone =
        [(0.13, 0.16), (0.31, 0.185), (0.30, 0.20), (0.145, 0.235), (0.115, 0.36), (0.06, 0.56), (0.0, 0.76)];
    hat.lathe(Vec3::new(0.0, 0.0, -0.01), &cone, 16);
    head.paint(wardrobe.cloth, gold).lathe(Vec3::new(0.0, 0.0, -0.01), &[(0.148, 0.23), (0.14, 0.275)], 16);
    // Wide sleeves that show the hands; the right one holds a staff.
    let arms = [0, 1].map(|_| {
        let [mut upper, mut fore] = [Model::default(), Model::default()];
        sleeve(upper.paint(wardrobe.cloth, tint), PERSON.upper_arm, 0.085, 0.075);
        fore.paint(wardrobe.cloth, tint).lathe(
            Vec3::ZERO,
            &[(0.16, -FOREARM), (0.11, -0.5 * FOREARM), (0.07, 0.0), (0.0, 0.06)],
            12,
        );
        ball(
            fore.paint(wardrobe.cloth, linear_from_hex(0xb07c5c)),
            Vec3::Y * (-FOREARM - 0.03),
            Vec3::splat(0.055),
        );
        [upper, fore]
    });
    let [[right_upper, mut right], left] = arms;
    staff(&mut right, wardrobe, team);
    Body {
        build: PERSON,
        hips,
        chest,
        head,
        arms: [[right_upper, right], left],
        legs: Default::default(),
        cape: None,
    }
}

/// A staff in the right hand, with a crystal between claws.
fn staff(right: &mut Model, wardrobe: &Wardrobe, team: Team) {
    let hand = Vec3::Y * (-FOREARM - 0.03);
    let wood = right.paint(wardrobe.wood, linear_from_hex(0x6a4a30));
    wood.tube(&[(hand - GRIP * 0.85, 0.02), (hand, 0.024), (hand + GRIP * 0.78, 0.028)], 8);
    for turn in 0..3 {
        let (sin, cos) = (TAU * turn as f32 / 3.0).sin_cos();
        let out = Vec3::X * cos + Vec3::X.cross(GRIP) * sin;
        let claw = |along: f32, reach: f32| hand + GRIP * along + out * reach;
        wood.tube(&[(claw(0.74, 0.01), 0.018), (claw(0.86, 0.09), 0.016), (claw(1.02, 0.06), 0.006)], 5);
    }
    let crystal = right.paint(wardrobe.glow(team), Vec3::splat(0.2));
    let middle = hand + GRIP * STAFF_TIP;
    spike(crystal, middle, middle + GRIP * 0.14, 0.09);
    spike(crystal, middle, middle - GRIP * 0.09, 0.09);
}

/// Distance along the staff from the hand to the crystal.
const STAFF_TIP: f32 = 0.92;

/// The crystal of a staff in the space of the right hand.
pub(super) fn staff_tip() -> Vec3 {
    Vec3::Y * (-FOREARM - 0.03) + GRIP * STAFF_TIP
}

/// Somebody in black plate with horns, glowing eyes and an axe.
pub(super) fn raider(wardrobe: &Wardrobe, tint: Vec3) -> Body {
    let steel = linear_from_hex(0x4a4246);
    let [hips, mut chest, mut head] = armour(wardrobe, steel, tint);
    for sign in [-1.0, 1.0] {
        let horn = head.paint(wardrobe.cloth, linear_from_hex(0xc8b898));
        let points = [
            (Vec3::new(sign * 0.11, 0.20, 0.0), 0.045),
            (Vec3::new(sign * 0.24, 0.25, 0.02), 0.036),
            (Vec3::new(sign * 0.31, 0.38, 0.05), 0.022),
            (Vec3::new(sign * 0.28, 0.50, 0.07), 0.003),
        ];
        horn.tube(&points, 7);
        let eye = Vec3::new(sign * 0.045, 0.16, 0.133);
        head.paint(wardrobe.glow(Team::Raiders), Vec3::splat(0.1))
            .block(eye - Vec3::new(0.024, 0.011, 0.01), eye + Vec3::new(0.024, 0.011, 0.012));
        let spikes = chest.paint(wardrobe.steel, steel);
        for step in 0..3 {
            let base = Vec3::new(sign * (0.20 + 0.07 * step as f32), 0.54 - 0.04 * step as f32, 0.0);
            spike(spikes, base, base + Vec3::new(sign * 0.09, 0.19, -0.02), 0.07);
        }
    }
    let [[right_upper, mut right], left] = [arm(wardrobe, steel), arm(wardrobe, steel)];
    let hand = Vec3::Y * -FOREARM;
    let shaft = right.paint(wardrobe.wood, linear_from_hex(0x50382a));
    shaft.tube(&[(hand - GRIP * 0.35, 0.022), (hand + GRIP * 0.85, 0.022)], 8);
    let edge = GRIP.cross(Vec3::X);
    let bit = right.paint(wardrobe.steel, linear_from_hex(0x9a9aa4));
    for sign in [1.0, -1.0] {
        let at = |along: f32, out: f32, thick: f32| {
            hand + GRIP * along + edge * (sign * out) + Vec3::X * (sign * thick)
        };
        // Two flat wedges, thin at the edge.
        for side in [0.022, -0.022] {
            let corners =
                [at(0.58, 0.0, side), at(0.48, 0.25, 0.0), at(0.92, 0.25, 0.0), at(0.78, 0.0, side)];
            let mut corners = corners;
            if side > 0.0 {
                corners.reverse();
            }
            bit.quad(corners);
        }
    }
    Body {
        build: PERSON,
        hips,
        chest,
        head,
        arms: [[right_upper, right], left],
        legs: [leg(wardrobe, steel), leg(wardrobe, steel)],
        cape: None,
    }
}

/// Four metres and a half of stone.
const GOLEM: Build = Build {
    thigh: 0.95,
    shin: 0.95,
    toe: 0.75,
    heel: 0.48,
    hip: 0.62,
    shoulder: 1.42,
    shoulder_height: 1.55,
    neck: 1.75,
    stoop: 0.42,
    upper_arm: 1.15,
};

/// The golem's mouth in the space of its head.
pub(super) const GOLEM_MOUTH: Vec3 = Vec3::new(0.0, 0.12, 0.62);

/// A boulder with flat faces.
fn rock(model: &mut Model, wardrobe: &Wardrobe, rng: &mut Rng, centre: Vec3, radii: Vec3) {
    let (rows, columns) = (6, 9);
    let mut point = |row: usize, column: usize| {
        let lift = if row == 0 || row == rows { 0.0 } else { rng.about(0.0, 0.22) };
        let (sin, cos) = (PI * (row as f32 + lift) / rows as f32).sin_cos();
        let (east, north) = (TAU * (column as f32 + 0.5 * (row % 2) as f32) / columns as f32).sin_cos();
        // Superellipsoid: a block that rivers have rounded.
        let blunt = |value: f32| value.abs().powf(0.72).copysign(value);
        let sides = Vec3::new(blunt(sin) * blunt(east), blunt(cos), blunt(sin) * blunt(north));
        centre + sides * radii * rng.between(0.88, 1.08)
    };
    let grid: Vec<Vec<Vec3>> = (0..=rows)
        .map(|row| {
            let pole = row == 0 || row == rows;
            let first = point(row, 0);
            (0..columns).map(|column| if pole || column == 0 { first } else { point(row, column) }).collect()
        })
        .collect();
    let tone = rng.between(0.8, 1.15);
    let shape = model.paint(wardrobe.stone, linear_from_hex(0x857a70) * tone);
    for row in 0..rows {
        for column in 0..columns {
            let next = (column + 1) % columns;
            let (a, b) = (grid[row][column], grid[row][next]);
            let (c, d) = (grid[row + 1][column], grid[row + 1][next]);
            for corners in [[a, c, d], [a, d, b]] {
                if (corners[1] - corners[0]).cross(corners[2] - corners[0]).length_squared() > 1e-10 {
                    shape.triangle(corners);
                }
            }
        }
    }
}

/// Makes the boulders that a golem is piled up from.
struct Quarry<'a> {
    wardrobe: &'a Wardrobe,
    rng: &'a mut Rng,
}

impl Quarry<'_> {
    /// Boulders, each a middle and radii, and the embers between them, each a middle and a radius.
    fn rocks(&mut self, lumps: &[[f32; 6]], core: &[[f32; 4]]) -> Model {
        let mut model = Model::default();
        for &[x, y, z, rx, ry, rz] in lumps {
            rock(&mut model, self.wardrobe, self.rng, Vec3::new(x, y, z), Vec3::new(rx, ry, rz));
        }
        for &[x, y, z, radius] in core {
            ball(model.paint(self.wardrobe.lava, Vec3::splat(0.1)), Vec3::new(x, y, z), Vec3::splat(radius));
        }
        model
    }

    fn arm(&mut self) -> [Model; 2] {
        [
            self.rocks(
                &[[0.0, 0.05, 0.0, 0.55, 0.52, 0.52], [0.0, -0.68, 0.0, 0.36, 0.42, 0.36]],
                &[[0.0, -0.36, 0.0, 0.3], [0.0, -1.1, 0.0, 0.27]],
            ),
            self.rocks(
                &[
                    [0.0, -0.42, 0.0, 0.44, 0.46, 0.44],
                    [0.0, -1.12, 0.05, 0.58, 0.48, 0.56],
                    [0.25, -1.5, 0.2, 0.22, 0.22, 0.24],
                    [-0.25, -1.5, 0.2, 0.22, 0.22, 0.24],
                ],
                &[[0.0, -0.78, 0.0, 0.36]],
            ),
        ]
    }

    fn leg(&mut self) -> [Model; 2] {
        [
            self.rocks(&[[0.0, -0.42, 0.0, 0.46, 0.55, 0.46]], &[[0.0, -0.92, 0.0, 0.32]]),
            self.rocks(
                &[[0.0, -0.42, 0.0, 0.46, 0.42, 0.46], [0.0, -0.76, 0.14, 0.55, 0.24, 0.66]],
                &[[0.0, -0.1, 0.0, 0.33]],
            ),
        ]
    }
}

/// A golem of boulders, with embers between them.
pub(super) fn golem(wardrobe: &Wardrobe, rng: &mut Rng) -> Body {
    let mut quarry = Quarry { wardrobe, rng };
    let hips = quarry.rocks(
        &[[0.0, 0.0, 0.0, 0.75, 0.42, 0.55], [0.0, -0.3, 0.3, 0.4, 0.35, 0.3]],
        &[[0.0, 0.42, 0.05, 0.48]],
    );
    let chest = quarry.rocks(
        &[
            [-0.52, 1.12, 0.12, 0.66, 0.62, 0.72],
            [0.52, 1.10, 0.10, 0.66, 0.62, 0.72],
            [0.0, 0.62, -0.1, 0.72, 0.34, 0.55],
            [0.0, 1.35, -0.45, 0.8, 0.62, 0.42],
            [-0.85, 1.66, -0.12, 0.42, 0.34, 0.42],
            [0.85, 1.62, -0.12, 0.42, 0.34, 0.42],
            [-0.3, 1.95, -0.5, 0.24, 0.5, 0.24],
            [0.34, 1.92, -0.52, 0.22, 0.42, 0.22],
        ],
        &[
            [0.0, 1.05, 0.30, 0.50],
            [0.0, 0.78, 0.18, 0.52],
            [-0.75, 1.35, 0.0, 0.46],
            [0.75, 1.35, 0.0, 0.46],
        ],
    );
    let mut head = quarry.rocks(
        &[
            [0.0, 0.34, 0.05, 0.44, 0.34, 0.44],
            [0.0, 0.42, 0.36, 0.40, 0.15, 0.18],
            [0.0, -0.10, 0.26, 0.36, 0.15, 0.34],
        ],
        &[[0.0, 0.12, 0.22, 0.27]],
    );
    for sign in [-1.0, 1.0] {
        let eye = Vec3::new(sign * 0.19, 0.26, 0.44);
        ball(head.paint(wardrobe.lava, Vec3::splat(0.1)), eye, Vec3::new(0.09, 0.05, 0.07));
    }
    let arms = [quarry.arm(), quarry.arm()];
    let legs = [quarry.leg(), quarry.leg()];
    Body { build: GOLEM, hips, chest, head, arms, legs, cape: None }
}

/// The plane of a sword stroke: a quarter of a turn that rises to the figure's left, as a crescent around the
/// shoulder.
pub(super) fn crescent(material: u32, inner: f32, outer: f32) -> Model {
    let mut model = Model::default();
    let shape = model.paint(material, Vec3::ONE);
    let steps = 16;
    let first = shape.positions.len() as u32;
    for step in 0..=steps {
        let s = step as f32 / steps as f32;
        let (sin, cos) = (FRAC_PI_2 * (1.5 * s - 0.75)).sin_cos();
        let direction = Vec3::new(-sin, 0.35 * sin, cos);
        for (radius, u) in [(inner, 0.0), (outer, 1.0)] {
            // A trail that thins out behind the blade.
            let reach = outer + (radius - outer) * (PI * s).sin().max(0.0);
            shape.vertex(Vertex {
                position: direction * reach,
                normal: Vec3::new(0.33, 0.94, 0.0),
                uv: Vec2::new(u, s),
            });
        }
    }
    for step in 0..steps {
        let at = first + 2 * step;
        shape.indices.extend([[at, at + 1, at + 3], [at, at + 3, at + 2]]);
    }
    model
}
