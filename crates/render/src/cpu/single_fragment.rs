//! How the families of one shaded fragment find it.

use glam::Vec3;
use sheer_accel::Hit;
use sheer_core::{colour::Premul, coverage::Correction};
use sheer_image::Pixel;
use sheer_scene::CameraRay;

use super::{
    tile::PixelRay,
    tracer::Tracer,
    workspace::{NearLayers, is_behind},
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
    /// One ray, one shaded fragment a pixel: the one that `find` finds, the background if none. With a
    /// hybrid, after the exact fragments.
    pub(super) fn stochastic(
        &mut self,
        hybrid: Hybrid,
        tile: &[[u32; 2]],
        counters: &mut Counters,
        pixels: &mut Vec<Pixel>,
        find: impl Fn(&mut Self, &[PixelRay], &mut Counters) -> Vec<Found>,
    ) {
        let rays = self.pixel_rays(tile);
        if hybrid.visibility < 1.0 {
            return self.hybrid(hybrid, &rays, counters, pixels, find);
        }
        let found = find(self, &rays, counters);
        for (ray, Found { hit, transparent }) in rays.iter().zip(found) {
            self.pixel_at = ray.at;
            let colour = self.seen(&ray.camera, hit.as_ref(), counters);
            pixels.push(self.pixel(colour, ray.sample, &ray.camera, hit.as_ref(), transparent));
        }
    }

    /// The nearest fragments exactly, what is left of the visibility by what `find` finds behind them (STD
    /// section 3.4).
    fn hybrid(
        &mut self,
        hybrid: Hybrid,
        rays: &[PixelRay],
        counters: &mut Counters,
        pixels: &mut Vec<Pixel>,
        find: impl Fn(&mut Self, &[PixelRay], &mut Counters) -> Vec<Found>,
    ) {
        // Not below the baseline's end, so that a share of 0 is the baseline to the bit.
        let share = hybrid.visibility.max(MIN_VISIBILITY);
        let most = hybrid.layers.map_or(usize::MAX, |layers| layers as usize);
        let enough = |_, count, visibility| visibility <= share || count == most;
        let near = self.gather_near(rays, Correction::NONE, enough, counters);

        // One ray more where something is left to be seen.
        let last_visible = |near: &NearLayers| {
            near.layers.last().copied().filter(|last| near.ended && last.visibility > MIN_VISIBILITY)
        };
        let behind: Vec<PixelRay> = rays
            .iter()
            .zip(&near)
            .filter_map(|(ray, near)| Some(PixelRay { after: Some(last_visible(near)?.hit), ..*ray }))
            .collect();
        let mut rests = find(self, &behind, counters).into_iter();

        for (ray, near) in rays.iter().zip(&near) {
            self.pixel_at = ray.at;
            let camera_ray = &ray.camera;
            let mut rgb = Vec3::ZERO;
            let mut visibility = 1.0;
            for layer in &near.layers {
                rgb += visibility * layer.alpha * self.shade_through_glass(camera_ray, &layer.hit, counters);
                visibility = layer.visibility;
            }
            let mut transparent = near.layers.iter().any(|layer| layer.alpha < 1.0);
            // Front to back: the last fragment gives depth and motion, the background none.
            let mut last = near.layers.last().filter(|_| near.ended).map(|layer| layer.hit);
            let mut colour = Premul { rgb, alpha: 1.0 - visibility };
            if !near.ended {
                colour = colour.over(self.background_through_glass(camera_ray, counters));
            } else if last_visible(near).is_some() {
                counters.merged += u64::from(visibility > share);
                let rest = rests.next().expect("a ray was traced for each pixel that shows a rest");
                transparent |= rest.transparent;
                last = rest.hit;
                colour = colour.over(self.seen(camera_ray, last.as_ref(), counters));
            }
            pixels.push(self.pixel(colour, ray.sample, camera_ray, last.as_ref(), transparent));
        }
        self.near_layers = near;
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

    /// For each ray the nearest hit whose alpha reaches its threshold (STD Listings 3 and 4).
    pub(super) fn first_kept(
        &self,
        method: &impl Threshold,
        tables: &Tables,
        rays: &[PixelRay],
        counters: &mut Counters,
    ) -> Vec<Found> {
        let mut tested = 0;
        // Nearest hit that is neither opaque nor nothing: it makes the pixel a transparent one, kept or not.
        let mut nearest_partial: Vec<Option<Hit>> = vec![None; rays.len()];
        // Glass has more opacity than its alpha, and a correction may be any curve.
        let can_bound = !self.has_glass && self.correction == Correction::NONE;
        let mut hits = Vec::new();
        let accept = |index: usize, hit: &Hit| {
            let ray = &rays[index];
            if ray.after.is_some_and(|after| !is_behind(hit, &after)) {
                return false;
            }
            tested += 1;
            let threshold = || method.threshold(&self.site(method, ray.at, &ray.camera, hit), tables);
            let nearest = &mut nearest_partial[index];
            let mut known = None;
            // Most hits in smoke are below their threshold wherever in their texture they lie: these need not
            // be looked up, unless it is they that make the pixel a transparent one.
            if can_bound && nearest.is_some_and(|nearest| is_behind(hit, &nearest)) {
                let most = self.stage.frame().most_opacity(hit.triangle);
                if most < 1.0 {
                    let threshold = threshold();
                    if most < threshold {
                        return false;
                    }
                    known = Some(threshold);
                }
            }
            let alpha = self.correction.coverage(self.alpha(hit));
            if alpha > 0.0 && alpha < 1.0 {
                *nearest = nearest.filter(|nearest| is_behind(hit, nearest)).or(Some(*hit));
            }
            keeps(alpha, || known.unwrap_or_else(&threshold))
        };
        self.stage.bvh().closest_of_packet(&self.rays_left(rays), accept, &mut hits);
        counters.camera_rays += rays.len() as u64;
        counters.hits += tested;
        let found = |(hit, partial): (Option<Hit>, Option<Hit>)| Found {
            hit,
            transparent: partial.is_some_and(|partial| hit.is_none_or(|hit| !is_behind(&partial, &hit))),
        };
        hits.into_iter().zip(nearest_partial).map(found).collect()
    }

    /// For each ray the hit with which the coverage accumulated from its beginning first exceeds the
    /// threshold of its pixel.
    pub(super) fn first_exceeding(
        &mut self,
        threshold: impl Fn([u32; 2]) -> f32,
        rays: &[PixelRay],
        counters: &mut Counters,
    ) -> Vec<Found> {
        let thresholds: Vec<f32> = rays.iter().map(|ray| threshold(ray.at)).collect();
        let exceeds = |ray: usize, _, visibility: f32| 1.0 - visibility > thresholds[ray];
        let near = self.gather_near(rays, self.correction, exceeds, counters);
        let found = |near: &NearLayers| Found {
            hit: near.layers.last().filter(|_| near.ended).map(|layer| layer.hit),
            transparent: near.layers.iter().any(|layer| layer.alpha < 1.0),
        };
        let found = near.iter().take(rays.len()).map(found).collect();
        self.near_layers = near;
        found
    }

    /// For each ray its hits, front to back, up to the first with which it is `enough`: a predicate of the
    /// ray's index, of their count and of the visibility behind them, see [`NearLayers::add`]. Their alpha is
    /// the corrected one. There may be more elements than rays. The caller gives the memory back.
    ///
    /// One traversal for all.
    pub(super) fn gather_near(
        &mut self,
        rays: &[PixelRay],
        correction: Correction,
        enough: impl Fn(usize, usize, f32) -> bool,
        counters: &mut Counters,
    ) -> Vec<NearLayers> {
        let mut near = std::mem::take(&mut self.near_layers);
        near.iter_mut().for_each(NearLayers::clear);
        near.resize_with(near.len().max(rays.len()), Default::default);
        let mut tested = 0;
        self.stage.bvh().traverse_packet(&self.rays_left(rays), |index, hit| {
            let is_new = rays[index].after.is_none_or(|after| is_behind(&hit, &after));
            let alpha = if is_new { correction.coverage(self.alpha(&hit)) } else { 0.0 };
            tested += u64::from(is_new);
            near[index].add(hit, alpha, |count, visibility| enough(index, count, visibility))
        });
        counters.camera_rays += rays.len() as u64;
        counters.hits += tested;
        near
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
