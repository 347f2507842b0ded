//! obvhs, pure Rust: its compressed tree of eight children, the faster of its two. Triangles are tested by
//! the method of Möller and Trumbore (*Fast, Minimum Storage Ray/Triangle Intersection*, 1997), since obvhs
//! leaves the test to its users and its own gives no weights.

use std::time::Duration;

use glam::Vec3A;
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    ray::{Ray, RayHit},
    triangle::Triangle,
};

use crate::rays::{Answer, LEAST_TRANSMITTANCE, Layer, Question, Scene, Workload, composite};

/// A tree over the triangles of a scene.
pub(crate) struct Obvhs<'a> {
    tree: CwBvh,
    /// In the order of the tree.
    triangles: Vec<Corner>,
    scene: &'a Scene,
}

/// A triangle as its test wants it.
struct Corner {
    origin: Vec3A,
    edges: [Vec3A; 2],
    triangle: u32,
}

struct Found {
    t: f32,
    u: f32,
    v: f32,
}

impl Corner {
    #[inline(always)]
    fn hit(&self, ray: &Ray) -> Option<Found> {
        let [second, third] = self.edges;
        let p = ray.direction.cross(third);
        let inverse = 1.0 / second.dot(p);
        let from_corner = ray.origin - self.origin;
        let u = from_corner.dot(p) * inverse;
        let q = from_corner.cross(second);
        let v = ray.direction.dot(q) * inverse;
        // A ray in the plane makes NaN, which no comparison holds for.
        if !(u >= 0.0 && v >= 0.0 && u + v <= 1.0) {
            return None;
        }
        let t = third.dot(q) * inverse;
        (ray.tmin <= t && t <= ray.tmax).then_some(Found { t, u, v })
    }
}

impl<'a> Obvhs<'a> {
    /// Builds the tree with the preset `medium_build`: the slower ones split triangles, and one hit would be
    /// seen twice.
    pub(crate) fn build(scene: &'a Scene) -> Self {
        let triangles: Vec<Triangle> = scene
            .geometry
            .triangles
            .iter()
            .map(|&[a, b, c]| Triangle { v0: a.into(), v1: b.into(), v2: c.into() })
            .collect();
        let tree =
            build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        let corner = |&triangle: &u32| {
            let Triangle { v0, v1, v2 } = triangles[triangle as usize];
            Corner { origin: v0, edges: [v1 - v0, v2 - v0], triangle }
        };
        let triangles = tree.primitive_indices.iter().map(corner).collect();
        Self { tree, triangles, scene }
    }

    /// Answers a question for each ray.
    pub(crate) fn answer(&self, question: Question, workload: &Workload, answers: &mut [Answer]) {
        let mut layers = Vec::new();
        for ((ray, &seed), answer) in workload.rays.iter().zip(&workload.seeds).zip(answers) {
            let ray = Ray::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max);
            *answer = match question {
                Question::Closest => self.closest(ray, |_, _| true),
                Question::Stochastic | Question::Samples => {
                    self.closest(ray, |triangle, hit| self.scene.accepts(seed, triangle, hit.u, hit.v))
                }
                Question::Layers => self.layers(ray, &mut layers),
                Question::Shadow => self.shadow(ray),
            };
        }
    }

    #[inline(always)]
    fn closest(&self, ray: Ray, mut accept: impl FnMut(u32, &Found) -> bool) -> Answer {
        let mut closest = RayHit::none();
        let is_hit = self.tree.ray_traverse(ray, &mut closest, |ray, index| {
            let corner = &self.triangles[index];
            match corner.hit(ray) {
                Some(hit) if accept(corner.triangle, &hit) => hit.t,
                _ => f32::INFINITY,
            }
        });
        if !is_hit {
            return Answer::NONE;
        }
        Answer { value: closest.t, index: self.triangles[closest.primitive_id as usize].triangle }
    }

    #[inline(always)]
    fn layers(&self, ray: Ray, layers: &mut Vec<Layer>) -> Answer {
        layers.clear();
        let mut opaque = RayHit::none();
        self.tree.ray_traverse(ray, &mut opaque, |ray, index| {
            let corner = &self.triangles[index];
            let Some(hit) = corner.hit(ray) else { return f32::INFINITY };
            let alpha = self.scene.alpha(corner.triangle, hit.u, hit.v);
            layers.push(Layer { t: hit.t, triangle: corner.triangle, alpha });
            if alpha >= 1.0 { hit.t } else { f32::INFINITY }
        });
        composite(layers)
    }

    #[inline(always)]
    fn shadow(&self, ray: Ray) -> Answer {
        let mut transmittance = 1.0;
        self.tree.ray_traverse_miss(ray, |ray, index| {
            let corner = &self.triangles[index];
            let Some(hit) = corner.hit(ray) else { return f32::INFINITY };
            transmittance *= 1.0 - self.scene.alpha(corner.triangle, hit.u, hit.v);
            // A distance within the ray ends the search.
            if transmittance < LEAST_TRANSMITTANCE { f32::NEG_INFINITY } else { f32::INFINITY }
        });
        Answer { value: transmittance, index: 0 }
    }
}
