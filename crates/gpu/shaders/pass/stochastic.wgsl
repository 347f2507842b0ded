// Stochastic transparency (ST sections 3.1 to 3.5) on targets of several samples a pixel: all transparent
// fragments are drawn for the total alpha, then twice a round; pass/stochastic_accumulate.wgsl is the second
// time. Twin of the steps in crates/render/src/method/stochastic/mod.rs.
#import method
#import shared/transparent
#import struct/Round

@group(GROUP_OWN) @binding(BIND_ROUND) var<uniform> round: Round;

fn mask_in_round(pixel: vec2u, fragment: TransparentFragment) -> u32 {
    let hit = fragment.hit;
    let object = triangles[hit.triangle].x;
    var site: MaskSite;
    site.pixel = pixel;
    site.instance = objects[object].id;
    site.geometry = objects[object].geometry;
    site.primitive = primitive(hit.triangle);
    site.back = select(0u, 1u, is_back(hit));
    if P_SEED_BY == P_SEED_BY_DEPTH {
        let ray = camera_ray(sample_of(pixel));
        site.depth = view_depth(ray.origin) + hit.t * dot(ray.direction, -frame.camera.z_axis);
    }
    site.alpha = fragment.alpha;
    return mask_of(site, round.index);
}

// Total alpha (ST Eq. 5): multiplied up in each sample.
@fragment
fn fs_total_alpha(vertex: TriangleVertex) -> @location(0) f32 {
    let pixel = vec2u(vertex.position.xy);
    let fragment = transparent_fragment(pixel, vertex.triangle);
    if fragment.alpha <= 0.0 {
        discard;
    }
    record_hit(pixel, fragment.hit);
    return 1.0 - fragment.alpha;
}

struct StochasticDepth {
    @builtin(frag_depth) depth: f32,
    @builtin(sample_mask) mask: u32,
}

// A z-buffer of what is kept by chance (ST section 3.2).
@fragment
fn fs_depth(vertex: TriangleVertex) -> StochasticDepth {
    let pixel = vec2u(vertex.position.xy);
    let fragment = transparent_fragment(pixel, vertex.triangle);
    if fragment.alpha <= 0.0 {
        discard;
    }
    if !HAS_TOTAL_ALPHA && round.index == 0u {
        record_hit(pixel, fragment.hit);
    }
    let mask = mask_in_round(pixel, fragment);
    if mask == 0u {
        discard;
    }
    return StochasticDepth(depth_in_buffer(fragment.hit), mask);
}

struct Winner {
    @location(0) colour: vec4f,
    @builtin(frag_depth) depth: f32,
    @builtin(sample_mask) mask: u32,
}

// The colour of the nearest fragment that each sample keeps (ST section 3.1), and a 1.
@fragment
fn fs_colour(vertex: TriangleVertex) -> Winner {
    let pixel = vec2u(vertex.position.xy);
    pixel_at = pixel;
    let fragment = transparent_fragment(pixel, vertex.triangle);
    if fragment.alpha <= 0.0 {
        discard;
    }
    record_triangle(pixel, fragment.hit);
    let mask = mask_in_round(pixel, fragment);
    if mask == 0u {
        discard;
    }
    return Winner(shaded(pixel, fragment), depth_in_buffer(fragment.hit), mask);
}
