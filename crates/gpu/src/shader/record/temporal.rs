//! What passes read that add frames up over time.

use glam::{UVec2, Vec3};

use crate::shader::declaration::shader_struct;

shader_struct! {
    /// What passes read that add frames up over time.
    struct TemporalUniform {
        /// Columns and rows of pixels.
        size: UVec2,
        /// How many frames the history holds.
        count: u32,
        /// Side of the dithering pattern, pixels.
        alignment_px: u32,
        /// Number of the frame in the clip.
        frame: u32,
        /// Seed of the run's random numbers.
        seed: u32,
        /// One of the numbers `ALIGN_…`: how motion vectors are aligned to the pattern.
        alignment_rule: u32,
        /// How many frames in a row have shown the same, the new one among them.
        still_count: u32,
    }
}

shader_struct! {
    /// What layered accumulation keeps of a pixel.
    struct KeptLayers {
        /// Mean colour of the front: YCoCg and alpha, premultiplied.
        front_colour: [f32; 4] => "vec4f",
        /// Mean colour of the back.
        back_colour: [f32; 4] => "vec4f",
        /// Mean weight of the front's samples, their number, the variance of their luma, and the coverage.
        front_sums: [f32; 4] => "vec4f",
        /// Mean weight of the back's samples, their number, the variance of their luma, and the number of
        /// coverages.
        back_sums: [f32; 4] => "vec4f",
        /// What glass in the front absorbs of the back's red, green and blue, beyond the coverage.
        absorbed: Vec3,
        /// Depth of the back; NO_DEPTH where nothing is.
        back_depth: f32,
    }
}
