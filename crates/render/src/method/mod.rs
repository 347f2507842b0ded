//! All methods, one file each. To add one: write `method/<name>.rs` after the pattern of its neighbours and put its name into the table
//! below; the command line, `sheer methods`, the docs and the tests that walk all methods follow.

use ::std::{fmt, str::FromStr};

use sheer_core::parameter::{Values, split_name};

use crate::contract::{MethodInfo, Visitor};

/// Why there is no such method.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MethodError {
    /// No method has that name.
    #[error("there is no method '{name}'; there are: {known}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// All names.
        known: String,
    },
    /// A key or a value is off.
    #[error("method '{method}': {problem}")]
    Parameter {
        /// Its name.
        method: &'static str,
        /// What is wrong and what is allowed.
        problem: String,
    },
}

mod object_draw;

macro_rules! methods {
    ($($module:ident :: $name:ident),+ $(,)?) => {
        $(pub mod $module;)+

        /// A method with its parameters. Parse one from `name:key=value,key=value`.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Method {
            kind: Kind,
            text: String,
        }

        #[derive(Clone, Debug, PartialEq)]
        enum Kind {
            $($name($module::$name),)+
        }

        /// All methods, in the order in which they are listed.
        pub const METHODS: &[MethodInfo] = &[$($module::INFO),+];

        impl Method {
            /// Its entry in the table.
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
                    let values = Values::parse($module::INFO.parameters, settings)
                        .map_err(|problem| MethodError::Parameter { method: $module::INFO.id, problem })?;
                    return Ok(Self { kind: Kind::$name($module::$name::new(&values)), text: text.to_owned() });
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
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_parses_by_its_own_name_and_prints_it_back() {
        for info in METHODS {
            let method: Method = info.id.parse().unwrap();
            assert_eq!(method.info().id, info.id);
            assert_eq!(method.to_string(), info.id);
        }
    }

    #[test]
    fn a_wrong_name_or_key_says_what_there_is() {
        let unknown = "sdt".parse::<Method>().unwrap_err().to_string();
        assert!(unknown.contains("baseline, roulette, std"), "{unknown}");
        let key = "roulette:hsah=pcg".parse::<Method>().unwrap_err().to_string();
        assert!(key.contains("hash (pcg|mcguire)"), "{key}");
    }
}
