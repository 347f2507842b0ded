// From samples to pixels: the estimates of ST section 4. Twin of `Stochastic::resolve`; pass/composite.wgsl
// adds what lies behind.
#import shared/counters
#import shared/frame
#import shared/pass
#import struct/RoundSums
#import shared/fragment_stats

@group(GROUP_OWN) @binding(BIND_FRAGMENT_STATS) var<storage, read> fragment_stats: array<u32>;
// Of the last round.
@group(GROUP_OWN) @binding(BIND_DEPTH_MAP) var depth_map: texture_depth_multisampled_2d;
@group(GROUP_OWN) @binding(BIND_ROUND_TARGETS) var round_targets: texture_multisampled_2d<f32>;
// Of all fragments, exactly.
@group(GROUP_OWN) @binding(BIND_TOTAL_TRANSMITTANCE) var total_transmittance: texture_multisampled_2d<f32>;

// Of the rounds that have ended; not used for one round.
@group(GROUP_OWN) @binding(BIND_ENDED_ROUNDS) var<storage, read_write> ended_rounds: array<RoundSums>;

fn round_sums(pixel: vec2u) -> RoundSums {
    var sums = vec4f(0.0);
    var empty = 0u;
    for (var sample = 0u; sample < MASK_SAMPLES; sample += 1u) {
        sums += min(textureLoad(round_targets, pixel, sample), vec4f(LARGEST_HALF));
        empty += select(0u, 1u, textureLoad(depth_map, pixel, sample) >= 1.0);
    }
    return RoundSums(sums.xyz, sums.w, empty, array<u32, 3>());
}

fn added(first: RoundSums, second: RoundSums) -> RoundSums {
    var sum = first;
    sum.rgb += second.rgb;
    sum.ones += second.ones;
    sum.empty += second.empty;
    return sum;
}

// Adds a round to those before it.
@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_end_round(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let index = id.y * frame.size.x + id.x;
    ended_rounds[index] = added(ended_rounds[index], round_sums(id.xy));
}

// What is left of the background: the mean over the samples.
fn transmittance(pixel: vec2u, sums: RoundSums) -> f32 {
    if !IS_CORRECTED {
        return f32(sums.empty) / f32(MASK_SAMPLES * ROUND_COUNT);
    }
    var sum = 0.0;
    for (var sample = 0u; sample < MASK_SAMPLES; sample += 1u) {
        sum += textureLoad(total_transmittance, pixel, sample).x;
    }
    return sum / f32(MASK_SAMPLES);
}

// Colour of the transparent layer, premultiplied: filtered first, then divided (ST section 4.2); a pixel
// without any winner stays empty (4.1).
fn estimate(sums: RoundSums, total_alpha: f32) -> vec3f {
    if !IS_CORRECTED {
        return sums.rgb / f32(MASK_SAMPLES * ROUND_COUNT);
    }
    return select(vec3f(0.0), total_alpha / sums.ones * sums.rgb, sums.ones > 0.0);
}

// Leaves a pixel to pass/composite.wgsl: the light of the layer, and in place of the primitive the furthest
// fragment's triangle.
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

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_resolve(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    resolve(id.xy);
    hand_in_counts();
}
