//! One door for built-in scenes and files.

use std::path::Path;

use sheer_load::{Contents, LoadError, LoadOptions, Loaded};

use crate::{
    catalogue::{build, is_builtin, unknown},
    error::GalleryError,
};

/// Opens a scene, files with the default [`LoadOptions`].
///
/// # Errors
/// As [`open_with`].
pub fn open(text: &str) -> Result<Loaded, GalleryError> {
    open_with(text, &LoadOptions::default())
}

/// Opens a scene: a built-in by name, with parameters as `layers:count=8,alpha=0.2`, or a file by path. Where
/// a file is called as a built-in scene is, the scene is meant.
///
/// # Errors
/// [`GalleryError`] says what is wrong, where, and what to do.
pub fn open_with(text: &str, options: &LoadOptions) -> Result<Loaded, GalleryError> {
    if is_builtin(text) {
        options.check_without_choices(Path::new(text))?;
        return Ok(Loaded { scene: build(text)?, warnings: Vec::new(), contents: Contents::default() });
    }
    sheer_load::open_with(text, options).map_err(|error| match error {
        LoadError::UnknownFormat { .. } => unknown(text),
        other => other.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_opens_a_built_in_scene_and_a_path_a_file() {
        assert_eq!(open("layers:count=2").unwrap().scene.name(), "layers");
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/no-such-file.GLB");
        assert!(matches!(open(file), Err(GalleryError::Load(LoadError::Read { .. }))));
        for neither in ["layer", "layers.gltf.txt", ""] {
            let error = open(neither).unwrap_err().to_string();
            assert!(error.contains("neither a built-in scene nor a .gltf, .glb, .obj, "), "{error}");
            assert_eq!(error.contains("the nearest is 'layers'"), neither == "layer", "{error}");
        }
    }
}
