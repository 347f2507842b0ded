//! Colour with its alpha state in the type. Everything is linear light with Rec. 709 primaries unless the
//! name says `srgb`.

use glam::{Vec3, Vec4};

/// A colour whose `rgb` is already multiplied by `alpha`: what compositing works on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Premul {
    /// Linear radiance times alpha, 0 to infinity.
    pub rgb: Vec3,
    /// Opacity, 0 to 1.
    pub alpha: f32,
}

/// A colour whose `rgb` does not depend on `alpha`: what materials and PNG files hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Straight {
    /// Linear radiance or reflectance.
    pub rgb: Vec3,
    /// Opacity, 0 to 1.
    pub alpha: f32,
}

impl Premul {
    /// Nothing: no light, no opacity.
    pub const CLEAR: Self = Self { rgb: Vec3::ZERO, alpha: 0.0 };

    /// The operator OVER of Porter and Duff 1984 (STD Eq. 1): `self` in front of `back`.
    #[must_use]
    pub fn over(self, back: Self) -> Self {
        let transmittance = 1.0 - self.alpha;
        Self { rgb: self.rgb + transmittance * back.rgb, alpha: self.alpha + transmittance * back.alpha }
    }

    /// As it is seen through glass that lets so much of red, green and blue pass, 0 to 1. What glass takes of
    /// what lies behind a clear colour it covers: by the mean of the three.
    #[must_use]
    pub fn filtered(self, tint: Vec3) -> Self {
        Self { rgb: self.rgb * tint, alpha: 1.0 - mean_channel(tint) * (1.0 - self.alpha) }
    }

    /// Divides by alpha; a clear colour stays black.
    #[must_use]
    pub fn to_straight(self) -> Straight {
        let rgb = if self.alpha > 0.0 { self.rgb / self.alpha } else { Vec3::ZERO };
        Straight { rgb, alpha: self.alpha }
    }

    /// As four floats, the layout of `Image<[f32; 4]>` planes.
    #[must_use]
    pub fn to_array(self) -> [f32; 4] {
        [self.rgb.x, self.rgb.y, self.rgb.z, self.alpha]
    }

    /// From four floats, the layout of `Image<[f32; 4]>` planes.
    #[must_use]
    pub fn from_array([r, g, b, alpha]: [f32; 4]) -> Self {
        Self { rgb: Vec3::new(r, g, b), alpha }
    }
}

impl Straight {
    /// A colour with an alpha of 1.
    #[must_use]
    pub fn opaque(rgb: Vec3) -> Self {
        Self { rgb, alpha: 1.0 }
    }

    /// The same colour with its `rgb` multiplied by `alpha`.
    #[must_use]
    pub fn to_premul(self) -> Premul {
        Premul { rgb: self.rgb * self.alpha, alpha: self.alpha }
    }
}

impl From<Vec4> for Straight {
    fn from(rgba: Vec4) -> Self {
        Self { rgb: rgba.truncate(), alpha: rgba.w }
    }
}

/// Mean of red, green and blue; of three that are the same it is that, to the bit.
#[must_use]
pub fn mean_channel(rgb: Vec3) -> f32 {
    rgb.x + ((rgb.y - rgb.x) + (rgb.z - rgb.x)) / 3.0
}

/// Relative luminance of linear Rec. 709 light (ITU-R BT.709-6, item 3.2).
#[must_use]
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// The sRGB decoding curve (IEC 61966-2-1): display value in [0, 1] to linear light.
#[must_use]
pub fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB encoding curve (IEC 61966-2-1): linear light in [0, 1] to display value.
#[must_use]
pub fn srgb_from_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

/// An 8-bit sRGB colour such as `0x80c0ff` as linear light.
#[must_use]
pub fn linear_from_hex(rgb_srgb: u32) -> Vec3 {
    let channel = |shift: u32| linear_from_srgb((rgb_srgb >> shift & 0xff) as f32 / 255.0);
    Vec3::new(channel(16), channel(8), channel(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn example_1_of_stochastic_transparency_composites_to_its_closed_form() {
        let layer = |rgb| Straight { rgb, alpha: 0.45 }.to_premul();
        let result = layer(Vec3::X).over(layer(Vec3::Y)).over(Straight::opaque(Vec3::Z).to_premul());
        assert!((result.rgb - Vec3::new(0.45, 0.2475, 0.3025)).abs().max_element() < 1e-6, "{result:?}");
        assert!((result.alpha - 1.0).abs() < 1e-6);
    }

    #[test]
    fn srgb_curves_are_inverses_of_each_other() {
        for step in 0..=255_u8 {
            let display = f32::from(step) / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(display)) - display).abs() < 1e-5);
        }
    }

    #[test]
    fn straight_and_premultiplied_convert_back_and_forth() {
        let straight = Straight { rgb: Vec3::new(0.2, 0.4, 3.0), alpha: 0.25 };
        assert_eq!(straight.to_premul().to_straight(), straight);
        assert_eq!(Premul::CLEAR.to_straight().rgb, Vec3::ZERO);
    }
}
