//! The threshold maps of STD section 3.3.

use sheer_core::threshold_map::{
    self, Statistics, THRESHOLD_COUNT, ThresholdMap, score, std_maps, threshold_index,
};

use super::check::exact;
use crate::verify::check::Check;

const SECTION: &str = "STD section 3.3";
/// The matrices of STD Eq. 7 and their scores.
const PRINTED: [(ThresholdMap, u32); 3] = [
    ([0, 6, 3, 8, 4, 1, 5, 2, 7], 344),
    ([6, 2, 4, 1, 5, 8, 3, 7, 0], 344),
    ([1, 4, 7, 8, 2, 5, 3, 6, 0], 342),
];
/// How many of the 1512 maps have which score (Eq. 6), by an independent enumeration.
const HISTOGRAM: [(u32, u32); 8] =
    [(344, 216), (342, 72), (332, 144), (328, 144), (320, 576), (302, 72), (288, 144), (284, 144)];

pub(super) fn checks() -> Vec<Check> {
    let Statistics { permutation_count, survivor_count, score_counts, cut_score, next_score } =
        threshold_map::statistics();
    let factorial: usize = (1..=THRESHOLD_COUNT).product();
    let mut checks = vec![
        exact("orders of nine thresholds", SECTION, factorial as f64, None, permutation_count as f64),
        exact("of these without close neighbours", SECTION, 1512.0, Some(1512.0), survivor_count as f64),
        exact("of these kept as maps", SECTION, 288.0, Some(288.0), std_maps().len() as f64),
        exact("least score of a map", "STD Eq. 6", 342.0, None, f64::from(cut_score)),
        exact("greatest score that is left out", "STD Eq. 6", 332.0, None, f64::from(next_score)),
    ];
    for (at, (expected_score, expected_count)) in HISTOGRAM.into_iter().enumerate() {
        // A score that is missing or out of order counts as none.
        let found =
            score_counts.get(at).filter(|(score, _)| *score == expected_score).map_or(0, |(_, count)| *count);
        let name = format!("maps of score {expected_score}");
        checks.push(exact(name, "STD Eq. 6", f64::from(expected_count), None, found as f64));
    }
    for (at, (map, expected)) in PRINTED.into_iter().enumerate() {
        let found = if std_maps().contains(&map) { f64::from(score(&map)) } else { f64::NAN };
        checks.push(exact(
            format!("score of printed matrix {}", at + 1),
            "STD Eq. 7",
            f64::from(expected),
            None,
            found,
        ));
    }
    let share = coverage(std_maps(), threshold_index);
    checks.push(exact(
        "share of pixels that meet all thresholds in nine frames",
        "STD Listing 4",
        1.0,
        None,
        share,
    ));
    checks
}

/// Share of maps, pixels and starts of nine frames that meet every threshold.
fn coverage(maps: &[ThresholdMap], index: impl Fn(&ThresholdMap, [u32; 2], u32) -> u8) -> f64 {
    let (mut whole, mut all) = (0_u32, 0_u32);
    for map in maps {
        for pixel in (0..9).map(|at| [at % 3 + 957, at / 3 + 537]) {
            for first in [0, 9, 18] {
                let seen = (first..first + 9).fold(0_u32, |seen, frame| seen | 1 << index(map, pixel, frame));
                whole += u32::from(seen == 0b1_1111_1111);
                all += 1;
            }
        }
    }
    f64::from(whole) / f64::from(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_maps_are_those_of_the_paper() {
        let failed: Vec<Check> = checks().into_iter().filter(|check| !check.pass).collect();
        assert!(failed.is_empty(), "{failed:?}");
    }

    #[test]
    fn a_walk_that_misses_a_threshold_is_noticed() {
        let stuck =
            |map: &ThresholdMap, pixel: [u32; 2], frame: u32| threshold_index(map, pixel, frame.min(7));
        assert!(coverage(std_maps(), stuck) < 1.0);
    }
}
