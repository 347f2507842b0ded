// A point that light arrives at: twin of `Receiver` in crates/render/src/shadow/mod.rs.
#import shared/frame
#import shared/vector

struct Receiver {
    // Where the point is, world.
    position: vec3f,
    // Unit normal of its triangle; either side.
    normal: vec3f,
    // Unit direction towards the light.
    to_light: vec3f,
    // To the light, world units; FAR_AWAY of a directional light.
    distance: f32,
    // Of the beam that sees the point, world units; a beam to a light keeps it.
    width: f32,
    // Makes random taps differ from fragment to fragment: the pixel, and what is hit in it.
    key: vec3u,
}

// How far to step off the surface so that rounding does not shadow it by itself: a share of the scene's size,
// and a few times the rounding error of a 32-bit coordinate.
fn lift(receiver: Receiver) -> f32 {
    return frame.lift + max_element(abs(receiver.position)) * LIFT_ROUNDING;
}
