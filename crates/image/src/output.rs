//! Frames as files: which format, whether it can be written, and writing it.

use std::path::Path;

use crate::{
    error::ImageError,
    exr_file::encode_exr_piece,
    metadata::Metadata,
    piece::Piece,
    planes::Planes,
    png_file::write_png,
    tone::{DisplayShare, Tone},
    whole_file::{temporary_beside, write_whole},
};

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
    check_place(path)?;
    Ok(format)
}

/// The same of a file that is no picture.
///
/// # Errors
/// [`ImageError::IsFolder`], [`ImageError::MissingFolder`], or [`ImageError::Write`] if the folder accepts no
/// new file.
pub fn check_place(path: &Path) -> Result<(), ImageError> {
    if path.is_dir() {
        return Err(ImageError::IsFolder { path: path.to_owned() });
    }
    temporary_beside(path)?;
    Ok(())
}

/// Writes a piece of a picture, or the whole of it, in the format that the ending of `path` asks for. Its
/// place in the picture goes into the metadata as `size`, `crop` and `sample_range` (see [`Piece`]).
///
/// A PNG file has what is displayed, and says as `tone` and `exposure_ev` how it came about. EXR keeps linear
/// light as it is, and with a piece how much of it is display-referred, so that [`merge`](crate::merge) can
/// make a PNG of it.
///
/// # Errors
/// Those of [`write_png`] and [`write_exr`](crate::write_exr), and [`ImageError::UnknownExtension`].
pub fn write_frame(
    path: &Path,
    planes: &Planes,
    piece: &Piece,
    tone: Tone,
    share: &DisplayShare,
    metadata: &Metadata,
) -> Result<(), ImageError> {
    let metadata = piece.described(metadata.clone());
    match FileFormat::from_path(path)? {
        FileFormat::Png => write_png(path, &planes.colour, tone, share, &tone.described(metadata)),
        FileFormat::Exr => {
            let share = if piece.is_whole() { &DisplayShare::Nothing } else { share };
            write_whole(path, &encode_exr_piece(planes, piece, share, &metadata)?)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
