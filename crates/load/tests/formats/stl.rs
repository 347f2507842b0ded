//! STL.

use glam::Vec3;
use sheer_scene::model::AlphaMode;

use crate::reading::{area, close, parts_of, refused, warned};

const TEXT: &str = "solid part
  facet normal 0 0 1
    outer loop
      vertex 0 0 0
      vertex 1 0 0
      vertex 1.0e0 1 0
    endloop
  endfacet
  facet normal 0 0 1
    outer loop
      vertex 0 0 0
      vertex 1 1 0
      vertex 0 1 0
    endloop
  endfacet
endsolid part
";

/// Two triangles of a square with words of attributes, under a header.
pub(crate) fn binary(header: &[u8], attributes: [u16; 2]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(2_u32.to_le_bytes());
    let corners = [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]]];
    for (corners, attributes) in corners.iter().zip(attributes) {
        for [x, y] in [[0.0, 0.0]].iter().chain(corners) {
            bytes.extend([*x, *y, 0.0].iter().flat_map(|value: &f32| value.to_le_bytes()));
        }
        bytes.extend(attributes.to_le_bytes());
    }
    bytes
}

#[test]
fn text_and_binary_hold_the_same_square_that_lies_on_the_ground() {
    // Many binary files begin like text.
    let binaries = [&b"made by a test"[..], b"solid part"].map(|header| binary(header, [0; 2]));
    for bytes in [TEXT.as_bytes().to_vec()].iter().chain(&binaries) {
        let parts = parts_of(bytes, "a.stl");
        let mesh = &parts.meshes[0];
        assert_eq!((mesh.indices.len(), mesh.positions.len()), (2, 4), "corners are shared");
        assert!((area(mesh) - 1.0).abs() < 1e-6);
        // What is up in the file is up in the scene.
        let up = parts.nodes[0].transform.to_affine().transform_vector3(Vec3::Z);
        assert!(close(up, Vec3::Y), "{up}");
        assert!(parts.materials[0].double_sided);
    }
}

#[test]
fn colours_of_both_dialects_are_read() {
    // VisCAM: five bits each of blue, green and red, valid with the highest bit.
    let parts = parts_of(&binary(b"", [0x8000 | 31 << 10, 0x8000 | 31]), "a.stl");
    let colours = &parts.meshes[0].colours;
    assert!(close(colours[0].truncate(), Vec3::X) && close(colours[5].truncate(), Vec3::Z), "{colours:?}");
    // Magics: the colour of the whole in the header, with opacity; red in the low bits, without the flag.
    let parts = parts_of(&binary(b"COLOR=\x00\xff\x00\x80", [0x8000, 31]), "a.stl");
    let colours = &parts.meshes[0].colours;
    assert!(close(colours[0].truncate(), Vec3::Y) && close(colours[5].truncate(), Vec3::X), "{colours:?}");
    assert!((colours[0].w - 0.502).abs() < 1e-3);
    assert_eq!(parts.materials[0].alpha_mode, AlphaMode::Blend);
    // Attributes without the flag are no colour.
    assert!(parts_of(&binary(b"", [7, 7]), "a.stl").meshes[0].colours.is_empty());
}

#[test]
fn odd_files_are_drawn_as_far_as_they_are_sound() {
    let whole = binary(b"", [0; 2]);
    let parts = warned(&whole[..84 + 50 + 20], "a.stl", "2 triangles are promised, only 1 are there");
    assert_eq!(parts.meshes[0].indices.len(), 1);
    let mut longer = whole.clone();
    longer.extend([0; 30]);
    assert_eq!(parts_of(&longer, "a.stl").meshes[0].indices.len(), 2);
    // A number that was never filled in, and one that is too small.
    for (claimed, says, count) in
        [(0, "no triangles are promised, but 2 are there", 2), (1, "50 bytes after them", 1)]
    {
        let mut other = whole.clone();
        other[80] = claimed;
        assert_eq!(warned(&other, "a.stl", says).meshes[0].indices.len(), count, "{says}");
    }
    let mut broken = whole;
    broken[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(warned(&broken, "a.stl", "not finite").meshes[0].indices.len(), 1);
    assert_eq!(
        warned(TEXT.replace("endsolid part\n", "").as_bytes(), "a.stl", "without 'endsolid'").meshes.len(),
        1
    );
    let fewer = TEXT.replacen("      vertex 1 0 0\n", "", 1);
    assert_eq!(warned(fewer.as_bytes(), "a.stl", "line 6: a facet of fewer").meshes[0].indices.len(), 1);
    let several = format!("{TEXT}{}", TEXT.replace("part", "other"));
    assert_eq!(parts_of(several.as_bytes(), "a.stl").meshes[0].indices.len(), 4);
    let shouting = TEXT.to_uppercase().replacen("SOLID", "solid", 1);
    assert_eq!(parts_of(shouting.as_bytes(), "a.stl").meshes[0].indices.len(), 2);
    let windows = TEXT.replace('\n', "\r\n");
    assert_eq!(parts_of(windows.as_bytes(), "a.stl").meshes[0].indices.len(), 2);
}

#[test]
fn what_cannot_be_read_is_named_with_its_line_or_byte() {
    for (text, says, count) in [
        (TEXT.replace("1.0e0", "1,0"), "line 6: '1,0' is not a number", 1),
        (TEXT.replace("1.0e0 1 0", "1 1"), "line 6: a number is missing", 1),
        (TEXT.replace("outer loop", "inner loop"), "line 3: 'inner' is no word of STL", 2),
    ] {
        assert_eq!(warned(text.as_bytes(), "a.stl", says).meshes[0].indices.len(), count, "{says}");
    }
    refused(b"solid ground is what it stands on\nand no more\n", "a.stl", "line 2: 'and' is no word of STL");
    refused(b"", "a.stl", "this is no STL file");
    refused(&binary(b"", [0; 2])[..100], "a.stl", "byte 80: 2 triangles are promised");
}
