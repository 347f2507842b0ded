// Colours weighted by visibility, once a round. By itself, since it is the same shader for all parameters of
// the method.
#import shared/transparent

// What fs_depth has drawn in this round.
@group(GROUP_OWN) @binding(BIND_DEPTH_MAP) var depth_map: texture_depth_multisampled_2d;

struct Accumulated {
    @location(0) sums: vec4f,
    @builtin(sample_mask) mask: u32,
}

// Added up in the samples that do not hide them (ST Eq. 4 and 6).
@fragment
fn fs_accumulate(vertex: TriangleVertex, @builtin(sample_mask) covered: u32) -> Accumulated {
    let pixel = vec2u(vertex.position.xy);
    pixel_at = pixel;
    let fragment = transparent_fragment(pixel, vertex.triangle);
    if fragment.alpha <= 0.0 {
        discard;
    }
    record_triangle(pixel, fragment.hit);
    let depth = depth_in_buffer(fragment.hit) * (1.0 - DEPTH_SLACK);
    var unhidden = 0u;
    for (var sample = 0u; sample < MASK_SAMPLES; sample += 1u) {
        let nearest = textureLoad(depth_map, pixel, sample);
        unhidden |= select(0u, 1u << sample, depth <= nearest);
    }
    if (unhidden & covered) == 0u {
        discard;
    }
    return Accumulated(shaded(pixel, fragment) * fragment.alpha, unhidden);
}
