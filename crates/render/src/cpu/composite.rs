//! How compositing methods get their fragments.

use std::{ops::ControlFlow, time::Instant};

use sheer_accel::{Hit, Ray};
use sheer_core::colour::Premul;
use sheer_image::Pixel;
use sheer_scene::CameraRay;

use super::{
    samples::SampleOffsets,
    tracer::{Tracer, is_behind},
    workspace::{Gathered, SampleHit, Workspace},
};
use crate::{
    contract::{Compositing, Fragment, Gathering, MIN_VISIBILITY, PixelSite},
    cost::Counters,
};

/// The light of all fragments with their total alpha.
fn layer<M: Compositing>(method: &M, pixel: &M::Pixel) -> Premul {
    let samples = method.samples().count;
    let transmittance: f32 = (0..samples as usize).map(|sample| method.transmittance(pixel, sample)).sum();
    Premul { rgb: method.resolve(pixel), alpha: 1.0 - transmittance / samples as f32 }
}

fn since(start: Instant) -> u64 {
    start.elapsed().as_nanos() as u64
}

impl Tracer<'_> {
    /// Hands the fragments of a pixel to the method and puts the background behind them. `keeps_layer`: their light is wanted by itself, too.
    pub(super) fn composite<M: Compositing>(
        &mut self,
        method: &M,
        offsets: &SampleOffsets,
        keeps_layer: bool,
        at: [u32; 2],
        counters: &mut Counters,
    ) -> Pixel {
        match method.gathering() {
            Gathering::Sorted | Gathering::Continuation => self.composite_in_order(method, at, counters),
            Gathering::Unordered { each_pass } => {
                self.composite_unordered(method, offsets, [each_pass, keeps_layer], at, counters)
            }
        }
    }

    fn pixel_site(&self, at: [u32; 2]) -> PixelSite {
        let (frame, seed) = (self.settings.frame, self.settings.run.seed);
        PixelSite { pixel: at, frame, seed, depth_range: self.depth_range }
    }

    /// Front to back, equal depths in the order of their triangles; what is opaque comes last, as a fragment.
    fn composite_in_order<M: Compositing>(
        &mut self,
        method: &M,
        at: [u32; 2],
        counters: &mut Counters,
    ) -> Pixel {
        let sample = self.sample(at);
        let camera_ray = self.camera_ray(sample);
        let mut pixel = method.begin(&self.pixel_site(at));
        let mut last = None;
        let mut transparent = false;
        let mut take = |hit: &Hit, alpha: f32, counters: &mut Counters| {
            last = Some(*hit);
            transparent |= alpha < 1.0;
            let depths = [self.depth(&camera_ray, hit)];
            let fragment = self.fragment(hit, alpha, 1, &depths);
            method.add(&mut pixel, 0, &fragment, || self.shade(&camera_ray, hit, counters))
        };
        let ray = self.ray(&camera_ray);
        if method.gathering() == Gathering::Continuation {
            self.continuation(&ray, counters, &mut take);
        } else {
            let mut hits = Vec::with_capacity(self.workspace.sorted.capacity());
            self.sorted_hits(&ray, &mut hits, counters);
            let _ = hits.iter().try_for_each(|(hit, alpha)| take(hit, *alpha, counters));
            hits.clear();
            self.workspace.sorted = hits;
        }
        counters.merged += u64::from(method.merged_count(&pixel));
        let transmittance = method.transmittance(&pixel, 0);
        let mut colour = Premul { rgb: method.resolve(&pixel), alpha: 1.0 - transmittance };
        if transmittance > MIN_VISIBILITY {
            // Everything was transparent: the background is the last fragment.
            colour = colour.over(self.background(&camera_ray));
            last = None;
        }
        self.pixel(colour, sample, &camera_ray, last.as_ref(), transparent)
    }

    /// All visible hits up to the first opaque one in one traversal, sorted by depth, then triangle.
    fn sorted_hits(&self, ray: &Ray, hits: &mut Vec<(Hit, f32)>, counters: &mut Counters) {
        let mut t_opaque = f32::INFINITY;
        self.stage.bvh().traverse(ray, |hit| {
            let alpha = self.alpha(&hit);
            if alpha > 0.0 {
                hits.push((hit, alpha));
            }
            if alpha >= 1.0 {
                t_opaque = t_opaque.min(hit.t);
            }
            t_opaque
        });
        counters.camera_rays += 1;
        counters.hits += hits.len() as u64;
        hits.retain(|(hit, _)| hit.t <= t_opaque);
        hits.sort_unstable_by(|(a, _), (b, _)| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
    }

    /// The paper's way (STD Listing 2): each ray starts at the last hit. It starts there inclusively and passes over what has been seen,
    /// so that a second surface at the same depth is not lost.
    fn continuation(
        &self,
        ray: &Ray,
        counters: &mut Counters,
        take: &mut impl FnMut(&Hit, f32, &mut Counters) -> ControlFlow<()>,
    ) {
        let mut after: Option<Hit> = None;
        loop {
            let from = after.map_or(ray.t_min, |hit| hit.t);
            let next = self.stage.bvh().closest(&Ray { t_min: from, ..*ray }, |hit| {
                after.is_none_or(|last| is_behind(hit, &last)) && self.alpha(hit) > 0.0
            });
            counters.camera_rays += 1;
            let Some(hit) = next else { return };
            counters.hits += 1;
            if take(&hit, self.alpha(&hit), counters).is_break() {
                return;
            }
            after = Some(hit);
        }
    }

    /// Fragments in the order of the scene's triangles, pass after pass, over an opaque background of its own for each sample.
    fn composite_unordered<M: Compositing>(
        &mut self,
        method: &M,
        offsets: &SampleOffsets,
        [each_pass, keeps_layer]: [bool; 2],
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
            if each_pass && pass > 0 {
                self.gather_fragments(&mut work, method.samples().all(), counters);
            }
            let ray_count = work.rays.len();
            let _ = work.fragments.iter().try_for_each(|gathered| {
                let depths = &work.depths[gathered.first_depth as usize..][..ray_count];
                let fragment = self.fragment(&gathered.hit, gathered.alpha, gathered.coverage, depths);
                let ray = &work.rays[gathered.ray as usize];
                method.add(&mut pixel, pass, &fragment, || self.shade(ray, &gathered.hit, counters))
            });
            self.byproducts.nanoseconds.passes[pass] += since(start);
        }

        let start = Instant::now();
        counters.merged += u64::from(method.merged_count(&pixel));
        let (colour, shows_background) = self.behind(method, &pixel, &work, counters);
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

    /// Fills `fragments`, `depths` and `opaque` from `rays`. `all` is the mask of all samples, which one ray may have in common.
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

    /// The method's light over the background of each sample, and whether any of that is seen. A surface is shaded once a pixel, at the
    /// sample nearest to the centre.
    fn behind<M: Compositing>(
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
            // Samples of one ray have their background in common, samples of one surface its shading.
            let samples = (0..sample_count).filter(|sample| {
                let ray = (*sample).min(work.rays.len() - 1);
                shares_triangle(&work.opaque[ray])
            });
            let transmittance =
                share * samples.map(|sample| method.transmittance(pixel, sample)).sum::<f32>();
            let mut background = Premul::CLEAR;
            if transmittance > MIN_VISIBILITY * share {
                shows_background = true;
                background = self.seen(ray, hit.as_ref(), counters);
            }
            colour.rgb += transmittance * background.rgb;
            colour.alpha -= transmittance * (1.0 - background.alpha);
        }
        (colour, shows_background)
    }

    fn fragment<'d>(&self, hit: &Hit, alpha: f32, coverage: u64, depths: &'d [f32]) -> Fragment<'d> {
        let object = self.stage.frame().object(hit.triangle);
        Fragment {
            alpha,
            coverage,
            depths,
            order: hit.triangle,
            instance: object.id,
            geometry: object.geometry,
            primitive: hit.triangle - object.first_triangle,
            is_back: self.is_back(hit),
        }
    }

    /// Distance along the view axis: never falls as `t` grows, rounding included.
    fn depth(&self, ray: &CameraRay, hit: &Hit) -> f32 {
        let camera = self.stage.frame().camera();
        let cosine = ray.direction.dot(camera.forward());
        camera.view_depth(ray.origin) + hit.t * cosine
    }
}
