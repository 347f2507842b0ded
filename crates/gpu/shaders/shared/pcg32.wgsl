// The random stream of `sheer_core::hash::Pcg32` (O'Neill 2014). Numbers of 64 bits are two words, the low
// one first.
#import shared/hash

var<private> pcg32_state: vec2u;
var<private> pcg32_increment: vec2u;

fn add64(a: vec2u, b: vec2u) -> vec2u {
    let low = a.x + b.x;
    return vec2u(low, a.y + b.y + select(0u, 1u, low < a.x));
}

fn mul64(a: vec2u, b: vec2u) -> vec2u {
    return vec2u(a.x * b.x, mul_high(a.x, b.x) + a.x * b.y + a.y * b.x);
}

// By 1 to 31 places.
fn shift_right64(v: vec2u, places: u32) -> vec2u {
    return vec2u((v.x >> places) | (v.y << (32u - places)), v.y >> places);
}

fn splitmix64(seed: vec2u) -> vec2u {
    var v = add64(seed, SPLITMIX64_STEP);
    v = mul64(v ^ shift_right64(v, 30u), SPLITMIX64_FACTOR_0);
    v = mul64(v ^ shift_right64(v, 27u), SPLITMIX64_FACTOR_1);
    return v ^ shift_right64(v, 31u);
}

// Starts the stream number `stream` of the family `seed`.
fn begin_pcg32(seed: vec2u, stream: u32) {
    let mixed = splitmix64(add64(splitmix64(seed), vec2u(stream, 0u)));
    let sequence = splitmix64(mixed);
    pcg32_state = vec2u(0u);
    pcg32_increment = vec2u((sequence.x << 1u) | 1u, (sequence.y << 1u) | (sequence.x >> 31u));
    next_u32();
    pcg32_state = add64(pcg32_state, mixed);
    next_u32();
}

// The next 32 random bits.
fn next_u32() -> u32 {
    let old = pcg32_state;
    pcg32_state = add64(mul64(old, PCG32_MULTIPLIER), pcg32_increment);
    let shifted = shift_right64(shift_right64(old, 18u) ^ old, 27u).x;
    let places = old.y >> 27u;
    return (shifted >> places) | (shifted << ((32u - places) & 31u));
}

// The next number in [0, 1).
fn next_f32() -> f32 {
    return unit_from_bits(next_u32());
}

// The next whole number below `count`, which is not 0, each equally likely.
fn next_below(count: u32) -> u32 {
    let unfair = (0u - count) % count;
    var bits = next_u32();
    while bits * count < unfair {
        bits = next_u32();
    }
    return mul_high(bits, count);
}
