//! Our own tracer.

use std::array;

use sheer_accel::{Bvh, Hit};

use crate::rays::{Answer, LEAST_TRANSMITTANCE, Layer, Question, Scene, Workload, composite};

/// Rays that are traced together.
const TILE: usize = 64;

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

    /// Answers a question for each ray, those of a tile of 8 x 8 pixels, or the samples of four pixels,
    /// together.
    pub(crate) fn answer_tiles(&self, question: Question, workload: &Workload, answers: &mut [Answer]) {
        let (tree, scene) = (&self.tree, self.scene);
        let mut closest = Vec::new();
        let mut layers: [Vec<Layer>; TILE] = array::from_fn(|_| Vec::new());
        let tiles = workload.rays.chunks(TILE).zip(workload.seeds.chunks(TILE)).zip(answers.chunks_mut(TILE));
        for ((rays, seeds), answers) in tiles {
            match question {
                Question::Closest => {
                    tree.closest_of_packet(rays, |_, _| true, &mut closest);
                    answers.iter_mut().zip(&closest).for_each(|(answer, hit)| *answer = Answer::hit(*hit));
                }
                Question::Stochastic | Question::Samples => {
                    let accept =
                        |ray: usize, hit: &Hit| scene.accepts(seeds[ray], hit.triangle, hit.u, hit.v);
                    tree.closest_of_packet(rays, accept, &mut closest);
                    answers.iter_mut().zip(&closest).for_each(|(answer, hit)| *answer = Answer::hit(*hit));
                }
                Question::Layers => {
                    layers.iter_mut().for_each(Vec::clear);
                    tree.traverse_packet(rays, |ray, hit| {
                        let alpha = scene.alpha(hit.triangle, hit.u, hit.v);
                        layers[ray].push(Layer { t: hit.t, triangle: hit.triangle, alpha });
                        if alpha >= 1.0 { hit.t } else { f32::INFINITY }
                    });
                    answers
                        .iter_mut()
                        .zip(&mut layers)
                        .for_each(|(answer, layers)| *answer = composite(layers));
                }
                Question::Shadow => {
                    let mut transmittances = [1.0; TILE];
                    tree.traverse_packet(rays, |ray, hit| {
                        let transmittance = &mut transmittances[ray];
                        *transmittance *= 1.0 - scene.alpha(hit.triangle, hit.u, hit.v);
                        if *transmittance < LEAST_TRANSMITTANCE { f32::NEG_INFINITY } else { f32::INFINITY }
                    });
                    for (answer, &value) in answers.iter_mut().zip(&transmittances) {
                        *answer = Answer { value, index: 0 };
                    }
                }
            }
        }
    }
}
