//! What passes read of what a caller has drawn.

use glam::Vec2;

use crate::shader::declaration::shader_struct;

shader_struct! {
    /// How depths and motions that a caller has drawn are to be read.
    struct OpaqueUniform {
        /// What the caller's projection makes of distances: the third entries of its third and fourth column,
        /// then their fourth entries.
        depth_row: [f32; 4] => "vec4f",
        /// From the caller's motion to pixels, from this frame to the last.
        motion_scale: Vec2,
        /// 1 where the caller tells motion.
        has_motion: u32,
        /// The depth where nothing was drawn.
        nothing: f32,
    }
}
