// Light from far away: twin of crates/scene/src/environment.rs.
#import shared/frame
#import shared/vector
#import struct/Lobe

@group(GROUP_SCENE) @binding(BIND_LOBES) var<storage, read> lobes: array<Lobe>;

// Radiance arriving from a unit direction, averaged over a lobe of the given width (perceptual roughness).
fn environment_radiance(direction: vec3f, roughness: f32) -> vec3f {
    // The gradient is smooth: blurring it pulls the height towards the horizon's mix.
    let blur = 1.0 - HORIZON_BLUR * roughness * roughness;
    var sum = gradient(direction.y * blur);
    // A rough reflection is itself a spherical Gaussian; the product's width adds as 1/sharpness (Wang et al.
    // 2009, section 3.2).
    let alpha = max(roughness * roughness, LEAST_WIDTH);
    let view_sharpness = 2.0 / (alpha * alpha) / 4.0;
    for (var index = 0u; index < frame.lobe_count; index++) {
        let lobe = lobes[index];
        let sharpness = lobe.sharpness * view_sharpness / (lobe.sharpness + view_sharpness);
        let energy = sharpness / lobe.sharpness;
        sum += lobe.radiance * energy * exp(sharpness * (dot(direction, lobe.direction) - 1.0));
    }
    return sum;
}

// Irradiance on a surface with the given unit normal, divided by pi.
fn environment_diffuse(normal: vec3f) -> vec3f {
    // Cosine-weighted mean of the gradient in closed form: the hemisphere's mean height is 2/3 of the
    // normal's.
    var sum = gradient(normal.y * (2.0 / 3.0));
    for (var index = 0u; index < frame.lobe_count; index++) {
        let lobe = lobes[index];
        // Lobe integral times a clamped cosine softened by the lobe's width.
        let integral = 2.0 * PI / lobe.sharpness * (1.0 - exp(-2.0 * lobe.sharpness));
        let softness = 1.0 / (1.0 + lobe.sharpness);
        let cosine = dot(normal, lobe.direction);
        let facing = max((cosine + softness) / (1.0 + softness), 0.0);
        sum += lobe.radiance * integral * facing / PI;
    }
    return sum;
}

fn gradient(height: f32) -> vec3f {
    if height >= 0.0 {
        return lerp(frame.horizon, frame.zenith, sqrt(min(height, 1.0)));
    }
    return lerp(frame.horizon, frame.ground, sqrt(min(-height * GROUND_STEEPNESS, 1.0)));
}
