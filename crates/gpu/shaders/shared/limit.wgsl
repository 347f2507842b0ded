// How far a camera ray goes: to the opaque surface of its pixel that the caller has drawn.
#import shared/opaque_input

// Along the viewing axis, world units; FAR_AWAY where nothing is.
fn opaque_distance(pixel: vec2u) -> f32 {
    return distance_of_depth(opaque_ndc(pixel));
}

// `stretch` is the length of the ray to a distance of 1 along the axis.
fn limited(sample: vec2f, furthest: f32, stretch: f32) -> f32 {
    let distance = opaque_distance(vec2u(sample));
    return select(min(furthest, distance * stretch), furthest, distance >= FAR_AWAY);
}
