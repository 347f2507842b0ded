//! `sheer inspect`, and the options for what it lists.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::fs;

use crate::run::{json, sheer, succeed};

/// A triangle with two scenes, two clips, two variants, a camera, a light, and a colour that lets through.
const FILE: &str = r#"{
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_materials_variants", "KHR_materials_sheen", "KHR_lights_punctual"],
    "extensions": {
        "KHR_materials_variants": {"variants": [{"name": "clear"}, {"name": "solid"}]},
        "KHR_lights_punctual": {"lights": [{"type": "point", "name": "lamp", "intensity": 40}]}
    },
    "buffers": [{"byteLength": 68, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAA="}],
    "bufferViews": [
        {"buffer": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 8},
        {"buffer": 0, "byteOffset": 44, "byteLength": 24}
    ],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
        {"bufferView": 1, "componentType": 5126, "type": "SCALAR", "count": 2},
        {"bufferView": 2, "componentType": 5126, "type": "VEC3", "count": 2}
    ],
    "materials": [
        {"name": "glass", "alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 0.25]}},
        {"name": "brick"}
    ],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "extensions": {
        "KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}}}]}],
    "cameras": [{"name": "front", "type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
    "nodes": [
        {"mesh": 0}, {"mesh": 0}, {"camera": 0, "translation": [0.3, 0.3, 5]},
        {"translation": [0, 2, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}}
    ],
    "scenes": [{"name": "one", "nodes": [0, 2, 3]}, {"name": "two", "nodes": [0, 1, 2]}],
    "animations": [
        {"name": "slide", "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
         "samplers": [{"input": 1, "output": 2}]},
        {"name": "jump", "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
         "samplers": [{"input": 1, "output": 2}]}
    ]
}"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.gltf"), FILE).unwrap();
    folder
}

#[test]
fn it_tells_what_a_file_holds() {
    let folder = folder();
    let text = succeed(folder.path(), "inspect a.gltf").stdout;
    for says in [
        "a.gltf: glTF 2.0",
        "1 instance at 4 nodes, 1 triangle",
        "KHR_materials_sheen",
        "has no effect here",
        "Scenes (--scene)",
        "Variants of materials (--variant)",
        "Animations (--clip)",
        "(0.3, 0.3, 5)",
        "28.6° high",
        "lamp",
        "glass",
        "0.250",
        "animations[1] ('jump') is not played",
    ] {
        assert!(text.contains(says), "{says} is missing in\n{text}");
    }

    let outcome = succeed(folder.path(), "inspect a.gltf --json -");
    let report = json(&outcome.stdout);
    assert_eq!(report["counts"]["triangles"], 1);
    assert_eq!(report["bounds"][1][0], 1.0);
    assert_eq!(report["extensions"][1]["has_effect"], false);
    assert_eq!(report["scenes"][0]["shown"], true);
    assert_eq!(report["clips"][0]["duration_secs"], 1.0);
    assert_eq!(report["clips"][1]["plays"], false);
    assert_eq!(report["variants"][1]["name"], "solid");
    assert_eq!(report["cameras"][0]["eye"][2], 5.0);
    assert_eq!(report["lights"][0]["position"][1], 2.0);
    assert_eq!(report["materials"][0]["mode"], "blend");
    assert_eq!(report["materials"][0]["alpha"][0], 0.25);
    assert!(report["memory"]["geometry"].as_u64().unwrap() > 0);
    assert_eq!(report["warnings"].as_array().unwrap().len(), 2);
}

#[test]
fn other_formats_and_built_in_scenes_are_told_of_as_well() {
    let folder = folder();
    fs::write(folder.path().join("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n").unwrap();
    let text = succeed(folder.path(), "inspect a.obj").stdout;
    assert!(
        text.contains("a.obj: OBJ") && text.contains("7 triangles") && text.contains("(default view)"),
        "{text}"
    );
    let report = json(&succeed(folder.path(), "inspect plume:particles=500 --json -").stdout);
    assert_eq!((&report["format"], &report["counts"]["particles"]), (&"".into(), &500.into()));
    assert_eq!(report["cameras"][0]["name"], "static");
    succeed(folder.path(), "inspect a.obj --json out.json");
    assert_eq!(json(&fs::read_to_string(folder.path().join("out.json")).unwrap())["format"], "OBJ");
}

#[test]
fn what_is_listed_can_be_chosen() {
    let folder = folder();
    let counted = |options: &str, key: &str| {
        let outcome = succeed(folder.path(), &format!("inspect a.gltf {options} --json -"));
        json(&outcome.stdout)["counts"][key].as_u64().unwrap()
    };
    assert_eq!(counted("", "instances"), 1);
    assert_eq!(counted("--scene two", "instances"), 2);
    assert_eq!(counted("--scene 1", "instances"), 2);
    let solid = succeed(folder.path(), "inspect a.gltf --variant solid --json -");
    assert_eq!(json(&solid.stdout)["materials"][0]["name"], "brick");
    let jump = json(&succeed(folder.path(), "inspect a.gltf --clip jump --json -").stdout);
    assert_eq!((&jump["clips"][0]["plays"], &jump["clips"][1]["plays"]), (&false.into(), &true.into()));
    // The same options hold for every command that opens a file; what is not there is wrong use.
    succeed(
        folder.path(),
        "render a.gltf --clip none --scene one --variant clear -a none --size 8x8 -o a.png",
    );
    for (options, says) in [
        ("inspect a.gltf --clip fly", "no clip 'fly'; it has 0 'slide', 1 'jump'"),
        ("render a.gltf --scene 7 -o b.png", "no scene '7'; it has 0 'one', 1 'two'"),
        ("render a.gltf --variant red -o b.png", "no variant 'red'; it has 0 'clear', 1 'solid'"),
        ("render layers --variant red -o b.png", "layers: there is no variant 'red'; it has none"),
        ("inspect none.xyz", "neither a built-in scene nor a .gltf"),
    ] {
        let outcome = sheer(folder.path(), options);
        assert_eq!(outcome.code, Some(2), "{outcome:?}");
        assert!(outcome.stderr.contains(says), "{says}: {}", outcome.stderr);
    }
}

#[test]
fn a_picture_of_nothing_is_warned_about() {
    let folder = folder();
    let away = "render a.gltf -a none --size 8x8 --eye 0,0,50 --target 0,0,90 -o a.png";
    let outcome = succeed(folder.path(), away);
    assert!(outcome.stderr.contains("nothing is in the picture"), "{}", outcome.stderr);
    let outcome = succeed(folder.path(), "render a.gltf -a none --size 8x8 -o a.png");
    assert!(!outcome.stderr.contains("nothing is in the picture"), "{}", outcome.stderr);
}
