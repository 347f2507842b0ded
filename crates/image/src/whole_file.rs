//! Writing files so that an interrupted run leaves either the old file or the new one, never half of one; and
//! reading files of which nothing is known but their name.

use std::fs::File;
use std::io::{self, Read as _, Write as _};
use std::path::Path;

use crate::error::ImageError;

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

/// Reads a whole file of at most `most_bytes`. What is no regular file is not even opened: a pipe waits for a
/// writer who may never come, and a device may have no end.
///
/// # Errors
/// What the system says; [`io::ErrorKind::InvalidInput`] for a pipe, a device or a folder,
/// [`io::ErrorKind::FileTooLarge`] for more bytes, and [`io::ErrorKind::OutOfMemory`] where they find no
/// room.
pub fn read_whole(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        let problem = "this is no regular file but a pipe, a device or a folder";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    let too_large = |length: u64| {
        let problem = format!("it holds {length} bytes, and at most {most_bytes} are read");
        io::Error::new(io::ErrorKind::FileTooLarge, problem)
    };
    if metadata.len() > most_bytes {
        return Err(too_large(metadata.len()));
    }
    let mut bytes = Vec::new();
    let length = usize::try_from(metadata.len()).map_err(|_| io::ErrorKind::OutOfMemory)?;
    bytes.try_reserve_exact(length).map_err(|_| io::ErrorKind::OutOfMemory)?;
    // What the system makes up as it is read states no length.
    File::open(path)?.take(most_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        return Err(too_large(bytes.len() as u64));
    }
    Ok(bytes)
}

/// An empty file in the folder of `path`, to take its name when it is whole: it vanishes unless it is
/// persisted.
///
/// # Errors
/// [`ImageError::MissingFolder`], or [`ImageError::Write`] if the folder accepts no new file.
pub fn temporary_beside(path: &Path) -> Result<tempfile::NamedTempFile, ImageError> {
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
    fn a_file_is_read_up_to_a_length() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, b"12345").unwrap();
        assert_eq!(read_whole(&path, 5).unwrap(), b"12345");
        assert_eq!(read_whole(&path, 4).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read_whole(folder.path(), 5).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        assert_eq!(read_whole(&folder.path().join("none"), 5).unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_has_no_end_is_not_read() {
        let endless = Path::new("/dev/zero");
        assert_eq!(read_whole(endless, u64::MAX).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        // It says that it is empty.
        let made_up = Path::new("/proc/self/smaps");
        assert_eq!(read_whole(made_up, 100).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
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

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_no_temporary_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::create_dir(&path).unwrap();
        assert!(matches!(write_whole(&path, b"text"), Err(ImageError::IsFolder { .. })));
        assert_eq!(names_in(folder.path()), ["a"]);
        assert!(write_whole(&path.join("b/c"), b"text").unwrap_err().to_string().contains("does not exist"));
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
}
