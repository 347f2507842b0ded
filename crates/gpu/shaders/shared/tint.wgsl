// What coloured glass leaves of the light on its way to the eye: twins of `Tracer::tint_before` and of what
// `Tracer::shade` takes of a fragment's own light. By a ray on every path: methods of a rasteriser do not
// meet fragments in their order.
#import shared/alpha
#import shared/counters
#import shared/glass
#import shared/intersect
#expand traverse VISITOR=tint

var<private> tint_left: vec3f;
var<private> tint_has_end: bool;
var<private> tint_end: Hit;

fn opacity_of(hit: Hit, width: f32) -> f32 {
    return opacity_for_camera(hit.triangle, hit.u, hit.v, hit.front, width);
}

fn visit_tint(hit: Hit) -> u32 {
    if (triangles[hit.triangle].y & TINTED) != 0u && (!tint_has_end || is_behind(tint_end, hit)) {
        let width = pixel_width_at(hit.t);
        tint_left *= glass_of(hit, opacity_of(hit, width), width).tint;
    }
    return GO_ON;
}

// The tint of all glass between the eye and a hit, or the far distance. Where a hit lies is found again: not
// everybody keeps it.
fn tint_before(ray: CameraRay, has_end: bool, end: Hit) -> vec3f {
    tint_left = vec3f(1.0);
    tint_has_end = has_end;
    tint_end = end;
    var t_max = ray.furthest;
    if has_end {
        tint_end = barycentrics(watertight_ray(ray.origin, ray.direction), end.triangle);
        t_max = tint_end.t;
    }
    traverse_tint(ray.origin, ray.direction, ray.nearest, t_max);
    counted.camera_rays += 1u;
    return tint_left;
}

// The share of its own light that a fragment sends to the eye.
fn own_share(ray: CameraRay, hit: Hit) -> f32 {
    if (triangles[hit.triangle].y & TINTED) == 0u {
        return 1.0;
    }
    let whole = barycentrics(watertight_ray(ray.origin, ray.direction), hit.triangle);
    let width = pixel_width_at(whole.t);
    return glass_of(whole, opacity_of(whole, width), width).own_share;
}
