// The plain mean of frames of one moment: twin of crates/render/src/temporal/accumulate.rs.
#import shared/temporal

fn resolved(pixel: vec2u, current: PixelRecord) -> vec4f {
    // What was there before a history began anew is no part of it, not even by its rounding.
    if temporal.count == 0u {
        return current.colour;
    }
    let weight = 1.0 / (f32(temporal.count) + 1.0);
    let mean = history[index_of(pixel)];
    return mean + (current.colour - mean) * weight;
}
