//! Intake and exhaust: the plenum in the valley, its runners, the manifolds and the turbochargers they drive.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Vec2, Vec3};

use super::{
    assembly::{Assembly, BANKS, Bank},
    head::flange,
    kinematics::clockwise,
    valves::{EXHAUST, INTAKE},
};
use crate::{
    kit::mechanical::{ball, bend, circle, drum, ring, rounded_rectangle, stand},
    shape::Shape,
};

/// Axis of the plenum, above the valley.
const PLENUM: Vec2 = Vec2::new(0.0, 3.32);
const PLENUM_RADIUS: f32 = 0.4;
/// Axis of the right exhaust collector.
const COLLECTOR: Vec2 = Vec2::new(3.12, 0.5);
/// Middle of the right turbocharger, behind the collector.
const TURBO: Vec2 = Vec2::new(3.12, 1.55);
/// Turns in a cycle: a real one makes thousands; this one can be watched.
const TURBO_TURNS: f32 = 8.0;

pub(super) fn put(assembly: &mut Assembly) {
    put_plenum(assembly);
    put_runners(assembly);
    put_exhaust(assembly);
    put_turbos(assembly);
}

fn put_plenum(assembly: &mut Assembly) {
    let (half, finish) = (assembly.layout.half(), assembly.finish);
    let (back, front) = (-half + 0.15, half - 0.3);
    assembly.put("plenum", finish.blue, |shape| {
        // Domed at the back, drawn in to the throttle at the front.
        let mut profile: Vec<(f32, f32)> = (0..=10)
            .map(|i| {
                let (sin, cos) = (0.5 * PI * i as f32 / 10.0).sin_cos();
                (PLENUM_RADIUS * sin, back + 0.3 * (1.0 - cos))
            })
            .collect();
        for i in 0..5 {
            // Beads stiffen the drum.
            let z = back + 0.5 + (front - back - 0.9) * i as f32 / 4.0;
            profile.extend([
                (PLENUM_RADIUS, z - 0.05),
                (PLENUM_RADIUS + 0.025, z - 0.02),
                (PLENUM_RADIUS + 0.025, z + 0.02),
                (PLENUM_RADIUS, z + 0.05),
            ]);
        }
        profile.extend((0..=8).map(|i| {
            let s = i as f32 / 8.0;
            (PLENUM_RADIUS - 0.16 * s * s * (3.0 - 2.0 * s), front - 0.25 + 0.25 * s)
        }));
        shape.turned(PLENUM.extend(0.0), Vec3::Z, &profile, 44);
    });
    assembly.put("throttle body", finish.steel, |shape| {
        let place = Affine3A::from_translation(PLENUM.extend(front + 0.01));
        shape.moved(place, |shape| {
            let plate = [rounded_rectangle(Vec2::splat(0.3), 0.08), circle(Vec2::ZERO, 0.225, 26)];
            shape.extrude(&plate, 0.0, 0.06, 0.012);
            shape.turned(Vec3::ZERO, Vec3::Z, &ring(0.225, 0.26, 0.065, 0.45), 32);
            shape.turned(Vec3::Z * 0.45, Vec3::Z, &ring(0.225, 0.285, 0.005, 0.06), 32);
        });
    });
    assembly.put("throttle", finish.brass, |shape| {
        let tilted = Affine3A::from_translation(PLENUM.extend(front + 0.28)) * Affine3A::from_rotation_x(0.6);
        shape.moved(tilted, |shape| {
            shape.turned(Vec3::ZERO, Vec3::Z, &drum(0.219, -0.008, 0.008, 0.003), 26);
            shape.turned(Vec3::NEG_X * 0.33, Vec3::X, &drum(0.02, 0.0, 0.66, 0.004), 12);
        });
    });
    for (x, y) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        let seat = (PLENUM + 0.235 * Vec2::new(x, y)).extend(front + 0.075);
        assembly.bolt(seat, Vec3::Z, 0.03);
    }
}

fn put_runners(assembly: &mut Assembly) {
    let finish = assembly.finish;
    for cylinder in assembly.layout.cylinders() {
        let world = cylinder.bank.to_world() * Affine3A::from_translation(Vec3::Z * cylinder.z);
        let (mouth, out) = flange(INTAKE);
        let (mouth, out) = (world.transform_point3(mouth), world.transform_vector3(out));
        // It leaves the plenum tangentially and falls into the port.
        let side = cylinder.bank.side;
        let root =
            PLENUM.extend(cylinder.z) + Vec3::new(0.8 * side, 0.45, 0.0).normalize() * (PLENUM_RADIUS - 0.02);
        let path = [
            root,
            root + Vec3::new(0.32 * side, 0.14, 0.0),
            mouth + out * 0.34 + Vec3::Y * 0.06,
            mouth + out * 0.06,
        ];
        assembly.put("runner", finish.blue, |shape| {
            shape.pipe(&bend(&path, 6), 0.145, 18);
        });
        assembly.put("runner flange", finish.steel, |shape| {
            shape.turned(mouth + out * 0.055, out, &ring(0.147, 0.21, 0.0, 0.05), 22);
        });
        // An injector stands on each runner.
        assembly.put("injector", finish.brass, |shape| {
            let foot = mouth + out * 0.38 + Vec3::new(0.02 * side, 0.2, 0.0);
            let profile = [
                (0.0, 0.0),
                (0.03, 0.0),
                (0.03, 0.1),
                (0.055, 0.11),
                (0.055, 0.28),
                (0.035, 0.29),
                (0.035, 0.36),
                (0.0, 0.36),
            ];
            shape.turned(foot, Vec3::new(0.1 * side, 1.0, 0.0), &profile, 14);
        });
    }
    let half = assembly.layout.half();
    for bank in BANKS {
        let (mouth, out) = flange(INTAKE);
        let at = bank.to_world().transform_point3(mouth + out * 0.38);
        let axis = Vec2::new(at.x + 0.06 * bank.side, at.y + 0.59);
        assembly.put("fuel rail", finish.copper, |shape| {
            shape.turned(axis.extend(-half + 0.2), Vec3::Z, &drum(0.055, 0.0, 2.0 * half - 0.5, 0.015), 16);
        });
    }
}

/// The map to the side of a bank of what is drawn on the right: the identity, or the mirror image.
fn mirror(bank: Bank) -> Affine3A {
    Affine3A::from_scale(Vec3::new(bank.side, 1.0, 1.0))
}

fn put_exhaust(assembly: &mut Assembly) {
    let (half, finish) = (assembly.layout.half(), assembly.finish);
    for cylinder in assembly.layout.cylinders() {
        let (mouth, out) = flange(EXHAUST);
        let right = BANKS[0].to_world();
        let (mouth, out) = (right.transform_point3(mouth).with_z(cylinder.z), right.transform_vector3(out));
        let path = [
            mouth + out * 0.055,
            mouth + out * 0.24,
            mouth + Vec3::new(0.42, -0.46, -0.1),
            COLLECTOR.extend(cylinder.z - 0.32) + Vec3::new(0.0, 0.17, 0.0),
        ];
        let part = assembly.part("exhaust primary", finish.orange, |shape| {
            shape.pipe(&bend(&path, 6), 0.15, 18);
            shape.turned(mouth + out * 0.056, out, &ring(0.152, 0.2, 0.0, 0.03), 20);
        });
        assembly.builder.place(&part, mirror(cylinder.bank));
    }
    let last = assembly.layout.pin_z(assembly.layout.cylinders - 1);
    let first = assembly.layout.pin_z(0);
    let [turbine, _] = housings(assembly);
    let (mouth, out) = TURBINE.mouth();
    let (mouth, out) = (turbine.transform_point3(mouth), turbine.transform_vector3(out));
    let part = assembly.part("collector", finish.orange, |shape| {
        let path = [
            COLLECTOR.extend(first + 0.15),
            COLLECTOR.extend(0.5 * (first + last) - 0.2),
            COLLECTOR.extend(last - 0.4),
            COLLECTOR.extend(-half - 0.2) + Vec3::new(0.16, 0.04, 0.0),
            mouth + out * 0.45,
            mouth + out * 0.01,
        ];
        shape.pipe(&bend(&path, 7), TURBINE.widest, 22);
        shape.turned(mouth, out, &ring(TURBINE.widest + 0.004, TURBINE.widest + 0.07, 0.0, 0.05), 22);
    });
    for bank in BANKS {
        assembly.builder.place(&part, mirror(bank));
    }
}

/// A housing that winds around a wheel, in the x-y plane: a pipe that widens as it goes around and ends along
/// the tangent.
#[derive(Clone, Copy, Debug)]
struct Volute {
    /// Radius of the chamber of the wheel.
    radius: f32,
    /// Bore of its mouth.
    widest: f32,
    /// Length of the straight piece before the mouth.
    outlet: f32,
}

const TURBINE: Volute = Volute { radius: 0.33, widest: 0.2, outlet: 0.12 };
const COMPRESSOR: Volute = Volute { radius: 0.36, widest: 0.15, outlet: 0.3 };

impl Volute {
    fn points(self) -> Vec<(Vec3, f32)> {
        let steps = 44;
        let mut points: Vec<(Vec3, f32)> = (0..=steps)
            .map(|i| {
                let s = i as f32 / steps as f32;
                let bore = self.widest * (0.25 + 0.75 * s);
                let middle = (self.radius + bore) * clockwise(TAU * (0.94 * s - 0.25));
                (middle.extend(0.0), bore)
            })
            .collect();
        let (last, before) = (points[steps].0, points[steps - 1].0);
        let along = (last - before).normalize();
        points.extend((1..=4).map(|i| (last + along * (self.outlet * i as f32 / 4.0), self.widest)));
        points
    }

    /// Middle of the mouth and the direction out of it.
    fn mouth(self) -> (Vec3, Vec3) {
        let points = self.points();
        let [.., before, end] = points[..] else { unreachable!("a volute has dozens of points") };
        (end.0, (end.0 - before.0).normalize())
    }

    fn draw(self, shape: &mut Shape) {
        shape.tube(&self.points(), 16);
        let (end, along) = self.mouth();
        shape.turned(
            end - along * 0.055,
            along,
            &ring(self.widest + 0.004, self.widest + 0.07, 0.0, 0.05),
            40,
        );
    }
}

/// Where the housings of the right turbocharger are: the turbine's mouth looks down to the collector, the
/// compressor's up.
fn housings(assembly: &Assembly) -> [Affine3A; 2] {
    let place = TURBO.extend(-assembly.layout.half() - 0.55);
    [
        Affine3A::from_translation(place) * Affine3A::from_rotation_z(PI),
        Affine3A::from_translation(place + Vec3::Z * 0.62),
    ]
}

/// A wheel of twisted blades around its hub.
fn draw_wheel(shape: &mut Shape, radius: f32, blades: u32, twist: f32) {
    let hub: Vec<(f32, f32)> = (0..=10)
        .map(|i| {
            let s = i as f32 / 10.0;
            (radius * (0.96 - 0.76 * s.powf(0.6)), 0.34 * radius * 2.0 * s)
        })
        .collect();
    let mut profile = vec![(0.0, -0.02), (radius * 0.96, -0.02)];
    profile.extend(hub);
    profile.push((0.0, 0.7 * radius));
    shape.turned(Vec3::ZERO, Vec3::Z, &profile, 26);
    for blade in 0..blades {
        let start = TAU * blade as f32 / blades as f32;
        let point = |s: f32, tip: f32| {
            let inner = radius * (0.95 - 0.74 * s.powf(0.6));
            let outer = radius * (1.0 - 0.2 * s);
            let turn = start + twist * s;
            (clockwise(turn) * (inner + (outer - inner) * tip)).extend(0.68 * radius * s + 0.02 * tip)
        };
        for step in 0..8 {
            let (low, high) = (step as f32 / 8.0, (step + 1) as f32 / 8.0);
            shape.quad([point(low, 0.0), point(low, 1.0), point(high, 1.0), point(high, 0.0)]);
        }
    }
}

fn put_turbos(assembly: &mut Assembly) {
    let finish = assembly.finish;
    let place = TURBO.extend(-assembly.layout.half() - 0.55);
    let [turbine, compressor] = housings(assembly);
    let hot = assembly.part("turbine housing", finish.orange, |shape| {
        shape.moved(turbine, |shape| TURBINE.draw(shape));
        // Spent gas leaves along the axis.
        let path = [
            place - Vec3::Z * 0.1,
            place - Vec3::Z * 0.35,
            place + Vec3::new(0.0, -0.2, -0.68),
            place + Vec3::new(0.0, -0.7, -0.82),
        ];
        shape.turned(place - Vec3::Z * 0.12, Vec3::NEG_Z, &ring(0.244, 0.33, 0.0, 0.06), 26);
        let path: Vec<(Vec3, f32)> = bend(&path, 7).into_iter().map(|point| (point, 0.24)).collect();
        shape.tube(&path, 22);
    });
    let cold = assembly.part("compressor housing", finish.cast, |shape| {
        shape.moved(compressor, |shape| COMPRESSOR.draw(shape));
        shape.turned(place + Vec3::Z * 0.66, Vec3::Z, &ring(0.34, 0.385, 0.02, 0.34), 32);
    });
    let centre = assembly.part("bearing housing", finish.steel, |shape| {
        let profile = [
            (0.08, 0.0),
            (0.34, 0.0),
            (0.34, 0.05),
            (0.19, 0.08),
            (0.17, 0.2),
            (0.19, 0.31),
            (0.36, 0.34),
            (0.36, 0.39),
            (0.08, 0.39),
            (0.08, 0.0),
        ];
        shape.turned(place + Vec3::Z * 0.09, Vec3::Z, &profile, 32);
    });
    for bank in BANKS {
        for part in [&hot, &cold, &centre] {
            assembly.builder.place(part, mirror(bank));
        }
    }
    put_turbo_wheels(assembly, place);
    put_charge_pipes(assembly, compressor);
}

fn put_turbo_wheels(assembly: &mut Assembly, place: Vec3) {
    let finish = assembly.finish;
    let wheels =
        [("turbine wheel", finish.copper, -1.0, 0.30, 11), ("compressor wheel", finish.steel, 1.0, 0.32, 12)];
    for (name, material, facing, radius, blades) in wheels {
        let wheel = assembly.part(name, material, |shape| {
            if facing > 0.0 {
                draw_wheel(shape, radius, blades, 0.9);
            } else {
                shape.moved(Affine3A::from_rotation_y(PI), |shape| draw_wheel(shape, radius, blades, 0.7));
            }
        });
        for bank in BANKS {
            let axis =
                Vec3::new(bank.side * place.x, place.y, place.z + if facing > 0.0 { 0.56 } else { 0.05 });
            assembly.put_turning(&wheel, axis, 0.0, TURBO_TURNS);
        }
    }
    let shaft = assembly.part("turbo shaft", finish.dark, |shape| {
        shape.turned(Vec3::Z * 0.04, Vec3::Z, &drum(0.06, 0.0, 0.53, 0.01), 16);
        shape.turned(Vec3::Z * 0.785, Vec3::Z, &ball(0.05, 8), 12);
    });
    for bank in BANKS {
        let axis = Vec3::new(bank.side * place.x, place.y, place.z);
        assembly.put_turning(&shaft, axis, 0.0, TURBO_TURNS);
    }
}

/// Pipes that lead the compressed air into the plenum from behind: a way along the heads to the front would
/// hide the gears.
fn put_charge_pipes(assembly: &mut Assembly, compressor: Affine3A) {
    let (half, finish) = (assembly.layout.half(), assembly.finish);
    let part = assembly.part("charge pipe", finish.cast, |shape| {
        let (mouth, out) = COMPRESSOR.mouth();
        let (mouth, out) = (compressor.transform_point3(mouth), compressor.transform_vector3(out));
        let path = [
            mouth + out * 0.005,
            mouth + out * 0.3 - Vec3::Z * 0.1,
            Vec3::new(2.2, 3.2, -half - 0.45),
            Vec3::new(1.35, 3.75, -half - 0.5),
            Vec3::new(0.6, 3.5, -half - 0.5),
            Vec3::new(0.22, PLENUM.y, -half - 0.15),
            Vec3::new(0.2, PLENUM.y, -half + 0.24),
        ];
        shape.pipe(&bend(&path, 6), COMPRESSOR.widest, 18);
    });
    for bank in BANKS {
        assembly.builder.place(&part, mirror(bank));
    }
    let clamp = assembly.part("hose clamp", finish.accent, |shape| {
        let foot = Vec3::new(0.2, PLENUM.y, -half - 0.04);
        shape.moved(stand(foot, Vec3::Z), |shape| shape.lathe(Vec3::ZERO, &ring(0.153, 0.18, 0.0, 0.1), 22));
    });
    for bank in BANKS {
        assembly.builder.place(&clamp, mirror(bank));
    }
}
