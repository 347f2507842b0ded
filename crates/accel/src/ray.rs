//! A ray, and where it meets a triangle.

use glam::Vec3;

/// A half-line `origin + t * direction`, with `t_min <= t <= t_max` (both ends belong to the interval).
///
/// Components of `origin` may be up to 1e12 in magnitude and the largest component of `direction` from
/// 1e-18 to 1e18, any other ray hits nothing. A negative `t_min` counts as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is 0.
    pub origin: Vec3,
    /// Need not have unit length; `t` is measured in its lengths.
    pub direction: Vec3,
    /// Smallest `t` that counts.
    pub t_min: f32,
    /// Largest `t` that counts; may be infinite.
    pub t_max: f32,
}

/// A point where a ray meets a triangle `[v0, v1, v2]`: `(1 - u - v) * v0 + u * v1 + v * v2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Weight of the second vertex.
    pub u: f32,
    /// Weight of the third vertex.
    pub v: f32,
    /// Index of the triangle in the slice the tree was built from.
    pub triangle: u32,
    /// The vertices run counter-clockwise seen from the ray's origin.
    pub front: bool,
}
