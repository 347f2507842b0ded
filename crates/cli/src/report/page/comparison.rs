//! `index.html` of `sheer compare`.

use serde::Serialize;
use sheer_metrics::false_colour;
use sheer_render::contract::MethodInfo;

use super::{benchmark::time_chart, data_uri, fill};
use crate::report::{
    chart::{Axis, Chart, Plot, Series},
    comparison::figures,
    figures::Figures,
    json::{Comparison, ComparisonRow, Run},
};

/// A method with its pictures.
#[derive(Debug)]
pub(crate) struct Entry {
    /// What it is.
    pub(crate) info: &'static MethodInfo,
    /// Its figures.
    pub(crate) row: ComparisonRow,
    /// Milliseconds of each frame.
    pub(crate) frame_ms: Vec<f64>,
    /// The last frame as PNG.
    pub(crate) picture_png: Vec<u8>,
    /// Its error map as PNG; the reference has none.
    pub(crate) error_png: Option<Vec<u8>>,
}

/// What the page shows.
#[derive(Debug)]
pub(crate) struct Page<'a> {
    /// Figures.
    pub(crate) report: &'a Comparison,
    /// Methods with their pictures, in the order of the report's rows.
    pub(crate) entries: &'a [Entry],
    /// Displayed error in the last colour of the error maps.
    pub(crate) error_full_scale: f32,
}

/// What the template fills in.
#[derive(Serialize)]
struct Context<'a> {
    run: &'a Run,
    reference: &'a str,
    figures: Figures,
    cards: Vec<Card<'a>>,
    has_several_aa: bool,
    charts: Vec<Charts<'a>>,
    explanations: Vec<Explanation>,
    legend: String,
    error_full_scale: f32,
}

/// An entry as the template wants it.
#[derive(Serialize)]
struct Card<'a> {
    id: String,
    label: String,
    aa: &'a str,
    is_reference: bool,
    picture: String,
    error: Option<String>,
}

#[derive(Serialize)]
struct Explanation {
    id: &'static str,
    title: &'static str,
    paper: &'static str,
    bias: &'static str,
}

/// Of the methods under one anti-aliasing; in all of them a method has the same colour.
#[derive(Serialize)]
struct Charts<'a> {
    aa: &'a str,
    time: Chart,
    ssim: Chart,
    psnr: Chart,
}

/// The page as text.
///
/// # Errors
/// If the template is broken, which the tests would have found.
pub(crate) fn text(page: &Page<'_>) -> anyhow::Result<String> {
    let has_several_aa = antialiasings(page).len() > 1;
    let context = Context {
        run: &page.report.run,
        reference: &page.report.reference,
        figures: figures(page.report, has_several_aa),
        cards: cards(page, has_several_aa),
        has_several_aa,
        charts: antialiasings(page).into_iter().map(|aa| charts(page, aa)).collect(),
        explanations: explanations(page),
        legend: legend(),
        error_full_scale: page.error_full_scale,
    };
    fill("comparison.html", context)
}

fn cards<'a>(page: &Page<'a>, has_several_aa: bool) -> Vec<Card<'a>> {
    let card = |(index, entry): (usize, &'a Entry)| {
        let row = &entry.row;
        Card {
            id: format!("picture-{index}"),
            label: if has_several_aa { format!("{} · {}", row.method, row.aa) } else { row.method.clone() },
            aa: &row.aa,
            is_reference: entry.error_png.is_none(),
            picture: data_uri(&entry.picture_png),
            error: entry.error_png.as_deref().map(data_uri),
        }
    };
    page.entries.iter().enumerate().map(card).collect()
}

fn antialiasings<'a>(page: &Page<'a>) -> Vec<&'a str> {
    let mut words: Vec<&str> = page.entries.iter().map(|entry| entry.row.aa.as_str()).collect();
    words.dedup();
    words
}

fn charts<'a>(page: &Page<'a>, aa: &'a str) -> Charts<'a> {
    let entries = || page.entries.iter().filter(|entry| entry.row.aa == aa);
    let lines = entries().map(|entry| (entry.row.method.as_str(), entry.frame_ms.as_slice()));
    let quality = |title: &str, value: fn(&ComparisonRow) -> Option<f64>| {
        let dots = |Entry { row, .. }: &Entry| {
            Series::dots(&row.method, value(row).map(|quality| [row.ms_median, quality]))
        };
        let plot = Plot {
            description: format!("{title} over milliseconds of a frame, one point for each method"),
            x: Axis::new("ms").logarithmic(),
            y: Axis::new(title),
            series: entries().map(dots).collect(),
        };
        plot.into()
    };
    Charts {
        aa,
        time: time_chart(page.report.run.first_frame, lines),
        ssim: quality("SSIM", |row| Some(row.ssim)),
        psnr: quality("PSNR dB", |row| row.psnr_db),
    }
}

/// Each method once, whatever its parameters.
fn explanations(page: &Page<'_>) -> Vec<Explanation> {
    let mut explanations: Vec<Explanation> = Vec::new();
    for MethodInfo { id, title, paper, bias, .. } in page.entries.iter().map(|entry| entry.info) {
        if !explanations.iter().any(|known| known.id == *id) {
            explanations.push(Explanation { id, title, paper, bias });
        }
    }
    explanations
}

/// The colours of error maps as a CSS gradient.
fn legend() -> String {
    const STOPS: u8 = 16;
    let stops = (0..=STOPS).map(|stop| {
        let [r, g, b] = false_colour(f32::from(stop) / f32::from(STOPS));
        format!("#{r:02x}{g:02x}{b:02x}")
    });
    format!("linear-gradient(to right, {})", stops.collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use sheer_render::method::METHODS;

    use super::{
        super::tests::{assert_sound, run_of},
        *,
    };

    fn page_of(scene: &str) -> String {
        let row = |method: &str| ComparisonRow {
            method: method.to_owned(),
            aa: "taa".to_owned(),
            ms_median: 1.5,
            ms_min: 1.0,
            ms_max: 2.0,
            ssim: 1.0,
            psnr_db: None,
            tpsnr_db: None,
            vdp_jod: None,
            flip: Some(0.0),
            flicker: 0.0,
            bias: 0.0,
            rms: 0.0,
            shaded_per_pixel: 1.0,
            hits_per_pixel: 2.0,
            memory_bytes_per_pixel: 0.0,
            merged_per_pixel: 0.0,
        };
        let entry = |method: &str, error_png| Entry {
            info: &METHODS[0],
            row: row(method),
            frame_ms: vec![1.0, 2.0],
            picture_png: b"png".to_vec(),
            error_png,
        };
        let entries = [entry("baseline", None), entry("std", Some(b"map".to_vec()))];
        let rows = entries.iter().map(|entry| entry.row.clone()).collect();
        let report = Comparison { run: run_of(scene), reference: "baseline".to_owned(), rows };
        text(&Page { report: &report, entries: &entries, error_full_scale: 0.25 }).unwrap()
    }

    #[test]
    fn the_page_needs_nothing_but_itself() {
        assert_sound(page_of);
        assert!(page_of("layers").contains("data:image/png;base64,cG5n"), "the picture is not embedded");
    }

    #[test]
    fn a_figure_that_was_not_asked_for_has_no_column() {
        let page = page_of("layers");
        assert!(page.contains("tPSNR dB") && !page.contains("VDP JOD"));
    }
}
