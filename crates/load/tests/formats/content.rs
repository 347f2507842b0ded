//! Which format a file has.

use std::fs;

use sheer_load::{LoadError, endings, open};

use crate::reading::{load, parts_of};

const PLY: &[u8] =
    b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn content_counts_for_more_than_an_ending() {
    for name in ["scan.ply", "scan.PLY", "scan", "scan.stl", "scan.obj", "scan.glb"] {
        assert_eq!(parts_of(PLY, name).meshes.len(), 1, "{name}");
    }
    for nothing in [&b"hello"[..], b"", b"\x89PNG\r\n\x1a\n"] {
        let error = load(nothing, "picture.xyz").unwrap_err();
        assert!(matches!(error, LoadError::UnknownFormat { .. }), "{error}");
        assert!(error.to_string().contains(".gltf, .glb, .obj, .ply, .stl or .hair"), "{error}");
    }
    assert!(endings().ends_with("or .hair"));
}

#[test]
fn files_open_by_path_and_name_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan of a vase.ply");
    fs::write(&path, PLY).unwrap();
    assert_eq!(open(&path).unwrap().scene.name(), "scan of a vase");
    let missing = open(folder.path().join("none.obj")).unwrap_err().to_string();
    assert!(missing.contains("cannot read") && missing.contains("none.obj"), "{missing}");
}
