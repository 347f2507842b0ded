//! What comes out of a loader: a scene, and what a user should know of the way there.

use std::fmt;

use sheer_scene::Scene;

use super::contents::Contents;

/// Characters of a message that quotes from a file.
pub(super) const LONGEST_MESSAGE: usize = 600;
/// Characters of a name that are kept; messages show fewer. Names are copied to whatever refers to them.
pub(super) const LONGEST_NAME: usize = 256;

/// A scene and what was left out of it.
#[derive(Debug)]
pub struct Loaded {
    /// What was in the file, validated.
    pub scene: Scene,
    /// Things a user should know, each said once.
    pub warnings: Vec<LoadWarning>,
    /// What else the file holds.
    pub contents: Contents,
}

/// Something in a file that is shown differently from what its author meant.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LoadWarning {
    /// An optional extension that has no effect here.
    ExtensionIgnored {
        /// Name of the extension, as the file spells it.
        extension: String,
    },
    /// `KHR_materials_transmission` filters what lies behind by its colour, and nothing refracts.
    UnrefractedTransmission {
        /// Material index and name.
        material: String,
    },
    /// An animation moves what an earlier one moves, and is not played.
    AnimationSkipped {
        /// Animation index and name.
        place: String,
    },
    /// A channel of an animation that changes what cannot be animated here.
    NotAnimated {
        /// Animation and channel, by their path in the file, with the animation's name.
        place: String,
        /// The JSON pointer of what it changes.
        pointer: String,
    },
    /// A morph target of what its mesh does not have, or of what no mesh morphs.
    MorphIgnored {
        /// Mesh and primitive, with index and name.
        place: String,
        /// What it moves, as the file spells it.
        attribute: String,
    },
    /// A part that is broken or missing: the rest is shown without it.
    Lost {
        /// The part, by its path in the file and its name.
        place: String,
        /// What is wrong with it and what to do.
        problem: String,
        /// What became of it.
        outcome: String,
    },
    /// There was more to say than anyone reads.
    More {
        /// How many warnings were left out.
        count: usize,
    },
    /// The file was repaired in a way its author would want, e.g. a normal that was not of unit length.
    Repaired {
        /// The part that was repaired, with index and name.
        place: String,
        /// What was done to it.
        what: String,
    },
}

impl fmt::Display for LoadWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ExtensionIgnored { extension } => write!(f, "extension {extension} has no effect here"),
            Self::UnrefractedTransmission { material } => {
                write!(f, "{material}: transmission is drawn without refraction")
            }
            Self::AnimationSkipped { place } => {
                write!(f, "{place} is not played: it moves what an earlier animation moves")
            }
            Self::NotAnimated { place, pointer } => {
                write!(f, "{place}: {pointer} cannot be animated here and stays as it is")
            }
            Self::MorphIgnored { place, attribute } => {
                write!(f, "{place}: morph targets of {attribute} have no effect here")
            }
            Self::Lost { place, problem, outcome } => write!(f, "{place}: {problem}; {outcome}"),
            Self::More { count } => write!(f, "{count} more warnings of this kind were left out"),
            Self::Repaired { place, what } => write!(f, "{place}: {what}"),
        }
    }
}
