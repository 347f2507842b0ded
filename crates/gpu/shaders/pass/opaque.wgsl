// The nearest opaque surface of each pixel.
#import shared/triangles
#import shared/visible

@fragment
fn fs_opaque(vertex: TriangleVertex) -> Visible {
    let hit = fragment_hit(vec2u(vertex.position.xy), vertex.triangle);
    if hit.t < 0.0 || alpha_of(hit) < 1.0 {
        discard;
    }
    return visible(hit);
}
