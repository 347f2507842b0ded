//! Structural similarity: Wang, Bovik, Sheikh and Simoncelli, *Image Quality Assessment: From Error
//! Visibility to Structural Similarity*, 2004 (WBSS04).

use rayon::prelude::*;
use sheer_image::Image;

use crate::MetricError;
use crate::convolve::gaussian_blur;
use crate::error::check_sizes;

/// The window of WBSS04 section III.B, a Gaussian of 11×11 taps.
const SIGMA_PX: f32 = 1.5;
const RADIUS_PX: usize = 5;

/// (K L)² of WBSS04 section III.B, for images in [0, 1].
const C1: f32 = 0.01 * 0.01;
const C2: f32 = 0.03 * 0.03;

/// Mean structural similarity of displayed images (sRGB in [0, 1]), from -1 to 1 (equal): the mean over
/// channels and over the pixels whose window lies inside the image, or over all in a direction that has less
/// than 11 pixels.
///
/// Agrees with scikit-image's `structural_similarity(gaussian_weights=True, sigma=1.5,
/// use_sample_covariance=False, data_range=1, channel_axis=2)`.
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn ssim(reference: &Image<[f32; 3]>, image: &Image<[f32; 3]>) -> Result<f64, MetricError> {
    let map = ssim_map(reference, image)?;
    let whole_windows = |size: u32| {
        let size = size as usize;
        if size > 2 * RADIUS_PX { RADIUS_PX..size - RADIUS_PX } else { 0..size }
    };
    let (columns, rows) = (whole_windows(map.width()), whole_windows(map.height()));
    let row_sums: Vec<f64> = map
        .par_rows()
        .map(|row| row[columns.clone()].as_flattened().iter().copied().map(f64::from).sum())
        .collect();
    let count = 3 * columns.len() * rows.len();
    Ok(row_sums[rows].iter().sum::<f64>() / count as f64)
}

/// Structural similarity around each pixel of displayed images (sRGB in [0, 1]) by channel, from -1 to 1
/// (equal). At the border the part of the window inside the image counts.
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn ssim_map(
    reference: &Image<[f32; 3]>,
    image: &Image<[f32; 3]>,
) -> Result<Image<[f32; 3]>, MetricError> {
    check_sizes(reference, image)?;

    // What the window averages: x, y, x², y² and xy of each channel.
    let products = Image::par_from_fn(reference.width(), reference.height(), |column, row| {
        let (x, y) = (reference[(column, row)], image[(column, row)]);
        let mut products = [0.0; 15];
        for channel in 0..3 {
            let (x, y) = (x[channel], y[channel]);
            products[5 * channel..][..5].copy_from_slice(&[x, y, x * x, y * y, x * y]);
        }
        products
    })?;
    let averages = gaussian_blur(&products, SIGMA_PX);

    Ok(averages.par_map(|averages| {
        std::array::from_fn(|channel| {
            let [x, y, xx, yy, xy] = std::array::from_fn(|product| averages[5 * channel + product]);
            let (variance_x, variance_y, covariance) = (xx - x * x, yy - y * y, xy - x * y);
            // WBSS04 Eq. 13.
            (2.0 * x * y + C1) * (2.0 * covariance + C2)
                / ((x * x + y * y + C1) * (variance_x + variance_y + C2))
        })
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::psnr_db;

    // The reference numbers come from scikit-image 0.26 with numpy's y, x, c = mgrid[0:21, 0:33, 0:3] in the
    // formulas below: structural_similarity(a, b, gaussian_weights=True, sigma=1.5,
    // use_sample_covariance=False, data_range=1, channel_axis=2) peak_signal_noise_ratio(a, b, data_range=1)
    fn from_formula(formula: impl Fn(u32, u32, u32) -> f32) -> Image<[f32; 3]> {
        Image::from_fn(33, 21, |x, y| [0, 1, 2].map(|c| formula(x, y, c))).unwrap()
    }

    fn busy(x: u32, y: u32, c: u32) -> f32 {
        ((37 * x + 61 * y + 29 * c + 3 * x * y) % 256) as f32 / 255.0
    }

    fn smooth(x: u32, y: u32, c: u32) -> f32 {
        (4 * x + 5 * y + 10 * c) as f32 / 255.0
    }

    fn noise(x: u32, y: u32, c: u32) -> f32 {
        ((91 * x + 53 * y + 17 * c + 7 * x * y) % 64) as f32 / 64.0
    }

    #[test]
    fn agrees_with_scikit_image() {
        type Formula = fn(u32, u32, u32) -> f32;
        let cases: [(&str, Formula, Formula, f64, f64); 4] = [
            (
                "noise on a busy image",
                busy,
                |x, y, c| 0.75 * busy(x, y, c) + 0.25 * noise(x, y, c),
                0.918_887_104,
                19.682_429,
            ),
            (
                "noise on a smooth image",
                smooth,
                |x, y, c| 0.9 * smooth(x, y, c) + 0.1 * noise(x, y, c),
                0.805_945_425,
                29.160_166,
            ),
            ("offset", smooth, |x, y, c| smooth(x, y, c) + 0.1, 0.979_249_755, 20.0),
            ("negative", busy, |x, y, c| 1.0 - busy(x, y, c), -0.983_344_461, 4.744_803),
        ];
        for (name, reference, image, expected_ssim, expected_psnr_db) in cases {
            let (reference, image) = (from_formula(reference), from_formula(image));
            let found = ssim(&reference, &image).unwrap();
            assert!((found - expected_ssim).abs() < 1e-4, "{name}: {found} instead of {expected_ssim}");
            let found = psnr_db(&reference, &image).unwrap();
            assert!((found - expected_psnr_db).abs() < 1e-4, "{name}: {found} instead of {expected_psnr_db}");
        }
    }

    #[test]
    fn equal_images_are_exactly_one_and_others_are_not() {
        let image = from_formula(busy);
        assert_eq!(ssim(&image, &image).unwrap(), 1.0);
        assert!(
            ssim_map(&image, &image).unwrap().as_slice().as_flattened().iter().all(|&value| value == 1.0)
        );
        let shifted = from_formula(|x, y, c| busy(x + 1, y, c));
        assert!(ssim(&image, &shifted).unwrap() < 0.5, "a shifted busy image is a different one");
    }

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        let (reference, image) = (from_formula(busy), from_formula(noise));
        let on_threads = |count| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
            pool.install(|| (ssim(&reference, &image).unwrap(), psnr_db(&reference, &image).unwrap()))
        };
        assert_eq!(on_threads(1), on_threads(3));
    }

    #[test]
    fn the_map_shows_where_the_images_differ() {
        let reference = from_formula(smooth);
        let image = from_formula(|x, y, c| if x < 16 { smooth(x, y, c) } else { noise(x, y, c) });
        let map = ssim_map(&reference, &image).unwrap();
        assert_eq!(map[(3, 10)], [1.0; 3]);
        assert!(map[(28, 10)].iter().all(|&value| value < 0.5), "{:?}", map[(28, 10)]);
    }

    #[test]
    fn images_smaller_than_the_window_have_a_similarity_too() {
        for (width, height) in [(1, 1), (8, 8), (64, 3)] {
            let reference = Image::from_fn(width, height, |x, y| [(x + y) as f32 / 70.0; 3]).unwrap();
            let image = reference.map(|&[r, g, b]| [r + 0.2, g, b]);
            assert_eq!(ssim(&reference, &reference).unwrap(), 1.0);
            let found = ssim(&reference, &image).unwrap();
            assert!((0.0..0.999).contains(&found), "{width}x{height}: {found}");
        }
    }
}
