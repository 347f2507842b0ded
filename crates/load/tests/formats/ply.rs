//! PLY.

use std::path::Path;

use glam::{Vec2, Vec3};
use sheer_load::{LoadOptions, read};
use sheer_scene::model::AlphaMode;

use crate::reading::{area, close, parts_of, refused, warned};

/// Its vertices.
const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

/// A square of four vertices as two triangles, with what the header and rows of vertices say besides.
fn square(properties: &str, row: [&str; 4]) -> String {
    let at = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"];
    let rows: String = at.iter().zip(row).map(|(at, more)| format!("{at} {more}\n")).collect();
    format!(
        "ply\nformat ascii 1.0\ncomment made by a test\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\n{properties}element face 2\nproperty list uchar int vertex_indices\nend_header\n\
         {rows}3 0 1 2\n3 0 2 3\n"
    )
}

#[test]
fn colours_are_those_of_the_display_and_alpha_makes_it_transparent() {
    let properties = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    let text = square(properties, ["255 0 0 255", "0 255 0 51", "188 188 188 0", "0 0 255 255"]);
    let parts = parts_of(text.as_bytes(), "a.ply");
    let colours = &parts.meshes[0].colours;
    assert!(close(colours[0].truncate(), Vec3::X) && (colours[1].w - 0.2).abs() < 1e-6, "{colours:?}");
    assert!(close(colours[2].truncate(), Vec3::splat(0.5029)), "{}", colours[2]);
    assert_eq!(parts.materials[0].alpha_mode, AlphaMode::Blend);
    let opaque = square("property float r\nproperty float g\nproperty float b\n", ["1 0 0"; 4]);
    let parts = parts_of(opaque.as_bytes(), "a.ply");
    assert_eq!(parts.materials[0].alpha_mode, AlphaMode::Opaque);
    assert!(close(parts.meshes[0].colours[3].truncate(), Vec3::X));
}

/// The same square in binary, with doubles, a list before the vertices of a face, and bytes in an order.
fn binary(is_little: bool) -> Vec<u8> {
    let order = if is_little { "little" } else { "big" };
    let header = format!(
        "ply\r\nformat binary_{order}_endian 1.0\r\nelement vertex 4\r\nproperty double x\r\nproperty double y\r\n\
         property float64 z\r\nproperty ushort red\r\nproperty ushort green\r\nproperty ushort blue\r\n\
         element face 1\r\nproperty list uint8 float weights\r\nproperty list ushort int vertex_index\r\n\
         end_header\r\n"
    );
    let mut bytes = header.into_bytes();
    let mut put = |value: &[u8]| {
        let mut value = value.to_vec();
        if !is_little {
            value.reverse();
        }
        bytes.extend(value);
    };
    for at in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        at.iter().chain(&[0.5]).for_each(|value: &f64| put(&value.to_le_bytes()));
        [65535_u16, 0, 32768].iter().for_each(|value| put(&value.to_le_bytes()));
    }
    put(&[2]);
    [0.25_f32, 0.75].iter().for_each(|value| put(&value.to_le_bytes()));
    put(&4_u16.to_le_bytes());
    [0_i32, 1, 2, 3].iter().for_each(|value| put(&value.to_le_bytes()));
    bytes
}

#[test]
fn both_byte_orders_are_read_and_polygons_are_cut() {
    for is_little in [true, false] {
        let parts =
            warned(&binary(is_little), "a.ply", "element 'face': properties without effect here: 'weights'");
        let mesh = &parts.meshes[0];
        assert_eq!((mesh.indices.len(), mesh.positions.len()), (2, 4));
        assert!((area(mesh) - 1.0).abs() < 1e-6);
        assert!(close(mesh.colours[0].truncate(), Vec3::new(1.0, 0.0, 0.214)), "{}", mesh.colours[0]);
        assert!(mesh.positions.iter().all(|position| position.z == 0.5));
    }
}

#[test]
fn normals_and_texture_coordinates_are_those_of_the_file_or_made() {
    let given = square(
        "property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n",
        ["0 2 0 0.25 1"; 4],
    );
    let parts = parts_of(given.as_bytes(), "a.ply");
    assert_eq!(parts.meshes[0].normals[0], Vec3::Y);
    assert_eq!(parts.meshes[0].uv_sets[0][0], Vec2::new(0.25, 0.0), "v grows upwards in the file");
    let made = parts_of(square("", [""; 4]).as_bytes(), "a.ply");
    assert!(made.meshes[0].normals.iter().all(|normal| close(*normal, Vec3::Z)));
}

#[test]
fn odd_files_are_drawn_as_far_as_they_are_sound() {
    let plain = square("", [""; 4]);
    // A face that refers to nothing, a vertex that is not finite, an edge list, and a strip.
    let parts = warned(plain.replace("3 0 2 3", "3 0 2 9").as_bytes(), "a.ply", "faces: one face");
    assert_eq!(parts.meshes[0].indices.len(), 1);
    let parts = warned(plain.replace("0 1 0", "0 nan 0").as_bytes(), "a.ply", "not finite");
    assert_eq!(parts.meshes[0].indices.len(), 1);
    let camera = plain.replace("element face", "element camera 1\nproperty float f\nelement face");
    let camera = camera.replace("3 0 1 2\n", "35\n3 0 1 2\n");
    assert_eq!(warned(camera.as_bytes(), "a.ply", "element 'camera'").meshes[0].indices.len(), 2);
    // Vertices alone are points, with edges they are lines.
    let (header, _) = plain.split_once("element face").unwrap();
    let points = format!("{header}end_header\n0 0 0\n1 0 0\n1 nan 0\n0 1 0\n");
    assert_eq!(parts_of(points.as_bytes(), "a.ply").meshes[0].indices.len(), 3 * 8);
    let edges = format!(
        "{header}element edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n\
         0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 1\n1 7\n"
    );
    assert_eq!(warned(edges.as_bytes(), "a.ply", "left out").meshes[0].indices.len(), 6);
    let strip = plain
        .replace("element face 2\nproperty list uchar int", "element tristrips 1\nproperty list int int");
    let strip = strip.replace("3 0 1 2\n3 0 2 3\n", "9 0 1 3 2 -1 2 3 1 0\n");
    let parts = parts_of(strip.as_bytes(), "a.ply");
    assert_eq!(parts.meshes[0].indices.len(), 4);
    assert!((area(&parts.meshes[0]) - 2.0).abs() < 1e-6);
    assert!(parts.meshes[0].normals.iter().all(|normal| normal.z.abs() > 0.99));
    // Numbers of a row may stand on several lines, as they may in the format's own description.
    let broken_lines = plain.replace("1 0 0", "1\n0\n\n0");
    assert_eq!(parts_of(broken_lines.as_bytes(), "a.ply").meshes[0].indices.len(), 2);
}

#[test]
fn what_cannot_be_read_is_named_with_its_line_or_byte() {
    let plain = square("", [""; 4]);
    refused(b"ply\nformat ascii 1.0\n", "a.ply", "'end_header' is missing");
    refused(plain.replace("ascii", "utf8").as_bytes(), "a.ply", "line 2: 'utf8' is no format");
    refused(plain.replace("float y", "real y").as_bytes(), "a.ply", "line 6: 'real' is no type");
    refused(plain.replace("float z", "float w").as_bytes(), "a.ply", "no x, y and z");
    refused(
        plain.replace("vertex 4", "vertex 4000000000").as_bytes(),
        "a.ply",
        "4000000000 of 'vertex' are promised",
    );
    let two_lists = plain.replace("uchar int vertex_indices", "uchar int a\nproperty list uchar int b");
    let parts = warned(two_lists.as_bytes(), "a.ply", "no list vertex_indices");
    assert_eq!(parts.meshes[0].indices.len(), 4 * 8, "the vertices are left");
    // Where nothing is left, the first loss is the error.
    let (header, _) = plain.split_once("end_header").unwrap();
    refused(
        format!("{header}end_header\nx 0 0\n").as_bytes(),
        "a.ply",
        "the file ends before its last element",
    );
}

#[test]
fn what_is_cut_short_or_wrong_is_drawn_as_far_as_it_is_sound() {
    let plain = square("", [""; 4]);
    let cut = plain.replace("3 0 2 3\n", "");
    assert_eq!(
        warned(cut.as_bytes(), "a.ply", "the file ends before its last element").meshes[0].indices.len(),
        1
    );
    let list = plain.replace("3 0 2 3", "300000 0 2 3");
    assert_eq!(warned(list.as_bytes(), "a.ply", "a list of 300000").meshes[0].indices.len(), 1);
    let word = plain.replace("0 1 0", "0 o 0");
    let parts = warned(word.as_bytes(), "a.ply", "line 14: 'o' is not a number");
    assert_eq!(parts.meshes[0].indices.len(), 1, "one of two has that vertex");
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    for text in [cut, list, word] {
        assert!(read(text.as_bytes(), Path::new("a.ply"), &strict).is_err());
    }
    // Cut within its faces, a file still has its vertices.
    let bytes = binary(true);
    let parts = warned(&bytes[..bytes.len() - 2], "a.ply", "what stands before it is drawn");
    assert_eq!(parts.meshes[0].indices.len(), 4 * 8);
    // The only list is that of the vertices, whatever its name.
    let renamed = plain.replace("vertex_indices", "corners");
    assert_eq!(parts_of(renamed.as_bytes(), "a.ply").meshes[0].indices.len(), 2);
}

#[test]
fn faces_may_stand_first_be_concave_and_have_colours() {
    let vertices = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    let header = |elements: &str| format!("ply\nformat ascii 1.0\n{elements}end_header\n");
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    // An arrow head, whose fan around its first corner would reach outside.
    let arrow = "2 -1 0\n1 0 0\n2 1 0\n0 0 0\n";
    for (elements, body) in [
        (format!("{vertices}{faces}"), format!("{arrow}4 0 1 2 3\n")),
        (format!("{faces}{vertices}"), format!("4 0 1 2 3\n{arrow}")),
    ] {
        let parts = parts_of(format!("{}{body}", header(&elements)).as_bytes(), "a.ply");
        assert!((area(&parts.meshes[0]) - 1.0).abs() < 1e-6);
    }
    let coloured = faces.replace("element face 1", "element face 2")
        + "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let text =
        format!("{}{SQUARE}3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n", header(&format!("{vertices}{coloured}")));
    let parts = parts_of(text.as_bytes(), "a.ply");
    let mesh = &parts.meshes[0];
    let colour = |face: usize, corner: usize| mesh.colours[mesh.indices[face][corner] as usize].truncate();
    assert_eq!(mesh.positions.len(), 6, "the edge between two colours is divided");
    assert!((0..3).all(|corner| close(colour(0, corner), Vec3::X) && close(colour(1, corner), Vec3::Z)));
}

#[test]
fn colours_are_of_the_unit_in_which_they_are_written() {
    for (kind, row) in [
        ("uchar", "255 51 0"),
        ("float", "1 0.2 0"),
        ("float", "255 51 0"),
        ("int", "255 51 0"),
        ("ushort", "65535 13107 0"),
        ("double", "1 0.2 0"),
    ] {
        let properties = format!("property {kind} red\nproperty {kind} green\nproperty {kind} blue\n");
        let parts = parts_of(square(&properties, [row; 4]).as_bytes(), "a.ply");
        let colour = parts.meshes[0].colours[0].truncate();
        assert!(close(colour, Vec3::new(1.0, 0.0331, 0.0)), "{kind} {row}: {colour}");
    }
}

#[test]
fn properties_without_effect_are_named() {
    let text = square("property float quality\nproperty float f_dc_0\n", ["1 2"; 4]);
    let parts = warned(
        text.as_bytes(),
        "a.ply",
        "element 'vertex': properties without effect here: 'quality', 'f_dc_0'",
    );
    assert_eq!(parts.meshes[0].indices.len(), 2);
}
