// The 5×5 map of DTAA: twins of sheer_render's method/dtaa.rs (STD Listing 1).

// `stratify` of Listing 1, 0 to 4.
fn dtaa_stratum(pixel: vec2u, frame: u32) -> u32 {
    let cell = pixel % DTAA_SIDE + frame % DTAA_SIDE;
    return (cell.x + 2u * cell.y) % DTAA_SIDE;
}

// The last line of Listing 1, with the blue noise of a pixel.
fn dtaa_threshold(stratum: u32, noise: f32) -> f32 {
    return (f32(stratum) + noise) / f32(DTAA_SIDE);
}
