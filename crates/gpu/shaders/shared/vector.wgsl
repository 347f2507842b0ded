// Vector arithmetic as glam and Rust's `f32` have it.

// (a + b) + c. WGSL lets compilers add the last two first, which rounds otherwise, and Mesa's does; through
// negations it does not.
fn sum_in_order(a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    return -(-c - (a + b));
}

// WGSL's own may go by a reciprocal root, whose last bit would order surfaces that all but coincide in
// another way.
fn normalized(vector: vec3f) -> vec3f {
    return vector * (1.0 / sqrt(dot(vector, vector)));
}

fn normalize_or(vector: vec3f, otherwise: vec3f) -> vec3f {
    let square = dot(vector, vector);
    // A length whose reciprocal is a finite normal number; WGSL knows no infinity to test for.
    if square >= LEAST_NORMAL && square <= GREATEST {
        return normalized(vector);
    }
    return otherwise;
}

// 1 or -1, of zero by its sign: WGSL's `sign` has a third value.
fn signum(value: f32) -> f32 {
    return select(1.0, -1.0, (bitcast<u32>(value) >> 31u) != 0u);
}

fn lerp(first: vec3f, second: vec3f, weight: f32) -> vec3f {
    return first * (1.0 - weight) + second * weight;
}

// Mean of red, green and blue; of three that are the same it is that, to the bit.
fn mean_channel(rgb: vec3f) -> f32 {
    return rgb.x + ((rgb.y - rgb.x) + (rgb.z - rgb.x)) / 3.0;
}

fn max_element(vector: vec3f) -> f32 {
    return max(max(vector.x, vector.y), vector.z);
}
