// Dither Temporal AA: twin of sheer_render's method/dtaa.rs (STD section 2.2, Listing 1).
#import shared/dtaa_map
#import shared/noise_of_all
#import shared/site

const USES_OBJECT_SPACE: bool = false;

fn threshold(site: Site) -> f32 {
    // A seed moves the whole pattern sideways.
    let pixel = vec2u(site.pixel.x + site.seed % DTAA_PERIOD_PX, site.pixel.y);
    return dtaa_threshold(dtaa_stratum(pixel, site.frame), noise_of_all(pixel));
}
