// One fragment a pixel by the depth test: those are dropped whose alpha does not reach their threshold (STD
// section 3.5), by the functions of the ray path.
#import method
#import shared/decide
#import shared/site_of
#import shared/visible

// The words of `Tested`.
@group(GROUP_OWN) @binding(BIND_TESTED) var<storage, read_write> tested: array<atomic<u32>>;

@fragment
fn fs_visibility(vertex: TriangleVertex) -> Visible {
    let pixel = vec2u(vertex.position.xy);
    let hit = fragment_hit(pixel, vertex.triangle);
    if hit.t < 0.0 {
        discard;
    }
    let index = TESTED_WORDS * (pixel.y * frame.size.x + pixel.x);
    atomicAdd(&tested[index + TESTED_COUNT], 1u);
    let alpha = coverage(alpha_of(hit));
    if alpha > 0.0 && alpha < 1.0 {
        // Bits of positive numbers are ordered as the numbers are.
        atomicMax(&tested[index + TESTED_NEAREST], ~bitcast<u32>(hit.t));
    }
    if alpha < MIN_ALPHA {
        discard;
    }
    let ray = camera_ray(sample_of(pixel));
    if alpha < 1.0 && !keeps(alpha, threshold(site_of(pixel, ray, hit))) {
        discard;
    }
    return visible(hit);
}
