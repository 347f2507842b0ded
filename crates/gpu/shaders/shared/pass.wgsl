// What every pass that makes pixels writes.
#import shared/pixel

@group(1) @binding(0) var<storage, read_write> pixels: array<PixelRecord>;
@group(1) @binding(1) var<storage, read_write> counters: array<atomic<u32>>;
// What the one shaded fragment of each pixel is, for methods that have one: see shared/found.wgsl.
@group(1) @binding(5) var<storage, read_write> surfaces: array<vec4u>;

// Column and row of the pixel that is being made; every entry point sets it.
var<private> pixel_at: vec2u;
