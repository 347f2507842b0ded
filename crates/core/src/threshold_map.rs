//! The 3×3 threshold maps of STD section 3.3: an ordered dither for one object, walked through over nine
//! frames.
//!
//! Of all arrangements of the thresholds 0…8 those stay whose direct neighbours, on the torus, differ by more
//! than 1; the 288 of them with the largest squared differences (Eq. 6) are the maps. The paper leaves their
//! order open, ours is fixed: score descending, then lexicographic. There is no tie at the cut.

use std::sync::OnceLock;

/// Rows and columns of a map.
pub const SIDE: u32 = 3;

/// Thresholds of a map.
pub const THRESHOLD_COUNT: usize = 9;

/// Maps that objects choose from (STD section 3.3).
pub const MAP_COUNT: usize = 288;

/// The thresholds 0…8 in some order, row by row: the one at column `x` and row `y` is `map[3 * y + x]`.
pub type ThresholdMap = [u8; THRESHOLD_COUNT];

/// How the choice of maps came about, to be compared with the paper's figures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Statistics {
    /// Arrangements of nine thresholds: 9!.
    pub permutation_count: usize,
    /// Arrangements without direct neighbours that differ by 1; the paper states 1512.
    pub survivor_count: usize,
    /// Scores of these and how many have each, highest score first.
    pub score_counts: Vec<(u32, usize)>,
    /// The lowest score that is chosen.
    pub cut_score: u32,
    /// The highest score that is not chosen. Less than `cut_score`: the choice does not depend on the order
    /// of ties.
    pub next_score: u32,
}

/// The 288 maps of STD, score descending, then lexicographic. Built on first use, within milliseconds.
#[must_use]
pub fn std_maps() -> &'static [ThresholdMap; MAP_COUNT] {
    static MAPS: OnceLock<[ThresholdMap; MAP_COUNT]> = OnceLock::new();
    MAPS.get_or_init(|| {
        let ranked = ranked_survivors();
        std::array::from_fn(|index| ranked[index].1)
    })
}

/// Counts what [`std_maps`] is chosen from.
#[must_use]
pub fn statistics() -> Statistics {
    let ranked = ranked_survivors();
    let score_counts = ranked.chunk_by(|a, b| a.0 == b.0).map(|equal| (equal[0].0, equal.len())).collect();
    Statistics {
        permutation_count: permutations().count(),
        survivor_count: ranked.len(),
        score_counts,
        cut_score: ranked[MAP_COUNT - 1].0,
        next_score: ranked[MAP_COUNT].0,
    }
}

/// The sum of squared differences of direct neighbours on the torus (STD Eq. 6).
#[must_use]
pub fn score(map: &ThresholdMap) -> u32 {
    neighbours(map).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
}

/// The cell of a map that a pixel uses in a frame: column and row, 0 to 2 (STD Listing 4, `shift` and the
/// modulo).
///
/// The walk is serpentine, so that each step leads to a direct neighbour and no two successive frames use
/// thresholds that differ by 1. Each nine frames that start at a multiple of nine visit all cells; the walk
/// repeats after 18.
#[must_use]
pub fn shift(pixel: [u32; 2], frame: u32) -> [u32; 2] {
    let offset_y = frame / SIDE;
    let offset_x = if offset_y % 2 == 1 { SIDE - 1 - frame % SIDE } else { frame % SIDE };
    [(pixel[0] % SIDE + offset_x) % SIDE, (pixel[1] % SIDE + offset_y % SIDE) % SIDE]
}

/// The threshold, 0 to 8, that a map gives a pixel in a frame: Listing 4's `stratify`.
#[must_use]
pub fn threshold_index(map: &ThresholdMap, pixel: [u32; 2], frame: u32) -> u8 {
    let [x, y] = shift(pixel, frame);
    map[(SIDE * y + x) as usize]
}

/// All maps that pass the filter with their scores, in the order of choice.
fn ranked_survivors() -> Vec<(u32, ThresholdMap)> {
    let passes = |map: &ThresholdMap| neighbours(map).all(|(a, b)| a.abs_diff(b) > 1);
    let mut ranked: Vec<_> = permutations().filter(passes).map(|map| (score(&map), map)).collect();
    // Stable: maps of equal score stay in lexicographic order.
    ranked.sort_by_key(|&(score, _)| std::cmp::Reverse(score));
    ranked
}

/// The 18 pairs of direct neighbours on the torus: each cell with its right and its lower one.
fn neighbours(map: &ThresholdMap) -> impl Iterator<Item = (u8, u8)> {
    (0..3).flat_map(move |y| {
        (0..3).flat_map(move |x| {
            let at = |x: usize, y: usize| map[3 * (y % 3) + x % 3];
            [(at(x, y), at(x + 1, y)), (at(x, y), at(x, y + 1))]
        })
    })
}

/// All arrangements of the nine thresholds in lexicographic order.
fn permutations() -> impl Iterator<Item = ThresholdMap> {
    std::iter::successors(Some([0, 1, 2, 3, 4, 5, 6, 7, 8]), |map| {
        let mut next: ThresholdMap = *map;
        let pivot = (0..THRESHOLD_COUNT - 1).rfind(|&i| next[i] < next[i + 1])?;
        let successor = (pivot + 1..THRESHOLD_COUNT).rfind(|&i| next[i] > next[pivot])?;
        next.swap(pivot, successor);
        next[pivot + 1..].reverse();
        Some(next)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::fnv1a;

    /// The matrices of STD Eq. 7.
    const PRINTED: [ThresholdMap; 3] =
        [[0, 6, 3, 8, 4, 1, 5, 2, 7], [6, 2, 4, 1, 5, 8, 3, 7, 0], [1, 4, 7, 8, 2, 5, 3, 6, 0]];

    #[test]
    fn the_choice_agrees_with_the_paper_and_an_independent_enumeration() {
        let statistics = statistics();
        assert_eq!(statistics.permutation_count, 362_880);
        assert_eq!(statistics.survivor_count, 1512);
        assert_eq!(
            statistics.score_counts,
            [(344, 216), (342, 72), (332, 144), (328, 144), (320, 576), (302, 72), (288, 144), (284, 144)]
        );
        assert_eq!((statistics.cut_score, statistics.next_score), (342, 332), "a tie at the cut");
    }

    #[test]
    fn the_printed_matrices_are_among_the_maps() {
        assert_eq!(PRINTED.map(|map| score(&map)), [344, 344, 342]);
        assert!(PRINTED.iter().all(|map| std_maps().contains(map)));
        let unfit = [0, 1, 2, 3, 4, 5, 6, 7, 8];
        assert!(!std_maps().contains(&unfit), "the plain order passed the filter");
    }

    #[test]
    fn maps_are_ordered_by_score_then_lexicographically() {
        let key = |map: &ThresholdMap| (std::cmp::Reverse(score(map)), *map);
        assert!(std_maps().is_sorted_by(|a, b| key(a) < key(b)));
    }

    #[test]
    fn the_table_is_the_one_all_pictures_were_made_with() {
        assert_eq!(fnv1a(std_maps().as_flattened().iter().copied()), 0xd82a_f673_f5f4_b915);
    }

    #[test]
    fn each_map_shows_each_pixel_all_nine_thresholds_over_nine_frames() {
        let pixels = [[0, 0], [1, 0], [2, 1], [959, 539], [u32::MAX, u32::MAX - 1]];
        for map in std_maps() {
            for pixel in pixels {
                for first in [0, 9, 18, 9 * 1_000_003] {
                    let seen = (first..first + 9)
                        .fold(0_u32, |seen, frame| seen | 1 << threshold_index(map, pixel, frame));
                    assert_eq!(seen, 0b1_1111_1111, "pixel {pixel:?} from frame {first}");
                }
            }
        }
    }

    #[test]
    fn successive_frames_use_thresholds_that_differ_by_more_than_one() {
        for map in std_maps() {
            let walk: Vec<u8> = (0..=18).map(|frame| threshold_index(map, [1, 2], frame)).collect();
            assert!(walk.windows(2).all(|pair| pair[0].abs_diff(pair[1]) > 1), "{walk:?}");
            assert_eq!(walk[0], walk[18], "the walk closes after 18 frames");
        }
        // Without the mirrored rows, the step to the next row is a diagonal one that the filter does not
        // cover.
        let raster = |frame: u32| [frame % 3, frame / 3 % 3];
        let jumps = std_maps().iter().any(|map| {
            let at = |frame: u32| map[(3 * raster(frame)[1] + raster(frame)[0]) as usize];
            (0..8).any(|frame| at(frame).abs_diff(at(frame + 1)) <= 1)
        });
        assert!(jumps, "a plain raster walk passes the same check: the check is blind");
    }

    #[test]
    fn the_walk_is_the_serpentine_of_listing_4() {
        let cells: Vec<_> = (0..10).map(|frame| shift([0, 0], frame)).collect();
        assert_eq!(cells, [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1], [0, 2], [1, 2], [2, 2], [2, 0]]);
        assert_eq!(shift([u32::MAX, u32::MAX], u32::MAX), {
            let wide = |v: u64| (v % 3) as u32;
            let (frame, pixel) = (u64::from(u32::MAX), u64::from(u32::MAX));
            let offset_x = if frame / 3 % 2 == 1 { 2 - frame % 3 } else { frame % 3 };
            [wide(pixel + offset_x), wide(pixel + frame / 3)]
        });
    }
}
