// Hashed alpha testing: twin of sheer_render's method/hashed.rs (Wyman and McGuire 2017).
#import shared/hash
#import shared/site

const USES_OBJECT_SPACE: bool = true;

// The blend of both cells' numbers, and the weight of the smaller cell.
struct Blend {
    value: f32,
    weight: f32,
}

// 2 to a whole number from -126 to 127, exactly, which exp2 need not be.
fn power_of_two(octave: i32) -> f32 {
    return bitcast<f32>(u32(octave + 127) << 23u);
}

// A whole number as `as i64 as u32` in Rust: modulo 2^32 within 64 bits, the nearest end outside.
fn wrapped_cell(whole: f32) -> u32 {
    let bits = bitcast<u32>(whole);
    // The number is the mantissa of 24 bits, moved to the left so far.
    let places = i32((bits >> 23u) & 0xffu) - 150;
    let is_negative = whole < 0.0;
    if places >= 40 {
        return select(~0u, 0u, is_negative);
    }
    if places <= 0 {
        return bitcast<u32>(i32(whole));
    }
    let mantissa = (bits & 0x7fffffu) | 0x800000u;
    let low = select(mantissa << (u32(places) & 31u), 0u, places >= 32);
    return select(low, 0u - low, is_negative);
}

fn draw_of_cell(site: Site, object: u32, octave: i32) -> f32 {
    let cell = floor(site.position_in_object * power_of_two(octave));
    let moment = pcg3d(vec3u(object, site.frame, bitcast<u32>(octave))).x;
    return unit_from_bits(pcg4d(vec4u(wrapped_cell(cell.x), wrapped_cell(cell.y), wrapped_cell(cell.z), moment)).w);
}

fn blend(site: Site) -> Blend {
    // Cells in an object unit, as an octave. Bounded before the logarithm, too, as a shader may make anything
    // of those of 0 and infinity.
    let footprint = clamp(site.footprint_in_object * P_SCALE, exp2(-MAX_LEVEL), exp2(MAX_LEVEL));
    let level = clamp(-log2(footprint), -MAX_LEVEL, MAX_LEVEL);
    let larger = floor(level);
    let object = pcg3d(vec3u(site.instance, (site.geometry << 1u) | site.back, site.seed)).x;
    let larger_draw = draw_of_cell(site, object, i32(larger));
    let smaller_draw = draw_of_cell(site, object, i32(larger) + 1);
    let weight = level - larger;
    return Blend((1.0 - weight) * larger_draw + weight * smaller_draw, weight);
}

// The cumulative distribution of `(1 - weight) A + weight B` for uniform A and B, at `value`.
fn uniform_from_blend(value: f32, weight: f32) -> f32 {
    let ramp = min(weight, 1.0 - weight);
    if value < ramp {
        return value * value / (2.0 * ramp * (1.0 - ramp));
    }
    if value <= 1.0 - ramp {
        return (value - 0.5 * ramp) / (1.0 - ramp);
    }
    let rest = 1.0 - value;
    return 1.0 - rest * rest / (2.0 * ramp * (1.0 - ramp));
}

fn threshold(site: Site) -> f32 {
    let mixed = blend(site);
    return min(uniform_from_blend(mixed.value, mixed.weight), BELOW_ONE);
}
