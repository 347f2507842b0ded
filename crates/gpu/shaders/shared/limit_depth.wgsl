// Depths of what the caller has drawn, in a depth texture. Stands for `limit`.
#import shared/limit

@group(GROUP_PASS) @binding(BIND_INPUT_DEPTH) var input_depth: texture_depth_2d;

fn opaque_ndc(pixel: vec2u) -> f32 {
    return textureLoad(input_depth, pixel, 0);
}
