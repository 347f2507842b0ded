//! `name:key=value,key=value`: how scenes, methods and techniques are asked for on the command line.

use std::fmt;

use crate::suggestion::suggestion;

/// One parameter of a scene or a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterInfo {
    /// The word before the `=`.
    pub key: &'static str,
    /// The value where none is given, as it would be typed.
    pub default: &'static str,
    /// What it may be.
    pub range: ParameterRange,
    /// A line on what it does, for help.
    pub what: &'static str,
}

/// Values that a parameter may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterRange {
    /// A whole number from the first to the second, both included.
    Count(u32, u32),
    /// A number from the first to the second, both included.
    Real(f32, f32),
    /// One of these words.
    Choice(&'static [&'static str]),
}

impl ParameterRange {
    /// Whether a value, as it was typed, is allowed.
    #[must_use]
    pub fn holds(self, value: &str) -> bool {
        match self {
            Self::Count(low, high) => value.parse().is_ok_and(|count: u32| (low..=high).contains(&count)),
            Self::Real(low, high) => value.parse().is_ok_and(|real: f32| (low..=high).contains(&real)),
            Self::Choice(words) => words.contains(&value),
        }
    }
}

impl fmt::Display for ParameterRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(low, high) => write!(f, "{low}..={high}"),
            Self::Real(low, high) => write!(f, "{low:?}..={high:?}"),
            Self::Choice(words) => f.write_str(&words.join("|")),
        }
    }
}

/// A parameter whose value is one of several words. [`choice!`](crate::choice) declares it: enum and words in
/// one list.
pub trait Choice: Copy + PartialEq + 'static {
    /// All values, in the order in which they are listed and numbered in shaders.
    const ALL: &'static [Self];
    /// The word of each of [`Self::ALL`].
    const WORDS: &'static [&'static str];

    /// The word for a value.
    fn word(self) -> &'static str;

    /// The value that a word stands for, if it stands for any.
    fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.word() == word)
    }
}

/// Declares a [`Choice`]: the enum, and with it the words on the command line, in help and in shaders. Its
/// function `parameter` makes the key that takes it.
///
/// ```
/// use sheer_core::parameter::{ParameterInfo, Values};
///
/// sheer_core::choice! {
///     /// Whose noise.
///     enum Noise {
///         /// That of the pixel.
///         Shared = "shared",
///         /// None at all.
///         Off = "off",
///     }
/// }
/// const NOISE: ParameterInfo = Noise::parameter("noise", Noise::Shared, "whose noise thresholds have");
///
/// let values = Values::parse(&[NOISE], "noise=off")?;
/// assert_eq!(values.choice::<Noise>("noise"), Noise::Off);
/// # Ok::<(), String>(())
/// ```
#[macro_export]
macro_rules! choice {
    (
        $(#[$about:meta])*
        $visibility:vis enum $name:ident { $($(#[$what:meta])* $value:ident = $word:literal),+ $(,)? }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $visibility enum $name {
            $($(#[$what])* $value,)+
        }

        impl $name {
            /// The key that takes one of its words, with a default.
            #[must_use]
            $visibility const fn parameter(
                key: &'static str,
                default: Self,
                what: &'static str,
            ) -> $crate::parameter::ParameterInfo {
                let words = <Self as $crate::parameter::Choice>::WORDS;
                let range = $crate::parameter::ParameterRange::Choice(words);
                $crate::parameter::ParameterInfo { key, default: words[default as usize], range, what }
            }
        }

        impl $crate::parameter::Choice for $name {
            const ALL: &'static [Self] = &[$(Self::$value),+];
            const WORDS: &'static [&'static str] = &[$($word),+];

            fn word(self) -> &'static str {
                match self {
                    $(Self::$value => $word,)+
                }
            }
        }
    };
}

choice! {
    /// What is turned on or off.
    pub enum Switch {
        /// What the key names is done.
        On = "on",
        /// What the key names is left out.
        Off = "off",
    }
}

/// Splits `name:settings`; without a colon there are no settings.
#[must_use]
pub fn split_name(text: &str) -> (&str, &str) {
    text.split_once(':').unwrap_or((text, ""))
}

/// Parameters with their values, each one checked against its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    known: Vec<ParameterInfo>,
    given: Vec<(&'static str, String)>,
}

impl Values {
    /// Reads `key=value,key=value`; what is not given has its default.
    ///
    /// # Errors
    /// What is wrong and what is allowed, in words.
    pub fn parse(known: &[ParameterInfo], settings: &str) -> Result<Self, String> {
        let mut given: Vec<(&'static str, String)> = Vec::new();
        for setting in settings.split(',').map(str::trim).filter(|setting| !setting.is_empty()) {
            let (key, value) =
                setting.split_once('=').ok_or_else(|| format!("'{setting}' is not KEY=VALUE"))?;
            let parameter = known.iter().find(|parameter| parameter.key == key).ok_or_else(|| {
                let allowed: Vec<_> =
                    known.iter().map(|known| format!("{} ({})", known.key, known.range)).collect();
                let allowed = if allowed.is_empty() { "none".to_owned() } else { allowed.join(", ") };
                let nearest = suggestion(key, known.iter().map(|known| known.key));
                format!("there is no parameter '{key}'; it takes {allowed}{nearest}")
            })?;
            if !parameter.range.holds(value) {
                let words = match parameter.range {
                    ParameterRange::Choice(words) => words,
                    ParameterRange::Count(..) | ParameterRange::Real(..) => &[],
                };
                let nearest = suggestion(value, words.iter().copied());
                return Err(format!("{key}={value} is not in {}{nearest}", parameter.range));
            }
            if given.iter().any(|(earlier, _)| *earlier == key) {
                return Err(format!("{key} is given twice"));
            }
            given.push((parameter.key, value.to_owned()));
        }
        Ok(Self { known: known.to_vec(), given })
    }

    /// The same with other defaults for some keys: what was given stays.
    ///
    /// # Panics
    /// If a key is not known or its value not in its range: a slip of the program, not of its user.
    #[must_use]
    pub fn with_defaults(mut self, defaults: &[(&str, &'static str)]) -> Self {
        for &(key, default) in defaults {
            let known = self.known.iter_mut().find(|parameter| parameter.key == key);
            let parameter = known.expect("only parameters of the own table get other defaults");
            assert!(parameter.range.holds(default), "{key}={default}");
            parameter.default = default;
        }
        self
    }

    /// A parameter's value as it was given, or its default.
    ///
    /// # Panics
    /// If the key is not among the known ones: a slip of the program, not of its user.
    #[must_use]
    pub fn text(&self, key: &str) -> &str {
        if let Some((_, value)) = self.given.iter().find(|(given, _)| *given == key) {
            return value;
        }
        let parameter = self.known.iter().find(|parameter| parameter.key == key);
        parameter.expect("only parameters of the own table are asked for").default
    }

    /// A whole number.
    ///
    /// # Panics
    /// If the key is not known or not a [`ParameterRange::Count`].
    #[must_use]
    pub fn count(&self, key: &str) -> u32 {
        self.text(key).parse().expect("checked against its range")
    }

    /// A number.
    ///
    /// # Panics
    /// If the key is not known or not a number.
    #[must_use]
    pub fn real(&self, key: &str) -> f32 {
        self.text(key).parse().expect("checked against its range")
    }

    /// One of several words.
    ///
    /// # Panics
    /// If the key is not known or takes other words than the choice has.
    #[must_use]
    pub fn choice<C: Choice>(&self, key: &str) -> C {
        C::from_word(self.text(key)).expect("the key takes the words of the choice")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: &[ParameterInfo] = &[
        ParameterInfo { key: "count", default: "3", range: ParameterRange::Count(1, 8), what: "" },
        ParameterInfo {
            key: "hash",
            default: "pcg",
            range: ParameterRange::Choice(&["pcg", "mcguire"]),
            what: "",
        },
    ];

    #[test]
    fn what_is_not_given_has_its_default() {
        let values = Values::parse(KNOWN, "hash=mcguire").unwrap();
        assert_eq!((values.count("count"), values.text("hash")), (3, "mcguire"));
    }

    #[test]
    fn other_defaults_yield_to_what_is_given() {
        let values = Values::parse(KNOWN, "count=5").unwrap();
        let values = values.with_defaults(&[("count", "2"), ("hash", "mcguire")]);
        assert_eq!((values.count("count"), values.text("hash")), (5, "mcguire"));
    }

    #[test]
    fn each_slip_is_named_with_what_is_allowed() {
        let problem = |settings| Values::parse(KNOWN, settings).unwrap_err();
        assert!(problem("cuont=3").ends_with("count (1..=8), hash (pcg|mcguire); the nearest is 'count'"));
        assert_eq!(problem("hash=mcgiure"), "hash=mcgiure is not in pcg|mcguire; the nearest is 'mcguire'");
        assert_eq!(problem("count=9"), "count=9 is not in 1..=8");
        assert_eq!(problem("count"), "'count' is not KEY=VALUE");
        assert_eq!(problem("count=1,count=2"), "count is given twice");
        assert_eq!(split_name("std:hash=pcg"), ("std", "hash=pcg"));
    }
}
