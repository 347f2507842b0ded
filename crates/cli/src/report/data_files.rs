//! The figures of a table for spreadsheets (CSV) and papers (LaTeX).

use std::fmt::Write as _;

use sheer_lab::Figures;

use crate::{args::DataArguments, output::TextOutput};

/// Where a table goes beside the terminal.
#[derive(Debug)]
pub(crate) struct DataFiles<'a> {
    csv: Option<TextOutput<'a>>,
    latex: Option<TextOutput<'a>>,
}

impl<'a> DataFiles<'a> {
    /// Finds out whether the files can be written.
    pub(crate) fn open(arguments: &'a DataArguments) -> anyhow::Result<Self> {
        let open = |path: &'a Option<std::path::PathBuf>| path.as_deref().map(TextOutput::open).transpose();
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

/// Comma-separated values (RFC 4180), with all digits that there are; what is missing is empty.
fn csv(figures: &Figures) -> String {
    let quoted = |text: &str| {
        if text.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    let mut text = figures.titles().map(quoted).collect::<Vec<_>>().join(",") + "\r\n";
    for row in figures.cells() {
        let cells = row.enumerate().map(|(column, (cell, value))| match value {
            Some(value) => value.to_string(),
            None if figures.is_number(column) => String::new(),
            None => quoted(cell),
        });
        text += &(cells.collect::<Vec<_>>().join(",") + "\r\n");
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
                other => escaped.push(other),
            }
        }
        escaped
    };
    let line = |cells: Vec<String>| cells.join(" & ") + " \\\\\n";
    let count = figures.titles().count();
    let columns: String =
        (0..count).map(|column| if figures.is_number(column) { 'r' } else { 'l' }).collect();
    let mut text = format!("\\begin{{tabular}}{{{columns}}}\n\\toprule\n");
    text += &line(figures.titles().map(escaped).collect());
    text += "\\midrule\n";
    for row in figures.rows() {
        let _ = write!(text, "{}", line(row.map(escaped).collect()));
    }
    text + "\\bottomrule\n\\end{tabular}\n"
}

#[cfg(test)]
mod tests {
    use sheer_lab::Datum;

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
}
