//! What a frame is rendered with, the same in every pass.

use glam::{UVec2, Vec2, Vec3};

use crate::shader::declaration::shader_struct;

shader_struct! {
    /// A camera at one moment: columns of `world_from_camera`, and its lens.
    struct CameraUniform {
        /// World, unit length.
        x_axis: Vec3,
        /// Tangent of half the vertical field of view; without meaning for an orthographic camera.
        tan_half_fov: f32,
        /// World, unit length.
        y_axis: Vec3,
        /// Half the height of the view, world units; without meaning for a perspective camera.
        half_height: f32,
        /// World, unit length; the camera looks against it.
        z_axis: Vec3,
        /// 1 for an orthographic camera, 0 for a perspective one.
        is_orthographic: u32,
        /// Where the camera stands, world.
        eye: Vec3,
        /// Side of a sample's beam, world units: at distance 1 of a perspective camera, anywhere of an
        /// orthographic one; 0 of the camera of the frame before, which sees no texture.
        beam_side: f32,
        /// Nothing is seen that is nearer along the view axis, world units.
        near: f32,
        /// Nothing is seen that is further; `FAR_AWAY` if there is no end.
        far: f32,
        /// Fills the size up to a multiple of 16.
        padding: UVec2,
    }
}

shader_struct! {
    /// What a frame is rendered with, the same in every pass.
    struct FrameUniform {
        /// At the time of the frame.
        camera: CameraUniform,
        /// At the time of the frame before.
        previous_camera: CameraUniform,
        /// Columns and rows of pixels.
        size: UVec2,
        /// Offset of the sample from the pixel centre, pixels.
        jitter: Vec2,
        /// Number of the frame in the clip.
        index: u32,
        /// Seed of the run's random numbers.
        seed: u32,
        /// How many triangles the frame has.
        triangle_count: u32,
        /// Triangles before this one never move.
        static_count: u32,
        /// How many punctual lights there are.
        light_count: u32,
        /// How many lobes the environment has.
        lobe_count: u32,
        /// One of the numbers `BACKGROUND_…`.
        background_kind: u32,
        /// 1 if the light that passes a surface somewhere takes its colour.
        tinted: u32,
        /// Linear; of a background of one colour.
        background_rgb: Vec3,
        /// Factor from radiance to the picture's values.
        exposure: f32,
        /// Radiance of the environment straight above.
        zenith: Vec3,
        /// Ray origins are lifted off surfaces by this much, world units.
        lift: f32,
        /// Radiance of the environment at the horizon.
        horizon: Vec3,
        /// No surface is nearer along the view axis, scene units; above 0.
        depth_near: f32,
        /// Radiance of the environment straight below.
        ground: Vec3,
        /// No surface is further along the view axis, scene units.
        depth_far: f32,
        /// A power of two that no distance along a camera ray exceeds, world units.
        reach: f32,
        /// Of the hybrid: visibility from which on one ray stands for the rest.
        hybrid_visibility: f32,
        /// Of the hybrid: how many fragments are exact at most.
        hybrid_layers: u32,
        /// 1 / size.y, by the CPU's division.
        inverse_height: f32,
    }
}
