// The visibility buffer (STD section 3.5): 16 bytes a pixel that say what to shade there.
#import shared/triangles

struct Visible {
    // Triangle, which stands for instance and primitive; the weights of its second and third vertex, as bits;
    // 1 for the front.
    @location(0) surface: vec4u,
    @builtin(frag_depth) depth: f32,
}

fn visible(hit: Hit) -> Visible {
    let surface = vec4u(hit.triangle, bitcast<u32>(hit.u), bitcast<u32>(hit.v), select(0u, 1u, hit.front));
    return Visible(surface, depth_in_buffer(hit));
}
