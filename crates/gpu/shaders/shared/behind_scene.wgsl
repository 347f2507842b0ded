// Motion and depth where nothing of the scene is. Stands for `behind`.
#import shared/project_motion

fn motion_behind(pixel: vec2u, ray: CameraRay) -> vec2f {
    return motion_at_infinity(pixel, ray);
}

fn depth_behind(pixel: vec2u) -> f32 {
    return NO_DEPTH;
}
