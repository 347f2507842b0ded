// Stochastic shadow maps (ST sections 3.2 and 3.6): each texel keeps, sample by sample, the first blocker on
// its ray that chance leaves. Twin of `StochasticMap::draw`, of `Blockers::find` and of the masks in
// crates/render/src/shadow/mask.rs.
#import shared/pcg32
#import shared/scene
#import shared/shadow_projection
#import shared/shadow_texel
#import shared/surface
#expand traverse VISITOR=first_opaque
#expand traverse VISITOR=blocker

@group(GROUP_PASS) @binding(BIND_SHADOW_MAP) var<storage, read_write> shadow_map: array<f32>;

// Of the texel that is being made: its number within the light's map, the light's key, where its numbers
// begin.
var<private> texel_number: u32;
var<private> texel_key: u32;
var<private> texel_first: u32;
// Its light, and its face among those of the light.
var<private> texel_light: u32;
var<private> texel_face: u32;
// Depth of the first opaque surface.
var<private> opaque_depth: f32;
// Of all transparent ones before that: transmittance, and the depth of the last.
var<private> blockers_through: vec3f;
var<private> last_blocker: f32;

fn visit_first_opaque(hit: Hit) -> u32 {
    if opacity(hit.triangle, hit.u, hit.v, texel_side(texel_light, texel_face, hit.t)) < 1.0 {
        return GO_ON;
    }
    opaque_depth = min(opaque_depth, hit.t);
    return END_HERE;
}

fn visit_blocker(hit: Hit) -> u32 {
    let width = texel_side(texel_light, texel_face, hit.t);
    let alpha = opacity(hit.triangle, hit.u, hit.v, width);
    if hit.t >= opaque_depth || alpha >= 1.0 || alpha < MIN_ALPHA {
        return GO_ON;
    }
    let through = light_through(hit.triangle, hit.u, hit.v, hit.front, alpha, width);
    blockers_through *= through;
    last_blocker = select(max(last_blocker, hit.t), hit.t, last_blocker == FAR_AWAY);
    let random = pcg4d(vec4u(texel_number, hit.triangle, texel_key, 0u));
    for (var channel = 0u; channel < shadow_channels(); channel += 1u) {
        // What a channel loses is its chance: the coverage times one less the tint (McGuire and Enderton).
        // One seed for all channels.
        cover(texel_first + channel * SHADOW_SAMPLES, 1.0 - through[channel], random.yx, hit.t);
    }
    return GO_ON;
}

fn keep_nearer(index: u32, depth: f32) {
    shadow_map[index] = min(shadow_map[index], depth);
}

// Enters a blocker in the samples that it covers, each with probability `alpha`: `Sampling::mask`.
fn cover(first: u32, alpha: f32, seed: vec2u, depth: f32) {
    if !SHADOW_IS_STRATIFIED {
        begin_pcg32(seed, SHADOW_SAMPLES);
        for (var at = 0u; at < SHADOW_SAMPLES; at += 1u) {
            if next_f32() < alpha {
                keep_nearer(first + at, depth);
            }
        }
        return;
    }
    // The whole part by itself: added at once, the random part would lose its last bits.
    let exact = alpha * f32(SHADOW_SAMPLES);
    let count = min(u32(exact) + u32(fract(exact) + unit_from_bits(seed.x)), SHADOW_SAMPLES);
    begin_pcg32(seed, 0u);
    // The first ones of a random order, by the shuffle of Fisher and Yates, stopped early.
    var order: array<u32, SHADOW_SAMPLES>;
    for (var at = 0u; at < SHADOW_SAMPLES; at += 1u) {
        order[at] = at;
    }
    for (var at = 0u; at < count; at += 1u) {
        let other = at + next_below(SHADOW_SAMPLES - at);
        let chosen = order[other];
        order[other] = order[at];
        order[at] = chosen;
        keep_nearer(first + chosen, depth);
    }
}

fn write_correction() {
    let corrected = texel_first + shadow_channels() * SHADOW_SAMPLES;
    shadow_map[corrected] = opaque_depth;
    shadow_map[corrected + 1u] = last_blocker;
    for (var channel = 0u; channel < shadow_channels(); channel += 1u) {
        var kept = 0.0;
        for (var at = 0u; at < SHADOW_SAMPLES; at += 1u) {
            kept += select(0.0, 1.0, shadow_map[texel_first + channel * SHADOW_SAMPLES + at] < FAR_AWAY);
        }
        let estimate = kept / f32(SHADOW_SAMPLES);
        let drop = 1.0 - blockers_through[channel];
        shadow_map[corrected + 2u + 2u * channel] = drop;
        shadow_map[corrected + 3u + 2u * channel] = select(0.0, drop / max(estimate, MIN_ALPHA), estimate > 0.0);
    }
}

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_shadow_map(@builtin(global_invocation_id) id: vec3u) {
    let light = id.z;
    let side = shadow_lights[light].side;
    if id.x >= side || id.y >= side * shadow_lights[light].face_count {
        return;
    }
    texel_number = id.y * side + id.x;
    texel_key = shadow_lights[light].key;
    texel_first = (shadow_lights[light].first_texel + texel_number) * shadow_stride();
    texel_light = light;
    texel_face = id.y / side;
    let ray = light_ray(light, texel_face, vec2f(f32(id.x), f32(id.y % side)) + 0.5);
    opaque_depth = FAR_AWAY;
    traverse_first_opaque(ray.origin, ray.direction, 0.0, FAR_AWAY);
    // A corrected map keeps the opaque surface apart from the samples, as the paper says it has to.
    let nothing = select(opaque_depth, FAR_AWAY, SHADOW_IS_CORRECTED);
    for (var at = 0u; at < shadow_channels() * SHADOW_SAMPLES; at += 1u) {
        shadow_map[texel_first + at] = nothing;
    }
    blockers_through = vec3f(1.0);
    last_blocker = FAR_AWAY;
    traverse_blocker(ray.origin, ray.direction, 0.0, opaque_depth);
    if SHADOW_IS_CORRECTED {
        write_correction();
    }
}
