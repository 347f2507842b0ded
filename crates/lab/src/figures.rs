//! Tables of figures, the same for terminal and page.

use serde::Serialize;

/// A figure of a row.
#[derive(Debug)]
pub struct Column<R> {
    /// Its heading.
    pub title: &'static str,
    /// What it means, in plain words.
    pub meaning: &'static str,
    /// Digits after the point.
    pub decimals: usize,
    /// Left out where no row has it.
    pub is_optional: bool,
    /// Of a row.
    pub value: fn(&R) -> Option<f64>,
}

/// What titles of figures against the truth begin with.
pub(crate) const TRUTH_PREFIX: &str = "truth ";

/// A word that says which row it is: its heading and where it comes from.
pub type Name<R> = (&'static str, fn(&R) -> String);

/// What stands in a cell of a table that is put together by hand.
#[derive(Clone, Debug)]
pub enum Datum {
    /// A name.
    Word(String),
    /// A figure with so many decimals, or a dash.
    Number(Option<f64>, usize),
}

/// Rows under headings; the first column names them.
#[derive(Debug, Serialize)]
pub struct Figures {
    headings: Vec<Heading>,
    rows: Vec<Vec<Cell>>,
}

#[derive(Debug, Serialize)]
struct Heading {
    title: &'static str,
    meaning: &'static str,
    is_number: bool,
    /// Of its figures, where it has any.
    #[serde(skip)]
    decimals: usize,
}

#[derive(Debug, Serialize)]
struct Cell {
    text: String,
    value: Option<f64>,
}

impl Figures {
    /// The columns that have figures, for all rows.
    pub fn new<'c, 'r, R: 'c + 'r>(
        names: &[Name<R>],
        columns: impl IntoIterator<Item = &'c Column<R>>,
        rows: impl IntoIterator<Item = &'r R>,
    ) -> Self {
        let rows: Vec<&R> = rows.into_iter().collect();
        let is_shown =
            |column: &&Column<R>| !column.is_optional || rows.iter().any(|row| (column.value)(row).is_some());
        let columns: Vec<&Column<R>> = columns.into_iter().filter(is_shown).collect();
        let named =
            names.iter().map(|&(title, _)| Heading { title, meaning: "", is_number: false, decimals: 0 });
        let counted = columns.iter().map(|&&Column { title, meaning, decimals, .. }| Heading {
            title,
            meaning,
            is_number: true,
            decimals,
        });
        let cells = |row: &&R| {
            let named = names.iter().map(|(_, name)| Cell { text: name(row), value: None });
            let counted = columns.iter().map(|column| {
                let value = (column.value)(row);
                Cell { text: number(value, column.decimals), value }
            });
            named.chain(counted).collect()
        };
        Self { headings: named.chain(counted).collect(), rows: rows.iter().map(cells).collect() }
    }

    /// Headings with rows of their own; a column after the first is one of figures if its first cell is one.
    pub fn of_data(titles: &[&'static str], rows: Vec<Vec<Datum>>) -> Self {
        let is_number = |at: usize| {
            at > 0
                && rows
                    .first()
                    .and_then(|row| row.get(at))
                    .is_some_and(|datum| matches!(datum, Datum::Number(..)))
        };
        let headings = titles.iter().enumerate();
        let headings = headings
            .map(|(at, &title)| Heading { title, meaning: "", is_number: is_number(at), decimals: 0 })
            .collect();
        let cell = |datum: Datum| match datum {
            Datum::Word(text) => Cell { text, value: None },
            Datum::Number(value, decimals) => Cell { text: number(value, decimals), value },
        };
        Self { headings, rows: rows.into_iter().map(|row| row.into_iter().map(cell).collect()).collect() }
    }

    /// Adds a row of these names, with the figures that there are under the titles.
    pub(crate) fn add_row(&mut self, names: &[String], figure: impl Fn(&str) -> Option<f64>) {
        let names = names.iter().map(|name| Cell { text: name.clone(), value: None });
        let counted = self.headings.iter().filter(|heading| heading.is_number).map(|heading| {
            let value = figure(heading.title);
            Cell { text: number(value, heading.decimals), value }
        });
        self.rows.push(names.chain(counted).collect());
    }

    /// The headings, in order.
    pub fn titles(&self) -> impl Iterator<Item = &str> {
        self.headings.iter().map(|heading| heading.title)
    }

    /// Whether a column has figures, by its place.
    #[must_use]
    pub fn is_number(&self, column: usize) -> bool {
        self.headings.get(column).is_some_and(|heading| heading.is_number)
    }

    /// Texts and figures of the cells, row by row: a figure with all its digits where there is one.
    pub fn cells(&self) -> impl Iterator<Item = impl Iterator<Item = (&str, Option<f64>)>> {
        self.rows.iter().map(|row| row.iter().map(|cell| (cell.text.as_str(), cell.value)))
    }

    /// The texts of the cells, row by row.
    pub fn rows(&self) -> impl Iterator<Item = impl Iterator<Item = &str>> {
        self.rows.iter().map(|row| row.iter().map(|cell| cell.text.as_str()))
    }
}

/// A number with so many decimals, or a dash where there is none.
#[must_use]
pub fn number(value: impl Into<Option<f64>>, decimals: usize) -> String {
    match value.into() {
        // Rounding takes small negative numbers to a zero that has no sign.
        Some(value) if value.is_finite() => {
            let text = format!("{value:.decimals$}");
            let is_zero = text.bytes().all(|byte| b"-0.".contains(&byte));
            if is_zero { text.trim_start_matches('-').to_owned() } else { text }
        }
        _ => "–".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_round_to_zero_have_no_sign_and_missing_ones_a_dash() {
        assert_eq!(
            [number(-0.000_01, 2), number(None, 2), number(f64::NAN, 1), number(-1.25, 1)],
            ["0.00", "–", "–", "-1.2"]
        );
    }
}
