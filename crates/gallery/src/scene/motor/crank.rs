//! What turns and slides: crankshaft, rods, pistons, flywheel.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::{
    assembly::{Assembly, BANK_OFFSET, BORE_RADIUS, CRANK, SPACING},
    kinematics::{clockwise, throws},
};
use crate::{
    builder::Prop,
    kit::mechanical::{Outline, ball, circle, drum, gear, hull, inset, pitch_radius, ring, stand},
    shape::Shape,
};

const PIN_RADIUS: f32 = 0.22;
const MAIN_RADIUS: f32 = 0.27;
/// Half the distance between the webs of a throw: two rods side by side.
const HALF_PIN: f32 = 0.235;
/// Half the width of a rod, a little less than the offset of the banks.
const HALF_ROD: f32 = BANK_OFFSET - 0.008;
/// The timing gear and the pulley sit on this end.
pub(super) const SNOUT_RADIUS: f32 = 0.198;
/// How far it reaches in front of the block, and where the last main journal ends.
pub(super) const SNOUT_END: f32 = 0.99;
const JOURNAL_END: f32 = 0.1;

pub(super) fn put(assembly: &mut Assembly) {
    put_crankshaft(assembly);
    put_rods(assembly);
    put_pistons(assembly);
    put_flywheel(assembly);
}

/// A web with its counterweight opposite the pin, which is at the top.
fn web() -> Outline {
    let pin = circle(Vec2::Y * CRANK.crank_radius, 0.3, 26);
    let weight = (0..=28).map(|i| {
        let turn = PI + (i as f32 / 28.0 - 0.5) * 2.3;
        0.68 * clockwise(turn)
    });
    hull(pin.into_iter().chain(circle(Vec2::ZERO, 0.36, 26)).chain(weight))
}

fn put_crankshaft(assembly: &mut Assembly) {
    let layout = assembly.layout;
    let half = layout.half();
    let part = assembly.part("crankshaft", assembly.finish.dark, |shape| {
        let bar = |shape: &mut Shape, middle: Vec2, radius: f32, low: f32, high: f32| {
            shape.turned(middle.extend(low), Vec3::Z, &[(radius, 0.0), (radius, high - low)], 32);
        };
        for (index, throw) in throws(layout.cylinders).into_iter().enumerate() {
            let z = layout.pin_z(index as u32);
            let outward = CRANK.crank_radius * clockwise(throw);
            bar(shape, outward, PIN_RADIUS, z - HALF_PIN, z + HALF_PIN);
            for low in [z - HALF_PIN - 0.14, z + HALF_PIN] {
                shape.moved(Affine3A::from_rotation_z(-throw), |shape| {
                    let drilled = circle(Vec2::Y * CRANK.crank_radius, 0.09, 14);
                    shape.extrude(&[web(), drilled], low, low + 0.14, 0.016);
                });
            }
        }
        // Main journals between the webs; the ends carry the flywheel and the timing gear.
        let mains: Vec<f32> = layout.main_z().collect();
        let reach = 0.5 * SPACING - HALF_PIN - 0.14;
        for (index, &z) in mains.iter().enumerate() {
            let low = if index + 1 == mains.len() { -half - 0.2 } else { z - reach };
            let high = if index == 0 { half + JOURNAL_END } else { z + reach };
            bar(shape, Vec2::ZERO, MAIN_RADIUS, low, high);
        }
        let length = SNOUT_END - JOURNAL_END;
        shape.turned(
            Vec3::Z * (half + JOURNAL_END),
            Vec3::Z,
            &[
                (MAIN_RADIUS, 0.0),
                (SNOUT_RADIUS, 0.0),
                (SNOUT_RADIUS, length - 0.03),
                (0.17, length),
                (0.0, length),
            ],
            56,
        );
        shape.turned(Vec3::NEG_Z * (half + 0.2), Vec3::NEG_Z, &[(MAIN_RADIUS, 0.0), (0.0, 0.0)], 32);
    });
    assembly.put_turning(&part, Vec3::ZERO, 0.0, 2.0);
}

/// The outline of a rod: a ring at either end of a tapering shank.
fn rod_outline() -> Outline {
    let top = CRANK.rod_length;
    let mut outline = Outline::new();
    let mut arc = |centre: Vec2, radius: f32, from: f32, to: f32, steps: u32| {
        outline.extend(
            (0..=steps)
                .map(|i| centre + radius * Vec2::from_angle(from + (to - from) * i as f32 / steps as f32)),
        );
    };
    // Counter-clockwise from where the shank leaves the big end, at the bolts' shoulders.
    arc(Vec2::ZERO, 0.325, PI - 0.98, TAU + 0.98, 24);
    arc(Vec2::Y * top, 0.175, -0.96, PI + 0.96, 16);
    outline
}

fn draw_rod(shape: &mut Shape) {
    let top = CRANK.rod_length;
    // The flanks of the I-beam stand around a pocket that is closed by a thin web.
    let pocket =
        hull(circle(Vec2::Y * 0.52, 0.115, 12).into_iter().chain(circle(Vec2::Y * (top - 0.3), 0.052, 12)));
    let holes = [circle(Vec2::ZERO, PIN_RADIUS + 0.03, 32), circle(Vec2::Y * top, 0.118, 22)];
    let [big, small] = holes;
    let low = -HALF_ROD;
    shape.extrude(&[rod_outline(), big, small, pocket.clone()], low, HALF_ROD, 0.012);
    shape.extrude(&[inset(&pocket, 0.002)], -0.03, 0.03, 0.0);
    // Bosses of the cap's bolts.
    for side in [-1.0, 1.0] {
        let boss = Vec3::new(side * 0.305, -0.12, 0.0);
        shape.moved(Affine3A::from_translation(boss), |shape| {
            shape.lathe(Vec3::ZERO, &drum(0.062, 0.0, 0.24, 0.012), 14);
            shape.extrude_up(&[circle(Vec2::ZERO, 0.05, 6)], -0.06, -0.004, 0.006);
        });
    }
}

/// Places a part of a connecting rod on each crank pin.
fn put_on_pins(assembly: &mut Assembly, part: &Prop) {
    for cylinder in assembly.layout.cylinders() {
        let tilt = cylinder.bank.tilt_rad();
        assembly.put_led(
            part,
            |crank| Quat::from_rotation_z(-(tilt + CRANK.lean_rad(cylinder.turn_rad(crank)))),
            |crank| (CRANK.crank_radius * clockwise(crank + cylinder.throw_rad)).extend(cylinder.z),
            None,
        );
    }
}

fn put_rods(assembly: &mut Assembly) {
    let finish = assembly.finish;
    let rod = assembly.part("connecting rod", finish.steel, draw_rod);
    let shell = assembly.part("rod bearing", finish.brass, |shape| {
        let half = HALF_ROD - 0.004;
        shape.turned(Vec3::ZERO, Vec3::Z, &ring(PIN_RADIUS + 0.003, PIN_RADIUS + 0.026, -half, half), 32);
        let bush = ring(0.103, 0.114, -half, half);
        shape.turned(Vec3::Y * CRANK.rod_length, Vec3::Z, &bush, 22);
    });
    put_on_pins(assembly, &rod);
    put_on_pins(assembly, &shell);
}

/// Bottom and top of the ring grooves above the pin.
const GROOVES: [(f32, f32); 3] = [(0.255, 0.279), (0.195, 0.219), (0.12, 0.154)];

fn draw_piston(shape: &mut Shape) {
    const SKIRT: f32 = BORE_RADIUS - 0.004;
    const GROOVE: f32 = BORE_RADIUS - 0.05;
    let mut profile = vec![(0.0, 0.235), (0.30, 0.225), (0.345, 0.17), (0.40, 0.08), (0.42, -0.28)];
    profile.extend([(SKIRT - 0.01, -0.28), (SKIRT, -0.26)]);
    for &(low, high) in GROOVES.iter().rev() {
        profile.extend([(SKIRT, low), (GROOVE, low), (GROOVE, high), (SKIRT, high)]);
    }
    // A shallow dish in the crown.
    profile.extend([(SKIRT, 0.322), (SKIRT - 0.012, 0.334), (0.36, 0.334), (0.30, 0.312), (0.0, 0.306)]);
    shape.lathe(Vec3::ZERO, &profile, 34);
    // Bosses that hold the pin.
    for low in [-0.385, 0.155] {
        shape.turned(Vec3::Z * low, Vec3::Z, &ring(0.104, 0.165, 0.0, 0.23), 18);
    }
}

fn put_pistons(assembly: &mut Assembly) {
    let finish = assembly.finish;
    let piston = assembly.part("piston", finish.cast, draw_piston);
    let rings = assembly.part("piston rings", finish.dark, |shape| {
        for (low, high) in GROOVES {
            let section = ring(BORE_RADIUS - 0.045, BORE_RADIUS - 0.001, low + 0.003, high - 0.003);
            shape.lathe(Vec3::ZERO, &section, 34);
        }
    });
    let pin = assembly.part("piston pin", finish.steel, |shape| {
        shape.turned(Vec3::ZERO, Vec3::Z, &ring(0.055, 0.1, -0.37, 0.37), 18);
    });
    for part in [piston, rings, pin] {
        for cylinder in assembly.layout.cylinders() {
            let world = cylinder.bank.to_world();
            let upright = Quat::from_rotation_z(-cylinder.bank.tilt_rad());
            assembly.put_led(
                &part,
                |_| upright,
                |crank| {
                    let height = CRANK.height(cylinder.turn_rad(crank));
                    world.transform_point3(Vec3::new(0.0, height, cylinder.z))
                },
                None,
            );
        }
    }
}

/// Teeth of the ring gear and their module: as large as the bell housing takes.
const RING_TEETH: u32 = 132;
const RING_MODULE: f32 = 0.019;

fn put_flywheel(assembly: &mut Assembly) {
    let (half, finish) = (assembly.layout.half(), assembly.finish);
    let back = -half - 0.205;
    let rim = pitch_radius(RING_TEETH, RING_MODULE) - 0.06;
    let flywheel = assembly.part("flywheel", finish.steel, |shape| {
        let mut outlines = vec![circle(Vec2::ZERO, rim - 0.004, 80), circle(Vec2::ZERO, 0.16, 22)];
        outlines.extend((0..8).map(|i| circle(0.74 * clockwise(TAU * (i as f32 + 0.5) / 8.0), 0.13, 18)));
        shape.extrude(&outlines, back - 0.16, back - 0.005, 0.02);
    });
    let ring_gear = assembly.part("ring gear", finish.dark, |shape| {
        let outlines = [gear(RING_TEETH, RING_MODULE), circle(Vec2::ZERO, rim, 80)];
        shape.extrude(&outlines, back - 0.13, back - 0.03, 0.0);
    });
    for part in [&flywheel, &ring_gear] {
        assembly.put_turning(part, Vec3::ZERO, 0.0, 2.0);
    }
    put_clutch(assembly, back);
}

fn put_clutch(assembly: &mut Assembly, back: f32) {
    let finish = assembly.finish;
    let clutch = assembly.part("clutch", finish.blue, |shape| {
        let profile = [
            (0.30, -0.36),
            (0.34, -0.40),
            (0.62, -0.36),
            (0.80, -0.27),
            (0.95, -0.23),
            (0.95, -0.17),
            (0.88, -0.17),
            (0.76, -0.21),
            (0.60, -0.30),
            (0.30, -0.36),
        ];
        shape.turned(Vec3::Z * back, Vec3::Z, &profile, 54);
        // The fingers of the diaphragm spring.
        for i in 0..18 {
            let turn = TAU * i as f32 / 18.0;
            let (inner, outer) = (clockwise(turn) * 0.12, clockwise(turn) * 0.31);
            shape.beam(
                inner.extend(back - 0.43),
                outer.extend(back - 0.39),
                clockwise(turn + 0.5 * PI).extend(0.0),
                0.035,
                0.012,
            );
        }
    });
    let bearing = assembly.part("release bearing", finish.brass, |shape| {
        shape.turned(Vec3::Z * (back - 0.56), Vec3::Z, &ring(0.1, 0.17, 0.0, 0.1), 26);
        for i in 0..12 {
            let place = clockwise(TAU * i as f32 / 12.0) * 0.135;
            shape.turned(place.extend(back - 0.44), Vec3::Z, &ball(0.014, 6), 8);
        }
    });
    for part in [&clutch, &bearing] {
        assembly.put_turning(part, Vec3::ZERO, 0.0, 2.0);
    }
    let bolts = assembly.part("flywheel bolts", finish.brass, |shape| {
        for i in 0..8 {
            let place = clockwise(TAU * i as f32 / 8.0);
            for (radius, depth) in [(0.225, -0.165), (0.915, -0.235)] {
                let seat = (place * radius).extend(back + depth);
                shape.moved(stand(seat, Vec3::NEG_Z), |shape| {
                    shape.extrude_up(&[circle(Vec2::ZERO, 0.042, 6)], 0.0, 0.04, 0.006);
                });
            }
        }
    });
    assembly.put_turning(&bolts, Vec3::ZERO, 0.0, 2.0);
}
