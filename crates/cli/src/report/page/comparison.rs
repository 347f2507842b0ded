//! `index.html` of `sheer compare`.

use serde::Serialize;
use sheer_image::{Image, Metadata, encode_png};
use sheer_lab::{
    Figures, Measured, figures,
    plot::{Axis, Plot, Series},
};
use sheer_metrics::false_colour;
use sheer_render::contract::MethodInfo;

use super::{benchmark::time_chart, data_uri, fill};
use crate::report::{
    chart::Chart,
    json::{Comparison, Run},
};

/// A method with its pictures.
#[derive(Debug)]
pub(crate) struct Entry {
    /// What came of it.
    pub(crate) measured: Measured,
    /// Its last frame as PNG.
    pub(crate) picture_png: Vec<u8>,
    /// Its error map as PNG; the reference has none.
    pub(crate) error_png: Option<Vec<u8>>,
}

impl Entry {
    /// Encodes the pictures.
    ///
    /// # Errors
    /// There is no memory for them.
    pub(crate) fn new(measured: Measured) -> anyhow::Result<Self> {
        let png = |image: &Image<[u8; 4]>| encode_png(image, &Metadata::default());
        let error_png = measured.error_map.as_ref().map(png).transpose()?;
        Ok(Self { picture_png: png(&measured.picture)?, error_png, measured })
    }

    /// Its anti-aliasing as it was asked for.
    fn aa(&self) -> String {
        self.measured.antialiasing.to_string()
    }
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
    cards: Vec<Card>,
    has_several_aa: bool,
    charts: Vec<Charts>,
    explanations: Vec<Explanation>,
    legend: String,
    error_full_scale: f32,
}

/// An entry as the template wants it.
#[derive(Serialize)]
struct Card {
    id: String,
    label: String,
    aa: String,
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
struct Charts {
    aa: String,
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
        figures: figures(page.entries.iter().map(|entry| &entry.measured), has_several_aa),
        cards: cards(page, has_several_aa),
        has_several_aa,
        charts: antialiasings(page).into_iter().map(|aa| charts(page, aa)).collect(),
        explanations: explanations(page),
        legend: legend(),
        error_full_scale: page.error_full_scale,
    };
    fill("comparison.html", context)
}

fn cards(page: &Page<'_>, has_several_aa: bool) -> Vec<Card> {
    let card = |(index, entry): (usize, &Entry)| {
        let (method, aa) = (&entry.measured.method, entry.aa());
        Card {
            id: format!("picture-{index}"),
            label: if has_several_aa { format!("{method} · {aa}") } else { method.to_string() },
            aa,
            is_reference: entry.error_png.is_none(),
            picture: data_uri(&entry.picture_png),
            error: entry.error_png.as_deref().map(data_uri),
        }
    };
    page.entries.iter().enumerate().map(card).collect()
}

fn antialiasings(page: &Page<'_>) -> Vec<String> {
    let mut words: Vec<String> = page.entries.iter().map(Entry::aa).collect();
    words.dedup();
    words
}

fn charts(page: &Page<'_>, aa: String) -> Charts {
    let all: Vec<&Measured> =
        page.entries.iter().filter(|entry| entry.aa() == aa).map(|entry| &entry.measured).collect();
    let names: Vec<String> = all.iter().map(|measured| measured.method.to_string()).collect();
    let lines = names.iter().zip(&all).map(|(name, measured)| (name.as_str(), measured.frame_ms.as_slice()));
    let quality = |title: &str, value: fn(&Measured) -> Option<f64>| {
        let dots = |(name, measured): (&String, &&Measured)| {
            Series::dots(name, value(measured).map(|quality| [measured.ms_median, quality]))
        };
        let plot = Plot {
            description: format!("{title} over milliseconds of a frame, one point for each method"),
            x: Axis::new("ms").logarithmic(),
            y: Axis::new(title),
            series: names.iter().zip(&all).map(dots).collect(),
        };
        plot.into()
    };
    Charts {
        time: time_chart(page.report.run.first_frame, lines),
        ssim: quality("SSIM", |measured| Some(measured.ssim)),
        psnr: quality("PSNR dB", |measured| measured.psnr_db),
        aa,
    }
}

/// Each method once, whatever its parameters.
fn explanations(page: &Page<'_>) -> Vec<Explanation> {
    let mut explanations: Vec<Explanation> = Vec::new();
    for MethodInfo { id, title, paper, bias, .. } in
        page.entries.iter().map(|entry| entry.measured.method.info())
    {
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
    use sheer_render::Antialiasing;

    use super::{
        super::tests::{assert_sound, run_of},
        *,
    };

    fn page_of(scene: &str) -> String {
        let measured = |method: &str| Measured {
            method: method.parse().unwrap(),
            antialiasing: Antialiasing::TAA,
            frame_ms: vec![1.0, 2.0],
            ms_median: 1.5,
            ms_min: 1.0,
            ms_max: 2.0,
            ssim: 1.0,
            psnr_db: None,
            tpsnr_db: None,
            vdp_jod: None,
            flip: 0.0,
            flicker: 0.0,
            bias: 0.0,
            rms: 0.0,
            shaded_per_pixel: 1.0,
            hits_per_pixel: 2.0,
            memory_bytes_per_pixel: 0.0,
            merged_per_pixel: 0.0,
            picture: Image::filled(2, 1, [0; 4]).unwrap(),
            error_map: None,
        };
        let entry = |method: &str, error_png| Entry {
            measured: measured(method),
            picture_png: b"png".to_vec(),
            error_png,
        };
        let entries = [entry("baseline", None), entry("std", Some(b"map".to_vec()))];
        let report = Comparison { run: run_of(scene), reference: "baseline".to_owned(), rows: Vec::new() };
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
