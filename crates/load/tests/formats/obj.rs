//! OBJ and MTL.

use std::{fs, path::Path};

use glam::{Vec2, Vec3, Vec4};
use sheer_image::{Image, Metadata, encode_png};
use sheer_load::{LoadError, LoadOptions, Loaded, open_with, read};
use sheer_scene::{
    SceneParts,
    model::{AlphaMode, Wrap},
};

use crate::reading::{area, close, load, parts_of, refused, warned};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn square(rest: &str) -> Vec<u8> {
    format!("# made by a test\n{SQUARE}{rest}").into_bytes()
}

/// A file with materials and images beside it.
struct Folder {
    folder: tempfile::TempDir,
}

impl Folder {
    fn new(mtl: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let faces = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3 4/4\n";
        fs::write(folder.path().join("a.obj"), format!("mtllib a.mtl\n{SQUARE}{faces}")).unwrap();
        fs::write(folder.path().join("a.mtl"), mtl).unwrap();
        Self { folder }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Adds an image of two texels.
    fn image(self, name: &str, texels: [[u8; 4]; 2]) -> Self {
        let image = Image::from_fn(2, 1, |x, _| texels[x as usize]).unwrap();
        fs::write(self.path().join(name), encode_png(&image, &Metadata::default()).unwrap()).unwrap();
        self
    }

    fn open(&self) -> Result<Loaded, LoadError> {
        open_with(self.path().join("a.obj"), &LoadOptions::default())
    }

    fn parts(&self) -> SceneParts {
        let loaded = self.open().unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded.scene.parts().clone()
    }

    fn warned(&self, says: &str) -> SceneParts {
        let loaded = self.open().unwrap();
        let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        assert!(warnings.iter().any(|warning| warning.contains(says)), "{says}: {warnings:?}");
        loaded.scene.parts().clone()
    }
}

/// The material of the faces: the first is that of faces without one.
fn material(parts: &SceneParts) -> &sheer_scene::model::Material {
    &parts.materials[parts.meshes[0].material as usize]
}

#[test]
fn faces_count_from_one_or_backwards_and_every_kind_of_corner_is_read() {
    for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1// 2// 3// 4//", "f 1 2 \\\n3 4", "f 1 2 3 4 # a square"] {
        let parts = parts_of(&square(face), "a.obj");
        assert_eq!(parts.meshes[0].indices.len(), 2, "{face}");
        assert!((area(&parts.meshes[0]) - 1.0).abs() < 1e-6, "{face}");
        assert!(close(parts.meshes[0].normals[0], Vec3::Z), "{face}: made from the face");
    }
    let full = "vt 0.25 1\nvn 0 3 0\nf 1/1/1 2/-1/-1 3/1/1\n";
    let parts = parts_of(&square(full), "a.obj");
    assert_eq!(parts.meshes[0].normals[0], Vec3::Y);
    assert_eq!(parts.meshes[0].uv_sets[0][1], Vec2::new(0.25, 0.0), "v grows upwards in the file");
}

#[test]
fn corners_without_coordinates_or_normals_do_not_shift_those_of_others() {
    let mixed = "vt 0 0\nvt 1 1\nvn 0 0 -1\nf 1 2/2 3//1\nf 1/1 3/2/1 4\n";
    let parts = parts_of(&square(mixed), "a.obj");
    let mesh = &parts.meshes[0];
    let find = |position: Vec3, uv: Vec2| {
        (0..mesh.positions.len()).any(|at| mesh.positions[at] == position && mesh.uv_sets[0][at] == uv)
    };
    assert!(find(Vec3::X, Vec2::new(1.0, 0.0)) && find(Vec3::ZERO, Vec2::new(0.0, 1.0)));
    assert!(mesh.normals.iter().all(|normal| normal.is_normalized()));
    assert!(mesh.normals.contains(&Vec3::NEG_Z));
}

#[test]
fn a_concave_polygon_is_filled_as_it_is_drawn() {
    let arrow = b"v 2 -1 0\nv 1 0 0\nv 2 1 0\nv 0 0 0\nf 1 2 3 4\n";
    let parts = parts_of(arrow, "a.obj");
    assert!((area(&parts.meshes[0]) - 1.0).abs() < 1e-6);
}

#[test]
fn objects_and_materials_are_apart_and_smoothing_groups_hold() {
    let text = "o left\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\ng right\nf 1 2 4\no left\nf 2 3 4\n";
    let loaded = warned(&square(text), "a.obj", "material 'red': no material file has it");
    let ids: Vec<(u32, u32)> =
        loaded.instances.iter().map(|instance| (instance.id, instance.geometry)).collect();
    assert_eq!(ids, [(1, 0), (1, 1), (2, 0)], "what goes on with a name belongs to it");
    assert_eq!(loaded.meshes[1].indices.len(), 2);
    // Two squares at a right angle.
    let corner = "v 0 0 1\nv 1 0 1\n";
    for (group, is_smooth) in [("s 1\n", true), ("s off\n", false), ("", false)] {
        let parts = parts_of(&square(&format!("{corner}{group}f 1 2 3 4\nf 2 1 5 6\n")), "a.obj");
        let normals = &parts.meshes[0].normals;
        let diagonal = Vec3::new(0.0, 1.0, 1.0).normalize();
        assert_eq!(normals.iter().any(|normal| close(*normal, diagonal)), is_smooth, "{group}");
    }
}

#[test]
fn lines_and_points_are_drawn() {
    let parts = parts_of(&square("vt 0 0\nl 1 2 3/1\np 4 1\nf 1 2 3\n"), "a.obj");
    let triangles: Vec<usize> = parts.meshes.iter().map(|mesh| mesh.indices.len()).collect();
    assert_eq!(triangles, [1, 2 * 6, 2 * 8]);
    let geometries: Vec<u32> = parts.instances.iter().map(|instance| instance.geometry).collect();
    assert_eq!(geometries, [0, 1, 2]);
}

#[test]
fn vertex_colours_may_have_an_alpha() {
    let text = b"v 0 0 0 1 0 0 0.5\nv 1 0 0 0 1 0 1\nv 0 1 0 0 0 1\nf 1 2 3\n";
    let parts = parts_of(text, "a.obj");
    let [first, second, ..] = parts.meshes[0].colours[..] else { panic!("no colours") };
    assert!(close(first.truncate(), Vec3::X) && first.w == 0.5, "{first}");
    assert!(close(second.truncate(), Vec3::Y) && second.w == 1.0, "{second}");
    assert_eq!(parts.materials[parts.meshes[0].material as usize].alpha_mode, AlphaMode::Blend);
    // Some programs write bytes in the place of shares.
    let bytes = parts_of(b"v 0 0 0 255 0 0\nv 1 0 0 0 51 0\nv 0 1 0 0 0 0\nf 1 2 3\n", "a.obj");
    let shares = parts_of(b"v 0 0 0 1 0 0\nv 1 0 0 0 0.2 0\nv 0 1 0 0 0 0\nf 1 2 3\n", "a.obj");
    assert!(
        bytes.meshes[0].colours.iter().zip(&shares.meshes[0].colours).all(|(a, b)| (a - b).length() < 1e-6)
    );
    // A fourth number alone is a weight, which triangles do not have.
    assert!(parts_of(b"v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n", "a.obj").meshes[0].colours.is_empty());
}

#[test]
fn opacity_is_d_or_what_tr_leaves() {
    for (mtl, opacity) in [
        ("d 0.25", 0.25),
        ("Tr 0.25", 0.75),
        ("d 0.5\nTr 0.9", 0.5),
        ("d -halo 0.5", 0.5),
        ("Kd 1 0 0", 1.0),
        ("Tf 1 1 1\nillum 2", 1.0),
        ("Tf 0.5 0.5 0.5\nd 0.5", 0.5),
    ] {
        let parts = Folder::new(&format!("newmtl a\n{mtl}\n")).parts();
        let material = material(&parts);
        assert!((material.base_colour.w - opacity).abs() < 1e-6, "{mtl}: {}", material.base_colour.w);
        assert_eq!(material.alpha_mode == AlphaMode::Blend, opacity < 1.0, "{mtl}");
        assert_eq!(material.transmission, 0.0, "{mtl}");
    }
}

#[test]
fn tf_colours_what_passes() {
    let parts = Folder::new("newmtl a\nKd 0 0 0\nd 0.4\nTf 1 0.5 0\n").parts();
    let glass = material(&parts);
    // Through the whole of it passes (1 - d) Tf.
    let passes = glass.transmission * glass.base_colour.truncate();
    assert!(close(passes, 0.6 * Vec3::new(1.0, 0.5, 0.0)), "{passes}");
    assert!((glass.base_colour.w - (1.0 - glass.transmission)).abs() < 1e-6);
    assert_eq!(glass.alpha_mode, AlphaMode::Blend);
    // Clear glass that is ray-traced lets light through even if nobody wrote d.
    let parts = Folder::new("newmtl a\nTf 1 1 1\nillum 7\n").parts();
    assert!(material(&parts).transmission > 0.5);
}

#[test]
fn images_colour_and_cut_out() {
    let red_and_blue = [[255, 0, 0, 255], [0, 0, 255, 255]];
    let layout = "-s 2 3 1 -o 0.25 0.5 -clamp on";
    let text = format!("newmtl a\nKd 0 0 0\nmap_Kd {layout} my wood.png\nmap_d {layout} -bm 1 mask.png\n");
    let text = text.as_str();
    let folder = Folder::new(text).image("my wood.png", red_and_blue);
    let folder = folder.image("mask.png", [[255; 4], [51, 51, 51, 255]]);
    let parts = folder.parts();
    let used = material(&parts).base_colour_texture.unwrap();
    let texture = &parts.textures[used.texture as usize];
    assert_eq!(texture.image.as_slice(), [[255, 0, 0, 255], [0, 0, 255, 51]]);
    assert!(texture.srgb && texture.wrap == [Wrap::ClampToEdge; 2]);
    assert_eq!(material(&parts).base_colour, Vec4::ONE, "black under an image is a habit of exporters");
    // The lower left corner of the file, at (0, 0), has (0.25, 0.5) there; here v runs down.
    let at = used.transform.transform_point2(Vec2::new(0.0, 1.0));
    assert!((at - Vec2::new(0.25, 0.5)).length() < 1e-6, "{at}");
    assert_eq!(material(&parts).alpha_mode, AlphaMode::Blend);

    // An image of its own alpha, as colour and as mask, and one without.
    let leaf = [[0, 255, 0, 255], [0, 255, 0, 0]];
    for text in ["map_Kd leaf.png", "map_Kd leaf.png\nmap_d leaf.png"] {
        let parts = Folder::new(&format!("newmtl a\n{text}\n")).image("leaf.png", leaf).parts();
        assert_eq!(parts.textures[0].image.as_slice(), leaf);
        assert_eq!(material(&parts).alpha_mode, AlphaMode::Blend);
    }
    let parts = Folder::new("newmtl a\nmap_Kd x.png\n").image("x.png", red_and_blue).parts();
    assert_eq!(material(&parts).alpha_mode, AlphaMode::Opaque);
}

#[test]
fn a_mask_has_a_layout_of_its_own() {
    let files = |text: &str| {
        let folder =
            Folder::new(&format!("newmtl a\n{text}\n")).image("c.png", [[255, 0, 0, 255], [0, 0, 255, 255]]);
        folder.image("m.png", [[255; 4], [0, 0, 0, 255]])
    };
    // The mask is repeated on the colours, or the colours on the mask.
    let parts = files("map_Kd c.png\nmap_d -s 2 1 1 m.png").parts();
    let (red, blue) = ([255, 0, 0], [0, 0, 255]);
    let texels = |parts: &SceneParts| -> Vec<([u8; 3], bool)> {
        let used = material(parts).base_colour_texture.unwrap();
        let texels = parts.textures[used.texture as usize].image.as_slice();
        texels.iter().map(|&[r, g, b, a]| ([r, g, b], a > 127)).collect()
    };
    assert_eq!(texels(&parts), [(red, true), (red, false), (blue, true), (blue, false)]);
    let parts = files("map_Kd -s 2 1 1 c.png\nmap_d m.png").parts();
    assert_eq!(texels(&parts), [(red, true), (blue, true), (red, false), (blue, false)]);
    assert_eq!(material(&parts).base_colour_texture.unwrap().transform, glam::Affine2::IDENTITY);
    // Turned around by half of its width.
    let parts = files("map_Kd c.png\nmap_d -o 0.5 0 m.png").parts();
    assert_eq!(texels(&parts), [(red, false), (blue, true)]);
    files("map_Kd c.png\nmap_d -s 1.5 1 1 m.png").warned("line 3: it is laid out otherwise than 'map_Kd'");
}

#[test]
fn images_of_other_systems_are_found_and_read() {
    let folder = Folder::new("newmtl a\nmap_Kd Textures\\Wood.PNG\n");
    fs::create_dir(folder.path().join("textures")).unwrap();
    let folder = folder.image("textures/wood.png", [[9, 9, 9, 255]; 2]);
    let parts = folder.warned("'textures/wood.png' was taken from beside the file for 'Textures\\Wood.PNG'");
    assert!(material(&parts).base_colour_texture.is_some());
    // A TGA has its alpha in a fourth byte, or means nothing by it.
    let tga = |alpha: u8| {
        let header = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 32, 0x28];
        [&header[..], &[3, 2, 1, alpha]].concat()
    };
    for (alpha, seen) in [(77, 77), (0, 255)] {
        let folder = Folder::new("newmtl a\nmap_Kd a.TGA\n");
        fs::write(folder.path().join("a.TGA"), tga(alpha)).unwrap();
        assert_eq!(folder.parts().textures[0].image.as_slice(), [[1, 2, 3, seen]]);
    }
}

#[test]
fn materials_are_read_once_wherever_they_are_named() {
    // By a path of another machine, in quotes, in other letters, twice, before and after what uses them.
    for line in ["mtllib C:\\models\\a.mtl", "mtllib \"a.mtl\"", "mtllib A.MTL", "mtllib ./a.mtl a.mtl"] {
        let folder = Folder::new("newmtl a\nKd 1 0 0\n");
        let faces = format!("usemtl a\nf 1 2 3\n{line}\nmtllib a.mtl\n");
        fs::write(folder.path().join("a.obj"), format!("{SQUARE}{faces}")).unwrap();
        let parts = folder.open().unwrap().scene.parts().clone();
        assert!(close(material(&parts).base_colour.truncate(), Vec3::X), "{line}");
    }
    Folder::new("newmtl a\nmap_Ka x.png\n")
        .warned("a.mtl, line 2: 'map_Ka' has no effect here without 'map_Kd'");
}

#[test]
fn what_is_missing_beside_the_file_is_named_and_drawn_without() {
    let alone = square("mtllib none.mtl\nusemtl a\nf 1 2 3 4\n");
    let parts = warned(&alone, "a.obj", "line 6: its materials are not there");
    let grey = material(&parts).base_colour;
    assert!(grey.x == grey.y && grey.x > 0.2 && grey.x < 0.9, "{grey}");
    let parts = Folder::new("newmtl a\nmap_Kd gone.png\n").warned("a.mtl, line 2: its image was left out");
    assert!(material(&parts).base_colour_texture.is_none());
    let folder = Folder::new("newmtl a\nmap_Kd C:\\Users\\me\\wood.png\n");
    let folder = folder.image("wood.png", [[9, 9, 9, 255]; 2]);
    let parts = folder.warned("'wood.png' was taken from beside the file for 'C:\\Users\\me\\wood.png'");
    assert!(material(&parts).base_colour_texture.is_some());
    let parts = Folder::new("newmtl a\nmap_Kd ../../secret.png\n").warned("lies outside the folder");
    assert!(parts.textures.is_empty());
    let parts = Folder::new("newmtl a\nKd 1 x 0\nd 0.5\n").warned("line 2: the line was left out: 'x'");
    assert_eq!(material(&parts).base_colour.w, 0.5);
    Folder::new("newmtl a\nbump b.png\n").warned("a.mtl: 'bump' has no effect here");
}

#[test]
fn odd_files_are_drawn_as_far_as_they_are_sound() {
    for (rest, says, count) in [
        (
            "f 1 2 3\nf 1 2 9\n",
            "line 7: a face was left out: it refers to vertex 9, but 4 stand before it",
            1,
        ),
        ("f 1 2 3\nf 0 1 2\n", "line 7: a face was left out: it refers to vertex 0", 1),
        ("f 1 2 3\nf -9 1 2\n", "vertex -9", 1),
        (
            "f 1 2 3\nf 1/7 2/7 3/7\n",
            "line 7: a face is drawn without a part of it: it refers to texture coordinate 7",
            2,
        ),
        ("f 1 2 3\nf 1//1 2//1 3//1\n", "normal 1, but 0 stand before it", 2),
        ("f 1 2 3\nf 1 2\n", "line 7: a face of fewer than three corners", 1),
        ("v nan 0 0\nf 1 2 3\nf 1 2 5\n", "line 8: a face with a vertex that is not finite", 1),
        ("f 1 2 3\ncurv 0 1 1 2\n", "'curv' has no effect", 1),
    ] {
        let parts = warned(&square(rest), "a.obj", says);
        assert_eq!(parts.meshes.iter().map(|mesh| mesh.indices.len()).sum::<usize>(), count, "{rest}");
    }
    // Blanks, tabs, endings of other systems, words that nobody knows, an object without faces.
    for odd in
        ["\tf  1\t2 3 \r\n", "vp 0.1\nlod 3\nf 1 2 3", "o none\no some\nf 1 2 3", "vt 0.5\nf 1/1 2/1 3/1"]
    {
        assert_eq!(parts_of(&square(odd), "a.obj").meshes.len(), 1, "{odd}");
    }
    // One bad line does not cost the file, and those after it keep their numbers.
    for (rest, says, count) in [
        ("v 9 zero 9\nv 1 1 1\nf 1 2 6\nf 1 2 5\n", "line 6: 'zero' is not a number", 1),
        ("vt 0,5 0\nvt 1 1\nf 1/2 2/1 3/2\n", "line 6: '0,5' is not a number", 1),
        ("vn 0 0\nf 1//1 2//1 3//1\n", "line 6: a number is missing", 1),
        ("f 1 2 3\nf 1 2 three\n", "line 7: a face was left out: 'three' is not a number", 1),
        ("f 1 2 3\nf /1 2 3\n", "line 7: a face was left out: '/1' names no vertex", 1),
        ("f 1 2 3\nl 1 9 2\n", "line 7: a vertex was left out: it refers to vertex 9", 1 + 6),
    ] {
        let parts = warned(&square(rest), "a.obj", says);
        assert_eq!(parts.meshes.iter().map(|mesh| mesh.indices.len()).sum::<usize>(), count, "{rest}");
        let strict = LoadOptions { strict: true, ..LoadOptions::default() };
        let error = read(&square(rest), Path::new("a.obj"), &strict).unwrap_err().to_string();
        assert!(error.contains(says) && error.contains("without --strict"), "{error}");
    }
    // Vertices alone are points, as scanners write them.
    assert_eq!(parts_of(SQUARE.as_bytes(), "a.obj").meshes[0].indices.len(), 4 * 8);
    // Of a thousand broken faces some are told, the others counted.
    let many = format!("f 1 2 3\n{}", "f 1 2 99\n".repeat(1000));
    let loaded = load(&square(&many), "a.obj").unwrap();
    assert_eq!(loaded.warnings.len(), 51);
    assert_eq!(loaded.warnings[50].to_string(), "950 more warnings of this kind were left out");
}

#[test]
fn what_cannot_be_read_is_named_with_its_line() {
    // Where nothing is left, the first loss is the error.
    refused(b"v 0 0\n", "a.obj", "line 1: a vertex needs three numbers");
    refused(&square("f 1 2 three\n"), "a.obj", "line 6: a face was left out: 'three' is not a number");
    refused(&square("f 1 2 9\n"), "a.obj", "line 6: a face was left out: it refers to vertex 9");
    refused(b"PK\x03\x04 not an obj at all", "a.obj", "this is no OBJ file");
}
