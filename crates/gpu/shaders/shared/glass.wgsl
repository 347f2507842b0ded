// Coloured glass: twin of crates/render/src/cpu/glass.rs.
#import shared/hit
#import shared/scene
#import shared/surface
#import shared/vector

// What coloured glass does to light.
struct Glass {
    // Opacity to the channel that passes best; 0 if nobody would see a fragment of so little.
    alpha: f32,
    // What passes of each channel, over what passes of the one that passes best.
    tint: vec3f,
    // The fragment's own light over what its alpha stands for.
    own_share: f32,
}

// What a hit of an opacity does.
fn glass_of(hit: Hit, opacity: f32, width: f32) -> Glass {
    let passing = transmitted(hit.triangle, hit.u, hit.v, hit.front, opacity, width);
    let alpha = opacity + passing.share * (1.0 - max_element(passing.filtered));
    let through = vec3f(1.0 - opacity) - passing.share * (vec3f(1.0) - passing.filtered);
    if alpha < MIN_ALPHA {
        // No fragment, but what it takes of the other channels may be seen.
        return Glass(0.0, through, 1.0);
    }
    let passes = 1.0 - alpha;
    if passes <= 0.0 {
        return Glass(alpha, vec3f(1.0), opacity / alpha);
    }
    return Glass(alpha, clamp(through / passes, vec3f(0.0), vec3f(1.0)), opacity / alpha);
}

// Opacity that methods work with, of a hit that has this one for the camera.
fn method_alpha(hit: Hit, opacity: f32, width: f32) -> f32 {
    if (triangles[hit.triangle].y & TINTED) != 0u {
        return glass_of(hit, opacity, width).alpha;
    }
    return select(0.0, opacity, opacity >= MIN_ALPHA);
}
