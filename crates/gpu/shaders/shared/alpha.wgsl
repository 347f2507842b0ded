// What a camera ray makes of a hit.
#import glass
#import shared/scene

// Opacity for the camera, of coloured glass to the channel that passes best; 0 where it is less than anyone
// would see.
fn alpha_of(hit: Hit) -> f32 {
    let width = pixel_width_at(hit.t);
    return method_alpha(hit, opacity_for_camera(hit.triangle, hit.u, hit.v, hit.front, width), width);
}

// Whether a hit lies behind another in the order of all hits: by depth, then triangle.
fn is_behind(hit: Hit, other: Hit) -> bool {
    return is_behind_at(hit.t, hit.triangle, other.t, other.triangle);
}

fn is_behind_at(t: f32, triangle: u32, other_t: f32, other_triangle: u32) -> bool {
    return t > other_t || (t == other_t && triangle > other_triangle);
}
