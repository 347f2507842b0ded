//! How restless the error of a clip is.

use rayon::prelude::*;
use sheer_image::Image;

use crate::MetricError;
use crate::error::check_sizes;

/// Takes a clip frame by frame and tells its flicker: the standard deviation over time of the error (image
/// minus reference), root mean square over pixels and channels, in the unit of the images.
///
/// A constant error does not flicker, and motion that the reference shares does not count. One frame has no
/// flicker.
#[derive(Clone, Debug, Default)]
pub struct Flicker<const N: usize> {
    frame_count: usize,
    // Mean and sum of squared deviations of the error, after Welford 1962: one pass, and no cancellation.
    moments: Option<Image<[[f64; 2]; N]>>,
}

impl<const N: usize> Flicker<N> {
    /// A clip without frames.
    #[must_use]
    pub fn new() -> Self {
        Self { frame_count: 0, moments: None }
    }

    /// Takes the next frame.
    ///
    /// # Errors
    /// [`MetricError::SizesDiffer`] if the images, or this frame and the first, differ in size.
    pub fn add(&mut self, reference: &Image<[f32; N]>, image: &Image<[f32; N]>) -> Result<(), MetricError> {
        check_sizes(reference, image)?;
        let moments = self.moments.get_or_insert_with(|| reference.map(|_| [[0.0; 2]; N]));
        check_sizes(moments, image)?;
        self.frame_count += 1;
        let weight = 1.0 / self.frame_count as f64;
        moments.par_rows_mut().zip(reference.par_rows()).zip(image.par_rows()).for_each(
            |((moments, references), values)| {
                for ((moments, reference), value) in moments.iter_mut().zip(references).zip(values) {
                    for (channel, [mean, squares]) in moments.iter_mut().enumerate() {
                        let error = f64::from(value[channel]) - f64::from(reference[channel]);
                        let before = error - *mean;
                        *mean += before * weight;
                        *squares += before * (error - *mean);
                    }
                }
            },
        );
        Ok(())
    }

    /// The flicker of the frames so far, 0 for less than two.
    #[must_use]
    pub fn value(&self) -> f64 {
        let Some(moments) = self.moments.as_ref().filter(|_| self.frame_count > 1) else { return 0.0 };
        let row_sums: Vec<f64> = moments
            .par_rows()
            .map(|row| row.as_flattened().iter().map(|&[_, squares]| squares).sum())
            .collect();
        let count = (moments.as_slice().len() * N * (self.frame_count - 1)) as f64;
        (row_sums.iter().sum::<f64>() / count).sqrt()
    }
}

/// The flicker of a whole clip: see [`Flicker`].
///
/// # Errors
/// [`MetricError::FramesDiffer`] for lists that are empty or differ in length, [`MetricError::SizesDiffer`].
pub fn flicker<const N: usize>(
    references: &[Image<[f32; N]>],
    images: &[Image<[f32; N]>],
) -> Result<f64, MetricError> {
    if references.len() != images.len() || images.is_empty() {
        return Err(MetricError::FramesDiffer { references: references.len(), images: images.len() });
    }
    let mut flicker = Flicker::new();
    references.iter().zip(images).try_for_each(|(reference, image)| flicker.add(reference, image))?;
    Ok(flicker.value())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clip(frames: u32, value: impl Fn(u32, u32) -> f32) -> Vec<Image<[f32; 3]>> {
        (0..frames).map(|frame| Image::from_fn(6, 4, |x, _| [value(frame, x); 3]).unwrap()).collect()
    }

    #[test]
    fn an_alternating_error_has_its_standard_deviation() {
        let still = clip(16, |_, _| 0.5);
        let blinking = clip(16, |frame, _| if frame % 2 == 0 { 0.25 } else { 0.75 });
        // Sixteen deviations of 0.25, with one degree of freedom taken by the mean.
        let expected = (16.0_f64 / 15.0).sqrt() * 0.25;
        assert!((flicker(&still, &blinking).unwrap() - expected).abs() < 1e-12);
    }

    #[test]
    fn shared_motion_and_constant_error_do_not_flicker() {
        let moving = clip(8, |frame, x| ((frame * 3 + x) % 8) as f32 / 8.0);
        let brighter = clip(8, |frame, x| ((frame * 3 + x) % 8) as f32 / 8.0 + 0.25);
        assert!(flicker(&moving, &brighter).unwrap() < 1e-12);
        let still = clip(8, |_, _| 0.5);
        assert!(
            flicker(&still, &moving).unwrap() > 0.1,
            "the measure is blind to motion that only one clip has"
        );
    }

    #[test]
    fn short_and_uneven_clips_are_told_apart() {
        let still = clip(3, |_, _| 0.5);
        assert_eq!(flicker(&still[..1], &still[1..2]).unwrap(), 0.0);
        assert!(matches!(
            flicker(&still, &still[..2]),
            Err(MetricError::FramesDiffer { references: 3, images: 2 })
        ));
        assert!(flicker::<3>(&[], &[]).is_err());
        let wide = Image::filled(9, 4, [0.0; 3]).unwrap();
        let mut flicker = Flicker::new();
        flicker.add(&still[0], &still[1]).unwrap();
        assert!(matches!(flicker.add(&wide, &wide), Err(MetricError::SizesDiffer { .. })));
    }
}
