//! How the families of one shaded fragment find it.

use glam::{Vec2, Vec3};
use sheer_accel::Hit;
use sheer_core::{colour::Premul, coverage::Correction};
use sheer_image::Pixel;
use sheer_scene::CameraRay;

use super::{
    tracer::{Tracer, is_behind},
    workspace::Layer,
};
use crate::{
    contract::{Hybrid, MIN_VISIBILITY, Site, Tables, Threshold, keeps},
    cost::Counters,
};

/// What a stochastic ray found.
pub(super) struct Found {
    pub(super) hit: Option<Hit>,
    /// Whether the ray met something that is neither opaque nor nothing on its way.
    transparent: bool,
}

impl Tracer<'_> {
    /// One ray, one shaded fragment: the one that `find` finds, the background if none. With a hybrid, after
    /// the exact fragments.
    pub(super) fn stochastic(
        &mut self,
        hybrid: Hybrid,
        at: [u32; 2],
        counters: &mut Counters,
        find: impl FnOnce(&mut Self, &CameraRay, Option<Hit>, &mut Counters) -> Found,
    ) -> Pixel {
        let sample = self.sample(at);
        let camera_ray = self.camera_ray(sample);
        if hybrid.visibility < 1.0 {
            return self.hybrid(hybrid, sample, &camera_ray, counters, find);
        }
        let Found { hit, transparent } = find(self, &camera_ray, None, counters);
        let colour = self.seen(&camera_ray, hit.as_ref(), counters);
        self.pixel(colour, sample, &camera_ray, hit.as_ref(), transparent)
    }

    /// The nearest fragments exactly, what is left of the visibility by what `find` finds behind them (STD
    /// section 3.4).
    fn hybrid(
        &mut self,
        hybrid: Hybrid,
        sample: Vec2,
        camera_ray: &CameraRay,
        counters: &mut Counters,
        find: impl FnOnce(&mut Self, &CameraRay, Option<Hit>, &mut Counters) -> Found,
    ) -> Pixel {
        // Not below the baseline's end, so that a share of 0 is the baseline to the bit.
        let share = hybrid.visibility.max(MIN_VISIBILITY);
        let most = hybrid.layers.map_or(usize::MAX, |layers| layers as usize);
        let enough = |count, visibility| visibility <= share || count == most;
        let ended = self.gather_front(camera_ray, None, Correction::NONE, enough, counters);
        let mut rgb = Vec3::ZERO;
        let mut visibility = 1.0;
        for layer in &self.layers {
            rgb += visibility * layer.alpha * self.shade_through_glass(camera_ray, &layer.hit, counters);
            visibility = layer.visibility;
        }
        let mut transparent = self.layers.iter().any(|layer| layer.alpha < 1.0);
        // Front to back: the last fragment gives depth and motion, the background none.
        let mut last = self.layers.last().filter(|_| ended).map(|layer| layer.hit);
        let mut colour = Premul { rgb, alpha: 1.0 - visibility };
        if !ended {
            colour = colour.over(self.background_through_glass(camera_ray, counters));
        } else if visibility > MIN_VISIBILITY {
            counters.merged += u64::from(visibility > share);
            let rest = find(self, camera_ray, last, counters);
            transparent |= rest.transparent;
            last = rest.hit;
            colour = colour.over(self.seen(camera_ray, last.as_ref(), counters));
        }
        self.pixel(colour, sample, camera_ray, last.as_ref(), transparent)
    }

    /// A hit taken as opaque, or the background, through all glass in front of it.
    pub(super) fn seen(&self, ray: &CameraRay, hit: Option<&Hit>, counters: &mut Counters) -> Premul {
        match hit {
            Some(hit) => Premul { rgb: self.shade_through_glass(ray, hit, counters), alpha: 1.0 },
            None => self.background_through_glass(ray, counters),
        }
    }

    /// A hit taken as opaque, or the background, as if no glass were in front of it.
    pub(super) fn unfiltered(&self, ray: &CameraRay, hit: Option<&Hit>, counters: &mut Counters) -> Premul {
        hit.map_or_else(
            || self.background(ray),
            |hit| Premul { rgb: self.shade(ray, hit, counters), alpha: 1.0 },
        )
    }

    /// The nearest hit behind `after` whose alpha reaches its threshold (STD Listings 3 and 4).
    pub(super) fn first_kept(
        &self,
        method: &impl Threshold,
        tables: &Tables,
        at: [u32; 2],
        camera_ray: &CameraRay,
        after: Option<Hit>,
        counters: &mut Counters,
    ) -> Found {
        let mut tested = 0;
        // Nearest hit that is neither opaque nor nothing: it makes the pixel a transparent one, kept or not.
        let mut nearest_partial = f32::INFINITY;
        let hit = self.stage.bvh().closest(&self.ray_from(camera_ray, after), |hit| {
            if after.is_some_and(|after| !is_behind(hit, &after)) {
                return false;
            }
            tested += 1;
            let alpha = self.correction.coverage(self.alpha(hit));
            if alpha > 0.0 && alpha < 1.0 {
                nearest_partial = nearest_partial.min(hit.t);
            }
            keeps(alpha, || method.threshold(&self.site(method, at, camera_ray, hit), tables))
        });
        counters.camera_rays += 1;
        counters.hits += tested;
        let transparent = hit.map_or(nearest_partial < f32::INFINITY, |hit| nearest_partial <= hit.t);
        Found { hit, transparent }
    }

    /// The hit behind `after` with which the coverage accumulated from there first exceeds a threshold.
    pub(super) fn first_exceeding(
        &mut self,
        threshold: f32,
        camera_ray: &CameraRay,
        after: Option<Hit>,
        counters: &mut Counters,
    ) -> Found {
        let exceeds = |_, visibility: f32| 1.0 - visibility > threshold;
        let exceeded = self.gather_front(camera_ray, after, self.correction, exceeds, counters);
        Found {
            hit: self.layers.last().filter(|_| exceeded).map(|layer| layer.hit),
            transparent: self.layers.iter().any(|layer| layer.alpha < 1.0),
        }
    }

    /// Fills `layers` with the hits behind `after`, front to back, up to the first with which it is `enough`:
    /// a predicate of their count and of the visibility behind them that stays true as the one grows and the
    /// other falls. False if it never is enough. Their alpha is the corrected one.
    ///
    /// One traversal. A hit found late, in front of others, can only lower the visibility behind each of
    /// these, rounding included, so the end known so far is never nearer than the true one: what lies behind
    /// it is dropped at once and bounds the ray, and nothing is lost.
    pub(super) fn gather_front(
        &mut self,
        camera_ray: &CameraRay,
        after: Option<Hit>,
        correction: Correction,
        enough: impl Fn(usize, f32) -> bool,
        counters: &mut Counters,
    ) -> bool {
        let mut layers = std::mem::take(&mut self.layers);
        layers.clear();
        let mut ended = false;
        let mut tested = 0;
        self.stage.bvh().traverse(&self.ray_from(camera_ray, after), |hit| {
            let is_new = after.is_none_or(|after| is_behind(&hit, &after));
            let alpha = if is_new { correction.coverage(self.alpha(&hit)) } else { 0.0 };
            tested += u64::from(is_new);
            let index = layers.partition_point(|layer| is_behind(&hit, &layer.hit));
            let is_dropped = ended && index == layers.len();
            if alpha > 0.0 && !is_dropped {
                let mut visibility = if index == 0 { 1.0 } else { layers[index - 1].visibility };
                let mut count = index;
                layers.insert(index, Layer { hit, alpha, visibility });
                let end = layers[index..].iter_mut().position(|layer| {
                    visibility *= 1.0 - layer.alpha;
                    layer.visibility = visibility;
                    count += 1;
                    enough(count, visibility)
                });
                if let Some(end) = end {
                    ended = true;
                    layers.truncate(index + end + 1);
                }
            }
            layers.last().filter(|_| ended).map_or(f32::INFINITY, |layer| layer.hit.t)
        });
        counters.camera_rays += 1;
        counters.hits += tested;
        self.layers = layers;
        ended
    }

    pub(super) fn site(&self, method: &impl Threshold, at: [u32; 2], ray: &CameraRay, hit: &Hit) -> Site {
        let object = self.stage.frame().object(hit.triangle);
        let (position_in_object, footprint_in_object) =
            if method.uses_object_space() { self.object_space(at, hit) } else { (Vec3::ZERO, 0.0) };
        Site {
            pixel: at,
            frame: self.settings.frame,
            seed: self.settings.run.seed,
            instance: object.id,
            geometry: object.geometry,
            primitive: hit.triangle - object.first_triangle,
            back: u32::from(self.is_back(hit)),
            position: ray.origin + ray.direction * hit.t,
            position_in_object,
            footprint_in_object,
        }
    }
}
