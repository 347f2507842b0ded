// Temporal anti-aliasing: twin of crates/render/src/temporal/taa.rs (Salvi 2016; STD section 2.1, Eq. 2), its
// motion vectors aligned as in align.rs there (STD section 3.3.1, Listing 5).
#import shared/hash
#import shared/temporal

fn resolved(pixel: vec2u, current: PixelRecord) -> vec4f {
    let latest = current.colour;
    // A young history is a plain mean: the average would take 30 frames to forget the first one.
    let weight = max(NEW_FRAME_WEIGHT, 1.0 / (f32(temporal.count) + 1.0));
    let transparent = current.transparent != 0u;
    var motion = current.motion;
    // Only where the pattern shows: opaque surfaces would smear for nothing.
    if transparent {
        motion = aligned(motion, pixel);
    }
    let old = fetch(vec2f(pixel) + motion);
    if !old.is_inside {
        return latest;
    }
    let radius = select(OPAQUE_RADIUS, TRANSPARENT_RADIUS, transparent);
    let clipped = clip(old.colour, vec2i(pixel), radius);
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

// Pulls history into the ellipsoid of the neighbourhood, along the line to its mean; alpha as it is. With the
// rule of the dead zone into the box around the ellipsoid, each channel by itself.
fn clip(old: vec4f, pixel: vec2i, radius: i32) -> vec4f {
    var sum = vec3f(0.0);
    var squares = vec3f(0.0);
    for (var dy = -radius; dy <= radius; dy += 1) {
        for (var dx = -radius; dx <= radius; dx += 1) {
            let neighbour = ycocg_from_rgb(pixels[index_of(clamped(pixel + vec2i(dx, dy)))].colour.rgb);
            sum += neighbour;
            squares += neighbour * neighbour;
        }
    }
    let count = f32((2 * radius + 1) * (2 * radius + 1));
    let mean = sum / count;
    let deviation = sqrt(max(squares / count - mean * mean, vec3f(0.0))) * CLIP_SIGMAS;
    let offset = ycocg_from_rgb(old.rgb) - mean;
    if temporal.alignment_rule == ALIGN_DEAD {
        return vec4f(rgb_from_ycocg(mean + clamp(offset, -deviation, deviation)), old.a);
    }
    // Length of the offset in standard deviations; an even neighbourhood leaves no room.
    let reach = length(offset / max(deviation, vec3f(LEAST_DEVIATION)));
    if reach <= 1.0 {
        return old;
    }
    return vec4f(rgb_from_ycocg(mean + offset / reach), old.a);
}

struct Fetched {
    colour: vec4f,
    is_inside: bool,
}

// History at a point in pixels (origin at the first pixel's centre).
fn fetch(at: vec2f) -> Fetched {
    let end = vec2f(temporal.size) - 0.5;
    if !(all(at > vec2f(-0.5)) && all(at < end)) {
        return Fetched(vec4f(0.0), false);
    }
    let low = floor(at);
    let share = at - low;
    let texel = vec2i(low);
    if all(share == vec2f(0.0)) {
        return Fetched(history[index_of(clamped(texel))], true);
    }
    // Catmull-Rom keeps edges that bilinear lookups would blur a little more in every frame.
    let wx = catmull_rom(share.x);
    let wy = catmull_rom(share.y);
    var sum = vec4f(0.0);
    for (var dy = 0; dy < 4; dy += 1) {
        for (var dx = 0; dx < 4; dx += 1) {
            sum += history[index_of(clamped(texel + vec2i(dx, dy) - 1))] * (wx[dx] * wy[dy]);
        }
    }
    return Fetched(max(sum, vec4f(0.0)), true);
}

// Weights of the four samples around a point at `s` between the middle two.
fn catmull_rom(s: f32) -> vec4f {
    let s2 = s * s;
    let s3 = s2 * s;
    return vec4f(
        0.5 * (-s3 + 2.0 * s2 - s),
        0.5 * (3.0 * s3 - 5.0 * s2 + 2.0),
        0.5 * (-3.0 * s3 + 4.0 * s2 + s),
        0.5 * (s3 - s2),
    );
}

// The nearest pixel inside the picture.
fn clamped(pixel: vec2i) -> vec2u {
    return vec2u(clamp(pixel, vec2i(0), vec2i(temporal.size) - 1));
}

fn ycocg_from_rgb(rgb: vec3f) -> vec3f {
    return vec3f(
        0.25 * rgb.r + 0.5 * rgb.g + 0.25 * rgb.b,
        0.5 * (rgb.r - rgb.b),
        -0.25 * rgb.r + 0.5 * rgb.g - 0.25 * rgb.b,
    );
}

fn rgb_from_ycocg(ycocg: vec3f) -> vec3f {
    return vec3f(ycocg.x + ycocg.y - ycocg.z, ycocg.x + ycocg.z, ycocg.x - ycocg.y - ycocg.z);
}
