//! The motor while it is put together: how it is divided into banks and cylinders, and how parts are placed
//! and led through the cycle.

use std::f32::consts::{FRAC_PI_4, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};
use sheer_scene::model::{Interpolation, Keys, Track, Transform};

use super::{
    finish::Finish,
    kinematics::{SliderCrank, firing_angles, throws},
};
use crate::{
    builder::{Prop, SceneBuilder},
    kit::mechanical::stand,
    rng::Rng,
    shape::{Model, Shape},
};

/// Two turns of the crankshaft: one working cycle.
pub(super) const CYCLE_SECS: f32 = 6.0;
/// Keys of what does not turn evenly: one every three degrees of the crankshaft; the chord then misses the
/// curve by a ten-thousandth.
pub(super) const KEY_COUNT: u32 = 240;

/// 90 mm stroke, 92 mm bore and a rod of 150 mm: common for a V8 of five litres.
pub(super) const CRANK: SliderCrank = SliderCrank { crank_radius: 0.45, rod_length: 1.5 };
pub(super) const BORE_RADIUS: f32 = 0.46;
/// Distance of the axes of neighbouring cylinders of a bank.
pub(super) const SPACING: f32 = 1.15;
/// The two rods of a crank pin sit side by side, and so the banks are offset.
pub(super) const BANK_OFFSET: f32 = 0.12;
/// Height of the cylinder deck above the crank axis: clears the piston at its top by 0.3 mm.
pub(super) const DECK: f32 = 2.34;
/// The camshafts in the space of a bank; the intake's is at -x.
pub(super) const CAMSHAFT: Vec2 = Vec2::new(0.66, 3.95);

/// How the engine is divided along its crankshaft.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Cylinders of one bank; there are two.
    pub(super) cylinders: u32,
}

impl Layout {
    /// Middle of a crank pin; the first is at the front.
    pub(super) fn pin_z(self, index: u32) -> f32 {
        (0.5 * (self.cylinders as f32 - 1.0) - index as f32) * SPACING
    }

    /// Main bearings, one more than pins.
    pub(super) fn main_z(self) -> impl Iterator<Item = f32> {
        (0..=self.cylinders).map(move |index| (0.5 * self.cylinders as f32 - index as f32) * SPACING)
    }

    /// Half the length of the block.
    pub(super) fn half(self) -> f32 {
        0.5 * self.cylinders as f32 * SPACING + BANK_OFFSET
    }

    pub(super) fn cylinders(self) -> Vec<Cylinder> {
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
pub(super) struct Bank {
    /// 1 for the right bank, -1 for the left.
    pub(super) side: f32,
}

pub(super) const BANKS: [Bank; 2] = [Bank { side: 1.0 }, Bank { side: -1.0 }];

impl Bank {
    /// How far it leans clockwise.
    pub(super) fn tilt_rad(self) -> f32 {
        self.side * FRAC_PI_4
    }

    /// `world_from_bank`: a bank is modelled upright with its exhaust at +x; the left one is mirrored.
    pub(super) fn to_world(self) -> Affine3A {
        Affine3A::from_rotation_z(-self.tilt_rad()) * Affine3A::from_scale(Vec3::new(self.side, 1.0, 1.0))
    }

    /// A point of the bank's cross-section.
    pub(super) fn point(self, point: Vec2) -> Vec2 {
        self.to_world().transform_point3(point.extend(0.0)).truncate()
    }
}

/// One cylinder and when it fires.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cylinder {
    pub(super) bank: Bank,
    pub(super) z: f32,
    /// Direction of its crank pin at time zero, clockwise.
    pub(super) throw_rad: f32,
    /// Crank angle at which it fires, 0 to 4π.
    pub(super) fires_rad: f32,
}

impl Cylinder {
    /// How far its crank pin is past the top dead centre.
    pub(super) fn turn_rad(self, crank_rad: f32) -> f32 {
        crank_rad + self.throw_rad - self.bank.tilt_rad()
    }
}

/// The motor in the making.
pub(super) struct Assembly {
    pub(super) builder: SceneBuilder,
    pub(super) finish: Finish,
    pub(super) layout: Layout,
    pub(super) rng: Rng,
    pub(super) bolt: Prop,
}

impl Assembly {
    /// A part of one material, to be placed.
    pub(super) fn part(&mut self, name: &str, material: u32, draw: impl FnOnce(&mut Shape)) -> Prop {
        let mut model = Model::default();
        draw(model.paint(material, Vec3::ONE));
        self.builder.prop(name, model)
    }

    /// A part that stays where it is drawn.
    pub(super) fn put(&mut self, name: &str, material: u32, draw: impl FnOnce(&mut Shape)) {
        let part = self.part(name, material, draw);
        self.builder.place(&part, Affine3A::IDENTITY);
    }

    /// A part drawn in the space of a bank, once a bank.
    pub(super) fn put_on_banks(&mut self, name: &str, material: u32, draw: impl FnOnce(&mut Shape)) {
        let part = self.part(name, material, draw);
        for bank in BANKS {
            self.builder.place(&part, bank.to_world());
        }
    }

    /// A hexagon bolt, tightened as far as chance would have it; `seat` is where its head lies, `size` the
    /// radius of its shank.
    pub(super) fn bolt(&mut self, seat: Vec3, axis: Vec3, size: f32) {
        let turn = Affine3A::from_rotation_y(self.rng.between(0.0, TAU));
        self.builder.place(&self.bolt, stand(seat, axis) * turn * Affine3A::from_scale(Vec3::splat(size)));
    }

    /// A part that turns evenly around the z axis through `centre`: clockwise, so many turns a cycle.
    pub(super) fn put_turning(&mut self, part: &Prop, centre: Vec3, start_rad: f32, turns: f32) {
        // An eighth of a turn from key to key leaves no doubt which way round.
        let count = (8.0 * turns.abs()).ceil() as u32;
        let rotation = |share: f32| Quat::from_rotation_z(start_rad - TAU * turns * share);
        let rest = Transform::Trs { translation: centre, rotation: rotation(0.0), scale: Vec3::ONE };
        self.builder.place_moving(part, rest, vec![Track::Rotation(keys(count, rotation))]);
    }

    /// A part that is led as a function of the crank angle; its place at angle zero is its place at rest.
    pub(super) fn put_led(
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
pub(super) fn keys<T>(count: u32, value: impl Fn(f32) -> T) -> Keys<T> {
    let shares = (0..=count).map(|i| i as f32 / count as f32);
    Keys {
        times_secs: shares.clone().map(|share| share * CYCLE_SECS).collect(),
        values: shares.map(value).collect(),
        interpolation: Interpolation::Linear,
    }
}
