//! CPU bounding volume hierarchy over triangles: closest, any and all hits of a ray.
//!
//! The tree has eight children a node and one block of up to eight triangles a leaf, both stored as
//! structures of arrays, so that one node or one leaf is one pass of eight SIMD lanes. It knows triangles
//! and a closure that takes or refuses a hit; what the hit means (opacity, threshold, layer) is the
//! caller's, and the closure is inlined into the traversal.
//!
//! * Build: top-down binned surface area heuristic (Wald, *On fast Construction of SAH-based Bounding
//!   Volume Hierarchies*, 2007), parallel at every level, the same tree for any number of threads.
//! * Triangles: the watertight test of Woop, Benthin and Wald (*Watertight Ray/Triangle Intersection*,
//!   JCGT 2013) with a fill rule, so that a ray through a shared edge or vertex hits exactly one of the
//!   triangles around it: no hole, and no layer counted twice.
//! * Boxes: conservative after Ize (*Robust BVH Ray Traversal*, JCGT 2013) and Woop et al.
//! * Paths: AVX-512, AVX2 and portable code, chosen at run time ([`SimdPath`]); hits are the same bits on all.
//!
//! ```
//! use glam::{Vec3, vec3};
//! use sheer_accel::{Bvh, Ray};
//!
//! let triangles = [[vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)]];
//! let bvh = Bvh::build(&triangles);
//! let ray = Ray { origin: vec3(0.0, 0.0, 2.0), direction: Vec3::NEG_Z, t_min: 0.0, t_max: f32::INFINITY };
//! let hit = bvh.closest(&ray, |_| true).expect("the ray points at the triangle");
//! assert_eq!((hit.t, hit.triangle, hit.front), (2.0, 0, true));
//! ```

mod build;
mod bvh;
mod node;
mod packed;
mod simd;
#[cfg(test)]
mod tests;
mod traverse;
mod validate;

use glam::Vec3;

pub use build::is_kept;
pub use bvh::Bvh;
pub use packed::PackedTree;
pub use simd::SimdPath;
pub use validate::Stats;

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

/// What can be wrong with a tree or with the path it shall run on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AccelError {
    /// The processor, or the architecture this was built for, lacks the path.
    #[error("this processor cannot run the {0} path; take `SimdPath::detect()` or `SimdPath::Portable`")]
    UnsupportedPath(SimdPath),
    /// A child points outside the arrays, or two parents share it.
    #[error(
        "node {node}, child {lane}: reference {child:#x} is out of range or shared; build the tree again"
    )]
    BrokenLink {
        /// The parent.
        node: u32,
        /// Which of its eight children.
        lane: usize,
        /// The reference as stored.
        child: u32,
    },
    /// A child's box is not a box (NaN, or its lower bound above its upper bound), or does not contain what lies below it.
    #[error("node {node}, child {lane}: its box does not contain what lies below it; build the tree again")]
    BrokenBox {
        /// The parent.
        node: u32,
        /// Which of its eight children.
        lane: usize,
    },
    /// A leaf holds other vertices than the triangle it names, or names none of them.
    #[error("leaf {leaf}: triangle {triangle} is not the one given; rebuild after triangles move")]
    StaleTriangle {
        /// The leaf block.
        leaf: u32,
        /// The triangle it names.
        triangle: u32,
    },
    /// A triangle is in no leaf or in more than one.
    #[error("triangle {triangle} is in {leaves} leaves instead of one; build the tree again")]
    LostTriangle {
        /// The triangle.
        triangle: u32,
        /// How many leaves hold it.
        leaves: u32,
    },
    /// The tree is deeper than the traversal stack allows.
    #[error("the tree is {depth} levels deep, the traversal stack allows {limit}; build the tree again")]
    TooDeep {
        /// Levels found.
        depth: u32,
        /// Levels allowed.
        limit: u32,
    },
}
