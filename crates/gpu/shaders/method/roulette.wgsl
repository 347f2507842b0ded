// Russian roulette: twin of sheer_render's method/roulette.rs (STD section 3.2, Listing 3).
#import shared/hash
#import shared/site

const USES_OBJECT_SPACE: bool = false;

fn threshold(site: Site) -> f32 {
    if P_HASH == P_HASH_MCGUIRE {
        let seed = f32(site.seed % MCGUIRE_SEEDS) * MCGUIRE_SEED_STEP;
        return mcguire4(vec4f(site.position, f32(site.frame) + seed));
    }
    let object = pcg(site.geometry ^ rotate_left(site.seed, 16u)) + site.instance;
    let bits = pcg4d(vec4u(site.pixel.x | (site.pixel.y << 16u), site.frame, object, site.primitive)).w;
    return unit_from_bits(bits);
}
