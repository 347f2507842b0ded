//! What frames are rendered with, beside scene and method.

use glam::{Vec2, Vec3};
use sheer_image::{Region, Tone};

use crate::shadow::Shadow;

/// What lies behind everything (`--background`).
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
