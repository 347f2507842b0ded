//! The crankcase: walls, bulkheads, decks with their liners, the oil pan and the stand.

use glam::{Affine3A, Vec2, Vec3};

use super::assembly::{Assembly, BANK_OFFSET, BANKS, BORE_RADIUS, DECK};
use crate::kit::mechanical::{Outline, circle, drum, inset, ring, rounded, rounded_rectangle, wall};

/// Height of the joint between crankcase and pan.
const RAIL: f32 = -0.36;
/// Parts that touch are this far apart, so that no two faces coincide.
pub(super) const GAP: f32 = 0.005;

pub(super) fn put(assembly: &mut Assembly) {
    put_walls(assembly);
    put_bulkheads(assembly);
    put_decks(assembly);
    put_pan(assembly);
    put_stand(assembly);
}

/// A plate of a bank with a hole for each bore; holes are offset with their bank, so that the two banks'
/// plates differ.
pub(super) fn bored(assembly: &Assembly, side: f32, half_width: f32, bore: f32) -> Vec<Outline> {
    let layout = assembly.layout;
    let mut outlines = vec![rounded_rectangle(Vec2::new(half_width, layout.half()), 0.12)];
    // Outlines of what is extruded upwards give x and -z.
    outlines.extend(
        (0..layout.cylinders)
            .map(|i| circle(Vec2::new(0.0, -layout.pin_z(i) - side * BANK_OFFSET), bore, 36)),
    );
    outlines
}

fn put_walls(assembly: &mut Assembly) {
    let (half, cast) = (assembly.layout.half(), assembly.finish.cast);
    let right = BANKS[0];
    let outer = [
        Vec2::new(1.08, RAIL + GAP),
        Vec2::new(1.08, 0.16),
        right.point(Vec2::new(0.62, 1.02)),
        right.point(Vec2::new(0.62, 2.2 - GAP)),
    ];
    let outline = wall(&outer, 0.09);
    let part = assembly.part("crankcase wall", cast, |shape| {
        shape.extrude(&[outline], -half, half, 0.015);
    });
    for bank in BANKS {
        assembly.builder.place(&part, Affine3A::from_scale(Vec3::new(bank.side, 1.0, 1.0)));
    }
    let inner = |bank: usize, y: f32| BANKS[bank].point(Vec2::new(-0.62, y));
    let valley =
        [inner(0, 2.2 - GAP), inner(0, 0.86), Vec2::new(0.0, 0.98), inner(1, 0.86), inner(1, 2.2 - GAP)];
    assembly.put("valley", cast, |shape| {
        shape.extrude(&[wall(&valley, 0.09)], -half, half, 0.015);
    });
    // Ribs stiffen the skirt between the main bearings.
    let foot = [
        Vec2::new(1.13, RAIL + 0.02),
        Vec2::new(1.34, RAIL + 0.02),
        Vec2::new(1.30, RAIL + 0.16),
        outer[2] + Vec2::new(0.05, -0.16),
        Vec2::new(1.13, 0.12),
    ];
    let places: Vec<f32> = assembly.layout.main_z().collect();
    for side in [1.0, -1.0] {
        assembly.put("ribs", cast, |shape| {
            for &z in &places {
                let z = z.clamp(-half + 0.06, half - 0.06);
                let rib = foot.iter().map(|p| Vec2::new(side * p.x, p.y)).collect();
                shape.extrude(&[rib], z - 0.03, z + 0.03, 0.008);
            }
        });
    }
}

fn put_bulkheads(assembly: &mut Assembly) {
    let (half, cast, brass) = (assembly.layout.half(), assembly.finish.cast, assembly.finish.brass);
    let mirrored = |right: &[Vec2]| -> Outline {
        right.iter().copied().chain(right.iter().rev().map(|p| Vec2::new(-p.x, p.y))).collect()
    };
    let web = rounded(
        &mirrored(&[
            Vec2::new(0.62, RAIL - 0.12),
            Vec2::new(1.02, RAIL + 0.04),
            Vec2::new(1.02, 0.16),
            Vec2::new(0.62, 0.66),
            Vec2::new(0.24, 0.86),
        ]),
        0.08,
        4,
    );
    let mut outlines = vec![web, circle(Vec2::ZERO, 0.335, 36)];
    for side in [1.0, -1.0] {
        outlines.push(circle(Vec2::new(0.66 * side, 0.24), 0.13, 18));
    }
    let part = assembly.part("bulkhead", cast, |shape| shape.extrude(&outlines, -0.09, 0.09, 0.02));
    let shell = assembly.part("main bearing", brass, |shape| {
        shape.turned(Vec3::ZERO, Vec3::Z, &ring(0.273, 0.331, -0.1, 0.1), 36);
    });
    let places: Vec<f32> = assembly.layout.main_z().collect();
    for &z in &places {
        // The outer ones stand inside the end plates.
        let z = z.clamp(-half + 0.1, half - 0.1);
        assembly.builder.place(&part, Affine3A::from_translation(Vec3::Z * z));
        assembly.builder.place(&shell, Affine3A::from_translation(Vec3::Z * z));
        for x in [-0.46, 0.46] {
            assembly.bolt(Vec3::new(x, RAIL - 0.125, z), Vec3::NEG_Y, 0.045);
        }
    }
    let right = BANKS[0];
    let face = mirrored(&[
        Vec2::new(1.1, RAIL + GAP),
        Vec2::new(1.12, 0.14),
        right.point(Vec2::new(0.66, 1.0)),
        right.point(Vec2::new(0.66, DECK - 0.01)),
        right.point(Vec2::new(-0.66, DECK - 0.01)),
        right.point(Vec2::new(-0.66, 0.95)),
    ]);
    let face = [face, circle(Vec2::ZERO, 0.3, 36)];
    assembly.put("front plate", cast, |shape| shape.extrude(&face, half + GAP, half + 0.06, 0.012));
    assembly.put("rear plate", cast, |shape| shape.extrude(&face, -half - 0.06, -half - GAP, 0.012));
}

fn put_decks(assembly: &mut Assembly) {
    let finish = assembly.finish;
    let liner = assembly.part("liner", finish.steel, |shape| {
        let profile = [
            (BORE_RADIUS, 0.98),
            (0.495, 0.98),
            (0.495, 1.6),
            (0.515, 1.62),
            (0.515, DECK - 0.03),
            (BORE_RADIUS, DECK - 0.03),
            (BORE_RADIUS, 0.98),
        ];
        shape.lathe(Vec3::ZERO, &profile, 40);
    });
    for bank in BANKS {
        // Already mirrored by the bank, which does not touch z.
        let deck = bored(assembly, bank.side, 0.66, 0.52);
        let gasket = bored(assembly, bank.side, 0.65, 0.475);
        let part = assembly.part("deck", finish.cast, |shape| shape.extrude_up(&deck, 2.2, DECK, 0.012));
        assembly.builder.place(&part, bank.to_world());
        let part = assembly.part("head gasket", finish.copper, |shape| {
            shape.extrude_up(&gasket, DECK + GAP, DECK + 0.018, 0.0);
        });
        assembly.builder.place(&part, bank.to_world());
    }
    for cylinder in assembly.layout.cylinders() {
        let place = cylinder.bank.to_world() * Affine3A::from_translation(Vec3::Z * cylinder.z);
        assembly.builder.place(&liner, place);
    }
}

fn put_pan(assembly: &mut Assembly) {
    let (half, finish) = (assembly.layout.half(), assembly.finish);
    let section = rounded(
        &[
            Vec2::new(1.0, RAIL - 0.07),
            Vec2::new(-1.0, RAIL - 0.07),
            Vec2::new(-0.94, -1.0),
            Vec2::new(-0.6, -1.34),
            Vec2::new(0.6, -1.34),
            Vec2::new(0.94, -1.0),
        ],
        0.14,
        5,
    );
    assembly.put("oil pan", finish.blue, |shape| {
        shape.extrude(&[section.clone(), inset(&section, 0.045)], -half + 0.06, half - 0.06, 0.012);
        for z in [-half, half - 0.05] {
            shape.extrude(std::slice::from_ref(&section), z, z + 0.05, 0.012);
        }
    });
    let outside = rounded_rectangle(Vec2::new(1.34, half + 0.06), 0.12);
    let inside = rounded_rectangle(Vec2::new(1.0, half - 0.16), 0.08);
    assembly.put("pan flange", finish.blue, |shape| {
        shape.extrude_up(&[outside, inside], RAIL - 0.065, RAIL - 0.005, 0.012);
    });
    let count = 3 * assembly.layout.cylinders + 1;
    for i in 0..count {
        let z = (i as f32 / (count - 1) as f32 - 0.5) * 2.0 * (half - 0.14);
        for x in [-1.24, 1.24] {
            assembly.bolt(Vec3::new(x, RAIL - 0.068, z), Vec3::NEG_Y, 0.035);
        }
    }
    assembly.bolt(Vec3::new(0.3, -1.345, half - 0.5), Vec3::NEG_Y, 0.075);
}

/// Four posts on a round plate: an engine does not float.
fn put_stand(assembly: &mut Assembly) {
    let (half, finish) = (assembly.layout.half(), assembly.finish);
    let post = assembly.part("post", finish.dark, |shape| {
        let profile = [
            (0.0, 0.0),
            (0.26, 0.0),
            (0.26, 0.05),
            (0.12, 0.09),
            (0.09, 0.2),
            (0.09, 1.2),
            (0.13, 1.26),
            (0.13, 1.3),
            (0.0, 1.3),
        ];
        shape.lathe(Vec3::ZERO, &profile, 22);
    });
    for (x, z) in [(-1.2, -1.0), (1.2, -1.0), (-1.2, 1.0), (1.2, 1.0)] {
        let foot = Vec3::new(x, RAIL - 0.07 - 1.3 - 0.08, z * (half - 0.3));
        assembly.builder.place(&post, Affine3A::from_translation(foot));
    }
    assembly.put("plinth", finish.slate, |shape| {
        let top = RAIL - 0.07 - 1.3 - 0.09;
        shape.lathe(Vec3::ZERO, &drum(1.9 + half, top - 0.16, top, 0.03), 108);
    });
}
