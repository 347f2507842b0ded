// The nearest opaque surface of each pixel, which pass/opaque.wgsl has drawn.
#import shared/triangles

// Triangle and, as bits, the weights of its second and third vertex; NONE where there is nothing opaque.
@group(GROUP_OWN) @binding(BIND_OPAQUE_SURFACES) var opaque_surfaces: texture_2d<u32>;

struct OpaqueSurface {
    found: bool,
    hit: Hit,
}

fn opaque_surface(pixel: vec2u) -> OpaqueSurface {
    let triangle = textureLoad(opaque_surfaces, pixel, 0).x;
    if triangle == NONE {
        return OpaqueSurface(false, Hit());
    }
    return OpaqueSurface(true, fragment_hit(pixel, triangle));
}

// Whether something opaque hides a hit.
fn is_hidden(pixel: vec2u, hit: Hit) -> bool {
    let surface = opaque_surface(pixel);
    return surface.found && is_behind(hit, surface.hit);
}
