//! What `sheer experiments` found: for a page, for programs and as text.

use std::fmt::Write as _;

use serde::Serialize;
use sheer_image::{Metadata, encode_png};
use sheer_lab::{
    Figures,
    experiments::{Claim, Experiment, Findings},
};
use sheer_render::Backend;

use super::{json::Run, table::Table};

/// An experiment that was made.
#[derive(Debug)]
pub(crate) struct Section {
    /// For file names and links.
    pub(crate) id: &'static str,
    /// What it shows.
    pub(crate) title: &'static str,
    /// Paper and figure.
    pub(crate) source: &'static str,
    /// What is done, and where and why the outcome differs from the paper's.
    pub(crate) account: &'static str,
    pub(crate) findings: Findings,
    /// The pictures of the findings as PNG.
    pub(crate) pictures_png: Vec<Vec<u8>>,
    /// Why the backend does not run the experiment, which has no findings then.
    pub(crate) refused: Option<String>,
}

/// All that were made in a run.
#[derive(Debug)]
pub(crate) struct Experiments {
    pub(crate) run: Run,
    pub(crate) sections: Vec<Section>,
}

#[derive(Serialize)]
struct JsonReport<'a> {
    #[serde(flatten)]
    run: &'a Run,
    experiments: Vec<JsonSection<'a>>,
}

#[derive(Serialize)]
struct JsonSection<'a> {
    id: &'a str,
    title: &'a str,
    source: &'a str,
    claims: &'a [Claim],
    commands: &'a [String],
    tables: Vec<JsonTable<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<&'a str>,
}

#[derive(Serialize)]
struct JsonTable<'a> {
    caption: &'a str,
    #[serde(flatten)]
    figures: &'a Figures,
}

impl<'a> JsonSection<'a> {
    fn new(section: &'a Section) -> Self {
        let Section { id, title, source, ref findings, .. } = *section;
        let tables = findings.tables.iter().map(|(caption, figures)| JsonTable { caption, figures });
        let (claims, commands) = (&findings.claims, &findings.commands);
        let refused = section.refused.as_deref();
        Self { id, title, source, claims, commands, tables: tables.collect(), refused }
    }
}

impl Experiments {
    /// For programs.
    pub(crate) fn json(&self) -> anyhow::Result<String> {
        let experiments = self.sections.iter().map(JsonSection::new).collect();
        super::json::text(&JsonReport { run: &self.run, experiments })
    }

    /// For the terminal: what held and what did not.
    pub(crate) fn verdicts(&self) -> String {
        let mut text = String::new();
        for section in &self.sections {
            let _ = writeln!(text, "{} ({})", section.title, section.source);
            for claim in &section.findings.claims {
                let _ = writeln!(text, "  {}", line(claim));
            }
            if let Some(refused) = &section.refused {
                let _ = writeln!(text, "  – not run: {refused}");
            }
        }
        text
    }

    /// As Markdown that refers to pictures and charts by [`Section::picture_file`] and
    /// [`Section::chart_file`] in `folder`.
    pub(crate) fn markdown(&self, folder: &str) -> String {
        let Run { size: [width, height], threads, adapter, commit, seed, .. } = &self.run;
        let mut text = format!(
            "# Results\n\nMade by `sheer experiments` at {width}x{height} on {threads} threads ({adapter}), commit `{commit}`, seed {seed}.\n\n\
             Times are those of this machine and good to compare with one another only. A cross marks what did not come out as the paper, or we, say, a question mark what the seeds do not decide.\n"
        );
        for section in &self.sections {
            section.write_markdown(&mut text, folder);
        }
        text
    }
}

/// A claim with its sign in front, and behind it what follows.
fn line(claim: &Claim) -> String {
    let Claim { text, remark, .. } = claim;
    let remark = remark.as_ref().map(|remark| format!(". {remark}")).unwrap_or_default();
    format!("{} {text}{remark}", claim.mark())
}

impl Section {
    /// Encodes the pictures.
    ///
    /// # Errors
    /// There is no memory for them.
    pub(crate) fn new<B: Backend>(experiment: &Experiment<B>, findings: Findings) -> anyhow::Result<Self> {
        let &Experiment { id, title, source, account, .. } = experiment;
        let pictures = findings.pictures.iter();
        let pictures_png = pictures.map(|picture| encode_png(&picture.image, &Metadata::default()));
        let pictures_png = pictures_png.collect::<Result<_, _>>()?;
        Ok(Self { id, title, source, account, findings, pictures_png, refused: None })
    }

    /// An experiment that the backend does not run, and why.
    pub(crate) fn refused<B: Backend>(experiment: &Experiment<B>, why: String) -> Self {
        let &Experiment { id, title, source, account, .. } = experiment;
        let (findings, pictures_png) = (Findings::default(), Vec::new());
        Self { id, title, source, account, findings, pictures_png, refused: Some(why) }
    }

    /// Name of a picture's file.
    pub(crate) fn picture_file(&self, at: usize) -> String {
        format!("{}-{}.png", self.id, at + 1)
    }

    /// Name of a chart's file.
    pub(crate) fn chart_file(&self, at: usize) -> String {
        format!("{}-{}.svg", self.id, at + 1)
    }

    fn write_markdown(&self, text: &mut String, folder: &str) {
        let Findings { claims, commands, tables, plots, pictures } = &self.findings;
        let _ = write!(text, "\n## {}\n\n*{}.* {}\n\n", self.title, self.source, self.account);
        for claim in claims {
            let _ = writeln!(text, "* {}", line(claim));
        }
        if let Some(refused) = &self.refused {
            let _ = writeln!(text, "* – not run: {refused}");
        }
        if !commands.is_empty() {
            let _ = write!(text, "\n```sh\n{}\n```\n", commands.join("\n"));
        }
        for (caption, figures) in tables {
            let _ = write!(text, "\n{caption}\n\n```text\n{}```\n", Table::of(figures).text());
        }
        for (at, (caption, plot)) in plots.iter().enumerate() {
            let _ =
                write!(text, "\n{caption}\n\n![{}]({folder}/{})\n", plot.description, self.chart_file(at));
        }
        // Three in a row, each above its name.
        for (row, shown) in pictures.chunks(3).enumerate() {
            let files =
                (0..shown.len()).map(|at| format!("![]({folder}/{})", self.picture_file(3 * row + at)));
            let names = shown.iter().map(|picture| picture.label.clone());
            let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
            let rule = line(vec!["---".to_owned(); shown.len()]);
            let _ = write!(text, "\n{}{rule}{}", line(names.collect()), line(files.collect()));
        }
    }
}
