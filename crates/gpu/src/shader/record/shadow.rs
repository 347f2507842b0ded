//! The maps of lights: twins of what `sheer_render::shadow::projection` makes.

use glam::Vec3;

use crate::shader::declaration::shader_struct;

shader_struct! {
    /// One square of a light's map: columns of `world_from_face`, and its lens.
    struct ShadowFace {
        /// World, unit length.
        right: Vec3,
        /// Parallel: columns of a texel, world units. Central: half the width at distance 1.
        width: f32,
        /// World, unit length.
        up: Vec3,
        /// Parallel: rows of a texel, world units.
        height: f32,
        /// World, unit length: where the face looks.
        forward: Vec3,
        /// 1 where rays start from one point, 0 where they are parallel.
        is_central: u32,
        /// Parallel: a corner of the map, in the space of the face. Central: the eye, world.
        origin: Vec3,
        /// Fills the last row.
        padding: u32,
    }
}

shader_struct! {
    /// The map of a light.
    struct ShadowLight {
        /// Index of its first face.
        first_face: u32,
        /// How many faces its map has: 1 or 6.
        face_count: u32,
        /// Texels a row of a face.
        side: u32,
        /// Where its texels begin: in texels.
        first_texel: u32,
        /// Of the frame, the run and the light: makes random numbers differ.
        key: u32,
    }
}
