// Motion in pixels: twins of `Tracer::motion_and_depth_of` and `Tracer::motion_at_infinity`.
#import shared/camera
#import shared/surface

// Of a point that was elsewhere in the frame before.
fn motion_between(position: vec3f, previous: vec3f) -> vec2f {
    let now = project(frame.camera, position);
    let before = project(frame.previous_camera, previous);
    // From projected to projected, not from the sample: so a still surface has a motion of exactly zero.
    return select(vec2f(0.0), before.pixel - now.pixel, now.is_seen && before.is_seen);
}

// Of what is infinitely far away, which the camera's turning alone moves.
fn motion_at_infinity(pixel: vec2u, ray: CameraRay) -> vec2f {
    let before = project_direction(frame.previous_camera, ray.direction);
    return select(vec2f(0.0), before.pixel - sample_of(pixel), before.is_seen);
}
