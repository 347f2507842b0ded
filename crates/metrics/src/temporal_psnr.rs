//! How far the changes of a clip from frame to frame are from those of its reference.

use rayon::prelude::*;
use sheer_image::Image;

use crate::MetricError;
use crate::error::check_sizes;

/// Takes a clip in [0, 1] frame by frame and tells its tPSNR: the peak signal-to-noise ratio of the
/// differences of successive frames, in decibels. Infinite if every change is that of the reference.
///
/// It is to PSNR what [`Flicker`](crate::Flicker) is to RMS, but hears fast changes only: a slow drift costs
/// next to nothing.
#[derive(Clone, Debug, Default)]
pub struct TemporalPsnr<const N: usize> {
    /// Image minus reference: the difference of two frames' errors is the error of the frames' difference.
    error: Option<Image<[f32; N]>>,
    /// Mean square of the changes of the error, summed over the pairs of frames.
    squares: f64,
    pair_count: u32,
}

impl<const N: usize> TemporalPsnr<N> {
    /// A clip without frames.
    #[must_use]
    pub fn new() -> Self {
        Self { error: None, squares: 0.0, pair_count: 0 }
    }

    /// Takes the next frame.
    ///
    /// # Errors
    /// [`MetricError::SizesDiffer`] if the images, or this frame and the first, differ in size.
    pub fn add(&mut self, reference: &Image<[f32; N]>, image: &Image<[f32; N]>) -> Result<(), MetricError> {
        check_sizes(reference, image)?;
        let Some(error) = &mut self.error else {
            let error = Image::par_from_fn(image.width(), image.height(), |x, y| {
                difference(&image[(x, y)], &reference[(x, y)])
            });
            self.error = Some(error?);
            return Ok(());
        };
        check_sizes(error, image)?;
        let rows = error.par_rows_mut().zip(reference.par_rows()).zip(image.par_rows());
        let row_sums: Vec<f64> = rows
            .map(|((errors, references), values)| {
                let pixels = errors.iter_mut().zip(references).zip(values);
                let changes = pixels.map(|((error, reference), value)| {
                    let next = difference(value, reference);
                    difference(&next, &std::mem::replace(error, next))
                });
                changes.flatten().map(|change| f64::from(change).powi(2)).sum()
            })
            .collect();
        self.squares += row_sums.iter().sum::<f64>() / (image.as_slice().len() * N) as f64;
        self.pair_count += 1;
        Ok(())
    }

    /// The tPSNR of the frames so far in decibels: 10 log₁₀(1 / mean square change of the error). None for
    /// less than two frames.
    #[must_use]
    pub fn value_db(&self) -> Option<f64> {
        (self.pair_count > 0).then(|| -10.0 * (self.squares / f64::from(self.pair_count)).log10())
    }
}

fn difference<const N: usize>(a: &[f32; N], b: &[f32; N]) -> [f32; N] {
    std::array::from_fn(|channel| a[channel] - b[channel])
}

#[cfg(test)]
mod tests {
    use sheer_core::hash::Pcg32;

    use super::*;
    use crate::{flicker, psnr_db};

    fn clip(frames: u32, mut value: impl FnMut(u32, u32) -> f32) -> Vec<Image<[f32; 3]>> {
        (0..frames).map(|frame| Image::from_fn(16, 9, |x, _| [value(frame, x); 3]).unwrap()).collect()
    }

    fn tpsnr_db(references: &[Image<[f32; 3]>], images: &[Image<[f32; 3]>]) -> Option<f64> {
        let mut tpsnr = TemporalPsnr::new();
        for (reference, image) in references.iter().zip(images) {
            tpsnr.add(reference, image).unwrap();
        }
        tpsnr.value_db()
    }

    #[test]
    fn an_alternating_error_has_its_closed_form() {
        let still = clip(9, |_, _| 0.5);
        // The error is ±0.125, its changes are all 0.25.
        let blinking = clip(9, |frame, _| if frame % 2 == 0 { 0.375 } else { 0.625 });
        let found = tpsnr_db(&still, &blinking).unwrap();
        assert!((found - 20.0 * 4.0_f64.log10()).abs() < 1e-9, "{found}");
    }

    #[test]
    fn the_changes_of_independent_noise_have_twice_its_variance() {
        let mut random = Pcg32::new(3, 1);
        let still = clip(65, |_, _| 0.5);
        let noisy = clip(65, |_, _| 0.4 + 0.2 * random.next_f32());
        // Uniform over 0.2.
        let expected = -10.0 * (2.0 * 0.04 / 12.0_f64).log10();
        let found = tpsnr_db(&still, &noisy).unwrap();
        // 64 pairs of 144 independent pixels. A squared change has the relative variance 7/5, to which the
        // correlation of 1/7 with either neighbour adds its share: the mean has a relative deviation of 1.4
        // %. Four of these are 0.24 dB; forgetting the factor 2 is 3 dB.
        assert!((found - expected).abs() < 0.24, "{found} instead of {expected}");
    }

    #[test]
    fn a_steady_error_and_shared_motion_cost_nothing_but_motion_of_one_clip_does() {
        // Sixteenths are exact in binary.
        let moving = clip(8, |frame, x| ((3 * frame + x) % 8) as f32 / 16.0);
        let brighter = clip(8, |frame, x| ((3 * frame + x) % 8) as f32 / 16.0 + 0.25);
        assert_eq!(tpsnr_db(&moving, &brighter), Some(f64::INFINITY));
        assert!(psnr_db(&moving[0], &brighter[0]).unwrap() < 13.0, "the pictures are the same");
        let still = clip(8, |_, _| 0.25);
        assert!(tpsnr_db(&still, &moving).unwrap() < 20.0, "motion that only one clip has is not seen");
    }

    #[test]
    fn a_slow_drift_costs_less_than_a_blink_of_the_same_deviation() {
        let still = clip(16, |_, _| 0.5);
        let drifting = clip(16, |frame, _| 0.25 + frame as f32 / 32.0);
        let blinking = clip(16, |frame, _| if frame % 2 == 0 { 0.35 } else { 0.65 });
        let [slow, fast] = [&drifting, &blinking].map(|clip| flicker(&still, clip).unwrap());
        assert!((slow / fast - 1.0).abs() < 0.1, "{slow}, {fast}");
        let [slow, fast] = [&drifting, &blinking].map(|clip| tpsnr_db(&still, clip).unwrap());
        assert!(slow > fast + 15.0, "{slow}, {fast}");
    }

    #[test]
    fn less_than_two_frames_have_none_and_other_sizes_are_refused() {
        let still = clip(2, |_, _| 0.5);
        assert_eq!(tpsnr_db(&[], &[]), None);
        assert_eq!(tpsnr_db(&still[..1], &still[..1]), None);
        let wide = Image::filled(9, 4, [0.0; 3]).unwrap();
        let mut tpsnr = TemporalPsnr::new();
        tpsnr.add(&still[0], &still[1]).unwrap();
        assert!(matches!(tpsnr.add(&wide, &wide), Err(MetricError::SizesDiffer { .. })));
        assert!(matches!(tpsnr.add(&wide, &still[0]), Err(MetricError::SizesDiffer { .. })));
    }
}
