//! Separable convolution of images with several channels.

use rayon::prelude::*;
use sheer_image::Image;

/// What a filter does where it reaches over the border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Border {
    /// Leaves those taps out and scales the others up; for kernels whose sum is not 0.
    Cut,
    /// Repeats the outermost pixels.
    Repeat,
}

/// A Gaussian of standard deviation `sigma_px`, cut at 3.5 standard deviations and normalised; at the border,
/// what lies outside is left out. A `sigma_px` of 0 or less returns the image unchanged.
#[must_use]
pub fn gaussian_blur<const N: usize>(image: &Image<[f32; N]>, sigma_px: f32) -> Image<[f32; N]> {
    if sigma_px <= 0.0 {
        return image.clone();
    }
    // Rounded as scikit-image does, so that a sigma of 1.5 gives the 11 taps of WBSS04.
    let kernel = gaussian_kernel(sigma_px, (3.5 * sigma_px + 0.5) as usize);
    convolve(image, &kernel, &kernel, Border::Cut)
}

/// The `2 * radius + 1` taps of a Gaussian, which add up to 1.
pub(crate) fn gaussian_kernel(sigma_px: f32, radius: usize) -> Vec<f32> {
    let tap = |x: f64| (-0.5 * (x / f64::from(sigma_px)).powi(2)).exp();
    let taps: Vec<f64> = (0..=2 * radius).map(|i| tap(i as f64 - radius as f64)).collect();
    let sum: f64 = taps.iter().sum();
    taps.iter().map(|tap| (tap / sum) as f32).collect()
}

/// Correlates each channel with `along_x` in rows, then `along_y` in columns. Both have an odd number of
/// taps.
pub(crate) fn convolve<const N: usize>(
    image: &Image<[f32; N]>,
    along_x: &[f32],
    along_y: &[f32],
    border: Border,
) -> Image<[f32; N]> {
    let rows = convolve_rows(image, along_x, border);
    convolve_columns(&rows, along_y, border)
}

fn convolve_rows<const N: usize>(image: &Image<[f32; N]>, taps: &[f32], border: Border) -> Image<[f32; N]> {
    let radius = taps.len() / 2;
    let width = image.width() as usize;
    let scales: Vec<f32> = (0..width).map(|x| scale_at(x, width, taps, border)).collect();
    let mut result = image.clone();
    result.par_rows_mut().zip(image.par_rows()).for_each_init(
        || vec![[0.0; N]; width + 2 * radius],
        |padded, (target, source)| {
            padded[radius..radius + width].copy_from_slice(source);
            if border == Border::Repeat {
                padded[..radius].fill(source[0]);
                padded[radius + width..].fill(source[width - 1]);
            }
            // Channels lie side by side: one tap is one pass over plain numbers, which vectorises.
            target.fill([0.0; N]);
            for (offset, &tap) in taps.iter().enumerate() {
                add_scaled(target.as_flattened_mut(), padded[offset..offset + width].as_flattened(), tap);
            }
            for (pixel, scale) in target.iter_mut().zip(&scales) {
                pixel.iter_mut().for_each(|value| *value *= scale);
            }
        },
    );
    result
}

fn convolve_columns<const N: usize>(
    image: &Image<[f32; N]>,
    taps: &[f32],
    border: Border,
) -> Image<[f32; N]> {
    let radius = taps.len() as i64 / 2;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let source = image.as_slice();
    let mut result = image.clone();
    result.par_rows_mut().enumerate().for_each(|(y, target)| {
        target.fill([0.0; N]);
        for (offset, &tap) in taps.iter().enumerate() {
            let row = y as i64 + offset as i64 - radius;
            let inside = row.clamp(0, height as i64 - 1);
            if row == inside || border == Border::Repeat {
                let start = inside as usize * width;
                add_scaled(target.as_flattened_mut(), source[start..start + width].as_flattened(), tap);
            }
        }
        let scale = scale_at(y, height, taps, border);
        target.as_flattened_mut().iter_mut().for_each(|value| *value *= scale);
    });
    result
}

fn add_scaled(target: &mut [f32], source: &[f32], factor: f32) {
    target.iter_mut().zip(source).for_each(|(target, source)| *target += factor * source);
}

/// What makes up for the taps that are cut off at index `at` of `size`.
fn scale_at(at: usize, size: usize, taps: &[f32], border: Border) -> f32 {
    let radius = taps.len() / 2;
    if border == Border::Repeat || (at >= radius && at + radius < size) {
        return 1.0;
    }
    let inside = |offset: &usize| (radius..radius + size).contains(&(at + offset));
    taps.iter().sum::<f32>() / (0..taps.len()).filter(inside).map(|offset| taps[offset]).sum::<f32>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dot_becomes_the_gaussian() {
        let dot = Image::from_fn(31, 31, |x, y| [if (x, y) == (15, 15) { 1.0 } else { 0.0 }, 0.0]).unwrap();
        let blurred = gaussian_blur(&dot, 2.0);
        let expected = |x: f32, y: f32| (-(x * x + y * y) / 8.0).exp() / (std::f32::consts::TAU * 4.0);
        for (x, y) in [(15, 15), (16, 15), (15, 18), (12, 11)] {
            let (found, expected) = (blurred[(x, y)][0], expected(x as f32 - 15.0, y as f32 - 15.0));
            // The cut at 3.5 sigma moves 0.05 % of the weight inwards in each direction.
            assert!((found / expected - 1.0).abs() < 2e-3, "{found} instead of {expected}");
        }
        assert!(blurred.as_slice().iter().all(|pixel| pixel[1] == 0.0), "channels mixed");
    }

    #[test]
    fn constants_stay_constant_up_to_the_border_even_if_the_filter_is_wider_than_the_image() {
        for (width, height) in [(1, 1), (3, 20), (40, 2)] {
            let flat = Image::filled(width, height, [0.7, 5.0, -1.0]).unwrap();
            let kernel = gaussian_kernel(3.0, 10);
            for border in [Border::Cut, Border::Repeat] {
                let result = convolve(&flat, &kernel, &kernel, border);
                assert!(
                    result.as_slice().iter().all(|pixel| (pixel[0] - 0.7).abs() < 1e-5),
                    "{width}x{height} {border:?}"
                );
            }
        }
        let image = Image::filled(2, 2, [3.0]).unwrap();
        assert_eq!(gaussian_blur(&image, 0.0), image);
    }

    #[test]
    fn taps_run_from_left_to_right_and_top_to_bottom() {
        let image = Image::from_fn(4, 3, |x, y| [(10 * y + x) as f32]).unwrap();
        let one = [0.0, 1.0, 0.0];
        let next = [0.0, 0.0, 1.0];
        assert_eq!(convolve(&image, &next, &one, Border::Repeat)[(1, 1)], [12.0]);
        assert_eq!(convolve(&image, &one, &next, Border::Repeat)[(1, 1)], [21.0]);
        assert_eq!(convolve(&image, &next, &next, Border::Repeat)[(3, 2)], [23.0]);
    }
}
