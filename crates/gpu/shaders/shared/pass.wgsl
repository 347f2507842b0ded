// What every pass that makes pixels writes.
#import struct/PixelRecord

@group(GROUP_PASS) @binding(BIND_PIXELS) var<storage, read_write> pixels: array<PixelRecord>;
@group(GROUP_PASS) @binding(BIND_COUNTERS) var<storage, read_write> counters: array<atomic<u32>>;
// What the one shaded fragment of each pixel is, for methods that have one: see shared/found.wgsl.
@group(GROUP_PASS) @binding(BIND_SURFACES) var<storage, read_write> surfaces: array<vec4u>;

// Column and row of the pixel that is being made; every entry point sets it.
var<private> pixel_at: vec2u;
