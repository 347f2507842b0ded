// Fragments that no memory was left for, summed up by the blending units.
#import shared/scene

struct Tail {
    // Added up: radiance times alpha, and alpha.
    @location(0) rgb_premul: vec4f,
    // Multiplied up.
    @location(1) transmittance: f32,
}

@group(2) @binding(3) var tail_sums: texture_2d<f32>;
@group(2) @binding(4) var tail_transmittance: texture_2d<f32>;

fn tail_of(rgb: vec3f, alpha: f32) -> Tail {
    return Tail(vec4f(rgb * alpha, alpha), 1.0 - alpha);
}

// Light and opacity of these fragments, premultiplied: their mean by alpha, as opaque as all of them together.
fn tail(pixel: vec2u) -> vec4f {
    let transmittance = textureLoad(tail_transmittance, pixel, 0).x;
    let sums = textureLoad(tail_sums, pixel, 0);
    let alpha = 1.0 - transmittance;
    return vec4f(sums.xyz * (alpha / max(sums.w, MIN_ALPHA)), alpha);
}
