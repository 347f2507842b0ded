//! ColorVideoVDP: what a viewer would object to in a clip.

use colorvideovdp::{Color, Cvvdp, DisplayModel, Options};
use rayon::prelude::*;
use sheer_image::{Image, unit_from_u8};

use crate::MetricError;
use crate::error::check_sizes;

/// The display and its viewer: the authors' default, a 30 inch 4K monitor of 200 cd/m² in an office, at twice
/// its height.
const DISPLAY: &str = "standard_4k";

/// Pictures with a shorter side have no quality.
pub const LEAST_VDP_SIDE_PX: u32 = 4;

/// Quality of a clip as a display shows it (opaque sRGB) against its reference, in just-objectionable
/// differences (Mantiuk et al. 2024): 10 if no difference is seen; at 9 three in four viewers prefer the
/// reference. A clip of one frame is judged as a still picture.
///
/// # Errors
/// [`MetricError::FramesDiffer`] for lists that are empty or differ in length, [`MetricError::SizesDiffer`],
/// [`MetricError::Vdp`] for pictures of less than [`LEAST_VDP_SIDE_PX`] and if memory does not suffice.
pub fn video_vdp_jod(
    references: &[Image<[u8; 3]>],
    images: &[Image<[u8; 3]>],
    frames_per_sec: f32,
) -> Result<f64, MetricError> {
    if references.len() != images.len() || images.is_empty() {
        return Err(MetricError::FramesDiffer { references: references.len(), images: images.len() });
    }
    references.iter().zip(images).try_for_each(|(reference, image)| check_sizes(reference, image))?;
    // How much memory there is, the system knows: the size of the picture is the user's choice.
    let options = Options::default().with_memory_limit_bytes(usize::MAX);
    let metric = Cvvdp::new(DisplayModel::from_name(DISPLAY)?, options)?;
    let [references, images] = [convert(references)?, convert(images)?];
    let prediction = match (&references[..], &images[..]) {
        ([reference], [image]) => metric.predict_image(image, reference, Color::Srgb)?,
        _ => metric.predict_video(&images, &references, frames_per_sec, Color::Srgb)?,
    };
    Ok(f64::from(prediction.jod))
}

fn convert(images: &[Image<[u8; 3]>]) -> Result<Vec<colorvideovdp::Image>, MetricError> {
    let convert = |image: &Image<[u8; 3]>| {
        let samples = image.as_slice().as_flattened().iter().map(|&sample| unit_from_u8(sample)).collect();
        Ok(colorvideovdp::Image::new(image.width() as usize, image.height() as usize, 3, samples)?)
    };
    images.par_iter().map(convert).collect()
}

#[cfg(test)]
mod tests {
    use sheer_core::hash::Pcg32;

    use super::*;

    const FRAMES_PER_SEC: f32 = 30.0;

    /// A gradient that moves, with uniform noise of at most `noise` steps to either side in each pixel of
    /// each frame.
    fn clip(frames: u32, noise: f32) -> Vec<Image<[u8; 3]>> {
        let mut random = Pcg32::new(11, 1);
        let frame = |frame: u32| {
            let mut pixel = |x: u32, y: u32| {
                let shift = noise * (2.0 * random.next_f32() - 1.0);
                [0, 20, 40].map(|tint| (60.0 + (2 * x + y + 3 * frame + tint) as f32 + shift) as u8)
            };
            Image::from_fn(32, 24, &mut pixel).unwrap()
        };
        (0..frames).map(frame).collect()
    }

    #[test]
    fn equal_clips_are_ten_and_more_noise_is_less() {
        let clean = clip(6, 0.0);
        let jod = |noise| video_vdp_jod(&clean, &clip(6, noise), FRAMES_PER_SEC).unwrap();
        let jods = [0.0, 4.0, 12.0, 36.0].map(jod);
        assert_eq!(jods[0], 10.0);
        assert!(jods.windows(2).all(|pair| pair[1] < pair[0] - 0.05), "{jods:?}");
    }

    #[test]
    fn a_still_picture_has_a_quality_too() {
        let [clean, noisy] = [clip(1, 0.0), clip(1, 20.0)];
        assert_eq!(video_vdp_jod(&clean, &clean, FRAMES_PER_SEC).unwrap(), 10.0);
        assert!(video_vdp_jod(&clean, &noisy, FRAMES_PER_SEC).unwrap() < 9.5);
    }

    #[test]
    fn a_difference_that_blinks_is_worse_than_one_that_stays() {
        let grey = |level: u8| Image::filled(32, 24, [level; 3]).unwrap();
        let still: Vec<_> = (0..12).map(|_| grey(120)).collect();
        let brighter: Vec<_> = (0..12).map(|_| grey(128)).collect();
        // 7.5 Hz, near the peak of temporal sensitivity.
        let blinking: Vec<_> = (0..12).map(|frame| grey(if frame % 4 < 2 { 128 } else { 112 })).collect();
        let jod = |images: &[_]| video_vdp_jod(&still, images, FRAMES_PER_SEC).unwrap();
        let (steady, restless) = (jod(&brighter), jod(&blinking));
        assert!(restless < steady - 0.1, "{restless}, {steady}");
    }

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        let [clean, noisy] = [clip(4, 0.0), clip(4, 10.0)];
        let on_threads = |count| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
            pool.install(|| video_vdp_jod(&clean, &noisy, FRAMES_PER_SEC).unwrap())
        };
        assert_eq!(on_threads(1).to_bits(), on_threads(3).to_bits());
    }

    #[test]
    fn clips_that_do_not_fit_are_refused() {
        let square = |side| vec![Image::filled(side, side, [0; 3]).unwrap()];
        let (clean, tiny) = (clip(3, 0.0), square(LEAST_VDP_SIDE_PX - 1));
        let refused =
            |references: &[_], images: &[_]| video_vdp_jod(references, images, FRAMES_PER_SEC).unwrap_err();
        assert!(matches!(
            refused(&clean, &clean[..2]),
            MetricError::FramesDiffer { references: 3, images: 2 }
        ));
        assert!(matches!(refused(&[], &[]), MetricError::FramesDiffer { .. }));
        assert!(matches!(refused(&clean[..1], &tiny), MetricError::SizesDiffer { .. }));
        assert!(matches!(refused(&tiny, &tiny), MetricError::Vdp(_)));
        let small = square(LEAST_VDP_SIDE_PX);
        assert_eq!(video_vdp_jod(&small, &small, FRAMES_PER_SEC).unwrap(), 10.0);
    }
}
