//! Tables for terminals.

use sheer_core::text::printable;
use sheer_lab::Figures;

/// Lines of cells under a heading, columns lined up: the first to the left, the others to the right.
#[derive(Debug)]
pub(crate) struct Table {
    lines: Vec<Vec<String>>,
}

impl Table {
    /// A table with a heading and no lines.
    pub(crate) fn new(heading: &[&str]) -> Self {
        Self { lines: vec![heading.iter().map(|&cell| cell.to_owned()).collect()] }
    }

    /// Figures of any kind.
    pub(crate) fn of(figures: &Figures) -> Self {
        let mut table = Self::new(&figures.titles().collect::<Vec<_>>());
        figures.rows().for_each(|row| table.add(row.map(str::to_owned).collect()));
        table
    }

    /// Adds a line of as many cells as the heading has.
    pub(crate) fn add(&mut self, cells: Vec<String>) {
        self.lines.push(cells.iter().map(|cell| printable(cell).into_owned()).collect());
    }

    /// As text, one line each.
    pub(crate) fn text(&self) -> String {
        let columns = self.lines.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            let cells = self.lines.iter().filter_map(|line| line.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let line = |cells: &Vec<String>| {
            let padded = cells.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column {
                0 => format!("{cell:<width$}"),
                _ => format!("{cell:>width$}"),
            });
            format!("{}\n", padded.collect::<Vec<_>>().join("  ").trim_end())
        };
        self.lines.iter().map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up_whatever_their_characters() {
        let mut table = Table::new(&["method", "ms"]);
        table.add(vec!["std".to_owned(), "7.5".to_owned()]);
        table.add(vec!["über".to_owned(), "–".to_owned()]);
        assert_eq!(table.text(), "method   ms\nstd     7.5\nüber      –\n");
    }
}
