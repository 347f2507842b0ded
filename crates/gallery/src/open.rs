//! One door for built-in scenes and files.

use sheer_scene::{Loaded, SceneError};

use crate::{catalogue::build, error::GalleryError};

/// Opens a scene: a built-in by name, with parameters as `layers:count=8,alpha=0.2`, or a `.gltf` or `.glb`
/// file by path.
///
/// # Errors
/// [`GalleryError`] says what is wrong, where, and what to do.
pub fn open(text: &str) -> Result<Loaded, GalleryError> {
    match sheer_scene::open(text) {
        // What has no extension of a file is the text of a built-in scene.
        Err(SceneError::UnknownFormat { .. }) => Ok(Loaded { scene: build(text)?, warnings: Vec::new() }),
        loaded => Ok(loaded?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_opens_a_built_in_scene_and_a_path_a_file() {
        assert_eq!(open("layers:count=2").unwrap().scene.name(), "layers");
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/no-such-file.GLB");
        assert!(matches!(open(file), Err(GalleryError::Scene(SceneError::Read { .. }))));
        for neither in ["layer", "layers.gltf.txt", ""] {
            let error = open(neither).unwrap_err().to_string();
            assert!(error.contains("neither a built-in scene nor a .gltf or .glb file"), "{error}");
        }
    }
}
