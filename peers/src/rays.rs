//! What is asked of rays, and the measurement: each engine answers the same questions for the same rays, in
//! turns, on one thread; then the answers are compared.

use std::time::Instant;

use anyhow::ensure;
use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};
use sheer_accel::{Bvh, Hit, Ray};

use crate::{
    embree::{Embree, Mode, Prepared},
    obvhs::Obvhs,
    scenes::{Geometry, camera_ray, pcg, shadow_ray, texture, unit},
    sheer::Sheer,
};

/// Whole tiles of 8 x 8 pixels, about the size at which whole frames are measured.
const SIZE: [u32; 2] = [960, 544];
/// With 16 rays a pixel that makes four times the rays of the other questions, not 16.
const SAMPLES_SIZE: [u32; 2] = [480, 272];
/// Through a shadow ray less passes than a display of 8 bits shows.
pub(crate) const LEAST_TRANSMITTANCE: f32 = 0.001;

/// A scene with what its hits mean.
pub(crate) struct Scene {
    pub(crate) geometry: Geometry,
    texture: Vec<f32>,
}

impl Scene {
    #[inline(always)]
    pub(crate) fn alpha(&self, triangle: u32, u: f32, v: f32) -> f32 {
        self.geometry.alpha(&self.texture, triangle, u, v)
    }

    /// Whether a hit is kept with the probability of its opacity; `seed` is that of the ray.
    #[inline(always)]
    pub(crate) fn accepts(&self, seed: u32, triangle: u32, u: f32, v: f32) -> bool {
        self.alpha(triangle, u, v) > unit(pcg(seed ^ triangle))
    }
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Question {
    /// The first hit.
    Closest,
    /// The first of the hits that are kept at random, one ray a pixel.
    Stochastic,
    /// The same for 16 rays of a pixel.
    Samples,
    /// All hits to the first opaque one, composited front to back.
    Layers,
    /// What light passes from the first hit to a light.
    Shadow,
}

impl Question {
    pub(crate) const ALL: [Self; 5] =
        [Self::Closest, Self::Stochastic, Self::Samples, Self::Layers, Self::Shadow];

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Closest => "Closest hit",
            Self::Stochastic => "Stochastic any-hit, one ray a pixel",
            Self::Samples => "Stochastic any-hit, 16 samples a pixel",
            Self::Layers => "All layers, composited front to back",
            Self::Shadow => "Transmittance of a shadow ray",
        }
    }
}

/// An answer for a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Answer {
    /// Distance of the hit, composited grey, or transmittance.
    pub(crate) value: f32,
    /// Triangle, `u32::MAX` without a hit; number of layers; 0 for a transmittance.
    pub(crate) index: u32,
}

impl Answer {
    pub(crate) const NONE: Self = Self { value: f32::INFINITY, index: u32::MAX };

    pub(crate) fn hit(hit: Option<Hit>) -> Self {
        hit.map_or(Self::NONE, |hit| Self { value: hit.t, index: hit.triangle })
    }

    /// Whether two engines saw the same. Two triangles at one distance share an edge, or lie in one plane.
    fn agrees(self, other: Self, question: Question) -> bool {
        match question {
            Question::Closest | Question::Stochastic | Question::Samples => {
                self.index == other.index || (self.value - other.value).abs() <= 1e-5 * self.value
            }
            Question::Layers => self.index == other.index && (self.value - other.value).abs() <= 1e-3,
            // Below the least transmittance an engine stops wherever it is.
            Question::Shadow => (self.value - other.value).abs() <= LEAST_TRANSMITTANCE,
        }
    }
}

/// A hit that is a part of a pixel.
#[derive(Clone, Copy)]
pub(crate) struct Layer {
    pub(crate) t: f32,
    pub(crate) triangle: u32,
    pub(crate) alpha: f32,
}

/// Layers composited so far, front to back; each triangle has a grey of its own.
pub(crate) struct Composite {
    grey: f32,
    transmittance: f32,
    count: u32,
}

impl Composite {
    pub(crate) fn new() -> Self {
        Self { grey: 0.0, transmittance: 1.0, count: 0 }
    }

    /// Adds the next layer; false if nothing is seen behind it.
    #[inline(always)]
    pub(crate) fn add(&mut self, triangle: u32, alpha: f32) -> bool {
        self.grey += self.transmittance * alpha * unit(pcg(triangle));
        self.transmittance *= 1.0 - alpha;
        self.count += 1;
        alpha < 1.0
    }

    pub(crate) fn answer(&self) -> Answer {
        Answer { value: self.grey, index: self.count }
    }
}

/// Composites layers that were found in any order, of which those behind an opaque one do not count.
#[inline(always)]
pub(crate) fn composite(layers: &mut [Layer]) -> Answer {
    layers.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
    let mut composite = Composite::new();
    for layer in layers {
        if !composite.add(layer.triangle, layer.alpha) {
            break;
        }
    }
    composite.answer()
}

/// The rays of a question, 16 after the other being neighbours, 64 a tile of 8 x 8 pixels.
pub(crate) struct Workload {
    pub(crate) rays: Vec<Ray>,
    /// One a ray, for what is random.
    pub(crate) seeds: Vec<u32>,
}

impl Workload {
    fn new(question: Question, tree: &Bvh) -> Self {
        let rays: Vec<Ray> = match question {
            Question::Closest | Question::Stochastic | Question::Layers => {
                pixels(SIZE).map(|[x, y]| camera_ray([x as f32 + 0.5, y as f32 + 0.5], SIZE)).collect()
            }
            Question::Samples => pixels(SAMPLES_SIZE).flat_map(samples).collect(),
            Question::Shadow => pixels(SIZE)
                .filter_map(|[x, y]| {
                    let ray = camera_ray([x as f32 + 0.5, y as f32 + 0.5], SIZE);
                    Some(shadow_ray(&ray, tree.closest(&ray, |_| true)?.t))
                })
                .collect(),
        };
        let seeds = (0..rays.len() as u32).map(pcg).collect();
        Self { rays, seeds }
    }
}

/// The pixels of a picture: tile after tile of 8 x 8, in each the four blocks of 4 x 4 one after the other.
fn pixels([width, height]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    let tiles = (0..height / 8).flat_map(move |y| (0..width / 8).map(move |x| [8 * x, 8 * y]));
    tiles.flat_map(|[left, top]| {
        (0..64).map(move |index| {
            let (block, within) = (index / 16, index % 16);
            [left + 4 * (block % 2) + within % 4, top + 4 * (block / 2) + within / 4]
        })
    })
}

/// 16 rays through a pixel, one through the middle of each sixteenth.
fn samples([x, y]: [u32; 2]) -> impl Iterator<Item = Ray> {
    (0..16).map(move |sample| {
        let within = [sample % 4, sample / 4].map(|step| (step as f32 + 0.5) / 4.0);
        camera_ray([x as f32 + within[0], y as f32 + within[1]], SAMPLES_SIZE)
    })
}

/// What was measured.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct RayTimes {
    /// `4.4.0`, if Embree was there.
    pub(crate) embree: Option<String>,
    /// How many rays a packet of Embree's had.
    pub(crate) packet_width: usize,
    /// Instructions that our own tracer used.
    pub(crate) path: String,
    pub(crate) scenes: Vec<SceneCounts>,
    pub(crate) rows: Vec<RayRow>,
}

/// A scene, and how long trees over it took, on all threads.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SceneCounts {
    pub(crate) name: String,
    pub(crate) triangles: usize,
    /// Layers of a ray that meets any, mean.
    pub(crate) layers: f64,
    /// Engine and milliseconds.
    pub(crate) build_ms: Vec<(String, f64)>,
}

/// An engine's times for a question on a scene.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct RayRow {
    pub(crate) scene: String,
    pub(crate) question: Question,
    pub(crate) engine: String,
    pub(crate) mode: String,
    pub(crate) rays: usize,
    /// Rays with another answer than that of our single rays.
    pub(crate) differing: usize,
    /// Milliseconds of processor time of each round, in the order of the rounds: those of one round belong
    /// together.
    pub(crate) ms: Vec<f64>,
}

pub(crate) const SHEER: &str = "Sheer";
pub(crate) const EMBREE: &str = "Embree";
pub(crate) const OBVHS: &str = "obvhs";

/// What fills in the answer to each ray.
type Answering<'a> = dyn Fn(&mut [Answer]) + 'a;

/// A way to answer a question for all rays.
struct Contestant<'a> {
    engine: &'static str,
    mode: &'static str,
    answer: Box<Answering<'a>>,
}

/// Measures all engines that are there.
pub(crate) fn measure(embree: Option<&Embree>, rounds: usize) -> anyhow::Result<RayTimes> {
    let packet_width = embree.map_or(0, Embree::packet_width);
    let mut times = RayTimes { embree: embree.map(Embree::version), packet_width, ..RayTimes::default() };
    for geometry in Geometry::all() {
        let scene = Scene { geometry, texture: texture() };
        measure_scene(&scene, embree, rounds, &mut times)?;
    }
    Ok(times)
}

fn measure_scene(
    scene: &Scene,
    embree: Option<&Embree>,
    rounds: usize,
    times: &mut RayTimes,
) -> anyhow::Result<()> {
    let name = scene.geometry.name;
    eprintln!("{name}: building");
    let mut build_ms = Vec::new();
    let mut timed = |engine: &str, start: Instant| build_ms.push((engine.to_owned(), ms_since(start)));
    let start = Instant::now();
    let sheer = Sheer::build(scene);
    timed(SHEER, start);
    let start = Instant::now();
    let obvhs = Obvhs::build(scene);
    timed(OBVHS, start);
    let start = Instant::now();
    let embree = embree.map(|embree| embree.build(scene)).transpose()?;
    if embree.is_some() {
        timed(EMBREE, start);
    }
    times.path = sheer.tree().path().to_string();
    let mut layers = 0.0;

    for question in Question::ALL {
        eprintln!("{name}: {}", question.title());
        let workload = Workload::new(question, sheer.tree());
        let prepared = Prepared::new(&workload, times.packet_width);
        let mut contestants = vec![Contestant {
            engine: SHEER,
            mode: Mode::Single.name(),
            answer: Box::new(|answers| sheer.answer(question, &workload, answers)),
        }];
        contestants.push(Contestant {
            engine: SHEER,
            mode: "tiles",
            answer: Box::new(|answers| sheer.answer_tiles(question, &workload, answers)),
        });
        if let Some(embree) = &embree {
            let prepared = &prepared;
            contestants.extend(Mode::of(question).iter().map(|&mode| Contestant {
                engine: EMBREE,
                mode: mode.name(),
                answer: Box::new(move |answers| embree.answer(question, mode, prepared, answers)),
            }));
        }
        contestants.push(Contestant {
            engine: OBVHS,
            mode: Mode::Single.name(),
            answer: Box::new(|answers| obvhs.answer(question, &workload, answers)),
        });
        let rows = compete(name, question, workload.rays.len(), &contestants, rounds)?;
        if question == Question::Layers {
            let mut answers = vec![Answer::NONE; workload.rays.len()];
            (contestants[0].answer)(&mut answers);
            layers = mean_layers(&answers);
        }
        times.rows.extend(rows);
    }
    let triangles = scene.geometry.triangles.len();
    times.scenes.push(SceneCounts { name: name.to_owned(), triangles, layers, build_ms });
    Ok(())
}

/// Lets contestants answer in turns. The first turn warms up and its answers are compared with those of the
/// first contestant.
fn compete(
    scene: &str,
    question: Question,
    ray_count: usize,
    contestants: &[Contestant<'_>],
    rounds: usize,
) -> anyhow::Result<Vec<RayRow>> {
    let mut expected = vec![Answer::NONE; ray_count];
    let mut answers = vec![Answer::NONE; ray_count];
    let mut rows = Vec::new();
    for (index, contestant) in contestants.iter().enumerate() {
        let target = if index == 0 { &mut expected } else { &mut answers };
        (contestant.answer)(target);
        let differing = if index == 0 { 0 } else { differing(&expected, &answers, question) };
        let Contestant { engine, mode, .. } = contestant;
        let share = differing as f64 / ray_count as f64;
        ensure!(
            share <= EDGE_SHARE,
            "{scene}, {}: {engine} ({mode}) sees something else than our single rays in {:.2} % of {ray_count} \
             rays; edges explain {:.2} %",
            question.title(),
            100.0 * share,
            100.0 * EDGE_SHARE
        );
        rows.push(RayRow {
            scene: scene.to_owned(),
            question,
            engine: (*engine).to_owned(),
            mode: (*mode).to_owned(),
            rays: ray_count,
            differing,
            ms: Vec::with_capacity(rounds),
        });
    }
    for _ in 0..rounds {
        for (contestant, row) in contestants.iter().zip(&mut rows) {
            let start_ms = thread_ms();
            (contestant.answer)(&mut answers);
            row.ms.push(thread_ms() - start_ms);
        }
    }
    Ok(rows)
}

/// Largest share of rays that may differ. The engines round differently by some 1e-6 of the distance; of hair
/// whose width is 1e-4 of the distance that is a hundredth, at each of its edges, and of a textured quad a
/// thousandth of a texel, at each of its texels. More would be another scene, or other rays.
const EDGE_SHARE: f64 = 0.02;

/// In how many rays two engines disagree.
fn differing(expected: &[Answer], answers: &[Answer], question: Question) -> usize {
    expected.iter().zip(answers).filter(|(a, b)| !a.agrees(**b, question)).count()
}

/// Layers of the rays that have any.
fn mean_layers(answers: &[Answer]) -> f64 {
    let met = answers.iter().filter(|answer| answer.index > 0).count();
    answers.iter().map(|answer| f64::from(answer.index)).sum::<f64>() / met.max(1) as f64
}

/// Processor time of this thread: what else runs on the machine may take its turns, and is not counted.
fn thread_ms() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    1e3 * time.tv_sec as f64 + 1e-6 * time.tv_nsec as f64
}

fn ms_since(start: Instant) -> f64 {
    1e3 * start.elapsed().as_secs_f64()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    const HIT: Answer = Answer { value: 2.0, index: 7 };

    #[test]
    fn another_triangle_at_another_distance_is_another_hit() {
        let there = [HIT; 4];
        let other = Answer { value: 2.5, index: 8 };
        let touching = Answer { value: 2.000_001, index: 8 };
        let found = [HIT, touching, other, Answer::NONE];
        assert_eq!(differing(&there, &found, Question::Closest), 2);
        assert_eq!(differing(&[Answer::NONE], &[Answer::NONE], Question::Closest), 0);
    }

    #[test]
    fn a_lost_layer_is_found_even_where_it_is_not_seen() {
        let there = Answer { value: 0.5, index: 12 };
        let lost = Answer { value: 0.5, index: 11 };
        assert_eq!(differing(&[there], &[lost], Question::Layers), 1);
    }

    #[test]
    fn layers_behind_an_opaque_one_do_not_count() {
        let layer = |t, triangle, alpha| Layer { t, triangle, alpha };
        let mut layers = [layer(3.0, 2, 0.5), layer(2.0, 1, 1.0), layer(1.0, 0, 0.5)];
        let answer = composite(&mut layers);
        assert_eq!(answer.index, 2);
        assert_eq!(answer.value, 0.5 * unit(pcg(0)) + 0.5 * unit(pcg(1)));
    }

    #[test]
    fn sixteen_rays_after_the_other_are_a_block_and_all_pixels_are_there_once() {
        let pixels: Vec<_> = pixels([16, 8]).collect();
        assert!(pixels[16..32].iter().all(|&[x, y]| (4..8).contains(&x) && y < 4));
        let mut sorted = pixels.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), 128);
    }

    #[test]
    fn all_samples_of_a_pixel_lie_in_it() {
        let corners = [camera_ray([3.0, 5.0], SAMPLES_SIZE), camera_ray([4.0, 6.0], SAMPLES_SIZE)];
        let within = |ray: Ray| {
            let low = corners[0].direction.min(corners[1].direction);
            let high = corners[0].direction.max(corners[1].direction);
            ray.direction.cmpge(low).all() && ray.direction.cmple(high).all()
        };
        assert!(samples([3, 5]).all(within));
        assert!(!within(Ray { direction: Vec3::Z, ..corners[0] }));
    }
}
