// What a stochastic ray found.
#import shared/hit

struct Found {
    found: bool,
    hit: Hit,
    // Whether the ray met something that is neither opaque nor nothing on its way.
    transparent: bool,
    // It found one of the fragments that a full list had no node for: of those only the mean colour is known.
    is_tail: bool,
    tail_rgb: vec3f,
}

// Bits of a surface's last word.
const SURFACE_FRONT: u32 = 1u;
const SURFACE_TRANSPARENT: u32 = 2u;
const SURFACE_TAIL: u32 = 4u;
// What is seen is kept as it is behind the glass in front of it.
const SURFACE_BEHIND_GLASS: u32 = 8u;

// In 16 bytes: triangle, weights of its second and third vertex, flags; of a tail the colour in place of the
// weights, and no triangle.
fn surface_from_found(found: Found) -> vec4u {
    var flags = select(0u, SURFACE_TRANSPARENT, found.transparent);
    if found.is_tail {
        let colour = vec2u(pack2x16float(found.tail_rgb.xy), pack2x16float(vec2f(found.tail_rgb.z, 0.0)));
        return vec4u(NONE, colour, flags | SURFACE_TAIL);
    }
    if !found.found {
        return vec4u(NONE, 0u, 0u, flags);
    }
    flags |= select(0u, SURFACE_FRONT, found.hit.front);
    return vec4u(found.hit.triangle, bitcast<u32>(found.hit.u), bitcast<u32>(found.hit.v), flags);
}

// The same back, but for the distance, which nobody asks for any more.
fn found_from_surface(surface: vec4u) -> Found {
    let is_tail = (surface.w & SURFACE_TAIL) != 0u;
    let is_front = (surface.w & SURFACE_FRONT) != 0u;
    let hit = Hit(0.0, bitcast<f32>(surface.y), bitcast<f32>(surface.z), surface.x, is_front);
    let rgb = vec3f(unpack2x16float(surface.y), unpack2x16float(surface.z).x);
    return Found(surface.x != NONE, hit, (surface.w & SURFACE_TRANSPARENT) != 0u, is_tail, rgb);
}
