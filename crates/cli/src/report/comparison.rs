//! The columns of a comparison, the same for terminal and page.

use super::{
    json::{Comparison, ComparisonRow},
    table::{Table, number},
};

/// A figure of [`ComparisonRow`].
#[derive(Debug)]
pub(crate) struct Column {
    /// Its heading.
    pub(crate) title: &'static str,
    /// What it means, in plain words.
    pub(crate) meaning: &'static str,
    decimals: usize,
    value: fn(&ComparisonRow) -> Option<f64>,
}

impl Column {
    /// The figure of a row.
    pub(crate) fn value(&self, row: &ComparisonRow) -> Option<f64> {
        (self.value)(row)
    }

    /// The figure of a row as text.
    pub(crate) fn text(&self, row: &ComparisonRow) -> String {
        number(self.value(row), self.decimals)
    }
}

/// All figures, in the order in which they are shown.
pub(crate) const COLUMNS: &[Column] = &[
    Column {
        title: "ms",
        meaning: "Median time of a frame in milliseconds: animation, acceleration structure, tracing and shading. Adding frames up over time is not counted.",
        decimals: 1,
        value: |row| Some(row.ms_median),
    },
    Column {
        title: "min",
        meaning: "Time of the fastest frame, milliseconds.",
        decimals: 1,
        value: |row| Some(row.ms_min),
    },
    Column {
        title: "max",
        meaning: "Time of the slowest frame, milliseconds.",
        decimals: 1,
        value: |row| Some(row.ms_max),
    },
    Column {
        title: "SSIM",
        meaning: "Structural similarity to the exact picture as displayed. 1 is the same picture; above 0.98 few people see a difference.",
        decimals: 4,
        value: |row| Some(row.ssim),
    },
    Column {
        title: "PSNR dB",
        meaning: "Peak signal-to-noise ratio of the displayed picture in decibels: 6 more means half the error. A dash: no error at all.",
        decimals: 2,
        value: |row| row.psnr_db,
    },
    Column {
        title: "FLIP",
        meaning: "Difference that an eye would notice when the two pictures alternate on a display. 0 is none, 1 the most.",
        decimals: 4,
        value: |row| row.flip,
    },
    Column {
        title: "flicker",
        meaning: "How much the error changes from frame to frame: its standard deviation over time, display white being 1. A steady error does not flicker.",
        decimals: 4,
        value: |row| Some(row.flicker),
    },
    Column {
        title: "RMS",
        meaning: "Root mean square error in linear light.",
        decimals: 4,
        value: |row| Some(row.rms),
    },
    Column {
        title: "bias",
        meaning: "Mean error in linear light with its sign: what remains when noise averages out. Above 0 is too bright.",
        decimals: 5,
        value: |row| Some(row.bias),
    },
    Column {
        title: "shaded/px",
        meaning: "Fragments shaded for a pixel of a frame. Shading is what costs; one-fragment methods stay at 1 or below, since sky is not shaded.",
        decimals: 2,
        value: |row| Some(row.shaded_per_pixel),
    },
    Column {
        title: "hits/px",
        meaning: "Surfaces that the rays of a pixel met and tested or blended.",
        decimals: 2,
        value: |row| Some(row.hits_per_pixel),
    },
];

/// For the terminal.
pub(crate) fn table(report: &Comparison) -> String {
    let titles: Vec<&str> =
        ["method", "aa"].into_iter().chain(COLUMNS.iter().map(|column| column.title)).collect();
    let mut table = Table::new(&titles);
    for row in &report.rows {
        let figures = COLUMNS.iter().map(|column| column.text(row));
        table.add([row.method.clone(), row.aa.clone()].into_iter().chain(figures).collect());
    }
    table.text()
}
