//! Motion vectors for dithering patterns that are fixed to the screen (STD section 3.3.1, Listing 5).

use glam::Vec2;
use sheer_core::hash::{pcg3d, unit_from_bits};

/// How motion vectors are aligned in a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Alignment {
    /// Side of the dithering pattern, pixels; 1 leaves motion vectors as they are.
    pub alignment_px: u32,
    pub frame: u32,
    pub seed: u32,
}

impl Alignment {
    /// A motion vector (pixels) as one of the four nearest multiples of the pattern's side, drawn by bilinear weight: so that history is
    /// fetched from a pixel at the same place in the pattern, and the mean motion stays what it is.
    pub(super) fn apply(self, motion: Vec2, [x, y]: [u32; 2]) -> Vec2 {
        if self.alignment_px <= 1 {
            return motion;
        }
        let side = self.alignment_px as f32;
        let (low, high) = ((motion / side).floor() * side, (motion / side).ceil() * side);
        let share = motion / side - (motion / side).floor();
        let random = unit_from_bits(pcg3d([x, y, self.frame ^ self.seed.rotate_left(16)])[0]);
        // One random number serves both axes: what remains of it after the first decision is uniform again.
        let (x, rest) = if random < share.x {
            (high.x, random / share.x)
        } else {
            (low.x, (random - share.x) / (1.0 - share.x))
        };
        Vec2::new(x, if rest < share.y { high.y } else { low.y })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aligned(motion: Vec2, frame: u32) -> Vec2 {
        Alignment { alignment_px: 3, frame, seed: 0 }.apply(motion, [frame % 977, frame / 977])
    }

    #[test]
    fn aligned_motion_is_a_multiple_of_three_and_right_on_average() {
        let motion = Vec2::new(-1.25, 4.5);
        let draws = 200_000;
        let mut sum = glam::DVec2::ZERO;
        for frame in 0..draws {
            let drawn = aligned(motion, frame);
            assert_eq!(drawn % 3.0, Vec2::ZERO);
            assert!((drawn - motion).abs().max_element() < 3.0);
            sum += drawn.as_dvec2();
        }
        // Standard deviation of a two-point draw 3 apart is at most 1.5; 5 of them over the root of the count.
        let error = (sum / f64::from(draws) - motion.as_dvec2()).abs().max_element();
        assert!(error < 5.0 * 1.5 / f64::from(draws).sqrt(), "{error}");
    }

    #[test]
    fn what_stands_still_stays_still() {
        for frame in 0..1000 {
            assert_eq!(aligned(Vec2::ZERO, frame), Vec2::ZERO);
            assert_eq!(aligned(Vec2::new(3.0, -6.0), frame), Vec2::new(3.0, -6.0));
        }
        assert_eq!(
            Alignment { alignment_px: 1, frame: 0, seed: 0 }.apply(Vec2::new(0.3, 0.4), [0, 0]),
            Vec2::new(0.3, 0.4)
        );
    }
}
