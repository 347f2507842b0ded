//! All that lies behind a point of the picture, for tools that explain a pixel.

use glam::{UVec2, Vec2, Vec3};
use sheer_accel::{Hit, Ray};
use sheer_scene::CameraRay;

use crate::{contract::MIN_ALPHA, stage::Stage};

/// A surface that the camera's ray through a point of the picture meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayFragment {
    /// Number of the triangle in the stage's frame.
    pub triangle: u32,
    /// From where the ray begins, world units.
    pub distance: f32,
    /// Opacity as the camera sees it, [`MIN_ALPHA`] to 1.
    pub alpha: f32,
    /// The share of light from behind that passes, red, green and blue: 1 − `alpha` but for coloured glass.
    pub transmittance: Vec3,
}

impl Stage {
    /// The fragments that the camera's ray through a point meets, front to back, up to and with the first
    /// opaque one; triangles in one place come in the order of their numbers. What `baseline` shades there,
    /// whose ray goes through the middle of the pixel where nothing jitters it. `point_px`: pixels from the
    /// upper left corner of a picture of `size` pixels.
    ///
    /// ```
    /// use glam::Vec2;
    /// use sheer_render::Stage;
    ///
    /// let scene = sheer_gallery::open("layers:count=3,alpha=0.5")?.scene;
    /// let stage = Stage::new(scene, &Default::default(), None)?;
    /// let fragments = stage.fragments_through(Vec2::new(32.5, 18.5), [64, 36]);
    /// let alphas: Vec<f32> = fragments.iter().map(|fragment| fragment.alpha).collect();
    /// assert_eq!(alphas, [0.5, 0.5, 0.5, 1.0]); // and the wall behind
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn fragments_through(&self, point_px: Vec2, size: [u32; 2]) -> Vec<RayFragment> {
        let frame = self.frame();
        let size = UVec2::from(size).as_vec2();
        let beam = frame.camera().pixel_beam(size.y);
        let CameraRay { origin, direction, nearest, furthest } = frame.camera().ray(point_px, size);
        let ray = Ray { origin, direction, t_min: nearest, t_max: furthest };
        let mut fragments = Vec::new();
        let mut nearest_opaque = furthest;
        self.bvh().traverse(&ray, |Hit { t, u, v, triangle, front }| {
            let width = beam.width_at(t);
            let alpha = frame.opacity_for_camera(triangle, u, v, front, width);
            if alpha >= MIN_ALPHA {
                let transmittance = frame.light_through(triangle, u, v, front, alpha, width);
                fragments.push(RayFragment { triangle, distance: t, alpha, transmittance });
            }
            if alpha >= 1.0 {
                nearest_opaque = nearest_opaque.min(t);
            }
            nearest_opaque
        });
        fragments.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.triangle.cmp(&b.triangle)));
        let seen =
            fragments.iter().position(|fragment| fragment.alpha >= 1.0).map_or(fragments.len(), |at| at + 1);
        fragments.truncate(seen);
        fragments
    }
}
