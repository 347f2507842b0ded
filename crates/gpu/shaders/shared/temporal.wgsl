// What passes that add frames up read and write. They see pixels alone, so that group 0 is theirs.
#import shared/pixel

struct Temporal {
    // Pixels.
    size: vec2u,
    // How many frames the history holds.
    count: u32,
    // Side of the dithering pattern, pixels.
    alignment_px: u32,
    frame: u32,
    seed: u32,
    // An ALIGN_ constant.
    alignment_rule: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> temporal: Temporal;
@group(0) @binding(1) var<storage, read> pixels: array<PixelRecord>;
// Linear, premultiplied.
@group(0) @binding(2) var<storage, read> history: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> next_history: array<vec4f>;

fn index_of(pixel: vec2u) -> u32 {
    return pixel.y * temporal.size.x + pixel.x;
}
