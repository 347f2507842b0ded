//! How compositing methods get their fragments in the order in which the scene is drawn.

use std::time::Instant;

use glam::Vec3;
use sheer_accel::Hit;
use sheer_core::colour::{Premul, mean_channel};
use sheer_image::Pixel;

use super::{
    samples::SampleOffsets,
    tile::TILE_SIDE,
    tracer::Tracer,
    workspace::{Gathered, PixelFragments, SampleHit, Workspace, is_behind},
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
        tile: &[[u32; 2]],
        counters: &mut Counters,
        pixels: &mut Vec<Pixel>,
    ) {
        // As many pixels at a time as fill a tile with their rays.
        let pixel_count = ((TILE_SIDE * TILE_SIDE) as usize / offsets.len()).max(1);
        for places in tile.chunks(pixel_count) {
            self.composite_pixels(method, offsets, keeps_layer, places, counters, pixels);
        }
    }

    /// The same for pixels whose rays are traced together.
    fn composite_pixels<M: UnorderedCompositing>(
        &mut self,
        method: &M,
        offsets: &SampleOffsets,
        keeps_layer: bool,
        places: &[[u32; 2]],
        counters: &mut Counters,
        pixels: &mut Vec<Pixel>,
    ) {
        let mut work = std::mem::take(&mut self.workspace);
        let start = Instant::now();
        work.pixels.resize_with(work.pixels.len().max(places.len()), Default::default);
        for (seen, &at) in work.pixels.iter_mut().zip(places) {
            seen.rays.clear();
            seen.rays.extend(offsets.iter().map(|&offset| self.camera_ray(self.centre(at) + offset)));
        }
        let mut going_on: Vec<usize> = (0..places.len()).collect();
        self.gather_fragments(&mut work, &going_on, method.samples().all(), counters);
        self.byproducts.nanoseconds.gather += since(start);

        let mut states: Vec<M::Pixel> = places.iter().map(|&at| method.begin(&self.pixel_site(at))).collect();
        self.byproducts.nanoseconds.passes.resize(method.pass_count(), 0);
        for pass in 0..method.pass_count() {
            let start = Instant::now();
            going_on.retain(|&index| method.begin_pass(&mut states[index], pass).is_continue());
            if going_on.is_empty() {
                break;
            }
            if pass > 0 && method.retrace() == Retrace::On {
                self.gather_fragments(&mut work, &going_on, method.samples().all(), counters);
            }
            for &index in &going_on {
                self.pixel_at = places[index];
                let PixelFragments { rays, fragments, depths, .. } = &work.pixels[index];
                let _ = fragments.iter().try_for_each(|gathered| {
                    let depths = &depths[gathered.first_depth as usize..][..rays.len()];
                    let fragment = self.fragment(&gathered.hit, gathered.alpha, gathered.coverage, depths);
                    let ray = &rays[gathered.ray as usize];
                    method.add(&mut states[index], pass, &fragment, || {
                        self.shade_through_glass(ray, &gathered.hit, counters)
                    })
                });
            }
            self.byproducts.nanoseconds.passes[pass] += since(start);
        }

        let start = Instant::now();
        for ((&at, state), seen) in places.iter().zip(&states).zip(&work.pixels) {
            self.pixel_at = at;
            counters.merged += u64::from(method.merged_count(state));
            let (colour, shows_background) = self.over_background(method, state, seen, counters);
            let transparent = !seen.fragments.is_empty();
            if keeps_layer && transparent {
                self.byproducts.layer.push((at, layer(method, state)));
            }
            let furthest = seen
                .fragments
                .iter()
                .map(|gathered| gathered.hit)
                .reduce(|far, hit| if is_behind(&hit, &far) { hit } else { far });
            let last = if shows_background { seen.opaque[0] } else { furthest };
            let sample = self.centre(at) + offsets[0];
            pixels.push(self.pixel(colour, sample, &seen.rays[0], last.as_ref(), transparent));
        }
        self.byproducts.nanoseconds.composite += since(start);
        self.workspace = work;
    }

    /// Fills `fragments`, `depths` and `opaque` of some pixels from their `rays`. `all` is the mask of all
    /// samples, which one ray may have in common.
    fn gather_fragments(&self, work: &mut Workspace, pixels: &[usize], all: u64, counters: &mut Counters) {
        let Workspace { pixels: seen, hits, .. } = work;
        let mut rays = Vec::new();
        let mut owners = Vec::new();
        for &pixel in pixels {
            let PixelFragments { rays: own, opaque, fragments, depths } = &mut seen[pixel];
            opaque.clear();
            opaque.resize(own.len(), None);
            fragments.clear();
            depths.clear();
            rays.extend(own.iter().map(|ray| self.ray(ray)));
            owners.extend((0..own.len() as u32).map(|ray| (pixel as u32, ray)));
        }
        hits.clear();
        self.stage.bvh().traverse_packet(&rays, |index, hit| {
            let (pixel, ray) = owners[index];
            let nearest = &mut seen[pixel as usize].opaque[ray as usize];
            let alpha = self.alpha(&hit);
            if alpha >= 1.0 {
                *nearest = nearest.filter(|nearest| is_behind(&hit, nearest)).or(Some(hit));
            } else if alpha > 0.0 {
                hits.push(SampleHit { hit, alpha, pixel, ray });
            }
            nearest.map_or(f32::INFINITY, |hit| hit.t)
        });
        hits.retain(|found| {
            let nearest = seen[found.pixel as usize].opaque[found.ray as usize];
            nearest.is_none_or(|nearest| is_behind(&nearest, &found.hit))
        });
        counters.camera_rays += rays.len() as u64;
        counters.hits += hits.len() as u64;

        hits.sort_unstable_by_key(|found| (found.pixel, found.hit.triangle, found.ray));
        let is_one = |a: &SampleHit, b: &SampleHit| (a.pixel, a.hit.triangle) == (b.pixel, b.hit.triangle);
        for of_triangle in hits.chunk_by(is_one) {
            let SampleHit { hit, alpha, pixel, ray } = of_triangle[0];
            let PixelFragments { rays, fragments, depths, .. } = &mut seen[pixel as usize];
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
        PixelFragments { rays, opaque, .. }: &PixelFragments,
        counters: &mut Counters,
    ) -> (Premul, bool) {
        let sample_count = method.samples().count as usize;
        let share = 1.0 / sample_count as f32;
        let mut colour = Premul { rgb: method.resolve(pixel), alpha: 1.0 };
        let mut shows_background = false;
        for (index, (hit, ray)) in opaque.iter().zip(rays).enumerate() {
            let triangle = hit.map(|hit| hit.triangle);
            let shares_triangle = |other: &Option<Hit>| other.map(|hit| hit.triangle) == triangle;
            if opaque[..index].iter().any(shares_triangle) {
                continue;
            }
            // Samples of one ray have their background in common, samples of one surface its shading. What
            // glass leaves of it differs from ray to ray.
            let is_one_ray = rays.len() == 1;
            let mut transmittance = Vec3::ZERO;
            for (at, (other, ray)) in opaque.iter().zip(rays).enumerate() {
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
