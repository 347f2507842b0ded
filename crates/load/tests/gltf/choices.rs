//! What a file leaves to choose: clips, scenes, variants of materials; and what is told of it.

use std::path::Path;

use serde_json::json;
use sheer_load::{Clip, LoadError, LoadOptions, Loaded, read_gltf};
use sheer_scene::SceneParts;

use crate::builder::Builder;

fn load(builder: &Builder, options: &LoadOptions) -> Result<Loaded, LoadError> {
    read_gltf(&builder.glb(), Path::new("made/test.glb"), options)
}

/// The parts of the file under options of which one is set.
fn parts(builder: &Builder, set: impl Fn(&mut LoadOptions)) -> SceneParts {
    let mut options = LoadOptions::default();
    set(&mut options);
    load(builder, &options).unwrap().scene.parts().clone()
}

fn refused(builder: &Builder, set: impl Fn(&mut LoadOptions)) -> String {
    let mut options = LoadOptions::default();
    set(&mut options);
    let error = load(builder, &options).unwrap_err();
    assert!(matches!(error, LoadError::NoChoice { .. }), "{error}");
    error.to_string()
}

/// A file with three clips, of which the first two move the same.
fn clips() -> Builder {
    let mut builder = Builder::triangle();
    let times = builder.floats("SCALAR", &[0.0, 2.5]);
    let moves = builder.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    for (name, path) in [("Walk", "translation"), ("Run", "translation"), ("Grow", "scale")] {
        builder.push(
            "animations",
            json!({
                "name": name,
                "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
                "samplers": [{"input": times, "output": moves}],
            }),
        );
    }
    builder
}

#[test]
fn a_clip_is_chosen_by_name_or_number() {
    let file = clips();
    for (clip, plays) in [
        (None, &["Walk", "Grow"][..]),
        (Some("all"), &["Walk", "Grow"]),
        (Some("none"), &[]),
        (Some("Run"), &["Run"]),
        (Some("1"), &["Run"]),
        (Some("2"), &["Grow"]),
    ] {
        let played = parts(&file, |options| options.clip = clip.map(str::to_owned)).animations;
        let names: Vec<&str> = played.iter().map(|animation| animation.name.as_str()).collect();
        assert_eq!(names, plays, "{clip:?}");
    }
    let error = refused(&file, |options| options.clip = Some("Jump".to_owned()));
    assert_eq!(error, "made/test.glb: there is no clip 'Jump'; it has 0 'Walk', 1 'Run', 2 'Grow'");
    assert!(refused(&file, |options| options.clip = Some("3".to_owned())).contains("no clip '3'"));
    // Whoever chooses one does not ask for the others.
    let options = LoadOptions { clip: Some("Run".to_owned()), ..LoadOptions::default() };
    let loaded = load(&file, &options).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let told: Vec<(&str, bool, f32)> = (loaded.contents.clips.iter())
        .map(|Clip { name, plays, duration_secs }| (name.as_str(), *plays, *duration_secs))
        .collect();
    assert_eq!(told, [("Walk", false, 0.0), ("Run", true, 2.5), ("Grow", false, 0.0)]);
}

#[test]
fn a_scene_is_chosen_by_name_or_number() {
    let mut file = Builder::triangle();
    file.push("nodes", json!({"name": "other", "mesh": 0}));
    file.push("nodes", json!({"name": "third", "mesh": 0}));
    file.json["scenes"] = json!([{"nodes": [0], "name": "day"}, {"nodes": [1, 2], "name": "night"}]);
    file.json["scene"] = json!(1);
    let count = |scene: Option<&str>| {
        parts(&file, |options| options.scene = scene.map(str::to_owned)).instances.len()
    };
    assert_eq!([None, Some("day"), Some("0"), Some("night")].map(count), [2, 1, 1, 2]);
    let error = refused(&file, |options| options.scene = Some("dawn".to_owned()));
    assert!(error.ends_with("there is no scene 'dawn'; it has 0 'day', 1 'night'"), "{error}");
    let contents = load(&file, &LoadOptions::default()).unwrap().contents;
    assert_eq!(
        (contents.scenes, contents.shown_scene),
        (vec!["day".to_owned(), "night".to_owned()], Some(1))
    );
}

/// A triangle that is red, or green or blue as a variant.
fn variants() -> Builder {
    let mut file = Builder::triangle();
    for colour in [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]] {
        file.material(json!({"pbrMetallicRoughness": {"baseColorFactor": colour}}));
    }
    file.primitive()["material"] = json!(0);
    file.primitive()["extensions"] = json!({"KHR_materials_variants": {"mappings": [
        {"material": 1, "variants": [0, 2]},
        {"material": 2, "variants": [1]},
    ]}});
    file.json["extensions"] = json!({"KHR_materials_variants": {"variants": [
        {"name": "leaf"}, {"name": "sky"}, {"name": "lawn"}, {"name": "bare"},
    ]}});
    file.json["extensionsUsed"] = json!(["KHR_materials_variants"]);
    file
}

#[test]
fn a_variant_is_chosen_by_name_or_number() {
    let file = variants();
    for (variant, colour) in [
        (None, [1.0, 0.0, 0.0]),
        (Some("leaf"), [0.0, 1.0, 0.0]),
        (Some("2"), [0.0, 1.0, 0.0]),
        (Some("sky"), [0.0, 0.0, 1.0]),
        (Some("bare"), [1.0, 0.0, 0.0]),
    ] {
        let parts = parts(&file, |options| options.variant = variant.map(str::to_owned));
        let material = &parts.materials[parts.meshes[0].material as usize];
        assert_eq!(material.base_colour.truncate().to_array(), colour, "{variant:?}");
    }
    let error = refused(&file, |options| options.variant = Some("sea".to_owned()));
    assert!(error.ends_with("it has 0 'leaf', 1 'sky', 2 'lawn', 3 'bare'"), "{error}");
    assert!(load(&file, &LoadOptions::default()).unwrap().warnings.is_empty());
    // A mapping to a material that is not there names the primitive, and is an error where that is asked for.
    let mut broken = variants();
    broken.primitive()["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] = json!(9);
    let mut options = LoadOptions { variant: Some("leaf".to_owned()), ..LoadOptions::default() };
    let warnings = load(&broken, &options).unwrap().warnings;
    options.strict = true;
    let error = load(&broken, &options).unwrap_err().to_string();
    for said in [warnings[0].to_string(), error] {
        assert!(said.contains("meshes[0].primitives[0]") && said.contains("material 9"), "{said}");
    }
}

#[test]
fn extensions_are_told_with_what_becomes_of_them() {
    let mut file = Builder::triangle();
    file.json["extensionsUsed"] = json!(["KHR_materials_sheen", "KHR_materials_unlit"]);
    file.json["extensionsRequired"] = json!(["KHR_materials_unlit"]);
    let extensions = load(&file, &LoadOptions::default()).unwrap().contents.extensions;
    let told: Vec<(&str, bool, bool)> = (extensions.iter())
        .map(|extension| (extension.name.as_str(), extension.required, extension.has_effect))
        .collect();
    assert_eq!(told, [("KHR_materials_sheen", false, false), ("KHR_materials_unlit", true, true)]);
}

#[test]
fn points_and_lines_follow_their_vertices() {
    let mut file = Builder::triangle();
    let colours = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.25, 0.0, 1.0, 0.0, 0.5, 0.0, 0.0, 1.0, 1.0]);
    file.attribute("COLOR_0", colours);
    for (mode, triangles) in [(0, 3 * 8), (1, 6), (2, 3 * 6), (3, 2 * 6)] {
        file.primitive()["mode"] = json!(mode);
        let loaded = load(&file, &LoadOptions::default()).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let mesh = &loaded.scene.parts().meshes[0];
        assert_eq!(mesh.indices.len(), triangles, "mode {mode}");
        // Each vertex of a body has the colour of the one that it is near.
        for (at, colour) in mesh.positions.iter().zip(&mesh.colours) {
            let expected = if at.x > 0.5 {
                0.5
            } else if at.y > 0.5 {
                1.0
            } else {
                0.25
            };
            assert_eq!(colour.w, expected, "mode {mode}: {at}");
        }
    }
    file.primitive()["indices"] = json!(null);
    let indices = file.accessor("SCALAR", 5121, &[0, 9], 2);
    file.primitive()["indices"] = json!(indices);
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    let error = load(&file, &strict).unwrap_err().to_string();
    assert!(error.contains("index 9 refers to one of only 3 vertices"), "{error}");
}
