//! Motion vectors for dithering patterns that are fixed to the screen (STD section 3.3.1, Listing 5).

use glam::{UVec2, Vec2};
use sheer_core::hash::{pcg3d, unit_from_bits};
use sheer_image::Region;

use crate::contract::{Alignment, AlignmentRule};

/// How history is reprojected in a frame.
#[derive(Clone, Copy, Debug)]
pub struct Reprojection {
    /// How motion vectors are aligned to the dithering pattern.
    pub alignment: Alignment,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The part of it of which there is a history.
    pub region: Region,
    /// Index of the frame: each draws anew.
    pub frame: u32,
    /// Seed of the run.
    pub seed: u32,
}

impl Reprojection {
    /// The motion vector (pixels) of a transparent pixel, given by column and row in the picture, as a
    /// multiple of the pattern's side, so that history is fetched from a pixel at the same position in the
    /// pattern.
    #[must_use]
    pub fn aligned(self, motion: Vec2, pixel: [u32; 2]) -> Vec2 {
        let side = self.alignment.side_px as f32;
        match self.alignment.rule {
            AlignmentRule::Off => motion,
            AlignmentRule::Random => self.drawn(motion, pixel),
            AlignmentRule::Nearest => (motion / side + 0.5).floor() * side,
            AlignmentRule::DeadZone => {
                let least = UVec2::from(self.size).as_vec2() * AlignmentRule::DEAD_ZONE;
                self.drawn(Vec2::select(motion.abs().cmplt(least), Vec2::ZERO, motion), pixel)
            }
        }
    }

    /// One of the four nearest multiples, drawn by bilinear weight (STD Listing 5): the mean motion stays
    /// what it is.
    fn drawn(self, motion: Vec2, [x, y]: [u32; 2]) -> Vec2 {
        let side = self.alignment.side_px as f32;
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

    fn aligned_by(rule: AlignmentRule, motion: Vec2, frame: u32) -> Vec2 {
        let alignment = Alignment { side_px: 3, rule };
        let size = [1000, 500];
        Reprojection { alignment, size, region: Region::whole(size), frame, seed: 0 }
            .aligned(motion, [frame % 977, frame / 977])
    }

    fn aligned(motion: Vec2, frame: u32) -> Vec2 {
        aligned_by(AlignmentRule::Random, motion, frame)
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
        // Standard deviation of a two-point draw 3 apart is at most 1.5; 5 of them over the root of the
        // count.
        let error = (sum / f64::from(draws) - motion.as_dvec2()).abs().max_element();
        assert!(error < 5.0 * 1.5 / f64::from(draws).sqrt(), "{error}");
    }

    #[test]
    fn what_stands_still_stays_still() {
        for frame in 0..1000 {
            assert_eq!(aligned(Vec2::ZERO, frame), Vec2::ZERO);
            assert_eq!(aligned(Vec2::new(3.0, -6.0), frame), Vec2::new(3.0, -6.0));
        }
        let motion = Vec2::new(0.3, 0.4);
        assert_eq!(aligned_by(AlignmentRule::Off, motion, 0), motion);
    }

    #[test]
    fn rounding_takes_the_nearest_multiple_whatever_the_frame() {
        for frame in 0..100 {
            let nearest = |motion| aligned_by(AlignmentRule::Nearest, motion, frame);
            assert_eq!(nearest(Vec2::new(1.4, -1.4)), Vec2::ZERO);
            assert_eq!(nearest(Vec2::new(1.6, -1.6)), Vec2::new(3.0, -3.0));
            assert_eq!(nearest(Vec2::new(7.4, -10.6)), Vec2::new(6.0, -12.0));
        }
    }

    #[test]
    fn the_dead_zone_stops_the_least_motion_in_each_direction_and_no_other() {
        // 1e-4 of 1000 × 500 pixels is a tenth and a twentieth of a pixel.
        let stopped =
            |motion| (0..1000).all(|frame| aligned_by(AlignmentRule::DeadZone, motion, frame) == Vec2::ZERO);
        assert!(stopped(Vec2::new(0.099, -0.049)));
        assert!(!stopped(Vec2::new(0.101, 0.0)) && !stopped(Vec2::new(0.0, -0.051)));
        for frame in 0..1000 {
            let motion = Vec2::new(-1.25, 4.5);
            assert_eq!(aligned_by(AlignmentRule::DeadZone, motion, frame), aligned(motion, frame));
        }
    }
}
