//! Line charts: where things go. The page draws them.

use serde::Serialize;

/// Space of the whole drawing, in its own units.
const SIZE: [f64; 2] = [720.0, 280.0];
/// Around the plot: left for the numbers, right for the names of the lines, above, below for the axis.
const LEFT: f64 = 44.0;
const RIGHT: f64 = 130.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 30.0;
/// Names of lines closer than this would overlap.
const LABEL_SPACING: f64 = 16.0;

/// A chart of some quantity over frames.
#[derive(Debug, Serialize)]
pub(crate) struct Chart {
    size: [f64; 2],
    plot: [f64; 4],
    ticks: Vec<Tick>,
    first: u32,
    last: u32,
    lines: Vec<Line>,
}

#[derive(Debug, Serialize)]
struct Tick {
    y: f64,
    label: String,
}

#[derive(Debug, Serialize)]
struct Line {
    name: String,
    points: String,
    end: [f64; 2],
    label_y: f64,
}

impl Chart {
    /// Lines with names over frames from `first_frame` on; the vertical axis starts at 0.
    pub(crate) fn new(first_frame: u32, series: &[(String, &[f64])]) -> Self {
        let greatest = series.iter().flat_map(|(_, values)| *values).copied().fold(0.0, f64::max);
        let step = round_step(greatest / 4.0);
        let top_value = (greatest / step).ceil().max(1.0) * step;
        let (right, bottom) = (SIZE[0] - RIGHT, SIZE[1] - BOTTOM);
        let y = |value: f64| bottom - (bottom - TOP) * value / top_value;
        let frame_count = series.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
        let x =
            |frame: usize| LEFT + (right - LEFT) * frame as f64 / frame_count.saturating_sub(1).max(1) as f64;

        let ticks = (0..=(top_value / step).round() as u32).map(|count| f64::from(count) * step);
        let ticks = ticks.map(|value| Tick { y: y(value), label: tick_label(value, step) }).collect();
        let mut lines: Vec<Line> = series
            .iter()
            .map(|(name, values)| {
                let points = values
                    .iter()
                    .enumerate()
                    .map(|(frame, &value)| format!("{:.1},{:.1}", x(frame), y(value)));
                let last = values.len().saturating_sub(1);
                let end_y = y(values.last().copied().unwrap_or(0.0));
                Line {
                    name: name.clone(),
                    points: points.collect::<Vec<_>>().join(" "),
                    end: [x(last), end_y],
                    label_y: end_y,
                }
            })
            .collect();
        spread_labels(&mut lines, bottom);
        let last = first_frame + frame_count.saturating_sub(1) as u32;
        Self { size: SIZE, plot: [LEFT, TOP, right, bottom], ticks, first: first_frame, last, lines }
    }
}

/// Moves names apart, from the lowest line upwards.
fn spread_labels(lines: &mut [Line], bottom: f64) {
    let mut order: Vec<usize> = (0..lines.len()).collect();
    order.sort_by(|&a, &b| lines[b].label_y.total_cmp(&lines[a].label_y));
    let mut limit = bottom;
    for at in order {
        lines[at].label_y = lines[at].label_y.min(limit);
        limit = lines[at].label_y - LABEL_SPACING;
    }
}

/// 1, 2 or 5 times a power of ten, at least `wanted`.
fn round_step(wanted: f64) -> f64 {
    if wanted <= 0.0 {
        return 1.0;
    }
    let power = 10_f64.powf(wanted.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= wanted).unwrap_or(10.0);
    factor * power
}

fn tick_label(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_large_enough() {
        assert_eq!(
            [0.0, 0.9, 1.0, 1.1, 23.0, 0.03, 70.0].map(round_step),
            [1.0, 1.0, 1.0, 2.0, 50.0, 0.05, 100.0]
        );
        assert_eq!([tick_label(0.1, 0.05), tick_label(150.0, 50.0)], ["0.10", "150"]);
    }

    #[test]
    fn names_of_close_lines_do_not_overlap() {
        let series: Vec<(String, &[f64])> =
            ["a", "b", "c"].map(|name| (name.to_owned(), [5.0, 1.0].as_slice())).into();
        let chart = Chart::new(0, &series);
        let mut ys: Vec<f64> = chart.lines.iter().map(|line| line.label_y).collect();
        ys.sort_by(f64::total_cmp);
        assert!(ys.windows(2).all(|pair| pair[1] - pair[0] >= LABEL_SPACING), "{ys:?}");
        assert!(ys[2] <= chart.plot[3]);
    }

    #[test]
    fn a_single_frame_has_a_place() {
        let chart = Chart::new(7, &[("a".to_owned(), &[3.0])]);
        assert_eq!((chart.first, chart.last), (7, 7));
        assert!(chart.lines[0].end.iter().all(|coordinate| coordinate.is_finite()));
    }
}
