//! `calibration`: ten opacity levels, each above the opaque grey of the same value (STD Fig. 2, to which Eq.
//! 5 was fitted).

use glam::{Vec3, Vec4};
use sheer_core::parameter::{ParameterInfo, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
    environment::Environment,
    model::{AlphaMode, Material, ShadingModel},
};

use crate::{builder::SceneBuilder, seed::SEED, shape::Model};

pub(crate) const PARAMETERS: &[ParameterInfo] = &[SEED];

/// 0.1, 0.2, … 1.0.
const LEVEL_COUNT: u32 = 10;
/// The plane fills a 16:9 picture exactly.
const HALF_WIDTH: f32 = 16.0 / 9.0;

pub(crate) fn build(_: &Values) -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new("calibration", Environment::black());
    let luminous = |name: &str, alpha_mode| Material {
        name: name.to_owned(),
        model: ShadingModel::Luminous,
        alpha_mode,
        ..Material::default()
    };
    let white = builder.material(luminous("white of ten opacities", AlphaMode::Blend));
    let grey = builder.material(luminous("ten greys", AlphaMode::Opaque));

    let (mut transparent, mut opaque) = (Model::default(), Model::default());
    let width = 2.0 * HALF_WIDTH / LEVEL_COUNT as f32;
    for level in 1..=LEVEL_COUNT {
        let value = level as f32 / LEVEL_COUNT as f32;
        let left = -HALF_WIDTH + (level - 1) as f32 * width;
        let (right, up) = (Vec3::X * width, Vec3::Y);
        let upper = transparent.paint(white, Vec3::ONE).brush(Vec3::ONE.extend(value));
        upper.panel(Vec3::new(left, 0.0, 0.0), right, up);
        let lower = opaque.paint(grey, Vec3::ONE).brush(Vec4::new(value, value, value, 1.0));
        lower.panel(Vec3::new(left, -1.0, 0.0), right, up);
    }
    builder.put("ten opacities", transparent);
    builder.put("ten greys", opaque);

    let key = CameraKey { time_secs: 0.0, eye: Vec3::Z, target: Vec3::ZERO };
    builder.camera(Camera {
        name: "static".to_owned(),
        lens: Lens::Orthographic { half_height: 1.0 },
        clip: ClipPlanes::NONE,
        motion: CameraMotion::Path { keys: vec![key] },
    });
    builder.finish()
}

#[cfg(test)]
mod tests {
    use crate::catalogue;

    #[test]
    fn every_column_has_the_same_value_above_as_opacity_and_below_as_grey() {
        let scene = catalogue::build("calibration").unwrap();
        let [upper, lower] = scene.parts().meshes.as_slice() else { panic!("two halves") };
        assert_eq!((upper.colours.len(), lower.colours.len()), (40, 40));
        for (above, below) in upper.colours.iter().zip(&lower.colours) {
            assert_eq!((above.w, above.x), (below.x, 1.0));
        }
    }
}
