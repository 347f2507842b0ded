// Rays drop nothing.

// Light and opacity of the fragments that had no memory, premultiplied.
fn tail(pixel: vec2u) -> vec4f {
    return vec4f(0.0);
}
