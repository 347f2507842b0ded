//! How a file is read.

use std::path::PathBuf;

/// What a caller may say of how a file is read. The default reads nothing that lies outside the file's own
/// folder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Folders besides the file's own that the files it refers to may lie in, at any depth.
    pub allowed_folders: Vec<PathBuf>,
}
