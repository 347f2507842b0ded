//! Writing files so that an interrupted run leaves either the old file or the new one, never half of one.

use std::io::Write;
use std::path::Path;

use crate::{ImageError, Planes, ToneCurve, write_exr, write_png};

/// A pixel file format Sheer writes, chosen by the ending of the file name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// 8-bit sRGB with straight alpha, as displayed.
    Png,
    /// 32-bit linear light with premultiplied alpha, and all other planes.
    Exr,
}

impl FileFormat {
    /// The format that the ending of `path` asks for, in upper or lower case.
    ///
    /// # Errors
    /// [`ImageError::UnknownExtension`] for anything but `.png` and `.exr`.
    pub fn from_path(path: &Path) -> Result<Self, ImageError> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(ImageError::UnknownExtension { path: path.to_owned() }),
        }
    }
}

/// How a picture was made: texts by key, stored in PNG and EXR files under `sheer.KEY`, in the order given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata {
    entries: Vec<(String, String)>,
}

impl Metadata {
    /// The same with one more text, or with another text for a key that is there already.
    #[must_use]
    pub fn with(mut self, key: &str, text: impl ToString) -> Self {
        let text = text.to_string();
        match self.entries.iter_mut().find(|(known, _)| known == key) {
            Some(entry) => entry.1 = text,
            None => self.entries.push((key.to_owned(), text)),
        }
        self
    }

    /// Keys, without the prefix, and texts.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries.iter().map(|(key, text)| (key.as_str(), text.as_str()))
    }

    /// Keys as they stand in files, and texts.
    ///
    /// # Errors
    /// [`ImageError::MetadataKey`] for a key or text that PNG or EXR cannot hold.
    pub(crate) fn stored(&self) -> Result<Vec<(String, &str)>, ImageError> {
        // PNG ends a keyword after 79 bytes, EXR ends texts at NUL.
        const LONGEST_KEY_BYTES: usize = 60;
        let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
        self.entries()
            .map(|(key, text)| {
                let storable = !key.is_empty()
                    && key.len() <= LONGEST_KEY_BYTES
                    && key.chars().all(plain)
                    && !text.contains('\0');
                if storable {
                    Ok((format!("sheer.{key}"), text))
                } else {
                    Err(ImageError::MetadataKey { key: key.to_owned() })
                }
            })
            .collect()
    }
}

/// The program and version that files name as their origin.
pub(crate) const SOFTWARE: &str = concat!("Sheer ", env!("CARGO_PKG_VERSION"));

/// Finds out before a long run whether its result can be written: format, folder, permission.
///
/// # Errors
/// [`ImageError::UnknownExtension`], [`ImageError::IsFolder`], [`ImageError::MissingFolder`], or
/// [`ImageError::Write`] if the folder accepts no new file.
pub fn check_writable(path: &Path) -> Result<FileFormat, ImageError> {
    if path.is_dir() {
        return Err(ImageError::IsFolder { path: path.to_owned() });
    }
    let format = FileFormat::from_path(path)?;
    temporary_beside(path)?;
    Ok(format)
}

/// Writes a frame in the format that the ending of `path` asks for. The tone curve applies to PNG only.
///
/// # Errors
/// Those of [`write_png`] and [`write_exr`], and [`ImageError::UnknownExtension`].
pub fn write_frame(
    path: &Path,
    planes: &Planes,
    curve: ToneCurve,
    metadata: &Metadata,
) -> Result<(), ImageError> {
    match FileFormat::from_path(path)? {
        FileFormat::Png => write_png(path, &planes.colour, curve, metadata),
        FileFormat::Exr => write_exr(path, planes, metadata),
    }
}

/// Writes any file whole: into a temporary file in the same folder, which then takes the name `path`.
///
/// # Errors
/// [`ImageError::IsFolder`], [`ImageError::MissingFolder`] or [`ImageError::Write`].
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    if path.is_dir() {
        return Err(ImageError::IsFolder { path: path.to_owned() });
    }
    let failed = |source| ImageError::Write { path: path.to_owned(), source };
    let mut file = temporary_beside(path)?;
    file.write_all(bytes).map_err(failed)?;
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// An empty file in the folder of `path` that vanishes unless it is persisted.
fn temporary_beside(path: &Path) -> Result<tempfile::NamedTempFile, ImageError> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(ImageError::MissingFolder { path: path.to_owned(), folder: folder.to_owned() });
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".sheer-");
    // Temporary files are private by default; an output file gets the usual rights, less the user's umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder).map_err(|source| ImageError::Write { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn outputs_that_cannot_work_are_refused_with_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let message = |name: &str| check_writable(&folder.path().join(name)).unwrap_err().to_string();
        let missing = message("absent/out.png");
        assert!(
            missing.contains("folder") && missing.contains("absent") && missing.contains("create"),
            "{missing}"
        );
        assert!(message("out.jpg").contains(".png or .exr"));
        assert!(message("out").contains(".png or .exr"));
        std::fs::create_dir(folder.path().join("taken.png")).unwrap();
        assert!(message("taken.png").contains("this is a folder"));
        std::fs::write(folder.path().join("file"), "").unwrap();
        assert!(
            message("file/out.png").contains("does not exist") || message("file/out.png").contains("folder")
        );
    }

    #[test]
    fn checking_an_output_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(check_writable(&folder.path().join("a.PNG")).unwrap(), FileFormat::Png);
        assert_eq!(check_writable(&folder.path().join("a.exr")).unwrap(), FileFormat::Exr);
        assert_eq!(names_in(folder.path()), [""; 0]);
    }

    #[test]
    fn writing_replaces_the_old_file_and_leaves_no_temporary_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, b"a much longer first text").unwrap();
        write_whole(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(names_in(folder.path()), ["a.txt"]);
    }

    #[cfg(unix)]
    #[test]
    fn written_files_can_be_read_by_others_as_far_as_the_umask_allows() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_whole(&ours, b"").unwrap();
        std::fs::write(&plain, b"").unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_no_temporary_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::create_dir(&path).unwrap();
        assert!(matches!(write_whole(&path, b"text"), Err(ImageError::IsFolder { .. })));
        assert_eq!(names_in(folder.path()), ["a"]);
        assert!(write_whole(&path.join("b/c"), b"text").unwrap_err().to_string().contains("does not exist"));
    }

    #[test]
    fn metadata_keys_that_files_cannot_hold_are_named() {
        let refused = |key: &str, text: &str| Metadata::default().with(key, text).stored().is_err();
        assert!(!refused("commit", "19f26a5, plain or ünïcödé"));
        assert!(refused("", "x") && refused("a b", "x") && refused("ü", "x"));
        assert!(refused(&"k".repeat(61), "x") && refused("key", "a\0b"));
    }

    #[test]
    fn a_key_given_twice_keeps_its_place_and_takes_the_new_text() {
        let metadata = Metadata::default().with("seed", 1).with("scene", "pane").with("seed", 2);
        assert_eq!(metadata.entries().collect::<Vec<_>>(), [("seed", "2"), ("scene", "pane")]);
    }
}
