//! How compositing methods get their fragments in the order in which the scene is drawn.

use std::time::Instant;

use glam::Vec3;
use sheer_accel::Hit;
use sheer_core::colour::{Premul, mean_channel};
use sheer_image::Pixel;

use super::{
    samples::SampleOffsets,
    tracer::{Tracer, is_behind},
    workspace::{Gathered, SampleHit, Workspace},
};
use crate::{
    contract::{MIN_VISIBILITY, Retrace, UnorderedCompositing},
    cost::Counters,
};

/// The light of all fragments with their total alpha: the transparent layer that a filter works on.
fn layer<M: UnorderedCompositing>(method: &M, pixel: &M::Pixel) -> Premul {
    let samples = method.samples().count;
    let transmittance: f32 = (0..samples as usize).map(|sample| method.transmittance(pixel, sample)).sum();
    Premul { rgb: method.resolve(pixel), alpha: 1.0 - transmittance / samples as f32 }
}

fn since(start: Instant) -> u64 {
    start.elapsed().as_nanos() as u64
}

impl Tracer<'_> {
    /// Fragments in the order of the scene's triangles, pass after pass, over an opaque background of its own
    /// for each sample. `keeps_layer`: their light is wanted by itself, too.
    pub(super) fn composite_unordered<M: UnorderedCompositing>(
        &mut self,
        method: &M,
        offsets: &SampleOffsets,
        keeps_layer: bool,
        at: [u32; 2],
        counters: &mut Counters,
    ) -> Pixel {
        let mut work = std::mem::take(&mut self.workspace);
        let start = Instant::now();
        work.rays.clear();
        work.rays.extend(offsets.iter().map(|&offset| self.camera_ray(self.centre(at) + offset)));
        self.gather_fragments(&mut work, method.samples().all(), counters);
        self.byproducts.nanoseconds.gather += since(start);

        let mut pixel = method.begin(&self.pixel_site(at));
        self.byproducts.nanoseconds.passes.resize(method.pass_count(), 0);
        for pass in 0..method.pass_count() {
            let start = Instant::now();
            if method.begin_pass(&mut pixel, pass).is_break() {
                break;
            }
            if pass > 0 && method.retrace() == Retrace::On {
                self.gather_fragments(&mut work, method.samples().all(), counters);
            }
            let ray_count = work.rays.len();
            let _ = work.fragments.iter().try_for_each(|gathered| {
                let depths = &work.depths[gathered.first_depth as usize..][..ray_count];
                let fragment = self.fragment(&gathered.hit, gathered.alpha, gathered.coverage, depths);
                let ray = &work.rays[gathered.ray as usize];
                method.add(&mut pixel, pass, &fragment, || {
                    self.shade_through_glass(ray, &gathered.hit, counters)
                })
            });
            self.byproducts.nanoseconds.passes[pass] += since(start);
        }

        let start = Instant::now();
        counters.merged += u64::from(method.merged_count(&pixel));
        let (colour, shows_background) = self.over_background(method, &pixel, &work, counters);
        let transparent = !work.fragments.is_empty();
        if keeps_layer && transparent {
            self.byproducts.layer.push((at, layer(method, &pixel)));
        }
        let furthest = work
            .fragments
            .iter()
            .map(|gathered| gathered.hit)
            .reduce(|far, hit| if is_behind(&hit, &far) { hit } else { far });
        let last = if shows_background { work.opaque[0] } else { furthest };
        let sample = self.centre(at) + offsets[0];
        let result = self.pixel(colour, sample, &work.rays[0], last.as_ref(), transparent);
        self.byproducts.nanoseconds.composite += since(start);
        self.workspace = work;
        result
    }

    /// Fills `fragments`, `depths` and `opaque` from `rays`. `all` is the mask of all samples, which one ray
    /// may have in common.
    fn gather_fragments(&self, work: &mut Workspace, all: u64, counters: &mut Counters) {
        let Workspace { rays, hits, opaque, fragments, depths, .. } = work;
        hits.clear();
        opaque.clear();
        for (index, ray) in (0..).zip(&*rays) {
            let first = hits.len();
            let mut nearest: Option<Hit> = None;
            self.stage.bvh().traverse(&self.ray(ray), |hit| {
                let alpha = self.alpha(&hit);
                if alpha >= 1.0 {
                    nearest = nearest.filter(|nearest| is_behind(&hit, nearest)).or(Some(hit));
                } else if alpha > 0.0 {
                    hits.push(SampleHit { hit, alpha, ray: index });
                }
                nearest.map_or(f32::INFINITY, |hit| hit.t)
            });
            if let Some(nearest) = nearest {
                let mut kept = first;
                for at in first..hits.len() {
                    if is_behind(&nearest, &hits[at].hit) {
                        hits[kept] = hits[at];
                        kept += 1;
                    }
                }
                hits.truncate(kept);
            }
            opaque.push(nearest);
        }
        counters.camera_rays += rays.len() as u64;
        counters.hits += hits.len() as u64;

        hits.sort_unstable_by_key(|found| (found.hit.triangle, found.ray));
        fragments.clear();
        depths.clear();
        for of_triangle in hits.chunk_by(|a, b| a.hit.triangle == b.hit.triangle) {
            let SampleHit { hit, alpha, ray } = of_triangle[0];
            let first_depth = depths.len();
            depths.resize(first_depth + rays.len(), f32::INFINITY);
            let mut coverage = if rays.len() == 1 { all } else { 0 };
            for found in of_triangle {
                coverage |= 1 << found.ray;
                depths[first_depth + found.ray as usize] = self.depth(&rays[found.ray as usize], &found.hit);
            }
            fragments.push(Gathered { hit, alpha, ray, coverage, first_depth: first_depth as u32 });
        }
    }

    /// The method's light over the background of each sample, and whether any of that is seen. A surface is
    /// shaded once a pixel, at the sample nearest to the centre.
    fn over_background<M: UnorderedCompositing>(
        &self,
        method: &M,
        pixel: &M::Pixel,
        work: &Workspace,
        counters: &mut Counters,
    ) -> (Premul, bool) {
        let sample_count = method.samples().count as usize;
        let share = 1.0 / sample_count as f32;
        let mut colour = Premul { rgb: method.resolve(pixel), alpha: 1.0 };
        let mut shows_background = false;
        for (index, (hit, ray)) in work.opaque.iter().zip(&work.rays).enumerate() {
            let triangle = hit.map(|hit| hit.triangle);
            let shares_triangle = |other: &Option<Hit>| other.map(|hit| hit.triangle) == triangle;
            if work.opaque[..index].iter().any(shares_triangle) {
                continue;
            }
            // Samples of one ray have their background in common, samples of one surface its shading. What
            // glass leaves of it differs from ray to ray.
            let is_one_ray = work.rays.len() == 1;
            let mut transmittance = Vec3::ZERO;
            for (at, (other, ray)) in work.opaque.iter().zip(&work.rays).enumerate() {
                if !shares_triangle(other) {
                    continue;
                }
                let samples = if is_one_ray { 0..sample_count } else { at..at + 1 };
                let grey = samples.map(|sample| method.transmittance(pixel, sample)).sum::<f32>();
                transmittance += grey * self.tint_before(ray, other.as_ref(), counters);
            }
            transmittance *= share;
            let mut background = Premul::CLEAR;
            if transmittance.max_element() > MIN_VISIBILITY * share {
                shows_background = true;
                background = self.unfiltered(ray, hit.as_ref(), counters);
            }
            colour.rgb += transmittance * background.rgb;
            colour.alpha -= mean_channel(transmittance) * (1.0 - background.alpha);
        }
        (colour, shows_background)
    }
}
