//! The columns of a benchmark.

use super::{
    figures::{Column, Datum, Figures},
    json::{Benchmark, BenchmarkRow, Run, Step},
};

const fn column(
    title: &'static str,
    decimals: usize,
    value: fn(&Run, &BenchmarkRow) -> Option<f64>,
    meaning: &'static str,
) -> Column<BenchmarkRow> {
    Column { title, meaning, decimals, is_optional: false, value }
}

/// All figures, in the order in which they are shown.
const COLUMNS: &[Column<BenchmarkRow>] = &[
    column(
        "ms",
        2,
        |_, row| Some(row.ms_median),
        "Median time of a frame in milliseconds: animation, acceleration structure, tracing and shading. Adding frames up over time is not counted.",
    ),
    column(
        "spread",
        2,
        |_, row| Some(row.ms_spread),
        "Half of the frames lie within so many milliseconds of one another: third less first quartile.",
    ),
    column("min", 2, |_, row| Some(row.ms_min), "Time of the fastest frame, milliseconds."),
    column("max", 2, |_, row| Some(row.ms_max), "Time of the slowest frame, milliseconds."),
    column("ratio", 3, |_, row| Some(row.ratio), "Median time over that of the first method."),
    column(
        "build ms",
        2,
        |_, row| Some(row.build_ms_median),
        "Median time of animation and acceleration structure, milliseconds; part of ms.",
    ),
    column(
        "rays/px",
        2,
        |run, row| Some(row.rays / pixels(run)),
        "Camera and shadow rays for a pixel of a frame.",
    ),
    column(
        "shaded/px",
        2,
        |run, row| Some(row.shaded / pixels(run)),
        "Fragments shaded for a pixel of a frame.",
    ),
    column("Mray/s", 2, |_, row| Some(row.mray_per_s), "Million rays a second of tracing and shading."),
];

fn pixels(run: &Run) -> f64 {
    run.size.map(f64::from).iter().product()
}

/// The table.
pub(crate) fn figures(report: &Benchmark) -> Figures {
    Figures::new(&[("method", |row: &BenchmarkRow| row.method.clone())], COLUMNS, &report.run, &report.rows)
}

/// The passes of each method, where the GPU's clock has timed them.
pub(crate) fn passes(report: &Benchmark) -> Option<Figures> {
    let row = |row: &BenchmarkRow, step: &Step| {
        let share = step.ms_median / row.steps.iter().map(|step| step.ms_median).sum::<f64>();
        vec![
            Datum::Word(row.method.clone()),
            Datum::Word(step.name.to_owned()),
            Datum::Number(Some(step.ms_median), 3),
            Datum::Number(Some(share), 3),
        ]
    };
    let rows: Vec<_> = report
        .rows
        .iter()
        .flat_map(|method| method.steps.iter().map(move |step| row(method, step)))
        .collect();
    (!rows.is_empty()).then(|| Figures::of_data(&["method", "pass", "ms", "share"], rows))
}
