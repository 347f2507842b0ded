//! What experiments hand in.

use serde::Serialize;
use sheer_image::Image;

use crate::{Figures, plot::Plot};

/// What an experiment found.
#[derive(Debug, Default)]
pub struct Findings {
    /// What was to be seen.
    pub claims: Vec<Claim>,
    /// Commands that make the figures again.
    pub commands: Vec<String>,
    /// Captions and tables.
    pub tables: Vec<(String, Figures)>,
    /// Captions and charts.
    pub plots: Vec<(String, Plot)>,
    /// Pictures to be compared.
    pub pictures: Vec<Picture>,
}

/// Something that the paper or we say, and whether the measurement bears it out.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// With the figures that decide.
    pub text: String,
    /// Whether they do so in its favour; where seeds differ, beyond chance.
    pub holds: bool,
    /// Probability that chance alone makes such a difference, 0 to 1, by a two-sided paired t-test; none
    /// where nothing is random or there is one seed.
    pub p: Option<f64>,
    /// What follows from the outcome, in a sentence.
    pub remark: Option<String>,
}

impl Claim {
    /// A claim that no chance has a part in, or that allows for chance in its text.
    #[must_use]
    pub fn new(text: impl Into<String>, holds: bool) -> Self {
        Self { text: text.into(), holds, p: None, remark: None }
    }
}

/// A picture with its name.
#[derive(Clone, Debug)]
pub struct Picture {
    /// What is seen.
    pub label: String,
    /// As a display shows it: sRGB, straight alpha.
    pub image: Image<[u8; 4]>,
}
