//! One shaded fragment a pixel, with what is known of its layers without shading: how much the front covers,
//! and how both move. Enderton et al. correct alpha so (ST section 3.3): the coverage is exact, only the
//! colour is a sample.

use glam::Vec3;
use sheer_image::{Pixel, PixelLayers};
use sheer_scene::CameraRay;

use super::{single_fragment::Found, tracer::Tracer, workspace::Layer};
use crate::{
    contract::{DENSE_VISIBILITY, Tables, Threshold, keeps},
    cost::Counters,
};

/// The front of a pixel: its transparent fragments before the nearest opaque surface.
pub(super) struct Front<'a> {
    /// Front to back.
    pub(super) fragments: &'a [Layer],
    /// Share of the front in what is seen.
    pub(super) coverage: f32,
    /// Hardly anything is seen through it, so that what lies behind has not been looked for: all there is
    /// counts as the front.
    pub(super) is_dense: bool,
}

/// Which fragment of a pixel is shaded.
pub(super) struct Choice {
    /// Index of a fragment of the front; none for what lies behind.
    pub(super) front: Option<usize>,
    /// Probability with which it was to be one of the front.
    pub(super) share: f32,
}

impl Tracer<'_> {
    /// One traversal, one shaded fragment: `choose` says which. Now and then it is one behind a dense front,
    /// which `find` looks for by another ray.
    pub(super) fn layered(
        &mut self,
        at: [u32; 2],
        counters: &mut Counters,
        choose: impl FnOnce(&mut Self, &CameraRay, &Front<'_>) -> Choice,
        find: impl FnOnce(&mut Self, &CameraRay, &mut Counters) -> Found,
    ) -> Pixel {
        let sample = self.sample(at);
        let ray = self.camera_ray(sample);
        let is_enough = |_, visibility| visibility <= DENSE_VISIBILITY;
        let ended = self.gather_front(&ray, None, self.correction, is_enough, counters);
        let mut front = std::mem::take(&mut self.layers);
        let opaque = front.pop_if(|layer| ended && layer.alpha >= 1.0).map(|layer| layer.hit);
        let is_dense = ended && opaque.is_none();
        let coverage = match front.last() {
            None => 0.0,
            Some(_) if is_dense => 1.0,
            Some(last) => 1.0 - last.visibility,
        };

        let choice = choose(self, &ray, &Front { fragments: &front, coverage, is_dense });
        let hit = match choice.front {
            Some(index) => Some(front[index].hit),
            None if is_dense => find(self, &ray, counters).hit,
            None => opaque,
        };
        let is_front = is_dense || choice.front.is_some();
        // A back is kept as it is, and seen through the glass of this frame.
        let has_back = !is_dense && !front.is_empty();
        let colour = if is_front || !has_back {
            self.seen(&ray, hit.as_ref(), counters)
        } else {
            self.unfiltered(&ray, hit.as_ref(), counters)
        };
        let tint = if has_back { self.tint_before(&ray, opaque.as_ref(), counters) } else { Vec3::ONE };
        let absorbed = ((1.0 - coverage) * (Vec3::ONE - tint)).to_array();
        let mut pixel = self.pixel(colour, sample, &ray, hit.as_ref(), !front.is_empty());
        let (front_motion, front_depth) = self.front_motion(&front);
        let (back_motion, back_depth) = match opaque {
            _ if is_dense => (front_motion, front_depth),
            // The pixel is that of the back.
            _ if !is_front => (pixel.motion, pixel.depth),
            Some(opaque) => self.motion_and_depth(&opaque),
            None => (self.motion_at_infinity(sample, &ray), f32::INFINITY),
        };
        pixel.layers = PixelLayers {
            coverage,
            absorbed,
            share: choice.share,
            is_front,
            front_motion,
            front_depth,
            back_motion,
            back_depth,
        };
        self.layers = front;
        pixel
    }

    /// Motion in pixels and depth of the mean of the fragments of a front, weighted by their shares of the
    /// pixel.
    fn front_motion(&self, front: &[Layer]) -> ([f32; 2], f32) {
        let mut before = 1.0;
        let mut weights = 0.0;
        let mut sums = [Vec3::ZERO; 2];
        for layer in front {
            let weight = before - layer.visibility;
            before = layer.visibility;
            weights += weight;
            let positions = self.stage.frame().positions(layer.hit.triangle, layer.hit.u, layer.hit.v);
            for (sum, position) in sums.iter_mut().zip(positions) {
                *sum += position * weight;
            }
        }
        if weights <= 0.0 {
            return ([0.0; 2], f32::INFINITY);
        }
        let [position, previous] = sums.map(|sum| sum / weights);
        self.motion_and_depth_of(position, previous)
    }
}

/// What a threshold method shades: the nearest fragment that reaches its threshold. Its share of the front is
/// taken to be the coverage.
pub(super) fn by_threshold<'m, M: Threshold>(
    method: &'m M,
    tables: &'m Tables,
    at: [u32; 2],
) -> impl FnOnce(&mut Tracer<'_>, &CameraRay, &Front<'_>) -> Choice + 'm {
    move |tracer, ray, front| {
        let is_kept = |layer: &Layer| {
            keeps(layer.alpha, || method.threshold(&tracer.site(method, at, ray, &layer.hit), tables))
        };
        Choice { front: front.fragments.iter().position(is_kept), share: front.coverage }
    }
}

/// What a selection method shades: one of the front with a share of the coverage kept between `least_share`
/// and its complement, where there are both layers; within the front the fragment with which the coverage
/// exceeds the threshold, spread over it.
pub(super) fn by_selection(
    threshold: f32,
    least_share: f32,
) -> impl FnOnce(&mut Tracer<'_>, &CameraRay, &Front<'_>) -> Choice {
    move |_, _, &Front { fragments, coverage, is_dense }| {
        let share = if coverage > 0.0 && coverage < 1.0 {
            coverage.clamp(least_share, 1.0 - least_share)
        } else {
            coverage
        };
        if threshold >= share {
            return Choice { front: None, share };
        }
        let wanted = threshold / share * coverage;
        let exceeding = fragments.iter().position(|layer| 1.0 - layer.visibility > wanted);
        // Rounding may leave a threshold just below the share beyond the last fragment.
        let last = (!is_dense).then(|| fragments.len() - 1);
        Choice { front: exceeding.or(last), share }
    }
}
