//! The town square that `smoke-square` and `pane` share.
//!
//! North is -Z. Rows of houses close the north, east and south; the south-west is open, and the low sun
//! shines in through it.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine3A, IVec2, Quat, Vec2, Vec3};
use sheer_core::colour::linear_from_hex;
use sheer_scene::environment::{Environment, Lobe};

use crate::{
    builder::{Prop, SceneBuilder},
    kit::{
        foliage::{Habit, planting, tree},
        furniture,
        house::{Covering, House, Slope, Wall},
        leaf::Cluster,
        palette::Palette,
    },
    paint::{Noise, smoothstep},
    rng::Rng,
    shape::Model,
};

/// Where the fountain stands.
pub(crate) const FOUNTAIN: Vec3 = Vec3::new(-5.5, 0.0, -4.5);
/// The lamp post whose shadow falls into the smoke.
pub(crate) const SHADOW_LAMP: Vec3 = Vec3::new(-0.2, 0.0, 2.6);
/// The fire bowl that the smoke comes from.
pub(crate) const FIRE_BOWL: Vec3 = Vec3::new(8.2, 0.0, -1.6);
/// Half the width of the paved square, west to east.
const HALF_WIDTH: f32 = 18.0;
/// The fronts of the northern and southern rows.
const NORTH: f32 = -16.0;
const SOUTH: f32 = 18.0;
/// Pavement in front of the houses.
const PAVEMENT: f32 = 2.2;
const KERB: f32 = 0.12;

/// Unit direction towards the sun: late afternoon, in the south-west.
pub(crate) fn towards_sun() -> Vec3 {
    Vec3::new(-0.80, 0.45, 0.41).normalize()
}

/// A clear sky with the glow around a low sun.
pub(crate) fn sky() -> Environment {
    Environment {
        zenith: Vec3::new(0.08, 0.26, 0.74),
        horizon: Vec3::new(0.64, 0.78, 0.90),
        ground: Vec3::new(0.20, 0.17, 0.14),
        lobes: vec![
            Lobe { direction: towards_sun(), radiance: Vec3::new(1.5, 1.05, 0.6), sharpness: 9.0 },
            Lobe { direction: towards_sun(), radiance: Vec3::new(6.0, 4.6, 3.0), sharpness: 160.0 },
        ],
        ..Environment::black()
    }
}

/// Builds the square without smoke: everything opaque or cut out.
pub(crate) fn raise(builder: &mut SceneBuilder, seed: u32) -> Palette {
    let palette = Palette::new(builder, seed);
    builder.sun(towards_sun(), Vec3::new(4.9, 3.75, 2.4));
    put_ground(builder, &palette, seed);
    put_houses(builder, &palette, seed);
    put_tower(builder, &palette, seed);
    put_trees(builder, &palette, seed);
    put_furniture(builder, &palette, seed);
    palette
}

/// A place on the ground, turned around +Y.
fn at(x: f32, z: f32, turn_rad: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_y(turn_rad), Vec3::new(x, 0.0, z))
}

fn put_ground(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let noise = Noise { seed: seed.wrapping_add(400) };
    let stains = noise.fractal(IVec2::splat(9), 4);
    // Broad stains, since a texture of two and a half metres repeats many times; the foot of the kerbs stays
    // dark and damp.
    let shade = |p: Vec3| {
        let stain = stains.at(Vec2::new(p.x, p.z) / 64.0 + 0.5);
        let kerb =
            (HALF_WIDTH - PAVEMENT - p.x.abs()).min(p.z - NORTH - PAVEMENT).min(SOUTH - PAVEMENT - p.z);
        (1.0 + 0.28 * stain) * (0.72 + 0.28 * smoothstep(0.0, 1.6, kerb.abs()))
    };
    let mut ground = Model::default();
    let cell = 1.0;
    for row in -46..32 {
        for column in -32..28 {
            let corner = Vec3::new(column as f32, 0.0, row as f32) * cell;
            ground.paint(palette.cobbles, Vec3::ONE).panel(
                corner + Vec3::Z * cell,
                Vec3::X * cell,
                -Vec3::Z * cell,
            );
        }
    }
    // Bands of slabs divide the cobbles into fields, up to the ring around the fountain.
    let bands = ground.paint(palette.slabs, Vec3::new(1.0, 0.96, 0.90));
    for index in -3..=3 {
        let (line, half, lift) = (5.0 * index as f32 - 0.5, 0.2, 0.008);
        for step in -16..16 {
            let (from, to) = (step as f32, step as f32 + 1.0);
            let east_west = Vec3::new(from, lift, line + 1.0 + half);
            let north_south = Vec3::new(line - half, lift + 0.001, to + 1.0);
            for (corner, right, up) in
                [(east_west, Vec3::X, -Vec3::Z * 2.0 * half), (north_south, Vec3::X * 2.0 * half, -Vec3::Z)]
            {
                let middle = corner + 0.5 * (right + up);
                let paved = middle.x.abs() < HALF_WIDTH - PAVEMENT && middle.z > NORTH + PAVEMENT;
                if paved && middle.with_y(0.0).distance(FOUNTAIN) > 5.3 {
                    bands.panel(corner, right, up);
                }
            }
        }
    }
    // A ring of slabs around the fountain.
    ground.paint(palette.slabs, Vec3::new(1.05, 1.0, 0.93)).lathe(
        FOUNTAIN,
        &[(5.3, -0.02), (5.25, 0.025), (3.7, 0.03)],
        72,
    );
    ground.shade(|p, _| shade(p));
    builder.put("ground", ground);

    let mut pavement = Model::default();
    let slabs = pavement.paint(palette.slabs, Vec3::ONE);
    let mut lay = |x: [f32; 2], z: [f32; 2]| {
        slabs.block(Vec3::new(x[0], -0.05, z[0]), Vec3::new(x[1], KERB, z[1]));
    };
    lay([-HALF_WIDTH, -6.2], [NORTH, NORTH + PAVEMENT]);
    lay([-1.8, HALF_WIDTH], [NORTH, NORTH + PAVEMENT]);
    lay([HALF_WIDTH - PAVEMENT, HALF_WIDTH], [NORTH + PAVEMENT, SOUTH - PAVEMENT]);
    lay([-HALF_WIDTH, -HALF_WIDTH + PAVEMENT], [NORTH + PAVEMENT, -1.0]);
    lay([-HALF_WIDTH, HALF_WIDTH], [SOUTH - PAVEMENT, SOUTH]);
    pavement.shade(|p, n| {
        let wall = (HALF_WIDTH - p.x.abs()).min(p.z - NORTH).min(SOUTH - p.z);
        if n.y > 0.5 { 0.66 + 0.34 * smoothstep(-0.2, 1.5, wall) } else { 0.8 }
    });
    builder.put("pavement", pavement);

    // Meadow and hills beyond the town, bluer with distance.
    let mut land = Model::default();
    let rings: [(f32, f32); 5] = [(20.0, -0.06), (60.0, -0.06), (95.0, 3.0), (140.0, 14.0), (200.0, 24.0)];
    let segment_count = 96;
    let relief = noise.fractal(IVec2::new(7, 4), 3);
    let point = |ring: usize, segment: i32| {
        let (radius, height) = rings[ring];
        let turn = segment as f32 / segment_count as f32;
        let relief = 1.0 + 0.55 * relief.at(Vec2::new(turn, 0.13 * ring as f32));
        let direction = Vec2::from_angle(turn * 2.0 * PI);
        Vec3::new(
            direction.x * radius,
            if height > 0.0 { height * relief } else { height },
            direction.y * radius,
        )
    };
    for ring in 0..rings.len() - 1 {
        let haze = ring as f32 / (rings.len() - 2) as f32;
        let tint = Vec3::new(0.75, 0.85, 0.8).lerp(Vec3::new(1.2, 1.9, 4.2), haze * haze);
        for segment in 0..segment_count {
            land.paint(palette.meadow, tint).quad([
                point(ring, segment + 1),
                point(ring, segment),
                point(ring + 1, segment),
                point(ring + 1, segment + 1),
            ]);
        }
    }
    builder.put("land", land);
}

/// Fronts that no two neighbours share.
fn design(rng: &mut Rng, width: f32, previous: Option<&House>) -> House {
    let plasters =
        [0xe9d9b0, 0xdcb183, 0xd89a78, 0xc9c4a8, 0xe8e0d0, 0xb9c2b4, 0xd8c08a, 0xc98f6a].map(linear_from_hex);
    let paints = [0x3f5c4a, 0x5a2f2a, 0x33475c, 0x6a5238, 0x4a3a52, 0x2f4f4f].map(linear_from_hex);
    let roofs = [0xa04e30, 0x8a4630, 0xb0603c, 0x7a4436, 0x6a5a54].map(linear_from_hex);
    let gable_front = width < 8.4 && rng.happens(0.55) && previous.is_none_or(|house| !house.gable_front);
    let storeys = [2, 3, 3];
    let mut house = House {
        width,
        depth: 9.0,
        storey_count: *rng.pick(&storeys),
        pitch: rng.between(0.95, 1.2),
        gable_front,
        wall: Wall::Brick,
        trim: linear_from_hex(0xe6dfcf),
        paint: *rng.pick(&paints),
        covering: if rng.happens(0.5) { Covering::Pantile } else { Covering::Plain },
        roof: *rng.pick(&roofs),
        shutters: false,
        shop: rng.happens(0.5),
        dormer_count: if gable_front { 0 } else { (width / 3.2) as u32 },
    };
    loop {
        let plaster = *rng.pick(&plasters);
        house.wall = match rng.below(10) {
            0..=4 => Wall::Plaster(plaster),
            5..=7 => Wall::HalfTimber(linear_from_hex(0xeae2cc)),
            _ => Wall::Brick,
        };
        let kind = std::mem::discriminant(&house.wall);
        let differs = previous.is_none_or(|other| match (house.wall, other.wall) {
            (Wall::Plaster(one), Wall::Plaster(two)) => one.distance(two) > 0.12,
            _ => kind != std::mem::discriminant(&other.wall),
        });
        if differs {
            break;
        }
    }
    house.shutters = matches!(house.wall, Wall::Plaster(_)) && rng.happens(0.6);
    house
}

fn put_houses(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let mut rng = Rng::new(seed, "houses");
    // Fronts from left to right as one faces them: where the row begins, which way its houses look, and their
    // widths.
    let rows: [(Vec3, f32, &[f32]); 8] = [
        (Vec3::new(-19.0, 0.0, NORTH), 0.0, &[6.2, 6.6]),
        (Vec3::new(-1.8, 0.0, NORTH), 0.0, &[7.0, 5.8, 7.4]),
        (Vec3::new(HALF_WIDTH, 0.0, NORTH + 0.4), -FRAC_PI_2, &[6.6, 7.6, 6.0, 7.2, 6.4]),
        (Vec3::new(-HALF_WIDTH, 0.0, -1.0), FRAC_PI_2, &[7.8, 7.2]),
        (Vec3::new(HALF_WIDTH - 1.0, 0.0, SOUTH), PI, &[7.0, 6.2, 7.4, 6.4]),
        // The street to the north, and the house that closes it.
        (Vec3::new(-6.2, 0.0, NORTH - 9.6), FRAC_PI_2, &[6.4]),
        (Vec3::new(-1.8, 0.0, NORTH - 16.2), -FRAC_PI_2, &[6.4]),
        (Vec3::new(-10.4, 0.0, -36.0), 0.0, &[9.0]),
    ];
    for (start, turn_rad, widths) in rows {
        let rotation = Quat::from_rotation_y(turn_rad);
        let mut from = 0.0;
        let mut previous: Option<House> = None;
        for &width in widths {
            let house = design(&mut rng, width, previous.as_ref());
            let prop = builder.prop("house", house.build(palette, &mut rng));
            let middle = start + rotation * Vec3::X * (from + 0.5 * width);
            builder.place(&prop, Affine3A::from_rotation_translation(rotation, middle));
            from += width;
            previous = Some(house);
        }
    }
}

/// The church stands this much higher than the square, so that its dial shows above the roofs.
const CHURCH_HILL: f32 = 7.0;

/// A church tower at the end of the street to the north.
fn put_tower(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let mut rng = Rng::new(seed, "tower");
    let mut model = Model::default();
    let (half, top) = (2.7, 17.5);
    let stone = model.paint(palette.ashlar, Vec3::new(0.95, 0.92, 0.88));
    for (low, high) in [(-CHURCH_HILL, 10.6), (10.6, top)] {
        stone.block(Vec3::new(-half, low, -half), Vec3::new(half, high, half));
    }
    for y in [10.5, top] {
        stone.block(
            Vec3::new(-half - 0.18, y - 0.15, -half - 0.18),
            Vec3::new(half + 0.18, y + 0.18, half + 0.18),
        );
    }
    for turn in 0..4 {
        let turned = Affine3A::from_rotation_y(turn as f32 * FRAC_PI_2);
        let mut face = Model::default();
        // Buttress strips, belfry openings with louvres, a dial.
        let strips = face.paint(palette.ashlar, Vec3::splat(0.9));
        for x in [-half - 0.06, half - 0.5] {
            strips
                .block(Vec3::new(x, -CHURCH_HILL, half - 0.02), Vec3::new(x + 0.56, top - 0.15, half + 0.14));
        }
        for x in [-0.95, 0.95] {
            let dark = face.paint(palette.timber, Vec3::splat(0.05));
            dark.panel(Vec3::new(x - 0.5, 14.2, half + 0.012), Vec3::X, Vec3::Y * 2.2);
            for louvre in 0..8 {
                let y = 14.26 + 0.26 * louvre as f32;
                let wood = face.paint(palette.timber, Vec3::splat(0.30));
                wood.panel(Vec3::new(x - 0.5, y, half + 0.16), Vec3::X, Vec3::new(0.0, 0.19, -0.14));
            }
            let frame = face.paint(palette.slabs, Vec3::new(1.5, 1.42, 1.3));
            for side in [-0.66, 0.5] {
                frame.block(Vec3::new(x + side, 14.05, half), Vec3::new(x + side + 0.16, 16.5, half + 0.2));
            }
            frame.block(Vec3::new(x - 0.7, 16.4, half), Vec3::new(x + 0.7, 16.62, half + 0.24));
            frame.block(Vec3::new(x - 0.74, 13.98, half), Vec3::new(x + 0.74, 14.2, half + 0.28));
        }
        let dial = face.paint(palette.dial, Vec3::ONE);
        dial.fitted_panel(
            Vec3::new(-1.05, 11.2, half + 0.06),
            Vec3::X * 2.1,
            Vec3::Y * 2.1,
            Vec2::ZERO,
            Vec2::ONE,
        );
        let rim = face.paint(palette.slabs, Vec3::new(1.4, 1.3, 1.2));
        for (low, high) in [
            (Vec3::new(-1.2, 11.05, half), Vec3::new(1.2, 11.2, half + 0.14)),
            (Vec3::new(-1.2, 13.3, half), Vec3::new(1.2, 13.45, half + 0.14)),
            (Vec3::new(-1.2, 11.2, half), Vec3::new(-1.05, 13.3, half + 0.14)),
            (Vec3::new(1.05, 11.2, half), Vec3::new(1.2, 13.3, half + 0.14)),
        ] {
            rim.block(low, high);
        }
        model.append(&face, turned);
    }
    // A spire in two slopes, slated, with a ball and a vane.
    let slate = linear_from_hex(0x4c5660);
    for (low, high, wide, narrow) in
        [(top + 0.1, top + 2.2, half + 0.35, 1.75), (top + 2.2, top + 10.5, 1.75, 0.04)]
    {
        for turn in 0..4 {
            let turned = Affine3A::from_rotation_y(turn as f32 * FRAC_PI_2);
            let mut face = Model::default();
            let rows = ((high - low) / 0.4) as u32;
            for row in 0..rows {
                let (a, b) = (row as f32 / rows as f32, (row as f32 + 1.0) / rows as f32);
                let (r0, r1) = (wide + (narrow - wide) * a, wide + (narrow - wide) * b);
                let (y0, y1) = (low + (high - low) * a, low + (high - low) * b);
                let shape = face.paint(palette.tiles, slate * rng.between(0.8, 1.1));
                // Each course stands a little over the one below.
                shape.quad([
                    Vec3::new(-r0 - 0.03, y0, r0 + 0.03),
                    Vec3::new(r0 + 0.03, y0, r0 + 0.03),
                    Vec3::new(r1, y1, r1),
                    Vec3::new(-r1, y1, r1),
                ]);
            }
            model.append(&face, turned);
        }
    }
    let gold = model.paint(palette.metal, Vec3::new(0.95, 0.70, 0.28));
    let tip = Vec3::Y * (top + 10.4);
    gold.lathe(
        tip,
        &[
            (0.05, 0.0),
            (0.05, 0.4),
            (0.22, 0.55),
            (0.26, 0.70),
            (0.22, 0.85),
            (0.04, 1.0),
            (0.03, 2.1),
            (0.0, 2.2),
        ],
        16,
    );
    // The nave behind it, only its roof seen.
    let nave = model.paint(palette.ashlar, Vec3::splat(0.9));
    nave.block(Vec3::new(-4.5, -CHURCH_HILL, -20.0), Vec3::new(4.5, 9.5, -half));
    for side in [1.0, -1.0] {
        let foot = Vec3::new(side * 5.0, 9.2, if side > 0.0 { -half } else { -20.3 });
        let run = Vec3::new(0.0, 0.0, -side * 17.6);
        let plane = Slope { foot, run, up: Vec3::new(-side * 5.0, 5.6, 0.0) };
        plane.cover(&mut model, palette, &mut rng, Covering::Plain, linear_from_hex(0x8a4630), true);
    }
    builder.put_at("church", model, Affine3A::from_translation(Vec3::new(-9.2, CHURCH_HILL, -52.0)));
}

fn put_trees(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let mut rng = Rng::new(seed, "trees");
    let habits = [
        Habit { height: 9.2, radius: 3.1, clear: 0.30, clump_count: 48, cards_per_clump: 46, turning: 0.10 },
        Habit { height: 7.6, radius: 2.7, clear: 0.32, clump_count: 40, cards_per_clump: 46, turning: 0.42 },
    ];
    let trees: Vec<Prop> =
        habits.map(|habit| builder.prop("tree", tree(palette, &mut rng, habit))).into_iter().collect();
    let places: [(f32, f32, usize); 10] = [
        (-4.6, 10.8, 0),
        (-13.6, -10.2, 0),
        (-13.4, 1.6, 1),
        (-24.5, 2.0, 1),
        (13.4, -11.2, 1),
        (13.6, 9.5, 0),
        (-25.0, 9.0, 0),
        (-23.0, 15.0, 1),
        (-29.5, 13.0, 1),
        (-27.0, 19.5, 0),
    ];
    for (x, z, kind) in places {
        let scale = rng.between(0.92, 1.08);
        let turn = Quat::from_rotation_y(rng.between(0.0, 2.0 * PI));
        let world_from_tree =
            Affine3A::from_scale_rotation_translation(Vec3::splat(scale), turn, Vec3::new(x, 0.0, z));
        builder.place(&trees[kind], world_from_tree);
        if x.abs() < HALF_WIDTH {
            // A square of soil behind a stone edge.
            let mut pit = Model::default();
            pit.paint(palette.meadow, Vec3::new(0.75, 0.55, 0.45)).panel(
                Vec3::new(-0.8, 0.03, 0.8),
                Vec3::X * 1.6,
                -Vec3::Z * 1.6,
            );
            let edge = pit.paint(palette.slabs, Vec3::splat(1.1));
            edge.block(Vec3::new(-0.95, -0.02, 0.8), Vec3::new(0.95, 0.09, 0.95));
            edge.block(Vec3::new(-0.95, -0.02, -0.95), Vec3::new(0.95, 0.09, -0.8));
            edge.block(Vec3::new(-0.95, -0.02, -0.8), Vec3::new(-0.8, 0.09, 0.8));
            edge.block(Vec3::new(0.8, -0.02, -0.8), Vec3::new(0.95, 0.09, 0.8));
            builder.put_at("tree pit", pit, at(x, z, 0.0));
        }
    }
    // A low wall with a hedge closes the square towards the park.
    let mut wall = Model::default();
    let stone = wall.paint(palette.ashlar, Vec3::splat(0.9));
    let (low, high) = (Vec3::new(-18.3, 0.0, -0.9), Vec3::new(-17.9, 0.75, 15.2));
    stone.block(low, high);
    wall.paint(palette.slabs, Vec3::splat(1.2)).block(
        Vec3::new(low.x - 0.06, high.y, low.z - 0.06),
        Vec3::new(high.x + 0.06, high.y + 0.1, high.z + 0.06),
    );
    for half_metre in 0..31 {
        let z = -0.6 + 0.5 * half_metre as f32;
        let bed = (Vec3::new(-19.2, 0.0, z), Vec3::new(-18.5, 1.05, z + 0.7));
        planting(&mut wall, palette, &mut rng, Cluster::Hedge, bed, 36);
    }
    builder.put("park wall", wall);
}

fn put_furniture(builder: &mut SceneBuilder, palette: &Palette, seed: u32) {
    let mut rng = Rng::new(seed, "furniture");
    builder.put_at("fountain", furniture::fountain(palette), at(FOUNTAIN.x, FOUNTAIN.z, 0.0));

    let lamp = builder.prop("lamp post", furniture::lamp_post(palette));
    for (x, z) in [
        (SHADOW_LAMP.x, SHADOW_LAMP.z),
        (-10.8, 6.4),
        (11.6, -6.2),
        (-11.4, -12.2),
        (2.2, -12.4),
        (11.8, 6.8),
    ] {
        builder.place(&lamp, at(x, z, 0.3));
    }

    let bench = builder.prop("bench", furniture::bench(palette));
    for (x, z, turn_rad) in
        [(-11.6, -4.6, FRAC_PI_2), (-5.4, -11.0, 0.05), (-1.2, -9.6, -0.8), (13.2, -4.2, -FRAC_PI_2)]
    {
        builder.place(&bench, at(x, z, turn_rad));
    }

    let barrel = builder.prop("barrel", furniture::barrel(palette));
    for (x, z) in [(9.6, -11.2), (10.35, -11.0), (9.9, -10.45)] {
        builder.place(&barrel, at(x, z, rng.between(0.0, PI)));
    }
    let crate_prop = builder.prop("crate", furniture::crate_box(palette, 0.72));
    for (x, z) in [(6.1, -11.4), (7.0, -11.2), (6.3, -10.5)] {
        builder.place(&crate_prop, at(x, z, rng.about(0.1, 0.25)));
    }
    let upper = Affine3A::from_translation(Vec3::Y * 0.72) * at(6.55, -11.3, 0.6);
    builder.place(&crate_prop, upper);

    builder.put_at("stall", furniture::stall(palette, &mut rng), at(8.0, -9.4, -0.12));
    builder.put_at("stall", furniture::stall(palette, &mut rng), at(3.6, -10.2, 0.1));
    let planter = builder.prop("planter", furniture::planter(palette, &mut rng));
    for (x, z) in [(-7.4, -13.0), (-1.0, -13.0), (14.9, -1.0), (14.9, 3.0), (-14.9, -6.0)] {
        builder.place(&planter, at(x, z, rng.between(0.0, PI)));
    }
    let cloths = [0xd8d0b8, 0x7a2f28, 0xd8d0b8].map(linear_from_hex);
    for ((x, z), cloth) in [(-13.9, -2.6), (-12.6, -7.2), (-14.2, 5.0)].into_iter().zip(cloths) {
        let table = furniture::cafe_table(palette, &mut rng, cloth);
        builder.put_at("café table", table, at(x, z, rng.between(0.0, PI)));
    }
    builder.put_at("fire bowl", furniture::fire_bowl(palette, &mut rng), at(FIRE_BOWL.x, FIRE_BOWL.z, 0.0));
}
