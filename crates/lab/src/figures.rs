//! Tables of figures, the same for terminal and page.

use serde::Serialize;

use crate::{Seeded, seeded::Estimate};

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
    /// Whether it is measured by a clock, so that it differs from run to run where nothing is random.
    pub is_time: bool,
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
    #[serde(skip)]
    is_time: bool,
}

impl Heading {
    fn of_names(title: &'static str) -> Self {
        Self { title, meaning: "", is_number: false, decimals: 0, is_time: false }
    }

    fn of_figures<R>(column: &Column<R>) -> Self {
        let Column { title, meaning, decimals, is_time, .. } = *column;
        Self { title, meaning, is_number: true, decimals, is_time }
    }
}

/// The column that says how many seeds a row is the mean of, where there are several.
const SEEDS: Heading = Heading {
    title: "seeds",
    meaning: "How many seeds the figures of the row are means over, each with half of its 95 % confidence interval (Student's t). 1: a single run, which stands for all seeds where it has ±0. A dash: pictures of another program.",
    is_number: true,
    decimals: 0,
    is_time: false,
};

#[derive(Debug, Serialize)]
struct Cell {
    text: String,
    value: Option<f64>,
    /// Of the 95 % confidence interval, where there is one.
    #[serde(skip)]
    half_width: Option<f64>,
}

impl Cell {
    fn word(text: String) -> Self {
        Self { text, value: None, half_width: None }
    }

    fn number(value: Option<f64>, decimals: usize) -> Self {
        Self { text: number(value, decimals), value, half_width: None }
    }

    fn estimate(Estimate { mean, half_width }: Estimate, decimals: usize) -> Self {
        let text = number(mean, decimals);
        let text = match half_width {
            Some(half_width) => format!("{text} ±{}", uncertainty(half_width, decimals)),
            None => text,
        };
        Self { text, value: mean, half_width }
    }
}

impl Figures {
    /// The columns that have figures, for all rows.
    pub fn new<'c, 'r, R: 'c + 'r>(
        names: &[Name<R>],
        columns: impl IntoIterator<Item = &'c Column<R>>,
        rows: impl IntoIterator<Item = &'r R>,
    ) -> Self {
        let rows: Vec<&R> = rows.into_iter().collect();
        let columns = shown(columns, &rows);
        let row = |row: &&R| {
            let named = names.iter().map(|(_, name)| Cell::word(name(row)));
            let counted = columns.iter().map(|column| Cell::number((column.value)(row), column.decimals));
            named.chain(counted).collect()
        };
        let rows = rows.iter().map(row).collect();
        let named = names.iter().map(|&(title, _)| Heading::of_names(title));
        let counted = columns.iter().map(|&column| Heading::of_figures(column));
        Self { headings: named.chain(counted).collect(), rows }
    }

    /// The same of what was measured with several seeds: means with their 95 % confidence intervals, and how
    /// many seeds there are; where nothing has more than one, the table of those.
    pub fn over_seeds<'c, 'r, R: 'c + 'r>(
        names: &[Name<R>],
        columns: impl IntoIterator<Item = &'c Column<R>>,
        rows: impl IntoIterator<Item = &'r Seeded<R>>,
    ) -> Self {
        let rows: Vec<&Seeded<R>> = rows.into_iter().collect();
        if rows.iter().all(|row| row.count() == 1) {
            return Self::new(names, columns, rows.iter().map(|row| row.first()));
        }
        let runs: Vec<&R> = rows.iter().flat_map(|row| row.runs()).collect();
        let columns = shown(columns, &runs);
        let row = |row: &&Seeded<R>| {
            let named = names.iter().map(|(_, name)| Cell::word(name(row.first())));
            let seeds = Cell::number(Some(row.count() as f64), SEEDS.decimals);
            let counted = columns.iter().map(|column| {
                let estimate = row.estimate(column.is_time, column.value);
                match column.decimals {
                    // Counts and bytes, not what is measured.
                    0 => Cell::number(estimate.mean, 0),
                    decimals => Cell::estimate(estimate, decimals),
                }
            });
            named.chain([seeds]).chain(counted).collect()
        };
        let rows = rows.iter().map(row).collect();
        let named = names.iter().map(|&(title, _)| Heading::of_names(title));
        let counted = columns.iter().map(|&column| Heading::of_figures(column));
        Self { headings: named.chain([SEEDS]).chain(counted).collect(), rows }
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
            .map(|(at, &title)| Heading { is_number: is_number(at), ..Heading::of_names(title) })
            .collect();
        let cell = |datum: Datum| match datum {
            Datum::Word(text) => Cell::word(text),
            Datum::Number(value, decimals) => Cell::number(value, decimals),
        };
        Self { headings, rows: rows.into_iter().map(|row| row.into_iter().map(cell).collect()).collect() }
    }

    /// Adds a row of these names, with the figures that there are under the titles.
    pub(crate) fn add_row(&mut self, names: &[String], figure: impl Fn(&str) -> Option<f64>) {
        let names = names.iter().map(|name| Cell::word(name.clone()));
        let counted = self.headings.iter().filter(|heading| heading.is_number);
        let counted = counted.map(|heading| Cell::number(figure(heading.title), heading.decimals));
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

    /// Half of the 95 % confidence intervals of the cells, row by row, where they have one.
    pub fn half_widths(&self) -> impl Iterator<Item = impl Iterator<Item = Option<f64>>> {
        self.rows.iter().map(|row| row.iter().map(|cell| cell.half_width))
    }

    /// Whether a figure of a column has an interval, by the column's place.
    #[must_use]
    pub fn has_intervals(&self, column: usize) -> bool {
        self.rows.iter().any(|row| row.get(column).is_some_and(|cell| cell.half_width.is_some()))
    }

    /// What has the same figures with every seed, but for times: the first name of such rows, each once.
    #[must_use]
    pub fn certain(&self) -> Vec<&str> {
        let is_certain = |row: &&Vec<Cell>| {
            let untimed = self.headings.iter().zip(*row).filter(|(heading, _)| !heading.is_time);
            let mut half_widths = untimed.filter_map(|(_, cell)| cell.half_width).peekable();
            half_widths.peek().is_some() && half_widths.all(|half_width| half_width == 0.0)
        };
        let names = |is_meant: &dyn Fn(&&Vec<Cell>) -> bool| -> Vec<&str> {
            self.rows.iter().filter(is_meant).filter_map(|row| Some(row.first()?.text.as_str())).collect()
        };
        // Under another anti-aliasing it may be random.
        let random = names(&|row| !is_certain(row));
        let mut certain = names(&is_certain);
        certain.retain(|name| !random.contains(name));
        certain.dedup();
        certain
    }

    /// The texts of the cells, row by row.
    pub fn rows(&self) -> impl Iterator<Item = impl Iterator<Item = &str>> {
        self.rows.iter().map(|row| row.iter().map(|cell| cell.text.as_str()))
    }
}

/// The columns that have figures, or are there without.
fn shown<'c, R>(columns: impl IntoIterator<Item = &'c Column<R>>, rows: &[&R]) -> Vec<&'c Column<R>> {
    let is_shown =
        |column: &&Column<R>| !column.is_optional || rows.iter().any(|row| (column.value)(row).is_some());
    columns.into_iter().filter(is_shown).collect()
}

/// Half of an interval with the decimals of its mean, or as many more as show its first digit: what is not
/// certain does not look as if it were.
fn uncertainty(half_width: f64, decimals: usize) -> String {
    /// Digits of a double.
    const MOST_DECIMALS: usize = 17;
    if half_width == 0.0 {
        return "0".to_owned();
    }
    let has_digit = |text: &String| text.bytes().any(|byte| (b'1'..=b'9').contains(&byte));
    let texts = (decimals..=MOST_DECIMALS).map(|decimals| format!("{half_width:.decimals$}"));
    texts.into_iter().find(has_digit).unwrap_or_else(|| format!("{half_width:e}"))
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

    /// Something that is measured by a clock, and something that is not.
    type Row = (f64, Option<f64>);

    const COLUMNS: [Column<Row>; 3] = [
        Column {
            title: "frames",
            meaning: "",
            decimals: 0,
            is_optional: false,
            is_time: false,
            value: |_| Some(4.0),
        },
        Column {
            title: "ms",
            meaning: "",
            decimals: 1,
            is_optional: false,
            is_time: true,
            value: |row| Some(row.0),
        },
        Column {
            title: "error",
            meaning: "",
            decimals: 2,
            is_optional: false,
            is_time: false,
            value: |row| row.1,
        },
    ];

    fn over_seeds(rows: &[Seeded<Row>]) -> Figures {
        Figures::over_seeds(&[("method", |row: &Row| format!("of {}", row.0))], &COLUMNS, rows)
    }

    #[test]
    fn figures_of_several_seeds_have_their_interval() {
        let random = Seeded::of(vec![(2.0, Some(0.5)), (4.0, Some(0.75))]).unwrap();
        let alike = Seeded::of(vec![(1.0, Some(0.25)), (3.0, Some(0.25))]).unwrap();
        let once = Seeded::once_for_all((9.0, Some(0.125)));
        let missing = Seeded::of(vec![(5.0, Some(0.25)), (5.0, None)]).unwrap();
        let slight = Seeded::of(vec![(5.0, Some(1.0)), (5.0, Some(1.000_001))]).unwrap();
        let figures = over_seeds(&[random, alike, once, missing, slight]);
        assert_eq!(figures.titles().collect::<Vec<_>>(), ["method", "seeds", "frames", "ms", "error"]);
        let rows: Vec<Vec<&str>> = figures.rows().map(Iterator::collect).collect();
        // Half of an interval of two numbers is tan(0.475 π) = 12.7062 times half of their difference.
        assert_eq!(
            rows,
            [
                ["of 2", "2", "4", "3.0 ±12.7", "0.62 ±1.59"],
                ["of 1", "2", "4", "2.0 ±12.7", "0.25 ±0"],
                ["of 9", "1", "4", "9.0", "0.12 ±0"],
                ["of 5", "2", "4", "5.0 ±0", "–"],
                ["of 5", "2", "4", "5.0 ±0", "1.00 ±0.00001"],
            ]
        );
        assert_eq!(figures.certain(), ["of 1", "of 9"]);
        let half_widths: Vec<Vec<_>> = figures.half_widths().map(Iterator::collect).collect();
        assert_eq!((half_widths[1][4], half_widths[2][3], half_widths[3][4]), (Some(0.0), None, None));
        assert!((half_widths[0][4].unwrap() - 12.706_2 * 0.125).abs() < 1e-4, "{half_widths:?}");
        assert!([3, 4].into_iter().all(|column| figures.has_intervals(column)) && !figures.has_intervals(2));
    }

    #[test]
    fn figures_of_one_seed_are_as_they_were() {
        let once = over_seeds(&[Seeded::of(vec![(2.0, Some(0.5))]).unwrap()]);
        assert_eq!(once.titles().collect::<Vec<_>>(), ["method", "frames", "ms", "error"]);
        assert_eq!(
            once.rows().map(Iterator::collect::<Vec<_>>).collect::<Vec<_>>(),
            [["of 2", "4", "2.0", "0.50"]]
        );
        assert!(once.certain().is_empty());
    }
}
