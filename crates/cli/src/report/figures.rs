//! Tables of figures, the same for terminal and page.

use serde::Serialize;

use super::{
    json::Run,
    table::{Table, number},
};

/// A figure of a row.
#[derive(Debug)]
pub(crate) struct Column<R> {
    /// Its heading.
    pub(crate) title: &'static str,
    /// What it means, in plain words.
    pub(crate) meaning: &'static str,
    pub(crate) decimals: usize,
    /// Left out where no row has it.
    pub(crate) is_optional: bool,
    pub(crate) value: fn(&Run, &R) -> Option<f64>,
}

/// A word that says which row it is: its heading and where it comes from.
pub(crate) type Name<R> = (&'static str, fn(&R) -> String);

/// What stands in a cell of a table that is put together by hand.
#[derive(Clone, Debug)]
pub(crate) enum Datum {
    /// A name.
    Word(String),
    /// A figure with so many decimals, or a dash.
    Number(Option<f64>, usize),
}

/// Rows under headings; the first column names them.
#[derive(Debug, Serialize)]
pub(crate) struct Figures {
    headings: Vec<Heading>,
    rows: Vec<Vec<Cell>>,
}

#[derive(Debug, Serialize)]
struct Heading {
    title: &'static str,
    meaning: &'static str,
    is_number: bool,
}

#[derive(Debug, Serialize)]
struct Cell {
    text: String,
    value: Option<f64>,
}

impl Figures {
    /// The columns that have figures, for all rows.
    pub(crate) fn new<'c, R>(
        names: &[Name<R>],
        columns: impl IntoIterator<Item = &'c Column<R>>,
        run: &Run,
        rows: &[R],
    ) -> Self
    where
        R: 'c,
    {
        let is_shown = |column: &&Column<R>| {
            !column.is_optional || rows.iter().any(|row| (column.value)(run, row).is_some())
        };
        let columns: Vec<&Column<R>> = columns.into_iter().filter(is_shown).collect();
        let named = names.iter().map(|&(title, _)| Heading { title, meaning: "", is_number: false });
        let counted =
            columns.iter().map(|&&Column { title, meaning, .. }| Heading { title, meaning, is_number: true });
        let cells = |row: &R| {
            let named = names.iter().map(|(_, name)| Cell { text: name(row), value: None });
            let counted = columns.iter().map(|column| {
                let value = (column.value)(run, row);
                Cell { text: number(value, column.decimals), value }
            });
            named.chain(counted).collect()
        };
        Self { headings: named.chain(counted).collect(), rows: rows.iter().map(cells).collect() }
    }

    /// Headings with rows of their own; a column after the first is one of figures if its first cell is one.
    pub(crate) fn of_data(titles: &[&'static str], rows: Vec<Vec<Datum>>) -> Self {
        let is_number = |at: usize| {
            at > 0
                && rows
                    .first()
                    .and_then(|row| row.get(at))
                    .is_some_and(|datum| matches!(datum, Datum::Number(..)))
        };
        let headings = titles.iter().enumerate();
        let headings =
            headings.map(|(at, &title)| Heading { title, meaning: "", is_number: is_number(at) }).collect();
        let cell = |datum: Datum| match datum {
            Datum::Word(text) => Cell { text, value: None },
            Datum::Number(value, decimals) => Cell { text: number(value, decimals), value },
        };
        Self { headings, rows: rows.into_iter().map(|row| row.into_iter().map(cell).collect()).collect() }
    }

    /// For the terminal.
    pub(crate) fn text(&self) -> String {
        let titles: Vec<&str> = self.headings.iter().map(|heading| heading.title).collect();
        let mut table = Table::new(&titles);
        for row in &self.rows {
            table.add(row.iter().map(|cell| cell.text.clone()).collect());
        }
        table.text()
    }
}
