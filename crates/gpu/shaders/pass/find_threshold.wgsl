// The nearest hit whose alpha reaches its threshold (STD Listings 3 and 4): twin of `Tracer::first_kept`.
#import method
#import shared/alpha
#import shared/counters
#import shared/decide
#import shared/found
#import shared/site_of

var<private> nearest: Hit;
var<private> has_nearest: bool;
// Nearest hit that is neither opaque nor nothing: it makes the pixel a transparent one, kept or not.
var<private> nearest_partial: f32;
var<private> find_pixel: vec2u;
var<private> find_ray: CameraRay;
var<private> find_has_after: bool;
var<private> find_after: Hit;

fn visit_find(hit: Hit) -> u32 {
    if find_has_after && !is_behind(hit, find_after) {
        return GO_ON;
    }
    counted.hits += 1u;
    let alpha = coverage(alpha_of(hit));
    if alpha > 0.0 && alpha < 1.0 {
        nearest_partial = min(nearest_partial, hit.t);
    }
    if alpha < MIN_ALPHA || (has_nearest && is_behind(hit, nearest)) {
        return GO_ON;
    }
    if alpha < 1.0 && !keeps(alpha, threshold(site_of(find_pixel, find_ray, hit))) {
        return GO_ON;
    }
    nearest = hit;
    has_nearest = true;
    return END_HERE;
}
#expand camera VISITOR=find

fn find(pixel: vec2u, ray: CameraRay, has_after: bool, after: Hit) -> Found {
    has_nearest = false;
    nearest_partial = FAR_AWAY;
    find_pixel = pixel;
    find_ray = ray;
    find_has_after = has_after;
    find_after = after;
    traverse_find(ray.origin, ray.direction, select(ray.nearest, after.t, has_after), ray.furthest);
    counted.camera_rays += 1u;
    let transparent = select(nearest_partial < FAR_AWAY, nearest_partial <= nearest.t, has_nearest);
    return Found(has_nearest, nearest, transparent, false, vec3f(0.0));
}
