//! Cameras and where they are at a time.

use std::f32::consts::TAU;

use glam::{Affine3A, Mat3, Vec2, Vec3, Vec3Swizzles as _};

/// The side of what a sample sees of a pixel's side. Jittered samples average over the pixel by themselves,
/// and a lookup reaches over twice its footprint: a whole pixel blurs the moving pane, still and exact, to an
/// SSIM of 0.94 against the same without levels; half of one leaves 0.98 and still has no texel skipped.
const BEAM_SHARE: f32 = 0.5;
/// Time of one turn of an orbit: slow enough to look, short enough for a clip.
const ORBIT_PERIOD_SECS: f32 = 12.0;

/// A camera of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name for `--camera NAME`; built-in scenes use `static` and `path`.
    pub name: String,
    /// What the camera sees from where it is.
    pub lens: Lens,
    /// Nothing nearer or further is seen.
    pub clip: ClipPlanes,
    /// Where it is at a time.
    pub motion: CameraMotion,
}

/// The depths along the viewing axis between which a camera sees, world units. They cut the view alone: what
/// is not seen casts shadows all the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlanes {
    /// At least 0.
    pub near: f32,
    /// Above `near`; may be infinite.
    pub far: f32,
}

impl ClipPlanes {
    /// Cuts nothing.
    pub const NONE: Self = Self { near: 0.0, far: f32::INFINITY };
}

impl Default for ClipPlanes {
    fn default() -> Self {
        Self::NONE
    }
}

/// What a camera sees from where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// A pinhole: what is further away is smaller.
    Perspective {
        /// Full vertical field of view, radians.
        yfov_rad: f32,
    },
    /// Parallel rays: what is further away is as large as what is near.
    Orthographic {
        /// Half the height of the view, world units.
        half_height: f32,
    },
}

/// Where a camera is at a time.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraMotion {
    /// It hangs on a node, animated or not.
    Node(u32),
    /// It stands still.
    Still {
        /// Rigid; the camera looks along its own -Z, +Y is up.
        world_from_camera: Affine3A,
    },
    /// A smooth path through keys: a cubic Hermite spline whose tangents are finite differences, held before
    /// the first key and after the last.
    Path {
        /// Keys in order of time, at least one; with one key the camera is static.
        keys: Vec<CameraKey>,
    },
    /// A full turn around a point.
    Orbit {
        /// The middle of the circle, and what is looked at.
        target: Vec3,
        /// Eye at time zero.
        eye: Vec3,
        /// Time of one turn.
        period_secs: f32,
    },
}

/// One key of a camera path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraKey {
    /// When the camera is there, seconds.
    pub time_secs: f32,
    /// Where the camera is, world.
    pub eye: Vec3,
    /// Looked-at point in world; never the eye itself.
    pub target: Vec3,
}

/// A camera at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPose {
    /// Rigid; the camera looks along its own -Z, +Y is up.
    pub world_from_camera: Affine3A,
    /// What the camera sees from where it is.
    pub lens: Lens,
    /// Nothing nearer or further is seen.
    pub clip: ClipPlanes,
}

/// How wide the beam of a sample in the middle of an image is along its ray; beams towards the corners of a
/// perspective image are taken for as wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelBeam {
    /// Where the ray begins, world units: 0 of a perspective camera.
    pub width: f32,
    /// What it grows by along a world unit: 0 of an orthographic camera.
    pub growth: f32,
}

impl PixelBeam {
    /// The width at a distance.
    #[must_use]
    #[inline]
    pub fn width_at(&self, distance: f32) -> f32 {
        self.width + self.growth * distance
    }
}

/// A ray of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraRay {
    /// Where it starts, world.
    pub origin: Vec3,
    /// Unit direction in world.
    pub direction: Vec3,
    /// Distance along the ray from which on the camera sees, world units.
    pub nearest: f32,
    /// Distance up to which it does; may be infinite.
    pub furthest: f32,
}

impl Camera {
    /// A camera that stands still.
    #[must_use]
    pub fn fixed(name: &str, yfov_rad: f32, eye: Vec3, target: Vec3) -> Self {
        Self {
            name: name.to_owned(),
            lens: Lens::Perspective { yfov_rad },
            clip: ClipPlanes::NONE,
            motion: CameraMotion::Path { keys: vec![CameraKey { time_secs: 0.0, eye, target }] },
        }
    }

    /// A camera that stays where it is.
    #[must_use]
    pub fn still(name: &str, pose: CameraPose) -> Self {
        let CameraPose { world_from_camera, lens, clip } = pose;
        Self { name: name.to_owned(), lens, clip, motion: CameraMotion::Still { world_from_camera } }
    }

    /// A camera that circles a point it looks at, once in twelve seconds, starting from `eye`.
    #[must_use]
    pub fn orbit(lens: Lens, target: Vec3, eye: Vec3) -> Self {
        let motion = CameraMotion::Orbit { target, eye, period_secs: ORBIT_PERIOD_SECS };
        Self { name: "orbit".to_owned(), lens, clip: ClipPlanes::NONE, motion }
    }

    /// The pose at a time of a camera on a path or an orbit; `None` for one that hangs on a node, which goes
    /// where the animation takes it.
    #[must_use]
    pub fn pose_on_rails(&self, time_secs: f32) -> Option<CameraPose> {
        match &self.motion {
            CameraMotion::Node(_) => None,
            CameraMotion::Still { world_from_camera } => {
                Some(CameraPose { world_from_camera: *world_from_camera, lens: self.lens, clip: self.clip })
            }
            CameraMotion::Path { keys } => {
                let (eye, target) = along_path(keys, time_secs);
                Some(CameraPose { clip: self.clip, ..CameraPose::looking_at(self.lens, eye, target) })
            }
            CameraMotion::Orbit { target, eye, period_secs } => {
                let rotation = Mat3::from_rotation_y(TAU * time_secs / period_secs);
                let pose = CameraPose::looking_at(self.lens, *target + rotation * (*eye - *target), *target);
                Some(CameraPose { clip: self.clip, ..pose })
            }
        }
    }
}

impl CameraPose {
    /// Placed at `eye`, looking at `target`, +Y up (any up if looking straight along it), without clip
    /// planes.
    #[must_use]
    pub fn looking_at(lens: Lens, eye: Vec3, target: Vec3) -> Self {
        Self::looking_at_with_up(lens, eye, target, Vec3::Y)
    }

    /// The same with another direction up in the picture, of any length; any up if it is none or looking
    /// straight along it.
    #[must_use]
    pub fn looking_at_with_up(lens: Lens, eye: Vec3, target: Vec3, up: Vec3) -> Self {
        let back = (eye - target).try_normalize().unwrap_or(Vec3::Z);
        let up = up.try_normalize().unwrap_or(Vec3::Y);
        let up = if back.dot(up).abs() > 0.9999 { up.zxy() } else { up };
        let right = up.cross(back).normalize();
        let rotation = Mat3::from_cols(right, back.cross(right), back);
        Self {
            world_from_camera: Affine3A::from_mat3_translation(rotation, eye),
            lens,
            clip: ClipPlanes::NONE,
        }
    }

    /// Where the camera is, world.
    #[must_use]
    pub fn eye(&self) -> Vec3 {
        self.world_from_camera.translation.into()
    }

    /// Unit viewing direction in world.
    #[must_use]
    pub fn forward(&self) -> Vec3 {
        -Vec3::from(self.world_from_camera.matrix3.z_axis)
    }

    /// The ray through `pixel` (pixel units, origin in the upper left corner, centres at halves) of an image
    /// of `size` pixels.
    #[must_use]
    pub fn ray(&self, pixel: Vec2, size: Vec2) -> CameraRay {
        // Times the reciprocal: a GPU's division need not round like ours, and a last bit decides which of
        // two coincident surfaces is in front.
        let ndc = Vec2::new(2.0 * pixel.x - size.x, size.y - 2.0 * pixel.y) * size.y.recip();
        match self.lens {
            Lens::Perspective { yfov_rad } => {
                let in_camera = (ndc * (0.5 * yfov_rad).tan()).extend(-1.0);
                let direction = self.world_from_camera.transform_vector3(in_camera).normalize();
                // Clip planes lie across the axis: rays beside it reach them later.
                let stretch = direction.dot(self.forward()).recip();
                CameraRay {
                    origin: self.eye(),
                    direction,
                    nearest: self.clip.near * stretch,
                    furthest: self.clip.far * stretch,
                }
            }
            Lens::Orthographic { half_height } => {
                let origin = self.world_from_camera.transform_point3((ndc * half_height).extend(0.0));
                CameraRay {
                    origin,
                    direction: self.forward(),
                    nearest: self.clip.near,
                    furthest: self.clip.far,
                }
            }
        }
    }

    /// The beam of a sample of a pixel of an image that is `height` pixels high.
    #[must_use]
    pub fn pixel_beam(&self, height: f32) -> PixelBeam {
        let side = BEAM_SHARE * 2.0 * height.recip();
        match self.lens {
            Lens::Perspective { yfov_rad } => PixelBeam { width: 0.0, growth: side * (0.5 * yfov_rad).tan() },
            Lens::Orthographic { half_height } => PixelBeam { width: side * half_height, growth: 0.0 },
        }
    }

    /// Distance of a world point along the viewing axis.
    #[must_use]
    pub fn view_depth(&self, point_in_world: Vec3) -> f32 {
        (point_in_world - self.eye()).dot(self.forward())
    }

    /// Where a world point appears, in pixels; `None` behind a perspective camera.
    #[must_use]
    pub fn project(&self, point_in_world: Vec3, size: Vec2) -> Option<Vec2> {
        let in_camera = self.world_from_camera.matrix3.transpose() * (point_in_world - self.eye());
        let ndc = match self.lens {
            Lens::Perspective { yfov_rad } => {
                if in_camera.z >= 0.0 {
                    return None;
                }
                in_camera.truncate() / (-in_camera.z * (0.5 * yfov_rad).tan())
            }
            Lens::Orthographic { half_height } => in_camera.truncate() / half_height,
        };
        Some(Vec2::new(ndc.x * size.y + size.x, size.y - ndc.y * size.y) * 0.5)
    }

    /// Where a direction at infinity appears, in pixels; `None` behind a perspective camera.
    #[must_use]
    pub fn project_direction(&self, direction_in_world: Vec3, size: Vec2) -> Option<Vec2> {
        match self.lens {
            Lens::Perspective { .. } => self.project(self.eye() + direction_in_world, size),
            Lens::Orthographic { .. } => None,
        }
    }
}

/// Cubic Hermite through the keys with finite-difference tangents, so that uneven key times do not overshoot.
fn along_path(keys: &[CameraKey], time_secs: f32) -> (Vec3, Vec3) {
    let next = keys.partition_point(|key| key.time_secs <= time_secs);
    let (Some(previous), Some(following)) = (next.checked_sub(1), keys.get(next)) else {
        let held = keys[next.saturating_sub(1)];
        return (held.eye, held.target);
    };
    let span_secs = following.time_secs - keys[previous].time_secs;
    let s = (time_secs - keys[previous].time_secs) / span_secs;
    let spline = |value: &dyn Fn(usize) -> Vec3| {
        let slope = |at: usize| {
            let (low, high) = (at.saturating_sub(1), (at + 1).min(keys.len() - 1));
            (value(high) - value(low)) / (keys[high].time_secs - keys[low].time_secs)
        };
        value(previous).hermite_to(value(next), slope(previous) * span_secs, slope(next) * span_secs, s)
    };
    (spline(&|at| keys[at].eye), spline(&|at| keys[at].target))
}

trait Hermite {
    fn hermite_to(self, end: Self, start_tangent: Self, end_tangent: Self, s: f32) -> Self;
}

impl Hermite for Vec3 {
    fn hermite_to(self, end: Self, start_tangent: Self, end_tangent: Self, s: f32) -> Self {
        let (s2, s3) = (s * s, s * s * s);
        self * (2.0 * s3 - 3.0 * s2 + 1.0)
            + start_tangent * (s3 - 2.0 * s2 + s)
            + end * (3.0 * s2 - 2.0 * s3)
            + end_tangent * (s3 - s2)
    }
}
