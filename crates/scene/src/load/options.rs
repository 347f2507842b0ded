//! How a file is read.

use std::path::PathBuf;

use sheer_core::text::MemorySize;

/// What a caller may say of how a file is read. The default reads whatever is sound, and nothing that lies
/// outside the file's own folder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// A part that is broken or missing is an error for the whole file. Otherwise what is sound is loaded,
    /// and each part that is not is a [`LoadWarning::Lost`](crate::LoadWarning::Lost); where nothing is left
    /// to draw, the first of them is the error.
    pub strict: bool,
    /// Folders besides the file's own that the files it refers to may lie in, at any depth.
    pub allowed_folders: Vec<PathBuf>,
    /// What the scene may take in memory in all, with its acceleration structure: counted before it is taken.
    /// Without a limit there still is one of what is decoded from a file of its size.
    pub memory_limit: Option<MemorySize>,
}
