//! CPU bounding volume hierarchy over triangles: closest, any and all hits of a ray.
//!
//! The tree has eight children a node and one block of up to eight triangles a leaf, both stored as
//! structures of arrays, so that one node or one leaf is one pass of eight SIMD lanes. It knows triangles
//! and a closure that takes or refuses a hit; what the hit means (opacity, threshold, layer) is the
//! caller's, and the closure is inlined into the traversal.
//!
//! * Build: top-down binned surface area heuristic (Wald, *On fast Construction of SAH-based Bounding
//!   Volume Hierarchies*, 2007), parallel at every level, the same tree for any number of threads.
//! * Motion: what never moves is built once; the tree over what does is refitted ([`Bvh::refit_after`]) until
//!   its quality, which is watched, has suffered.
//! * Triangles: the watertight test of Woop, Benthin and Wald (*Watertight Ray/Triangle Intersection*,
//!   JCGT 2013) with a fill rule, so that a ray through a shared edge or vertex hits exactly one of the
//!   triangles around it: no hole, and no layer counted twice.
//! * Boxes: conservative after Ize (*Robust BVH Ray Traversal*, JCGT 2013) and Woop et al.
//! * Packets: coherent rays, such as those of a tile of pixels, descend the tree together
//!   ([`Bvh::traverse_packet`]), with the hits of single rays, to the bit.
//! * Instances: what is drawn many times can be stored once ([`Bvh::build_with_meshes`]): a tree a mesh and
//!   one over all instances, with the hits of a tree over all of their triangles, to the bit.
//! * Parallel rays: [`LightBuffer`] has lists of triangles for rays of one direction, which need no tree.
//! * Paths: AVX-512, AVX2 and portable code, chosen at run time ([`SimdPath`]); hits are the same bits on
//!   all.
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
mod column;
mod error;
mod instance;
mod light_buffer;
mod limits;
mod node;
mod packed;
mod packet;
mod placement;
mod ray;
mod refit;
mod simd;
#[cfg(test)]
mod tests;
mod traverse;
mod tree;
mod validate;

pub use build::is_kept;
pub use bvh::Bvh;
pub use error::AccelError;
pub use instance::{Instance, MeshTree};
pub use light_buffer::LightBuffer;
pub use packed::PackedTree;
pub use ray::{Hit, Ray};
pub use simd::SimdPath;
pub use validate::Stats;
