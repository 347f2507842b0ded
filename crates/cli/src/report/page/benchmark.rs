//! `sheer bench --html`: what methods cost.

use serde::Serialize;
use sheer_lab::{
    Figures,
    plot::{Axis, Plot, Series},
};

use super::fill;
use crate::report::{
    benchmark::{figures, label, passes},
    chart::Chart,
    json::{Benchmark, BenchmarkRow, Row, Run},
};

#[derive(Serialize)]
struct Context<'a> {
    run: &'a Run,
    figures: Figures,
    passes: Option<Figures>,
    time: Chart,
}

/// The page as text.
pub(crate) fn text(report: &Benchmark) -> anyhow::Result<String> {
    let rows: Vec<&BenchmarkRow> = report.rows.iter().map(|Row(runs)| runs.first()).collect();
    let names: Vec<String> = rows.iter().map(|row| label(report, row)).collect();
    let lines = names.iter().zip(&rows).map(|(name, row)| (name.as_str(), row.ms.as_slice()));
    let time = time_chart(report.run.first_frame, lines);
    fill(
        "benchmark.html",
        Context { run: &report.run, figures: figures(report), passes: passes(report), time },
    )
}

/// Milliseconds of each frame, a line for each method.
pub(super) fn time_chart<'a>(first_frame: u32, methods: impl Iterator<Item = (&'a str, &'a [f64])>) -> Chart {
    let points = |ms: &[f64]| -> Vec<[f64; 2]> {
        (first_frame..).zip(ms).map(|(frame, &ms)| [f64::from(frame), ms]).collect()
    };
    let plot = Plot {
        description: "Milliseconds of each frame, one line for each method".to_owned(),
        x: Axis::new("frame").of_counts(),
        y: Axis::new("ms").with_zero(),
        series: methods.map(|(method, ms)| Series::line(method, points(ms))).collect(),
    };
    plot.into()
}

#[cfg(test)]
mod tests {
    use super::{
        super::tests::{assert_sound, run_of},
        *,
    };
    use sheer_lab::Seeded;

    use crate::report::json::Step;

    #[test]
    fn the_page_needs_nothing_but_itself() {
        let row = |method: &str| BenchmarkRow {
            method: method.to_owned(),
            aa: "none".to_owned(),
            ms: vec![1.0, 2.5],
            ms_median: 1.75,
            ms_min: 1.0,
            ms_max: 2.5,
            ms_spread: 0.5,
            ratio: 1.0,
            build_ms_median: 0.0,
            shadow_ms_median: 0.0,
            resolve_ms_median: 0.0,
            whole_ms_median: 1.75,
            whole_ratio: 1.0,
            rays: 64.0,
            shaded: 32.0,
            mray_per_s: 1.0,
            steps: Vec::new(),
        };
        let once = |row: BenchmarkRow| Row(Seeded::of(vec![row]).unwrap());
        assert_sound(|scene| {
            let rows = ["std", "roulette"].map(|method| once(row(method))).into();
            text(&Benchmark { run: run_of(scene), rows }).unwrap()
        });
        let timed = BenchmarkRow { steps: vec![Step { name: "trace", ms_median: 0.625 }], ..row("std") };
        let page = |row| text(&Benchmark { run: run_of("layers"), rows: vec![row] }).unwrap();
        assert!(page(once(timed)).contains("0.625") && !page(once(row("std"))).contains("Passes"));
        let two = Row(Seeded::of(vec![row("std"), BenchmarkRow { shaded: 64.0, ..row("std") }]).unwrap());
        // 32 pixels: 1 and 2 a pixel.
        assert!(page(two).contains("1.50 ±6.35"), "there is no interval");
    }
}
