//! What is said about bad files: the file, the place in it, what is wrong, what to do.

use std::{fs, path::Path};

use serde_json::json;
use sheer_load::{LoadError, LoadOptions, open, open_with, read_gltf};

use crate::builder::Builder;

/// Loads what `spoil` made of a good file, and checks place and problem of the error; and that the same is
/// said, in a warning if there is anything left to draw, where only what is sound is asked for.
fn refused(spoil: impl FnOnce(&mut Builder), place: &str, problems: &[&str]) {
    let mut builder = Builder::triangle();
    spoil(&mut builder);
    let error = builder.load_strictly().expect_err(place);
    let (LoadError::File { path, place: found_place, problem }
    | LoadError::Limit { path, place: found_place, problem }) = &error
    else {
        panic!("{error}")
    };
    assert_eq!(path, Path::new("made/test.glb"));
    assert!(found_place.contains(place), "{error}");
    for part in problems {
        assert!(problem.contains(part), "'{part}' is not in: {error}");
    }
    let said = match builder.load() {
        Ok(loaded) => loaded.warnings.iter().map(|warning| format!("{warning}\n")).collect(),
        Err(error) => error.to_string(),
    };
    assert!(said.contains(problem), "'{problem}' is not in: {said}");
}

#[test]
fn an_unknown_required_extension_is_named() {
    let spoil = |builder: &mut Builder| builder.json["extensionsRequired"] = json!(["VENDOR_magic"]);
    refused(spoil, "extensionsRequired", &["VENDOR_magic", "export the file again without it"]);
}

#[test]
fn other_versions_are_named() {
    let spoil = |builder: &mut Builder| builder.json["asset"]["version"] = json!("1.0");
    refused(spoil, "asset", &["'1.0'", "glTF 2.0"]);
    let spoil = |builder: &mut Builder| {
        builder.json["asset"]["version"] = json!("1.0");
        builder.json["meshes"] = json!({"mesh_0": {}});
    };
    refused(spoil, "asset", &["'1.0'", "glTF 2.0"]);
    let spoil = |builder: &mut Builder| builder.json["nodes"] = json!([7]);
    refused(spoil, "nodes[0]", &["it is 7", "an object is expected", "export the file again"]);
}

#[test]
fn what_is_written_off_but_plainly_is_read_and_said() {
    let mut builder = Builder::triangle();
    let count = builder.json["accessors"][0]["count"].as_f64().unwrap();
    builder.json["accessors"][0]["count"] = json!(count);
    builder.json["skins"] = json!(null);
    let loaded = builder.load().unwrap();
    assert_eq!(loaded.scene.parts().meshes[0].indices.len(), 1);
    let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.iter().any(|warning| warning.contains("whole numbers")), "{warnings:?}");
}

#[test]
fn resources_outside_the_folder_are_refused() {
    for uri in
        ["../secret.bin", "/etc/passwd", "http://example.org/a.bin", "a/%2e%2e/%2e%2e/b.bin", "file:///a"]
    {
        let (json, _) = Builder::triangle().separate(uri);
        let error =
            read_gltf(&json, Path::new("made/test.gltf"), &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.contains("made/test.gltf: buffers[0]: "), "{error}");
        assert!(error.contains("move it there") || error.contains("put it there"), "{error}");
    }
}

#[test]
fn resources_in_allowed_folders_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let [models, shared] = ["models", "shared"].map(|name| folder.path().join(name));
    fs::create_dir(&models).unwrap();
    fs::create_dir(&shared).unwrap();
    let builder = Builder::triangle();
    let (json, binary) = builder.separate("../shared/data.bin");
    fs::write(shared.join("data.bin"), binary).unwrap();
    let file = models.join("scene.gltf");
    fs::write(&file, json).unwrap();

    let error = open(&file).unwrap_err().to_string();
    assert!(error.contains(&format!("--allow-folder '{}'", shared.display())), "{error}");
    let allowing =
        |folder: &Path| LoadOptions { allowed_folders: vec![folder.to_owned()], ..LoadOptions::default() };
    assert!(open_with(&file, &allowing(&models)).is_err());
    for allowed in [shared.as_path(), folder.path()] {
        assert_eq!(open_with(&file, &allowing(allowed)).unwrap().scene.parts().meshes.len(), 1);
    }
}

#[test]
fn what_is_gltf_inside_opens_under_any_name() {
    let folder = tempfile::tempdir().unwrap();
    let builder = Builder::triangle();
    let (json, binary) = builder.separate("data.bin");
    fs::write(folder.path().join("data.bin"), binary).unwrap();
    for (name, bytes) in [("avatar.vrm", builder.glb()), ("upload", builder.glb()), ("a.json", json)] {
        let file = folder.path().join(name);
        fs::write(&file, bytes).unwrap();
        assert_eq!(open(&file).unwrap().scene.parts().meshes.len(), 1, "{name}");
    }
    let other = folder.path().join("picture.png");
    fs::write(&other, b"\x89PNG\r\n\x1A\n").unwrap();
    for no_scene in [other.as_path(), folder.path()] {
        assert!(matches!(open(no_scene), Err(LoadError::UnknownFormat { .. })));
    }
}

#[test]
fn missing_and_short_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let builder = Builder::triangle();
    let (json, binary) = builder.separate("data.bin");
    let file = folder.path().join("scene.gltf");
    fs::write(&file, json).unwrap();
    let load = || open(file.to_str().unwrap()).unwrap_err().to_string();
    assert!(load().contains("data.bin"), "{}", load());
    fs::write(folder.path().join("data.bin"), &binary[..20]).unwrap();
    assert!(
        load().contains("buffers[0]: it should hold 36 bytes but holds 20; the data is cut short"),
        "{}",
        load()
    );
    let error = open(folder.path().join("none.glb")).unwrap_err().to_string();
    assert!(error.contains("none.glb"), "{error}");
    for path in ["layers", "scene.xyz", ""] {
        assert!(matches!(open(path), Err(LoadError::UnknownFormat { .. })), "{path}");
    }
}

#[test]
fn a_glb_cut_short_is_an_error_at_every_length() {
    let glb = Builder::triangle().glb();
    for length in 0..glb.len() {
        assert!(
            read_gltf(&glb[..length], Path::new("cut.glb"), &LoadOptions::default()).is_err(),
            "{length}"
        );
    }
    read_gltf(&glb, Path::new("cut.glb"), &LoadOptions::default()).unwrap();
}

#[test]
fn indices_out_of_range_name_their_place() {
    let spoil = |builder: &mut Builder| {
        let indices = builder.accessor("SCALAR", 5123, &[0, 0, 1, 0, 3, 0], 3);
        builder.primitive()["indices"] = json!(indices);
    };
    refused(
        spoil,
        "meshes[0].primitives[0].indices ('Body')",
        &["index 3", "only 3 vertices", "export the file again"],
    );
    let spoil = |builder: &mut Builder| builder.attribute("NORMAL", 77);
    refused(spoil, "meshes[0].primitives[0].attributes.NORMAL ('Body')", &["accessor 77", "only 1"]);
    refused(
        |builder| builder.json["nodes"][0]["mesh"] = json!(5),
        "nodes[0] ('root')",
        &["mesh 5", "only 1"],
    );
    refused(|builder| builder.json["scene"] = json!(9), "scene", &["scene 9"]);
    refused(
        |builder| builder.primitive()["material"] = json!(4),
        "meshes[0].primitives[0] ('Body')",
        &["material 4"],
    );
    refused(|builder| builder.json["accessors"][0]["bufferView"] = json!(8), "POSITION", &["buffer view 8"]);
    refused(|builder| builder.json["nodes"][0]["children"] = json!([3]), "nodes[0] ('root')", &["node 3"]);
}

#[test]
fn positions_that_are_not_finite_name_mesh_and_accessor() {
    let spoil = |builder: &mut Builder| {
        let positions = builder.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0, 0.0]);
        builder.attribute("POSITION", positions);
    };
    refused(
        spoil,
        "meshes[0].primitives[0].attributes.POSITION ('Body')",
        &["element 1 of accessor 1 is not finite", "repair the mesh"],
    );
}

#[test]
fn attributes_of_other_lengths_are_refused() {
    let spoil = |builder: &mut Builder| {
        let normals = builder.floats("VEC3", &[0.0; 6]);
        builder.attribute("NORMAL", normals);
    };
    refused(spoil, "NORMAL", &["2 values for 3 positions"]);
}

#[test]
fn counts_beyond_the_data_are_refused() {
    let count =
        |count: u64| move |builder: &mut Builder| builder.json["accessors"][0]["count"] = json!(count);
    refused(count(4), "POSITION", &["asks for 4 elements", "cut short"]);
    refused(count(u64::MAX), "POSITION", &["cut short"]);
    // Zeros need no data, but memory.
    let zeros = |count: u64| {
        move |builder: &mut Builder| {
            builder.json["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": count});
        }
    };
    refused(zeros(1 << 40), "accessors[0]", &["more than a file of this size may hold", "split the file"]);
    refused(zeros(u64::MAX), "accessors[0]", &["more than a file of this size may hold"]);
    let sparse = |builder: &mut Builder| {
        let sparse = json!({"count": 1_u64 << 40, "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}});
        builder.json["accessors"][0]["sparse"] = sparse;
    };
    refused(sparse, "accessors[0]", &["sparse", "do not fit"]);
    let sparse_index = |builder: &mut Builder| {
        let indices = builder.view(&[200]);
        builder.json["accessors"][0]["sparse"] = json!({"count": 1, "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": 0}});
    };
    refused(sparse_index, "accessors[0]", &["sparse: index 200"]);
}

#[test]
fn a_thousand_uses_of_one_accessor_are_paid_for() {
    let spoil = |builder: &mut Builder| {
        let many = builder.accessor("VEC3", 5126, &vec![0; 12 << 16], 1 << 16);
        builder.json["meshes"][0]["primitives"] =
            json!(vec![json!({"attributes": {"POSITION": many}}); 5000]);
    };
    refused(spoil, "", &["more than a file of this size may hold"]);
}

#[test]
fn a_billion_triangles_by_instancing_are_refused() {
    let spoil = |builder: &mut Builder| {
        let many = builder.accessor("VEC3", 5126, &vec![0; 36 << 15], 3 << 15);
        builder.attribute("POSITION", many);
        let places = builder.accessor("VEC3", 5126, &vec![0; 12 * ((1 << 15) + 1)], (1 << 15) + 1);
        builder.json["nodes"][0]["extensions"] =
            json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
    };
    refused(spoil, "meshes", &["1073741824 drawn", "reduce or split the file"]);
}

#[test]
fn cycles_and_second_parents_are_refused() {
    let nodes = |nodes: serde_json::Value| move |builder: &mut Builder| builder.json["nodes"] = nodes;
    refused(
        nodes(json!([{"children": [1]}, {"children": [0]}])),
        "nodes[0]",
        &["its own ancestor", "break the cycle"],
    );
    refused(nodes(json!([{"children": [0]}])), "nodes[0]", &["its own ancestor"]);
    refused(
        nodes(json!([{"children": [2]}, {"children": [2]}, {}])),
        "nodes[2]",
        &["both node 0 and node 1", "one parent"],
    );
    let spoil = |builder: &mut Builder| builder.json["nodes"][0]["translation"] = json!([1e39, 0, 0]);
    refused(spoil, "nodes[0] ('root')", &["not finite"]);
}

#[test]
fn animation_faults_name_the_channel() {
    let spoil = |times: &'static [f32], values: usize| {
        move |builder: &mut Builder| {
            let input = builder.floats("SCALAR", times);
            let output = builder.floats("VEC3", &vec![0.0; 3 * values]);
            builder.json["animations"] = json!([{"name": "walk",
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                "samplers": [{"input": input, "output": output}]}]);
        }
    };
    refused(spoil(&[1.0, 0.5], 2), "animations[0].channels[0] ('walk')", &["key 1", "sort the keys"]);
    refused(spoil(&[0.0, 0.5], 3), "animations[0].channels[0] ('walk')", &["3 values where its keys need 2"]);
    refused(spoil(&[f32::NAN], 1), "animations[0].channels[0] ('walk')", &["key 0"]);
}

#[test]
fn skins_without_enough_joints_are_refused() {
    let spoil = |builder: &mut Builder| {
        let joints = builder.accessor("VEC4", 5121, &[7; 12], 3);
        let weights = builder.floats("VEC4", &[1.0; 12]);
        builder.attribute("JOINTS_0", joints);
        builder.attribute("WEIGHTS_0", weights);
        builder.json["skins"] = json!([{"joints": [0]}]);
        builder.json["nodes"][0]["skin"] = json!(0);
    };
    refused(spoil, "nodes[0] ('root')", &["joint 7", "only 1"]);
    let spoil = |builder: &mut Builder| {
        let matrices = builder.floats("MAT4", &[0.0; 16]);
        builder.json["skins"] = json!([{"joints": [0, 0], "inverseBindMatrices": matrices}]);
    };
    refused(spoil, "skins[0]", &["2 joints have only 1"]);
}

#[test]
fn images_that_are_no_images_or_bombs_are_refused() {
    let with_image = |bytes: Vec<u8>| {
        move |builder: &mut Builder| {
            let view = builder.view(&bytes);
            builder.json["images"] = json!([{"name": "wood", "bufferView": view}]);
            builder.json["textures"] = json!([{"source": 0}]);
            builder.material(json!({"emissiveTexture": {"index": 0}}));
        }
    };
    refused(with_image(b"not an image".to_vec()), "images[0] ('wood')", &["PNG, JPEG, WebP, BMP or TGA"]);
    // A PNG header that claims 60,000 pixels a side.
    let mut bomb = b"\x89PNG\r\n\x1A\n\0\0\0\rIHDR\0\0\xEA\x60\0\0\xEA\x60\x08\x06\0\0\0".to_vec();
    bomb.extend(crc(&bomb[12..]).to_be_bytes());
    bomb.extend(b"\0\0\0\0IDAT\x35\xAF\x06\x1E");
    refused(with_image(bomb), "images[0] ('wood')", &["60000x60000", "scale it down"]);
}

/// CRC-32 of a PNG chunk.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(
            crc ^ u32::from(byte),
            |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 },
        )
    })
}

#[test]
fn compressed_bombs_and_damage_are_refused() {
    let meshopt = |count: u64, bytes: &'static [u8]| {
        move |builder: &mut Builder| {
            let data = builder.view(bytes);
            let (offset, length) = (builder.json["bufferViews"][data]["byteOffset"].clone(), bytes.len());
            builder.json["bufferViews"][0]["extensions"] = json!({"EXT_meshopt_compression": {
                "buffer": 0, "byteOffset": offset, "byteLength": length, "byteStride": 12, "count": count, "mode": "ATTRIBUTES"}});
        }
    };
    refused(meshopt(1 << 40, &[0xA0; 64]), "bufferViews[0]", &["more than a file of this size may hold"]);
    refused(
        meshopt(1000, &[0xA0; 64]),
        "bufferViews[0]",
        &["meshopt compression", "compress the file again"],
    );
    refused(meshopt(3, &[7; 64]), "bufferViews[0]", &["first byte"]);
}

#[cfg(feature = "draco")]
#[test]
fn draco_streams_must_hold_what_the_accessors_say() {
    let draco = |bytes: &'static [u8]| {
        move |builder: &mut Builder| {
            let data = builder.view(bytes);
            let indices =
                builder.push("accessors", json!({"componentType": 5125, "type": "SCALAR", "count": 3}));
            let primitive = builder.primitive();
            primitive["indices"] = json!(indices);
            primitive["extensions"] =
                json!({"KHR_draco_mesh_compression": {"bufferView": data, "attributes": {"POSITION": 0}}});
        }
    };
    let place = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression ('Body')";
    refused(draco(b"DRACO\x02\x02"), place, &["cut short", "compress the file again"]);
    // Four thousand million triangles by edgebreaker.
    refused(
        draco(b"DRACO\x02\x02\x01\x01\0\0\0\x03\xFF\xFF\xFF\xFF\x0F\0\x01\0"),
        place,
        &["other numbers of triangles"],
    );
    refused(draco(b"DRACO\x02\x02\x01\x00\0\0\x01\x03\x01\0\x01"), place, &["compress the file again"]);
}
