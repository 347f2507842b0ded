//! Where frames sample their pixels.

use glam::Vec2;

/// Samples before the jitter repeats: an exponential average of weight 0.1 forgets in about as many, and 16
/// is coprime to the 9 frames of the STD walk, so that every threshold meets every offset.
pub(super) const JITTER_PERIOD: u32 = 16;

/// Samples of the picture that layers converge to: as many as a reference has.
const STILL_SAMPLES: u32 = 32;
/// Frames after which they begin one later: thresholds that repeat after a power of two would meet each
/// offset in few of their frames otherwise.
const STILL_SHIFT_FRAMES: u32 = 64;

/// The offset of a frame where frames may be averaged for long.
pub(super) fn long_jitter(frame: u32) -> Vec2 {
    halton((frame + frame / STILL_SHIFT_FRAMES) % STILL_SAMPLES + 1)
}

/// Offset from the pixel centre, each coordinate in (-0.5, 0.5) pixels: Halton's sequence of bases 2 and 3,
/// at an index from 1 on.
pub(super) fn halton(index: u32) -> Vec2 {
    Vec2::new(radical_inverse(index, 2), radical_inverse(index, 3)) - 0.5
}

/// The digits of `index` in a base, mirrored at the point.
fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut value, mut weight) = (0.0, 1.0);
    while index > 0 {
        weight /= base as f32;
        value += weight * (index % base) as f32;
        index /= base;
    }
    value
}
