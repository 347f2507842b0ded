// Which samples a fragment covers by chance: twin of crates/render/src/method/stochastic/masks.rs.
//
// The method's samples come in ROUND_COUNT rounds of MASK_SAMPLES each, as many as a pixel of the targets
// has.
#import shared/frame
#import shared/hash
#import shared/mask
#import shared/tables

// What the mask of a fragment depends on.
struct MaskSite {
    pixel: vec2u,
    // InstanceID() of STD Listing 4, GeometryIndex(), PrimitiveIndex().
    instance: u32,
    geometry: u32,
    primitive: u32,
    // HitKind(): 0 front, 1 back.
    back: u32,
    // Along the view axis, scene units.
    depth: f32,
    // Opacity, 0 to 1.
    alpha: f32,
}

// Who draws a mask of its own (ST section 6), in one frame of one run.
fn surface_of(site: MaskSite) -> u32 {
    var who = vec3u(site.instance, (site.geometry << 1u) | site.back, site.primitive);
    if P_SEED_BY == P_SEED_BY_OBJECT {
        who.z = ~0u;
    } else if P_SEED_BY == P_SEED_BY_DEPTH {
        who = vec3u(bitcast<u32>(site.depth), site.back, ~0u);
    }
    let index = select(0u, frame.index, P_RESEED == P_RESEED_ON);
    return pcg3d(vec3u(pcg3d(who).x, index, frame.seed)).x;
}

// Four random numbers of a surface in a pixel.
fn in_pixel(pixel: vec2u, surface: u32) -> vec4u {
    return pcg4d(vec4u(pixel.x | (pixel.y << 16u), surface, frame.seed, 0u));
}

// Xi from blue noise, for each surface from another part of it.
fn tiled_xi(pixel: vec2u, surface: u32) -> u32 {
    return u32(blue_noise_at(pixel + pcg2d(vec2u(surface, frame.seed))) * f32(OPAQUE_ALPHA));
}

// A round's part of a subset over the samples of all rounds (ST footnotes 3 and 4).
fn size_in_round(size: u32, round: u32, bits: u32) -> u32 {
    if ROUND_COUNT == 1u {
        return size;
    }
    let rounds_with_more = round_pick(size % ROUND_COUNT, bits);
    return size / ROUND_COUNT + ((rounds_with_more >> round) & 1u);
}

// The mask of a fragment in one of the rounds.
fn mask_of(site: MaskSite, round: u32) -> u32 {
    let surface = surface_of(site);
    let random = in_pixel(site.pixel, surface);
    let alpha = quantised_alpha(site.alpha, random.x);
    if P_MASKS == P_MASKS_NAIVE {
        return coin_mask(alpha, vec2u(random.y, round << ALPHA_BITS)) & ((1u << MASK_SAMPLES) - 1u);
    }
    var xi = random.y >> (32u - ALPHA_BITS);
    if P_DITHER == P_DITHER_TILE {
        xi = tiled_xi(site.pixel, surface);
    }
    let size = size_in_round(set_size(alpha, MASK_SAMPLES * ROUND_COUNT, xi), round, random.z);
    if P_MASKS == P_MASKS_A2C {
        return (1u << size) - 1u;
    }
    return mask_pick(size, pcg2d(vec2u(random.w, round)).x);
}
