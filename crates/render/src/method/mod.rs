//! All methods, one file each. To add one: write `method/<name>.rs` after the pattern of its neighbours and
//! put its name into the table below; the command line, `sheer methods`, the docs and the tests that walk all
//! methods follow.

use ::std::{fmt, str::FromStr};

use sheer_core::{
    coverage::Correction,
    parameter::{ParameterInfo, ParameterRange, Values, split_name},
    suggestion::suggestion,
};

use crate::contract::{
    Alignment, AlignmentRule, CORRECTION_PARAMETER, Hybrid, Memory, MethodInfo, OrderedCompositing,
    Selection, Threshold, UnorderedCompositing, Visitor, correction,
};

/// Why there is no such method.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MethodError {
    /// No method has that name.
    #[error("there is no method '{name}'; there are: {known}{}", suggestion(.name, .known.split(", ")))]
    Unknown {
        /// What was asked for.
        name: String,
        /// The names of all methods, separated by commas.
        known: String,
    },
    /// A key or a value is off.
    #[error("method '{method}': {problem}")]
    Parameter {
        /// The name of the method.
        method: &'static str,
        /// What is wrong and what is allowed.
        problem: String,
    },
}

/// The contract that a method fulfils.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// A threshold for each hit: [`Threshold`].
    Threshold,
    /// A threshold for each pixel: [`Selection`].
    Selection,
    /// Fragments added up front to back: [`OrderedCompositing`].
    Ordered,
    /// Fragments added up in any order: [`UnorderedCompositing`].
    Unordered,
}

impl Family {
    /// Whether one fragment a pixel is shaded, and not several added up.
    #[must_use]
    pub fn shades_one_fragment(self) -> bool {
        match self {
            Self::Threshold | Self::Selection => true,
            Self::Ordered | Self::Unordered => false,
        }
    }

    /// All keys of a method of this family: its own, then those that families of one shaded fragment have in
    /// common.
    fn parameters(self, info: &MethodInfo) -> Vec<ParameterInfo> {
        if !self.shades_one_fragment() {
            return info.parameters.to_vec();
        }
        let alignment = if info.alignment_px > 1 { &[AlignmentRule::PARAMETER][..] } else { &[] };
        [info.parameters, Hybrid::PARAMETERS, &[CORRECTION_PARAMETER], alignment].concat()
    }
}

struct MemoryOf;

impl Visitor for MemoryOf {
    type Output = Memory;

    /// One fragment at a time is all that is held, in the targets that every method has.
    fn threshold(self, _: &impl Threshold) -> Memory {
        Memory::Bounded(0)
    }

    fn selection(self, _: &impl Selection) -> Memory {
        Memory::Bounded(0)
    }

    fn ordered(self, method: &impl OrderedCompositing) -> Memory {
        method.memory()
    }

    fn unordered(self, method: &impl UnorderedCompositing) -> Memory {
        method.memory()
    }
}

struct FamilyOf;

impl Visitor for FamilyOf {
    type Output = Family;

    fn threshold(self, _: &impl Threshold) -> Family {
        Family::Threshold
    }

    fn selection(self, _: &impl Selection) -> Family {
        Family::Selection
    }

    fn ordered(self, _: &impl OrderedCompositing) -> Family {
        Family::Ordered
    }

    fn unordered(self, _: &impl UnorderedCompositing) -> Family {
        Family::Unordered
    }
}

mod object_draw;
mod stack;
mod static_noise;

macro_rules! methods {
    ($($module:ident :: $name:ident),+ $(,)?) => {
        $(mod $module;)+

        /// A method with its parameters. Parse one from `name:key=value,key=value`.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Method {
            kind: Kind,
            hybrid: Hybrid,
            correction: Correction,
            alignment: Alignment,
            values: Values,
            text: String,
        }

        #[derive(Clone, Debug, PartialEq)]
        enum Kind {
            $($name($module::$name),)+
        }

        /// All methods, in the order in which they are listed.
        pub const METHODS: &[MethodInfo] = &[$($module::INFO),+];

        impl Method {
            /// What lists and help say of it, and what a GPU needs of it.
            #[must_use]
            pub fn info(&self) -> &'static MethodInfo {
                match self.kind {
                    $(Kind::$name(_) => &const { $module::INFO },)+
                }
            }

            /// Hands the method to a backend under its contract.
            pub fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
                match &self.kind {
                    $(Kind::$name(method) => method.accept(visitor),)+
                }
            }
        }

        impl FromStr for Method {
            type Err = MethodError;

            fn from_str(text: &str) -> Result<Self, MethodError> {
                let (name, settings) = split_name(text);
                $(if name == $module::INFO.id {
                    let defaults = Values::parse($module::INFO.parameters, "").expect("defaults need no settings");
                    let family = $module::$name::new(&defaults).accept(FamilyOf);
                    let values = Values::parse(&family.parameters(&$module::INFO), settings)
                        .map_err(|problem| MethodError::Parameter { method: $module::INFO.id, problem })?;
                    let (hybrid, correction) = if family.shades_one_fragment() {
                        (Hybrid::new(&values), correction(&values))
                    } else {
                        (Hybrid::NONE, Correction::NONE)
                    };
                    let alignment = alignment(&$module::INFO, &values);
                    let kind = Kind::$name($module::$name::new(&values));
                    return Ok(Self { kind, hybrid, correction, alignment, values, text: text.to_owned() });
                })+
                let known = METHODS.iter().map(|info| info.id).collect::<Vec<_>>().join(", ");
                Err(MethodError::Unknown { name: name.to_owned(), known })
            }
        }
    };
}

methods! {
    baseline::Baseline,
    roulette::Roulette,
    std::Std,
    joint::Joint,
    dtaa::Dtaa,
    dtaa_unique::DtaaUnique,
    hashed::Hashed,
    stbn::Stbn,
    list::List,
    stochastic::Stochastic,
    peel::Peel,
    kbuffer::Kbuffer,
    weighted::Weighted,
    mlab::Mlab,
    adaptive::Adaptive,
    moments::Moments,
}

impl Method {
    /// The contract that it fulfils.
    #[must_use]
    pub fn family(&self) -> Family {
        self.visit(FamilyOf)
    }

    /// What it stores for a pixel.
    #[must_use]
    pub fn memory(&self) -> Memory {
        self.visit(MemoryOf)
    }

    /// All keys it takes, those of its family among them.
    #[must_use]
    pub fn parameters(&self) -> Vec<ParameterInfo> {
        self.family().parameters(self.info())
    }

    /// The value of one of its [`Self::parameters`], as it was given, or its default.
    ///
    /// # Panics
    /// If it takes no such key: a slip of the program, not of its user.
    #[must_use]
    pub fn value(&self, key: &str) -> &str {
        self.values.text(key)
    }

    /// Up to where it is exact.
    #[must_use]
    pub fn hybrid(&self) -> Hybrid {
        self.hybrid
    }

    /// The curve from opacity to the coverage that is held against thresholds.
    #[must_use]
    pub fn correction(&self) -> Correction {
        self.correction
    }

    /// How motion vectors are to be aligned under TAA.
    #[must_use]
    pub fn alignment(&self) -> Alignment {
        self.alignment
    }

    /// The method with a correction of the caller's own; it prints as `text` from now on. A method that
    /// composites has no threshold and renders as before.
    #[must_use]
    pub fn with_correction(self, correction: Correction, text: impl Into<String>) -> Self {
        Self { correction, text: text.into(), ..self }
    }
}

/// Every method of the table with its defaults, followed by itself with each other word of each of its own
/// choices.
pub fn variants() -> impl Iterator<Item = Method> {
    let texts = METHODS.iter().flat_map(|info| {
        let words = info.parameters.iter().flat_map(|parameter| {
            let words = match parameter.range {
                ParameterRange::Choice(words) => words,
                ParameterRange::Count(..) | ParameterRange::Real(..) => &[],
            };
            let others = words.iter().filter(|word| **word != parameter.default);
            others.map(|word| format!("{}:{}={word}", info.id, parameter.key))
        });
        ::std::iter::once(info.id.to_owned()).chain(words)
    });
    texts.map(|text| text.parse().expect("the table's own words are known"))
}

/// The alignment that a method's user wants; a hybrid that is exact all through has no pattern to align to.
fn alignment(info: &MethodInfo, values: &Values) -> Alignment {
    if info.alignment_px == 1 || Hybrid::new(values) == Hybrid::EXACT {
        return Alignment::NONE;
    }
    match values.choice(AlignmentRule::PARAMETER.key) {
        AlignmentRule::Off => Alignment::NONE,
        rule => Alignment { side_px: info.alignment_px, rule },
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use sheer_core::parameter::Choice as _;

    use super::*;

    #[test]
    fn every_method_parses_by_its_own_name_and_prints_it_back() {
        for info in METHODS {
            let method: Method = info.id.parse().unwrap();
            assert_eq!(method.info().id, info.id);
            assert_eq!(method.to_string(), info.id);
        }
    }

    /// The text of a list names each work that stands in the bibliography for it.
    #[test]
    fn every_paper_names_its_works_and_no_other() {
        for info in METHODS {
            assert_eq!(info.works.is_empty(), info.paper == "own", "{}", info.id);
            for work in info.works {
                let name = work.abbreviation.unwrap_or(work.first_author());
                assert!(info.paper.contains(name), "{}: {} does not name {name}", info.id, info.paper);
            }
        }
    }

    #[test]
    fn variants_have_each_word_once() {
        let of_roulette: Vec<String> = variants()
            .filter(|method| method.info().id == "roulette")
            .map(|method| method.to_string())
            .collect();
        assert_eq!(of_roulette, ["roulette", "roulette:hash=mcguire"]);
    }

    #[test]
    fn a_wrong_name_or_key_says_what_there_is() {
        let unknown = "sdt".parse::<Method>().unwrap_err().to_string();
        assert!(unknown.contains("baseline, roulette, std"), "{unknown}");
        let key = "roulette:hsah=pcg".parse::<Method>().unwrap_err().to_string();
        assert!(key.contains("hash (pcg|mcguire), hybrid (0.0..=1.0)"), "{key}");
    }

    #[test]
    fn a_method_gives_back_the_values_of_all_its_keys() {
        let method: Method = "std:rehash=9,layers=4".parse().unwrap();
        assert_eq!(["rehash", "hash", "layers"].map(|key| method.value(key)), ["9", "pcg", "4"]);
        for info in METHODS {
            let method: Method = info.id.parse().unwrap();
            for parameter in method.parameters() {
                assert_eq!(method.value(parameter.key), parameter.default, "{}", info.id);
            }
        }
    }

    #[test]
    fn hybrid_is_a_key_of_every_method_that_shades_one_fragment() {
        for info in METHODS {
            let hybrid = format!("{}:hybrid=0.5,layers=4", info.id).parse::<Method>();
            let family = info.id.parse::<Method>().unwrap().family();
            assert_eq!(hybrid.is_ok(), family.shades_one_fragment(), "{}", info.id);
            if let Ok(method) = hybrid {
                assert_eq!(method.hybrid(), Hybrid { visibility: 0.5, layers: Some(4) });
            }
        }
    }

    #[test]
    fn alignment_can_be_chosen_where_there_is_any() {
        for info in METHODS {
            let side_px = info.id.parse::<Method>().unwrap().alignment().side_px;
            assert_eq!(side_px, info.alignment_px, "{}", info.id);
            if let Ok(exact) = format!("{}:hybrid=0", info.id).parse::<Method>() {
                assert_eq!(exact.alignment(), Alignment::NONE, "{}", info.id);
            }
            for &rule in AlignmentRule::ALL {
                let chosen = format!("{}:align={}", info.id, rule.word()).parse::<Method>();
                assert_eq!(chosen.is_ok(), info.alignment_px > 1, "{}", info.id);
                let Ok(method) = chosen else { continue };
                let side_px = if rule == AlignmentRule::Off { 1 } else { info.alignment_px };
                assert_eq!(method.alignment(), Alignment { side_px, rule }, "{method}");
            }
        }
    }

    #[test]
    fn correction_is_a_key_of_the_same_methods() {
        for info in METHODS {
            let corrected = format!("{}:correction=dlss", info.id).parse::<Method>();
            let plain = info.id.parse::<Method>().unwrap();
            assert_eq!(plain.correction(), Correction::NONE);
            assert_eq!(corrected.is_ok(), plain.family().shades_one_fragment(), "{}", info.id);
            if let Ok(method) = corrected {
                assert_eq!(method.correction(), Correction::DLSS);
            }
        }
    }
}
