//! How the two families find their fragments.

use std::ops::ControlFlow;

use sheer_accel::{Hit, Ray};
use sheer_image::Pixel;

use super::{Counters, Tracer};
use crate::contract::{Compositing, Gathering, Site, Tables, Threshold, keeps};

impl Tracer<'_> {
    /// One ray, one shaded fragment: the nearest hit whose alpha reaches its threshold (STD Listings 3 and 4).
    pub(super) fn pick(
        &mut self,
        method: &impl Threshold,
        tables: &Tables,
        at: [u32; 2],
        counters: &mut Counters,
    ) -> Pixel {
        let sample = self.sample(at);
        let camera_ray = self.camera_ray(sample);
        let mut tested = 0;
        // Nearest hit that is neither opaque nor nothing: it makes the pixel a transparent one, kept or not.
        let mut nearest_partial = f32::INFINITY;
        let picked = self.stage.bvh().closest(&self.ray(&camera_ray), |hit| {
            tested += 1;
            let alpha = self.alpha(hit);
            if alpha > 0.0 && alpha < 1.0 {
                nearest_partial = nearest_partial.min(hit.t);
            }
            keeps(alpha, || method.threshold(&self.site(at, &camera_ray, hit), tables)[0])
        });
        counters.camera_rays += 1;
        counters.hits += tested;

        let Some(hit) = picked else {
            let transparent = nearest_partial < f32::INFINITY;
            return self.pixel(self.background(&camera_ray), sample, &camera_ray, None, transparent);
        };
        let colour = sheer_core::colour::Premul { rgb: self.shade(&camera_ray, &hit, counters), alpha: 1.0 };
        self.pixel(colour, sample, &camera_ray, Some(&hit), nearest_partial <= hit.t)
    }

    fn site(&self, [x, y]: [u32; 2], ray: &sheer_scene::CameraRay, hit: &Hit) -> Site<1> {
        let frame = self.stage.frame();
        let object = frame.object(hit.triangle);
        let back = frame.side(hit.triangle, hit.front) == sheer_scene::FaceSide::Back;
        Site {
            pixel: [[x], [y]],
            frame: self.settings.frame,
            seed: self.settings.seed,
            instance: [object.id],
            geometry: [object.geometry],
            primitive: [hit.triangle - object.first_triangle],
            back: [u32::from(back)],
            position: (ray.origin + ray.direction * hit.t).to_array().map(|coordinate| [coordinate]),
        }
    }

    /// Hands the fragments of a pixel to the method, front to back; equal depths in the order of their triangles.
    pub(super) fn composite(
        &mut self,
        method: &impl Compositing,
        at: [u32; 2],
        counters: &mut Counters,
    ) -> Pixel {
        let sample = self.sample(at);
        let camera_ray = self.camera_ray(sample);
        let mut pixel = method.begin();
        let mut last = None;
        let mut transparent = false;
        let mut ended = false;
        let mut take = |hit: &Hit, alpha: f32, counters: &mut Counters| {
            last = Some(*hit);
            transparent |= alpha < 1.0;
            let flow = method.add(&mut pixel, alpha, || self.shade(&camera_ray, hit, counters));
            ended = flow.is_break();
            flow
        };
        match method.gathering() {
            Gathering::Sorted => {
                let mut hits = self.sorted_hits(&self.ray(&camera_ray), counters);
                let _ = hits.iter().try_for_each(|(hit, alpha)| take(hit, *alpha, counters));
                hits.clear();
                self.hits = hits;
            }
            Gathering::Continuation => self.continuation(&self.ray(&camera_ray), counters, &mut take),
        }
        let mut colour = method.resolve(pixel);
        if !ended {
            // Everything was transparent: the background is the last fragment.
            colour = colour.over(self.background(&camera_ray));
            last = None;
        }
        self.pixel(colour, sample, &camera_ray, last.as_ref(), transparent)
    }

    /// All visible hits up to the first opaque one in one traversal, sorted by depth, then triangle.
    fn sorted_hits(&self, ray: &Ray, counters: &mut Counters) -> Vec<(Hit, f32)> {
        let mut hits = Vec::with_capacity(self.hits.capacity());
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
        hits
    }

    /// The paper's way (Listing 2): each ray starts at the last hit. It starts there inclusively and passes over what has been seen, so
    /// that a second surface at the same depth is not lost.
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
                let seen = after.is_some_and(|last| (hit.t, hit.triangle) <= (last.t, last.triangle));
                !seen && self.alpha(hit) > 0.0
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
