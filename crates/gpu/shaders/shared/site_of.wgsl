// A hit as thresholds know it: twin of `Tracer::site` and of `cpu/object_space.rs`.
#import shared/camera
#import shared/scene
#import shared/site

// Barycentric weights of the second and third corner where a ray meets a triangle's plane.
struct PlaneHit {
    weights: vec2f,
    is_met: bool,
}

// The plane of a triangle in front of a ray's origin (Möller and Trumbore 1997, without the bounds of the
// triangle).
fn plane_hit(triangle: u32, ray: CameraRay) -> PlaneHit {
    let corners = corners_in_world(triangle);
    let a = corners[0];
    let to_b = corners[1] - a;
    let to_c = corners[2] - a;
    let to_origin = ray.origin - a;
    let p = cross(ray.direction, to_c);
    let q = cross(to_origin, to_b);
    let determinant = dot(to_b, p);
    if determinant == 0.0 {
        return PlaneHit(vec2f(0.0), false);
    }
    let scale = 1.0 / determinant;
    let weights = vec2f(dot(to_origin, p), dot(ray.direction, q)) * scale;
    let t = dot(to_c, q) * scale;
    let is_finite = all(abs(weights) < vec2f(FAR_AWAY));
    return PlaneHit(weights, t > 0.0 && is_finite);
}

// The longer of the two lengths, in the space of the object, between a hit and where the rays of the pixels
// to the right and below meet the triangle's plane; FAR_AWAY where they pass it by.
fn footprint_in_object(pixel: vec2u, triangle: u32, position: vec3f) -> f32 {
    let sample = sample_of(pixel);
    let right = plane_hit(triangle, camera_ray(sample + vec2f(1.0, 0.0)));
    let below = plane_hit(triangle, camera_ray(sample + vec2f(0.0, 1.0)));
    if !right.is_met || !below.is_met {
        return FAR_AWAY;
    }
    let to_right = distance(position_in_object(triangle, right.weights), position);
    let to_below = distance(position_in_object(triangle, below.weights), position);
    return max(to_right, to_below);
}

// A point of a triangle in the space of its object.
fn position_in_object(triangle: u32, weights: vec2f) -> vec3f {
    let corners = corners_in_object(triangle);
    return corners[0] + weights.x * (corners[1] - corners[0]) + weights.y * (corners[2] - corners[0]);
}

fn site_of(pixel: vec2u, ray: CameraRay, hit: Hit) -> Site {
    let object = triangles[hit.triangle].x;
    var site: Site;
    site.pixel = pixel;
    site.frame = frame.index;
    site.seed = frame.seed;
    site.instance = objects[object].id;
    site.geometry = objects[object].geometry;
    site.primitive = primitive(hit.triangle);
    site.back = select(0u, 1u, is_back(hit));
    site.position = ray.origin + ray.direction * hit.t;
    if USES_OBJECT_SPACE {
        site.position_in_object = position_in_object(hit.triangle, vec2f(hit.u, hit.v));
        site.footprint_in_object = footprint_in_object(pixel, hit.triangle, site.position_in_object);
    }
    return site;
}
