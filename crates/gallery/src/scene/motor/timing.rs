//! The train of gears from the crankshaft to the camshafts, and its cover.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Vec2, Vec3};

use super::{
    assembly::{Assembly, BANKS, Bank, CAMSHAFT},
    crank::SNOUT_RADIUS,
    kinematics::Meshing,
};
use crate::kit::mechanical::{Outline, ball, circle, drum, gear, hull, inset, pitch_radius, ring};

/// Twice as many teeth on the camshaft as on the crankshaft: half its speed.
pub(super) const CRANK_TEETH: u32 = 18;
pub(super) const CAM_TEETH: u32 = 36;
/// Both camshafts of a bank are reached from one idler between them, and their gears just clear each other.
pub(super) const MODULE: f32 = 0.035;
/// How far the first idler stands outwards of its bank's axis, so that the two banks' idlers clear each
/// other.
const FIRST_IDLER_RAD: f32 = 0.35;
/// Balls of an idler's bearing. In a full turn of the outer race on a still inner one the cage makes 7/12, if
/// the races are 7 to 5 wide; of twelve balls each has then taken the place of another.
const BALLS: u32 = 12;
const CAGE_TURNS: f32 = 7.0 / 12.0;
const OUTER_RACE: f32 = 0.252;
const INNER_RACE: f32 = OUTER_RACE * 5.0 / 7.0;

/// The cover's outer face, in front of the block.
pub(super) const COVER_FACE: f32 = 0.485;

/// A gear of the train and how far it turns in a cycle, clockwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrainGear {
    pub(super) meshing: Meshing,
    pub(super) turns: f32,
    idler: bool,
}

/// The gears of a bank from the crankshaft's on, each driven by the one before, but both of the camshafts by
/// the last idler.
pub(super) fn train(bank: Bank) -> [TrainGear; 6] {
    let crank = Meshing { centre: Vec2::ZERO, teeth: CRANK_TEETH, turn_rad: 0.5 * PI };
    let step = pitch_radius(2 * CAM_TEETH, MODULE);
    let first = pitch_radius(CRANK_TEETH + CAM_TEETH, MODULE) * Vec2::from_angle(0.5 * PI - FIRST_IDLER_RAD);
    let last = Vec2::new(0.0, CAMSHAFT.y - (step * step - CAMSHAFT.x * CAMSHAFT.x).sqrt());
    // The middle one bends the train inwards, to where it touches both.
    let between = last - first;
    let sag = (step * step - 0.25 * between.length_squared()).sqrt();
    let middle = 0.5 * (first + last) + between.normalize().perp() * sag;
    let driven = |driver: Meshing, centre: Vec2, turns: f32, idler: bool| {
        let meshing = driver.drives(bank.point(centre), CAM_TEETH);
        TrainGear { meshing, turns, idler }
    };
    let a = driven(crank, first, -1.0, true);
    let b = driven(a.meshing, middle, 1.0, true);
    let c = driven(b.meshing, last, -1.0, true);
    let cams =
        [1.0, -1.0].map(|side| driven(c.meshing, Vec2::new(side * CAMSHAFT.x, CAMSHAFT.y), 1.0, false));
    [TrainGear { meshing: crank, turns: 2.0, idler: false }, a, b, c, cams[0], cams[1]]
}

pub(super) fn put(assembly: &mut Assembly) {
    put_gears(assembly);
    put_cover(assembly);
}

fn put_gears(assembly: &mut Assembly) {
    let (front, finish) = (assembly.layout.half(), assembly.finish);
    let (low, high) = (front + 0.14, front + 0.32);
    let crank_gear = assembly.part("crank gear", finish.brass, |shape| {
        let outlines = [gear(CRANK_TEETH, MODULE), circle(Vec2::ZERO, SNOUT_RADIUS + 0.003, 26)];
        shape.extrude(&outlines, low - 0.01, high + 0.01, 0.008);
    });
    let spoked = |hub: f32| {
        let mut outlines = vec![gear(CAM_TEETH, MODULE), circle(Vec2::ZERO, hub, 32)];
        outlines.extend((0..6).map(|i| circle(0.435 * Vec2::from_angle(TAU * i as f32 / 6.0), 0.088, 16)));
        outlines
    };
    let idler = assembly.part("idler gear", finish.brass, |shape| {
        shape.extrude(&spoked(0.302), low, high, 0.0);
    });
    let cam_gear = assembly.part("cam gear", finish.blue, |shape| {
        shape.extrude(&spoked(0.123), low, high, 0.0);
        shape.turned(Vec3::Z * (high + 0.005), Vec3::Z, &ring(0.123, 0.2, 0.0, 0.05), 20);
    });
    let crank = train(BANKS[0])[0];
    assembly.put_turning(&crank_gear, Vec3::ZERO, crank.meshing.turn_rad, crank.turns);
    for bank in BANKS {
        for wheel in &train(bank)[1..] {
            let part = if wheel.idler { &idler } else { &cam_gear };
            let centre = wheel.meshing.centre.extend(0.0);
            assembly.put_turning(part, centre, wheel.meshing.turn_rad, wheel.turns);
        }
    }
    put_bearings(assembly, low, high);
}

/// Each idler runs on a ball bearing around a stub that is bolted to the front plate.
fn put_bearings(assembly: &mut Assembly, low: f32, high: f32) {
    let finish = assembly.finish;
    let (middle, half) = (0.5 * (low + high), 0.065);
    let (ball_radius, pitch) = (0.5 * (OUTER_RACE - INNER_RACE), 0.5 * (OUTER_RACE + INNER_RACE));
    let outer = assembly.part("outer race", finish.steel, |shape| {
        // The groove that the balls run in is a circular arc.
        let mut profile =
            vec![(OUTER_RACE - 0.02, -half), (0.298, -half), (0.298, half), (OUTER_RACE - 0.02, half)];
        profile.extend((0..=6).map(|i| groove(OUTER_RACE, 0.55 - 1.1 * i as f32 / 6.0, ball_radius, 1.0)));
        profile.push((OUTER_RACE - 0.02, -half));
        shape.turned(Vec3::Z * middle, Vec3::Z, &profile, 32);
    });
    let inner = assembly.part("inner race", finish.steel, |shape| {
        let mut profile = vec![(0.122, -half), (INNER_RACE + 0.02, -half)];
        profile.extend((0..=6).map(|i| groove(INNER_RACE, -0.55 + 1.1 * i as f32 / 6.0, ball_radius, -1.0)));
        profile.extend([(INNER_RACE + 0.02, half), (0.122, half), (0.122, -half)]);
        shape.turned(Vec3::Z * middle, Vec3::Z, &profile, 26);
    });
    let balls = assembly.part("bearing balls", finish.copper, |shape| {
        for i in 0..BALLS {
            let place = pitch * Vec2::from_angle(TAU * i as f32 / BALLS as f32);
            shape.turned(place.extend(middle), Vec3::Y, &ball(ball_radius - 0.001, 6), 8);
        }
    });
    let stub = assembly.part("idler axle", finish.dark, |shape| {
        let front = low - 0.075;
        shape.turned(Vec3::Z * front, Vec3::Z, &drum(0.119, 0.0, high - front + 0.02, 0.01), 20);
        shape.turned(Vec3::Z * front, Vec3::Z, &ring(0.121, 0.17, 0.005, 0.08), 20);
    });
    for bank in BANKS {
        for wheel in train(bank).iter().filter(|wheel| wheel.idler) {
            let centre = wheel.meshing.centre.extend(0.0);
            assembly.put_turning(&outer, centre, 0.0, wheel.turns);
            assembly.put_turning(&balls, centre, 0.0, wheel.turns * CAGE_TURNS);
            for part in [&inner, &stub] {
                assembly.builder.place(part, Affine3A::from_translation(centre));
            }
            assembly.bolt(centre + Vec3::Z * (high + 0.025), Vec3::Z, 0.045);
        }
        for wheel in train(bank).iter().filter(|wheel| !wheel.idler).skip(1) {
            let seat = wheel.meshing.centre.extend(high + 0.085);
            let bolt = assembly.part("cam bolt", finish.steel, |shape| {
                shape.turned(Vec3::Z * -0.02, Vec3::Z, &drum(0.15, 0.0, 0.03, 0.006), 18);
                shape.extrude(&[circle(Vec2::ZERO, 0.085, 6)], 0.015, 0.075, 0.01);
            });
            assembly.put_turning(&bolt, seat, 0.3, 1.0);
        }
    }
}

/// A point of a race's groove, seen from the ball's middle under an angle from the radial direction.
fn groove(race: f32, angle_rad: f32, ball_radius: f32, outwards: f32) -> (f32, f32) {
    let (sin, cos) = angle_rad.sin_cos();
    (race - outwards * ball_radius * (1.0 - cos), ball_radius * sin)
}

/// The outline of the cover: around the gears of both banks, with `margin` around their pitch circles.
fn cover_outline(margin: f32) -> Outline {
    let right = hull(train(BANKS[0]).iter().flat_map(|wheel| {
        circle(wheel.meshing.centre, pitch_radius(wheel.meshing.teeth, MODULE) + margin, 26)
    }));
    // Cut at the middle plane and doubled by its mirror image.
    let count = right.len();
    let mut half = Outline::new();
    for i in 0..count {
        let (a, b) = (right[i], right[(i + 1) % count]);
        if a.x >= 0.0 {
            half.push(a);
        }
        if (a.x >= 0.0) != (b.x >= 0.0) {
            half.push(a.lerp(b, a.x / (a.x - b.x)));
        }
    }
    // The half begins at the lower cut and ends at the upper one.
    let start =
        (0..half.len()).filter(|&i| half[i].x.abs() < 1e-5).min_by(|&i, &j| half[i].y.total_cmp(&half[j].y));
    half.rotate_left(start.expect("the crank gear lies on the middle plane"));
    let middle = 1..half.len() - 1;
    let left: Vec<Vec2> = half[middle].iter().rev().map(|p| Vec2::new(-p.x, p.y)).collect();
    half.extend(left);
    half
}

fn put_cover(assembly: &mut Assembly) {
    let (front, finish) = (assembly.layout.half(), assembly.finish);
    let (outer, flange) = (cover_outline(0.1), cover_outline(0.2));
    let skin = inset(&outer, 0.04);
    // The face is cut away in front of each gear but the crankshaft's.
    let mut face = vec![outer.clone(), circle(Vec2::ZERO, 0.24, 26)];
    for bank in BANKS {
        face.extend(train(bank)[1..].iter().map(|wheel| circle(wheel.meshing.centre, 0.545, 40)));
    }
    assembly.put("timing cover", finish.glass, |shape| {
        shape.extrude(&[outer.clone(), skin], front + 0.07, front + 0.44, 0.008);
        shape.extrude(&face, front + COVER_FACE - 0.04, front + COVER_FACE, 0.012);
    });
    assembly.put("cover joint", finish.steel, |shape| {
        shape.extrude(&[flange.clone(), inset(&outer, -0.004)], front + 0.075, front + 0.125, 0.01);
    });
    assembly.put("shaft seal", finish.rubber, |shape| {
        shape.turned(Vec3::Z * (front + 0.445), Vec3::Z, &ring(SNOUT_RADIUS + 0.004, 0.236, 0.0, 0.05), 26);
    });
    // Bolts evenly along the joint.
    let path = cover_outline(0.155);
    let length = |i: usize| path[i].distance(path[(i + 1) % path.len()]);
    let total: f32 = (0..path.len()).map(length).sum();
    let count = (total / 0.55).round();
    let mut next = 0.25 * total / count;
    let mut travelled = 0.0;
    for i in 0..path.len() {
        while next < travelled + length(i) {
            let place = path[i].lerp(path[(i + 1) % path.len()], (next - travelled) / length(i));
            assembly.bolt(place.extend(front + 0.127), Vec3::Z, 0.034);
            next += total / count;
        }
        travelled += length(i);
    }
}
