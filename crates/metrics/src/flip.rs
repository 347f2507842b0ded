//! FLIP: the difference a person sees who flips between two images. Andersson, Nilsson, Akenine-Möller,
//! Oskarsson, Åström and Fairchild, *FLIP: A Difference Evaluator for Alternating Images*, HPG 2020. All
//! sections and symbols are that paper's.

use std::f32::consts::{PI, SQRT_2};

use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;
use sheer_core::colour::linear_from_srgb;
use sheer_image::Image;

use crate::MetricError;
use crate::convolve::{Border, convolve};
use crate::error::check_sizes;

/// Pixels in a degree of the field of view, for a 4K display 0.7 m wide seen from 0.7 m: the paper's default.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

/// A channel of the reference and of the image, side by side.
type Pair = [f32; 2];

/// Mean FLIP error of displayed images (sRGB in [0, 1]), from 0 (equal) to 1, at
/// [`DEFAULT_PIXELS_PER_DEGREE`].
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn flip(reference: &Image<[f32; 3]>, image: &Image<[f32; 3]>) -> Result<f64, MetricError> {
    let map = flip_map(reference, image, DEFAULT_PIXELS_PER_DEGREE)?;
    let row_sums: Vec<f64> = map.par_rows().map(|row| row.iter().copied().map(f64::from).sum()).collect();
    Ok(row_sums.iter().sum::<f64>() / map.as_slice().len() as f64)
}

/// FLIP error of each pixel of displayed images (sRGB in [0, 1]), from 0 to 1. `pixels_per_degree` is the
/// viewing distance: more pixels in a degree hide more.
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn flip_map(
    reference: &Image<[f32; 3]>,
    image: &Image<[f32; 3]>,
    pixels_per_degree: f32,
) -> Result<Image<f32>, MetricError> {
    check_sizes(reference, image)?;
    let opponent = |image: &Image<[f32; 3]>| {
        image.par_map(|&rgb_srgb| {
            ycxcz_from_linear(Vec3::from_array(rgb_srgb.map(|v| linear_from_srgb(v.clamp(0.0, 1.0)))))
        })
    };
    let (reference, image) = (opponent(reference), opponent(image));
    let channel = |index: usize| {
        Image::par_from_fn(reference.width(), reference.height(), |x, y| {
            [reference[(x, y)][index], image[(x, y)][index]]
        })
    };
    let luminance = channel(0)?;

    // Section 4.1: filter what the eye cannot resolve, then measure the difference of colours.
    let filtered = [
        see(&luminance, &ACHROMATIC, pixels_per_degree),
        see(&channel(1)?, &RED_GREEN, pixels_per_degree),
        see(&channel(2)?, &BLUE_YELLOW, pixels_per_degree),
    ];
    // Section 4.2: edges and points that only one image has.
    let features = feature_differences(&luminance, pixels_per_degree);

    // Section 4.3, Eq. 6.
    let largest = largest_colour_difference();
    Ok(Image::par_from_fn(luminance.width(), luminance.height(), |x, y| {
        let colour =
            |side: usize| Vec3::from_array([0, 1, 2].map(|channel: usize| filtered[channel][(x, y)][side]));
        let perceived =
            |side: usize| hunt_lab_from_linear(linear_from_ycxcz(colour(side)).clamp(Vec3::ZERO, Vec3::ONE));
        colour_difference(perceived(0), perceived(1), largest).powf(1.0 - features[(x, y)])
    })?)
}

/// A contrast sensitivity function as a sum of Gaussians, each with height `a` and width `b` (Table 1).
type Sensitivity = [(f32, f32)];
const ACHROMATIC: [(f32, f32); 1] = [(1.0, 0.0047)];
const RED_GREEN: [(f32, f32); 1] = [(1.0, 0.0053)];
const BLUE_YELLOW: [(f32, f32); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// Filters a channel with its contrast sensitivity (section 4.1.1). The sum of Gaussians is not separable,
/// each Gaussian is.
fn see(channel: &Image<Pair>, sensitivity: &Sensitivity, pixels_per_degree: f32) -> Image<Pair> {
    // Three standard deviations of the widest Gaussian of all channels.
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
    let gaussians: Vec<(f32, Vec<f32>)> = sensitivity
        .iter()
        .map(|&(a, b)| {
            let tap = |x: i32| (-(PI * x as f32 / pixels_per_degree).powi(2) / b).exp();
            let taps: Vec<f32> = (-radius..=radius).map(tap).collect();
            let sum: f32 = taps.iter().sum();
            (a * (PI / b).sqrt() * sum * sum, taps.iter().map(|tap| tap / sum).collect())
        })
        .collect();
    let total: f32 = gaussians.iter().map(|(share, _)| share).sum();
    let mut seen = channel.map(|_| [0.0; 2]);
    for (share, taps) in &gaussians {
        let blurred = convolve(channel, taps, taps, Border::Repeat);
        let (target, source) = (seen.as_mut_slice().as_flattened_mut(), blurred.as_slice().as_flattened());
        target.iter_mut().zip(source).for_each(|(target, source)| *target += share / total * source);
    }
    seen
}

/// Differences of edges and points (section 4.2), from 0 to 1.
fn feature_differences(luminance: &Image<Pair>, pixels_per_degree: f32) -> Image<f32> {
    /// The width of a feature detector in degrees, and the exponent of its answer.
    const WIDTH_DEGREES: f32 = 0.082;
    const FEATURE_EXPONENT: f32 = 0.5;

    let sigma = 0.5 * WIDTH_DEGREES * pixels_per_degree;
    let radius = (3.0 * sigma).ceil() as i32;
    let taps = |weight: &dyn Fn(f32) -> f32| -> Vec<f32> {
        (-radius..=radius).map(|x| x as f32).map(|x| weight(x) * (-0.5 * (x / sigma).powi(2)).exp()).collect()
    };
    let smooth = normalised(taps(&|_| 1.0));
    let edge = normalised(taps(&|x| -x));
    let point = normalised(taps(&|x| (x / sigma).powi(2) - 1.0));

    let grey = luminance.par_map(|pair| pair.map(|y| (y + 16.0) / 116.0));
    let strengths = |detector: &[f32]| {
        let along_x = convolve(&grey, detector, &smooth, Border::Repeat);
        let along_y = convolve(&grey, &smooth, detector, Border::Repeat);
        let pairs = along_x.as_slice().iter().zip(along_y.as_slice());
        pairs.map(|(x, y)| (x[1].hypot(y[1]) - x[0].hypot(y[0])).abs()).collect::<Vec<f32>>()
    };
    let (edges, points) = (strengths(&edge), strengths(&point));
    let mut stronger = edges.into_iter().zip(points).map(|(edge, point)| edge.max(point));
    // Equations 4 and 5; both images have the same pixels, so that the list never runs out.
    grey.map(|_| (stronger.next().unwrap_or(0.0) / SQRT_2).powf(FEATURE_EXPONENT))
}

/// Scales positive taps to a sum of 1 and negative ones to -1, each on its own.
fn normalised(taps: Vec<f32>) -> Vec<f32> {
    let sum = |sign: f32| taps.iter().map(|tap| (sign * tap).max(0.0)).sum::<f32>();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    taps.iter()
        .map(|&tap| if tap > 0.0 { tap / positive } else { tap / negative.max(f32::MIN_POSITIVE) })
        .collect()
}

/// The difference of two Hunt-adjusted colours, compressed to [0, 1] (section 4.1.3).
fn colour_difference(a: Vec3, b: Vec3, largest: f32) -> f32 {
    // Differences up to 40 % of the largest are spread over 95 % of the range.
    const SMALL_SHARE: f32 = 0.4;
    const SMALL_RANGE: f32 = 0.95;
    let difference = compressed_hyab(a, b);
    let knee = SMALL_SHARE * largest;
    if difference < knee {
        SMALL_RANGE / knee * difference
    } else {
        SMALL_RANGE + (difference - knee) / (largest - knee) * (1.0 - SMALL_RANGE)
    }
}

/// The HyAB distance, lightness apart from hue, to the power of 0.7 (section 4.1.3).
fn compressed_hyab(a: Vec3, b: Vec3) -> f32 {
    let difference = a - b;
    (difference.x.abs() + Vec2::new(difference.y, difference.z).length()).powf(0.7)
}

/// Between green and blue lies the largest difference inside sRGB (section 4.1.3).
fn largest_colour_difference() -> f32 {
    compressed_hyab(hunt_lab_from_linear(Vec3::Y), hunt_lab_from_linear(Vec3::Z))
}

/// Linear Rec. 709 light to CIE XYZ, from the primaries and white (0.3127, 0.3290) of BT.709.
const XYZ_FROM_LINEAR: Mat3 = Mat3::from_cols(
    Vec3::new(0.412_386_56, 0.212_636_82, 0.019_330_62),
    Vec3::new(0.357_591_5, 0.715_183, 0.119_197_17),
    Vec3::new(0.180_450_5, 0.072_180_2, 0.950_372_6),
);

/// XYZ relative to white.
fn relative_xyz_from_linear(rgb: Vec3) -> Vec3 {
    XYZ_FROM_LINEAR * rgb / (XYZ_FROM_LINEAR * Vec3::ONE)
}

/// The linear opponent space YCxCz (section 4.1.1).
fn ycxcz_from_linear(rgb: Vec3) -> [f32; 3] {
    let Vec3 { x, y, z } = relative_xyz_from_linear(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn linear_from_ycxcz(ycxcz: Vec3) -> Vec3 {
    let y = (ycxcz.x + 16.0) / 116.0;
    let relative = Vec3::new(y + ycxcz.y / 500.0, y, y - ycxcz.z / 200.0);
    XYZ_FROM_LINEAR.inverse() * (relative * (XYZ_FROM_LINEAR * Vec3::ONE))
}

/// CIELAB (CIE 15:2018) with the Hunt effect: dark colours have less chroma (section 4.1.2).
fn hunt_lab_from_linear(rgb: Vec3) -> Vec3 {
    const DELTA: f32 = 6.0 / 29.0;
    let f = relative_xyz_from_linear(rgb)
        .map(|t| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    let lightness = 116.0 * f.y - 16.0;
    let hunt = 0.01 * lightness;
    Vec3::new(lightness, hunt * 500.0 * (f.x - f.y), hunt * 200.0 * (f.y - f.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    type Formula = fn(u32, u32, u32) -> f32;

    fn from_formula(formula: Formula) -> Image<[f32; 3]> {
        Image::from_fn(48, 40, |x, y| [0, 1, 2].map(|c| formula(x, y, c))).unwrap()
    }

    fn busy(x: u32, y: u32, c: u32) -> f32 {
        ((37 * x + 61 * y + 29 * c + 3 * x * y) % 256) as f32 / 255.0
    }

    fn smooth(x: u32, y: u32, c: u32) -> f32 {
        (x + 2 * y + 20 * c) as f32 / 255.0
    }

    fn noise(x: u32, y: u32, c: u32) -> f32 {
        ((91 * x + 53 * y + 17 * c + 7 * x * y) % 64) as f32 / 64.0
    }

    fn checks(x: u32, y: u32, _: u32) -> f32 {
        if (x / 3 + y / 5).is_multiple_of(2) { 0.9 } else { 0.1 }
    }

    // The reference numbers come from the authors' Python package, flip-evaluator 1.7, with numpy's y, x, c =
    // mgrid[0:40, 0:48, 0:3] in the formulas below: map, mean, _ = evaluate(a, b, "LDR", applyMagma=False);
    // then mean, map[10, 10] and map[20, 30].
    #[test]
    fn agrees_with_the_authors_implementation() {
        let cases: [(&str, Formula, Formula, [f64; 3]); 9] = [
            (
                "noise on a busy image",
                busy,
                |x, y, c| 0.75 * busy(x, y, c) + 0.25 * noise(x, y, c),
                [0.231_040, 0.192_380, 0.245_686],
            ),
            (
                "noise on a smooth image",
                smooth,
                |x, y, c| 0.9 * smooth(x, y, c) + 0.1 * noise(x, y, c),
                [0.123_201, 0.157_487, 0.095_600],
            ),
            ("offset", smooth, |x, y, c| smooth(x, y, c) + 0.1, [0.360_165, 0.374_695, 0.357_220]),
            ("negative", busy, |x, y, c| 1.0 - busy(x, y, c), [0.370_848, 0.329_653, 0.390_490]),
            (
                "half of it noise",
                smooth,
                |x, y, c| if x < 24 { smooth(x, y, c) } else { noise(x, y, c) },
                [0.362_984, 0.0, 0.633_841],
            ),
            (
                "weaker edges",
                checks,
                |x, y, c| 0.5 * checks(x, y, c) + 0.25,
                [0.344_128, 0.270_976, 0.358_705],
            ),
            ("edges gone", checks, |_, _, _| 0.5, [0.471_872, 0.264_574, 0.491_192]),
            (
                "green and blue",
                |_, _, c| if c == 1 { 1.0 } else { 0.0 },
                |_, _, c| if c == 2 { 1.0 } else { 0.0 },
                [1.0; 3],
            ),
            ("black and white", |_, _, _| 0.0, |_, _, _| 1.0, [0.967_401, 0.967_388, 0.967_388]),
        ];
        for (name, reference, image, expected) in cases {
            let (reference, image) = (from_formula(reference), from_formula(image));
            let map = flip_map(&reference, &image, DEFAULT_PIXELS_PER_DEGREE).unwrap();
            let found =
                [flip(&reference, &image).unwrap(), f64::from(map[(10, 10)]), f64::from(map[(30, 20)])];
            let worst = found
                .iter()
                .zip(expected)
                .map(|(found, expected)| (found - expected).abs())
                .fold(0.0, f64::max);
            // Both sides compute in 32 bits; the square roots of small feature differences amplify that.
            assert!(worst < 5e-4, "{name}: {found:?} instead of {expected:?}");
        }
    }

    #[test]
    fn equal_images_do_not_differ_and_distance_hides_noise() {
        let (reference, image) =
            (from_formula(smooth), from_formula(|x, y, c| 0.9 * smooth(x, y, c) + 0.1 * noise(x, y, c)));
        assert_eq!(flip(&reference, &reference).unwrap(), 0.0);
        let mean = |pixels_per_degree| {
            let map = flip_map(&reference, &image, pixels_per_degree).unwrap();
            map.as_slice().iter().sum::<f32>() / map.as_slice().len() as f32
        };
        assert!(mean(120.0) < mean(60.0) && mean(60.0) < mean(30.0));
    }

    #[test]
    fn numbers_outside_the_display_range_and_tiny_images_stay_in_range() {
        let reference = Image::filled(1, 1, [-1.0, 0.5, 7.0]).unwrap();
        let image = Image::filled(1, 1, [2.0, 0.5, 0.0]).unwrap();
        assert!((0.0..=1.0).contains(&flip(&reference, &image).unwrap()));
    }
}
