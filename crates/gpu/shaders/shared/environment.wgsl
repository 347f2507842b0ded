// Light from far away: twin of crates/scene/src/environment.rs and, of what a panorama adds, of panorama.rs
// in the folder beside it.
#import shared/frame
#import shared/vector
#import struct/Lobe

@group(GROUP_SCENE) @binding(BIND_LOBES) var<storage, read> lobes: array<Lobe>;
// The table of levels (first row, columns and rows of each), and below it their texels; one empty row of a
// table where there is no panorama.
@group(GROUP_SCENE) @binding(BIND_ENVIRONMENT_MAP) var environment_map: texture_2d<f32>;

// Radiance arriving from a unit direction, averaged over a lobe of the given width (perceptual roughness).
fn environment_radiance(direction: vec3f, roughness: f32) -> vec3f {
    let level = f32(LEVEL_SHARP) + clamp(roughness, 0.0, 1.0) * f32(ROUGHNESS_STEPS);
    return closed_form(direction, roughness) + map_at(direction, level);
}

fn closed_form(direction: vec3f, roughness: f32) -> vec3f {
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
    return sum + map_at(normal, f32(LEVEL_DIFFUSE));
}

// Radiance of the panorama from a unit direction at a level, or between it and the next.
fn map_at(direction: vec3f, level: f32) -> vec3f {
    var sum = vec3f(0.0);
    if textureLoad(environment_map, vec2u(0u), 0).y == 0.0 {
        return sum;
    }
    // Where the direction lies: shares of the width and height.
    let across = vec2f(direction.z, sqrt(direction.x * direction.x + direction.z * direction.z));
    let along = direction.xy;
    let angles = angles_of(across, along);
    let place = vec2f(angles.x / (2.0 * PI) + 0.5, angles.y / PI);

    let first = u32(level);
    let share = level - f32(first);
    for (var step = 0u; step < 2u; step++) {
        let weight = select(share, 1.0 - share, step == 0u);
        if weight > 0.0 {
            sum += weight * map_at_level(place, first + step);
        }
    }
    return sum;
}

// The angles from the axis of `x` to two points, radians; 0 for none. GPUs have an arcus tangent each of its
// own.
fn angles_of(y: vec2f, x: vec2f) -> vec2f {
    let less = min(abs(y), abs(x));
    let more = max(abs(y), abs(x));
    let ratio = less / select(vec2f(1.0), more, more > vec2f(0.0));
    let square = ratio * ratio;
    let end = ANGLE_FIT.w + square * (ANGLE_FIT_END.x + square * ANGLE_FIT_END.y);
    let octant = ratio * (ANGLE_FIT.x + square * (ANGLE_FIT.y + square * (ANGLE_FIT.z + square * end)));
    let quadrant = select(octant, 0.5 * PI - octant, abs(y) > abs(x));
    let half = select(quadrant, PI - quadrant, x < vec2f(0.0));
    return select(half, -half, y < vec2f(0.0));
}

fn map_at_level(place: vec2f, level: u32) -> vec3f {
    let entry = vec3i(textureLoad(environment_map, vec2u(level, 0u), 0).xyz);
    let size = entry.yz;
    let texel = place * vec2f(size) - 0.5;
    let corner = floor(texel);
    let share = texel - corner;
    var sum = vec3f(0.0);
    for (var index = 0; index < 4; index++) {
        let offset = vec2i(index & 1, index >> 1u);
        let weights = select(1.0 - share, share, offset == vec2i(1));
        let at = vec2i(corner) + offset;
        let column = (at.x + size.x) % size.x;
        let row = entry.x + clamp(at.y, 0, size.y - 1);
        sum += weights.x * weights.y * textureLoad(environment_map, vec2i(column, row), 0).xyz;
    }
    return sum;
}

fn gradient(height: f32) -> vec3f {
    if height >= 0.0 {
        return lerp(frame.horizon, frame.zenith, sqrt(min(height, 1.0)));
    }
    return lerp(frame.horizon, frame.ground, sqrt(min(-height * GROUND_STEEPNESS, 1.0)));
}
