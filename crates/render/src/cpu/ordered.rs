//! How compositing methods get their fragments front to back.

use std::ops::ControlFlow;

use sheer_accel::{Hit, Ray};
use sheer_core::colour::Premul;
use sheer_image::Pixel;

use super::{tile::PixelRay, tracer::Tracer, workspace::is_behind};
use crate::{
    contract::{MIN_VISIBILITY, OrderedCompositing, Traversal},
    cost::Counters,
};

impl Tracer<'_> {
    /// Front to back, equal depths in the order of their triangles; what is opaque comes last, as a fragment.
    pub(super) fn composite_in_order<M: OrderedCompositing>(
        &mut self,
        method: &M,
        tile: &[[u32; 2]],
        counters: &mut Counters,
        pixels: &mut Vec<Pixel>,
    ) {
        let rays = self.pixel_rays(tile);
        let mut sorted = std::mem::take(&mut self.workspace.sorted);
        if method.traversal() == Traversal::Sorted {
            self.sorted_hits(&rays, &mut sorted, counters);
        }
        for (index, ray) in rays.iter().enumerate() {
            self.pixel_at = ray.at;
            let camera_ray = &ray.camera;
            let mut pixel = method.begin(&self.pixel_site(ray.at));
            let mut last = None;
            let mut transparent = false;
            let mut take = |hit: &Hit, alpha: f32, counters: &mut Counters| {
                last = Some(*hit);
                transparent |= alpha < 1.0;
                let depths = [self.depth(camera_ray, hit)];
                let fragment = self.fragment(hit, alpha, 1, &depths);
                method.add(&mut pixel, &fragment, || self.shade_through_glass(camera_ray, hit, counters))
            };
            match method.traversal() {
                Traversal::Continuation => self.continuation(&self.ray(camera_ray), counters, &mut take),
                Traversal::Sorted => {
                    let _ = sorted[index].iter().try_for_each(|(hit, alpha)| take(hit, *alpha, counters));
                }
            }
            let transmittance = method.transmittance(&pixel);
            let mut colour = Premul { rgb: method.resolve(&pixel), alpha: 1.0 - transmittance };
            if transmittance > MIN_VISIBILITY {
                // Everything was transparent: the background is the last fragment.
                colour = colour.over(self.background_through_glass(camera_ray, counters));
                last = None;
            }
            pixels.push(self.pixel(colour, ray.sample, camera_ray, last.as_ref(), transparent));
        }
        self.workspace.sorted = sorted;
    }

    /// All visible hits of each ray up to the first opaque one, in one traversal, sorted by depth, then
    /// triangle. There may be more elements than rays.
    fn sorted_hits(&self, rays: &[PixelRay], sorted: &mut Vec<Vec<(Hit, f32)>>, counters: &mut Counters) {
        sorted.iter_mut().for_each(Vec::clear);
        sorted.resize_with(sorted.len().max(rays.len()), Vec::new);
        self.stage.bvh().traverse_packet(&self.rays_left(rays), |index, hit| {
            let alpha = self.alpha(&hit);
            if alpha > 0.0 {
                sorted[index].push((hit, alpha));
            }
            if alpha >= 1.0 { hit.t } else { f32::INFINITY }
        });
        counters.camera_rays += rays.len() as u64;
        for hits in sorted {
            counters.hits += hits.len() as u64;
            let is_opaque = |(_, alpha): &&(Hit, f32)| *alpha >= 1.0;
            let t_opaque = hits.iter().filter(is_opaque).map(|(hit, _)| hit.t).fold(f32::INFINITY, f32::min);
            hits.retain(|(hit, _)| hit.t <= t_opaque);
            hits.sort_unstable_by(|(a, _), (b, _)| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        }
    }

    /// The paper's way (STD Listing 2): each ray starts at the last hit. It starts there inclusively and
    /// passes over what has been seen, so that a second surface at the same depth is not lost.
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
}
