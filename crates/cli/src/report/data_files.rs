//! The figures of a table for spreadsheets (CSV) and papers (LaTeX).

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
};

use sheer_lab::Figures;

use crate::{
    args::DataArguments,
    failure::Misuse,
    output::{self, TextOutput},
};

impl DataArguments {
    /// Refuses to print more than one of the files and these others.
    pub(crate) fn check_stdout(&self, others: &[(&str, Option<&Path>)]) -> Result<(), Misuse> {
        let own = [("--csv", self.csv.as_deref()), ("--latex", self.latex.as_deref())];
        output::check_stdout(&[others, &own].concat())
    }
}

/// Where a table goes beside the terminal.
#[derive(Debug)]
pub(crate) struct DataFiles<'a> {
    csv: Option<TextOutput<'a>>,
    latex: Option<TextOutput<'a>>,
}

impl<'a> DataFiles<'a> {
    /// Finds out whether the files can be written.
    pub(crate) fn open(arguments: &'a DataArguments) -> anyhow::Result<Self> {
        let open = |path: &'a Option<PathBuf>| path.as_deref().map(TextOutput::open).transpose();
        Ok(Self { csv: open(&arguments.csv)?, latex: open(&arguments.latex)? })
    }

    /// Whether one of them replaces what would be printed otherwise.
    pub(crate) fn is_stdout(&self) -> bool {
        [&self.csv, &self.latex].into_iter().flatten().any(TextOutput::is_stdout)
    }

    /// Writes them.
    pub(crate) fn write(&self, figures: &Figures) -> anyhow::Result<()> {
        if let Some(csv) = &self.csv {
            csv.write(&self::csv(figures))?;
        }
        if let Some(latex) = &self.latex {
            latex.write(&self::latex(figures))?;
        }
        Ok(())
    }
}

/// Comma-separated values (RFC 4180), with all digits that there are; what is missing is empty. Half of a 95
/// % confidence interval has a column `… ci95` after its mean's.
fn csv(figures: &Figures) -> String {
    let quoted = |text: &str| {
        if text.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    // Half of an interval stands beside its mean.
    let with_interval = |column: usize, cell: String, interval: String| {
        if figures.has_intervals(column) { vec![cell, interval] } else { vec![cell] }
    };
    let line = |cells: Vec<String>| cells.join(",") + "\r\n";
    let titles = figures.titles().enumerate();
    let titles =
        titles.flat_map(|(at, title)| with_interval(at, quoted(title), quoted(&format!("{title} ci95"))));
    let mut text = line(titles.collect());
    let digits = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for (row, half_widths) in figures.cells().zip(figures.half_widths()) {
        let cells = row.zip(half_widths).enumerate().flat_map(|(column, ((cell, value), half_width))| {
            let is_word = value.is_none() && !figures.is_number(column);
            let cell = if is_word { quoted(cell) } else { digits(value) };
            with_interval(column, cell, digits(half_width))
        });
        text += &line(cells.collect());
    }
    text
}

/// A `tabular` with the rules of the package booktabs, rounded as on the terminal.
fn latex(figures: &Figures) -> String {
    let escaped = |text: &str| {
        let mut escaped = String::with_capacity(text.len());
        for character in text.chars() {
            match character {
                '&' | '%' | '$' | '#' | '_' | '{' | '}' => escaped.extend(['\\', character]),
                '\\' => escaped.push_str("\\textbackslash{}"),
                '~' => escaped.push_str("\\textasciitilde{}"),
                '^' => escaped.push_str("\\textasciicircum{}"),
                '–' => escaped.push_str("--"),
                '±' => escaped.push_str("$\\pm$"),
                other => escaped.push(other),
            }
        }
        escaped
    };
    let line = |cells: Vec<String>| cells.join(" & ") + " \\\\\n";
    let count = figures.titles().count();
    let columns: String =
        (0..count).map(|column| if figures.is_number(column) { 'r' } else { 'l' }).collect();
    let mut text = String::new();
    if (0..count).any(|column| figures.has_intervals(column)) {
        text += "% Means over seeds with half of their 95 % confidence interval (Student's t).\n";
    }
    let _ = write!(text, "\\begin{{tabular}}{{{columns}}}\n\\toprule\n");
    text += &line(figures.titles().map(escaped).collect());
    text += "\\midrule\n";
    for row in figures.rows() {
        let _ = write!(text, "{}", line(row.map(escaped).collect()));
    }
    text + "\\bottomrule\n\\end{tabular}\n"
}

#[cfg(test)]
mod tests {
    use sheer_lab::{Column, Datum, Seeded};

    use super::*;

    fn figures() -> Figures {
        let row = |name: &str, value| vec![Datum::Word(name.to_owned()), Datum::Number(value, 2)];
        Figures::of_data(
            &["method", "error %"],
            vec![row("std:hash=pcg,noise=off", Some(0.123_456)), row("a \"b\"_c", None)],
        )
    }

    #[test]
    fn csv_has_all_digits_and_quotes_what_would_break_it() {
        assert_eq!(
            csv(&figures()),
            "method,error %\r\n\"std:hash=pcg,noise=off\",0.123456\r\n\"a \"\"b\"\"_c\",\r\n"
        );
    }

    #[test]
    fn latex_is_a_table_that_compiles() {
        assert_eq!(
            latex(&figures()),
            "\\begin{tabular}{lr}\n\\toprule\nmethod & error \\% \\\\\n\\midrule\n\
             std:hash=pcg,noise=off & 0.12 \\\\\na \"b\"\\_c & -- \\\\\n\\bottomrule\n\\end{tabular}\n"
        );
    }

    #[test]
    fn intervals_stand_beside_their_means() {
        let columns = [Column::<f64> {
            title: "error %",
            meaning: "",
            decimals: 1,
            is_optional: false,
            is_time: false,
            value: |row| Some(*row),
        }];
        let rows = [Seeded::of(vec![1.0, 2.0]).unwrap(), Seeded::once_for_all(0.25)];
        let figures = Figures::over_seeds(&[("method", |row: &f64| format!("of {row}"))], &columns, &rows);
        let half_width = rows[0].estimate(false, |row| Some(*row)).half_width.unwrap();
        assert_eq!(
            csv(&figures),
            format!("method,seeds,error %,error % ci95\r\nof 1,2,1.5,{half_width}\r\nof 0.25,1,0.25,0\r\n")
        );
        let latex = latex(&figures);
        assert!(latex.starts_with("% Means") && latex.contains("of 1 & 2 & 1.5 $\\pm$6.4 \\\\\n"), "{latex}");
        assert!(latex.contains("of 0.25 & 1 & 0.2 $\\pm$0 \\\\\n"), "{latex}");
    }
}
