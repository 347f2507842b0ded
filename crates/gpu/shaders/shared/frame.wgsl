// What a frame is rendered with, the same in every pass.
#import struct/FrameUniform

@group(GROUP_SCENE) @binding(BIND_FRAME) var<uniform> frame: FrameUniform;

// How wide the beam of a sample is at a distance, world units: twin of `PixelBeam::width_at`.
fn pixel_width_at(distance: f32) -> f32 {
    return frame.camera.beam_side * select(distance, 1.0, frame.camera.is_orthographic != 0u);
}
