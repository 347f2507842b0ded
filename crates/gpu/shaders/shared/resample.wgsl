// What techniques that reproject their history share: twin of crates/render/src/temporal/resample.rs.
#import shared/temporal_uniform

// A place in a history: the pixel to its upper left, and the way from there, 0 to 1.
struct Place {
    pixel: vec2i,
    share: vec2f,
    is_inside: bool,
}

// A point in pixels, origin at the first pixel's centre.
fn place_of(at: vec2f) -> Place {
    let end = vec2f(temporal.size) - 0.5;
    let low = floor(at);
    return Place(vec2i(low), at - low, all(at > vec2f(-0.5)) && all(at < end));
}

// Weight of the pixel at an offset in a bilinear lookup; 0 beyond the four pixels around.
fn bilinear(place: Place, offset: vec2i) -> f32 {
    let weights = max(1.0 - abs(vec2f(offset) - place.share), vec2f(0.0));
    return weights.x * weights.y;
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

// Luma, two differences of colour, and alpha: of linear premultiplied RGBA.
fn ycocga_from_rgba(rgba: vec4f) -> vec4f {
    return vec4f(
        0.25 * rgba.r + 0.5 * rgba.g + 0.25 * rgba.b,
        0.5 * (rgba.r - rgba.b),
        -0.25 * rgba.r + 0.5 * rgba.g - 0.25 * rgba.b,
        rgba.a,
    );
}

fn rgba_from_ycocga(ycocga: vec4f) -> vec4f {
    return vec4f(
        ycocga.x + ycocga.y - ycocga.z,
        ycocga.x + ycocga.z,
        ycocga.x - ycocga.y - ycocga.z,
        ycocga.w,
    );
}
