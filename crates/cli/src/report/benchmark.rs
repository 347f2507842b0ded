//! The columns of a benchmark.

use sheer_lab::{Column, Datum, Figures, Name, Seeded};

use super::json::{self, Benchmark, BenchmarkRow, Step};

/// A row and how many pixels a frame has.
struct Row<'a> {
    row: &'a BenchmarkRow,
    pixels: f64,
}

const fn column<'a>(
    title: &'static str,
    decimals: usize,
    value: fn(&Row<'a>) -> Option<f64>,
    meaning: &'static str,
) -> Column<Row<'a>> {
    Column { title, meaning, decimals, is_optional: false, is_time: false, value }
}

/// The same of what a clock measures.
const fn timed<'a>(
    title: &'static str,
    decimals: usize,
    value: fn(&Row<'a>) -> Option<f64>,
    meaning: &'static str,
) -> Column<Row<'a>> {
    Column { is_time: true, ..column(title, decimals, value, meaning) }
}

/// All figures, in the order in which they are shown.
fn columns<'a>() -> [Column<Row<'a>>; 12] {
    [
        timed(
            "ms",
            2,
            |Row { row, .. }| Some(row.ms_median),
            "Median time of a frame in milliseconds: animation, acceleration structure, tracing and shading. Adding frames up over time is not counted.",
        ),
        timed(
            "spread",
            2,
            |Row { row, .. }| Some(row.ms_spread),
            "Half of the frames lie within so many milliseconds of one another: third less first quartile.",
        ),
        timed("min", 2, |Row { row, .. }| Some(row.ms_min), "Time of the fastest frame, milliseconds."),
        timed("max", 2, |Row { row, .. }| Some(row.ms_max), "Time of the slowest frame, milliseconds."),
        timed("ratio", 3, |Row { row, .. }| Some(row.ratio), "Median time over that of the first method."),
        timed(
            "build ms",
            2,
            |Row { row, .. }| Some(row.build_ms_median),
            "Median time of animation and acceleration structure, milliseconds; part of ms.",
        ),
        Column {
            is_optional: true,
            ..timed(
                "resolve ms",
                2,
                |Row { row, .. }| adds_up(row).then_some(row.resolve_ms_median),
                "Median time of adding frames up over time, milliseconds; no part of ms.",
            )
        },
        Column {
            is_optional: true,
            ..timed(
                "whole ms",
                2,
                |Row { row, .. }| adds_up(row).then_some(row.whole_ms_median),
                "Median time of a frame with all that it takes, milliseconds.",
            )
        },
        Column {
            is_optional: true,
            ..timed(
                "whole ratio",
                3,
                |Row { row, .. }| adds_up(row).then_some(row.whole_ratio),
                "Median time of a whole frame over that of the first row.",
            )
        },
        column(
            "rays/px",
            2,
            |Row { row, pixels }| Some(row.rays / pixels),
            "Camera and shadow rays for a pixel of a frame.",
        ),
        column(
            "shaded/px",
            2,
            |Row { row, pixels }| Some(row.shaded / pixels),
            "Fragments shaded for a pixel of a frame.",
        ),
        timed(
            "Mray/s",
            2,
            |Row { row, .. }| Some(row.mray_per_s),
            "Million rays a second of tracing and shading.",
        ),
    ]
}

/// Whether frames are added up over time.
fn adds_up(row: &BenchmarkRow) -> bool {
    row.aa != "none"
}

/// Whether those of any row are.
fn add_up(report: &Benchmark) -> bool {
    report.rows.iter().any(|json::Row(runs)| adds_up(runs.first()))
}

/// Method and, where frames are added up, anti-aliasing.
pub(crate) fn label(report: &Benchmark, row: &BenchmarkRow) -> String {
    if add_up(report) { format!("{}, {}", row.method, row.aa) } else { row.method.clone() }
}

/// The table.
pub(crate) fn figures(report: &Benchmark) -> Figures {
    let pixels = report.run.size.map(f64::from).iter().product();
    let rows: Vec<Seeded<Row<'_>>> =
        report.rows.iter().map(|json::Row(runs)| runs.map(|row| Row { row, pixels })).collect();
    let names: [Name<Row<'_>>; 2] =
        [("method", |row| row.row.method.clone()), ("aa", |row| row.row.aa.clone())];
    Figures::over_seeds(if add_up(report) { &names } else { &names[..1] }, &columns(), &rows)
}

/// The passes of each method, where the GPU's clock has timed them; those of the first seed.
pub(crate) fn passes(report: &Benchmark) -> Option<Figures> {
    let row = |row: &BenchmarkRow, step: &Step| {
        let share = step.ms_median / row.steps.iter().map(|step| step.ms_median).sum::<f64>();
        vec![
            Datum::Word(label(report, row)),
            Datum::Word(step.name.to_owned()),
            Datum::Number(Some(step.ms_median), 3),
            Datum::Number(Some(share), 3),
        ]
    };
    let rows: Vec<_> = report
        .rows
        .iter()
        .map(|json::Row(runs)| runs.first())
        .flat_map(|method| method.steps.iter().map(move |step| row(method, step)))
        .collect();
    (!rows.is_empty()).then(|| Figures::of_data(&["method", "pass", "ms", "share"], rows))
}
