//! `motor`: a V engine as a CAD program shows it, transparent all over: hundreds of parts behind and inside one another (ST Fig. 2, 4).
//!
//! Lengths are decimetres: the exhibit is ten times life size. The crankshaft lies on the z axis with its front towards +z; each bank of
//! cylinders is modelled upright with its exhaust towards +x and then tilted, the left one mirrored. The clip is one working cycle.

use std::f32::consts::{FRAC_PI_4, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, Lens},
    environment::{Environment, Lobe},
    model::{Interpolation, Keys, Track, Transform},
};

use crate::{
    builder::{Prop, SceneBuilder},
    kit::mechanical::{circle, ring, stand},
    rng::Rng,
    seed::SEED,
    shape::{Model, Shape},
};

mod ancillaries;
mod block;
mod crank;
mod finish;
mod head;
mod kinematics;
mod pipes;
#[cfg(test)]
mod tests;
mod timing;
mod valves;

use finish::Finish;
use kinematics::{SliderCrank, clockwise, firing_angles, throws};

pub(crate) const PARAMETERS: &[ParameterInfo] = &[
    ParameterInfo {
        key: "alpha",
        default: "0.3",
        range: ParameterRange::Real(0.0, 1.0),
        what: "opacity of every part",
    },
    ParameterInfo {
        key: "cylinders",
        default: "4",
        range: ParameterRange::Count(1, 6),
        what: "cylinders in each of the two banks",
    },
    SEED,
];

/// Two turns of the crankshaft: one working cycle.
const CYCLE_SECS: f32 = 6.0;
/// Keys of what does not turn evenly: one every three degrees of the crankshaft; the chord then misses the curve by a ten-thousandth.
const KEY_COUNT: u32 = 240;

/// 90 mm stroke, 92 mm bore and a rod of 150 mm: common for a V8 of five litres.
const CRANK: SliderCrank = SliderCrank { crank_radius: 0.45, rod_length: 1.5 };
const BORE_RADIUS: f32 = 0.46;
/// Between the axes of neighbouring cylinders of a bank.
const SPACING: f32 = 1.15;
/// The two rods of a crank pin sit side by side, and so the banks are offset.
const BANK_OFFSET: f32 = 0.12;
/// Height of the cylinder deck above the crank axis: clears the piston at its top by 0.3 mm.
const DECK: f32 = 2.34;
/// The camshafts in the space of a bank; the intake's is at -x.
const CAMSHAFT: Vec2 = Vec2::new(0.66, 3.95);

/// Where things are along the engine.
#[derive(Clone, Copy, Debug)]
struct Layout {
    /// In a bank.
    cylinders: u32,
}

impl Layout {
    /// Middle of a crank pin; the first is at the front.
    fn pin_z(self, index: u32) -> f32 {
        (0.5 * (self.cylinders as f32 - 1.0) - index as f32) * SPACING
    }

    /// Main bearings, one more than pins.
    fn main_z(self) -> impl Iterator<Item = f32> {
        (0..=self.cylinders).map(move |index| (0.5 * self.cylinders as f32 - index as f32) * SPACING)
    }

    /// Half the length of the block.
    fn half(self) -> f32 {
        0.5 * self.cylinders as f32 * SPACING + BANK_OFFSET
    }

    fn cylinders(self) -> Vec<Cylinder> {
        let throws = throws(self.cylinders);
        let places: Vec<(Bank, u32)> =
            BANKS.into_iter().flat_map(|bank| (0..self.cylinders).map(move |index| (bank, index))).collect();
        let tops: Vec<f32> =
            places.iter().map(|&(bank, index)| bank.tilt_rad() - throws[index as usize]).collect();
        let fires = firing_angles(&tops);
        let cylinder = |(&(bank, index), fires_rad)| Cylinder {
            bank,
            z: self.pin_z(index) + bank.side * BANK_OFFSET,
            throw_rad: throws[index as usize],
            fires_rad,
        };
        places.iter().zip(fires).map(cylinder).collect()
    }
}

/// A row of cylinders: the right one, seen from the front, leans to +x.
#[derive(Clone, Copy, Debug)]
struct Bank {
    /// 1 or -1.
    side: f32,
}

const BANKS: [Bank; 2] = [Bank { side: 1.0 }, Bank { side: -1.0 }];

impl Bank {
    /// How far it leans clockwise.
    fn tilt_rad(self) -> f32 {
        self.side * FRAC_PI_4
    }

    /// From the bank's space, exhaust at +x, mirrored on the left.
    fn to_world(self) -> Affine3A {
        Affine3A::from_rotation_z(-self.tilt_rad()) * Affine3A::from_scale(Vec3::new(self.side, 1.0, 1.0))
    }

    /// A point of the bank's cross-section.
    fn point(self, point: Vec2) -> Vec2 {
        self.to_world().transform_point3(point.extend(0.0)).truncate()
    }
}

/// One cylinder and when it fires.
#[derive(Clone, Copy, Debug)]
struct Cylinder {
    bank: Bank,
    z: f32,
    /// Direction of its crank pin at time zero, clockwise.
    throw_rad: f32,
    /// Crank angle at which it fires, 0 to 4π.
    fires_rad: f32,
}

impl Cylinder {
    /// How far its crank pin is past the top dead centre.
    fn turn_rad(self, crank_rad: f32) -> f32 {
        crank_rad + self.throw_rad - self.bank.tilt_rad()
    }
}

/// The motor in the making.
struct Assembly {
    builder: SceneBuilder,
    finish: Finish,
    layout: Layout,
    rng: Rng,
    bolt: Prop,
}

impl Assembly {
    /// A part of one material, to be placed.
    fn part(&mut self, name: &str, material: u32, draw: impl FnOnce(&mut Shape)) -> Prop {
        let mut model = Model::default();
        draw(model.paint(material, Vec3::ONE));
        self.builder.prop(name, model)
    }

    /// A part that stays where it is drawn.
    fn put(&mut self, name: &str, material: u32, draw: impl FnOnce(&mut Shape)) {
        let part = self.part(name, material, draw);
        self.builder.place(&part, Affine3A::IDENTITY);
    }

    /// A part drawn in the space of a bank, once a bank.
    fn put_on_banks(&mut self, name: &str, material: u32, draw: impl FnOnce(&mut Shape)) {
        let part = self.part(name, material, draw);
        for bank in BANKS {
            self.builder.place(&part, bank.to_world());
        }
    }

    /// A hexagon bolt, tightened as far as chance would have it; `seat` is where its head lies, `size` the radius of its shank.
    fn bolt(&mut self, seat: Vec3, axis: Vec3, size: f32) {
        let turn = Affine3A::from_rotation_y(self.rng.between(0.0, TAU));
        self.builder.place(&self.bolt, stand(seat, axis) * turn * Affine3A::from_scale(Vec3::splat(size)));
    }

    /// A part that turns evenly around the z axis through `centre`: clockwise, so many turns a cycle.
    fn put_turning(&mut self, part: &Prop, centre: Vec3, start_rad: f32, turns: f32) {
        // An eighth of a turn from key to key leaves no doubt which way round.
        let count = (8.0 * turns.abs()).ceil() as u32;
        let rotation = |share: f32| Quat::from_rotation_z(start_rad - TAU * turns * share);
        let rest = Transform::Trs { translation: centre, rotation: rotation(0.0), scale: Vec3::ONE };
        self.builder.place_moving(part, rest, vec![Track::Rotation(keys(count, rotation))]);
    }

    /// A part that is led as a function of the crank angle; its place at angle zero is its place at rest.
    fn put_led(
        &mut self,
        part: &Prop,
        rotation: impl Fn(f32) -> Quat,
        translation: impl Fn(f32) -> Vec3,
        scale: Option<&dyn Fn(f32) -> Vec3>,
    ) {
        let crank = |share: f32| 2.0 * TAU * share;
        let rest =
            Transform::Trs { translation: translation(0.0), rotation: rotation(0.0), scale: Vec3::ONE };
        let mut tracks = vec![
            Track::Rotation(keys(KEY_COUNT, |share| rotation(crank(share)))),
            Track::Translation(keys(KEY_COUNT, |share| translation(crank(share)))),
        ];
        tracks.extend(scale.map(|scale| Track::Scale(keys(KEY_COUNT, |share| scale(crank(share))))));
        self.builder.place_moving(part, rest, tracks);
    }
}

/// `count` even steps through the cycle, both ends included.
fn keys<T>(count: u32, value: impl Fn(f32) -> T) -> Keys<T> {
    let shares = (0..=count).map(|i| i as f32 / count as f32);
    Keys {
        times_secs: shares.clone().map(|share| share * CYCLE_SECS).collect(),
        values: shares.map(value).collect(),
        interpolation: Interpolation::Linear,
    }
}

pub(crate) fn build(values: &Values) -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new("motor", studio());
    let seed = values.count(SEED.key);
    let finish = Finish::new(&mut builder, values.real("alpha"), seed);
    builder.sun(Vec3::new(0.35, 0.80, 0.55), Vec3::new(3.3, 3.1, 2.9));
    let mut model = Model::default();
    draw_bolt(model.paint(finish.steel, Vec3::ONE));
    let bolt = builder.prop("bolt", model);
    let layout = Layout { cylinders: values.count("cylinders") };
    let mut assembly = Assembly { builder, finish, layout, rng: Rng::new(seed, "bolts"), bolt };
    block::put(&mut assembly);
    crank::put(&mut assembly);
    head::put(&mut assembly);
    valves::put(&mut assembly);
    timing::put(&mut assembly);
    pipes::put(&mut assembly);
    ancillaries::put(&mut assembly);
    put_cameras(&mut assembly.builder, layout);
    assembly.builder.finish()
}

/// A bolt whose shank has radius 1 and whose head sits on the origin: proportions of ISO 4014 and 7089.
fn draw_bolt(shape: &mut Shape) {
    shape.lathe(Vec3::ZERO, &ring(1.05, 2.1, 0.0, 0.3), 10);
    shape.extrude_up(&[circle(Vec2::ZERO, 1.85, 6)], 0.31, 1.6, 0.12);
    // Its upper end is hidden in the washer.
    shape.lathe(Vec3::ZERO, &[(0.0, -2.2), (1.0, -2.2), (1.0, 0.1)], 8);
}

/// A photographer's studio: a sweep that fades to a dark floor, a large soft box
/// above, a weak one in front, a strip on either side.
fn studio() -> Environment {
    let lobe = |x: f32, y: f32, z: f32, radiance: Vec3, sharpness: f32| Lobe {
        direction: Vec3::new(x, y, z).normalize(),
        radiance,
        sharpness,
    };
    Environment {
        zenith: Vec3::new(0.16, 0.18, 0.22),
        horizon: Vec3::new(0.34, 0.36, 0.40),
        ground: Vec3::new(0.045, 0.05, 0.06),
        lobes: vec![
            lobe(0.35, 0.9, 0.5, Vec3::new(2.6, 2.5, 2.4), 14.0),
            lobe(0.1, 0.25, 1.0, Vec3::new(0.62, 0.66, 0.72), 5.0),
            lobe(-1.0, 0.3, 0.35, Vec3::new(1.2, 1.4, 1.7), 18.0),
            lobe(1.0, 0.15, -0.2, Vec3::new(1.5, 1.35, 1.2), 22.0),
        ],
    }
}

fn put_cameras(builder: &mut SceneBuilder, layout: Layout) {
    const YFOV_RAD: f32 = 0.42;
    let target = Vec3::new(0.1, 1.0, 0.0);
    // Further back from a longer engine.
    let eye = target + Vec3::new(0.58, 0.36, 0.73).normalize() * (12.3 + 2.2 * layout.half());
    builder.camera(Camera::fixed("static", YFOV_RAD, eye, target));
    let lens = Lens::Perspective { yfov_rad: YFOV_RAD };
    builder.camera(Camera::orbit(lens, target, eye));
    let front = layout.half();
    let key = |time_secs, eye, target| CameraKey { time_secs, eye, target };
    builder.camera(Camera {
        name: "path".to_owned(),
        lens,
        motion: CameraMotion::Path {
            keys: vec![
                key(0.0, Vec3::new(3.0, 2.6, front + 11.0), Vec3::new(0.0, 1.5, front)),
                key(4.0, Vec3::new(6.5, 3.4, front + 5.0), Vec3::new(1.2, 1.8, 0.6 * front)),
                key(8.0, Vec3::new(9.0, 4.6, 0.0), Vec3::new(0.6, 1.4, 0.0)),
                key(12.0, Vec3::new(6.0, 7.5, -8.0 - front), Vec3::new(0.0, 1.4, -0.3 * front)),
            ],
        },
    });
}
