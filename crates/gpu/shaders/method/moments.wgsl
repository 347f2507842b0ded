// Moment-based transparency (Münstermann, Krumpen, Klein and Peters 2018): twin of
// crates/render/src/method/moments.rs. What the CPU solves in 64 bits is solved in 32 here, as by the paper.
#import shared/composited
#import shared/counters
#import shared/drawn
#import shared/hamburger
#import shared/shade

// The zeroth moment of a pixel: the sum of the absorbances of its fragments.
@group(GROUP_OWN) @binding(BIND_ABSORBANCES) var absorbances: texture_2d<f32>;
// The first to fourth, each times the absorbance.
@group(GROUP_OWN) @binding(BIND_MOMENTS) var moments: texture_2d<f32>;
// The fifth and so on; not read at order 4.
@group(GROUP_OWN) @binding(BIND_FURTHER_MOMENTS) var further_moments: texture_2d<f32>;
// Radiance by weight, and weights.
@group(GROUP_OWN) @binding(BIND_BLENDED_SUMS) var blended_sums: texture_2d<f32>;

// All are added up.
struct MomentSums {
    @location(0) absorbance: f32,
    @location(1) moments: vec4f,
    @location(2) further_moments: vec4f,
}

// -ln(1 - alpha), by its series where the subtraction would take digits away.
fn absorbance_of(alpha: f32) -> f32 {
    if alpha > 0.1 {
        return -log(1.0 - alpha);
    }
    // The next term is 1e-8 of the sum.
    let tail = 1.0 / 5.0 + alpha * (1.0 / 6.0 + alpha * (1.0 / 7.0));
    return alpha * (1.0 + alpha * (0.5 + alpha * (1.0 / 3.0 + alpha * (0.25 + alpha * tail))));
}

// 1 - exp(-absorbance), likewise.
fn alpha_of_absorbance(absorbance: f32) -> f32 {
    if absorbance > 0.1 {
        return 1.0 - exp(-absorbance);
    }
    let tail = 1.0 / 24.0 - absorbance * (1.0 / 120.0 - absorbance * (1.0 / 720.0));
    return absorbance * (1.0 - absorbance * (0.5 - absorbance * (1.0 / 6.0 - absorbance * tail)));
}

// The logarithm of depth from -1 at the nearest to 1 at the furthest: layers are fragment_stats apart by the
// ratio of their depths.
fn warped(depth: f32) -> f32 {
    let near = log(frame.depth_near);
    let share = (log(depth) - near) / max(log(frame.depth_far) - near, EPSILON);
    return clamp(2.0 * share - 1.0, -1.0, 1.0);
}

@fragment
fn fs_moments(vertex: TriangleVertex) -> MomentSums {
    pixel_at = vec2u(vertex.position.xy);
    let fragment = drawn(vertex, camera_ray(sample_of(pixel_at)));
    if fragment.alpha <= 0.0 {
        discard;
    }
    let depth = warped(fragment.depth);
    let absorbance = absorbance_of(fragment.alpha);
    let squared = depth * depth;
    let powers = vec4f(depth, squared, squared * depth, squared * squared);
    return MomentSums(absorbance, absorbance * powers, absorbance * powers.w * powers);
}

// The moments a unit of absorbance, moved towards those of a distribution that is well inside the valid ones,
// so that rounding takes none outside.
fn biased(pixel: vec2u, absorbance: f32) -> array<f32, 2u * DEGREE + 1u> {
    let low = textureLoad(moments, pixel, 0) / absorbance;
    let high = textureLoad(further_moments, pixel, 0) / absorbance;
    var read = array(low.x, low.y, low.z, low.w, high.x, high.y, high.z, high.w);
    var towards = array(MOMENT_TOWARDS.x, MOMENT_TOWARDS.y, MOMENT_TOWARDS.z, MOMENT_TOWARDS.w);
    var all: array<f32, 2u * DEGREE + 1u>;
    all[0] = 1.0;
    for (var index = 0u; index < 2u * DEGREE; index += 1u) {
        let even = select(0.0, towards[index / 2u], index % 2u == 1u);
        all[index + 1u] = read[index] + MOMENT_BIAS * (even - read[index]);
    }
    return all;
}

@fragment
fn fs_blend(vertex: TriangleVertex) -> @location(0) vec4f {
    pixel_at = vec2u(vertex.position.xy);
    let ray = camera_ray(sample_of(pixel_at));
    let fragment = drawn(vertex, ray);
    if fragment.alpha <= 0.0 {
        discard;
    }
    let absorbance = textureLoad(absorbances, pixel_at, 0).x;
    factorise(biased(pixel_at, absorbance));
    let share = share_in_front(warped(fragment.depth), P_OVERESTIMATION);
    let weight = fragment.alpha * exp(-absorbance * share);
    counted.hits += 1u;
    counted.shaded += 1u;
    counted.merged += 1u;
    let rgb = shade(ray, fragment.hit, pixel_at);
    hand_in_counts();
    return vec4f(weight * rgb, weight);
}

fn composited(pixel: vec2u, ray: CameraRay) -> Composited {
    let absorbance = textureLoad(absorbances, pixel, 0).x;
    if absorbance <= 0.0 {
        return Composited(vec3f(0.0), 1.0, false, false, Hit());
    }
    // There is one sum for all: one fragment a pixel was not merged. Counters wrap around.
    counted.merged -= 1u;
    let sums = textureLoad(blended_sums, pixel, 0);
    // Scaled so that what is seen of all fragments and of the background adds up to one.
    let scale = alpha_of_absorbance(absorbance) / max(sums.w, LEAST_NORMAL);
    return Composited(sums.xyz * scale, exp(-absorbance), true, false, Hit());
}
