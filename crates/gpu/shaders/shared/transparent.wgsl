// The transparent fragments of the passes of pass/stochastic.wgsl, and what they tell those that come after
// them.
//
// A fragment has one depth, that of the hit of its pixel's ray, in all samples that its triangle covers.
#import shared/camera
#import shared/counters
#import shared/opaque
#import shared/shade
#import shared/fragment_stats

@group(GROUP_OWN) @binding(BIND_FRAGMENT_STATS) var<storage, read_write> fragment_stats: array<atomic<u32>>;

// A share of a depth by which it may differ from itself: compilers are free to round differently in the
// shaders that compute it.
const DEPTH_SLACK: f32 = 4.8e-7;

struct TransparentFragment {
    hit: Hit,
    // 0: there is none, or something opaque hides it.
    alpha: f32,
}

fn transparent_fragment(pixel: vec2u, triangle: u32) -> TransparentFragment {
    let hit = fragment_hit(pixel, triangle);
    if hit.t < 0.0 {
        return TransparentFragment(hit, 0.0);
    }
    let alpha = alpha_of(hit);
    if alpha >= 1.0 || is_hidden(pixel, hit) {
        return TransparentFragment(hit, 0.0);
    }
    return TransparentFragment(hit, alpha);
}

// The first pass over all fragments counts them and looks for the furthest.
fn record_hit(pixel: vec2u, hit: Hit) {
    let stats = stats_index(pixel);
    atomicMax(&fragment_stats[stats + STATS_FURTHEST], bitcast<u32>(hit.t));
    atomicAdd(&fragment_stats[stats + STATS_HITS], 1u);
}

// A later one, which triangle that is.
fn record_triangle(pixel: vec2u, hit: Hit) {
    let stats = stats_index(pixel);
    if hit.t >= bitcast<f32>(atomicLoad(&fragment_stats[stats + STATS_FURTHEST])) * (1.0 - DEPTH_SLACK) {
        atomicMax(&fragment_stats[stats + STATS_TRIANGLE], hit.triangle);
    }
}

// Light of a fragment, and a 1.
fn shaded(pixel: vec2u, fragment: TransparentFragment) -> vec4f {
    let rgb = shade(camera_ray(sample_of(pixel)), fragment.hit, pixel);
    let stats = stats_index(pixel);
    atomicAdd(&fragment_stats[stats + STATS_SHADED], 1u);
    atomicAdd(&fragment_stats[stats + STATS_SHADOW_RAYS], counted_shadow_rays);
    return vec4f(rgb, 1.0);
}
