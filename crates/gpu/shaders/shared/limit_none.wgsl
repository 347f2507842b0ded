// How far a camera ray goes: as far as the camera sees. Stands for `limit` where nothing else ends rays.

fn limited(sample: vec2f, furthest: f32, stretch: f32) -> f32 {
    return furthest;
}
