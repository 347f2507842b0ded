// Fragments that no memory was left for, summed up by the blending units.
#import shared/scene

struct Tail {
    // Radiance times alpha, and alpha; the target adds them up.
    @location(0) rgb_premul: vec4f,
    // What is seen through a fragment; the target multiplies them up.
    @location(1) transmittance: f32,
}

@group(GROUP_OWN) @binding(BIND_TAIL_SUMS) var tail_sums: texture_2d<f32>;
@group(GROUP_OWN) @binding(BIND_TAIL_TRANSMITTANCE) var tail_transmittance: texture_2d<f32>;

fn tail_of(rgb: vec3f, alpha: f32) -> Tail {
    return Tail(vec4f(rgb * alpha, alpha), 1.0 - alpha);
}

// Light and opacity of these fragments, premultiplied: their mean by alpha, as opaque as all of them
// together.
fn tail(pixel: vec2u) -> vec4f {
    let transmittance = textureLoad(tail_transmittance, pixel, 0).x;
    let sums = textureLoad(tail_sums, pixel, 0);
    let alpha = 1.0 - transmittance;
    return vec4f(sums.xyz * (alpha / max(sums.w, MIN_ALPHA)), alpha);
}
