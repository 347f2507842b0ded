//! STD Listing 5: motion vectors become multiples of the pattern's side, drawn by bilinear weight.

use glam::Vec2;
use sheer_image::Region;
use sheer_metrics::statistics::{Moments, wilson_hilferty};
use sheer_render::{
    contract::{Alignment, AlignmentRule},
    temporal::align::Reprojection,
};

use super::{
    check::exact,
    estimate::{mean_z, worst},
};
use crate::verify::check::{Check, Value};

/// Vectors that are drawn for.
const DRAWS: u32 = 200_000;
const SECTION: &str = "STD Listing 5";
/// Sides of the patterns of STD and DTAA, with a motion that is no multiple, pixels.
const MOTIONS: [(u32, Vec2); 2] = [(3, Vec2::new(-1.25, 4.5)), (5, Vec2::new(0.5, -7.75))];

pub(super) fn checks() -> Vec<Check> {
    MOTIONS
        .into_iter()
        .flat_map(|(side_px, motion)| listing_5(AlignmentRule::Random, side_px, motion))
        .collect()
}

/// All draws are corners of the cell around the motion; each corner comes with its bilinear weight; their
/// mean is the motion.
fn listing_5(rule: AlignmentRule, side_px: u32, motion: Vec2) -> [Check; 3] {
    let side = side_px as f32;
    let low = (motion / side).floor() * side;
    let share = ((motion - low) / side).as_dvec2();
    let alignment = Alignment { side_px, rule };
    let mut counts = [0_u32; 4];
    let mut strays = 0;
    let mut means = [Moments::default(); 2];
    for draw in 0..DRAWS {
        let size = [1920, 1080];
        let region = Region::whole(size);
        let reprojection = Reprojection { alignment, size, region, frame: draw / 1024, seed: 9 };
        let aligned = reprojection.aligned(motion, [draw % 1024 % 32 * 60, draw % 1024 / 32 * 33]);
        let corner = (0..4_usize)
            .find(|&corner| aligned == low + side * Vec2::new((corner % 2) as f32, (corner / 2) as f32));
        match corner {
            Some(corner) => counts[corner] += 1,
            None => strays += 1,
        }
        means[0].add(f64::from(aligned.x));
        means[1].add(f64::from(aligned.y));
    }
    let weight = |corner: usize| {
        let along = |share: f64, high: bool| if high { share } else { 1.0 - share };
        along(share.x, corner % 2 == 1) * along(share.y, corner / 2 == 1)
    };
    let terms = counts.iter().enumerate().map(|(corner, &count)| {
        let expected = weight(corner) * f64::from(DRAWS);
        (f64::from(count) - expected).powi(2) / expected
    });
    let chi_square: f64 = terms.sum();
    let name = |what: &str| format!("alignment to {side_px} pixels: {what}");
    let check = |what: &str, closed_form, measured, z| Check {
        name: name(what),
        source: SECTION.to_owned(),
        closed_form: Some(closed_form),
        paper: None,
        measured: Some(measured),
        samples: Some(u64::from(DRAWS)),
        z: Some(z),
        pass: false,
    };
    let [x, y] = motion.as_dvec2().to_array();
    // Two numbers as a colour of three, the third the same on both sides.
    let z = worst([mean_z(x, &means[0]), mean_z(y, &means[1])]);
    [
        exact(name("vectors that are no corner of their cell"), SECTION, 0.0, None, f64::from(strays)),
        check(
            "chi-square of the four corners",
            Value::Number(3.0),
            Value::Number(chi_square),
            wilson_hilferty(chi_square, 3.0),
        ),
        check(
            "mean motion in x and y, pixels",
            Value::Colour([x, y, 0.0]),
            Value::Colour([means[0].mean(), means[1].mean(), 0.0]),
            z,
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::{super::check::judge, *};

    fn verdicts(rule: AlignmentRule, side_px: u32, motion: Vec2) -> Vec<bool> {
        let mut checks = listing_5(rule, side_px, motion);
        judge(&mut checks);
        checks.iter().map(|check| check.pass).collect()
    }

    #[test]
    fn other_rules_are_found() {
        for (side_px, motion) in MOTIONS {
            assert_eq!(verdicts(AlignmentRule::Random, side_px, motion), [true; 3]);
            assert_eq!(verdicts(AlignmentRule::Off, side_px, motion)[..2], [false, false]);
            assert_eq!(verdicts(AlignmentRule::Nearest, side_px, motion), [true, false, false]);
        }
        // The dead zone of a wide picture takes a vector of a fifth of a pixel for none.
        let slow = Vec2::new(0.19, 1.0);
        assert_eq!(verdicts(AlignmentRule::Random, 3, slow), [true; 3]);
        assert_eq!(verdicts(AlignmentRule::DeadZone, 3, slow), [true, false, false]);
    }
}
