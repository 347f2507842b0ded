//! The one way from linear light to a display, so that all pictures and all metrics on pictures agree.
//!
//! Light is of two kinds. *Scene-referred* light is what a scene's lamps and surroundings make of its
//! surfaces: it has no upper bound, and a [`ToneCurve`] brings it into the range of a display.
//! *Display-referred* light is colour that somebody has chosen as it is to be seen: a background of one
//! colour, the texels of an unlit material. No curve may touch it, or white would come out grey.
//!
//! Both add up in one linear picture, and EXR files keep it as it is: there display-referred light is the
//! sRGB-decoded colour, and what blends with it does so in linear light. For a display, [`DisplayShare`]
//! tells how much of what a pixel shows is display-referred, by visibility: 1 where an unlit surface is all
//! that is seen, 1/2 where a lit pane of opacity 1/2 lies before a background of one colour. A pixel of share
//! `s` and colour `c` shows
//!
//! ```text
//! s · c + (1 - s) · curve(c · 2^exposure)
//! ```
//!
//! That is exact where all of a pixel is of one kind, and goes over from one to the other without a step.
//! Alternatives were to carry display-referred colour through the inverse of the curve, which makes white
//! infinitely bright, so that edges before it lose their anti-aliasing and panes their opacity; and to apply
//! the curve to each fragment before they are blended, as viewers without a linear target do, which blends in
//! another space than EXR files have, and dims lamps behind dark glass.

use glam::{Mat3, Vec3};
use rayon::prelude::*;
use sheer_core::{
    choice,
    colour::{Premul, srgb_from_linear},
    parameter::Choice as _,
};

use crate::{Image, Metadata};

choice! {
    /// How scene-referred light is brought into the range of a display.
    #[derive(Default)]
    pub enum ToneCurve {
        /// The Khronos PBR Neutral tone mapper (specification of 2024): base colours under grey light come
        /// out as they were authored, only what is brighter than 0.8 is compressed and then desaturated. It
        /// subtracts the 4 % that a dielectric reflects head-on, so that such a surface lit by white shows
        /// exactly its base colour.
        #[default]
        PbrNeutral = "pbr-neutral",
        /// No curve: light above display white is cut off.
        None = "none",
        /// The fit of the ACES reference rendering and output transforms for sRGB displays by Stephen Hill
        /// (*BakingLab*, 2016); without the exposure of 1/0.6 that some viewers put before it.
        Aces = "aces",
        /// The fit of the same by one rational function a channel (Narkowicz 2016, *ACES Filmic Tone Mapping
        /// Curve*): more contrast, and saturated light keeps its hue.
        AcesNarkowicz = "aces-narkowicz",
        /// AgX (Sobotka 2022) without a look, in the polynomial fit of Wrensch (*Minimal AgX Implementation*,
        /// 2023) with the Rec. 2020 primaries that Blender, Filament and three.js have.
        Agx = "agx",
        /// Light over one plus itself, channel by channel (Reinhard, Stark, Shirley, Ferwerda 2002,
        /// *Photographic Tone Reproduction for Digital Images*, Eq. 3).
        Reinhard = "reinhard",
    }
}

/// How a picture is brought to a display.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tone {
    /// What brings scene-referred light into the range of a display.
    pub curve: ToneCurve,
    /// Scene-referred light is multiplied by two to the power of this before the curve; stops.
    pub exposure_ev: f32,
}

/// How much of what each pixel of a picture shows is display-referred, 0 to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DisplayShare {
    /// Nothing: the curve applies everywhere.
    #[default]
    Nothing,
    /// Everything: the curve applies nowhere.
    Everything,
    /// This much of each pixel.
    PerPixel(Image<f32>),
}

impl DisplayShare {
    /// That of a pixel, counted row by row.
    fn at(&self, index: usize) -> f32 {
        match self {
            Self::Nothing => 0.0,
            Self::Everything => 1.0,
            Self::PerPixel(shares) => shares.as_slice()[index],
        }
    }

    fn suits<T>(&self, picture: &Image<T>) -> bool {
        !matches!(self, Self::PerPixel(shares) if shares.size() != picture.size())
    }
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
            Self::PbrNeutral => khronos_pbr_neutral(rgb),
            Self::None => rgb.min(Vec3::ONE),
            Self::Aces => aces_hill(rgb),
            Self::AcesNarkowicz => aces_narkowicz(rgb),
            Self::Agx => agx(rgb),
            Self::Reinhard => rgb / (1.0 + rgb),
        }
    }
}

impl Tone {
    /// Linear light of which `share` is display-referred to linear display light in [0, 1].
    #[must_use]
    pub fn apply(self, rgb: Vec3, share: f32) -> Vec3 {
        let toned = || self.curve.apply(rgb * self.exposure_ev.exp2());
        if share <= 0.0 {
            return toned();
        }
        let as_it_is = ToneCurve::None.apply(rgb);
        if share >= 1.0 { as_it_is } else { toned().lerp(as_it_is, share) }
    }

    /// The metadata of a picture with how it is displayed: the curve as `tone`, stops as `exposure_ev`.
    #[must_use]
    pub fn described(self, metadata: Metadata) -> Metadata {
        metadata.with("tone", self.curve.word()).with("exposure_ev", self.exposure_ev)
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

/// Hill's fit: from sRGB to the rendering primaries of ACES with its desaturation, both transforms as one
/// rational function, and back.
fn aces_hill(rgb: Vec3) -> Vec3 {
    const INTO: Mat3 = Mat3::from_cols(
        Vec3::new(0.597_19, 0.076_00, 0.028_40),
        Vec3::new(0.354_58, 0.908_34, 0.133_83),
        Vec3::new(0.048_23, 0.015_66, 0.837_77),
    );
    const BACK: Mat3 = Mat3::from_cols(
        Vec3::new(1.604_75, -0.102_08, -0.003_27),
        Vec3::new(-0.531_08, 1.108_13, -0.072_76),
        Vec3::new(-0.073_67, -0.006_05, 1.076_02),
    );
    let v = INTO * rgb;
    let fitted = (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    (BACK * fitted).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Narkowicz's fit, with the names of its article.
fn aces_narkowicz(x: Vec3) -> Vec3 {
    let [a, b, c, d, e] = [2.51, 0.03, 2.43, 0.59, 0.14];
    ((x * (a * x + b)) / (x * (c * x + d) + e)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// AgX: into Rec. 2020 and its inset gamut, logarithm, sigmoid, and back; the display's power of 2.2 undone.
fn agx(rgb: Vec3) -> Vec3 {
    const REC2020_FROM_SRGB: Mat3 = Mat3::from_cols(
        Vec3::new(0.6274, 0.0691, 0.0164),
        Vec3::new(0.3293, 0.9195, 0.0880),
        Vec3::new(0.0433, 0.0113, 0.8956),
    );
    const SRGB_FROM_REC2020: Mat3 = Mat3::from_cols(
        Vec3::new(1.6605, -0.1246, -0.0182),
        Vec3::new(-0.5876, 1.1329, -0.1006),
        Vec3::new(-0.0728, -0.0083, 1.1187),
    );
    const INSET: Mat3 = Mat3::from_cols(
        Vec3::new(0.856_627_15, 0.137_318_97, 0.111_898_21),
        Vec3::new(0.095_121_24, 0.761_242, 0.076_799_42),
        Vec3::new(0.048_251_606, 0.101_439_04, 0.811_302_37),
    );
    const OUTSET: Mat3 = Mat3::from_cols(
        Vec3::new(1.127_100_6, -0.141_329_76, -0.141_329_76),
        Vec3::new(-0.110_606_64, 1.157_823_7, -0.110_606_64),
        Vec3::new(-0.016_493_939, -0.016_493_939, 1.251_936_4),
    );
    /// Ten stops below and six and a half above the middle grey of 0.18, as logarithms to the base of 2.
    const LEAST_EV: f32 = -12.473_93;
    const MOST_EV: f32 = 4.026_069;
    let log = |channel: f32| ((channel.max(1e-10).log2() - LEAST_EV) / (MOST_EV - LEAST_EV)).clamp(0.0, 1.0);
    let x = (INSET * (REC2020_FROM_SRGB * rgb)).map(log);
    let x2 = x * x;
    let x4 = x2 * x2;
    let sigmoid =
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.002_32;
    let shown = (OUTSET * sigmoid).map(|channel| channel.max(0.0).powf(2.2));
    (SRGB_FROM_REC2020 * shown).clamp(Vec3::ZERO, Vec3::ONE)
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
///
/// # Panics
/// If the shares are those of a picture of another size.
#[must_use]
pub fn display(colour: &Image<[f32; 4]>, tone: Tone, share: &DisplayShare) -> Image<[u8; 4]> {
    shown(colour, share, |rgba_premul, share| {
        let straight = Premul::from_array(rgba_premul).to_straight();
        let rgb_srgb = tone.apply(straight.rgb, share).map(srgb_from_linear);
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
///
/// # Panics
/// If the shares are those of a picture of another size.
#[must_use]
pub fn display_over_black(colour: &Image<[f32; 4]>, tone: Tone, share: &DisplayShare) -> Image<[f32; 3]> {
    shown(colour, share, |[r, g, b, _], share| {
        tone.apply(Vec3::new(r, g, b), share).map(srgb_from_linear).to_array()
    })
}

/// A new image of what `pixel` makes of each pixel and its share.
fn shown<T: Send>(
    colour: &Image<[f32; 4]>,
    share: &DisplayShare,
    pixel: impl Fn([f32; 4], f32) -> T + Sync + Send,
) -> Image<T> {
    assert!(share.suits(colour), "the shares are those of a picture of another size");
    let (width, height) = colour.size();
    let pixels = colour.as_slice().par_iter().enumerate().with_min_len(width as usize);
    let pixels = pixels.map(|(index, &rgba_premul)| pixel(rgba_premul, share.at(index))).collect();
    Image::from_vec(width, height, pixels).expect("there is a pixel for each pixel of the picture")
}

#[cfg(test)]
mod tests {
    use sheer_core::colour::linear_from_srgb;

    use super::*;

    #[test]
    fn neutral_keeps_base_colours_lit_by_white_exact() {
        // The specification's promise: base colour plus the 4 % reflection comes out as the base colour.
        for base in [0.04, 0.18, 0.5, 0.75] {
            let shown = ToneCurve::PbrNeutral.apply(Vec3::splat(base + 0.04));
            assert!((shown - base).abs().max_element() < 1e-6, "{base} became {shown}");
        }
    }

    #[test]
    fn neutral_agrees_with_values_worked_out_from_its_specification() {
        // Python, in double precision, from the formulas of the specification.
        for (light, shown) in REFERENCE {
            let found = ToneCurve::PbrNeutral.apply(Vec3::from_array(light));
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
        for &curve in ToneCurve::ALL {
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
    fn curves_agree_with_values_worked_out_from_their_sources() {
        // Python, in double precision, from the formulas of the sources.
        for (curve, light, shown) in CURVES {
            let found = curve.apply(Vec3::from_array(light));
            assert!(
                (found - Vec3::from_array(shown)).abs().max_element() < 2e-5,
                "{curve:?} {light:?} became {found}"
            );
        }
        // Each curve is another one: middle grey tells them apart.
        for (at, curve) in ToneCurve::ALL.iter().enumerate() {
            for other in &ToneCurve::ALL[at + 1..] {
                let grey = Vec3::splat(0.6);
                assert!(
                    (curve.apply(grey) - other.apply(grey)).abs().max_element() > 1e-3,
                    "{curve:?} {other:?}"
                );
            }
        }
    }

    const CURVES: [(ToneCurve, [f32; 3], [f32; 3]); 12] = [
        (ToneCurve::Aces, [0.18, 0.18, 0.18], [0.105_591, 0.105_591, 0.105_590]),
        (ToneCurve::Aces, [4.0, 0.5, 0.1], [1.000_000, 0.493_941, 0.153_820]),
        (ToneCurve::Aces, [0.02, 0.3, 1.0], [0.000_232, 0.212_852, 0.604_442]),
        (ToneCurve::AcesNarkowicz, [0.18, 0.18, 0.18], [0.266_899, 0.266_899, 0.266_899]),
        (ToneCurve::AcesNarkowicz, [4.0, 0.5, 0.1], [0.973_417, 0.616_307, 0.125_840]),
        (ToneCurve::AcesNarkowicz, [0.02, 0.3, 1.0], [0.010_499, 0.438_492, 0.803_797]),
        (ToneCurve::Agx, [0.18, 0.18, 0.18], [0.214_549, 0.214_502, 0.214_499]),
        (ToneCurve::Agx, [4.0, 0.5, 0.1], [0.986_347, 0.524_875, 0.354_265]),
        (ToneCurve::Agx, [0.02, 0.3, 1.0], [0.122_566, 0.360_289, 0.645_828]),
        (ToneCurve::Reinhard, [0.18, 0.18, 0.18], [0.152_542, 0.152_542, 0.152_542]),
        (ToneCurve::Reinhard, [4.0, 0.5, 0.1], [0.800_000, 0.333_333, 0.090_909]),
        (ToneCurve::Reinhard, [0.02, 0.3, 1.0], [0.019_608, 0.230_769, 0.500_000]),
    ];

    #[test]
    fn display_referred_light_is_shown_as_it_is_under_any_curve_and_exposure() {
        let size = 256;
        let decoded = |value: u32| linear_from_srgb(unit_from_u8(value as u8));
        let colour =
            Image::from_fn(size, 1, |x, _| [decoded(x), decoded(255 - x), decoded(x / 2), 1.0]).unwrap();
        let bytes: Vec<_> = (0..size).map(|x| [x as u8, (255 - x) as u8, (x / 2) as u8, 255]).collect();
        for &curve in ToneCurve::ALL {
            for exposure_ev in [-3.0, 0.0, 2.5] {
                let tone = Tone { curve, exposure_ev };
                assert_eq!(display(&colour, tone, &DisplayShare::Everything).as_slice(), bytes, "{tone:?}");
                let each = DisplayShare::PerPixel(Image::filled(size, 1, 1.0).unwrap());
                assert_eq!(display(&colour, tone, &each).as_slice(), bytes, "{tone:?}");
            }
        }
        // Without a share the curve has its way: the specification takes white to 0.869, which is 240.
        let toned = display(&colour, Tone::default(), &DisplayShare::Nothing);
        assert_ne!(toned.as_slice(), bytes);
        let white = Image::filled(1, 1, [1.0; 4]).unwrap();
        assert_eq!(display(&white, Tone::default(), &DisplayShare::Nothing)[(0, 0)], [240, 240, 240, 255]);
    }

    #[test]
    fn what_mixes_both_kinds_of_light_lies_between_them() {
        let tone = Tone { curve: ToneCurve::Aces, exposure_ev: 1.0 };
        let colour = Vec3::new(0.7, 0.4, 0.1);
        let [toned, as_it_is] = [0.0, 1.0].map(|share| tone.apply(colour, share));
        assert_eq!(as_it_is, colour);
        let mut last = toned;
        for step in 1..=64 {
            let shown = tone.apply(colour, step as f32 / 64.0);
            assert!((shown - last).abs().max_element() < 0.02, "a step at {step} of 64");
            assert!(
                shown.cmpge(toned.min(as_it_is) - 1e-6).all()
                    && shown.cmple(toned.max(as_it_is) + 1e-6).all()
            );
            last = shown;
        }
    }

    #[test]
    fn exposure_counts_in_stops() {
        let tone = Tone { curve: ToneCurve::None, exposure_ev: -2.0 };
        assert_eq!(tone.apply(Vec3::new(1.0, 2.0, 8.0), 0.0), Vec3::new(0.25, 0.5, 1.0));
    }

    #[test]
    #[should_panic(expected = "another size")]
    fn shares_of_another_picture_are_refused() {
        let colour = Image::filled(2, 2, [0.0; 4]).unwrap();
        let share = DisplayShare::PerPixel(Image::filled(2, 1, 0.0).unwrap());
        let _ = display(&colour, Tone::default(), &share);
    }

    #[test]
    fn a_half_transparent_pixel_shows_its_own_colour() {
        let as_it_is = Tone { curve: ToneCurve::None, exposure_ev: 0.0 };
        let none = DisplayShare::Nothing;
        let colour = Image::filled(1, 1, [0.25, 0.0, 0.0, 0.5]).unwrap();
        // Straight 0.5 is 187.5 in sRGB, 0.25 would be 137.
        assert_eq!(display(&colour, as_it_is, &none).as_slice(), [[188, 0, 0, 128]]);
        let clear = Image::filled(1, 1, [0.25, 0.0, 0.0, 0.0]).unwrap();
        assert_eq!(display(&clear, as_it_is, &none).as_slice(), [[0; 4]]);
        let over_black = display_over_black(&colour, as_it_is, &none);
        assert!((over_black[(0, 0)][0] - 0.537_099).abs() < 1e-5);
    }
}
