// Twins of sheer_core::hash. WGSL's u32 wraps around as `wrapping_mul` and `wrapping_add` do.

fn lcg(v: u32) -> u32 {
    return v * LCG_MULTIPLIER + LCG_INCREMENT;
}

// Hash of one number, a bijection: Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9 (3), 2020.
fn pcg(v: u32) -> u32 {
    let state = v * PCG_MULTIPLIER + PCG_INCREMENT;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * PCG_OUTPUT_MULTIPLIER;
    return (word >> 22u) ^ word;
}

fn pcg2d(v: vec2u) -> vec2u {
    var x = lcg(v.x);
    var y = lcg(v.y);
    x += y * LCG_MULTIPLIER;
    y += x * LCG_MULTIPLIER;
    x ^= x >> 16u;
    y ^= y >> 16u;
    x += y * LCG_MULTIPLIER;
    y += x * LCG_MULTIPLIER;
    return vec2u(x ^ (x >> 16u), y ^ (y >> 16u));
}

fn pcg3d(v: vec3u) -> vec3u {
    var x = lcg(v.x);
    var y = lcg(v.y);
    var z = lcg(v.z);
    x += y * z;
    y += z * x;
    z += x * y;
    x ^= x >> 16u;
    y ^= y >> 16u;
    z ^= z >> 16u;
    x += y * z;
    y += z * x;
    z += x * y;
    return vec3u(x, y, z);
}

fn pcg4d(v: vec4u) -> vec4u {
    var x = lcg(v.x);
    var y = lcg(v.y);
    var z = lcg(v.z);
    var w = lcg(v.w);
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
    x ^= x >> 16u;
    y ^= y >> 16u;
    z ^= z >> 16u;
    w ^= w >> 16u;
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
    return vec4u(x, y, z, w);
}

fn rotate_left(v: u32, places: u32) -> u32 {
    return (v << places) | (v >> (32u - places));
}

// Random bits as a number in [0, 1): the top 24 bits, which an f32 holds exactly.
fn unit_from_bits(bits: u32) -> f32 {
    return f32(bits >> 8u) * UNIT_STEP;
}

// The high half of a product of 64 bits, schoolbook on halves of 16 bits: `(u64::from(a) * u64::from(b)) >>
// 32`.
fn mul_high(a: u32, b: u32) -> u32 {
    let low_low = (a & 0xffffu) * (b & 0xffffu);
    let low_high = (a & 0xffffu) * (b >> 16u);
    let high_low = (a >> 16u) * (b & 0xffffu);
    let high_high = (a >> 16u) * (b >> 16u);
    // At most 3 · (2^16 - 1): the carry into the high half.
    let middle = (low_low >> 16u) + (low_high & 0xffffu) + (high_low & 0xffffu);
    return high_high + (low_high >> 16u) + (high_low >> 16u) + (middle >> 16u);
}

// McGuire's hash (The Graphics Codex 2.13; STD appendix, Listing 6). Its bits are those of the device's sine.
fn mcguire2(v: vec2f) -> f32 {
    let weight = MCGUIRE_LEAST + abs(sin(MCGUIRE_Y_OF_WEIGHT * v.y + v.x));
    return fract_below_one(MCGUIRE_GAIN * sin(MCGUIRE_X * v.x + MCGUIRE_Y * v.y) * weight);
}

fn mcguire3(v: vec3f) -> f32 {
    return mcguire2(vec2f(mcguire2(v.xy), v.z));
}

fn mcguire4(v: vec4f) -> f32 {
    return mcguire2(vec2f(mcguire2(v.xy), mcguire2(v.zw)));
}

fn fract_below_one(v: f32) -> f32 {
    return min(v - floor(v), BELOW_ONE);
}
