//! Outputs: checked before the first frame, written whole or not at all.

use std::{
    fs,
    io::{self, Write as _},
    path::{Path, PathBuf},
    process,
    sync::{Mutex, MutexGuard, PoisonError},
    thread,
    time::Duration,
};

use anyhow::Context as _;
use sheer_image::{
    DisplayShare, FileFormat, Metadata, Piece, Planes, Tone, check_place, check_writable, write_frame,
    write_whole,
};

use crate::{
    failure::Misuse,
    video::{self, VideoFormat},
};

/// The folder of outputs that were not named.
pub(crate) const FOLDER: &str = "sheer-out";

/// Held while a file is being written.
static WRITING: Mutex<()> = Mutex::new(());

fn writing() -> MutexGuard<'static, ()> {
    // The lock guards no data that a panic could have left half-changed.
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Lets Ctrl-C and SIGTERM end the program between two files and never within one, where a temporary file
/// would stay behind.
pub(crate) fn finish_writing_when_interrupted() {
    let interrupted = || {
        let _files_are_whole = writing();
        let _nobody_misses_the_encoder = video::abandon();
        // 128 + SIGINT, as shells report it.
        process::exit(130);
    };
    // Without the handler an interruption works as well, only less tidily.
    let _ = ctrlc::set_handler(interrupted);
}

/// Waits, a while, until no file is being written: for whoever is about to end the program and may be who is
/// writing.
pub(crate) fn wait_for_writing() {
    const TRIES: u32 = 100;
    for _ in 0..TRIES {
        if WRITING.try_lock().is_ok() {
            return;
        }
        thread::sleep(Duration::from_millis(10));
    }
}

/// Writes to stdout.
///
/// # Errors
/// Whatever the system says; a broken pipe among it, which ends the program in silence.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    Ok(stdout.flush()?)
}

/// A file for text, or stdout where it is called `-`.
#[derive(Debug)]
pub(crate) struct TextOutput<'a>(&'a Path);

impl<'a> TextOutput<'a> {
    /// Finds out whether it can be written.
    pub(crate) fn open(path: &'a Path) -> anyhow::Result<Self> {
        if path != Path::new("-") {
            check_file(path)?;
        }
        Ok(Self(path))
    }

    /// Whether the text replaces what would be printed otherwise.
    pub(crate) fn is_stdout(&self) -> bool {
        self.0 == Path::new("-")
    }

    /// Writes it.
    pub(crate) fn write(&self, text: &str) -> anyhow::Result<()> {
        if self.is_stdout() {
            return print(text);
        }
        let _interruptions_wait = writing();
        Ok(write_whole(self.0, text.as_bytes())?)
    }
}

/// Refuses to write two things to stdout, which no program could tell apart.
pub(crate) fn check_stdout(outputs: &[(&str, Option<&Path>)]) -> Result<(), Misuse> {
    let printed = outputs.iter().filter(|(_, path)| *path == Some(Path::new("-")));
    let options: Vec<&str> = printed.map(|(option, _)| *option).collect();
    match &options[..] {
        [first, second, ..] => {
            Err(Misuse(format!("{first} and {second} are both to go to stdout: give a file to one of them")))
        }
        _ => Ok(()),
    }
}

/// Finds out whether a file of any kind can be written.
fn check_file(path: &Path) -> anyhow::Result<()> {
    let _interruptions_wait = writing();
    Ok(check_place(path)?)
}

/// Writes a file whole.
pub(crate) fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let _interruptions_wait = writing();
    Ok(write_whole(path, bytes)?)
}

/// Makes a folder, if need be, that accepts files.
pub(crate) fn open_folder(folder: &Path) -> anyhow::Result<()> {
    make_folder(folder)?;
    let _interruptions_wait = writing();
    check_place(&folder.join("index.html"))?;
    Ok(())
}

fn make_folder(folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}: choose another with -o", folder.display()))
}

/// A picture file, one for each frame, or a video.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum PictureOutput {
    /// One file of one picture.
    Single(PathBuf),
    /// One file of all frames.
    Video(VideoFormat, PathBuf),
    /// Numbered files: what stands before the number, its least number of digits, what stands after it.
    Sequence {
        /// Folder and beginning of the name.
        before: String,
        /// The number is filled up with zeros to this length.
        digits: usize,
        /// Rest of the name.
        after: String,
    },
}

impl PictureOutput {
    /// Reads `####` or `%04d` in the file name as where the number of the frame goes.
    pub(crate) fn from_path(path: &Path) -> Self {
        let single = || match VideoFormat::from_path(path) {
            Some(format) => Self::Video(format, path.to_owned()),
            None => Self::Single(path.to_owned()),
        };
        let Some(text) = path.to_str() else { return single() };
        let name_at = text.rfind('/').map_or(0, |slash| slash + 1);
        let number = hashes(&text[name_at..]).or_else(|| percent(&text[name_at..]));
        let Some((at, length, digits)) = number else { return single() };
        let (before, after) = (&text[..name_at + at], &text[name_at + at + length..]);
        Self::Sequence { before: before.to_owned(), digits, after: after.to_owned() }
    }

    /// The file of a frame.
    pub(crate) fn path(&self, frame: u32) -> PathBuf {
        match self {
            Self::Single(path) | Self::Video(_, path) => path.clone(),
            Self::Sequence { before, digits, after } => {
                // A width of the formatter has 16 bits, a name as many places as the user likes.
                let number = frame.to_string();
                let zeros = "0".repeat(digits.saturating_sub(number.len()));
                format!("{before}{zeros}{number}{after}").into()
            }
        }
    }

    /// Whether every frame is in it, and not the last one alone.
    pub(crate) fn has_all_frames(&self) -> bool {
        !matches!(self, Self::Single(_))
    }

    /// Whether frames are written as a display shows them, not in linear light.
    pub(crate) fn is_displayed(&self) -> bool {
        match self {
            Self::Video(..) => true,
            _ => matches!(FileFormat::from_path(&self.path(0)), Ok(FileFormat::Png)),
        }
    }

    /// Finds out whether the frames can be written. The folder of a sequence is made if need be; it and the
    /// ending are the same for all frames, so the first one tells.
    pub(crate) fn check(&self, first_frame: u32) -> anyhow::Result<()> {
        let path = self.path(first_frame);
        if let Self::Video(..) = self {
            return check_file(&path);
        }
        if let Self::Sequence { .. } = self {
            if VideoFormat::from_path(&path).is_some() {
                let problem =
                    "a video has all frames in one file; leave the place of a number out of its name";
                return Err(Misuse(format!("{}: {problem}", path.display())).into());
            }
            FileFormat::from_path(&path)?;
            make_folder(path.parent().unwrap_or(Path::new("")))?;
        }
        let _interruptions_wait = writing();
        check_writable(&path)?;
        Ok(())
    }

    /// Writes the file of a frame.
    pub(crate) fn write(
        &self,
        frame: u32,
        planes: &Planes,
        piece: &Piece,
        tone: Tone,
        share: &DisplayShare,
        metadata: &Metadata,
    ) -> anyhow::Result<()> {
        let _interruptions_wait = writing();
        Ok(write_frame(&self.path(frame), planes, piece, tone, share, metadata)?)
    }
}

/// Position, length and digits of the first run of two or more `#`.
fn hashes(name: &str) -> Option<(usize, usize, usize)> {
    let at = name.find("##")?;
    let length = name[at..].bytes().take_while(|&byte| byte == b'#').count();
    Some((at, length, length))
}

/// Position, length and digits of the first `%d`, `%4d` or `%04d`.
fn percent(name: &str) -> Option<(usize, usize, usize)> {
    name.match_indices('%').find_map(|(at, _)| {
        let digits = name[at + 1..].bytes().take_while(u8::is_ascii_digit).count();
        let width = &name[at + 1..at + 1 + digits];
        let number = name[at + 1 + digits..].starts_with('d');
        let width = if width.is_empty() { Some(1) } else { width.parse().ok().filter(|&width| width <= 20) };
        width.filter(|_| number).map(|width| (at, digits + 2, width))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame_7(pattern: &str) -> String {
        PictureOutput::from_path(Path::new(pattern)).path(7).display().to_string()
    }

    #[test]
    fn a_frame_number_goes_where_the_name_says() {
        assert_eq!(frame_7("out/a-####.png"), "out/a-0007.png");
        assert_eq!(frame_7("a%04d.exr"), "a0007.exr");
        assert_eq!(frame_7("a%d.exr"), "a7.exr");
        assert_eq!(frame_7("100%/##.png"), "100%/07.png");
        let long = frame_7(&format!("{}.png", "#".repeat(70_000)));
        assert_eq!(long, format!("{}7.png", "0".repeat(69_999)));
    }

    #[test]
    fn a_name_without_a_place_for_a_number_is_one_file() {
        for plain in ["a.png", "take#2.png", "50%.png", "50%off.exr", "####/a.png", "a%99999d.png"] {
            assert_eq!(frame_7(plain), plain);
        }
    }
}
