//! The one way from linear light to a display, so that all pictures and all metrics on pictures agree.

use glam::Vec3;
use sheer_core::colour::{Premul, srgb_from_linear};

use crate::Image;

/// How linear light above display white is brought into the range of a display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// The Khronos PBR Neutral tone mapper (specification of 2024): base colours under grey light come out as
    /// they were authored, only what is brighter than 0.8 is compressed and then desaturated. It subtracts
    /// the 4 % that a dielectric reflects head-on, so that such a surface lit by white shows exactly its base
    /// colour.
    #[default]
    Neutral,
    /// No curve: light above display white is cut off.
    None,
}

/// Radiance above which every curve here is display white in 32-bit floats; keeps infinity out of the
/// arithmetic.
const BRIGHTEST: f32 = 1.0e9;

impl ToneCurve {
    /// Linear light, from 0 to infinity, to linear display light in [0, 1]. Negative numbers and NaN count as
    /// 0.
    #[must_use]
    pub fn apply(self, rgb: Vec3) -> Vec3 {
        let rgb = rgb.map(|channel| if channel > 0.0 { channel.min(BRIGHTEST) } else { 0.0 });
        match self {
            Self::Neutral => khronos_pbr_neutral(rgb),
            Self::None => rgb.min(Vec3::ONE),
        }
    }
}

/// Khronos PBR Neutral, with the names and numbers of its specification.
fn khronos_pbr_neutral(rgb: Vec3) -> Vec3 {
    const FRESNEL: f32 = 0.04;
    const COMPRESSION_START: f32 = 0.8 - FRESNEL;
    const DESATURATION: f32 = 0.15;

    let least = rgb.min_element();
    let offset = if least < 2.0 * FRESNEL { least - least * least / (4.0 * FRESNEL) } else { FRESNEL };
    let rgb = rgb - offset;
    let peak = rgb.max_element();
    if peak < COMPRESSION_START {
        return rgb;
    }
    let headroom = 1.0 - COMPRESSION_START;
    let new_peak = 1.0 - headroom * headroom / (peak + headroom - COMPRESSION_START);
    let white_share = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    (rgb * (new_peak / peak)).lerp(Vec3::splat(new_peak), white_share).clamp(Vec3::ZERO, Vec3::ONE)
}

/// One channel in [0, 1] as 8 bits, rounded to nearest. What lies outside is cut off, NaN counts as 0.
#[must_use]
pub fn u8_from_unit(value: f32) -> u8 {
    // The cast saturates and takes NaN to 0.
    (value * 255.0 + 0.5) as u8
}

/// An 8-bit channel as a number in [0, 1].
#[must_use]
pub fn unit_from_u8(value: u8) -> f32 {
    f32::from(value) / 255.0
}

/// Premultiplied linear RGBA to what an 8-bit file with straight alpha holds: sRGB-encoded, alpha linear.
///
/// A pixel of alpha 0 becomes `[0; 4]`: light without coverage has no place in straight alpha.
#[must_use]
pub fn display(colour: &Image<[f32; 4]>, curve: ToneCurve) -> Image<[u8; 4]> {
    colour.par_map(|&rgba_premul| {
        let straight = Premul::from_array(rgba_premul).to_straight();
        let rgb_srgb = curve.apply(straight.rgb).map(srgb_from_linear);
        [
            u8_from_unit(rgb_srgb.x),
            u8_from_unit(rgb_srgb.y),
            u8_from_unit(rgb_srgb.z),
            u8_from_unit(straight.alpha),
        ]
    })
}

/// Premultiplied linear RGBA over a black background, as sRGB in [0, 1]: what metrics on displayed images
/// compare.
#[must_use]
pub fn display_over_black(colour: &Image<[f32; 4]>, curve: ToneCurve) -> Image<[f32; 3]> {
    colour.par_map(|&[r, g, b, _]| curve.apply(Vec3::new(r, g, b)).map(srgb_from_linear).to_array())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_keeps_base_colours_lit_by_white_exact() {
        // The specification's promise: base colour plus the 4 % reflection comes out as the base colour.
        for base in [0.04, 0.18, 0.5, 0.75] {
            let shown = ToneCurve::Neutral.apply(Vec3::splat(base + 0.04));
            assert!((shown - base).abs().max_element() < 1e-6, "{base} became {shown}");
        }
    }

    #[test]
    fn neutral_agrees_with_values_worked_out_from_its_specification() {
        // Python, in double precision, from the formulas of the specification.
        for (light, shown) in REFERENCE {
            let found = ToneCurve::Neutral.apply(Vec3::from_array(light));
            assert!((found - Vec3::from_array(shown)).abs().max_element() < 1e-5, "{light:?} became {found}");
        }
    }

    const REFERENCE: [([f32; 3], [f32; 3]); 4] = [
        ([0.05, 0.02, 0.01], [0.040_625, 0.010_625, 0.000_625]),
        ([1.0, 1.0, 1.0], [0.869_091; 3]),
        ([4.0, 0.5, 0.1], [0.983_256, 0.382_473, 0.313_812]),
        ([0.0, 0.0, 20.0], [0.738_101, 0.738_101, 0.997_043]),
    ];

    #[test]
    fn curves_rise_and_stay_in_range_for_any_number() {
        for curve in [ToneCurve::Neutral, ToneCurve::None] {
            let mut last = -1.0;
            for step in 0..4000 {
                let shown = curve.apply(Vec3::splat(1.004_f32.powi(step) * 1e-3 - 1e-3)).x;
                assert!(shown >= last && (0.0..=1.0).contains(&shown), "{curve:?} at step {step}: {shown}");
                last = shown;
            }
            for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0] {
                let shown = curve.apply(Vec3::new(odd, 0.5, 0.0));
                assert!(
                    shown.cmpge(Vec3::ZERO).all() && shown.cmple(Vec3::ONE).all(),
                    "{odd} became {shown}"
                );
            }
        }
    }

    #[test]
    fn eight_bits_round_to_nearest_and_saturate() {
        assert_eq!([0.0, 1.0, 0.5, 0.499 / 255.0, 0.501 / 255.0].map(u8_from_unit), [0, 255, 128, 0, 1]);
        assert_eq!([-1.0, 2.0, f32::NAN, f32::INFINITY].map(u8_from_unit), [0, 255, 0, 255]);
        assert!((0..=255).all(|v| u8_from_unit(unit_from_u8(v)) == v));
    }

    #[test]
    fn a_half_transparent_pixel_shows_its_own_colour() {
        let colour = Image::filled(1, 1, [0.25, 0.0, 0.0, 0.5]).unwrap();
        // Straight 0.5 is 187.5 in sRGB, 0.25 would be 137.
        assert_eq!(display(&colour, ToneCurve::None).as_slice(), [[188, 0, 0, 128]]);
        let clear = Image::filled(1, 1, [0.25, 0.0, 0.0, 0.0]).unwrap();
        assert_eq!(display(&clear, ToneCurve::None).as_slice(), [[0; 4]]);
        let over_black = display_over_black(&colour, ToneCurve::None);
        assert!((over_black[(0, 0)][0] - 0.537_099).abs() < 1e-5);
    }
}
