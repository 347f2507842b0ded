//! `index.html` of `sheer compare`: one file that needs nothing else, neither a server nor the network.

use anyhow::Context as _;
use base64::{Engine as _, prelude::BASE64_STANDARD};
use minijinja::{Environment, value::Serde};
use serde::Serialize;
use sheer_metrics::false_colour;
use sheer_render::contract::MethodInfo;

use super::{
    chart::Chart,
    comparison::COLUMNS,
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
    css: &'static str,
    js: &'static str,
    run: &'a Run,
    reference: &'a str,
    columns: Vec<Heading>,
    cards: Vec<Card<'a>>,
    has_several_aa: bool,
    charts: Vec<TimeChart<'a>>,
    explanations: Vec<Explanation>,
    legend: String,
    error_full_scale: f32,
}

/// An entry as the template wants it.
#[derive(Serialize)]
struct Card<'a> {
    id: String,
    label: String,
    method: &'a str,
    aa: &'a str,
    is_reference: bool,
    cells: Vec<Cell>,
    picture: String,
    error: Option<String>,
}

#[derive(Serialize)]
struct Cell {
    value: Option<f64>,
    text: String,
}

#[derive(Serialize)]
struct Heading {
    title: &'static str,
    meaning: &'static str,
}

#[derive(Serialize)]
struct Explanation {
    id: &'static str,
    title: &'static str,
    paper: &'static str,
    bias: &'static str,
}

#[derive(Serialize)]
struct TimeChart<'a> {
    aa: &'a str,
    chart: Chart,
}

/// The page as text.
///
/// # Errors
/// If the template is broken, which the tests would have found.
pub(crate) fn text(page: &Page<'_>) -> anyhow::Result<String> {
    let mut environment = Environment::new();
    // The ending makes the engine escape everything that is not marked as safe.
    environment.add_template("page.html", include_str!("page.html"))?;
    let context = Context {
        css: include_str!("page.css"),
        js: include_str!("page.js"),
        run: &page.report.run,
        reference: &page.report.reference,
        columns: COLUMNS
            .iter()
            .map(|column| Heading { title: column.title, meaning: column.meaning })
            .collect(),
        cards: cards(page),
        has_several_aa: antialiasings(page).len() > 1,
        charts: charts(page),
        explanations: explanations(page),
        legend: legend(),
        error_full_scale: page.error_full_scale,
    };
    environment.get_template("page.html")?.render(Serde(context)).context("cannot fill in the report page")
}

fn cards<'a>(page: &Page<'a>) -> Vec<Card<'a>> {
    let several = antialiasings(page).len() > 1;
    let card = |(index, entry): (usize, &'a Entry)| {
        let row = &entry.row;
        Card {
            id: format!("picture-{index}"),
            label: if several { format!("{} · {}", row.method, row.aa) } else { row.method.clone() },
            method: &row.method,
            aa: &row.aa,
            is_reference: entry.error_png.is_none(),
            cells: COLUMNS
                .iter()
                .map(|column| Cell { value: column.value(row), text: column.text(row) })
                .collect(),
            picture: data_uri(&entry.picture_png),
            error: entry.error_png.as_deref().map(data_uri),
        }
    };
    page.entries.iter().enumerate().map(card).collect()
}

fn data_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png))
}

fn antialiasings<'a>(page: &Page<'a>) -> Vec<&'a str> {
    let mut words: Vec<&str> = page.entries.iter().map(|entry| entry.row.aa.as_str()).collect();
    words.dedup();
    words
}

fn charts<'a>(page: &Page<'a>) -> Vec<TimeChart<'a>> {
    let chart = |aa: &'a str| {
        let lines = page.entries.iter().filter(|entry| entry.row.aa == aa);
        let lines: Vec<_> =
            lines.map(|entry| (entry.row.method.clone(), entry.frame_ms.as_slice())).collect();
        TimeChart { aa, chart: Chart::new(page.report.run.first_frame, &lines) }
    };
    antialiasings(page).into_iter().map(chart).collect()
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

    use super::*;

    fn page_of(scene: &str) -> String {
        let row = |method: &str| ComparisonRow {
            method: method.to_owned(),
            aa: "taa".to_owned(),
            ms_median: 1.5,
            ms_min: 1.0,
            ms_max: 2.0,
            ssim: 1.0,
            psnr_db: None,
            flip: Some(0.0),
            flicker: 0.0,
            bias: 0.0,
            rms: 0.0,
            shaded_per_pixel: 1.0,
            hits_per_pixel: 2.0,
        };
        let entry = |method: &str, error_png| Entry {
            info: &METHODS[0],
            row: row(method),
            frame_ms: vec![1.0, 2.0],
            picture_png: b"png".to_vec(),
            error_png,
        };
        let entries = [entry("baseline", None), entry("std", Some(b"map".to_vec()))];
        let run = Run {
            scene: scene.to_owned(),
            scene_hash: "0123".to_owned(),
            camera: "default".to_owned(),
            alpha: None,
            size: [8, 4],
            frames: 2,
            first_frame: 0,
            time_secs: 0.0,
            backend: "cpu",
            adapter: "a processor".to_owned(),
            seed: 0,
            version: "0",
            commit: "c0ffee",
            threads: 1,
        };
        let rows = entries.iter().map(|entry| entry.row.clone()).collect();
        let report = Comparison { run, reference: "baseline".to_owned(), rows };
        text(&Page { report: &report, entries: &entries, error_full_scale: 0.25 }).unwrap()
    }

    #[test]
    fn the_page_needs_nothing_but_itself() {
        let page = page_of("layers");
        assert!(page.contains("data:image/png;base64,cG5n"), "the picture is embedded");
        for outside in ["http:", "https:", "src=\"/", "@import", "<link"] {
            // The name of the SVG namespace is no address that is visited.
            let visited = page.replace("http://www.w3.org/2000/svg", "");
            assert!(!visited.contains(outside), "{outside}");
        }
    }

    #[test]
    fn names_from_outside_are_escaped() {
        let page = page_of("<script>alert(1)</script>&\"");
        assert!(!page.contains("<script>alert"));
        assert!(page.contains("&lt;script&gt;alert(1)"));
    }
}
