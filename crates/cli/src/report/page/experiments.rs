//! `index.html` of `sheer experiments`.

use serde::Serialize;
use sheer_lab::{Figures, experiments::Claim};

use super::{data_uri, fill};
use crate::report::{
    chart::Chart,
    experiments::{Experiments, Section},
    json::Run,
};

#[derive(Serialize)]
struct Context<'a> {
    run: &'a Run,
    sections: Vec<Shown<'a>>,
}

/// A section as the template wants it.
#[derive(Serialize)]
struct Shown<'a> {
    id: &'a str,
    title: &'a str,
    source: &'a str,
    account: &'a str,
    claims: Vec<ClaimView<'a>>,
    refused: Option<&'a str>,
    held: usize,
    commands: &'a [String],
    tables: Vec<CaptionedTable<'a>>,
    plots: Vec<CaptionedChart<'a>>,
    pictures: Vec<EmbeddedPicture<'a>>,
}

/// A claim as the template wants it.
#[derive(Serialize)]
struct ClaimView<'a> {
    text: &'a str,
    /// Word of the style sheet for its sign.
    outcome: &'static str,
    remark: Option<&'a str>,
}

impl<'a> ClaimView<'a> {
    fn new(claim: &'a Claim) -> Self {
        let outcome = match claim.mark() {
            "✓" => "holds",
            "?" => "undecided",
            _ => "fails",
        };
        Self { text: &claim.text, outcome, remark: claim.remark.as_deref() }
    }
}

#[derive(Serialize)]
struct CaptionedTable<'a> {
    caption: &'a str,
    figures: &'a Figures,
}

#[derive(Serialize)]
struct CaptionedChart<'a> {
    caption: &'a str,
    chart: Chart,
}

#[derive(Serialize)]
struct EmbeddedPicture<'a> {
    label: &'a str,
    data: String,
}

/// The page as text.
///
/// # Errors
/// If the template is broken, which the tests would have found.
pub(crate) fn text(report: &Experiments) -> anyhow::Result<String> {
    let sections = report.sections.iter().map(shown).collect();
    fill("experiments.html", Context { run: &report.run, sections })
}

fn shown(section: &Section) -> Shown<'_> {
    let Section { id, title, source, account, findings, pictures_png, refused } = section;
    Shown {
        id,
        title,
        source,
        account,
        claims: findings.claims.iter().map(ClaimView::new).collect(),
        refused: refused.as_deref(),
        held: findings.claims.iter().filter(|claim| claim.holds).count(),
        commands: &findings.commands,
        tables: findings
            .tables
            .iter()
            .map(|(caption, figures)| CaptionedTable { caption, figures })
            .collect(),
        plots: (findings.plots.iter())
            .map(|(caption, plot)| CaptionedChart { caption, chart: plot.clone().into() })
            .collect(),
        pictures: (findings.pictures.iter().zip(pictures_png))
            .map(|(picture, png)| EmbeddedPicture { label: &picture.label, data: data_uri(png) })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::tests::{assert_sound, run_of},
        *,
    };
    use sheer_image::Image;
    use sheer_lab::{
        Datum,
        experiments::{Findings, Picture},
        plot::{Axis, Plot, Series},
    };

    fn report(name: &str) -> Experiments {
        let plot = Plot {
            description: name.to_owned(),
            x: Axis::new("s"),
            y: Axis::new("ms"),
            series: vec![Series::line(name, [[0.0, 1.0], [1.0, 2.0]])],
        };
        let findings = Findings {
            claims: vec![Claim::new(name, true), Claim::new("no", false)],
            commands: vec![format!("sheer render {name}")],
            tables: vec![(
                name.to_owned(),
                Figures::of_data(&["a"], vec![vec![Datum::Word(name.to_owned())]]),
            )],
            plots: vec![(name.to_owned(), plot)],
            pictures: vec![Picture { label: name.to_owned(), image: Image::filled(1, 1, [0; 4]).unwrap() }],
        };
        let section = Section {
            id: "one",
            title: "One",
            source: "A paper",
            account: "How.",
            findings,
            pictures_png: vec![b"png".to_vec()],
            refused: None,
        };
        Experiments { run: run_of(name), sections: vec![section] }
    }

    #[test]
    fn the_page_needs_nothing_but_itself() {
        assert_sound(|name| text(&report(name)).unwrap());
        assert!(text(&report("layers")).unwrap().contains("1 of 2 hold"));
    }

    #[test]
    fn what_a_backend_does_not_run_is_said_everywhere() {
        let mut report = report("layers");
        report.sections[0].refused = Some("one sample a pixel is all it has".to_owned());
        let page = text(&report).unwrap();
        for form in [page, report.markdown("."), report.verdicts(), report.json().unwrap()] {
            assert!(form.contains("one sample a pixel is all it has"), "{form}");
        }
    }

    #[test]
    fn the_text_names_the_files_that_are_written() {
        let report = report("layers");
        let text = report.markdown("folder");
        for file in [report.sections[0].picture_file(0), report.sections[0].chart_file(0)] {
            assert!(text.contains(&format!("(folder/{file})")), "{text}");
        }
        assert!(text.contains("* ✓ layers") && text.contains("* ✗ no"));
    }

    #[test]
    fn a_chart_file_is_a_picture_by_itself() {
        let plot = report("layers").sections.remove(0).findings.plots.remove(0).1;
        let svg = super::super::chart_file(plot).unwrap();
        assert!(
            svg.starts_with("<svg xmlns=") && svg.contains("<style>") && svg.trim_end().ends_with("</svg>")
        );
        assert!(svg.contains("polyline") && !svg.contains("&lt;"), "{svg}");
    }
}
