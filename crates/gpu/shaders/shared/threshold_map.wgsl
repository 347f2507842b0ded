// The walk over the 3×3 maps: twins of sheer_core::threshold_map.
#import shared/tables

// The cell of a map that a pixel uses in a frame (STD Listing 4, `shift` and the modulo).
fn map_cell(pixel: vec2u, frame: u32) -> vec2u {
    let offset_y = frame / MAP_SIDE;
    let offset_x = select(frame % MAP_SIDE, MAP_SIDE - 1u - frame % MAP_SIDE, offset_y % 2u == 1u);
    return vec2u((pixel.x % MAP_SIDE + offset_x) % MAP_SIDE, (pixel.y % MAP_SIDE + offset_y % MAP_SIDE) % MAP_SIDE);
}

// The threshold, 0 to 8, that a map gives a pixel in a frame: Listing 4's `stratify`.
fn threshold_index(map: u32, pixel: vec2u, frame: u32) -> u32 {
    let cell = map_cell(pixel, frame);
    return tables[TABLE_STD_MAPS + map * THRESHOLD_COUNT + MAP_SIDE * cell.y + cell.x];
}
