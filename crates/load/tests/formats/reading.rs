//! Files made by the tests, read from memory.

use std::path::Path;

use glam::Vec3;
use sheer_load::{LoadError, LoadOptions, Loaded, read};
use sheer_scene::{SceneParts, model::Mesh};

/// Reads bytes as a file of a name that need not exist.
pub(crate) fn load(bytes: &[u8], name: &str) -> Result<Loaded, LoadError> {
    read(bytes, &Path::new("made").join(name), &LoadOptions::default())
}

/// Reads what must be sound, without a word about it.
pub(crate) fn parts_of(bytes: &[u8], name: &str) -> SceneParts {
    let loaded = load(bytes, name).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.scene.parts().clone()
}

/// Reads what can be drawn with something to say about it.
pub(crate) fn warned(bytes: &[u8], name: &str, says: &str) -> SceneParts {
    let loaded = load(bytes, name).unwrap();
    let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.iter().any(|warning| warning.contains(says)), "{says}: {warnings:?}");
    loaded.scene.parts().clone()
}

/// Reads what cannot be drawn.
pub(crate) fn refused(bytes: &[u8], name: &str, says: &str) {
    let error = load(bytes, name).unwrap_err().to_string();
    assert!(error.contains(name) && error.contains(says), "{says}: {error}");
}

pub(crate) fn area(mesh: &Mesh) -> f32 {
    let corner = |index: u32| mesh.positions[index as usize];
    let of = |[a, b, c]: [u32; 3]| 0.5 * (corner(b) - corner(a)).cross(corner(c) - corner(a)).length();
    mesh.indices.iter().map(|corners| of(*corners)).sum()
}

pub(crate) fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).abs().max_element() < 1e-3
}
