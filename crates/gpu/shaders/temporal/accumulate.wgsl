// The plain mean of frames of one moment: twin of crates/render/src/temporal/accumulate.rs.
#import shared/temporal

fn resolved(pixel: vec2u, current: PixelRecord) -> vec4f {
    let weight = 1.0 / (f32(temporal.count) + 1.0);
    let mean = history[index_of(pixel)];
    return mean + (current.colour - mean) * weight;
}
