// The tail of methods that go by rays: a further ray finds what a traversal had no memory for, so nothing is
// left over.

// Light and opacity of the fragments that had no memory, premultiplied.
fn tail(pixel: vec2u) -> vec4f {
    return vec4f(0.0);
}
