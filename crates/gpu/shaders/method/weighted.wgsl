// Weighted blended transparency (McGuire and Bavoil 2013): twin of crates/render/src/method/weighted.rs, with
// the sums in 16-bit floats that the paper asks of the blending units.
#import shared/composited
#import shared/counters
#import shared/drawn
#import shared/shade

// Weighted radiance, and weights.
@group(GROUP_OWN) @binding(BIND_WEIGHTED_SUMS) var weighted_sums: texture_2d<f32>;
@group(GROUP_OWN) @binding(BIND_WEIGHTED_TRANSMITTANCE) var weighted_transmittance: texture_2d<f32>;

struct Weighted {
    // Radiance times its weight, and the weight; the target adds them up.
    @location(0) rgb_weighted: vec4f,
    // What is seen through a fragment; the target multiplies them up.
    @location(1) transmittance: f32,
}

// The weight of a depth, without the factor of alpha that all of them have.
fn weight_of_depth(depth: f32) -> f32 {
    let z = abs(depth);
    var curve = 0.0;
    let to_200 = z / 200.0;
    let to_200_squared = to_200 * to_200;
    switch P_WEIGHT {
        case P_WEIGHT_EQ8: {
            let to_10 = z / 10.0;
            curve = 10.0 / (1e-5 + to_10 * to_10 * to_10 + to_200_squared * to_200_squared * to_200_squared);
        }
        case P_WEIGHT_EQ9: {
            curve = 0.03 / (1e-5 + to_200_squared * to_200_squared);
        }
        case P_WEIGHT_EQ10: {
            // What a depth buffer holds (Eq. 11).
            let span = max(frame.depth_far - frame.depth_near, EPSILON * frame.depth_far);
            let in_buffer = (frame.depth_far - frame.depth_near * frame.depth_far / max(z, frame.depth_near)) / span;
            let rest = 1.0 - in_buffer;
            curve = WEIGHT_MOST * rest * rest * rest;
        }
        default: {
            let to_5 = z / 5.0;
            curve = 10.0 / (1e-5 + to_5 * to_5 + to_200_squared * to_200_squared * to_200_squared);
        }
    }
    return clamp(curve, WEIGHT_LEAST, WEIGHT_MOST);
}

@fragment
fn fs_blend(vertex: TriangleVertex) -> Weighted {
    pixel_at = vec2u(vertex.position.xy);
    let ray = camera_ray(sample_of(pixel_at));
    let fragment = drawn(vertex, ray);
    let alpha = fragment.alpha;
    if alpha <= 0.0 {
        discard;
    }
    let weight = alpha * alpha * weight_of_depth(fragment.depth);
    counted.hits += 1u;
    counted.shaded += 1u;
    counted.merged += 1u;
    let rgb = shade(ray, fragment.hit, pixel_at);
    hand_in_counts();
    return Weighted(vec4f(weight * rgb, weight), 1.0 - alpha);
}

fn composited(pixel: vec2u, ray: CameraRay) -> Composited {
    let sums = textureLoad(weighted_sums, pixel, 0);
    if sums.w <= 0.0 {
        return Composited(vec3f(0.0), 1.0, false, false, Hit());
    }
    // There is one sum for all: one fragment a pixel was not merged. Counters wrap around.
    counted.merged -= 1u;
    let transmittance = textureLoad(weighted_transmittance, pixel, 0).x;
    // Bright fragments close to the eye overflow; the authors' program makes them white, too.
    let overflows = max_element(sums.xyz) > LARGEST_HALF || sums.w > LARGEST_HALF;
    let mean = select(sums.xyz / sums.w, vec3f(1.0), overflows);
    return Composited(mean * (1.0 - transmittance), transmittance, true, false, Hit());
}
