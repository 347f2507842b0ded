//! Shaders are joined from pieces below `shaders/`, which the binary holds as text.
//!
//! * `#import shared/hash` includes a piece, once however often it is asked for. A name that
//!   [`Linker::alias`] gives stands for another piece: that is how a pass includes the method it runs.
//!   `#import struct/FrameUniform` includes a struct that Rust declares ([`record`]).
//! * `#expand shared/traverse_query VISITOR=camera` includes a piece with each `VISITOR` replaced by
//!   `camera`: a template, once for each set of words.
//! * `enable …;` lines move to the top, where WGSL wants them.
//!
//! The constants come before all pieces: see [`constants`]. What a compiler says of the whole is told by
//! piece and line ([`linked`]).

use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet},
    rc::Rc,
};

use sheer_render::{Antialiasing, Method};

use self::linked::Linked;
use crate::error::GpuError;

pub(crate) mod binding;
pub(crate) mod constant;
pub(crate) mod constants;
pub(crate) mod declaration;
pub(crate) mod linked;
pub(crate) mod numbers;
pub(crate) mod record;

/// Name and text of each piece: the files below `shaders/`, as the build script finds them.
const PIECES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/pieces.rs"));

/// Joins pieces to a shader.
#[derive(Clone, Debug)]
pub(crate) struct Linker {
    pieces: BTreeMap<String, Cow<'static, str>>,
    aliases: BTreeMap<&'static str, String>,
    constants: String,
}

impl Linker {
    /// All pieces, the structs that Rust declares among them, and the constants that they have in common; no
    /// alias.
    pub(crate) fn new() -> Self {
        let mut linker = Self::of_pieces(PIECES, constant::text(&constants::all()));
        let structs = record::all();
        let structs =
            structs.iter().map(|found| (format!("struct/{}", found.name), Cow::Owned(found.wgsl())));
        linker.pieces.extend(structs);
        linker
    }

    /// Pieces by name and text, below constants.
    pub(crate) fn of_pieces(pieces: &[(&str, &'static str)], constants: String) -> Self {
        let pieces = pieces.iter().map(|&(name, text)| (name.to_owned(), Cow::Borrowed(text)));
        Self { pieces: pieces.collect(), aliases: BTreeMap::new(), constants }
    }

    /// Lets a name stand for a piece.
    pub(crate) fn alias(mut self, name: &'static str, piece: &str) -> Self {
        self.aliases.insert(name, piece.to_owned());
        self
    }

    /// Adds constants, as WGSL, to those of all shaders.
    pub(crate) fn constants(mut self, text: String) -> Self {
        self.constants.push_str(&text);
        self
    }

    /// Lets `method` stand for a method's piece and adds its parameters.
    pub(crate) fn method(self, method: &Method) -> Self {
        let constants = constant::text(&constants::of_method(method));
        self.alias("method", &piece_of("method", method.info().id)).constants(constants)
    }

    /// Lets `technique` stand for the piece of an anti-aliasing technique and adds its parameters.
    pub(crate) fn antialiasing(self, antialiasing: &Antialiasing) -> Self {
        let constants = constant::text(&constants::of_antialiasing(antialiasing));
        self.alias("technique", &piece_of("temporal", antialiasing.info().id)).constants(constants)
    }

    /// The names of all pieces, in alphabetical order.
    #[cfg(test)]
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.pieces.keys().map(String::as_str)
    }

    /// A piece with all that it includes.
    ///
    /// # Errors
    /// [`GpuError::Shader`] names the chain of pieces that leads to one that is not there, includes itself or
    /// has an unknown directive.
    pub(crate) fn link(&self, piece: &str) -> Result<Linked, GpuError> {
        let mut joined = Joined::default();
        self.include(&Inclusion::new(piece, ""), &mut Vec::new(), &mut joined)
            .map_err(|problem| GpuError::Shader { piece: piece.to_owned(), problem })?;
        let enables: String = joined.enables.iter().map(|line| format!("{line}\n")).collect();
        let prelude: Rc<str> = "constants".into();
        let prelude_lines = (enables.lines().count() + self.constants.lines().count()) as u32;
        let mut origins: Vec<_> = (1..=prelude_lines).map(|line| (Rc::clone(&prelude), line)).collect();
        origins.extend(joined.origins);
        Ok(Linked { piece: piece.to_owned(), text: enables + &self.constants + &joined.text, origins })
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
        let piece: Rc<str> = name.into();
        for (number, line) in (1..).zip(text.lines()) {
            self.line(line, (&piece, number), chain, joined)?;
        }
        chain.pop();
        joined.included.insert(inclusion);
        Ok(())
    }

    /// Follows a line of the piece at the end of the chain; it comes with that piece and its number there.
    fn line(
        &self,
        line: &str,
        (piece, number): (&Rc<str>, u32),
        chain: &mut Vec<Inclusion>,
        joined: &mut Joined,
    ) -> Result<(), String> {
        let trimmed = line.trim();
        if let Some(imported) = trimmed.strip_prefix("#import ") {
            self.include(&Inclusion::new(imported.trim(), ""), chain, joined)
        } else if let Some(expansion) = trimmed.strip_prefix("#expand ") {
            let (template, words) = expansion.trim().split_once(' ').unwrap_or((expansion.trim(), ""));
            self.include(&Inclusion::new(template, words.trim()), chain, joined)
        } else if trimmed.starts_with('#') {
            Err(format!("{piece}.wgsl:{number}: '{trimmed}' is neither #import nor #expand"))
        } else {
            if trimmed.starts_with("enable ") {
                joined.enables.insert(trimmed.to_owned());
            } else {
                joined.text.push_str(line);
                joined.text.push('\n');
                joined.origins.push((Rc::clone(piece), number));
            }
            Ok(())
        }
    }
}

/// The piece of a row of a table, by its id.
fn piece_of(folder: &str, id: &str) -> String {
    format!("{folder}/{}", id.replace('-', "_"))
}

/// What has been joined so far.
#[derive(Default)]
struct Joined {
    included: BTreeSet<Inclusion>,
    enables: BTreeSet<String>,
    text: String,
    /// Piece and line of each line of the text.
    origins: Vec<(Rc<str>, u32)>,
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
