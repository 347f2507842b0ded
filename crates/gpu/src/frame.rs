//! What a frame is rendered with, as shaders read it: the twin of shaders/shared/frame.wgsl.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use sheer_render::{Background, contract::Hybrid};
use sheer_scene::{CameraPose, Frame, Lens};

use crate::{
    shader::numbers::{BACKGROUND_COLOUR, BACKGROUND_ENVIRONMENT, BACKGROUND_NONE},
    stage::Extent,
};

/// A camera at one moment: columns of `world_from_camera`, and its lens.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct CameraUniform {
    pub(crate) x_axis: [f32; 3],
    pub(crate) tan_half_fov: f32,
    pub(crate) y_axis: [f32; 3],
    pub(crate) half_height: f32,
    pub(crate) z_axis: [f32; 3],
    pub(crate) is_orthographic: u32,
    pub(crate) eye: [f32; 3],
    pub(crate) padding: u32,
}

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
            eye: pose.eye().into(),
            padding: 0,
        }
    }
}

/// Uniform of a frame. Units and spaces as in shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct FrameUniform {
    pub(crate) camera: CameraUniform,
    pub(crate) previous_camera: CameraUniform,
    pub(crate) size: [u32; 2],
    pub(crate) jitter: [f32; 2],
    pub(crate) index: u32,
    pub(crate) seed: u32,
    pub(crate) triangle_count: u32,
    pub(crate) static_count: u32,
    pub(crate) light_count: u32,
    pub(crate) lobe_count: u32,
    pub(crate) background_kind: u32,
    pub(crate) tinted: u32,
    pub(crate) background_rgb: [f32; 3],
    pub(crate) exposure: f32,
    pub(crate) zenith: [f32; 3],
    pub(crate) lift: f32,
    pub(crate) horizon: [f32; 3],
    pub(crate) depth_near: f32,
    pub(crate) ground: [f32; 3],
    pub(crate) depth_far: f32,
    pub(crate) reach: f32,
    pub(crate) hybrid_visibility: f32,
    pub(crate) hybrid_layers: u32,
    pub(crate) inverse_height: f32,
}

/// What differs from pipeline to pipeline and from frame to frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameParameters {
    /// Pixels.
    pub(crate) size: [u32; 2],
    /// Offset of the sample from the pixel centre, pixels.
    pub(crate) jitter: Vec2,
    /// Frame index.
    pub(crate) index: u32,
    /// Seed of the run.
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
        let [depth_near, depth_far] = extent.depth_range(frame.camera());
        Self {
            camera: frame.camera().into(),
            previous_camera: frame.previous_camera().into(),
            size: parameters.size,
            jitter: parameters.jitter.into(),
            index: parameters.index,
            seed: parameters.seed,
            triangle_count: frame.triangles().len() as u32,
            static_count: frame.static_count() as u32,
            light_count: frame.lights().len() as u32,
            lobe_count: scene.environment.lobes.len() as u32,
            background_kind,
            tinted: u32::from(frame.tints_light()),
            background_rgb: background_rgb.into(),
            exposure: scene.exposure,
            zenith: scene.environment.zenith.into(),
            lift: extent.lift,
            horizon: scene.environment.horizon.into(),
            depth_near,
            ground: scene.environment.ground.into(),
            depth_far,
            reach: extent.reach(frame.camera()),
            hybrid_visibility: parameters.hybrid.visibility,
            hybrid_layers: parameters.hybrid.layers.unwrap_or(u32::MAX),
            inverse_height: (parameters.size[1] as f32).recip(),
        }
    }
}
