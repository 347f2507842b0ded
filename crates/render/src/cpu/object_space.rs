//! Where on its object a hit lies, and how much of the object a pixel covers there.

use glam::{Vec2, Vec3};
use sheer_accel::Hit;
use sheer_scene::CameraRay;

use super::tracer::Tracer;

impl Tracer<'_> {
    /// The hit in the space of its object, and the longer of the two lengths there between it and where the
    /// rays of the pixels to the right and below meet the triangle's plane. That length is infinite where
    /// they pass it by.
    pub(super) fn object_space(&self, at: [u32; 2], hit: &Hit) -> (Vec3, f32) {
        let frame = self.stage.frame();
        let [a, b, c] = frame.corners_in_object(hit.triangle);
        let in_object = |u: f32, v: f32| a + u * (b - a) + v * (c - a);
        let position = in_object(hit.u, hit.v);
        let corners = frame.corners(hit.triangle);
        let sample = self.sample(at);
        let footprint = [Vec2::X, Vec2::Y].map(|step| {
            let Some([u, v]) = plane_hit(corners, &self.camera_ray(sample + step)) else {
                return f32::INFINITY;
            };
            in_object(u, v).distance(position)
        });
        (position, footprint[0].max(footprint[1]))
    }
}

/// Barycentric weights of the second and third corner where a ray meets a triangle's plane; none if it does
/// not in front of its origin (Möller and Trumbore 1997, without the bounds of the triangle).
fn plane_hit([a, b, c]: [Vec3; 3], ray: &CameraRay) -> Option<[f32; 2]> {
    let (to_b, to_c, to_origin) = (b - a, c - a, ray.origin - a);
    let (p, q) = (ray.direction.cross(to_c), to_origin.cross(to_b));
    let scale = to_b.dot(p).recip();
    let (u, v, t) = (to_origin.dot(p) * scale, ray.direction.dot(q) * scale, to_c.dot(q) * scale);
    (t > 0.0 && u.is_finite() && v.is_finite()).then_some([u, v])
}

#[cfg(test)]
mod tests {
    use sheer_scene::CameraChoice;

    use super::*;
    use crate::{
        settings::{Background, FrameSettings, Settings},
        shadow::Shadows,
        stage::Stage,
    };

    #[test]
    fn a_ray_meets_the_plane_in_and_beyond_the_triangle() {
        let corners = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 4.0];
        let from = |x, y, direction| CameraRay {
            origin: Vec3::new(x, y, 5.0),
            direction,
            nearest: 0.0,
            furthest: f32::INFINITY,
        };
        assert_eq!(plane_hit(corners, &from(1.0, 1.0, Vec3::NEG_Z)), Some([0.5, 0.25]));
        assert_eq!(plane_hit(corners, &from(-2.0, 8.0, Vec3::NEG_Z)), Some([-1.0, 2.0]));
        assert_eq!(plane_hit(corners, &from(1.0, 1.0, Vec3::Z)), None, "it lies behind");
        assert_eq!(plane_hit(corners, &from(1.0, 1.0, Vec3::X)), None, "it runs beside");
    }

    #[test]
    fn the_footprint_is_the_distance_to_the_neighbours_own_hits() {
        let scene = sheer_gallery::open("layers:count=1").unwrap().scene;
        let stage = Stage::new(scene, &CameraChoice::Default, Some(1)).unwrap();
        for jitter in [Vec2::ZERO, Vec2::new(0.3, -0.2)] {
            let run = Settings { size: [64, 36], background: Background::None, ..Settings::default() };
            let settings = FrameSettings { run, frame: 0, jitter, layers: None, is_still: true };
            let shadows = Shadows::new(&stage, &run.shadow, 0, 0).unwrap();
            let tracer = Tracer::new(&stage, &settings, &shadows, sheer_core::coverage::Correction::NONE);
            let at = |pixel| {
                let ray = tracer.ray(&tracer.camera_ray(tracer.sample(pixel)));
                tracer.object_space(pixel, &stage.bvh().closest(&ray, |_| true).unwrap())
            };
            // Both triangles of the layer are met.
            for [x, y] in [[5, 3], [5, 30], [60, 3], [60, 30]] {
                let (here, footprint) = at([x, y]);
                let expected = here.distance(at([x + 1, y]).0).max(here.distance(at([x, y + 1]).0));
                assert!(
                    expected > 0.0 && (footprint / expected - 1.0).abs() < 1e-3,
                    "{footprint}, {expected}"
                );
            }
        }
    }
}
