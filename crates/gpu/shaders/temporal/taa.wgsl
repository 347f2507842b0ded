// Temporal anti-aliasing: twin of crates/render/src/temporal/taa.rs (Salvi 2016; STD section 2.1, Eq. 2), its
// motion vectors aligned as in align.rs there (STD section 3.3.1, Listing 5).
#import shared/hash
#import shared/resample
#import shared/temporal

fn resolved(pixel: vec2u, current: PixelRecord) -> vec4f {
    let latest = current.colour;
    if temporal.count == 0u {
        return latest;
    }
    // A young history is a plain mean: the average would take 30 frames to forget the first one.
    let weight = max(P_WEIGHT, 1.0 / (f32(temporal.count) + 1.0));
    let transparent = current.transparent != 0u;
    var motion = current.motion;
    // Only where the pattern shows: opaque surfaces would smear for nothing.
    if transparent {
        motion = aligned(motion, pixel);
    }
    let place = place_of(vec2f(pixel) + motion);
    if !place.is_inside {
        return latest;
    }
    let radius = select(OPAQUE_RADIUS, i32(P_RADIUS), transparent);
    let clipped = clip(sharp_history(place), vec2i(pixel), radius);
    return clipped + (latest - clipped) * weight;
}

// The motion vector (pixels) of a transparent pixel as a multiple of the pattern's side, so that history is
// fetched from a pixel at the same place in the pattern.
fn aligned(motion: vec2f, pixel: vec2u) -> vec2f {
    let side = f32(temporal.alignment_px);
    if temporal.alignment_rule == ALIGN_ON {
        return drawn(motion, pixel);
    }
    if temporal.alignment_rule == ALIGN_ROUND {
        return floor(motion / side + 0.5) * side;
    }
    if temporal.alignment_rule == ALIGN_DEAD {
        return drawn(select(motion, vec2f(0.0), abs(motion) < vec2f(temporal.size) * DEAD_ZONE), pixel);
    }
    return motion;
}

// One of the four nearest multiples, drawn by bilinear weight. A device may divide with an error of a few
// units in the last place: a multiple then counts as a point just beside it, and is drawn with a probability
// just below 1.
fn drawn(motion: vec2f, pixel: vec2u) -> vec2f {
    let side = f32(temporal.alignment_px);
    let low = floor(motion / side) * side;
    let high = ceil(motion / side) * side;
    let share = motion / side - floor(motion / side);
    let rotated_seed = (temporal.seed << 16u) | (temporal.seed >> 16u);
    let random = unit_from_bits(pcg3d(vec3u(pixel, temporal.frame ^ rotated_seed)).x);
    // One random number serves both axes: what remains of it after the first decision is uniform again.
    var chosen = low;
    var rest = (random - share.x) / (1.0 - share.x);
    if random < share.x {
        chosen.x = high.x;
        rest = random / share.x;
    }
    if rest < share.y {
        chosen.y = high.y;
    }
    return chosen;
}

// Pulls history into the ellipsoid of the neighbourhood, along the line to its mean: colour and alpha
// together. With the rule of the dead zone into the box around the ellipsoid, each channel by itself.
fn clip(old: vec4f, pixel: vec2i, radius: i32) -> vec4f {
    var sum = vec4f(0.0);
    var squares = vec4f(0.0);
    for (var dy = -radius; dy <= radius; dy += 1) {
        for (var dx = -radius; dx <= radius; dx += 1) {
            let neighbour = ycocga_from_rgba(pixels[index_of(clamped(pixel + vec2i(dx, dy)))].colour);
            sum += neighbour;
            squares += neighbour * neighbour;
        }
    }
    let count = f32((2 * radius + 1) * (2 * radius + 1));
    let mean = sum / count;
    let deviation = sqrt(max(squares / count - mean * mean, vec4f(0.0))) * P_SIGMA;
    let offset = ycocga_from_rgba(old) - mean;
    if temporal.alignment_rule == ALIGN_DEAD {
        return rgba_from_ycocga(mean + clamp(offset, -deviation, deviation));
    }
    // Length of the offset in standard deviations; an even neighbourhood leaves no room.
    let reach = length(offset / max(deviation, vec4f(LEAST_DEVIATION)));
    if reach <= 1.0 {
        return old;
    }
    return rgba_from_ycocga(mean + offset / reach);
}

fn texel_history(pixel: vec2u) -> vec4f {
    return history[index_of(pixel)];
}
#expand shared/sharp TEXEL=history
