// One fragment a pixel by the depth test: those are dropped whose alpha does not reach their threshold (STD section 3.5), by the functions of
// the ray path.
#import method
#import shared/decide
#import shared/site_of
#import shared/visible

// Of each pixel: the complement of the bits of the distance of the nearest fragment that is neither opaque nor nothing, 0 for none; and how
// many were tested.
@group(2) @binding(0) var<storage, read_write> tested: array<atomic<u32>>;

@fragment
fn fs_visibility(vertex: TriangleVertex) -> Visible {
    let pixel = vec2u(vertex.position.xy);
    let hit = fragment_hit(pixel, vertex.triangle);
    if hit.t < 0.0 {
        discard;
    }
    let index = 2u * (pixel.y * frame.size.x + pixel.x);
    atomicAdd(&tested[index + 1u], 1u);
    let alpha = coverage(alpha_of(hit));
    if alpha > 0.0 && alpha < 1.0 {
        // Bits of positive numbers are ordered as the numbers are.
        atomicMax(&tested[index], ~bitcast<u32>(hit.t));
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
