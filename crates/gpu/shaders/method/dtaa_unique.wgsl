// DTAA with its thresholds permuted for each object: twin of sheer_render's method/dtaa_unique.rs (STD
// sections 2.2 and 4).
#import shared/dtaa_map
#import shared/object_draw
#import shared/object_noise
#import shared/site
#import shared/tables

const USES_OBJECT_SPACE: bool = false;

fn threshold(site: Site) -> f32 {
    let permutation = draw_below(site, PERMUTATION_COUNT);
    let stratum = tables[TABLE_PERMUTATIONS + permutation * DTAA_SIDE + dtaa_stratum(site.pixel, site.frame)];
    return dtaa_threshold(stratum, object_noise(site));
}
