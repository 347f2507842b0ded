//! Camshafts, and the valves, springs and tappets that follow them.

use std::f32::consts::PI;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::{
    assembly::{Assembly, BANK_OFFSET, BANKS, Bank, CAMSHAFT, Cylinder},
    kinematics::Cam,
};
use crate::{
    builder::Prop,
    kit::mechanical::{circle, ring, stand},
    shape::Shape,
};

/// The intake or the exhaust valves of a bank, which are alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Valve {
    /// The side of the bank that they are on: -1 in the valley.
    pub(super) side: f32,
    /// Radius of the head.
    pub(super) radius: f32,
    /// Crank angle after the top dead centre of the gas exchange at which it is fully open.
    peak_rad: f32,
}

/// 110 degrees before and after: the common choice for a road engine.
const PEAK_RAD: f32 = 1.92;
pub(super) const INTAKE: Valve = Valve { side: -1.0, radius: 0.175, peak_rad: PEAK_RAD };
pub(super) const EXHAUST: Valve = Valve { side: 1.0, radius: 0.15, peak_rad: -PEAK_RAD };
/// Two of a kind in a cylinder, this far from its middle along the engine.
pub(super) const VALVE_Z: f32 = 0.2;
/// Middle of the head's face of an exhaust valve.
const FACE: Vec2 = Vec2::new(0.2, 2.5);

/// A lift of 9 mm over 280 degrees of crank angle. Convex while `base > lift (π² / (2 half_duration²) - 1)`.
pub(super) const CAM: Cam = Cam { base_radius: 0.22, lift: 0.09, half_duration_rad: 1.222 };

/// Distance along the valve from its face to where its spring sits.
const SPRING_SEAT: f32 = 0.60;
/// Distance along the valve from its face to what holds the upper end of its spring.
const RETAINER: f32 = 1.12;

impl Valve {
    /// Unit direction from the face to the camshaft in the space of a bank.
    fn axis(self) -> Vec3 {
        let axis = (CAMSHAFT - FACE).normalize();
        Vec3::new(self.side * axis.x, axis.y, 0.0)
    }

    /// A point on the axis.
    pub(super) fn at(self, distance: f32, z: f32) -> Vec3 {
        Vec3::new(self.side * FACE.x, FACE.y, z) + distance * self.axis()
    }

    /// Distance from the face at which the tappet ends while the valve is shut: at the base circle.
    fn tappet() -> f32 {
        (CAMSHAFT - FACE).length() - CAM.base_radius
    }

    /// How far the cam's nose has turned past the tappet.
    pub(super) fn nose_rad(self, cylinder: Cylinder, crank_rad: f32) -> f32 {
        // The camshaft turns at half speed; the gas exchange is a turn after firing.
        0.5 * (crank_rad - cylinder.fires_rad - 2.0 * PI - self.peak_rad)
    }

    pub(super) fn lift(self, cylinder: Cylinder, crank_rad: f32) -> f32 {
        CAM.lift(self.nose_rad(cylinder, crank_rad))
    }

    /// Direction from the camshaft to the tappet, clockwise in the world.
    fn towards_tappet_rad(self, bank: Bank) -> f32 {
        let down = -bank.to_world().transform_vector3(self.axis());
        down.x.atan2(down.y)
    }
}

pub(super) fn put(assembly: &mut Assembly) {
    put_camshafts(assembly);
    for valve in [INTAKE, EXHAUST] {
        put_valves(assembly, valve);
    }
}

fn put_camshafts(assembly: &mut Assembly) {
    let (layout, finish) = (assembly.layout, assembly.finish);
    let half = layout.half();
    for bank in BANKS {
        for (name, valve, material) in
            [("intake camshaft", INTAKE, finish.dark), ("exhaust camshaft", EXHAUST, finish.dark)]
        {
            let part = assembly.part(name, material, |shape| {
                // A hollow shaft with a journal at each bearing.
                let mut profile = vec![(0.06, -half + 0.02), (0.118, -half + 0.02)];
                let mut bearings: Vec<f32> = layout.main_z().collect();
                bearings.reverse();
                for z in bearings {
                    let z = (z + bank.side * BANK_OFFSET).clamp(-half + 0.08, half - 0.08);
                    profile.extend([
                        (0.118, z - 0.056),
                        (0.158, z - 0.056),
                        (0.158, z + 0.056),
                        (0.118, z + 0.056),
                    ]);
                }
                profile.extend([(0.118, half + 0.4), (0.06, half + 0.4), (0.06, -half + 0.02)]);
                shape.turned(Vec3::ZERO, Vec3::Z, &profile, 16);
                for cylinder in layout.cylinders() {
                    if cylinder.bank.side != bank.side {
                        continue;
                    }
                    // At crank angle zero the nose is that far past the tappet.
                    let nose = valve.towards_tappet_rad(bank) + valve.nose_rad(cylinder, 0.0);
                    for z in [VALVE_Z, -VALVE_Z] {
                        let hole = circle(Vec2::ZERO, 0.121, 22);
                        let (low, high) = (cylinder.z + z - 0.08, cylinder.z + z + 0.08);
                        shape.extrude(&[CAM.outline(nose, 40), hole], low, high, 0.0);
                    }
                }
            });
            let centre = bank.point(Vec2::new(valve.side * CAMSHAFT.x, CAMSHAFT.y));
            assembly.put_turning(&part, centre.extend(0.0), 0.0, 1.0);
        }
    }
}

fn draw_valve(shape: &mut Shape, radius: f32) {
    let tip = Valve::tappet() - 0.045;
    let profile = [
        (0.0, 0.0),
        (radius, 0.0),
        (radius, 0.018),
        (radius - 0.028, 0.046),
        (radius - 0.07, 0.07),
        (0.07, 0.12),
        (0.042, 0.2),
        (0.033, 0.32),
        (0.033, tip - 0.01),
        (0.026, tip),
        (0.0, tip),
    ];
    shape.lathe(Vec3::ZERO, &profile, 16);
    // The retainer and its collets.
    let cup = [
        (0.034, RETAINER + 0.005),
        (0.09, RETAINER + 0.005),
        (0.132, RETAINER + 0.005),
        (0.132, RETAINER + 0.035),
        (0.07, RETAINER + 0.05),
        (0.05, RETAINER + 0.075),
        (0.034, RETAINER + 0.075),
        (0.034, RETAINER + 0.005),
    ];
    shape.lathe(Vec3::ZERO, &cup, 14);
}

fn draw_tappet(shape: &mut Shape) {
    let top = Valve::tappet();
    let profile = [
        (0.0, top - 0.04),
        (0.14, top - 0.04),
        (0.14, top - 0.26),
        (0.165, top - 0.26),
        (0.165, top - 0.012),
        (0.153, top - 0.001),
        (0.0, top - 0.001),
    ];
    shape.lathe(Vec3::ZERO, &profile, 22);
}

/// Parts of a valve that stay where they are.
fn put_seats(assembly: &mut Assembly, valve: Valve) {
    let finish = assembly.finish;
    let seat = assembly.part("valve seat", finish.brass, |shape| {
        let (inner, outer) = (valve.radius - 0.03, valve.radius + 0.02);
        shape.lathe(Vec3::ZERO, &ring(inner, outer, 0.05, 0.1), 16);
        // The guide in which the stem slides.
        shape.lathe(Vec3::ZERO, &ring(0.036, 0.06, 0.34, SPRING_SEAT + 0.06), 12);
        shape.lathe(Vec3::ZERO, &ring(0.062, 0.145, SPRING_SEAT - 0.03, SPRING_SEAT), 18);
    });
    for cylinder in assembly.layout.cylinders() {
        for z in [VALVE_Z, -VALVE_Z] {
            let place = stand(valve.at(0.0, cylinder.z + z), valve.axis());
            assembly.builder.place(&seat, cylinder.bank.to_world() * place);
        }
    }
}

fn put_valves(assembly: &mut Assembly, valve: Valve) {
    put_seats(assembly, valve);
    let finish = assembly.finish;
    let metal = if valve.side > 0.0 { finish.copper } else { finish.steel };
    let poppet = assembly.part("valve", metal, |shape| draw_valve(shape, valve.radius));
    let tappet = assembly.part("tappet", finish.steel, draw_tappet);
    let spring = assembly.part("valve spring", finish.blue, |shape| {
        shape.coil(0.108, 0.019, RETAINER - SPRING_SEAT, 6.0, [12, 5]);
    });
    for cylinder in assembly.layout.cylinders() {
        for z in [VALVE_Z, -VALVE_Z] {
            put_followers(assembly, valve, cylinder, z, [&poppet, &tappet], &spring);
        }
    }
}

fn put_followers(
    assembly: &mut Assembly,
    valve: Valve,
    cylinder: Cylinder,
    z: f32,
    followers: [&Prop; 2],
    spring: &Prop,
) {
    let world: Affine3A = cylinder.bank.to_world();
    let axis = world.transform_vector3(valve.axis());
    // Turned parts do not mind that the left bank is mirrored.
    let rotation = Quat::from_rotation_arc(Vec3::Y, axis);
    let at = |distance: f32| world.transform_point3(valve.at(distance, cylinder.z + z));
    for part in followers {
        assembly.put_led(part, |_| rotation, |crank| at(-valve.lift(cylinder, crank)), None);
    }
    let length = RETAINER - SPRING_SEAT;
    let squeeze = |crank: f32| Vec3::new(1.0, 1.0 - valve.lift(cylinder, crank) / length, 1.0);
    assembly.put_led(spring, |_| rotation, |_| at(SPRING_SEAT), Some(&squeeze));
}
