//! What a chart shows: axes and series of values. How it is drawn is not said here.

/// What a chart shows.
#[derive(Clone, Debug)]
pub struct Plot {
    /// For those who do not see it.
    pub description: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Colours go by their order.
    pub series: Vec<Series>,
}

/// An axis: linear, as wide as the values need.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it measures, with the unit.
    pub title: String,
    /// Whether equal ratios take equal space.
    pub is_logarithmic: bool,
    /// Whether zero is shown, whatever the values.
    pub begins_at_zero: bool,
    /// Whether there are whole numbers only.
    pub counts: bool,
}

impl Axis {
    /// The title says the unit.
    #[must_use]
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), is_logarithmic: false, begins_at_zero: false, counts: false }
    }

    /// Equal ratios take equal space; what is not above 0 is left out.
    #[must_use]
    pub fn logarithmic(self) -> Self {
        Self { is_logarithmic: true, ..self }
    }

    /// Shows the zero, whatever the values.
    #[must_use]
    pub fn with_zero(self) -> Self {
        Self { begins_at_zero: true, ..self }
    }

    /// Has whole numbers only.
    #[must_use]
    pub fn of_counts(self) -> Self {
        Self { counts: true, ..self }
    }

    /// Whether a value has a place on it.
    #[must_use]
    pub fn has(&self, value: f64) -> bool {
        value.is_finite() && (value > 0.0 || !self.is_logarithmic)
    }
}

/// Values under one name.
#[derive(Clone, Debug)]
pub struct Series {
    /// Whose values they are.
    pub name: String,
    /// How they are drawn.
    pub mark: Mark,
    /// Whether the points of a line have dots.
    pub marks_points: bool,
    /// Horizontal and vertical coordinate of each.
    pub points: Vec<[f64; 2]>,
    /// Horizontal coordinate, and the two ends of what is shaded there.
    pub band: Vec<[f64; 3]>,
}

/// How values are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Joined from left to right.
    Line,
    /// Each by itself.
    Dots,
    /// As a line in the background, to compare with.
    Guide,
}

impl Series {
    /// Points joined from left to right. Where a coordinate is not finite, the line is broken.
    #[must_use]
    pub fn line(name: &str, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let points = points.into_iter().collect();
        Self { name: name.to_owned(), mark: Mark::Line, marks_points: false, points, band: Vec::new() }
    }

    /// Points by themselves, the last with the name.
    #[must_use]
    pub fn dots(name: &str, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self { mark: Mark::Dots, ..Self::line(name, points) }
    }

    /// A line to compare with, in the background.
    #[must_use]
    pub fn guide(name: &str, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self { mark: Mark::Guide, ..Self::line(name, points) }
    }

    /// Marks the points of a line.
    #[must_use]
    pub fn with_dots(self) -> Self {
        Self { marks_points: true, ..self }
    }

    /// Shades an area from the second to the third number above the first: least to most, or an interval.
    #[must_use]
    pub fn with_band(self, band: impl IntoIterator<Item = [f64; 3]>) -> Self {
        Self { band: band.into_iter().collect(), ..self }
    }
}
