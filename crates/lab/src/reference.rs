//! What methods are held against.

use std::{fmt, str::FromStr};

use sheer_core::{
    parameter::{ParameterInfo, ParameterRange, Values, split_name},
    suggestion::suggestion,
};

use crate::LabError;

/// The method that has no error, in all figures.
pub const REFERENCE: &str = "baseline";

/// What methods are held against. Parse one from `same` or `truth:samples=N`; it prints with the keys that
/// differ from their defaults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The exact answer under the same anti-aliasing: what is left is the method's own error.
    Same,
    /// The exact answer with many samples a pixel at the moment of the frame: what anti-aliasing adds to the
    /// error counts as well.
    Truth {
        /// How many samples.
        samples: u32,
    },
}

const SAME: &str = "same";
const TRUTH: &str = "truth";
const DEFAULT_SAMPLES: u32 = 32;
const SAMPLES: ParameterInfo = ParameterInfo {
    key: "samples",
    default: "32",
    range: ParameterRange::Count(1, 4096),
    what: "jittered samples a pixel",
};

impl Reference {
    /// The truth with its default of samples.
    pub const TRUTH: Self = Self::Truth { samples: DEFAULT_SAMPLES };

    /// What it is, for a reader who does not know its name.
    #[must_use]
    pub fn in_words(self) -> String {
        match self {
            Self::Same => format!("{REFERENCE} under the same anti-aliasing"),
            Self::Truth { samples: 1 } => "the truth (exact, one sample a pixel)".to_owned(),
            Self::Truth { samples } => format!("the truth (exact, {samples} samples a pixel)"),
        }
    }
}

impl FromStr for Reference {
    type Err = LabError;

    fn from_str(text: &str) -> Result<Self, LabError> {
        let (name, settings) = split_name(text);
        let values = |known: &[ParameterInfo]| {
            Values::parse(known, settings)
                .map_err(|problem| LabError::Misuse(format!("reference '{name}': {problem}")))
        };
        match name {
            SAME => values(&[]).map(|_| Self::Same),
            TRUTH => values(&[SAMPLES]).map(|values| Self::Truth { samples: values.count(SAMPLES.key) }),
            _ => Err(LabError::Misuse(format!(
                "there is no reference '{name}'; there are: {SAME}, {TRUTH}, {TRUTH}:{}=N{}",
                SAMPLES.key,
                suggestion(name, [SAME, TRUTH])
            ))),
        }
    }
}

impl fmt::Display for Reference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Same => f.write_str(SAME),
            Self::Truth { samples: DEFAULT_SAMPLES } => f.write_str(TRUTH),
            Self::Truth { samples } => write!(f, "{TRUTH}:{}={samples}", SAMPLES.key),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_parse_by_their_names_and_print_them_back() {
        assert_eq!(SAMPLES.default, DEFAULT_SAMPLES.to_string());
        for (text, reference) in [
            ("same", Reference::Same),
            ("truth", Reference::TRUTH),
            ("truth:samples=1", Reference::Truth { samples: 1 }),
            ("truth:samples=4096", Reference::Truth { samples: 4096 }),
        ] {
            assert_eq!(text.parse::<Reference>().unwrap(), reference);
            assert_eq!(reference.to_string(), text);
        }
    }

    #[test]
    fn what_is_no_reference_says_what_there_is() {
        let said = |text: &str| text.parse::<Reference>().unwrap_err().to_string();
        assert!(
            said("truht").contains("'truht'; there are: same, truth, truth:samples=N"),
            "{}",
            said("truht")
        );
        for wrong in ["truth:samples=0", "truth:samples=4097", "truth:samples=many"] {
            assert!(said(wrong).contains("1..=4096"), "{}", said(wrong));
        }
        assert!(said("truth:sample=4").contains("samples (1..=4096)"), "{}", said("truth:sample=4"));
        assert!(said("same:samples=4").contains("it takes none"), "{}", said("same:samples=4"));
    }
}
