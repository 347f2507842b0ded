// Motion and depth of what the caller has drawn, where nothing of the scene is. Stands for `behind`.
#import limit
#import shared/project_motion

@group(GROUP_PASS) @binding(BIND_INPUT_MOTION) var input_motion: texture_2d<f32>;

// Where the caller tells no motion, what was drawn stands still and the camera alone moves.
fn motion_behind(pixel: vec2u, ray: CameraRay) -> vec2f {
    if opaque_input.has_motion != 0u {
        return textureLoad(input_motion, pixel, 0).xy * opaque_input.motion_scale;
    }
    let distance = opaque_distance(pixel);
    if distance >= FAR_AWAY {
        return motion_at_infinity(pixel, ray);
    }
    let stretch = 1.0 / dot(ray.direction, -frame.camera.z_axis);
    let position = ray.origin + ray.direction * (distance * stretch);
    return motion_between(position, position);
}

fn depth_behind(pixel: vec2u) -> f32 {
    return min(opaque_distance(pixel), NO_DEPTH);
}
