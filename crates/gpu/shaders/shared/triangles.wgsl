// All triangles of the frame as they are drawn, without vertex buffers, and what a fragment is: the hit of
// its pixel's ray with the triangle, by the same arithmetic as on the ray path. So both paths see the same
// points, opacities and depths; what may differ is which pixels a triangle covers at its edges.
#import shared/alpha
#import shared/camera
#import shared/intersect
#import shared/pass
#import shared/scene

struct TriangleVertex {
    @invariant @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
}

// The near plane, as a share of the reach: a camera may stand inside smoke.
const NEAR_SHARE: f32 = 1e-6;

fn clip_from_world(point: vec3f) -> vec4f {
    let camera = frame.camera;
    let from_eye = point - camera.eye;
    let in_camera = vec3f(dot(camera.x_axis, from_eye), dot(camera.y_axis, from_eye), dot(camera.z_axis, from_eye));
    let size = vec2f(frame.size);
    // The sample of each pixel is moved into its centre.
    let shift = vec2f(-2.0, 2.0) * frame.jitter / size;
    if camera.is_orthographic != 0u {
        let ndc = in_camera.xy / camera.half_height * vec2f(size.y / size.x, 1.0);
        return vec4f(ndc + shift, -in_camera.z / frame.reach, 1.0);
    }
    let w = -in_camera.z;
    let ndc = in_camera.xy / camera.tan_half_fov * vec2f(size.y / size.x, 1.0);
    // Depth is written by fragments: this one only clips.
    return vec4f(ndc + shift * w, w - NEAR_SHARE * frame.reach, w);
}

fn triangle_vertex(index: u32) -> TriangleVertex {
    let triangle = index / 3u;
    return TriangleVertex(clip_from_world(corners_in_world(triangle)[index % 3u]), triangle);
}

// Outside the picture: draws nothing.
fn culled_vertex() -> TriangleVertex {
    return TriangleVertex(vec4f(2.0, 2.0, 2.0, 1.0), 0u);
}

@vertex
fn vs_all(@builtin(vertex_index) index: u32) -> TriangleVertex {
    return triangle_vertex(index);
}

// Leaves out what is opaque all over.
@vertex
fn vs_transparent(@builtin(vertex_index) index: u32) -> TriangleVertex {
    if (triangles[index / 3u].y & OPAQUE) != 0u {
        return culled_vertex();
    }
    return triangle_vertex(index);
}

// The hit of the pixel's ray with the plane of a triangle that covers it; `t` is negative where the camera's
// clip planes cut it away.
fn fragment_hit(pixel: vec2u, triangle: u32) -> Hit {
    let ray = camera_ray(sample_of(pixel));
    var hit = barycentrics(watertight_ray(ray.origin, ray.direction), triangle);
    if !(ray.nearest <= hit.t && hit.t <= ray.furthest) {
        hit.t = -1.0;
    }
    return hit;
}

// What a depth buffer holds: ordered as the distances are, to the bit.
fn depth_in_buffer(hit: Hit) -> f32 {
    return clamp(hit.t / frame.reach, 0.0, 1.0);
}
