//! The cross-bilateral filter of ST section 6: noise goes, edges of all visible layers stay, as total alpha
//! has them.

use glam::Vec3;
use rayon::prelude::*;
use sheer_core::colour::Premul;
use sheer_image::Image;

use crate::contract::LayerFilter;

/// Filters the light of all fragments, `layer`, inside pixels of which it is a part already.
///
/// The straight colour is filtered, by the share of alpha that each pixel brings, and takes the pixel's own
/// alpha again: total alpha has no noise, and where all layers have one colour nothing changes. The paper
/// names no weights: this is our reading.
pub(super) fn apply(filter: &LayerFilter, layer: &Image<Premul>, pixels: &mut Image<[f32; 4]>) {
    let width = layer.width();
    pixels.par_rows_mut().zip(0..layer.height()).for_each(|(row, y)| {
        for (pixel, x) in row.iter_mut().zip(0..width) {
            let own = layer[(x, y)];
            if own.alpha > 0.0 {
                let change = filtered(filter, layer, [x, y]) - own.rgb;
                *pixel = Premul { rgb: Premul::from_array(*pixel).rgb + change, alpha: pixel[3] }.to_array();
            }
        }
    });
}

/// The light of a pixel's fragments, blurred over its neighbourhood.
fn filtered(filter: &LayerFilter, layer: &Image<Premul>, [x, y]: [u32; 2]) -> Vec3 {
    let own = layer[(x, y)];
    let reach = |centre: u32, end: u32| {
        centre.saturating_sub(filter.radius_px)..=(centre + filter.radius_px).min(end - 1)
    };
    let gaussian = |difference: f32, sigma: f32| (-0.5 * (difference / sigma).powi(2)).exp();
    let (mut rgb, mut alpha) = (Vec3::ZERO, 0.0);
    for row in reach(y, layer.height()) {
        for column in reach(x, layer.width()) {
            let other = layer[(column, row)];
            let weight = gaussian(column as f32 - x as f32, filter.sigma_px)
                * gaussian(row as f32 - y as f32, filter.sigma_px)
                * gaussian(other.alpha - own.alpha, filter.sigma_alpha);
            rgb += weight * other.rgb;
            alpha += weight * other.alpha;
        }
    }
    own.alpha / alpha * rgb
}

#[cfg(test)]
mod tests {
    use sheer_core::hash::Pcg32;

    use super::*;

    const FILTER: LayerFilter = LayerFilter { radius_px: 2, sigma_px: 1.0, sigma_alpha: 0.05 };

    /// Over a background of 0.5, the filtered picture of a layer.
    fn picture(layer: &Image<Premul>) -> Image<[f32; 4]> {
        let mut pixels =
            layer.map(|light| light.over(Premul { rgb: Vec3::splat(0.5), alpha: 1.0 }).to_array());
        apply(&FILTER, layer, &mut pixels);
        pixels
    }

    #[test]
    fn noise_goes_and_an_edge_of_total_alpha_stays() {
        let mut random = Pcg32::new(1, 0);
        let mut alpha_of = |x: u32| {
            let alpha = if x < 16 { 0.3 } else { 0.8 };
            Premul { rgb: Vec3::splat(alpha * random.range(0.0, 2.0 * alpha)), alpha }
        };
        let layer = Image::from_fn(32, 32, |x, _| alpha_of(x)).unwrap();
        let pixels = picture(&layer);
        // Brightness α on either side, on average: light α² over (1 - α) / 2.
        for (side, alpha) in [(0..16_u32, 0.3_f32), (16..32, 0.8)] {
            let expected = alpha * alpha + (1.0 - alpha) * 0.5;
            let error = |value: &dyn Fn(u32, u32) -> f32| {
                let places = side.clone().flat_map(|x| (0..32).map(move |y| (x, y)));
                places.map(|(x, y)| (value(x, y) - expected).powi(2)).sum::<f32>()
            };
            let before = error(&|x, y| layer[(x, y)].rgb.x + (1.0 - alpha) * 0.5);
            let after = error(&|x, y| pixels[(x, y)][0]);
            // The weights of 5×5 Gaussian neighbours leave 0.08 of the variance inside, twice that at edges
            // and corners.
            assert!(after < 0.2 * before, "{after} of {before}");
            assert!(pixels.as_slice().iter().all(|pixel| pixel[3] == 1.0));
        }
    }

    #[test]
    fn layers_of_one_colour_stay_as_they_are() {
        let layer = Image::from_fn(16, 9, |x, y| {
            let alpha = (x * y % 7) as f32 / 7.0;
            Premul { rgb: Vec3::new(0.2, 0.7, 1.0) * alpha, alpha }
        });
        let layer = layer.unwrap();
        for (pixel, light) in picture(&layer).as_slice().iter().zip(layer.as_slice()) {
            let expected = light.rgb + Vec3::splat(0.5 * (1.0 - light.alpha));
            assert!((Premul::from_array(*pixel).rgb - expected).abs().max_element() < 1e-6);
        }
    }
}
