//! What a frame is rendered with, from a stage and a pipeline to the uniform that every pass reads.
//!
//! One uniform for all passes, written once a frame before anything is recorded: a pass that needs two of its
//! numbers binds the same group as one that needs twenty, and groups need not be made anew from frame to
//! frame. What depends on the scene comes from the frame and its extent, what depends on the run from
//! [`FrameParameters`]. Numbers that a division makes are made here, by the CPU's division, which shaders are
//! free to round otherwise.

use glam::{UVec2, Vec2, Vec3};
use sheer_render::{Background, contract::Hybrid};
use sheer_scene::{CameraPose, Frame, Lens};

use crate::{
    shader::{
        numbers::{BACKGROUND_COLOUR, BACKGROUND_ENVIRONMENT, BACKGROUND_NONE},
        record::frame::{CameraUniform, FrameUniform},
    },
    stage::Extent,
};

impl From<&CameraPose> for CameraUniform {
    fn from(pose: &CameraPose) -> Self {
        let axes = pose.world_from_camera.matrix3;
        let (tan_half_fov, half_height, is_orthographic) = match pose.lens {
            Lens::Perspective { yfov_rad } => ((0.5 * yfov_rad).tan(), 1.0, 0),
            Lens::Orthographic { half_height } => (1.0, half_height, 1),
        };
        Self {
            x_axis: axes.x_axis.into(),
            tan_half_fov,
            y_axis: axes.y_axis.into(),
            half_height,
            z_axis: axes.z_axis.into(),
            is_orthographic,
            eye: pose.eye(),
            beam_side: 0.0,
            near: pose.clip.near,
            far: pose.clip.far.min(f32::MAX),
            padding: UVec2::ZERO,
        }
    }
}

/// What differs from pipeline to pipeline and from frame to frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameParameters {
    /// Columns and rows of pixels.
    pub(crate) size: [u32; 2],
    /// Offset of the sample from the pixel centre, pixels.
    pub(crate) jitter: Vec2,
    /// Number of the frame in the clip.
    pub(crate) index: u32,
    /// Seed of the run's random numbers.
    pub(crate) seed: u32,
    /// What lies behind everything.
    pub(crate) background: Background,
    /// Up to where the method is exact.
    pub(crate) hybrid: Hybrid,
}

impl FrameUniform {
    pub(crate) fn new(frame: &Frame, extent: &Extent, parameters: &FrameParameters) -> Self {
        let scene = frame.scene().parts();
        let (background_kind, background_rgb) = match parameters.background {
            Background::Environment => (BACKGROUND_ENVIRONMENT, Vec3::ZERO),
            Background::Colour(rgb) => (BACKGROUND_COLOUR, rgb),
            Background::None => (BACKGROUND_NONE, Vec3::ZERO),
        };
        let beam = frame.camera().pixel_beam(parameters.size[1] as f32);
        let [depth_near, depth_far] = extent.depth_range(frame.camera());
        Self {
            camera: CameraUniform { beam_side: beam.width + beam.growth, ..frame.camera().into() },
            previous_camera: frame.previous_camera().into(),
            size: parameters.size.into(),
            jitter: parameters.jitter,
            index: parameters.index,
            seed: parameters.seed,
            triangle_count: frame.triangles().len() as u32,
            static_count: frame.static_count() as u32,
            light_count: frame.lights().len() as u32,
            lobe_count: scene.environment.lobes.len() as u32,
            background_kind,
            tinted: u32::from(frame.tints_light()),
            background_rgb,
            exposure: scene.exposure,
            zenith: scene.environment.zenith,
            lift: extent.lift,
            horizon: scene.environment.horizon,
            depth_near,
            ground: scene.environment.ground,
            depth_far,
            reach: extent.reach(frame.camera()),
            hybrid_visibility: parameters.hybrid.visibility,
            hybrid_layers: parameters.hybrid.layers.unwrap_or(u32::MAX),
            inverse_height: (parameters.size[1] as f32).recip(),
        }
    }
}
