// Rays of the camera and where points appear: twins of `CameraPose`.
#import limit
#import shared/frame
#import shared/hit
#import shared/vector

// Not seen by a perspective camera.
struct Projected {
    pixel: vec2f,
    is_seen: bool,
}

// The ray through a point in pixel units, origin in the upper left corner, centres at halves.
fn camera_ray(sample: vec2f) -> CameraRay {
    let camera = frame.camera;
    let size = vec2f(frame.size);
    let ndc = vec2f(2.0 * sample.x - size.x, size.y - 2.0 * sample.y) * frame.inverse_height;
    if camera.is_orthographic != 0u {
        let offset = ndc * camera.half_height;
        let origin = sum_in_order(camera.x_axis * offset.x, camera.y_axis * offset.y, camera.eye);
        return CameraRay(origin, -camera.z_axis, camera.near, limited(sample, camera.far, 1.0));
    }
    let in_camera = ndc * camera.tan_half_fov;
    let direction = sum_in_order(camera.x_axis * in_camera.x, camera.y_axis * in_camera.y, -camera.z_axis);
    let unit = normalized(direction);
    // Clip planes lie across the axis: rays beside it reach them later.
    let stretch = 1.0 / dot(unit, -camera.z_axis);
    let furthest = select(camera.far * stretch, FAR_AWAY, camera.far >= FAR_AWAY);
    return CameraRay(camera.eye, unit, camera.near * stretch, limited(sample, furthest, stretch));
}

// Where the one sample of a pixel lies, in pixels.
fn sample_of(pixel: vec2u) -> vec2f {
    return vec2f(pixel) + 0.5 + frame.jitter;
}

// Distance of a world point along the viewing axis.
fn view_depth(point: vec3f) -> f32 {
    return dot(point - frame.camera.eye, -frame.camera.z_axis);
}

// Where a world point appears, in pixels.
fn project(camera: CameraUniform, point: vec3f) -> Projected {
    let from_eye = point - camera.eye;
    let in_camera = vec3f(dot(camera.x_axis, from_eye), dot(camera.y_axis, from_eye), dot(camera.z_axis, from_eye));
    let size = vec2f(frame.size);
    var ndc = in_camera.xy / camera.half_height;
    if camera.is_orthographic == 0u {
        if in_camera.z >= 0.0 {
            return Projected(vec2f(0.0), false);
        }
        ndc = in_camera.xy / (-in_camera.z * camera.tan_half_fov);
    }
    return Projected(vec2f(ndc.x * size.y + size.x, size.y - ndc.y * size.y) * 0.5, true);
}

// Where a direction at infinity appears, in pixels.
fn project_direction(camera: CameraUniform, direction: vec3f) -> Projected {
    if camera.is_orthographic != 0u {
        return Projected(vec2f(0.0), false);
    }
    return project(camera, camera.eye + direction);
}
