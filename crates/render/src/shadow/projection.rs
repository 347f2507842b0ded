//! From world to the texels of a light's map: parallel for the sun, central for a spot, six squares around a
//! point.

use std::f32::consts::FRAC_PI_3;

use glam::{Mat3, Vec2, Vec3};
use sheer_accel::Ray;
use sheer_scene::{Frame, FrameLight, model::LightKind};

use super::technique::Receiver;
use crate::stage::Stage;

/// Spots that open wider than this from their axis get the six squares of a point: one square would spend its
/// texels on its corners.
const WIDEST_SPOT_RAD: f32 = FRAC_PI_3;
/// Texels of a parallel map grow in steps of this factor with what they have to cover, so that the map of a
/// still town does not crawl when a puff of smoke drifts.
const TEXEL_STEP: f32 = 1.09;
/// Neighbouring facets of what is meant as smooth turn by up to 11° (tangent 0.2) against each other, which
/// the plane of the receiver does not know. Less brings dark facets back on spheres of 32 segments, more lets
/// light under thin things.
pub const FACET_SLOPE: f32 = 0.2;
/// The plane of the receiver is followed up to this slope against the light (87°): beyond, where light but
/// grazes it, the plane says nothing about a neighbouring texel.
pub const STEEPEST: f32 = 20.0;
/// Share of a depth by which the two ways to it, from the camera and from the light, differ at most by
/// rounding.
pub const DEPTH_ROUNDING: f32 = 4e-6;
/// Step from one random tap to the next: inverse of the plastic number and its square (Roberts 2018).
pub const TAP_STEP: Vec2 = Vec2::new(0.754_877_7, 0.569_840_3);

/// How many texels the map of a light has, `side` a side; a side of the six squares is half as long, which
/// leaves them one and a half times the texels of the others.
pub(super) fn texel_count(light: &FrameLight, side: u32) -> usize {
    let (faces, side) = shape(light, side);
    faces * side as usize * side as usize
}

fn shape(light: &FrameLight, side: u32) -> (usize, u32) {
    match light.kind {
        LightKind::Directional => (1, side),
        LightKind::Spot { outer_cone_rad, .. } if outer_cone_rad <= WIDEST_SPOT_RAD => (1, side),
        LightKind::Spot { .. } | LightKind::Point { .. } => (6, side.div_ceil(2)),
    }
}

/// A light's map: one square of texels, or six.
#[derive(Debug)]
pub struct Projection {
    faces: Vec<Face>,
    side: u32,
}

/// One square of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Right, up, forward: `world_from_face`.
    pub axes: Mat3,
    /// How it looks along them.
    pub lens: FaceLens,
}

/// How a square of a map sees the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaceLens {
    /// From the plane at `low`, a corner of the map in the space of the face. The low sun sees a town as a
    /// strip: its texels need not be square.
    Parallel {
        /// Corner of the map, in the space of the face.
        low: Vec3,
        /// Sides of a texel, world units.
        texel: Vec2,
    },
    /// From `eye`; half as wide as `half_width` at distance 1.
    Central {
        /// Position of the light in world space.
        eye: Vec3,
        /// Half the width of the map at distance 1 from the light.
        half_width: f32,
    },
}

/// A point projected into a map.
#[derive(Clone, Copy, Debug)]
struct Projected {
    face: usize,
    /// Position in texels from the corner of the face.
    at: Vec2,
    /// World units along the ray from the light.
    depth: f32,
    /// Sides of a texel there, world units.
    texel: Vec2,
}

impl Projection {
    /// The map of a light of a frame, `side` texels a side; half as many for each of six squares.
    #[must_use]
    pub fn new(frame: &Frame, light: &FrameLight, side: u32) -> Self {
        let (face_count, side) = shape(light, side);
        let looking = |forward: Vec3| {
            // Level with the ground, which most scenes are wider along than high.
            let right = forward.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X);
            Mat3::from_cols(right, right.cross(forward), forward)
        };
        let faces = match light.kind {
            LightKind::Directional => {
                vec![Face::parallel(frame, looking(light.direction), side)]
            }
            LightKind::Spot { outer_cone_rad, .. } if face_count == 1 => {
                let lens = FaceLens::Central { eye: light.position, half_width: outer_cone_rad.tan() };
                vec![Face { axes: looking(light.direction), lens }]
            }
            LightKind::Spot { .. } | LightKind::Point { .. } => {
                let forwards = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
                let lens = || FaceLens::Central { eye: light.position, half_width: 1.0 };
                forwards.map(|forward| Face { axes: looking(forward), lens: lens() }).into()
            }
        };
        Self { faces, side }
    }

    /// How many texels all faces have.
    pub(super) fn texels(&self) -> usize {
        self.faces.len() * self.side as usize * self.side as usize
    }

    /// Texels in a row, and rows, of a face.
    #[must_use]
    pub fn side(&self) -> usize {
        self.side as usize
    }

    /// Its squares, whose texels follow one another row by row.
    #[must_use]
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The ray from the light through the middle of a texel. Its direction has unit length.
    pub(super) fn ray(&self, texel: usize) -> Ray {
        let side = self.side();
        let (x, y) = (texel % side, texel / side % side);
        self.ray_through(texel / (side * side), Vec2::new(x as f32 + 0.5, y as f32 + 0.5))
    }

    fn ray_through(&self, face: usize, at: Vec2) -> Ray {
        let Face { axes, lens } = &self.faces[face];
        let (origin, direction) = match *lens {
            FaceLens::Parallel { low, texel } => (*axes * (low + (at * texel).extend(0.0)), axes.z_axis),
            FaceLens::Central { eye, half_width } => {
                let beside = (at * (2.0 / self.side as f32) - 1.0) * half_width;
                (eye, (*axes * beside.extend(1.0)).normalize())
            }
        };
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The longer side of a texel at a depth, world units.
    pub(super) fn texel_side(&self, texel: usize, depth: f32) -> f32 {
        match self.faces[texel / (self.side() * self.side())].lens {
            FaceLens::Parallel { texel, .. } => texel.max_element(),
            FaceLens::Central { half_width, .. } => 2.0 / self.side as f32 * half_width * depth,
        }
    }

    /// A point of the world in the map; none outside, where nothing is lit or nothing is.
    fn project(&self, point: Vec3) -> Option<Projected> {
        let ahead = |face: &Face| match face.lens {
            FaceLens::Parallel { .. } => 0.0,
            FaceLens::Central { eye, .. } => face.axes.z_axis.dot(point - eye),
        };
        let faces = self.faces.iter().enumerate();
        let (face, Face { axes, lens }) = faces.max_by(|(_, a), (_, b)| ahead(a).total_cmp(&ahead(b)))?;
        let side = self.side as f32;
        let (at, depth, texel) = match *lens {
            FaceLens::Parallel { low, texel } => {
                let local = axes.transpose() * point - low;
                (local.truncate() / texel, local.z, texel)
            }
            FaceLens::Central { eye, half_width } => {
                let local = axes.transpose() * (point - eye);
                let at = 0.5 * side * (local.truncate() / (local.z * half_width) + 1.0);
                (at, local.length(), Vec2::splat(2.0 * half_width * local.z / side))
            }
        };
        let inside = at.min_element() >= 0.0 && at.max_element() <= side && depth >= 0.0;
        inside.then_some(Projected { face, at, depth, texel })
    }

    /// Mean of what `visibility` says of the texels around a receiver, each with the depth that it has there:
    /// percentage closer filtering. `width`: of the box in texels, which weighs texels by how much of them it
    /// covers; 0 for the texel that the receiver is in.
    pub(super) fn filter(
        &self,
        stage: &Stage,
        receiver: &Receiver,
        width: u32,
        visibility: impl Fn(usize, f32) -> Vec3,
    ) -> Vec3 {
        let Some(projected) = self.project(receiver.position) else { return Vec3::ONE };
        if width == 0 {
            let (texel, depth) = self.tap(stage, receiver, &projected, projected.at);
            return visibility(texel, depth);
        }
        let half = 0.5 * width as f32;
        let (low, high) = (projected.at - half, projected.at + half);
        let covered = |texel: f32, low: f32, high: f32| (texel + 1.0).min(high) - texel.max(low);
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        let first = low.floor();
        for row in 0..=width {
            for column in 0..=width {
                let corner = first + Vec2::new(column as f32, row as f32);
                let weight = covered(corner.x, low.x, high.x) * covered(corner.y, low.y, high.y);
                if weight > 0.0 {
                    let (texel, depth) = self.tap(stage, receiver, &projected, corner + 0.5);
                    sum += weight * visibility(texel, depth);
                    weights += weight;
                }
            }
        }
        sum / weights
    }

    /// Mean of what `visibility` says at `taps` random points in the box, evenly spread: the sequence R2
    /// (Roberts 2018) from a random start. The number of the tap is its first argument.
    pub(super) fn random_taps(
        &self,
        stage: &Stage,
        receiver: &Receiver,
        width: u32,
        taps: u32,
        start: Vec2,
        visibility: impl Fn(u32, usize, f32) -> Vec3,
    ) -> Vec3 {
        let Some(projected) = self.project(receiver.position) else { return Vec3::ONE };
        let sum = (0..taps).map(|tap| {
            let unit = (start + TAP_STEP * tap as f32).fract();
            let at = projected.at + (unit - 0.5) * width.max(1) as f32;
            let (texel, depth) = self.tap(stage, receiver, &projected, at);
            visibility(tap, texel, depth)
        });
        sum.sum::<Vec3>() / taps as f32
    }

    /// The texel at a point, the nearest one of the face, and the depth that counts as the receiver's there:
    /// where its plane meets the texel's ray, less a bias. So a plane does not shadow itself, however large a
    /// texel is and however steep the plane.
    fn tap(&self, stage: &Stage, receiver: &Receiver, projected: &Projected, at: Vec2) -> (usize, f32) {
        let at = at.floor().clamp(Vec2::ZERO, Vec2::splat(self.side as f32 - 1.0));
        let middle = at + 0.5;
        let side = self.side();
        let texel = (projected.face * side + at.y as usize) * side + at.x as usize;
        let ray = self.ray_through(projected.face, middle);
        let offset = ((middle - projected.at) * projected.texel).length();
        let cosine = receiver.normal.dot(ray.direction);
        let on_plane = (receiver.position - ray.origin).dot(receiver.normal) / cosine;
        let limit = STEEPEST * offset;
        let depth = if on_plane.is_finite() {
            on_plane.clamp(projected.depth - limit, projected.depth + limit)
        } else {
            projected.depth
        };
        // A turn of the plane by a small angle moves its depth by 1 / cosine² as much, here as far as the
        // steepest plane.
        let facet = FACET_SLOPE * offset / (cosine * cosine).max(1.0 / STEEPEST);
        (texel, depth - facet - receiver.lift(stage) - DEPTH_ROUNDING * projected.depth)
    }
}

impl Face {
    /// Looks along `axes` at everything the frame holds.
    fn parallel(frame: &Frame, axes: Mat3, side: u32) -> Self {
        let face_from_world = axes.transpose();
        let [low, high] = frame.bounds_in(face_from_world);
        let (low, high) = if low.x <= high.x { (low, high) } else { (Vec3::ZERO, Vec3::ONE) };
        // A map of nothing has texels, too. Two texels more than needed, for the map is moved onto the grid
        // of its texels and its border shall be empty.
        let extent = (high - low).truncate().max(Vec2::splat(1e-4 * (high - low).max_element().max(1e-20)));
        let needed = extent / (side.max(3) - 2) as f32;
        let texel = needed.map(|needed| TEXEL_STEP.powf(needed.log(TEXEL_STEP).ceil()));
        let corner = ((low.truncate() / texel).floor() - 0.5) * texel;
        let near = low.z - 0.01 * extent.max_element();
        Self { axes, lens: FaceLens::Parallel { low: corner.extend(near), texel } }
    }
}
