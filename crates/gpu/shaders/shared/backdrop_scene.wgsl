// What lies behind everything: the surroundings of the scene, a colour, or nothing. Stands for `backdrop`.
#import shared/environment
#import shared/frame

// What a camera ray that meets nothing sees, glass left out; premultiplied.
fn background(ray: CameraRay) -> vec4f {
    switch frame.background_kind {
        case BACKGROUND_ENVIRONMENT: {
            return vec4f(environment_radiance(ray.direction, 0.0) * frame.exposure, 1.0);
        }
        case BACKGROUND_COLOUR: {
            return vec4f(frame.background_rgb, 1.0);
        }
        default: {
            return vec4f(0.0);
        }
    }
}
