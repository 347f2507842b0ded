// Lookup in a stochastic shadow map (ST section 3.6): twin of `Samples` in
// crates/render/src/shadow/stochastic_map.rs and of `Projection::filter` and `Projection::random_taps`.
#import shared/hash
#import shared/shadow_projection
#import shared/shadow_texel

@group(GROUP_PASS) @binding(BIND_SHADOW_MAP) var<storage, read> shadow_map: array<f32>;

// No single sample: all of them.
const ALL_SAMPLES: u32 = ~0u;

// Corrects the share of samples that blocks a depth; `corrected`: where the texel's numbers for that begin.
fn corrected_share(corrected: u32, channel: u32, depth: f32, share: f32) -> f32 {
    if depth > shadow_map[corrected] {
        return 1.0;
    }
    if depth > shadow_map[corrected + 1u] {
        return shadow_map[corrected + 2u + 2u * channel];
    }
    return share * shadow_map[corrected + 3u + 2u * channel];
}

fn channel_visibility(texel: u32, channel: u32, depth: f32, one: u32) -> f32 {
    let first = texel + channel * SHADOW_SAMPLES;
    var blocked = 0.0;
    if one == ALL_SAMPLES {
        for (var at = 0u; at < SHADOW_SAMPLES; at += 1u) {
            blocked += select(0.0, 1.0, shadow_map[first + at] < depth);
        }
        blocked /= f32(SHADOW_SAMPLES);
    } else {
        blocked = select(0.0, 1.0, shadow_map[first + one] < depth);
    }
    if SHADOW_IS_CORRECTED {
        blocked = corrected_share(texel + shadow_channels() * SHADOW_SAMPLES, channel, depth, blocked);
    }
    return 1.0 - blocked;
}

// Visibility at a depth of a texel by the share of its samples that are not nearer to the light (ST Eq. 4):
// all of them, or one.
fn map_visibility(light: u32, at: Tap, one: u32) -> vec3f {
    let texel = (shadow_lights[light].first_texel + at.texel) * shadow_stride();
    let red = channel_visibility(texel, 0u, at.depth, one);
    if frame.tinted == 0u {
        return vec3f(red);
    }
    return vec3f(
        red, channel_visibility(texel, 1u, at.depth, one), channel_visibility(texel, 2u, at.depth, one),
    );
}

// How much of a texel a box covers, along one axis.
fn covered_by_box(texel: f32, low: f32, high: f32) -> f32 {
    return min(texel + 1.0, high) - max(texel, low);
}

// Mean of the texels around a receiver: percentage closer filtering.
fn filtered(light: u32, receiver: Receiver, coordinate: MapCoordinate) -> vec3f {
    if SHADOW_FILTER == 0u {
        return map_visibility(light, tap(light, receiver, coordinate, coordinate.at), ALL_SAMPLES);
    }
    let low = coordinate.at - 0.5 * f32(SHADOW_FILTER);
    let high = coordinate.at + 0.5 * f32(SHADOW_FILTER);
    let first = floor(low);
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var row = 0u; row <= SHADOW_FILTER; row += 1u) {
        for (var column = 0u; column <= SHADOW_FILTER; column += 1u) {
            let corner = first + vec2f(f32(column), f32(row));
            let weight = covered_by_box(corner.x, low.x, high.x) * covered_by_box(corner.y, low.y, high.y);
            if weight > 0.0 {
                sum += weight * map_visibility(light, tap(light, receiver, coordinate, corner + 0.5), ALL_SAMPLES);
                weights += weight;
            }
        }
    }
    return sum / weights;
}

// Mean of one sample each at random points of the box, evenly spread: the sequence R2 (Roberts 2018) from a
// random start.
fn random_taps(light: u32, receiver: Receiver, coordinate: MapCoordinate) -> vec3f {
    let random = pcg4d(vec4u(receiver.key, shadow_lights[light].key));
    let start = vec2f(unit_from_bits(random.x), unit_from_bits(random.y));
    let first = random.z % SHADOW_SAMPLES;
    var sum = vec3f(0.0);
    for (var index = 0u; index < SHADOW_TAPS; index += 1u) {
        let unit = fract(start + vec2f(TAP_STEP_X, TAP_STEP_Y) * f32(index));
        let at = coordinate.at + (unit - 0.5) * f32(max(SHADOW_FILTER, 1u));
        sum += map_visibility(light, tap(light, receiver, coordinate, at), (first + index) % SHADOW_SAMPLES);
    }
    return sum / f32(SHADOW_TAPS);
}

fn shadow_transmittance(light: u32, receiver: Receiver) -> vec3f {
    let coordinate = map_coordinate(light, receiver.position);
    if !coordinate.inside {
        return vec3f(1.0);
    }
    if SHADOW_TAPS == 0u {
        return filtered(light, receiver, coordinate);
    }
    return random_taps(light, receiver, coordinate);
}
