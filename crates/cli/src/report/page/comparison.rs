//! `index.html` of `sheer compare`.

use serde::Serialize;
use sheer_image::{Image, Metadata, encode_png};
use sheer_lab::{
    Figures, ForeignJudged, Measured, Reference, Seeded, figures,
    plot::{Axis, Plot, Series},
};
use sheer_render::{Antialiasing, contract::MethodInfo};

use super::{
    benchmark::time_chart,
    data_uri, fill,
    viewer::{Card, legend},
};
use crate::report::{
    chart::Chart,
    json::{Comparison, Run},
};

/// A method with its pictures.
#[derive(Debug)]
pub(crate) struct Entry {
    /// What came of it with each seed.
    pub(crate) runs: Seeded<Measured>,
    /// Its last frame with the first seed as PNG.
    pub(crate) picture_png: Vec<u8>,
    /// Its error map as PNG, against the truth where it is asked for; the reference has none.
    pub(crate) error_png: Option<Vec<u8>>,
}

/// The pictures of another program under one anti-aliasing.
#[derive(Debug)]
pub(crate) struct ForeignEntry {
    /// What came of them.
    pub(crate) judged: ForeignJudged,
    /// Their file or pattern.
    pub(crate) pattern: String,
    /// The last one as PNG.
    pub(crate) picture_png: Vec<u8>,
    /// Its error map as PNG, against the truth where it is asked for.
    pub(crate) error_png: Vec<u8>,
}

impl ForeignEntry {
    /// Encodes the pictures.
    ///
    /// # Errors
    /// There is no memory for them.
    pub(crate) fn new(judged: ForeignJudged, pattern: String) -> anyhow::Result<Self> {
        let png = |image: &Image<[u8; 4]>| encode_png(image, &Metadata::default());
        let against = judged.against_truth.as_ref().unwrap_or(&judged.against_same);
        let (picture_png, error_png) = (png(&against.picture)?, png(&against.error_map)?);
        Ok(Self { judged, pattern, picture_png, error_png })
    }
}

/// What methods should have shown in their last frame.
#[derive(Debug)]
pub(crate) struct TruthPicture {
    /// The anti-aliasing that they were under: under one that adds up a moment all frames show the first.
    pub(crate) aa: String,
    /// As PNG.
    pub(crate) png: Vec<u8>,
}

impl TruthPicture {
    /// Encodes the picture.
    ///
    /// # Errors
    /// There is no memory for it.
    pub(crate) fn new(antialiasing: Antialiasing, picture: &Image<[u8; 4]>) -> anyhow::Result<Self> {
        Ok(Self { aa: antialiasing.to_string(), png: encode_png(picture, &Metadata::default())? })
    }
}

impl Entry {
    /// Encodes the pictures.
    ///
    /// # Errors
    /// There is no memory for them.
    pub(crate) fn new(runs: Seeded<Measured>) -> anyhow::Result<Self> {
        let png = |image: &Image<[u8; 4]>| encode_png(image, &Metadata::default());
        let measured = runs.first();
        let error_map = match &measured.against_truth {
            Some(truth) => Some(&truth.error_map),
            None => measured.error_map.as_ref(),
        };
        let error_png = error_map.map(png).transpose()?;
        Ok(Self { picture_png: png(&measured.picture)?, error_png, runs })
    }

    /// What came of it with the first seed: method, anti-aliasing and pictures are those of all.
    pub(crate) fn first(&self) -> &Measured {
        self.runs.first()
    }

    /// Its anti-aliasing as it was asked for.
    fn aa(&self) -> String {
        self.first().antialiasing.to_string()
    }
}

/// What the page shows.
#[derive(Debug)]
pub(crate) struct Page<'a> {
    /// Figures.
    pub(crate) report: &'a Comparison,
    /// What the methods are held against.
    pub(crate) references: &'a [Reference],
    /// Methods with their pictures, in the order of the report's rows.
    pub(crate) entries: &'a [Entry],
    /// Pictures of other programs.
    pub(crate) foreign: &'a [ForeignEntry],
    /// The truth under each anti-aliasing, where it is asked for.
    pub(crate) true_pictures: &'a [TruthPicture],
    /// Displayed error in the last colour of the error maps.
    pub(crate) error_full_scale: f32,
}

/// What the template fills in.
#[derive(Serialize)]
struct Context<'a> {
    run: &'a Run,
    baseline: &'a str,
    /// The references in words.
    same: Option<String>,
    truth: Option<String>,
    figures: Figures,
    cards: Vec<Card>,
    has_several_aa: bool,
    charts: Vec<Charts>,
    explanations: Vec<Explanation>,
    foreign: Vec<ForeignSource<'a>>,
    legend: String,
    error_full_scale: f32,
}

#[derive(Serialize)]
struct Explanation {
    id: &'static str,
    title: &'static str,
    paper: &'static str,
    bias: &'static str,
}

/// Where pictures of another program come from.
#[derive(Serialize, PartialEq)]
struct ForeignSource<'a> {
    name: &'a str,
    pattern: &'a str,
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
    let mut figures = figures(page.entries.iter().map(|entry| &entry.runs), has_several_aa, page.references);
    figures.add_foreign(page.foreign.iter().map(|entry| &entry.judged), has_several_aa);
    let context = Context {
        run: &page.report.run,
        baseline: &page.report.reference,
        same: in_words(page, |reference| **reference == Reference::Same),
        truth: in_words(page, |reference| is_truth(reference)),
        figures,
        cards: cards(page, has_several_aa),
        has_several_aa,
        charts: antialiasings(page).into_iter().map(|aa| charts(page, aa)).collect(),
        explanations: explanations(page),
        foreign: foreign_sources(page),
        legend: legend(),
        error_full_scale: page.error_full_scale,
    };
    fill("comparison.html", context)
}

fn is_truth(reference: &Reference) -> bool {
    matches!(reference, Reference::Truth { .. })
}

fn in_words(page: &Page<'_>, is_meant: impl FnMut(&&Reference) -> bool) -> Option<String> {
    page.references.iter().find(is_meant).map(|reference| reference.in_words())
}

/// The pictures, those under one anti-aliasing side by side; before them the truth, where there is one, and
/// after them those of other programs.
fn cards(page: &Page<'_>, has_several_aa: bool) -> Vec<Card> {
    let label =
        |name: &str, aa: &str| if has_several_aa { format!("{name} · {aa}") } else { name.to_owned() };
    let card = |(index, entry): (usize, &Entry)| {
        let (method, aa) = (entry.first().method.to_string(), entry.aa());
        Card {
            id: format!("picture-{index}"),
            label: label(&method, &aa),
            aa,
            is_reference: entry.error_png.is_none(),
            picture: data_uri(&entry.picture_png),
            error: entry.error_png.as_deref().map(data_uri),
        }
    };
    let foreign = |(index, entry): (usize, &ForeignEntry)| {
        let aa = entry.judged.antialiasing.to_string();
        Card {
            id: format!("foreign-{index}"),
            label: label(&entry.judged.against_same.name, &aa),
            aa,
            is_reference: false,
            picture: data_uri(&entry.picture_png),
            error: Some(data_uri(&entry.error_png)),
        }
    };
    let truth = |(index, truth): (usize, &TruthPicture)| Card {
        id: format!("truth-{index}"),
        label: label("truth", &truth.aa),
        aa: truth.aa.clone(),
        is_reference: true,
        picture: data_uri(&truth.png),
        error: None,
    };
    let truths = page.true_pictures.iter().enumerate().map(truth);
    let of_others = page.foreign.iter().enumerate().map(foreign);
    truths.chain(page.entries.iter().enumerate().map(card)).chain(of_others).collect()
}

fn antialiasings(page: &Page<'_>) -> Vec<String> {
    let mut words: Vec<String> = page.entries.iter().map(Entry::aa).collect();
    words.dedup();
    words
}

fn charts(page: &Page<'_>, aa: String) -> Charts {
    let all: Vec<&Seeded<Measured>> =
        page.entries.iter().filter(|entry| entry.aa() == aa).map(|entry| &entry.runs).collect();
    let names: Vec<String> = all.iter().map(|runs| runs.first().method.to_string()).collect();
    let lines = names.iter().zip(&all).map(|(name, runs)| (name.as_str(), runs.first().frame_ms.as_slice()));
    let quality = |title: &str, value: fn(&Measured) -> Option<f64>| {
        let dots = |(name, runs): (&String, &&Seeded<Measured>)| {
            let ms_median = runs.mean(|measured| Some(measured.ms_median));
            Series::dots(name, ms_median.zip(runs.mean(value)).map(|(ms, quality)| [ms, quality]))
        };
        let plot = Plot {
            description: format!("{title} over milliseconds of a frame, one point for each method"),
            x: Axis::new("ms").logarithmic(),
            y: Axis::new(title),
            series: names.iter().zip(&all).map(dots).collect(),
        };
        plot.into()
    };
    let time = time_chart(page.report.run.first_frame, lines);
    if page.references.iter().any(is_truth) {
        let ssim = quality("SSIM to the truth", |measured| Some(measured.against_truth.as_ref()?.ssim));
        let psnr = quality("PSNR dB to the truth", |measured| measured.against_truth.as_ref()?.psnr_db);
        return Charts { aa, time, ssim, psnr };
    }
    let ssim = quality("SSIM", |measured| Some(measured.ssim));
    let psnr = quality("PSNR dB", |measured| measured.psnr_db);
    Charts { aa, time, ssim, psnr }
}

/// Each other program once.
fn foreign_sources<'a>(page: &Page<'a>) -> Vec<ForeignSource<'a>> {
    let mut sources: Vec<ForeignSource<'_>> = Vec::new();
    for ForeignEntry { judged, pattern, .. } in page.foreign {
        let source = ForeignSource { name: &judged.against_same.name, pattern };
        if !sources.contains(&source) {
            sources.push(source);
        }
    }
    sources
}

/// Each method once, whatever its parameters.
fn explanations(page: &Page<'_>) -> Vec<Explanation> {
    let mut explanations: Vec<Explanation> = Vec::new();
    for MethodInfo { id, title, paper, bias, .. } in
        page.entries.iter().map(|entry| entry.first().method.info())
    {
        if !explanations.iter().any(|known| known.id == *id) {
            explanations.push(Explanation { id, title, paper, bias });
        }
    }
    explanations
}

#[cfg(test)]
mod tests {
    use sheer_lab::{AgainstTruth, Judged};

    use super::{
        super::tests::{assert_sound, run_of},
        *,
    };

    fn page_of(scene: &str) -> String {
        page_against(scene, &[Reference::Same])
    }

    fn page_against(scene: &str, references: &[Reference]) -> String {
        page_with(scene, references, &[])
    }

    fn page_with(scene: &str, references: &[Reference], foreign: &[ForeignEntry]) -> String {
        let has_truth = references.iter().any(is_truth);
        let against_truth = AgainstTruth {
            ssim: 0.5,
            psnr_db: None,
            tpsnr_db: None,
            vdp_jod: None,
            flip: 0.0,
            flicker: 0.0,
            ghosting: None,
            bias: 0.0,
            rms: 0.0,
            error_map: Image::filled(2, 1, [0; 4]).unwrap(),
        };
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
            against_truth: has_truth.then(|| against_truth.clone()),
            shaded_per_pixel: 1.0,
            hits_per_pixel: 2.0,
            memory_bytes_per_pixel: 0.0,
            merged_per_pixel: 0.0,
            picture: Image::filled(2, 1, [0; 4]).unwrap(),
            error_map: None,
        };
        let entry = |method: &str, error_png| Entry {
            runs: Seeded::of(vec![measured(method)]).unwrap(),
            picture_png: b"png".to_vec(),
            error_png,
        };
        let entries = [entry("baseline", None), entry("std", Some(b"map".to_vec()))];
        let report = Comparison { run: run_of(scene), reference: "baseline".to_owned(), rows: Vec::new() };
        let truth = TruthPicture { aa: "taa".to_owned(), png: b"true".to_vec() };
        let true_pictures = if has_truth { std::slice::from_ref(&truth) } else { &[] };
        let page = Page {
            report: &report,
            references,
            entries: &entries,
            foreign,
            true_pictures,
            error_full_scale: 0.25,
        };
        text(&page).unwrap()
    }

    #[test]
    fn the_page_needs_nothing_but_itself() {
        assert_sound(page_of);
        assert!(page_of("layers").contains("data:image/png;base64,cG5n"), "the picture is not embedded");
    }

    #[test]
    fn references_are_named_in_words_and_have_columns_of_their_own() {
        const SAME: &str = "baseline</b> under the same anti-aliasing";
        const TRUTH: &str = "the truth (exact, 32 samples a pixel)";
        const TRUE_PICTURE: &str = "data:image/png;base64,dHJ1ZQ==";
        let holds = |references: &[Reference], text: &str| page_against("layers", references).contains(text);
        for references in [&[Reference::Same][..], &[Reference::TRUTH], &[Reference::Same, Reference::TRUTH]]
        {
            let [has_same, has_truth] =
                [Reference::Same, Reference::TRUTH].map(|reference| references.contains(&reference));
            assert_eq!(holds(references, SAME), has_same, "{references:?}");
            assert_eq!(holds(references, ">SSIM<"), has_same, "{references:?}");
            for text in [TRUTH, TRUE_PICTURE, ">truth SSIM<", "SSIM to the truth"] {
                assert_eq!(holds(references, text), has_truth, "{text}: {references:?}");
            }
        }
        assert_sound(|scene| page_against(scene, &[Reference::Same, Reference::TRUTH]));
    }

    #[test]
    fn pictures_of_other_programs_stand_beside_the_methods_and_say_where_they_are_from() {
        let judged = Judged {
            name: "<theirs>".to_owned(),
            frames: 1,
            ssim: 0.25,
            psnr_db: Some(12.5),
            tpsnr_db: None,
            vdp_jod: None,
            flip: 0.125,
            flicker: None,
            rms: 0.0625,
            bias: -0.03125,
            picture: Image::filled(2, 1, [0; 4]).unwrap(),
            error_map: Image::filled(2, 1, [0; 4]).unwrap(),
        };
        let judged = ForeignJudged {
            antialiasing: Antialiasing::TAA,
            against_same: judged,
            against_truth: None,
            ghosting: None,
            in_linear_light: true,
        };
        let entry = ForeignEntry {
            judged,
            pattern: "their/####.png".to_owned(),
            picture_png: b"foreign".to_vec(),
            error_png: b"wrong".to_vec(),
        };
        let page = page_with("layers", &[Reference::Same], std::slice::from_ref(&entry));
        for held in ["&lt;theirs&gt;", "their&#x2f;####.png", "Zm9yZWlnbg==", "d3Jvbmc=", "12.50", "0.1250"] {
            assert!(page.contains(held), "{held} is not in the page");
        }
        assert!(!page.contains("<theirs>"));
        assert_sound(|scene| page_with(scene, &[Reference::Same], std::slice::from_ref(&entry)));
    }

    #[test]
    fn a_figure_that_was_not_asked_for_has_no_column() {
        let page = page_of("layers");
        assert!(page.contains("tPSNR dB") && !page.contains("VDP JOD"));
    }
}
