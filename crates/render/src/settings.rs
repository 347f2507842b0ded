//! What frames are rendered with, beside scene and method.

use glam::{Vec2, Vec3};

use crate::shadow::Shadow;

/// What lies behind everything (`--background`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Background {
    /// The scene's environment, as sharp as it is.
    #[default]
    Environment,
    /// A constant linear colour.
    Colour(Vec3),
    /// Nothing: the picture is transparent there.
    None,
}

/// What all frames of a run have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width and height, pixels.
    pub size: [u32; 2],
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
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: [960, 540],
            seed: 0,
            background: Background::Environment,
            shadow: Shadow::default(),
            start_secs: 0.0,
            first_frame: 0,
        }
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
}
