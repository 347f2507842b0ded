// Depths of what the caller has drawn, in a texture of floats. Stands for `limit`.
#import shared/limit

@group(GROUP_PASS) @binding(BIND_INPUT_DEPTH) var input_depth: texture_2d<f32>;

fn opaque_ndc(pixel: vec2u) -> f32 {
    return textureLoad(input_depth, pixel, 0).x;
}
