//! Pictures that others made: one file, the pictures of a folder, or numbered files.

use std::{
    collections::BTreeSet,
    fs,
    ops::Range,
    path::{Path, PathBuf},
};

use anyhow::{Context as _, bail};

use crate::{args::NamedPattern, failure::Misuse, output::PictureOutput};

/// Endings of pictures; what is inside is told by the bytes.
const ENDINGS: [&str; 6] = ["png", "exr", "jpg", "jpeg", "hdr", "webp"];

/// A picture, or a clip of several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PictureInput {
    /// What it is called.
    pub(crate) name: String,
    /// Whether that is not its path alone.
    pub(crate) is_named: bool,
    /// Its frames in order, at least one.
    pub(crate) frames: Vec<PathBuf>,
    /// Their numbers, where it is a clip of numbered files.
    numbers: Option<Vec<u32>>,
}

impl PictureInput {
    /// Finds the files of `PATH` or `NAME=PATH`: a file, a folder, whose pictures are taken in the order of
    /// their names, or a name with `####` or `%04d`, for which all numbers are taken that there are.
    pub(crate) fn find(text: &str) -> anyhow::Result<Self> {
        let whole = Path::new(text);
        let (name, path, is_named) = match text.split_once('=') {
            Some((name, path)) if !whole.exists() && !name.contains('/') => (name, Path::new(path), true),
            _ => (text, whole, false),
        };
        if name.is_empty() || path.as_os_str().is_empty() {
            bail!("'{text}' names no picture: give PATH or NAME=PATH");
        }
        let (frames, numbers) = frames(path)?;
        if frames.is_empty() {
            bail!(
                "{}: there is no picture; give a .png, .exr, .jpg, .hdr or .webp file, a folder of them, or a name with #### for the number",
                path.display()
            );
        }
        Ok(Self { name: name.to_owned(), is_named, frames, numbers })
    }

    /// The first frame, and that of another clip beside it, whose numbers are not as far from those of the
    /// first ones: then frames are missing, and those that follow would be held against others.
    pub(crate) fn out_of_step<'a>(&'a self, other: &'a Self) -> Option<(&'a Path, &'a Path)> {
        let (own, others) = (self.numbers.as_deref()?, other.numbers.as_deref()?);
        let steps = |numbers: &[u32]| numbers.iter().map(|number| number - numbers[0]).collect::<Vec<_>>();
        let at = steps(own).into_iter().zip(steps(others)).position(|(own, other)| own != other)?;
        Some((&self.frames[at], &other.frames[at]))
    }
}

/// The pictures of a clip's frames by another program.
#[derive(Clone, Debug)]
pub(crate) struct FramePictures<'a> {
    /// What they are called.
    pub(crate) name: &'a str,
    /// As it was typed.
    pub(crate) pattern: &'a Path,
    /// Those of the frames that are judged, from this one on, the last one last; at least one.
    first_frame: u32,
    files: Vec<PathBuf>,
}

impl<'a> FramePictures<'a> {
    /// Finds those of the frames of a clip that are judged: one file is that of the last, numbered ones are
    /// all there.
    pub(crate) fn find(named: &'a NamedPattern, judged: Range<u32>) -> anyhow::Result<Self> {
        let NamedPattern { name, pattern } = named;
        let output = PictureOutput::from_path(pattern);
        let is_numbered = matches!(output, PictureOutput::Sequence { .. });
        let first_frame = if is_numbered { judged.start } else { judged.end - 1 };
        let files: Vec<PathBuf> = (first_frame..judged.end).map(|frame| output.path(frame)).collect();
        let missing = files.iter().find(|file| !file.is_file());
        match missing.map(|file| file.display()) {
            None => Ok(Self { name, pattern, first_frame, files }),
            Some(missing) if is_numbered => bail!(
                "{missing}: there is no such picture; --with {name} takes those of frames {first_frame} to {}, the last half of the clip",
                judged.end - 1
            ),
            Some(missing) => bail!(
                "{missing}: there is no such picture; give --with {name} a file, or a name with #### for the number of the frame"
            ),
        }
    }

    /// The file of a frame, if there is one.
    pub(crate) fn file(&self, frame: u32) -> Option<&Path> {
        let at = frame.checked_sub(self.first_frame)?;
        self.files.get(at as usize).map(PathBuf::as_path)
    }

    /// The first one.
    pub(crate) fn first(&self) -> &Path {
        &self.files[0]
    }
}

/// The files of a clip, with their numbers where they are asked for by number.
fn frames(path: &Path) -> anyhow::Result<(Vec<PathBuf>, Option<Vec<u32>>)> {
    if path.is_file() {
        return Ok((vec![path.to_owned()], None));
    }
    if path.is_dir() {
        let mut files = listed(path)?;
        files.retain(|file| {
            let ending = file.extension().map(|ending| ending.to_ascii_lowercase());
            ending.is_some_and(|ending| ENDINGS.iter().any(|known| *known == ending))
        });
        files.sort();
        return Ok((files, None));
    }
    let pattern = PictureOutput::from_path(path);
    if !matches!(pattern, PictureOutput::Sequence { .. }) {
        bail!("{}: there is no such file or folder", path.display());
    }
    let (numbers, files) = numbered(&pattern)?.into_iter().unzip();
    Ok((files, Some(numbers)))
}

/// The files of a pattern that there are with their numbers, in order; none for what is no pattern.
fn numbered(pattern: &PictureOutput) -> anyhow::Result<Vec<(u32, PathBuf)>> {
    let PictureOutput::Sequence { before, digits, after } = pattern else { return Ok(Vec::new()) };
    let (folder, start) = before.rsplit_once('/').unwrap_or((".", before));
    let folder = if before.starts_with('/') && folder.is_empty() { "/" } else { folder };
    let mut numbered: Vec<(u32, PathBuf)> = Vec::new();
    for file in listed(Path::new(folder))? {
        let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let number = name.strip_prefix(start).and_then(|rest| rest.strip_suffix(after.as_str()));
        let number = number
            .filter(|number| number.len() >= *digits && number.bytes().all(|digit| digit.is_ascii_digit()));
        if let Some(number) = number.and_then(|number| number.parse().ok()) {
            numbered.push((number, file));
        }
    }
    numbered.sort();
    Ok(numbered)
}

/// The pieces of the frames of a sequence.
#[derive(Debug)]
pub(crate) struct FramePieces {
    /// The number of the first frame.
    pub(crate) first: u32,
    /// The pieces of each frame, in the order in which they were given; at least one.
    pub(crate) frames: Vec<Vec<PathBuf>>,
}

impl FramePieces {
    /// Finds the files of patterns with `####` or `%04d`, of which all have the same frames without a gap;
    /// nothing where the names are those of files.
    pub(crate) fn find(pieces: &[PathBuf]) -> anyhow::Result<Option<Self>> {
        let pattern = |path: &PathBuf| match PictureOutput::from_path(path) {
            sequence @ PictureOutput::Sequence { .. } if !path.exists() => Some(sequence),
            _ => None,
        };
        let patterns: Vec<Option<PictureOutput>> = pieces.iter().map(pattern).collect();
        let single = patterns.iter().position(Option::is_none);
        let numbered_at = patterns.iter().position(Option::is_some);
        match (single, numbered_at) {
            (_, None) => return Ok(None),
            (Some(single), Some(numbered)) => {
                let problem = format!(
                    "{} is one file and {} numbered ones: give the pieces of one picture, or those of a sequence, all with #### for the number",
                    pieces[single].display(),
                    pieces[numbered].display()
                );
                return Err(Misuse(problem).into());
            }
            (None, Some(_)) => {}
        }
        // Of each pattern the frames that it would name itself.
        let mut numbers: BTreeSet<u32> = BTreeSet::new();
        for (pattern, path) in patterns.iter().flatten().zip(pieces) {
            let found = numbered(pattern)?.into_iter().map(|(number, _)| number);
            let found: Vec<u32> = found.filter(|&number| pattern.path(number).is_file()).collect();
            if found.is_empty() {
                bail!("{}: there is no such file", path.display());
            }
            numbers.extend(found);
        }
        let (Some(&first), Some(&last)) = (numbers.first(), numbers.last()) else { return Ok(None) };
        let mut frames = Vec::with_capacity(numbers.len());
        for number in first..=last {
            let files: Vec<PathBuf> = patterns.iter().flatten().map(|pattern| pattern.path(number)).collect();
            if let Some(missing) = files.iter().find(|file| !file.is_file()) {
                bail!(
                    "{} is missing: the pieces have frames from {first} to {last}, and every one is needed of each",
                    missing.display()
                );
            }
            frames.push(files);
        }
        Ok(Some(Self { first, frames }))
    }
}

fn listed(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    entries.map(|entry| Ok(entry?.path())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pictures_of_judged_frames_have_to_be_there() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a-12.png", "a-13.png", "a-99.png"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let named =
            |pattern: &str| NamedPattern { name: "a".to_owned(), pattern: folder.path().join(pattern) };
        let numbered = named("a-##.png");
        let found = FramePictures::find(&numbered, 12..14).unwrap();
        let name = |frame| found.file(frame).and_then(Path::file_name).and_then(|name| name.to_str());
        assert_eq!(
            [name(11), name(12), name(13), name(14)],
            [None, Some("a-12.png"), Some("a-13.png"), None]
        );
        let single = named("a-99.png");
        let found = FramePictures::find(&single, 12..14).unwrap();
        assert_eq!([found.file(12), found.file(13)], [None, Some(single.pattern.as_path())]);
        for (pattern, said) in [
            ("a-##.png", "a-14.png: there is no such picture; --with a takes those of frames 12 to 14"),
            ("b.png", "####"),
            ("", "####"),
        ] {
            let error = FramePictures::find(&named(pattern), 12..15).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }

    #[test]
    fn files_folders_and_numbers_are_found_in_order() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a-10.png", "a-2.png", "a-09.png", "b.EXR", "notes.txt", "a-x.png"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let names = |text: &str| -> Vec<String> {
            let input = PictureInput::find(text).unwrap();
            input.frames.iter().map(|file| file.file_name().unwrap().to_str().unwrap().to_owned()).collect()
        };
        let at = |name: &str| folder.path().join(name).display().to_string();
        assert_eq!(names(&at("b.EXR")), ["b.EXR"]);
        assert_eq!(names(&at("")), ["a-09.png", "a-10.png", "a-2.png", "a-x.png", "b.EXR"]);
        assert_eq!(names(&at("a-##.png")), ["a-09.png", "a-10.png"]);
        assert_eq!(names(&at("a-%d.png")), ["a-2.png", "a-09.png", "a-10.png"]);
        let named = PictureInput::find(&format!("ours={}", at("b.EXR"))).unwrap();
        assert_eq!((named.name.as_str(), named.frames.len()), ("ours", 1));
        for (wrong, said) in [("c.png", "no such file"), ("c-##.png", "no picture")] {
            let error = PictureInput::find(&at(wrong)).unwrap_err().to_string();
            assert!(error.contains(said) && error.contains(wrong), "{error}");
        }
    }
}
