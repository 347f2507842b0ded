//! Where the samples of a pixel lie.

use glam::Vec2;

use crate::contract::{Placement, Samples};

/// Offsets of a pixel's sample rays from its centre, pixels, the nearest first: the first sample of a surface
/// is where it is shaded.
pub(super) type SampleOffsets = Vec<Vec2>;

/// Inverse of the plastic number and its square: the additive recurrence that fills the plane most evenly
/// (Roberts 2018, *The Unreasonable Effectiveness of Quasirandom Sequences*), for any number of points.
const R2: Vec2 = Vec2::new(0.754_877_7, 0.569_840_3);
/// Standard deviation of the filter of ST section 3.5, which spans 2×2 pixels: at half a pixel it has fallen
/// to 0.14 at the end of the span.
const GAUSSIAN_SIGMA_PX: f32 = 0.5;

/// The offsets for a frame. Spread samples take the frame's jitter as a turn of the pattern, so that over
/// frames they fill the pixel.
pub(super) fn offsets(samples: Samples, jitter: Vec2) -> SampleOffsets {
    if samples.placement == Placement::Centre {
        return vec![jitter];
    }
    let turned = |index: u32| (R2 * (index as f32 + 0.5) + jitter).rem_euclid(Vec2::ONE);
    let offset = |unit: Vec2| match samples.placement {
        Placement::Centre | Placement::Box => unit - 0.5,
        Placement::Gaussian => unit.map(gaussian_quantile),
    };
    let mut offsets: Vec<Vec2> = (0..samples.count).map(|index| offset(turned(index))).collect();
    offsets.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    offsets
}

/// Where the Gaussian, cut off one pixel from the centre, has collected this share, 0 to 1.
fn gaussian_quantile(share: f32) -> f32 {
    let density = |x: f32| (-0.5 * (x / GAUSSIAN_SIGMA_PX).powi(2)).exp();
    // Steps of Simpson's rule, fine enough that the error is that of the rounding.
    const STEPS: u32 = 256;
    let step = 2.0 / STEPS as f32;
    let sum_to = |end: u32| -> f32 {
        (0..end)
            .map(|index| {
                let x = -1.0 + index as f32 * step;
                (density(x) + 4.0 * density(x + 0.5 * step) + density(x + step)) / 6.0
            })
            .sum()
    };
    let wanted = share * sum_to(STEPS);
    let mut sum = 0.0;
    for index in 0..STEPS {
        let x = -1.0 + index as f32 * step;
        let next = (density(x) + 4.0 * density(x + 0.5 * step) + density(x + step)) / 6.0;
        if sum + next >= wanted {
            return x + step * (wanted - sum) / next;
        }
        sum += next;
    }
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_samples_stay_in_their_pixel_and_are_balanced() {
        for count in [1, 4, 7, 8, 16, 64] {
            let samples = Samples { count, placement: Placement::Box };
            for jitter in [Vec2::ZERO, Vec2::new(0.3, -0.45)] {
                let offsets = offsets(samples, jitter);
                assert_eq!(offsets.len(), count as usize);
                assert!(offsets.iter().all(|offset| offset.abs().max_element() <= 0.5), "{offsets:?}");
                assert!(offsets.windows(2).all(|pair| pair[0].length() <= pair[1].length()));
                let mean = offsets.iter().sum::<Vec2>() / count as f32;
                assert!(mean.abs().max_element() <= 0.6 / count as f32 + 0.05, "{count}: {mean}");
            }
        }
    }

    #[test]
    fn gaussian_samples_have_the_moments_of_their_filter() {
        let samples = Samples { count: 64, placement: Placement::Gaussian };
        let offsets: Vec<Vec2> = (0..64)
            .flat_map(|frame| {
                offsets(samples, crate::temporal::jitter(crate::Antialiasing::ACCUMULATE, frame))
            })
            .collect();
        let variance = offsets.iter().map(|offset| *offset * *offset).sum::<Vec2>() / offsets.len() as f32;
        // Of a normal distribution cut off at two standard deviations: 0.7737 of the whole one's (Johnson and
        // Kotz 1970).
        let expected = 0.7737 * GAUSSIAN_SIGMA_PX * GAUSSIAN_SIGMA_PX;
        assert!((variance - expected).abs().max_element() < 0.005, "{variance}, {expected}");
        assert!(offsets.iter().all(|offset| offset.abs().max_element() <= 1.0));
    }

    #[test]
    fn samples_in_the_centre_share_one_ray() {
        let samples = Samples { count: 16, placement: Placement::Centre };
        assert_eq!(offsets(samples, Vec2::new(0.1, 0.2)), [Vec2::new(0.1, 0.2)]);
        assert_eq!((samples.all(), Samples::ONE.all()), (0xffff, 1));
        assert_eq!(Samples { count: 64, ..samples }.all(), u64::MAX);
    }
}
