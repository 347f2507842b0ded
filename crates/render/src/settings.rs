//! What frames are rendered with, beside scene and method.

use std::{fmt, str::FromStr};

use glam::{Vec2, Vec3};
use sheer_core::colour::{linear_from_srgb, srgb_from_linear};
use sheer_image::{Region, Tone, u8_from_unit, unit_from_u8};

use crate::shadow::Shadow;

/// What lies behind everything (`--background`). Parse one from `env`, `none` or an sRGB colour, `#rrggbb`;
/// it prints so.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Background {
    /// The scene's environment, as sharp as it is.
    #[default]
    Environment,
    /// A constant linear colour, display-referred: a picture for a display shows it as it is.
    Colour(Vec3),
    /// Nothing: the picture is transparent there.
    None,
}

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "env" => Ok(Self::Environment),
            "none" => Ok(Self::None),
            _ => {
                let is_colour = |digits: &&str| {
                    digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit())
                };
                let digits = text.strip_prefix('#').filter(is_colour);
                let bytes =
                    digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()).map(u32::to_be_bytes);
                let [_, r, g, b] = bytes.ok_or("give env, none or a colour as in #7f7f7f")?;
                Ok(Self::Colour(Vec3::from_array([r, g, b].map(|v| linear_from_srgb(unit_from_u8(v))))))
            }
        }
    }
}

impl fmt::Display for Background {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Environment => f.write_str("env"),
            Self::None => f.write_str("none"),
            Self::Colour(linear) => {
                let [r, g, b] = linear.to_array().map(|value| u8_from_unit(srgb_from_linear(value)));
                write!(f, "#{r:02x}{g:02x}{b:02x}")
            }
        }
    }
}

/// What all frames of a run have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The part of the picture that is rendered, all of it if none; within [`Self::size`]. Frames have its
    /// size. Pixels show what they show in the whole picture: without a history to the bit. What a history
    /// looks at beyond the edge is missing, see [`crate::temporal::margin_px`].
    pub crop: Option<Region>,
    /// Seed of the dithering.
    pub seed: u32,
    /// What lies behind everything.
    pub background: Background,
    /// How light is shadowed.
    pub shadow: Shadow,
    /// Time of the first frame, seconds.
    pub start_secs: f32,
    /// Index of the first frame.
    pub first_frame: u32,
    /// How many frames a second has where time passes; above 0.
    pub frames_per_sec: f32,
    /// Whether frames stay as they were rendered: jittered as the anti-aliasing wants them, with their pixels
    /// split into layers, and not added up.
    pub raw: bool,
    /// How pictures for a display are made of frames; frames do not depend on it.
    pub tone: Tone,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: [960, 540],
            crop: None,
            seed: 0,
            background: Background::Environment,
            shadow: Shadow::default(),
            start_secs: 0.0,
            first_frame: 0,
            frames_per_sec: 30.0,
            raw: false,
            tone: Tone::default(),
        }
    }
}

impl Settings {
    /// The pixels that are rendered.
    #[must_use]
    pub fn region(&self) -> Region {
        self.crop.unwrap_or(Region::whole(self.size))
    }
}

/// What one frame is rendered with.
#[derive(Clone, Copy, Debug)]
pub struct FrameSettings {
    /// What it has in common with all frames of its run.
    pub run: Settings,
    /// Index of the frame, by which thresholds and masks are drawn; counted from 0, not from
    /// [`Settings::first_frame`].
    pub frame: u32,
    /// Offset of the sample from the pixel centre, pixels, each coordinate in (-0.5, 0.5).
    pub jitter: Vec2,
    /// How pixels are split into layers, if they are; the planes have [`layers`](sheer_image::Planes::layers)
    /// then.
    pub layers: Option<LayerSplit>,
    /// Whether the previous frame shows the same, see [`sheer_scene::Frame::is_still`].
    pub is_still: bool,
}

/// How pixels are split into what is transparent and what lies behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerSplit {
    /// Where both layers are there, the shaded fragment is one of the front with a probability of the
    /// coverage, but no less than this and no more than its complement; 0 to 0.5. A threshold method keeps
    /// its own probability.
    pub least_share: f32,
}

impl LayerSplit {
    /// Each layer is shaded as often as it is seen, as it is without a split.
    pub const AS_SEEN: Self = Self { least_share: 0.0 };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn background_colours_are_srgb() {
        let Ok(Background::Colour(linear)) = "#ff8000".parse() else { panic!("no colour") };
        assert!((linear - Vec3::new(1.0, 0.215_86, 0.0)).abs().max_element() < 1e-4, "{linear}");
        for wrong in ["#fff", "ff8000", "#ff80zz", "#+f8000", "blue", "#ｆｆ"] {
            assert!(wrong.parse::<Background>().is_err(), "{wrong} passed");
        }
        for text in ["env", "none", "#ff8000", "#01fe7f"] {
            assert_eq!(text.parse::<Background>().unwrap().to_string(), text);
        }
    }
}
