// From samples to pixels: the estimates of ST section 4. Twin of `Stochastic::resolve`; pass/composite.wgsl adds what lies behind.
#import shared/counters
#import shared/frame
#import shared/pass
#import shared/fragment_stats

@group(2) @binding(2) var<storage, read> fragment_stats: array<u32>;
// Of the last round.
@group(2) @binding(3) var depth_map: texture_depth_multisampled_2d;
@group(2) @binding(4) var round_targets: texture_multisampled_2d<f32>;
// Of all fragments, exactly.
@group(2) @binding(5) var total_transmittance: texture_multisampled_2d<f32>;

struct Sums {
    // Of colours, and of the same with all colours 1 (ST section 4: F(B) and F(B1), F(U) and F(U1), times the number of samples).
    rgb: vec3f,
    ones: f32,
    // Samples that nothing covered.
    empty: u32,
}

// Of the rounds that have ended; not used for one round.
@group(2) @binding(6) var<storage, read_write> ended_rounds: array<Sums>;

// The largest number of a half float: more came out as infinite, and would spoil the pixel.
const MOST_HALF: f32 = 65504.0;

fn round_sums(pixel: vec2u) -> Sums {
    var sums = vec4f(0.0);
    var empty = 0u;
    for (var sample = 0u; sample < MASK_SAMPLES; sample += 1u) {
        sums += min(textureLoad(round_targets, pixel, sample), vec4f(MOST_HALF));
        empty += select(0u, 1u, textureLoad(depth_map, pixel, sample) >= 1.0);
    }
    return Sums(sums.xyz, sums.w, empty);
}

fn added(first: Sums, second: Sums) -> Sums {
    return Sums(first.rgb + second.rgb, first.ones + second.ones, first.empty + second.empty);
}

// Adds a round to those before it.
@compute @workgroup_size(8, 8)
fn cs_end_round(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let index = id.y * frame.size.x + id.x;
    ended_rounds[index] = added(ended_rounds[index], round_sums(id.xy));
}

// What is left of the background: the mean over the samples.
fn transmittance(pixel: vec2u, sums: Sums) -> f32 {
    if !IS_CORRECTED {
        return f32(sums.empty) / f32(MASK_SAMPLES * ROUND_COUNT);
    }
    var sum = 0.0;
    for (var sample = 0u; sample < MASK_SAMPLES; sample += 1u) {
        sum += textureLoad(total_transmittance, pixel, sample).x;
    }
    return sum / f32(MASK_SAMPLES);
}

// Colour of the transparent layer, premultiplied: filtered first, then divided (ST section 4.2); a pixel without any winner stays empty (4.1).
fn estimate(sums: Sums, total_alpha: f32) -> vec3f {
    if !IS_CORRECTED {
        return sums.rgb / f32(MASK_SAMPLES * ROUND_COUNT);
    }
    return select(vec3f(0.0), total_alpha / sums.ones * sums.rgb, sums.ones > 0.0);
}

// Leaves a pixel to pass/composite.wgsl: the light of the layer, and in place of the primitive the furthest fragment's triangle.
fn resolve(pixel: vec2u) {
    let at = pixel.y * frame.size.x + pixel.x;
    var sums = round_sums(pixel);
    if ROUND_COUNT > 1u {
        sums = added(ended_rounds[at], sums);
    }
    let through = transmittance(pixel, sums);
    let stats = stats_index(pixel);
    counted.hits += fragment_stats[stats + STATS_HITS];
    counted.shaded += fragment_stats[stats + STATS_SHADED];
    counted_shadow_rays += fragment_stats[stats + STATS_SHADOW_RAYS];
    let is_transparent = fragment_stats[stats + STATS_HITS] != 0u;
    pixels[at].colour = vec4f(estimate(sums, 1.0 - through), 1.0 - through);
    pixels[at].transparent = select(0u, 1u, is_transparent);
    pixels[at].primitive = select(NONE, fragment_stats[stats + STATS_TRIANGLE], is_transparent);
}

@compute @workgroup_size(8, 8)
fn cs_resolve(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    resolve(id.xy);
    hand_in_counts();
}
