//! Everything that can go wrong between pixels and files.

use std::path::PathBuf;

/// Why an image could not be made, read or written. Each message says what to do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// A width or height of zero, or more bytes than this machine can hold.
    #[error(
        "an image of {width}x{height} pixels cannot be held in memory: choose a size from 1x1 up that fits"
    )]
    Size {
        /// Width asked for, in pixels.
        width: u32,
        /// Height asked for, in pixels.
        height: u32,
    },
    /// A pixel list whose length is not width times height.
    #[error("an image of {width}x{height} pixels was given {found} pixels: give exactly width times height")]
    PixelCount {
        /// Width, in pixels.
        width: u32,
        /// Height, in pixels.
        height: u32,
        /// Length of the pixel list.
        found: usize,
    },
    /// Two images that belong together differ in size.
    #[error(
        "{what}: {}x{} and {}x{} pixels, but both images need the same size",
        first.0, first.1, second.0, second.1
    )]
    SizesDiffer {
        /// What the images are.
        what: &'static str,
        /// Width and height of the first image, in pixels.
        first: (u32, u32),
        /// Width and height of the second image, in pixels.
        second: (u32, u32),
    },
    /// The folder of an output file does not exist.
    #[error("cannot write {}: the folder {} does not exist, create it first", path.display(), folder.display())]
    MissingFolder {
        /// The file that was to be written.
        path: PathBuf,
        /// The folder that is missing.
        folder: PathBuf,
    },
    /// An output file would replace a folder.
    #[error("cannot write {}: this is a folder, name a file in it", path.display())]
    IsFolder {
        /// The folder that stands where a file was to be written.
        path: PathBuf,
    },
    /// A file name whose ending says nothing about its format.
    #[error("cannot tell the format of {}: end its name with .png or .exr", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
    },
    /// The system refused to write.
    #[error("cannot write {}: {source}; check permissions and free space", path.display())]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The system refused to read.
    #[error("cannot read {}: {source}; check the name and permissions", path.display())]
    Read {
        /// The file that was to be read.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A metadata key that the file formats cannot hold.
    #[error(
        "metadata key {key:?} cannot be stored: use 1 to 60 ASCII letters, digits, '.', '-' and '_', and a text without NUL"
    )]
    MetadataKey {
        /// The key as it was given.
        key: String,
    },
    /// An encoder refused the image.
    #[error("cannot encode as {format}: {reason}")]
    Encode {
        /// `PNG` or `EXR`.
        format: &'static str,
        /// What the encoder said.
        reason: String,
    },
    /// Bytes that are not a readable image.
    #[error("cannot decode {what}: {reason}; save it again as a plain {formats}")]
    Decode {
        /// The file, or what the bytes were meant to be.
        what: String,
        /// What the decoder said.
        reason: String,
        /// The formats that would be understood.
        formats: &'static str,
    },
    /// An image whose sides or decoded pixels are above the limits.
    #[error(
        "{what} holds {width}x{height} pixels, above the limit of {max_side_px} pixels a side and {max_bytes} bytes: scale it down"
    )]
    TooLarge {
        /// The file, or what the bytes were meant to be.
        what: String,
        /// Width as the file states it, in pixels.
        width: u64,
        /// Height as the file states it, in pixels.
        height: u64,
        /// The longest side allowed, in pixels.
        max_side_px: u32,
        /// The most memory that decoding may take.
        max_bytes: u64,
    },
    /// An image that the decoder gave up on when it reached the memory limit.
    #[error(
        "{what} takes more than the limit of {max_bytes} bytes to decode: scale it down or drop its embedded metadata"
    )]
    TooMuchMemory {
        /// The file, or what the bytes were meant to be.
        what: String,
        /// The most memory that decoding may take.
        max_bytes: u64,
    },
}
