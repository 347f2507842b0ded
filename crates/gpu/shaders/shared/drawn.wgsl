// Fragments as methods with an unordered gathering take them: twin of `Fragment` in
// crates/render/src/contract/fragment.rs.
#import shared/opaque

struct Fragment {
    hit: Hit,
    // Above 0 and below 1.
    alpha: f32,
    // Along the view axis, scene units.
    depth: f32,
}

// Twin of `Tracer::depth`: never falls as the distance grows, rounding included.
fn depth_of(ray: CameraRay, hit: Hit) -> f32 {
    return view_depth(ray.origin) + hit.t * dot(ray.direction, -frame.camera.z_axis);
}

fn fragment_of(ray: CameraRay, hit: Hit) -> Fragment {
    return Fragment(hit, alpha_of(hit), depth_of(ray, hit));
}

// Whether one fragment lies in front of another: by depth, then triangle, twin of `Fragment::place`.
fn is_in_front(depth: f32, triangle: u32, other_depth: f32, other_triangle: u32) -> bool {
    return depth < other_depth || (depth == other_depth && triangle < other_triangle);
}

// What a pass that draws all triangles does with one: alpha is 0 where it has no part in the pixel, being
// nothing, opaque or hidden by something opaque.
fn drawn(vertex: TriangleVertex, ray: CameraRay) -> Fragment {
    let fragment = fragment_of(ray, fragment_hit(pixel_at, vertex.triangle));
    if fragment.hit.t < 0.0 || fragment.alpha >= 1.0 || is_hidden(pixel_at, fragment.hit) {
        return Fragment(fragment.hit, 0.0, 0.0);
    }
    return fragment;
}
