//! A linked shader, and from which line of which piece each of its lines comes.

use std::{
    ffi::OsString,
    fs,
    hash::{DefaultHasher, Hash, Hasher as _},
    path::{Path, PathBuf},
    rc::Rc,
};

use crate::error::GpuError;

/// The folder that [`Linked::write`] writes to: the value of this environment variable, which is not to be
/// empty.
const FOLDER_VARIABLE: &str = "SHEER_SHADERS";

/// Where the user wants the sources of shaders written, if anywhere.
pub(crate) fn folder() -> Option<PathBuf> {
    folder_of(std::env::var_os(FOLDER_VARIABLE))
}

fn folder_of(value: Option<OsString>) -> Option<PathBuf> {
    value.filter(|value| !value.is_empty()).map(PathBuf::from)
}

/// A shader that is ready to be compiled.
#[derive(Clone, Debug)]
pub(crate) struct Linked {
    /// The piece that was asked for, which has the entry points.
    pub(crate) piece: String,
    /// The whole as WGSL, ready for a compiler.
    pub(crate) text: String,
    /// Piece and line of each line of the text; lines are counted from 1.
    pub(super) origins: Vec<(Rc<str>, u32)>,
}

impl Linked {
    /// The piece and the line there of a line of the text, counted from 1; none beyond its end.
    pub(crate) fn origin(&self, line: usize) -> Option<(&str, u32)> {
        let (piece, line) = self.origins.get(line.checked_sub(1)?)?;
        Some((piece, *line))
    }

    /// What a compiler says of the text, as naga prints it, with pieces and their lines in place of lines of
    /// the text: in `┌─ wgsl:120:5` and in the number before `│`.
    pub(crate) fn relocated(&self, message: &str) -> String {
        message.trim().lines().map(|line| self.relocated_line(line) + "\n").collect()
    }

    fn relocated_line(&self, line: &str) -> String {
        if let Some((before, place)) = line.split_once("┌─ wgsl:") {
            let (row, column) = place.split_once(':').unwrap_or((place, ""));
            if let Some((piece, row)) = row.parse().ok().and_then(|row| self.origin(row)) {
                return format!("{before}┌─ {piece}.wgsl:{row}:{column}");
            }
        }
        if let Some((gutter, code)) = line.split_once('│')
            && let Some((_, row)) = gutter.trim().parse().ok().and_then(|row| self.origin(row))
        {
            let width = gutter.len().saturating_sub(1);
            return format!("{row:<width$} │{code}");
        }
        line.to_owned()
    }

    /// Writes the text to a folder, with a comment wherever another piece begins, as
    /// `pass-find-0123abcd.wgsl`: the number tells what is linked with other methods and parameters from one
    /// another.
    ///
    /// # Errors
    /// [`GpuError::Shader`] when the file cannot be written.
    pub(crate) fn write(&self, folder: &Path) -> Result<(), GpuError> {
        let mut hasher = DefaultHasher::new();
        self.text.hash(&mut hasher);
        let number = hasher.finish() as u32;
        let file = folder.join(format!("{}-{number:08x}.wgsl", self.piece.replace('/', "-")));
        let written = fs::create_dir_all(folder).and_then(|()| fs::write(&file, self.annotated()));
        written.map_err(|error| GpuError::Shader {
            piece: self.piece.clone(),
            problem: format!(
                "{FOLDER_VARIABLE} asks for {}, which cannot be written: {error}",
                file.display()
            ),
        })
    }

    fn annotated(&self) -> String {
        let mut text = String::new();
        let mut last: Option<(&str, u32)> = None;
        for (line, (piece, row)) in self.text.lines().zip(&self.origins) {
            if last != Some((piece, row - 1)) {
                text += &format!("// {piece}.wgsl, from line {row} on\n");
            }
            text += line;
            text.push('\n');
            last = Some((piece, *row));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_variable_asks_for_no_folder() {
        assert_eq!(folder_of(None), None);
        assert_eq!(folder_of(Some(OsString::new())), None);
        assert_eq!(folder_of(Some("shaders".into())), Some(PathBuf::from("shaders")));
    }
}
