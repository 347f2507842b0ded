//! One shaded fragment a pixel, with what is known of its layers without shading: how much the front covers,
//! and how both move. Enderton et al. correct alpha so (ST section 3.3): the coverage is exact, only the
//! colour is a sample.

use glam::Vec3;
use sheer_accel::Hit;
use sheer_image::{Pixel, PixelLayers};

use super::{single_fragment::Found, tile::PixelRay, tracer::Tracer, workspace::Layer};
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

/// What is chosen of a pixel whose front is known.
struct Chosen {
    /// The nearest opaque surface, if it is not behind a dense front.
    opaque: Option<Hit>,
    is_dense: bool,
    coverage: f32,
    choice: Choice,
}

impl Chosen {
    /// Whether the fragment lies where nobody has looked yet.
    fn is_hidden(&self) -> bool {
        self.is_dense && self.choice.front.is_none()
    }
}

impl Tracer<'_> {
    /// One traversal, one shaded fragment a pixel: `choose` says which. Now and then it is one behind a dense
    /// front, which `find` looks for by another ray.
    pub(super) fn layered(
        &mut self,
        tile: &[[u32; 2]],
        counters: &mut Counters,
        pixels: &mut Vec<Pixel>,
        choose: impl Fn(&Self, &PixelRay, &Front<'_>) -> Choice,
        find: impl Fn(&mut Self, &[PixelRay], &mut Counters) -> Vec<Found>,
    ) {
        let rays = self.pixel_rays(tile);
        let is_enough = |_, _, visibility| visibility <= DENSE_VISIBILITY;
        let mut near = self.gather_near(&rays, self.correction, is_enough, counters);
        let chosen: Vec<Chosen> = rays
            .iter()
            .zip(&mut near)
            .map(|(ray, near)| {
                let opaque = near.layers.pop_if(|layer| near.ended && layer.alpha >= 1.0);
                let opaque = opaque.map(|layer| layer.hit);
                let is_dense = near.ended && opaque.is_none();
                let coverage = match near.layers.last() {
                    None => 0.0,
                    Some(_) if is_dense => 1.0,
                    Some(last) => 1.0 - last.visibility,
                };
                let choice = choose(self, ray, &Front { fragments: &near.layers, coverage, is_dense });
                Chosen { opaque, is_dense, coverage, choice }
            })
            .collect();
        let hidden: Vec<PixelRay> =
            rays.iter().zip(&chosen).filter_map(|(ray, chosen)| chosen.is_hidden().then_some(*ray)).collect();
        let mut found = find(self, &hidden, counters).into_iter();

        for ((ray, near), chosen) in rays.iter().zip(&near).zip(&chosen) {
            self.pixel_at = ray.at;
            let hit = match chosen.choice.front {
                Some(index) => Some(near.layers[index].hit),
                None if chosen.is_dense => {
                    found.next().expect("a ray was traced for each fragment behind a dense front").hit
                }
                None => chosen.opaque,
            };
            pixels.push(self.layered_pixel(ray, &near.layers, chosen, hit, counters));
        }
        self.near_layers = near;
    }

    /// The pixel that shows `hit`, with what is known of its layers.
    fn layered_pixel(
        &self,
        &PixelRay { sample, camera: ref ray, .. }: &PixelRay,
        front: &[Layer],
        &Chosen { opaque, is_dense, coverage, ref choice }: &Chosen,
        hit: Option<Hit>,
        counters: &mut Counters,
    ) -> Pixel {
        let is_front = is_dense || choice.front.is_some();
        // A back is kept as it is, and seen through the glass of this frame.
        let has_back = !is_dense && !front.is_empty();
        let colour = if is_front || !has_back {
            self.seen(ray, hit.as_ref(), counters)
        } else {
            self.unfiltered(ray, hit.as_ref(), counters)
        };
        let tint = if has_back { self.tint_before(ray, opaque.as_ref(), counters) } else { Vec3::ONE };
        let absorbed = ((1.0 - coverage) * (Vec3::ONE - tint)).to_array();
        let mut pixel = self.pixel(colour, sample, ray, hit.as_ref(), !front.is_empty());
        let (front_motion, front_depth) = self.front_motion(front);
        let (back_motion, back_depth) = match opaque {
            _ if is_dense => (front_motion, front_depth),
            // The pixel is that of the back.
            _ if !is_front => (pixel.motion, pixel.depth),
            Some(opaque) => self.motion_and_depth(&opaque),
            None => (self.motion_at_infinity(sample, ray), f32::INFINITY),
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
pub(super) fn by_threshold(
    method: &impl Threshold,
    tables: &Tables,
) -> impl Fn(&Tracer<'_>, &PixelRay, &Front<'_>) -> Choice {
    move |tracer, ray, front| {
        let is_kept = |layer: &Layer| {
            let site = || tracer.site(method, ray.at, &ray.camera, &layer.hit);
            keeps(layer.alpha, || method.threshold(&site(), tables))
        };
        Choice { front: front.fragments.iter().position(is_kept), share: front.coverage }
    }
}

/// What a selection method shades: one of the front with a share of the coverage kept between `least_share`
/// and its complement, where there are both layers; within the front the fragment with which the coverage
/// exceeds the threshold of the pixel, spread over it.
pub(super) fn by_selection(
    threshold: impl Fn([u32; 2]) -> f32,
    least_share: f32,
) -> impl Fn(&Tracer<'_>, &PixelRay, &Front<'_>) -> Choice {
    move |_, ray, &Front { fragments, coverage, is_dense }| {
        let threshold = threshold(ray.at);
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
