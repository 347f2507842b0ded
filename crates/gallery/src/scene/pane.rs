//! `pane`: one transparent pane in the town square, for how a constant alpha behaves under a still and a
//! moving camera (STD Fig. 6, 7).

use glam::{Affine3A, Quat, Vec3, Vec4};
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
    model::{AlphaMode, Material},
};

use crate::{builder::SceneBuilder, kit::square, seed::SEED, shape::Model};

pub(crate) const PARAMETERS: &[ParameterInfo] = &[
    ParameterInfo {
        key: "alpha",
        default: "0.5",
        range: ParameterRange::Real(0.0, 1.0),
        what: "opacity of the pane",
    },
    SEED,
];

const YFOV_RAD: f32 = 0.80;

pub(crate) fn build(values: &Values) -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new("pane", square::sky());
    let palette = square::raise(&mut builder, values.count(SEED.key));

    let material = builder.material(Material {
        name: "pane".to_owned(),
        base_colour: Vec4::new(0.34, 0.62, 0.74, values.real("alpha")),
        alpha_mode: AlphaMode::Blend,
        roughness: 0.35,
        double_sided: true,
        ..Material::default()
    });
    // The pane hangs in a slender frame that stands on two feet.
    let (low, high) = (Vec3::new(-2.3, 0.62, 0.0), Vec3::new(2.3, 3.22, 0.0));
    let mut frame = Model::default();
    let iron = frame.paint(palette.iron, Vec3::splat(0.05));
    for x in [low.x - 0.04, high.x + 0.04] {
        iron.beam(Vec3::new(x, 0.0, 0.0), Vec3::new(x, high.y + 0.08, 0.0), Vec3::X, 0.08, 0.08);
        iron.beam(Vec3::new(x, 0.04, -0.5), Vec3::new(x, 0.04, 0.5), Vec3::X, 0.1, 0.08);
    }
    for y in [low.y - 0.04, high.y + 0.04] {
        iron.beam(Vec3::new(low.x, y, 0.0), Vec3::new(high.x, y, 0.0), Vec3::Y, 0.08, 0.08);
    }
    let place = Affine3A::from_rotation_translation(Quat::from_rotation_y(-0.12), Vec3::new(2.4, 0.0, 5.0));
    builder.put_at("frame", frame, place);
    let mut pane = Model::default();
    pane.paint(material, Vec3::ONE).panel(low, Vec3::X * (high.x - low.x), Vec3::Y * (high.y - low.y));
    builder.put_at("pane", pane, place);

    builder.camera(Camera::fixed("static", YFOV_RAD, Vec3::new(0.6, 1.75, 12.0), Vec3::new(1.0, 2.5, -4.0)));
    let key = |time_secs, x: f32| CameraKey {
        time_secs,
        eye: Vec3::new(x, 1.75, 12.0),
        target: Vec3::new(0.6 * x + 0.6, 2.5, -4.0),
    };
    builder.camera(Camera {
        name: "path".to_owned(),
        lens: Lens::Perspective { yfov_rad: YFOV_RAD },
        clip: ClipPlanes::NONE,
        motion: CameraMotion::Path { keys: vec![key(0.0, -4.0), key(4.0, 0.6), key(8.0, 5.2)] },
    });
    let middle = place.transform_point3(0.5 * (low + high));
    // Around the pane; the circle that fits the whole town would run through its walls.
    let eye = middle + Vec3::new(1.5, 0.6, 6.0);
    builder.camera(Camera::orbit(Lens::Perspective { yfov_rad: YFOV_RAD }, middle, eye));
    builder.finish()
}

#[cfg(test)]
mod tests {
    use crate::catalogue;
    use sheer_scene::model::AlphaMode;

    #[test]
    fn the_pane_is_the_only_thing_that_blends_and_has_the_asked_for_alpha() {
        let scene = catalogue::build("pane:alpha=0.3").unwrap();
        let parts = scene.parts();
        let blended: Vec<_> = parts.materials.iter().filter(|m| m.alpha_mode == AlphaMode::Blend).collect();
        assert_eq!(blended.len(), 1);
        assert_eq!(blended[0].base_colour.w, 0.3);
        assert!(parts.particles.is_empty());
    }
}
