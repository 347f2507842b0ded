//! Pictures of errors for reports.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};
use sheer_core::colour::srgb_from_linear;
use sheer_image::{Image, u8_from_unit};

use crate::MetricError;
use crate::error::check_sizes;

/// The colour of a number in [0, 1] as sRGB: almost black over blue, violet, red and orange to pale yellow.
/// Numbers outside count as 0 or 1, NaN as 1.
///
/// Lightness rises evenly and neighbours are about equally far apart in OKLab (Ottosson 2020), so that equal
/// steps look equal and the order survives in grey and for colour-blind eyes.
#[must_use]
pub fn false_colour(value: f32) -> [u8; 3] {
    // Below the darkest lightness, 8 bits hold no more steps. The hue runs from blue (285°) over red to
    // yellow (455° = 95°), which are the hues whose strongest colours are dark, middling and light. More
    // chroma would leave the sRGB gamut.
    const DARKEST: f32 = 0.1;
    const LIGHTEST: f32 = 0.98;
    const MOST_CHROMA: f32 = 0.17;
    const FIRST_HUE_DEGREES: f32 = 285.0;
    const LAST_HUE_DEGREES: f32 = 455.0;

    let t = if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) };
    let lightness = DARKEST + (LIGHTEST - DARKEST) * t;
    let chroma = MOST_CHROMA * (PI * t).sin();
    let (sin, cos) = (FIRST_HUE_DEGREES + (LAST_HUE_DEGREES - FIRST_HUE_DEGREES) * t).to_radians().sin_cos();
    let linear = linear_from_oklab(Vec3::new(lightness, chroma * cos, chroma * sin));
    linear.clamp(Vec3::ZERO, Vec3::ONE).map(srgb_from_linear).to_array().map(u8_from_unit)
}

/// OKLab to linear Rec. 709 light, with the matrices of Ottosson, *A perceptual color space for image
/// processing*, 2020.
fn linear_from_oklab(lab: Vec3) -> Vec3 {
    let cone_root_from_lab = Mat3::from_cols(
        Vec3::ONE,
        Vec3::new(0.396_337_78, -0.105_561_346, -0.089_484_18),
        Vec3::new(0.215_803_76, -0.063_854_17, -1.291_485_5),
    );
    let linear_from_cone = Mat3::from_cols(
        Vec3::new(4.076_741_7, -1.268_438, -0.004_196_086),
        Vec3::new(-3.307_711_6, 2.609_757_4, -0.703_418_6),
        Vec3::new(0.230_969_94, -0.341_319_38, 1.707_614_7),
    );
    linear_from_cone * (cone_root_from_lab * lab).powf(3.0)
}

/// The difference of displayed images (sRGB in [0, 1]) in false colour, opaque: root mean square over the
/// channels, with `full_scale` and above in the last colour. [`error_legend`] explains the colours.
///
/// # Errors
/// [`MetricError::SizesDiffer`].
pub fn error_map(
    reference: &Image<[f32; 3]>,
    image: &Image<[f32; 3]>,
    full_scale: f32,
) -> Result<Image<[u8; 4]>, MetricError> {
    check_sizes(reference, image)?;
    Ok(Image::par_from_fn(reference.width(), reference.height(), |x, y| {
        let difference = Vec3::from_array(image[(x, y)]) - Vec3::from_array(reference[(x, y)]);
        opaque((difference.length_squared() / 3.0).sqrt() / full_scale)
    })?)
}

/// The colours of [`error_map`] from no error at the left to full scale at the right.
///
/// # Errors
/// [`MetricError::Image`] for a size of zero or beyond memory.
pub fn error_legend(width: u32, height: u32) -> Result<Image<[u8; 4]>, MetricError> {
    let last = width.saturating_sub(1).max(1) as f32;
    Ok(Image::from_fn(width, height, |x, _| opaque(x as f32 / last))?)
}

fn opaque(value: f32) -> [u8; 4] {
    let [r, g, b] = false_colour(value);
    [r, g, b, 255]
}

#[cfg(test)]
mod tests {
    use sheer_core::colour::{linear_from_srgb, luminance};
    use sheer_image::unit_from_u8;

    use super::*;

    #[test]
    fn more_error_is_always_brighter() {
        let brightness: Vec<f32> = (0_u8..=64)
            .map(|step| {
                luminance(
                    false_colour(f32::from(step) / 64.0).map(|v| linear_from_srgb(unit_from_u8(v))).into(),
                )
            })
            .collect();
        assert!(brightness.is_sorted_by(|a, b| a < b), "{brightness:?}");
        assert!(brightness[0] < 0.002 && brightness[64] > 0.85);
    }

    #[test]
    fn numbers_out_of_range_take_the_ends_and_nan_stands_out() {
        assert_eq!(false_colour(-1.0), false_colour(0.0));
        assert_eq!(false_colour(7.0), false_colour(1.0));
        assert_eq!(false_colour(f32::NAN), false_colour(1.0));
    }

    #[test]
    fn the_matrices_take_white_to_white() {
        assert!((linear_from_oklab(Vec3::X) - Vec3::ONE).abs().max_element() < 1e-5);
    }

    #[test]
    fn the_map_agrees_with_the_legend() {
        let reference = Image::filled(3, 1, [0.25; 3]).unwrap();
        let image = Image::from_vec(3, 1, vec![[0.25; 3], [0.5; 3], [0.75; 3]]).unwrap();
        let map = error_map(&reference, &image, 0.5).unwrap();
        let legend = error_legend(101, 2).unwrap();
        assert_eq!(map.as_slice(), [legend[(0, 0)], legend[(50, 1)], legend[(100, 0)]]);
        assert!(error_legend(0, 5).is_err());
        assert_eq!(error_legend(1, 1).unwrap()[(0, 0)], legend[(0, 0)]);
    }
}
