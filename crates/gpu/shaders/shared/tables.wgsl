// All tables in one buffer, made by crates/gpu/src/tables.rs; TABLE_ constants say where each begins.
@group(GROUP_SCENE) @binding(BIND_TABLES) var<storage, read> tables: array<u32>;

// The blue noise of a pixel, in (0, 1): BlueNoise64x64Tex[pixel % 64] of STD Listings 1 and 4.
fn blue_noise_at(pixel: vec2u) -> f32 {
    let at = pixel % BLUE_NOISE_SIDE;
    return bitcast<f32>(tables[TABLE_BLUE_NOISE + at.y * BLUE_NOISE_SIDE + at.x]);
}

// The linear value of a byte, sRGB-encoded (1) or not (0).
fn decoded(byte: u32, srgb: u32) -> f32 {
    return bitcast<f32>(tables[TABLE_DECODE + 256u * srgb + byte]);
}
