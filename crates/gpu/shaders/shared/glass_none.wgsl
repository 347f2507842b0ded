// In place of shared/glass.wgsl where nothing in a scene tints what shines through it.
#import shared/hit

// Opacity that methods work with, of a hit that has this one for the camera.
fn method_alpha(hit: Hit, opacity: f32, width: f32) -> f32 {
    return select(0.0, opacity, opacity >= MIN_ALPHA);
}
