// Which samples of a pixel a transparent fragment covers: twins of sheer_core::mask for up to 32 samples,
// whose masks are one word, the low one of the masks there.
#import shared/hash
#import shared/tables

// An opacity, 0 to 1, in ALPHA_BITS, rounded up or down as random bits say: right on average.
fn quantised_alpha(alpha: f32, bits: u32) -> u32 {
    let exact = alpha * f32(OPAQUE_ALPHA);
    return u32(exact) + u32(unit_from_bits(bits) < fract(exact));
}

// How many of `samples` are covered (ST section 3.1), with alpha and xi in ALPHA_BITS.
fn set_size(alpha: u32, samples: u32, xi: u32) -> u32 {
    return (alpha * samples + xi) >> ALPHA_BITS;
}

// Naive sampling: each sample by itself with the probability of an opacity in ALPHA_BITS.
fn coin_mask(alpha: u32, seed: vec2u) -> u32 {
    if alpha >= OPAQUE_ALPHA {
        return ~0u;
    }
    // From the lowest digit of alpha up: OR with a fair coin takes p to (p + 1) / 2, AND to p / 2, for all
    // samples at once.
    var mask = 0u;
    for (var digit = 0u; digit < ALPHA_BITS; digit++) {
        let coins = pcg2d(vec2u(seed.x, seed.y + digit)).x;
        mask = select(mask & coins, mask | coins, ((alpha >> digit) & 1u) == 1u);
    }
    return mask;
}

// A subset of `size` of MASK_SAMPLES samples, chosen by random bits: `MaskTable::pick`.
fn mask_pick(size: u32, bits: u32) -> u32 {
    return tables[TABLE_MASKS + size * MASK_WIDTH + mul_high(bits, MASK_WIDTH)];
}

// A subset of `size` of the rounds in which the samples are drawn: the same.
fn round_pick(size: u32, bits: u32) -> u32 {
    return tables[TABLE_ROUND_MASKS + size * MASK_WIDTH + mul_high(bits, MASK_WIDTH)];
}

fn spread(coordinate: u32) -> u32 {
    var bits = coordinate % CURVE_SIDE;
    bits = (bits | (bits << 8u)) & 0x00ff00ffu;
    bits = (bits | (bits << 4u)) & 0x0f0f0f0fu;
    bits = (bits | (bits << 2u)) & 0x33333333u;
    return (bits | (bits << 1u)) & 0x55555555u;
}

// The position of a pixel along a Z-curve through CURVE_SIDE² pixels, in 20 bits (Morton 1966).
fn along_curve(pixel: vec2u) -> u32 {
    return spread(pixel.x) | (spread(pixel.y) << 1u);
}

// The threshold, as a fraction of 2^32, of the sample with a position along a curve (Laine and Karras 2011,
// section 3.1).
fn stratified_threshold(position: u32, surface: u32) -> u32 {
    var x = reverseBits(position) + surface;
    x ^= x * SCRAMBLE_0;
    x ^= x * SCRAMBLE_1;
    x ^= x * SCRAMBLE_2;
    return x ^ (x * SCRAMBLE_3);
}
