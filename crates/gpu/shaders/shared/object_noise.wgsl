// The static blue noise of a hit: twin of `Noise::of_hit` in sheer_render's method/static_noise.rs.
#import shared/noise_of_all
#import shared/object_draw
#import shared/site

// In (0, 1), for each object from an offset of its own where the method is asked for that.
fn object_noise(site: Site) -> f32 {
    var pixel = site.pixel;
    if P_NOISE == P_NOISE_OBJECT {
        let place = draw_second_below(site, BLUE_NOISE_SIDE * BLUE_NOISE_SIDE);
        pixel = pixel % BLUE_NOISE_SIDE + vec2u(place % BLUE_NOISE_SIDE, place / BLUE_NOISE_SIDE);
    }
    return noise_of_all(pixel);
}
