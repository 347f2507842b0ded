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
    /// Whether they do so in its favour.
    pub holds: bool,
}

/// A picture with its name.
#[derive(Clone, Debug)]
pub struct Picture {
    /// What is seen.
    pub label: String,
    /// As a display shows it: sRGB, straight alpha.
    pub image: Image<[u8; 4]>,
}
