//! Tables for terminals.

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

    /// Adds a line of as many cells as the heading has.
    pub(crate) fn add(&mut self, cells: Vec<String>) {
        self.lines.push(cells);
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

/// A number with so many decimals, or a dash where there is none.
pub(crate) fn number(value: impl Into<Option<f64>>, decimals: usize) -> String {
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
    fn columns_line_up_whatever_their_characters() {
        let mut table = Table::new(&["method", "ms"]);
        table.add(vec!["std".to_owned(), "7.5".to_owned()]);
        table.add(vec!["über".to_owned(), "–".to_owned()]);
        assert_eq!(table.text(), "method   ms\nstd     7.5\nüber      –\n");
    }

    #[test]
    fn numbers_that_round_to_zero_have_no_sign_and_missing_ones_a_dash() {
        assert_eq!(
            [number(-0.000_01, 2), number(None, 2), number(f64::NAN, 1), number(-1.25, 1)],
            ["0.00", "–", "–", "-1.2"]
        );
    }
}
