// A point where a ray meets a triangle, as sheer_accel::Hit.
struct Hit {
    // Distance in lengths of the ray's direction; negative: no hit.
    t: f32,
    // Weights of the second and of the third vertex.
    u: f32,
    v: f32,
    triangle: u32,
    // The vertices run counter-clockwise seen from the ray's origin.
    front: bool,
}

// A ray through a point of the image, in world.
struct CameraRay {
    origin: vec3f,
    direction: vec3f,
    // Distances between which the camera sees.
    nearest: f32,
    furthest: f32,
}

fn no_hit() -> Hit {
    return Hit(-1.0, 0.0, 0.0, MISS, false);
}
