// What an object draws for itself: twin of sheer_render's method/object_draw.rs, of STD Listing 4's
// `getRandom3x3Map`.
#import shared/hash
#import shared/site

// A number in 0..count, each equally likely.
fn draw_below(site: Site, count: u32) -> u32 {
    return hashed_below(site, count, false);
}

// A second number in 0..count, independent of the first.
fn draw_second_below(site: Site, count: u32) -> u32 {
    return hashed_below(site, count, true);
}

fn hashed_below(site: Site, count: u32, second: bool) -> u32 {
    let back = select(0u, site.back, P_IDENTITY == P_IDENTITY_FACE);
    // The divisor of a shader without P_REHASH is never used, but a constant 0 would not compile.
    let cycle = site.frame / max(P_REHASH, 1u);
    if P_HASH == P_HASH_MCGUIRE {
        let shifted = f32(site.instance + site.seed);
        var drawn = mcguire3(vec3f(shifted, f32(site.geometry), f32(back)));
        if P_IDENTITY == P_IDENTITY_PRIMITIVE {
            drawn = mcguire2(vec2f(drawn, f32(site.primitive)));
        }
        if P_REHASH > 0u {
            drawn = mcguire2(vec2f(drawn, f32(cycle)));
        }
        if second {
            drawn = mcguire2(vec2f(drawn, f32(SECOND_DRAW)));
        }
        return min(u32(drawn * f32(count)), count - 1u);
    }
    var bits = pcg3d(vec3u(site.instance, (site.geometry << 1u) | back, site.seed)).x;
    if P_IDENTITY == P_IDENTITY_PRIMITIVE {
        bits = pcg2d(vec2u(bits, site.primitive)).x;
    }
    if P_REHASH > 0u {
        bits = pcg2d(vec2u(bits, cycle)).x;
    }
    if second {
        bits = pcg2d(vec2u(bits, SECOND_DRAW)).x;
    }
    // The high half of the product is uniform in 0..count (Lemire 2019).
    return mul_high(bits, count);
}
