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
    pub(crate) fn new<R>(names: &[Name<R>], columns: &[Column<R>], run: &Run, rows: &[R]) -> Self {
        let is_shown = |column: &&Column<R>| {
            !column.is_optional || rows.iter().any(|row| (column.value)(run, row).is_some())
        };
        let columns: Vec<&Column<R>> = columns.iter().filter(is_shown).collect();
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
