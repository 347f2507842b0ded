//! What the belt drives: pulleys, alternator, coolant pump with its fan, compressor; and the oil filter.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::{
    assembly::Assembly,
    block::GAP,
    crank::{SNOUT_END, SNOUT_RADIUS},
    kinematics::clockwise,
    timing::COVER_FACE,
};
use crate::{
    builder::Prop,
    kit::mechanical::{Outline, circle, drum, hull, ring, stand},
    shape::Shape,
};

/// Middle and radius of a pulley; whole turns a cycle, so that the clip closes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pulley {
    pub(super) centre: Vec2,
    pub(super) radius: f32,
    pub(super) turns: f32,
}

pub(super) const CRANK_PULLEY: Pulley = Pulley { centre: Vec2::ZERO, radius: 0.48, turns: 2.0 };
pub(super) const ALTERNATOR: Pulley = Pulley { centre: Vec2::new(-1.62, -0.28), radius: 0.24, turns: 4.0 };
pub(super) const COMPRESSOR: Pulley = Pulley { centre: Vec2::new(1.62, -0.28), radius: 0.32, turns: 3.0 };
pub(super) const PUMP: Pulley = Pulley { centre: Vec2::new(0.0, 1.36), radius: 0.48, turns: 2.0 };
pub(super) const PULLEYS: [Pulley; 4] = [CRANK_PULLEY, ALTERNATOR, COMPRESSOR, PUMP];

/// Ribs of the belt and the depth of their grooves.
const RIBS: u32 = 6;
const RIB: f32 = 0.034;
const GROOVE: f32 = 0.026;
const BELT_WIDTH: f32 = RIBS as f32 * RIB;

/// The belt's middle, in front of the block: clears the timing cover.
const BELT_PLANE: f32 = 0.66;

pub(super) fn put(assembly: &mut Assembly) {
    let plane = assembly.layout.half() + BELT_PLANE;
    put_pulleys(assembly, plane);
    put_belt(assembly, plane);
    put_fan(assembly, plane);
    put_alternator(assembly, plane);
    put_compressor(assembly, plane);
    put_filter(assembly);
}

/// A grooved rim on a web with holes; the hub is bored.
fn draw_pulley(shape: &mut Shape, radius: f32, bore: f32) {
    let half = 0.5 * BELT_WIDTH;
    let inside = radius - 0.1;
    let mut profile = vec![(inside, -half - 0.03), (radius + 0.02, -half - 0.03), (radius + 0.02, -half)];
    for rib in 0..RIBS {
        let low = -half + rib as f32 * RIB;
        profile.extend([
            (radius, low + 0.004),
            (radius - GROOVE, low + 0.5 * RIB),
            (radius, low + RIB - 0.004),
        ]);
    }
    profile.extend([
        (radius + 0.02, half),
        (radius + 0.02, half + 0.03),
        (inside, half + 0.03),
        (inside, -half - 0.03),
    ]);
    shape.turned(Vec3::ZERO, Vec3::Z, &profile, 32);
    let hub = bore + 0.06;
    let mut web = vec![circle(Vec2::ZERO, inside - 0.002, 40), circle(Vec2::ZERO, hub + 0.002, 22)];
    let (middle, size) = (0.5 * (inside + hub), 0.36 * (inside - hub));
    if size > 0.03 {
        web.extend((0..5).map(|i| circle(middle * clockwise(TAU * i as f32 / 5.0), size, 16)));
    }
    shape.extrude(&web, -0.03, 0.03, 0.006);
    shape.turned(Vec3::ZERO, Vec3::Z, &ring(bore, hub, -half, half), 22);
}

fn put_pulleys(assembly: &mut Assembly, plane: f32) {
    let finish = assembly.finish;
    for (pulley, bore) in PULLEYS.into_iter().zip([SNOUT_RADIUS + 0.003, 0.07, 0.07, 0.1]) {
        let part = assembly.part("pulley", finish.steel, |shape| draw_pulley(shape, pulley.radius, bore));
        assembly.put_turning(&part, pulley.centre.extend(plane), 0.0, pulley.turns);
    }
    let bolt = assembly.part("pulley bolt", finish.brass, |shape| {
        shape.turned(Vec3::Z * 0.01, Vec3::Z, &drum(0.23, 0.0, 0.04, 0.01), 22);
        shape.extrude(&[circle(Vec2::ZERO, 0.15, 6)], 0.055, 0.17, 0.015);
    });
    let front = assembly.layout.half() + SNOUT_END;
    assembly.put_turning(&bolt, Vec3::Z * front, 0.0, 2.0);
}

/// The belt lies on its pulleys like the hull of their circles.
fn put_belt(assembly: &mut Assembly, plane: f32) {
    let around = |lift: f32| -> Outline {
        hull(PULLEYS.iter().flat_map(|pulley| circle(pulley.centre, pulley.radius + lift, 90)))
    };
    let half = 0.5 * BELT_WIDTH - 0.006;
    let outlines = [around(0.045), around(0.004)];
    assembly.put("belt", assembly.finish.accent, |shape| {
        shape.extrude(&outlines, plane - half, plane + half, 0.006);
    });
}

fn draw_fan(shape: &mut Shape) {
    const BLADES: u32 = 9;
    shape.turned(Vec3::ZERO, Vec3::Z, &drum(0.24, 0.0, 0.16, 0.03), 26);
    for blade in 0..BLADES {
        let start = TAU * blade as f32 / BLADES as f32;
        // A swept blade, its pitch falling off towards the tip, of even thickness.
        let point = |out: f32, across: f32, lift: f32| {
            let radius = 0.22 + 0.78 * out;
            let pitch = 0.75 - 0.3 * out;
            let chord = 0.36 - 0.04 * (2.0 * out - 1.0).powi(2);
            let turn = start + 0.30 * out * out + (across - 0.5) * chord * pitch.cos() / radius;
            (clockwise(turn) * radius).extend(0.08 + (across - 0.5) * chord * pitch.sin() + lift)
        };
        let mut face = |lift: f32, flip: bool| {
            for o in 0..8 {
                for a in 0..4 {
                    let (out, across) = (o as f32 / 8.0, a as f32 / 4.0);
                    let [p, q, r, s] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                        .map(|(i, j)| point(out + i / 8.0, across + j / 4.0, lift));
                    shape.quad(if flip { [s, r, q, p] } else { [p, q, r, s] });
                }
            }
        };
        face(0.0, false);
        face(0.018, true);
        for o in 0..8 {
            let (low, high) = (o as f32 / 8.0, (o + 1) as f32 / 8.0);
            for across in [0.0, 1.0] {
                let edge = [
                    point(low, across, 0.0),
                    point(high, across, 0.0),
                    point(high, across, 0.018),
                    point(low, across, 0.018),
                ];
                let [p, q, r, s] = edge;
                shape.quad(if across > 0.5 { edge } else { [s, r, q, p] });
            }
        }
    }
}

fn put_fan(assembly: &mut Assembly, plane: f32) {
    let finish = assembly.finish;
    let fan = assembly.part("fan", finish.blue, draw_fan);
    assembly.put_turning(&fan, PUMP.centre.extend(plane + 0.2), 0.0, PUMP.turns);
    let front = assembly.layout.half() + COVER_FACE + GAP;
    assembly.put("coolant pump", finish.cast, |shape| {
        let profile =
            [(0.104, 0.0), (0.36, 0.0), (0.36, 0.05), (0.2, 0.06), (0.17, 0.09), (0.104, 0.09), (0.104, 0.0)];
        shape.turned(PUMP.centre.extend(front), Vec3::Z, &profile, 26);
    });
    let shaft: Prop = assembly.part("pump shaft", finish.dark, |shape| {
        shape.turned(Vec3::Z * -0.2, Vec3::Z, &drum(0.098, 0.0, 0.395, 0.01), 18);
    });
    assembly.put_turning(&shaft, PUMP.centre.extend(plane), 0.0, PUMP.turns);
}

fn put_alternator(assembly: &mut Assembly, plane: f32) {
    let finish = assembly.finish;
    let at = ALTERNATOR.centre;
    let back = plane - 0.95;
    assembly.put("alternator", finish.cast, |shape| {
        let profile = [
            (0.1, 0.0),
            (0.36, 0.0),
            (0.42, 0.06),
            (0.42, 0.22),
            (0.40, 0.23),
            (0.40, 0.5),
            (0.42, 0.51),
            (0.42, 0.66),
            (0.34, 0.74),
            (0.1, 0.76),
            (0.1, 0.70),
            (0.32, 0.68),
            (0.36, 0.62),
            (0.36, 0.07),
            (0.1, 0.05),
            (0.1, 0.0),
        ];
        shape.turned(at.extend(back), Vec3::Z, &profile, 36);
    });
    assembly.put("windings", finish.copper, |shape| {
        for i in 0..18 {
            let middle = 0.29 * clockwise(TAU * i as f32 / 18.0);
            let points: Vec<Vec3> = (0..=14)
                .map(|step| {
                    let turn = TAU * step as f32 / 14.0;
                    let out = middle.normalize() * 0.035 * turn.cos();
                    (at + middle + out).extend(back + 0.37 + 0.2 * turn.sin())
                })
                .collect();
            shape.pipe(&points, 0.017, 6);
        }
    });
    let rotor = assembly.part("rotor", finish.dark, |shape| {
        shape.turned(Vec3::Z * 0.08, Vec3::Z, &drum(0.068, 0.0, 0.95, 0.01), 16);
        shape.turned(Vec3::Z * 0.24, Vec3::Z, &ring(0.07, 0.15, 0.0, 0.24), 22);
        for i in 0..12 {
            // Claws of either pole in turn.
            let turn = TAU * i as f32 / 12.0;
            let (from, to) = if i % 2 == 0 { (0.22, 0.47) } else { (0.5, 0.25) };
            let place = 0.195 * clockwise(turn);
            shape.beam(
                place.extend(from),
                place.extend(to),
                clockwise(turn + 0.5 * PI).extend(0.0),
                0.06,
                0.05,
            );
        }
    });
    assembly.put_turning(&rotor, at.extend(back), 0.0, ALTERNATOR.turns);
    put_bracket(assembly, at, back + 0.3);
}

/// An arm from the crankcase to what hangs beside it.
fn put_bracket(assembly: &mut Assembly, at: Vec2, z: f32) {
    let side = at.x.signum();
    let arm = hull(
        circle(Vec2::new(side * 1.16, 0.05), 0.1, 14)
            .into_iter()
            .chain(circle(Vec2::new(side * 1.16, -0.2), 0.1, 14))
            .chain(circle(at, 0.48, 26)),
    );
    let outlines = [arm, circle(at, 0.425, 32)];
    assembly.put("bracket", assembly.finish.dark, |shape| shape.extrude(&outlines, z - 0.04, z + 0.04, 0.01));
}

fn put_compressor(assembly: &mut Assembly, plane: f32) {
    let finish = assembly.finish;
    let at = COMPRESSOR.centre;
    let back = plane - 1.25;
    assembly.put("compressor", finish.blue, |shape| {
        let mut profile = vec![(0.0, 0.0), (0.34, 0.0), (0.38, 0.04)];
        for i in 0..6 {
            // Ribs that cool the housing.
            let low = 0.1 + 0.13 * i as f32;
            profile.extend([(0.38, low), (0.42, low + 0.01), (0.42, low + 0.05), (0.38, low + 0.06)]);
        }
        profile.extend([(0.38, 0.92), (0.3, 1.0), (0.2, 1.02), (0.0, 1.02)]);
        shape.turned(at.extend(back), Vec3::Z, &profile, 36);
    });
    let shaft = assembly.part("compressor shaft", finish.steel, |shape| {
        shape.turned(Vec3::Z * -0.2, Vec3::Z, &drum(0.068, 0.0, 0.36, 0.01), 16);
    });
    assembly.put_turning(&shaft, at.extend(plane), 0.0, COMPRESSOR.turns);
    put_bracket(assembly, at, back + 0.55);
}

fn put_filter(assembly: &mut Assembly) {
    let (half, finish) = (assembly.layout.half(), assembly.finish);
    let foot = Vec3::new(1.14, -0.1, -half + 0.65);
    let axis = Vec3::new(1.0, -0.35, 0.0);
    assembly.put("oil filter", finish.accent, |shape| {
        let mut profile =
            vec![(0.0, 0.06), (0.27, 0.06), (0.285, 0.075), (0.285, 0.12), (0.27, 0.135), (0.27, 0.75)];
        profile.extend((0..=6).map(|i| {
            let (sin, cos) = (0.5 * PI * i as f32 / 6.0).sin_cos();
            (0.19 + 0.08 * cos, 0.75 + 0.08 * sin)
        }));
        profile.push((0.0, 0.84));
        shape.turned(foot, axis, &profile, 32);
        shape.moved(stand(foot, axis), |shape| {
            shape.extrude_up(&[circle(Vec2::ZERO, 0.1, 6)], 0.845, 0.9, 0.01);
        });
    });
    assembly.put("filter foot", finish.cast, |shape| {
        shape.turned(foot, axis, &drum(0.22, 0.0, 0.055, 0.01), 26);
    });
}
