//! Coloured glass: what shines through a surface in the surface's colour.
//!
//! Methods know one opacity a fragment, and all that they do with it stays as it is: of coloured glass it is
//! the opacity to the channel that passes best. What the other channels lose on top is a tint, a factor of 0
//! to 1 on red, green and blue. The backend multiplies what is shaded, and the background, by the tints of
//! all glass in front of it. So a sum over fragments front to back is that of the red, green and blue
//! transmittances, exactly, and a fragment that chance keeps comes with a weight that makes its mean exact;
//! no weight exceeds 1, whatever chance keeps.

use glam::Vec3;
use sheer_accel::{Hit, Ray};
use sheer_core::colour::Premul;
use sheer_scene::{CameraRay, Transmitted};

use super::{tracer::Tracer, workspace::is_behind};
use crate::{contract::MIN_ALPHA, cost::Counters};

/// What coloured glass does to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glass {
    /// Opacity to the channel that passes best; 0 if nobody would see a fragment of so little.
    pub(super) alpha: f32,
    /// What passes of each channel, over what passes of the one that passes best.
    pub(super) tint: Vec3,
    /// The fragment's own light, reflected and emitted, over what its alpha stands for: below 1, since what
    /// glass absorbs lets nothing pass, either, and sends out nothing.
    pub(super) own_share: f32,
}

impl Glass {
    /// A surface of an opacity that transmits light.
    fn new(opacity: f32, Transmitted { share, filter }: Transmitted) -> Self {
        let best = filter.max_element();
        let alpha = opacity + share * (1.0 - best);
        let through = Vec3::splat(1.0 - opacity) - share * (Vec3::ONE - filter);
        if alpha < MIN_ALPHA {
            // No fragment, but what it takes of the other channels may be seen.
            return Self { alpha: 0.0, tint: through, own_share: 1.0 };
        }
        let passes = 1.0 - alpha;
        let tint = if passes > 0.0 { (through / passes).clamp(Vec3::ZERO, Vec3::ONE) } else { Vec3::ONE };
        Self { alpha, tint, own_share: opacity / alpha }
    }
}

impl Tracer<'_> {
    /// What a hit does to light, if it is of coloured glass.
    pub(super) fn glass(&self, hit: &Hit) -> Option<Glass> {
        let frame = self.stage.frame();
        if !self.has_glass || !frame.is_tinted(hit.triangle) {
            return None;
        }
        let width = self.beam.width_at(hit.t);
        let opacity = frame.opacity_for_camera(hit.triangle, hit.u, hit.v, hit.front, width);
        let transmitted = frame.transmitted(hit.triangle, hit.u, hit.v, hit.front, opacity, width)?;
        Some(Glass::new(opacity, transmitted))
    }

    /// The tint of all glass between the eye and a hit, or the far distance.
    pub(super) fn tint_before(&self, ray: &CameraRay, hit: Option<&Hit>, counters: &mut Counters) -> Vec3 {
        if !self.has_glass {
            return Vec3::ONE;
        }
        let ray = self.ray(ray);
        let end = hit.map_or(ray.t_max, |hit| hit.t);
        let mut tints: Vec<(Hit, Vec3)> = Vec::new();
        self.stage.bvh().traverse(&Ray { t_max: end, ..ray }, |other| {
            if hit.is_none_or(|hit| is_behind(hit, &other)) {
                tints.extend(self.glass(&other).map(|glass| (other, glass.tint)));
            }
            end
        });
        counters.camera_rays += 1;
        // The order of the ray, as rounding would show that in which the tree happens to find them.
        tints.sort_unstable_by(|(a, _), (b, _)| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        tints.into_iter().map(|(_, tint)| tint).product()
    }

    /// Linear radiance of a hit, as it arrives through the tints of all glass in front of it.
    pub(super) fn shade_through_glass(&self, ray: &CameraRay, hit: &Hit, counters: &mut Counters) -> Vec3 {
        let radiance = self.shade(ray, hit, counters);
        if self.has_glass { radiance * self.tint_before(ray, Some(hit), counters) } else { radiance }
    }

    /// The background, as it arrives through the tints of all glass. Where it is clear, what glass absorbs
    /// is opaque: the alpha is what the mean of red, green and blue loses.
    pub(super) fn background_through_glass(&self, ray: &CameraRay, counters: &mut Counters) -> Premul {
        let background = self.background(ray);
        if self.has_glass { background.filtered(self.tint_before(ray, None, counters)) } else { background }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alpha_and_tint_are_the_transmittance_and_nothing_exceeds_one() {
        for opacity in [0.15, 0.5, 0.75] {
            for filter in [Vec3::X, Vec3::new(0.9, 0.5, 0.1), Vec3::splat(0.3), Vec3::ONE] {
                let transmitted = Transmitted { share: 0.8 * (1.0 - opacity), filter };
                let glass = Glass::new(opacity, transmitted);
                let through = Vec3::splat(1.0 - opacity) - transmitted.share * (Vec3::ONE - filter);
                assert!(((1.0 - glass.alpha) * glass.tint).abs_diff_eq(through, 1e-6), "{glass:?}");
                assert!(glass.tint.max_element() <= 1.0 && glass.tint.min_element() >= 0.0, "{glass:?}");
                assert!((glass.alpha * glass.own_share - opacity).abs() < 1e-6 && glass.own_share <= 1.0);
            }
        }
    }

    #[test]
    fn clear_glass_is_an_ordinary_fragment_to_the_bit() {
        let glass = Glass::new(0.15, Transmitted { share: 0.85, filter: Vec3::ONE });
        assert_eq!(glass, Glass { alpha: 0.15, tint: Vec3::ONE, own_share: 1.0 });
    }

    #[test]
    fn black_glass_hides_what_is_behind_and_faint_glass_only_tints() {
        let black = Glass::new(0.2, Transmitted { share: 0.8, filter: Vec3::ZERO });
        assert_eq!((black.alpha, black.tint), (1.0, Vec3::ONE));
        let faint = Glass::new(0.002, Transmitted { share: 0.998, filter: Vec3::new(1.0, 0.5, 0.0) });
        assert_eq!(faint.alpha, 0.0);
        assert!(faint.tint.abs_diff_eq(Vec3::new(0.998, 0.499, 0.0), 1e-6), "{faint:?}");
    }
}
