//! `motor`: a V engine as a CAD program shows it, transparent all over: hundreds of parts behind and inside
//! one another (ST Fig. 2, 4).
//!
//! Lengths are decimetres: the exhibit is ten times life size. The crankshaft lies on the z axis with its
//! front towards +z; each bank of cylinders is modelled upright with its exhaust towards +x and then tilted,
//! the left one mirrored. The clip is one working cycle.

use glam::{Vec2, Vec3};
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
    environment::{Environment, Lobe},
};

use crate::{
    builder::SceneBuilder,
    kit::mechanical::{circle, ring},
    rng::Rng,
    seed::SEED,
    shape::{Model, Shape},
};

mod ancillaries;
mod assembly;
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

use assembly::{Assembly, Layout};
use finish::Finish;

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
    // The upper end of the shank is hidden in the washer.
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
        ..Environment::black()
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
        clip: ClipPlanes::NONE,
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
