//! The view that is made up where a scene has no camera: three-quarter, as near as everything that is ever to
//! be seen allows in a picture of a given shape.
//!
//! The direction is chosen first, the eye follows in closed form. In a picture whose half width and half
//! height are tan_x and tan_y at distance 1, a point (x, y, z) of the camera's axes is inside if
//! |x - eye.x| ≤ (eye.z - z) tan_x, and so for y. Each of the four inequalities is the tightest for the point
//! that is furthest in one direction, so that four maxima over all points give the nearest eye.

use glam::{Affine3A, DVec2, DVec3, Mat3, Vec3};

use crate::{
    camera::{Camera, CameraMotion, ClipPlanes, Lens},
    frame::for_each_vertex_over_time,
    model::{Animation, Property, SceneParts},
};

/// Vertical field of view: that of a 50 mm lens would be 27°; a little wider shows more of the form.
const YFOV_RAD: f32 = 0.6;
/// Share of the picture's height and width that is filled, so that nothing touches an edge.
const FILL: f64 = 0.88;
/// A scene whose depth or height is less than this share of its other sides is flat.
const FLAT: f64 = 0.25;
/// Where the view comes from: in general, before what is flat like a board, above what is flat like a floor.
const DIRECTIONS: [DVec3; 3] =
    [DVec3::new(0.55, 0.42, 1.0), DVec3::new(0.22, 0.12, 1.0), DVec3::new(0.4, 0.9, 1.0)];
/// The eye keeps this share of the depth of what it sees before it: a line along the view would end in it.
const LEAST_GAP: f64 = 0.05;
/// Moments of a clip that are looked at, and as many keys at most: 24 a second of one of five seconds.
const MOST_MOMENTS: usize = 120;
/// What is looked at of a clip of many vertices: fewer moments, but at least these.
const FEWEST_MOMENTS: usize = 8;
/// Vertices that are moved in all, which takes about a fifth of a second.
const MOVED_VERTICES: usize = 8 << 20;
/// Ages of a particle that are looked at, from birth to death.
const AGES: u8 = 5;

/// A view of the whole scene at all times for a picture whose width is `aspect` times its height.
pub(crate) fn framing_camera(parts: &SceneParts, aspect: f32) -> Camera {
    let half_height = FILL * (0.5 * f64::from(YFOV_RAD)).tan();
    let slopes = DVec2::new(half_height * f64::from(aspect), half_height);
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    let mut fits = DIRECTIONS.map(|direction| Fit::new(direction, slopes));
    for_each_ball(parts, &mut |centre, radius| {
        low = low.min(centre - radius);
        high = high.max(centre + radius);
        fits.iter_mut().for_each(|fit| fit.include(centre, radius));
    });

    // Nothing to see: any view will do.
    if low.x > high.x {
        (low, high) = (DVec3::splat(-0.5), DVec3::splat(0.5));
        fits.iter_mut().for_each(|fit| fit.include(DVec3::ZERO, 0.5));
    }
    let extent = high - low;
    let [oblique, frontal, steep] = &fits;
    let fit = if extent.z < FLAT * extent.x.max(extent.y) {
        frontal
    } else if extent.y < FLAT * extent.x.max(extent.z) {
        steep
    } else {
        oblique
    };
    // Single precision moves the eye by this much, and every vertex, too.
    let rounding = f64::from(f32::EPSILON) * low.abs().max(high.abs()).max_element();
    let world_from_camera = fit.pose(rounding);
    Camera {
        name: "static".to_owned(),
        lens: Lens::Perspective { yfov_rad: YFOV_RAD },
        clip: ClipPlanes::NONE,
        motion: CameraMotion::Still { world_from_camera },
    }
}

/// The nearest eye that sees everything included, for one direction.
struct Fit {
    right: DVec3,
    up: DVec3,
    back: DVec3,
    /// Half width and half height of the filled part of the picture at distance 1.
    slopes: DVec2,
    /// Largest of x + z tan_x and y + z tan_y.
    upper: DVec2,
    /// Largest of -x + z tan_x and -y + z tan_y.
    lower: DVec2,
    nearest: f64,
    furthest: f64,
}

impl Fit {
    fn new(direction: DVec3, slopes: DVec2) -> Self {
        let back = direction.normalize();
        let right = DVec3::Y.cross(back).normalize();
        Self {
            right,
            up: back.cross(right),
            back,
            slopes,
            upper: DVec2::NEG_INFINITY,
            lower: DVec2::NEG_INFINITY,
            nearest: f64::NEG_INFINITY,
            furthest: f64::INFINITY,
        }
    }

    fn include(&mut self, centre: DVec3, radius: f64) {
        let beside = DVec2::new(centre.dot(self.right), centre.dot(self.up));
        let depth = centre.dot(self.back);
        // A ball touches the slanted sides of the view with a point that is not its outermost.
        let ahead = depth * self.slopes + radius * (1.0 + self.slopes * self.slopes).map(f64::sqrt);
        self.upper = self.upper.max(beside + ahead);
        self.lower = self.lower.max(ahead - beside);
        self.nearest = self.nearest.max(depth + radius);
        self.furthest = self.furthest.min(depth - radius);
    }

    /// `world_from_camera`, for points that may be off by `rounding`.
    fn pose(&self, rounding: f64) -> Affine3A {
        let (upper, lower) = (self.upper + rounding, self.lower + rounding);
        let beside = 0.5 * (upper - lower);
        let gap = LEAST_GAP * (self.nearest - self.furthest) + rounding;
        let depth = (0.5 * (upper + lower) / self.slopes).max_element().max(self.nearest + gap);
        // A point alone is looked at from a unit away.
        let depth = if depth > self.furthest { depth } else { self.furthest + 1.0 };
        let eye = self.right * beside.x + self.up * beside.y + self.back * depth;
        let axes = [self.right, self.up, self.back].map(|axis| axis.as_vec3());
        Affine3A::from_mat3_translation(Mat3::from_cols(axes[0], axes[1], axes[2]), eye.as_vec3())
    }
}

/// Calls `visit` with all that is ever to be seen, world: centres and radii, 0 for a vertex.
fn for_each_ball(parts: &SceneParts, visit: &mut impl FnMut(DVec3, f64)) {
    let mut visit_finite = |centre: Vec3, radius: f32| {
        if centre.is_finite() && radius.is_finite() {
            visit(centre.as_dvec3(), f64::from(radius));
        }
    };
    for_each_vertex_over_time(parts, &moments(parts), &mut |position| visit_finite(position, 0.0));
    for system in &parts.particles {
        for (index, particle) in system.particles.iter().enumerate() {
            let lifetime_secs = if particle.lifetime_secs.is_finite() { particle.lifetime_secs } else { 0.0 };
            for age in 0..AGES {
                let share = f32::from(age) / f32::from(AGES - 1);
                let state = system.state_at(index, particle.birth_secs + share * lifetime_secs);
                if let Some(state) = state {
                    visit_finite(state.centre, state.half_size * std::f32::consts::SQRT_2);
                }
            }
        }
    }
}

/// Times at which a clip is looked at: evenly over its longest animation, and at keys, where what moves turns
/// around; time zero where nothing moves.
fn moments(parts: &SceneParts) -> Vec<f32> {
    let channels = || parts.animations.iter().flat_map(|animation| &animation.channels);
    let end_secs = parts.animations.iter().map(Animation::duration_secs).fold(0.0, f32::max);
    if end_secs <= 0.0 {
        return vec![0.0];
    }
    let vertices = |mesh: u32| parts.meshes[mesh as usize].positions.len();
    let vertex_count: usize = parts.instances.iter().map(|instance| vertices(instance.mesh)).sum();
    let count = (MOVED_VERTICES / vertex_count.max(1)).clamp(FEWEST_MOMENTS, MOST_MOMENTS);
    // The last moment is just before the end, at which the clip begins anew.
    let last = end_secs.next_down();
    // So does what is shown and hidden.
    let properties = parts.animations.iter().flat_map(|animation| &animation.properties);
    let shows = properties.filter_map(|property| match property {
        Property::Visibility { visible, .. } => Some(&visible.times_secs),
        _ => None,
    });
    let moves = channels().flat_map(|channel| channel.track.times_secs());
    let mut keys: Vec<f32> = moves.chain(shows.flatten()).copied().collect();
    keys.retain(|secs| (0.0..last).contains(secs));
    keys.sort_unstable_by(f32::total_cmp);
    keys.dedup();
    let step = keys.len().div_ceil(count).max(1);
    let evenly = (0..count).map(|index| last * index as f32 / (count - 1) as f32);
    evenly.chain(keys.into_iter().step_by(step)).collect()
}
