//! Deep shadow rays: the exact light that passes everything between a point and a light (STD section 3.1).
//!
//! A ray to a light that is infinitely far away finds what moves down a list of a light buffer, where there
//! is one, and what stays through the acceleration structure; all others go through that alone. The hits are
//! the same, and so is their [`Product`].

use std::sync::Arc;

use glam::Vec3;
use sheer_accel::{Hit, LightBuffer, Ray};
use sheer_core::{bibliography, parameter::Values};
use sheer_scene::model::LightKind;

use super::technique::{Map, Receiver, ShadowInfo, Technique, View};
use crate::{
    contract::{MIN_ALPHA, MIN_VISIBILITY},
    cost::Counters,
    stage::Stage,
};

/// The row of the technique in lists and help.
pub(super) const INFO: ShadowInfo = ShadowInfo {
    id: "deep",
    title: "a ray through everything between a fragment and a light",
    paper: "Brüll, Kern, Grosch (STD), section 3.1",
    works: &[&bibliography::STD],
    bias: "none",
    parameters: &[],
};

/// Deep shadow rays, which have no parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Deep;

impl Deep {
    pub(super) fn new(_: &Values) -> Self {
        Self
    }
}

impl Technique for Deep {
    fn resolution(&self) -> u32 {
        0
    }

    fn texel_bytes(&self, _: usize) -> usize {
        0
    }

    fn map(&self, view: &View<'_>) -> Box<dyn Map> {
        let buffer = match view.light.kind {
            LightKind::Directional => view.stage.light_buffer(-view.light.direction, view.pixels),
            LightKind::Point { .. } | LightKind::Spot { .. } => None,
        };
        Box::new(Rays { tinted: view.channels > 1, buffer })
    }

    fn values(&self) -> Vec<String> {
        Vec::new()
    }
}

/// In place of a map: a ray for each lookup.
#[derive(Debug)]
struct Rays {
    tinted: bool,
    /// What moves, for a light that is infinitely far away.
    buffer: Option<Arc<LightBuffer>>,
}

impl Map for Rays {
    fn transmittance(&self, stage: &Stage, receiver: &Receiver, counters: &mut Counters) -> Vec3 {
        counters.shadow_rays += 1;
        let frame = stage.frame();
        if self.tinted {
            let through = |hit: &Hit, alpha| {
                let Hit { triangle, u, v, front, .. } = *hit;
                frame.light_through(triangle, u, v, front, alpha, receiver.width).to_array()
            };
            Vec3::from(self.passing(stage, receiver, through))
        } else {
            let [light] = self.passing(stage, receiver, |_, alpha| [1.0 - alpha]);
            Vec3::splat(light)
        }
    }
}

impl Rays {
    /// What of the light's channels passes every hit, none once all are too dark to see. `through`: the share
    /// that passes a hit of an opacity.
    fn passing<const CHANNELS: usize>(
        &self,
        stage: &Stage,
        receiver: &Receiver,
        through: impl Fn(&Hit, f32) -> [f32; CHANNELS],
    ) -> [f32; CHANNELS] {
        let lift = receiver.lift(stage);
        // Lifted towards the light's side of the surface.
        let side = receiver.normal.dot(receiver.to_light).signum();
        let origin = receiver.position + receiver.normal * (side * lift);
        let distance = receiver.distance - 2.0 * lift;
        let mut light = Product::<CHANNELS>::ONE;
        let mut visit = |hit: Hit| {
            let alpha = stage.frame().opacity(hit.triangle, hit.u, hit.v, receiver.width);
            if alpha >= MIN_ALPHA {
                light.multiply(through(&hit, alpha));
            }
            if light.is_dark() { f32::NEG_INFINITY } else { distance }
        };
        let ray = Ray { origin, direction: receiver.to_light, t_min: 0.0, t_max: distance };
        if let Some(buffer) = self.buffer.as_ref().filter(|buffer| buffer.serves(&ray)) {
            // What stays is mostly opaque: behind that, nothing else has to be looked for.
            let mut left = distance;
            stage.bvh().traverse_kept(&ray, |hit| {
                left = visit(hit);
                left
            });
            if left >= 0.0 {
                buffer.traverse(&ray, visit);
            }
        } else {
            stage.bvh().traverse(&ray, visit);
        }
        if light.is_dark() { [0.0; CHANNELS] } else { light.get() }
    }
}

/// A product of shares for each channel that does not depend on the order of its factors, as the order of
/// hits depends on how they are found. What passes a surface of an opacity is a multiple of 2^-24, as the
/// opacity is an `f32`, and what passes coloured glass is cut to one. So products are integers, of which the
/// lowest of 103 places is lost from the fifth factor on: order would show in one of 2^60 results or so.
#[derive(Clone, Copy, Debug)]
struct Product<const CHANNELS: usize>([u128; CHANNELS]);

impl<const CHANNELS: usize> Product<CHANNELS> {
    /// Binary places of a product.
    const PLACES: u32 = 103;
    /// Binary places of a factor; together with the product's they fill 127 bits.
    const FACTOR_PLACES: u32 = 24;
    const ONE: Self = Self([1 << Self::PLACES; CHANNELS]);
    /// [`MIN_VISIBILITY`] as a product.
    const DARK: u128 = (MIN_VISIBILITY as f64 * (1_u128 << Self::PLACES) as f64) as u128;

    #[inline]
    fn multiply(&mut self, factors: [f32; CHANNELS]) {
        for (product, factor) in self.0.iter_mut().zip(factors) {
            let factor = (factor * (1_u32 << Self::FACTOR_PLACES) as f32) as u32;
            *product = (*product * u128::from(factor.min(1 << Self::FACTOR_PLACES))) >> Self::FACTOR_PLACES;
        }
    }

    #[inline]
    fn is_dark(&self) -> bool {
        self.0.iter().all(|&product| product <= Self::DARK)
    }

    fn get(&self) -> [f32; CHANNELS] {
        self.0.map(|product| product as f32 / (1_u128 << Self::PLACES) as f32)
    }
}

#[cfg(test)]
mod tests {
    use sheer_core::hash::pcg3d;

    use super::*;

    fn product(factors: &[f32]) -> f32 {
        let mut product = Product::<1>::ONE;
        factors.iter().for_each(|&factor| product.multiply([factor]));
        product.get()[0]
    }

    #[test]
    fn light_does_not_depend_on_the_order_of_what_it_passes() {
        let mut order_shows_in_floats = false;
        for trial in 0..2000 {
            let unit = |index: u32| (pcg3d([trial, index, 7])[0] >> 8) as f32 / (1 << 24) as f32;
            let factors: Vec<f32> = (0..30).map(|index| 1.0 - 0.3 * unit(index)).collect();
            let mut shuffled = factors.clone();
            shuffled.sort_by_key(|factor| pcg3d([factor.to_bits(), trial, 3])[0]);
            let product_of = |factors: &[f32]| factors.iter().product::<f32>();
            order_shows_in_floats |= product_of(&factors) != product_of(&shuffled);
            let expected = factors.iter().map(|&factor| f64::from(factor)).product::<f64>();
            let found = product(&factors);
            assert_eq!(found.to_bits(), product(&shuffled).to_bits(), "trial {trial}");
            assert!((f64::from(found) / expected - 1.0).abs() <= 1e-7, "{found}, not {expected}");
        }
        assert!(order_shows_in_floats, "the test would not see an order");
    }

    #[test]
    fn all_light_and_none_are_exact_and_darkness_begins_at_the_least_visibility() {
        assert_eq!([product(&[]), product(&[1.0; 9]), product(&[0.5, 0.0, 0.7])], [1.0, 1.0, 0.0]);
        assert_eq!(product(&[0.5; 6]), 1.0 / 64.0);
        let is_dark = |factors: &[f32]| {
            let mut product = Product::<1>::ONE;
            factors.iter().for_each(|&factor| product.multiply([factor]));
            product.is_dark()
        };
        assert!(is_dark(&[0.9 * MIN_VISIBILITY]) && !is_dark(&[1.1 * MIN_VISIBILITY]) && !is_dark(&[]));
        let mut tinted = Product::<3>::ONE;
        tinted.multiply([0.0, 0.0, 0.5]);
        assert!(!tinted.is_dark());
        assert_eq!(tinted.get(), [0.0, 0.0, 0.5]);
    }
}
