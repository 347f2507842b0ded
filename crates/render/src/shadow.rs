//! Deep shadow rays: how much light passes everything between a point and a light (STD section 3.1).

use glam::Vec3;
use sheer_accel::{Bvh, Ray};
use sheer_scene::Frame;

use crate::contract::{MIN_ALPHA, MIN_VISIBILITY};

/// Transmittance from `origin` over `distance` along a unit direction, 0 to 1.
pub(crate) fn deep(frame: &Frame, bvh: &Bvh, origin: Vec3, direction: Vec3, distance: f32) -> f32 {
    let mut transmittance = 1.0;
    let ray = Ray { origin, direction, t_min: 0.0, t_max: distance };
    bvh.traverse(&ray, |hit| {
        let alpha = frame.opacity(hit.triangle, hit.u, hit.v);
        if alpha >= MIN_ALPHA {
            transmittance *= 1.0 - alpha;
        }
        if transmittance <= MIN_VISIBILITY {
            transmittance = 0.0;
            return f32::NEG_INFINITY;
        }
        distance
    });
    transmittance
}
