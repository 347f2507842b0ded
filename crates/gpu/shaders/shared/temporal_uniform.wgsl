// What all passes know that add frames up.
#import struct/TemporalUniform

@group(GROUP_TEMPORAL) @binding(BIND_TEMPORAL) var<uniform> temporal: TemporalUniform;

fn index_of(pixel: vec2u) -> u32 {
    return pixel.y * temporal.size.x + pixel.x;
}

// The nearest pixel inside the picture.
fn clamped(pixel: vec2i) -> vec2u {
    return vec2u(clamp(pixel, vec2i(0), vec2i(temporal.size) - 1));
}
