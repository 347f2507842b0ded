//! STD Fig. 4: what the order of thresholds does to an exponential average.

use sheer_core::threshold_map::{std_maps, threshold_index};
use sheer_metrics::statistics::quantile;
use sheer_render::Backend;

use super::{claims::claim, findings::Findings, lab::Lab};
use crate::{
    Datum, Figures, Result,
    plot::{Axis, Plot, Series},
};

/// Weight of a new frame in the exponential average (STD Eq. 2).
const WEIGHT: f64 = 0.1;
/// Frames that the chart shows, after the average has settled.
const SHOWN: usize = 36;
/// The sequences that STD section 3.3 prints: thresholds of one pixel, frame by frame.
const PRINTED: [(&str, [u8; 9]); 2] =
    [("printed, clumped", [0, 1, 2, 3, 4, 5, 6, 7, 8]), ("printed, spread", [0, 3, 6, 1, 4, 7, 2, 5, 8])];
/// Thresholds below which the alpha test passes: three, as the paper takes, and five, where the gaps are
/// shorter.
const PASSING: [u8; 2] = [3, 5];

/// The settled exponential average of the tests of a sequence, over one cycle and on.
fn averages(order: &[u8; 9], passing: u8, frames: usize) -> Vec<f64> {
    /// After as many frames the start counts for less than a thousandth.
    const SETTLED: usize = 90;
    let mut value = f64::from(passing) / 9.0;
    let step = |frame: usize| {
        value += WEIGHT * (f64::from(u8::from(order[frame % 9] < passing)) - value);
        value
    };
    (0..SETTLED + frames).map(step).skip(SETTLED).collect()
}

/// Of a settled average around its mean, which is the share of tests that pass.
fn variance(order: &[u8; 9], passing: u8) -> f64 {
    let alpha = f64::from(passing) / 9.0;
    averages(order, passing, 9).iter().map(|value| (value - alpha).powi(2)).sum::<f64>() / 9.0
}

/// The sequences of all pixels under all maps: the walk starts in each of the nine cells.
fn walks() -> Vec<[u8; 9]> {
    let cells = |map| {
        (0..9).map(move |cell| {
            std::array::from_fn(|frame| threshold_index(map, [cell % 3, cell / 3], frame as u32))
        })
    };
    std_maps().iter().flat_map(cells).collect()
}

/// The two printed sequences, and the distribution over all walks of all maps.
pub(super) fn sequences<B: Backend>(_: &Lab<'_, B>) -> Result<Findings> {
    let walks = walks();
    let mut findings = Findings::default();
    let mut rows = Vec::new();
    for passing in PASSING {
        let alpha = format!("{passing}/9");
        let [clumped, spread] = PRINTED.map(|(_, order)| variance(&order, passing));
        let of_walks: Vec<f64> = walks.iter().map(|order| variance(order, passing)).collect();
        let share = |holds: &dyn Fn(f64) -> bool| {
            of_walks.iter().filter(|variance| holds(**variance)).count() as f64 / of_walks.len() as f64
        };
        let (calmer, as_calm) =
            (share(&|variance| variance < clumped), share(&|variance| variance <= spread + 1e-12));
        findings.claims.push(claim(
            format!("alpha {alpha}: of the printed sequences the clumped one varies more, {clumped:.5} > {spread:.5}"),
            clumped > spread,
        ));
        findings.claims.push(
            claim(
                format!(
                    "alpha {alpha}: every walk over a map varies less than the clumped sequence; {:.1} % do",
                    100.0 * calmer
                ),
                calmer == 1.0,
            )
            .remark(
                "No map has a pixel whose tests come in one clump.",
                "Some pixels of some maps clump as much.",
            ),
        );
        let median = quantile(&of_walks, 0.5);
        findings.claims.push(
            claim(
                format!(
                    "alpha {alpha}: the median walk, {median:.5}, is as calm as the printed spread sequence, {spread:.5}; {:.1} % are",
                    100.0 * as_calm
                ),
                median <= spread + 1e-12,
            )
            .remark(
                "The maps are chosen for their neighbours in space, and the walk makes neighbours in time of them.",
                "The printed sequence is the ideal, not what the maps give: they are chosen for their neighbours in space.",
            ),
        );
        let number = |value| Datum::Number(Some(value), 6);
        rows.push(
            [Datum::Word(alpha.clone()), number(clumped), number(spread)]
                .into_iter()
                .chain([0.0, 0.25, 0.5, 0.75, 1.0].map(|at| number(quantile(&of_walks, at))))
                .collect(),
        );
        findings.plots.push((format!("Average of the tests, alpha {alpha}."), average_plot(passing)));
        findings.plots.push((
            format!("Variance over all {} walks, alpha {alpha}.", walks.len()),
            distribution_plot(&of_walks, [clumped, spread]),
        ));
    }
    let titles = ["alpha", "clumped", "spread", "least walk", "quarter", "median", "three quarters", "most"];
    let caption = "Variance of the settled average: the printed sequences, and the walks of every pixel over every map.";
    findings.tables.push((caption.to_owned(), Figures::of_data(&titles, rows)));
    Ok(findings)
}

/// Averages over frames: of the printed sequences and of one walk of many.
fn average_plot(passing: u8) -> Plot {
    let alpha = f64::from(passing) / 9.0;
    let points = |order: &[u8; 9]| -> Vec<[f64; 2]> {
        (0_u32..).map(f64::from).zip(averages(order, passing, SHOWN)).map(|(at, value)| [at, value]).collect()
    };
    let mut series = vec![Series::guide("alpha", [[0.0, alpha], [SHOWN as f64 - 1.0, alpha]])];
    series.extend(PRINTED.iter().map(|(name, order)| Series::line(name, points(order))));
    series.push(Series::line("one walk", points(&walks()[0])));
    Plot {
        description: format!("Exponential average of the tests of alpha {passing}/9 over frames"),
        x: Axis::new("frame").of_counts(),
        y: Axis::new("average"),
        series,
    }
}

/// The share of walks that vary by no more than so much, with the printed sequences as guides.
fn distribution_plot(of_walks: &[f64], [clumped, spread]: [f64; 2]) -> Plot {
    let mut sorted = of_walks.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len() - 1;
    // As many steps as an eye tells apart.
    let points = (0..=100_usize).map(|at| [sorted[at * last / 100], at as f64 / 100.0]);
    Plot {
        description: "Share of walks whose average varies by no more than so much".to_owned(),
        x: Axis::new("variance"),
        y: Axis::new("share of walks").with_zero(),
        series: vec![
            Series::guide("printed, clumped", [[clumped, 0.0], [clumped, 1.0]]),
            Series::guide("printed, spread", [[spread, 0.0], [spread, 1.0]]),
            Series::line("walks", points),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_walk_is_a_sequence_of_all_thresholds() {
        for mut walk in walks() {
            walk.sort_unstable();
            assert_eq!(walk, PRINTED[0].1);
        }
        assert_eq!(walks().len(), 288 * 9);
    }

    #[test]
    fn where_in_the_cycle_a_sequence_starts_does_not_matter() {
        let mut turned = PRINTED[1].1;
        turned.rotate_left(4);
        assert!((variance(&turned, 3) - variance(&PRINTED[1].1, 3)).abs() < 1e-6);
        assert!(variance(&PRINTED[0].1, 3) > 2.0 * variance(&PRINTED[1].1, 3));
    }
}
