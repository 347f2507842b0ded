// What the function `composited` of method/*.wgsl makes of the transparent fragments of a pixel.
#import shared/hit

struct Composited {
    rgb_premul: vec3f,
    // What is seen of the background.
    transmittance: f32,
    // Whether there is any fragment.
    transparent: bool,
    // The fragment that is furthest away, where the method can tell.
    has_furthest: bool,
    furthest: Hit,
}
