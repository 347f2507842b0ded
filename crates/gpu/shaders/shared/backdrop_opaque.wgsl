// What lies behind everything: what the caller has drawn. Stands for `backdrop`.
#import shared/hit
#import shared/pass

@group(GROUP_PASS) @binding(BIND_INPUT_COLOUR) var input_colour: texture_2d<f32>;

// Linear, premultiplied: a picture's values, with the exposure in them.
fn background(ray: CameraRay) -> vec4f {
    return textureLoad(input_colour, pixel_at, 0);
}
