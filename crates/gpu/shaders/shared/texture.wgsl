// Texture lookup with a footprint, trilinear in linear light: twin of crates/scene/src/texture.rs.
//
// Hardware filters with weights of 8 bits, and a filtered alpha would differ from the CPU's in the third
// digit.
#import shared/tables
#import struct/Texture

@group(GROUP_SCENE) @binding(BIND_TEXTURES) var<storage, read> textures: array<Texture>;
@group(GROUP_SCENE) @binding(BIND_ATLAS) var atlas: texture_2d_array<u32>;

// The two texels on either side of a lookup, wrapped into the image, and the weight of the second.
struct Neighbours {
    texels: vec2u,
    weight: f32,
}

// The four texels around a point, row by row, and the weights of the right and the lower ones.
struct Around {
    texels: array<vec4u, 4>,
    weights: vec2f,
}

// What a lookup sees of a texture: an ellipse, taken for a strip.
struct Footprint {
    // Its longer axis from end to end, texture coordinates.
    axis: vec2f,
    // How long that is, texels.
    length: f32,
    // How wide it is, texels; no more than its length.
    width: f32,
}

// The level to look up, and the weight of the next one; 0 where there is none.
struct Levels {
    level: u32,
    weight: f32,
}

// As wide as it is long, texels.
fn round_footprint(width: f32) -> Footprint {
    return Footprint(vec2f(0.0), width, width);
}

// The level whose texels are next in size below a footprint of more than one texel, and the weight of the
// level after it.
fn level_of(footprint: f32) -> Levels {
    let bits = bitcast<u32>(footprint);
    let mantissa = bitcast<f32>((bits & 0x007fffffu) | 0x3f800000u);
    return Levels((bits >> 23u) - 127u, mantissa - 1.0);
}

// For a footprint of at least a texel.
fn levels_of(texture: u32, footprint: f32) -> Levels {
    var found = level_of(footprint);
    switch textures[texture].level_filtering {
        case LEVELS_NEAREST: {
            found = Levels(found.level + select(0u, 1u, found.weight > NEXT_LEVEL), 0.0);
        }
        case LEVELS_NONE: {
            found = Levels(0u, 0.0);
        }
        default: {
        }
    }
    let last = textures[texture].last_level;
    if found.level < last {
        return found;
    }
    return Levels(last, 0.0);
}

// The record that says where a level lies.
fn place_of(texture: u32, level: u32) -> u32 {
    return select(textures[texture].first_level + level - 1u, texture, level == 0u);
}

fn neighbours(coordinate: f32, size: i32, wrap: u32, filtering: u32) -> Neighbours {
    let position = coordinate * f32(size);
    if filtering == FILTER_NEAREST {
        let texel = wrapped(floor_to_integer(position), size, wrap);
        return Neighbours(vec2u(texel, texel), 0.0);
    }
    let low = floor_to_integer(position - 0.5);
    let texels = vec2u(wrapped(low, size, wrap), wrapped(low + 1, size, wrap));
    return Neighbours(texels, position - 0.5 - f32(low));
}

// Any texel index as one inside the image.
fn wrapped(texel: i32, size: i32, wrap: u32) -> u32 {
    if u32(texel) < u32(size) {
        return u32(texel);
    }
    if wrap == WRAP_CLAMP_TO_EDGE {
        return u32(clamp(texel, 0, size - 1));
    }
    if wrap == WRAP_MIRRORED_REPEAT {
        let turn = remainder(texel, 2 * size);
        return u32(select(2 * size - 1 - turn, turn, turn < size));
    }
    return u32(remainder(texel, size));
}

// Euclid's: 0 to below the divisor.
fn remainder(value: i32, divisor: i32) -> i32 {
    let rest = value % divisor;
    return select(rest, rest + divisor, rest < 0);
}

// The next lower whole number. What is beyond an i32 becomes its nearest one, which saves the conversion from
// being undefined.
fn floor_to_integer(value: f32) -> i32 {
    let inside = clamp(value, -2147483648.0, 2147483520.0);
    let truncated = i32(inside);
    return truncated - select(0, 1, f32(truncated) > inside);
}

fn around(texture: u32, level: u32, uv: vec2f, filtering: u32) -> Around {
    let place = place_of(texture, level);
    let size = vec2i(textures[place].size);
    let wrap = textures[texture].wrap;
    let columns = neighbours(uv.x, size.x, wrap.x, filtering);
    let rows = neighbours(uv.y, size.y, wrap.y, filtering);
    let x = textures[place].origin.x + columns.texels;
    let y = textures[place].origin.y + rows.texels;
    let layer = textures[place].layer;
    return Around(
        array<vec4u, 4>(
            textureLoad(atlas, vec2u(x.x, y.x), layer, 0),
            textureLoad(atlas, vec2u(x.y, y.x), layer, 0),
            textureLoad(atlas, vec2u(x.x, y.y), layer, 0),
            textureLoad(atlas, vec2u(x.y, y.y), layer, 0),
        ),
        vec2f(columns.weight, rows.weight),
    );
}

fn linear_texel(texel: vec4u, srgb: bool) -> vec4f {
    let encoding = select(0u, 1u, srgb);
    return vec4f(
        decoded(texel.r, encoding),
        decoded(texel.g, encoding),
        decoded(texel.b, encoding),
        f32(texel.a) / 255.0,
    );
}

fn lerp_texels(first: vec4f, second: vec4f, weight: f32) -> vec4f {
    return first * (1.0 - weight) + second * weight;
}

// The texture at a point: linear RGBA, straight. A long footprint is covered by several lookups side by side,
// each as long as the footprint is wide, if MOST_PROBES are enough for that. Probes and levels in loops: a
// driver that inlines everything compiles the lookup once.
fn sample(texture: u32, uv: vec2f, footprint: Footprint) -> vec4f {
    var probes = 1u;
    var first = uv;
    var step = vec2f(0.0);
    var found = Levels(0u, 0.0);
    var filtering = textures[texture].filtering;
    if footprint.length > 1.0 {
        let probe = max(max(footprint.width, footprint.length / f32(MOST_PROBES)), 1.0);
        let gap = (footprint.length - probe) / (footprint.length * f32(MOST_PROBES - 1u));
        if gap >= LEAST_GAP && textures[texture].level_filtering != LEVELS_NONE {
            probes = MOST_PROBES;
            // From one end to the other, the middle of all in the middle.
            first = uv - footprint.axis * (0.5 * f32(MOST_PROBES - 1u) * gap);
            step = footprint.axis * gap;
        }
        found = levels_of(texture, probe);
        filtering = textures[texture].minified_filtering;
    }
    var sum = vec4f(0.0);
    for (var index = 0u; index < probes; index++) {
        var texel = vec4f(0.0);
        for (var next = 0u; next < 2u; next++) {
            let other = level_texel(texture, found.level + next, first + step * f32(index), filtering);
            texel = lerp_texels(texel, other, select(found.weight, 1.0, next == 0u));
            if found.weight == 0.0 {
                break;
            }
        }
        sum += texel;
    }
    return sum * (1.0 / f32(probes));
}

fn level_texel(texture: u32, level: u32, uv: vec2f, filtering: u32) -> vec4f {
    let found = around(texture, level, uv, filtering);
    let srgb = textures[texture].srgb != 0u;
    let upper = lerp_texels(
        linear_texel(found.texels[0], srgb), linear_texel(found.texels[1], srgb), found.weights.x,
    );
    let lower = lerp_texels(
        linear_texel(found.texels[2], srgb), linear_texel(found.texels[3], srgb), found.weights.x,
    );
    return lerp_texels(upper, lower, found.weights.y);
}

// Alpha, 0 to 1, with a footprint as wide as it is long, texels.
fn sample_alpha(texture: u32, uv: vec2f, footprint: f32) -> f32 {
    var found = Levels(0u, 0.0);
    var filtering = textures[texture].filtering;
    if footprint > 1.0 {
        found = levels_of(texture, footprint);
        filtering = textures[texture].minified_filtering;
    }
    var alpha = 0.0;
    for (var next = 0u; next < 2u; next++) {
        let other = level_alpha(texture, found.level + next, uv, filtering);
        alpha = select(alpha + (other - alpha) * found.weight, other, next == 0u);
        if found.weight == 0.0 {
            break;
        }
    }
    return alpha;
}

fn level_alpha(texture: u32, level: u32, uv: vec2f, filtering: u32) -> f32 {
    let found = around(texture, level, uv, filtering);
    let a = f32(found.texels[0].a);
    let b = f32(found.texels[1].a);
    let c = f32(found.texels[2].a);
    let d = f32(found.texels[3].a);
    let upper = a + (b - a) * found.weights.x;
    let lower = c + (d - c) * found.weights.x;
    return (upper + (lower - upper) * found.weights.y) * (1.0 / 255.0);
}
