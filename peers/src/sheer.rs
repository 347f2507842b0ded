//! Our own tracer.

use sheer_accel::Bvh;

use crate::rays::{Answer, LEAST_TRANSMITTANCE, Layer, Question, Scene, Workload, composite};

/// A tree over the triangles of a scene.
pub(crate) struct Sheer<'a> {
    tree: Bvh,
    scene: &'a Scene,
}

impl<'a> Sheer<'a> {
    /// Builds the tree on all threads.
    pub(crate) fn build(scene: &'a Scene) -> Self {
        Self { tree: Bvh::build(&scene.geometry.triangles), scene }
    }

    pub(crate) fn tree(&self) -> &Bvh {
        &self.tree
    }

    /// Answers a question for each ray, one by one.
    pub(crate) fn answer(&self, question: Question, workload: &Workload, answers: &mut [Answer]) {
        let (tree, scene) = (&self.tree, self.scene);
        let mut layers: Vec<Layer> = Vec::new();
        for ((ray, &seed), answer) in workload.rays.iter().zip(&workload.seeds).zip(answers) {
            *answer = match question {
                Question::Closest => Answer::hit(tree.closest(ray, |_| true)),
                Question::Stochastic | Question::Samples => {
                    Answer::hit(tree.closest(ray, |hit| scene.accepts(seed, hit.triangle, hit.u, hit.v)))
                }
                Question::Layers => {
                    layers.clear();
                    let mut t_max = ray.t_max;
                    tree.traverse(ray, |hit| {
                        let alpha = scene.alpha(hit.triangle, hit.u, hit.v);
                        layers.push(Layer { t: hit.t, triangle: hit.triangle, alpha });
                        if alpha >= 1.0 {
                            t_max = hit.t;
                        }
                        t_max
                    });
                    composite(&mut layers)
                }
                Question::Shadow => {
                    let mut transmittance = 1.0;
                    tree.any(ray, |hit| {
                        transmittance *= 1.0 - scene.alpha(hit.triangle, hit.u, hit.v);
                        transmittance < LEAST_TRANSMITTANCE
                    });
                    Answer { value: transmittance, index: 0 }
                }
            };
        }
    }
}
