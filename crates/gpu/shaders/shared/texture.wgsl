// Texture lookup, bilinear in linear light: twin of crates/scene/src/texture.rs.
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
struct Footprint {
    texels: array<vec4u, 4>,
    weights: vec2f,
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

fn footprint(texture: u32, uv: vec2f) -> Footprint {
    let size = vec2i(textures[texture].size);
    let wrap = textures[texture].wrap;
    let filtering = textures[texture].filtering;
    let columns = neighbours(uv.x, size.x, wrap.x, filtering);
    let rows = neighbours(uv.y, size.y, wrap.y, filtering);
    let x = textures[texture].origin.x + columns.texels;
    let y = textures[texture].origin.y + rows.texels;
    let layer = textures[texture].layer;
    return Footprint(
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

// The texture at a point, bilinear: linear RGBA, straight.
fn sample(texture: u32, uv: vec2f) -> vec4f {
    let around = footprint(texture, uv);
    let srgb = textures[texture].srgb != 0u;
    let upper = lerp_texels(
        linear_texel(around.texels[0], srgb), linear_texel(around.texels[1], srgb), around.weights.x,
    );
    let lower = lerp_texels(
        linear_texel(around.texels[2], srgb), linear_texel(around.texels[3], srgb), around.weights.x,
    );
    return lerp_texels(upper, lower, around.weights.y);
}

// Alpha, 0 to 1.
fn sample_alpha(texture: u32, uv: vec2f) -> f32 {
    let around = footprint(texture, uv);
    let a = f32(around.texels[0].a);
    let b = f32(around.texels[1].a);
    let c = f32(around.texels[2].a);
    let d = f32(around.texels[3].a);
    let upper = a + (b - a) * around.weights.x;
    let lower = c + (d - c) * around.weights.x;
    return (upper + (lower - upper) * around.weights.y) * (1.0 / 255.0);
}
