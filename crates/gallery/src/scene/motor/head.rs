//! The cylinder heads: fire deck, fins, ports, cam carriers, covers, spark plugs.

use std::f32::consts::PI;

use glam::{Affine3A, Vec2, Vec3};

use super::{
    assembly::{Assembly, BANK_OFFSET, BANKS, CAMSHAFT, DECK, SPACING},
    block::{GAP, bored},
    kinematics::clockwise,
    valves::{EXHAUST, INTAKE, VALVE_Z, Valve},
};
use crate::{
    kit::mechanical::{Outline, bend, circle, drum, hull, inset, ring, rounded_rectangle, stand, wall},
    shape::Shape,
};

/// Top of the fire deck.
const FIRE_DECK: f32 = 2.47;
/// Where the cam carrier begins.
const CARRIER: f32 = 3.42;

pub(super) fn put(assembly: &mut Assembly) {
    put_casting(assembly);
    put_ports(assembly);
    put_carriers(assembly);
    put_covers(assembly);
    put_plugs(assembly);
    put_coils(assembly);
}

/// The side of a head: upwards from the fire deck, spreading to make room for the camshafts.
fn side(x: f32) -> [Vec2; 4] {
    [
        Vec2::new(x * 0.66, FIRE_DECK + GAP),
        Vec2::new(x * 0.66, 2.62),
        Vec2::new(x * 0.98, 3.3),
        Vec2::new(x * 0.98, CARRIER),
    ]
}

/// Half the width of a head at a height.
fn half_width(height: f32) -> f32 {
    0.66 + 0.32 * ((height - 2.62) / 0.68).clamp(0.0, 1.0)
}

fn put_casting(assembly: &mut Assembly) {
    let (half, finish) = (assembly.layout.half(), assembly.finish);
    for bank in BANKS {
        let plate = bored(assembly, bank.side, 0.7, 0.47);
        let part = assembly.part("fire deck", finish.cast, |shape| {
            shape.extrude_up(&plate, DECK + 0.018 + GAP, FIRE_DECK, 0.012);
        });
        assembly.builder.place(&part, bank.to_world());
    }
    for x in [1.0, -1.0] {
        assembly.put_on_banks("head wall", finish.cast, |shape| {
            shape.extrude(&[wall(&side(x), 0.06)], -half + 0.05, half - 0.05, 0.01);
        });
    }
    let face: Outline = side(1.0).into_iter().chain(side(-1.0).into_iter().rev()).collect();
    let face = inset(&face, -0.03);
    for z in [half - 0.04, -half] {
        assembly.put_on_banks("head end", finish.cast, |shape| {
            shape.extrude(std::slice::from_ref(&face), z, z + 0.04, 0.01);
        });
    }
    for i in 0..7 {
        let low = 2.56 + 0.1 * i as f32;
        let inner = half_width(low + 0.03) + 0.035;
        let outline = [
            rounded_rectangle(Vec2::new(inner + 0.13, half + 0.04), 0.1),
            rounded_rectangle(Vec2::new(inner, half + GAP), 0.03),
        ];
        assembly.put_on_banks("fin", finish.cast, |shape| {
            shape.extrude_up(&outline, low, low + 0.028, 0.006);
        });
    }
    let count = assembly.layout.cylinders + 1;
    for bank in BANKS {
        let world = bank.to_world();
        for i in 0..count {
            let z = (0.5 * (count - 1) as f32 - i as f32) * SPACING * 0.96;
            for x in [-0.6, 0.6] {
                let seat = world.transform_point3(Vec3::new(x, FIRE_DECK + 0.005, z));
                assembly.bolt(seat, world.transform_vector3(Vec3::Y), 0.04);
            }
        }
    }
}

/// Where the pipes bolt on, in the space of a bank: middle and outward direction.
pub(super) fn flange(valve: Valve) -> (Vec3, Vec3) {
    let side = valve.side;
    (Vec3::new(1.0 * side, 2.86, 0.0), Vec3::new(side, if side > 0.0 { -0.25 } else { 0.2 }, 0.0).normalize())
}

fn put_ports(assembly: &mut Assembly) {
    let finish = assembly.finish;
    for (name, valve, material) in
        [("exhaust port", EXHAUST, finish.orange), ("intake port", INTAKE, finish.blue)]
    {
        let (mouth, out) = flange(valve);
        let port = assembly.part(name, material, |shape| {
            for z in [VALVE_Z, -VALVE_Z] {
                let seat = valve.at(0.09, z);
                let path = [seat, valve.at(0.2, z), (mouth - out * 0.42).with_z(0.6 * z), mouth - out * 0.02];
                shape.pipe(&bend(&path, 5), valve.radius - 0.035, 12);
            }
        });
        let plate = assembly.part("port flange", finish.steel, |shape| {
            shape.moved(stand(mouth, out), |shape| {
                let oval = hull(
                    [-0.24, 0.24].iter().flat_map(|&z| circle(Vec2::new(0.0, z), 0.12, 14)).chain(circle(
                        Vec2::ZERO,
                        0.22,
                        32,
                    )),
                );
                let holes = [circle(Vec2::ZERO, 0.155, 18)];
                let [hole] = holes;
                shape.extrude_up(&[oval, hole], 0.0, 0.05, 0.01);
            });
        });
        for cylinder in assembly.layout.cylinders() {
            let place = cylinder.bank.to_world() * Affine3A::from_translation(Vec3::Z * cylinder.z);
            assembly.builder.place(&port, place);
            assembly.builder.place(&plate, place);
            for z in [-0.265, 0.265] {
                let seat = place.transform_point3(mouth + out * 0.055 + Vec3::Z * z);
                assembly.bolt(seat, place.transform_vector3(out), 0.03);
            }
        }
    }
}

/// Bearings of both camshafts of a bank, between the cylinders and at the ends.
fn put_carriers(assembly: &mut Assembly) {
    let (layout, finish) = (assembly.layout, assembly.finish);
    let camshaft = |side: f32| Vec2::new(side * CAMSHAFT.x, CAMSHAFT.y);
    let tower = hull(
        circle(camshaft(1.0), 0.25, 22)
            .into_iter()
            .chain(circle(camshaft(-1.0), 0.25, 22))
            .chain([Vec2::new(0.92, CARRIER + 0.06), Vec2::new(-0.92, CARRIER + 0.06)]),
    );
    let outlines = [
        tower,
        circle(camshaft(1.0), 0.163, 22),
        circle(camshaft(-1.0), 0.163, 22),
        circle(Vec2::new(0.0, 3.78), 0.2, 18),
    ];
    let part =
        assembly.part("cam bearing", finish.cast, |shape| shape.extrude(&outlines, -0.05, 0.05, 0.012));
    for bank in BANKS {
        for z in layout.main_z() {
            let z = (z + bank.side * BANK_OFFSET).clamp(-layout.half() + 0.08, layout.half() - 0.08);
            assembly.builder.place(&part, bank.to_world() * Affine3A::from_translation(Vec3::Z * z));
        }
    }
}

/// Height of the flat top between the humps of a cover.
const COVER_TOP: f32 = CAMSHAFT.y + 0.312 + 0.0225;

/// A coil on each plug, a filler cap on the right cover.
fn put_coils(assembly: &mut Assembly) {
    let finish = assembly.finish;
    let coil = assembly.part("ignition coil", finish.rubber, |shape| {
        shape.extrude_up(&[rounded_rectangle(Vec2::new(0.19, 0.15), 0.06)], GAP, 0.2, 0.025);
        shape.extrude_up(&[rounded_rectangle(Vec2::new(0.3, 0.07), 0.05)], 0.205, 0.26, 0.015);
    });
    let stem = assembly.part("coil stem", finish.rubber, |shape| {
        shape.lathe(Vec3::ZERO, &ring(0.065, 0.095, -0.72, -0.06), 18);
    });
    for cylinder in assembly.layout.cylinders() {
        let foot = Vec3::new(0.0, COVER_TOP, cylinder.z);
        let place = cylinder.bank.to_world() * Affine3A::from_translation(foot);
        for part in [&coil, &stem] {
            assembly.builder.place(part, place);
        }
        let seat = place.transform_point3(Vec3::new(0.24, 0.265, 0.0));
        assembly.bolt(seat, place.transform_vector3(Vec3::Y), 0.022);
    }
    assembly.put("filler cap", finish.brass, |shape| {
        let world = BANKS[0].to_world();
        let foot = world.transform_point3(Vec3::new(CAMSHAFT.x, CAMSHAFT.y + 0.4, 0.0));
        let profile =
            [(0.0, 0.0), (0.15, 0.0), (0.15, 0.05), (0.2, 0.055), (0.2, 0.12), (0.17, 0.14), (0.0, 0.14)];
        shape.turned(foot, world.transform_vector3(Vec3::Y), &profile, 22);
        shape.moved(stand(foot, world.transform_vector3(Vec3::Y)), |shape| {
            shape.block(Vec3::new(-0.14, 0.145, -0.025), Vec3::new(0.14, 0.2, 0.025));
        });
    });
}

/// The outline of a cam cover from one side to the other: a hump over each camshaft.
fn cover_path() -> Vec<Vec2> {
    let hump = |side: f32| {
        (0..=10).map(move |i| {
            let turn = side * (0.5 * PI - 0.68 * PI * i as f32 / 10.0);
            Vec2::new(side * CAMSHAFT.x, CAMSHAFT.y) + 0.37 * clockwise(turn)
        })
    };
    let right = [Vec2::new(1.03, CARRIER + 0.03)].into_iter().chain(hump(1.0));
    let left: Vec<Vec2> = [Vec2::new(-1.03, CARRIER + 0.03)].into_iter().chain(hump(-1.0)).collect();
    right.chain(left.into_iter().rev()).collect()
}

fn put_covers(assembly: &mut Assembly) {
    let (half, finish) = (assembly.layout.half(), assembly.finish);
    let path = cover_path();
    let outside = wall(&path, 0.045);
    assembly.put_on_banks("cam cover", finish.accent, |shape| {
        shape.extrude(std::slice::from_ref(&outside), -half + 0.05, half - 0.05, 0.01);
        let shafts = [1.0, -1.0].map(|side| circle(Vec2::new(side * CAMSHAFT.x, CAMSHAFT.y), 0.17, 22));
        let [right, left] = shafts;
        let end: Outline = inset(&path, -0.0225);
        shape.extrude(&[end.clone(), right, left], half - 0.045, half, 0.01);
        shape.extrude(&[end], -half, -half + 0.045, 0.01);
    });
    let frame = [
        rounded_rectangle(Vec2::new(1.13, half + 0.03), 0.1),
        rounded_rectangle(Vec2::new(1.02, half - 0.08), 0.06),
    ];
    assembly.put_on_banks("cover flange", finish.steel, |shape| {
        shape.extrude_up(&frame, CARRIER + GAP - 0.02, CARRIER + 0.02, 0.006);
    });
    let count = 2 * assembly.layout.cylinders + 1;
    for bank in BANKS {
        let world = bank.to_world();
        for i in 0..count {
            let z = (i as f32 / (count - 1) as f32 - 0.5) * 2.0 * (half - 0.06);
            for x in [-1.085, 1.085] {
                let seat = world.transform_point3(Vec3::new(x, CARRIER + 0.022, z));
                assembly.bolt(seat, world.transform_vector3(Vec3::Y), 0.026);
            }
        }
    }
}

fn draw_plug(shape: &mut Shape) {
    // A threaded shank: its ridges are those of an M12.
    let mut shank = vec![(0.0, 0.0), (0.05, 0.0)];
    for i in 0..8 {
        let y = 0.02 + 0.024 * i as f32;
        shank.extend([(0.052, y), (0.06, y + 0.012)]);
    }
    shank.extend([(0.052, 0.22), (0.085, 0.225), (0.085, 0.25), (0.0, 0.25)]);
    shape.lathe(Vec3::ZERO, &shank, 14);
    shape.extrude_up(&[circle(Vec2::ZERO, 0.105, 6)], 0.255, 0.36, 0.012);
    shape.beam(Vec3::new(0.04, -0.002, 0.0), Vec3::new(0.04, -0.05, 0.0), Vec3::X, 0.012, 0.025);
    shape.beam(Vec3::new(0.046, -0.055, 0.0), Vec3::new(-0.012, -0.055, 0.0), Vec3::Y, 0.01, 0.025);
    shape.lathe(Vec3::Y * 1.02, &drum(0.035, 0.0, 0.09, 0.012), 12);
}

fn put_plugs(assembly: &mut Assembly) {
    let finish = assembly.finish;
    let metal = assembly.part("spark plug", finish.brass, draw_plug);
    let insulator = assembly.part("insulator", finish.ceramic, |shape| {
        let mut profile = vec![(0.0, 0.365), (0.075, 0.365), (0.075, 0.42), (0.06, 0.5)];
        for i in 0..5 {
            let y = 0.72 + 0.05 * i as f32;
            profile.extend([(0.05, y), (0.058, y + 0.02), (0.05, y + 0.035)]);
        }
        profile.extend([(0.046, 1.0), (0.0, 1.01)]);
        shape.lathe(Vec3::ZERO, &profile, 16);
    });
    let tube = assembly.part("plug well", finish.glass, |shape| {
        shape.lathe(Vec3::ZERO, &ring(0.135, 0.15, 0.26, 1.72), 20);
    });
    for cylinder in assembly.layout.cylinders() {
        let foot = Vec3::new(0.0, FIRE_DECK + 0.03, cylinder.z);
        let place = cylinder.bank.to_world() * Affine3A::from_translation(foot);
        for part in [&metal, &insulator, &tube] {
            assembly.builder.place(part, place);
        }
    }
}
