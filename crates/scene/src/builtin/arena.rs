//! `arena`: heroes and raiders fight in a ring of stone at dusk, and a golem breathes fire (STD Fig. 1, 8 and 11).
//!
//! Many small transparent things of middling opacity overlap: shields one in front of another, runes, fire, drops, dust and health bars. Their
//! number rises to two thirds of the clip and falls again; the clip loops.

use glam::Vec3;

use super::{
    ParameterInfo, ParameterRange, SEED, Values, arena_cast, arena_place,
    arena_spell::{self, Effects},
    palette::Palette,
    stage::Stage,
};
use crate::{
    SceneError,
    camera::{Camera, CameraKey, CameraMotion, Lens},
    scene::Scene,
};

pub(super) const PARAMETERS: &[ParameterInfo] = &[
    ParameterInfo {
        key: "effects",
        default: "1.0",
        range: ParameterRange::Real(0.0, 8.0),
        what: "factor on the number of effects; 0 shows the figures alone",
    },
    SEED,
];

/// The clip starts anew after this time.
pub(super) const CLIP_SECS: f32 = 10.0;
const YFOV_RAD: f32 = 0.70;

pub(super) fn build(values: &Values) -> Result<Scene, SceneError> {
    let seed = values.count(SEED.key);
    let mut stage = Stage::new("arena", arena_place::dusk());
    let palette = Palette::new(&mut stage, seed);
    arena_place::raise(&mut stage, &palette, seed);
    let cast = arena_cast::assemble(&mut stage, &palette, seed);
    arena_spell::conjure(&mut stage, &cast, Effects { amount: values.real("effects"), seed });

    stage.camera(Camera::fixed("static", YFOV_RAD, Vec3::new(-0.9, 2.75, 10.5), Vec3::new(0.10, 1.85, -1.0)));
    let key = |time_secs, eye: Vec3, target: Vec3| CameraKey { time_secs, eye, target };
    stage.camera(Camera {
        name: "path".to_owned(),
        lens: Lens::Perspective { yfov_rad: 0.80 },
        motion: CameraMotion::Path {
            keys: vec![
                key(0.0, Vec3::new(-7.6, 3.2, 5.8), Vec3::new(0.2, 1.6, -0.5)),
                key(2.5, Vec3::new(-4.4, 1.9, 6.4), Vec3::new(0.6, 1.8, -0.6)),
                key(5.0, Vec3::new(-0.9, 1.7, 7.4), Vec3::new(0.5, 2.0, -1.2)),
                key(7.0, Vec3::new(3.6, 2.1, 7.6), Vec3::new(0.2, 2.0, -1.2)),
                key(10.0, Vec3::new(8.6, 3.2, 5.0), Vec3::new(0.0, 1.7, -0.6)),
            ],
        },
    });
    // Within the ring: a wider circle would run through the pillars.
    let (target, eye) = (Vec3::new(0.0, 1.7, 0.0), Vec3::new(-0.6, 2.7, 9.4));
    stage.camera(Camera::orbit(Lens::Perspective { yfov_rad: 0.80 }, target, eye));
    stage.finish()
}
