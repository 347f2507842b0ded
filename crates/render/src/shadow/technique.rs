//! What a shadow technique is: a map for each light of a frame, made at its start and asked while shading.

use std::fmt;

use glam::Vec3;
use sheer_core::{
    bibliography::Work,
    parameter::{ParameterInfo, ParameterRange},
};
use sheer_scene::{FrameLight, model::LightKind};

use crate::{cost::Counters, stage::Stage};

/// A technique's entry in lists and help.
#[derive(Clone, Copy, Debug)]
pub struct ShadowInfo {
    /// The word on the command line.
    pub id: &'static str,
    /// A line on what it does.
    pub title: &'static str,
    /// Paper and section that describe it.
    pub paper: &'static str,
    /// The bibliography's entries for [`Self::paper`].
    pub works: &'static [&'static Work],
    /// What its result is biased in, in words.
    pub bias: &'static str,
    /// Keys that it takes on the command line.
    pub parameters: &'static [ParameterInfo],
}

/// The key for the size of a map, for all techniques that make one.
pub(super) const RESOLUTION: ParameterInfo = ParameterInfo {
    key: "resolution",
    default: "1024",
    range: ParameterRange::Count(16, 8192),
    what: "texels a side of a light's map; half as many for each of the six squares around a point light",
};

/// What a technique does for each light of a frame.
pub(super) trait Technique: Sync {
    /// Texels a side of its maps; 0 if it makes none.
    fn resolution(&self) -> u32;

    /// Whether its maps are drawn by chance, each seed another.
    fn is_random(&self) -> bool {
        false
    }

    /// Bytes that a texel takes at least, for a number of colour channels.
    fn texel_bytes(&self, channels: usize) -> usize;

    /// Makes the map of one light.
    fn map(&self, view: &View<'_>) -> Box<dyn Map>;

    /// The value of each key.
    fn values(&self) -> Vec<String>;
}

/// The answer of one light.
pub(super) trait Map: fmt::Debug + Send + Sync {
    /// Transmittance of everything between a point and the light.
    fn transmittance(&self, stage: &Stage, receiver: &Receiver, counters: &mut Counters) -> Vec3;
}

/// A light of a frame, as a technique sees it.
pub(super) struct View<'a> {
    pub(super) stage: &'a Stage,
    pub(super) light: &'a FrameLight,
    /// How many pixels the picture has that asks, about.
    pub(super) pixels: usize,
    /// 3 where light takes on colour, else 1: red stands for all.
    pub(super) channels: usize,
    /// A hash of frame, seed and light, by which random numbers differ.
    pub(super) key: u32,
}

/// A point that light arrives at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    /// Its position in world space.
    pub(crate) position: Vec3,
    /// Unit normal of its triangle; either side.
    pub(crate) normal: Vec3,
    /// Unit direction towards the light.
    pub(crate) to_light: Vec3,
    /// Distance to the light, world units.
    pub(crate) distance: f32,
    /// Of the beam that sees the point, world units. A beam to a light keeps it: rays of the sun are
    /// parallel, and those to a lamp, which draw nearer to one another, are taken for it.
    pub(crate) width: f32,
    /// Makes random taps differ from fragment to fragment: the pixel, and what is hit in it.
    pub(crate) key: [u32; 3],
}

/// Share of its largest coordinate by which a point is lifted off its surface, beside a share of the scene's
/// size: a few times the rounding of a 32-bit coordinate.
pub const LIFT_ROUNDING: f32 = 4e-6;

impl Receiver {
    /// How far to step off the surface so that rounding does not shadow it by itself: a share of the scene's
    /// size, and a few times the rounding error of a 32-bit coordinate.
    pub(super) fn lift(&self, stage: &Stage) -> f32 {
        stage.lift() + self.position.abs().max_element() * LIFT_ROUNDING
    }
}

/// Unit direction and distance from a point to a light; neither is finite for a point at the light.
pub(crate) fn toward(light: &FrameLight, position: Vec3) -> (Vec3, f32) {
    match light.kind {
        LightKind::Directional => (-light.direction, f32::INFINITY),
        LightKind::Point { .. } | LightKind::Spot { .. } => {
            let toward = light.position - position;
            let distance = toward.length();
            (toward / distance, distance)
        }
    }
}
