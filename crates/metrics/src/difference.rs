//! Metrics of one pixel at a time.

use rayon::prelude::*;
use sheer_image::Image;

use crate::MetricError;
use crate::error::check_sizes;

/// Root mean square difference, over all pixels and channels, in the unit of the images (0: equal).
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn rms<const N: usize>(reference: &Image<[f32; N]>, image: &Image<[f32; N]>) -> Result<f64, MetricError> {
    Ok(mean_square(reference, image)?.sqrt())
}

/// Root mean square difference of each channel, over all pixels, in the unit of the images.
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn rms_per_channel<const N: usize>(
    reference: &Image<[f32; N]>,
    image: &Image<[f32; N]>,
) -> Result<[f64; N], MetricError> {
    Ok(mean_per_channel(reference, image, |difference| difference * difference)?.map(f64::sqrt))
}

/// Mean of image minus reference, over all pixels and channels: above 0 if the image is too bright. Linear
/// light is where an unbiased method averages to 0.
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn bias<const N: usize>(
    reference: &Image<[f32; N]>,
    image: &Image<[f32; N]>,
) -> Result<f64, MetricError> {
    Ok(bias_per_channel(reference, image)?.iter().sum::<f64>() / N as f64)
}

/// Mean of image minus reference for each channel, over all pixels.
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn bias_per_channel<const N: usize>(
    reference: &Image<[f32; N]>,
    image: &Image<[f32; N]>,
) -> Result<[f64; N], MetricError> {
    mean_per_channel(reference, image, |difference| difference)
}

/// Peak signal-to-noise ratio in decibels of images in [0, 1], over all pixels and channels: 10 log₁₀(1 /
/// mean square difference). Infinite if the images are equal.
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn psnr_db<const N: usize>(
    reference: &Image<[f32; N]>,
    image: &Image<[f32; N]>,
) -> Result<f64, MetricError> {
    Ok(-10.0 * mean_square(reference, image)?.log10())
}

fn mean_square<const N: usize>(
    reference: &Image<[f32; N]>,
    image: &Image<[f32; N]>,
) -> Result<f64, MetricError> {
    let squares = mean_per_channel(reference, image, |difference| difference * difference)?;
    Ok(squares.iter().sum::<f64>() / N as f64)
}

fn mean_per_channel<const N: usize>(
    reference: &Image<[f32; N]>,
    image: &Image<[f32; N]>,
    term: impl Fn(f64) -> f64 + Sync,
) -> Result<[f64; N], MetricError> {
    check_sizes(reference, image)?;
    let row_sums: Vec<[f64; N]> = reference
        .par_rows()
        .zip(image.par_rows())
        .map(|(references, values)| {
            references.iter().zip(values).fold([0.0; N], |sums, (reference, value)| {
                std::array::from_fn(|c| sums[c] + term(f64::from(value[c]) - f64::from(reference[c])))
            })
        })
        .collect();
    let count = reference.as_slice().len() as f64;
    Ok(std::array::from_fn(|c| row_sums.iter().map(|sums| sums[c]).sum::<f64>() / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair() -> (Image<[f32; 3]>, Image<[f32; 3]>) {
        let reference = Image::from_fn(5, 4, |x, y| [0.1 * x as f32, 0.2 * y as f32, 0.5]).unwrap();
        let image = reference.map(|&[r, g, b]| [r + 0.1, g - 0.2, b]);
        (reference, image)
    }

    #[test]
    fn constant_offsets_give_their_closed_form() {
        let (reference, image) = pair();
        let close =
            |found: f64, expected: f64| assert!((found - expected).abs() < 1e-6, "{found}, {expected}");
        close(rms(&reference, &image).unwrap(), (0.05_f64 / 3.0).sqrt());
        let channels = rms_per_channel(&reference, &image).unwrap();
        [0.1, 0.2, 0.0].into_iter().zip(channels).for_each(|(expected, found)| close(found, expected));
        close(bias(&reference, &image).unwrap(), -0.1 / 3.0);
        let channels = bias_per_channel(&reference, &image).unwrap();
        [0.1, -0.2, 0.0].into_iter().zip(channels).for_each(|(expected, found)| close(found, expected));
        close(psnr_db(&reference, &image).unwrap(), -10.0 * (0.05_f64 / 3.0).log10());
    }

    #[test]
    fn equal_images_have_no_error_and_infinite_psnr() {
        let (reference, _) = pair();
        assert_eq!(rms(&reference, &reference).unwrap(), 0.0);
        assert_eq!(bias(&reference, &reference).unwrap(), 0.0);
        assert_eq!(psnr_db(&reference, &reference).unwrap(), f64::INFINITY);
    }

    #[test]
    fn errors_of_opposite_sign_cancel_in_the_bias_but_not_in_the_rms() {
        let reference = Image::filled(8, 8, [0.5]).unwrap();
        let image = Image::from_fn(8, 8, |x, _| [if x % 2 == 0 { 0.25 } else { 0.75 }]).unwrap();
        assert_eq!(bias(&reference, &image).unwrap(), 0.0);
        assert_eq!(rms(&reference, &image).unwrap(), 0.25);
    }

    #[test]
    fn images_of_other_sizes_are_refused() {
        let (reference, _) = pair();
        let other = Image::filled(4, 5, [0.0; 3]).unwrap();
        let message = rms(&reference, &other).unwrap_err().to_string();
        assert!(message.contains("4x5") && message.contains("5x4"), "{message}");
    }
}
