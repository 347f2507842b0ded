//! Shaders are joined from pieces below `shaders/`, which the binary holds as text.
//!
//! * `#import shared/hash` includes a piece, once however often it is asked for. A name that [`Linker::alias`] gives stands for another piece:
//!   that is how a pass includes the method it runs.
//! * `#expand shared/traverse_query VISITOR=camera` includes a piece with each `VISITOR` replaced by `camera`: a template, once for each set of
//!   words.
//! * `enable …;` lines move to the top, where WGSL wants them.
//!
//! The constants come before all pieces: see [`constants`].

use std::collections::{BTreeMap, BTreeSet};

use sheer_render::{Antialiasing, Method};

use crate::error::GpuError;

pub(crate) mod constant;
pub(crate) mod constants;
pub(crate) mod numbers;

/// Name and text of each piece: the files below `shaders/`, as the build script finds them.
const PIECES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/pieces.rs"));

/// Joins pieces to a shader.
#[derive(Clone, Debug)]
pub(crate) struct Linker {
    pub(crate) pieces: BTreeMap<&'static str, &'static str>,
    aliases: BTreeMap<&'static str, String>,
    constants: String,
}

impl Linker {
    /// All pieces and the constants that they have in common, no alias.
    pub(crate) fn new() -> Self {
        Self::of_pieces(PIECES, constant::text(&constants::all()))
    }

    /// Pieces by name and text, below constants.
    pub(crate) fn of_pieces(pieces: &[(&'static str, &'static str)], constants: String) -> Self {
        Self { pieces: pieces.iter().copied().collect(), aliases: BTreeMap::new(), constants }
    }

    /// Lets a name stand for a piece.
    pub(crate) fn alias(mut self, name: &'static str, piece: &str) -> Self {
        self.aliases.insert(name, piece.to_owned());
        self
    }

    /// Adds constants.
    pub(crate) fn constants(mut self, text: String) -> Self {
        self.constants.push_str(&text);
        self
    }

    /// Lets `method` stand for a method's piece and adds its parameters.
    pub(crate) fn method(self, method: &Method) -> Self {
        self.alias("method", &piece_of("method", method.info().id)).constants(method_constants(method))
    }

    /// Lets `technique` stand for the piece of an anti-aliasing technique and adds its parameters.
    pub(crate) fn antialiasing(self, antialiasing: &Antialiasing) -> Self {
        let constants = constant::text(&constants::of_antialiasing(antialiasing));
        self.alias("technique", &piece_of("temporal", antialiasing.info().id)).constants(constants)
    }

    /// A piece with all that it includes.
    pub(crate) fn link(&self, piece: &str) -> Result<String, GpuError> {
        let mut joined = Joined::default();
        self.include(&Inclusion::new(piece, ""), &mut Vec::new(), &mut joined)
            .map_err(|problem| GpuError::Shader { piece: piece.to_owned(), problem })?;
        let enables: String = joined.enables.iter().map(|line| format!("{line}\n")).collect();
        Ok(enables + &self.constants + &joined.text)
    }

    /// Appends a piece, unless it is there already; `chain` leads to it.
    fn include(
        &self,
        asked: &Inclusion,
        chain: &mut Vec<Inclusion>,
        joined: &mut Joined,
    ) -> Result<(), String> {
        let name = self.aliases.get(asked.piece.as_str()).map_or(asked.piece.as_str(), String::as_str);
        let inclusion = Inclusion::new(name, &asked.words);
        let path = || {
            chain.iter().chain([&inclusion]).map(|link| link.piece.as_str()).collect::<Vec<_>>().join(" → ")
        };
        if chain.contains(&inclusion) {
            return Err(format!("pieces include one another: {}", path()));
        }
        if joined.included.contains(&inclusion) {
            return Ok(());
        }
        let Some(text) = self.pieces.get(name) else {
            return Err(format!("there is no piece '{name}': {}", path()));
        };
        let text = inclusion.replace_words(text).map_err(|problem| format!("{problem}: {}", path()))?;
        chain.push(inclusion.clone());
        for line in text.lines() {
            self.line(line, chain, joined)?;
        }
        chain.pop();
        joined.included.insert(inclusion);
        Ok(())
    }

    /// Follows a line of the piece at the end of the chain.
    fn line(&self, line: &str, chain: &mut Vec<Inclusion>, joined: &mut Joined) -> Result<(), String> {
        let trimmed = line.trim();
        if let Some(piece) = trimmed.strip_prefix("#import ") {
            self.include(&Inclusion::new(piece.trim(), ""), chain, joined)
        } else if let Some(expansion) = trimmed.strip_prefix("#expand ") {
            let (piece, words) = expansion.trim().split_once(' ').unwrap_or((expansion.trim(), ""));
            self.include(&Inclusion::new(piece, words.trim()), chain, joined)
        } else if trimmed.starts_with('#') {
            let including = chain.last().map_or("", |link| link.piece.as_str());
            Err(format!("'{trimmed}' in {including} is neither #import nor #expand"))
        } else {
            if trimmed.starts_with("enable ") {
                joined.enables.insert(trimmed.to_owned());
            } else {
                joined.text.push_str(line);
                joined.text.push('\n');
            }
            Ok(())
        }
    }
}

/// The piece of a row of a table, by its id.
fn piece_of(folder: &str, id: &str) -> String {
    format!("{folder}/{}", id.replace('-', "_"))
}

/// A method's parameters as constants: see [`constants::of_method`].
pub(crate) fn method_constants(method: &Method) -> String {
    constant::text(&constants::of_method(method))
}

/// What has been joined so far.
#[derive(Default)]
struct Joined {
    included: BTreeSet<Inclusion>,
    enables: BTreeSet<String>,
    text: String,
}

/// A piece with the words that replace others in it, `NAME=word NAME=word`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Inclusion {
    piece: String,
    words: String,
}

impl Inclusion {
    fn new(piece: &str, words: &str) -> Self {
        Self { piece: piece.to_owned(), words: words.to_owned() }
    }

    fn replace_words(&self, text: &str) -> Result<String, String> {
        self.words.split_whitespace().try_fold(text.to_owned(), |text, setting| {
            let (name, word) =
                setting.split_once('=').ok_or_else(|| format!("'{setting}' is not NAME=WORD"))?;
            if !text.contains(name) {
                return Err(format!("there is no {name} to replace"));
            }
            Ok(text.replace(name, word))
        })
    }
}
