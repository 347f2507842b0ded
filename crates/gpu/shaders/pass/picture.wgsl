// The picture so far into a texture of the caller's: one triangle over all of it.
#import shared/temporal_uniform

@group(GROUP_TEMPORAL) @binding(BIND_HISTORY) var<storage, read> history: array<vec4f>;

@vertex
fn vs_picture(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(vec2u(index & 1u, index >> 1u));
    return vec4f(corner * 4.0 - 1.0, 0.0, 1.0);
}

// Linear and premultiplied; what the texture has beyond the picture stays.
@fragment
fn fs_picture(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    if any(pixel >= temporal.size) {
        discard;
    }
    return history[pixel.y * temporal.size.x + pixel.x];
}
