//! Where frames sample their pixels.

use glam::Vec2;

/// Samples before the jitter repeats: an exponential average of weight 0.1 forgets in about as many, and 16
/// is coprime to the 9 frames of the STD walk, so that every threshold meets every offset.
pub(super) const JITTER_PERIOD: u32 = 16;

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
