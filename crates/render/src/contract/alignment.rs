//! How motion vectors are aligned to dithering patterns that are fixed to the screen (STD section 3.3.1).

use sheer_core::{choice, parameter::ParameterInfo};

choice! {
    /// To which of the multiples of a pattern's side a motion vector goes.
    pub enum AlignmentRule {
        /// One of the four nearest, drawn by bilinear weight, so that the mean motion stays what it is (STD
        /// Listing 5).
        Random = "on",
        /// None of them: the vector stays as it is.
        Off = "off",
        /// The nearest, which lags behind slow motion (STD section 3.3.1 says so and does not do it).
        Nearest = "round",
        /// As [`Self::Random`] after a component shorter than [`Self::DEAD_ZONE`] of the picture's side has
        /// become 0; and what rectifies the history clips it to a box, not to an ellipsoid. So does the
        /// authors' own code (Falcor's `TAA` pass and their `DitherVBuffer2`).
        DeadZone = "dead",
    }
}

impl AlignmentRule {
    /// Share of the picture's width, or height, below which a component of the motion counts as none, with
    /// [`Self::DeadZone`].
    pub const DEAD_ZONE: f32 = 1e-4;

    /// The key for the alignment, which every method takes whose pattern is fixed to the screen.
    pub(crate) const PARAMETER: ParameterInfo = Self::parameter(
        "align",
        Self::Random,
        "under taa: align motion vectors to the dithering pattern, at random as in the paper; off shows what that prevents; \
         round: to the nearest place; dead: as in the authors' code, where the least motion counts as none and history is \
         clipped to a box",
    );
}

/// How the motion vectors of a method's transparent fragments are aligned to its dithering pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alignment {
    /// Side of the pattern, pixels.
    pub side_px: u32,
    /// What becomes of a vector.
    pub rule: AlignmentRule,
}

impl Alignment {
    /// Motion vectors stay as they are.
    pub const NONE: Self = Self { side_px: 1, rule: AlignmentRule::Off };
}
