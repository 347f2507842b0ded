//! How a file is read.

use std::path::{Path, PathBuf};

use sheer_core::text::MemorySize;

use crate::LoadError;

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
    /// The animation to play, by its name or its number from 0; `all` plays all that do not get in each
    /// other's way, as `None` does, and `none` holds everything at rest.
    pub clip: Option<String>,
    /// The scene to show, by its name or its number from 0; the one that the file names if `None`.
    pub scene: Option<String>,
    /// The variant of materials to show, by its name or its number from 0; what materials are without one if
    /// `None`.
    pub variant: Option<String>,
}

impl LoadOptions {
    /// Checks that nothing is chosen in what leaves no choice: `path` names it.
    ///
    /// # Errors
    /// [`LoadError::NoChoice`] names the first thing that was chosen.
    pub fn check_without_choices(&self, path: &Path) -> Result<(), LoadError> {
        let clip = self.clip.as_ref().filter(|clip| !matches!(clip.as_str(), "all" | "none"));
        for (what, wanted) in
            [("clip", clip), ("scene", self.scene.as_ref()), ("variant", self.variant.as_ref())]
        {
            if let Some(wanted) = wanted {
                return Err(LoadError::NoChoice {
                    path: path.to_owned(),
                    what,
                    wanted: wanted.clone(),
                    available: "it has none".to_owned(),
                });
            }
        }
        Ok(())
    }
}
