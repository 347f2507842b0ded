// Spatio-temporal dithering: twin of sheer_render's method/std.rs (STD section 3.3, Listing 4).
#import shared/object_draw
#import shared/object_noise
#import shared/site
#import shared/threshold_map

const USES_OBJECT_SPACE: bool = false;

fn threshold(site: Site) -> f32 {
    let map = draw_below(site, MAP_COUNT);
    let stratum = threshold_index(map, site.pixel, site.frame);
    return (f32(stratum) + object_noise(site)) / f32(THRESHOLD_COUNT);
}
