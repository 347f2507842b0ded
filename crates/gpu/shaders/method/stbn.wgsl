// Spatio-temporal blue noise: twin of sheer_render's method/stbn.rs and sheer_core::spatio_temporal (Wolfe et
// al. 2022; STD section 7.2).
#import shared/object_draw
#import shared/site
#import shared/tables

const USES_OBJECT_SPACE: bool = false;

// (rank + 0.5) / RANK_COUNT at a column and row of the plane and in a frame: the mask tiles all three.
fn rank_value(pixel: vec2u, frame: u32) -> f32 {
    let at = (frame % RANK_FRAMES * RANK_SIDE + pixel.y % RANK_SIDE) * RANK_SIDE + pixel.x % RANK_SIDE;
    return (f32(tables[TABLE_RANKS + at]) + 0.5) / f32(RANK_COUNT);
}

fn threshold(site: Site) -> f32 {
    let start = draw_below(site, RANK_COUNT);
    let offset = vec2u(start, start / RANK_SIDE) % RANK_SIDE;
    return rank_value(site.pixel % RANK_SIDE + offset, site.frame + start / (RANK_SIDE * RANK_SIDE));
}
