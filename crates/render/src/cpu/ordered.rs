//! How compositing methods get their fragments front to back.

use std::ops::ControlFlow;

use sheer_accel::{Hit, Ray};
use sheer_core::colour::Premul;
use sheer_image::Pixel;

use super::tracer::{Tracer, is_behind};
use crate::{
    contract::{MIN_VISIBILITY, OrderedCompositing, Traversal},
    cost::Counters,
};

impl Tracer<'_> {
    /// Front to back, equal depths in the order of their triangles; what is opaque comes last, as a fragment.
    pub(super) fn composite_in_order<M: OrderedCompositing>(
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
            method.add(&mut pixel, &fragment, || self.shade_through_glass(&camera_ray, hit, counters))
        };
        let ray = self.ray(&camera_ray);
        match method.traversal() {
            Traversal::Continuation => self.continuation(&ray, counters, &mut take),
            Traversal::Sorted => {
                let mut hits = Vec::with_capacity(self.workspace.sorted.capacity());
                self.sorted_hits(&ray, &mut hits, counters);
                let _ = hits.iter().try_for_each(|(hit, alpha)| take(hit, *alpha, counters));
                hits.clear();
                self.workspace.sorted = hits;
            }
        }
        let transmittance = method.transmittance(&pixel);
        let mut colour = Premul { rgb: method.resolve(&pixel), alpha: 1.0 - transmittance };
        if transmittance > MIN_VISIBILITY {
            // Everything was transparent: the background is the last fragment.
            colour = colour.over(self.background_through_glass(&camera_ray, counters));
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
