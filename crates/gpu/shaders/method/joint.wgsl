// Joint dithering: twin of sheer_render's method/joint.rs.
#import shared/hash
#import shared/noise_of_all
#import shared/threshold_map

fn selection_threshold(pixel: vec2u, frame_index: u32, seed: u32) -> f32 {
    // Another seed moves the pattern over the screen.
    let moved_pixel = pixel + pcg2d(vec2u(seed, 0u)) % SHIFT_PX;
    let stratum = threshold_index(0u, moved_pixel, frame_index);
    let cycle = select(0u, frame_index / CYCLE_FRAMES, P_CYCLE == P_CYCLE_GOLDEN);
    let moved = (cycle * GOLDEN_RATIO_BITS) >> (32u - OFFSET_BITS);
    let one = 1u << OFFSET_BITS;
    let offset = (u32(noise_of_all(moved_pixel) * f32(one)) + moved) % one;
    return (f32(stratum) + f32(offset) / f32(one)) / f32(THRESHOLD_COUNT);
}
