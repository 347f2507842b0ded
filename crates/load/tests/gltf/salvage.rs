//! Files of which a part is broken or missing: what is sound is loaded, what is lost is named.

use glam::{Affine3A, Vec3, Vec4};
use serde_json::{Value, json};
use sheer_load::{LoadError, LoadWarning};
use sheer_scene::model::SceneParts;

use crate::builder::Builder;

/// What is left of a file, of which all that is said must be lost contains the texts, one each.
fn salvaged(builder: &Builder, lost: &[&str]) -> SceneParts {
    let loaded = builder.load().unwrap();
    let losses: Vec<String> = loaded
        .warnings
        .iter()
        .filter(|warning| matches!(warning, LoadWarning::Lost { .. }))
        .map(ToString::to_string)
        .collect();
    assert_eq!(losses.len(), lost.len(), "{losses:?}");
    for (loss, part) in losses.iter().zip(lost) {
        assert!(loss.contains(part), "'{part}' is not in: {loss}");
    }
    let error = builder.load_strictly().unwrap_err().to_string();
    assert!(error.contains(lost[0]), "'{}' is not in: {error}", lost[0]);
    loaded.scene.parts().clone()
}

/// A square of two triangles, positions at 0 and 1.
fn square() -> Builder {
    let mut builder = Builder::triangle();
    let positions = builder.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    builder.attribute("POSITION", positions);
    let indices = builder.accessor("SCALAR", 5121, &[0, 1, 2, 0, 2, 3], 6);
    builder.primitive()["indices"] = json!(indices);
    builder
}

#[test]
fn a_file_without_faults_loads_strictly() {
    assert!(square().load_strictly().unwrap().warnings.is_empty());
}

#[test]
fn a_texture_falls_back_on_another_of_its_images() {
    let plain = |builder: &mut Builder| {
        let texture = builder.texture([1, 2, 3, 4]);
        builder.json["textures"][texture]["source"].clone()
    };
    for (extension, image, lost) in [
        ("EXT_texture_webp", json!({"uri": "gone.webp"}), "images[1] ('gone.webp')"),
        ("KHR_texture_basisu", json!({"uri": "data:image/ktx2;base64,q0tUWCAyMLsNChoK"}), "images[1]"),
        ("EXT_texture_webp", json!(null), "textures[1]: image 99"),
    ] {
        let mut builder = square();
        let source = plain(&mut builder);
        let better = if image.is_null() { 99 } else { builder.push("images", image) };
        let texture = builder
            .push("textures", json!({"source": source, "extensions": {extension: {"source": better}}}));
        builder.material(json!({"emissiveTexture": {"index": texture}}));
        let parts = salvaged(&builder, &[lost]);
        let used = parts.materials[0].emissive_texture.unwrap();
        assert_eq!(parts.textures[used.texture as usize].image.as_slice(), [[1, 2, 3, 4]], "{extension}");
        let said = builder.load().unwrap().warnings[0].to_string();
        assert!(said.ends_with("another image of its texture is drawn"), "{said}");
        // Without another one the texture is lost.
        builder.json["textures"][texture].as_object_mut().unwrap().remove("source");
        let parts = salvaged(&builder, &[lost.split(':').next().unwrap()]);
        assert!(parts.materials[0].emissive_texture.is_none(), "{extension}");
    }
}

#[test]
fn a_missing_image_costs_the_textures_that_show_it() {
    let mut builder = square();
    let found = builder.texture([1, 2, 3, 4]);
    let image = builder.push("images", json!({"uri": "gone%20away.png"}));
    let lost = builder.push("textures", json!({"source": image}));
    builder.material(json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.2, 0.4, 0.6, 0.5],
            "baseColorTexture": {"index": lost},
            "metallicRoughnessTexture": {"index": found},
            "metallicFactor": 0,
        },
        "normalTexture": {"index": lost},
        "alphaMode": "BLEND",
        // What would be worked into the base colour texture.
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": {"index": lost}}},
    }));
    let parts = salvaged(&builder, &["images[1] ('gone%20away.png'): cannot read"]);
    let material = &parts.materials[0];
    assert_eq!(material.base_colour.truncate(), Vec3::new(0.2, 0.4, 0.6));
    assert!(material.base_colour_texture.is_none() && material.normal_texture.is_none());
    assert!(material.metallic_roughness_texture.is_some());
    assert_eq!(parts.textures.len(), 1);
}

#[test]
fn a_broken_image_is_named_by_its_own_name() {
    let mut builder = square();
    let view = builder.view(b"no image");
    let image = builder.push("images", json!({"name": "wood", "bufferView": view}));
    let lost = builder.push("textures", json!({"source": image}));
    builder.material(json!({"emissiveTexture": {"index": lost}, "emissiveFactor": [1, 2, 3]}));
    let parts = salvaged(&builder, &["images[0] ('wood'): cannot decode"]);
    assert_eq!(parts.materials[0].emissive, Vec3::new(1.0, 2.0, 3.0));
}

#[test]
fn a_wild_index_costs_its_triangles() {
    let mut builder = square();
    let indices = builder.accessor("SCALAR", 5121, &[0, 1, 9, 0, 2, 3], 6);
    builder.primitive()["indices"] = json!(indices);
    let parts = salvaged(&builder, &["meshes[0].primitives[0].indices ('Body'): index 9"]);
    assert_eq!(parts.meshes[0].indices, [[0, 2, 3]]);
}

#[test]
fn a_vertex_that_is_nowhere_costs_its_triangles_and_changes_no_bounds() {
    let mut builder = square();
    let positions = [0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0].map(|at| at + 5.0);
    let positions = builder.floats("VEC3", &positions);
    builder.attribute("POSITION", positions);
    let parts = salvaged(&builder, &["attributes.POSITION ('Body'): element 1"]);
    assert_eq!(parts.meshes[0].indices, [[0, 2, 3]]);
    assert!(parts.meshes[0].positions.iter().all(|at| at.min_element() >= 5.0));
}

#[test]
fn a_broken_attribute_costs_no_triangle() {
    let mut builder = square();
    let normals = builder.floats("VEC3", &[0.0; 6]);
    builder.attribute("NORMAL", normals);
    let colours = builder.floats(
        "VEC4",
        &[f32::NAN, 0.0, 0.0, 1.0, 0.2, 0.2, 0.2, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
    );
    builder.attribute("COLOR_0", colours);
    let parts =
        salvaged(&builder, &["attributes.NORMAL ('Body'): there are 2 values for 4", "attributes.COLOR_0"]);
    assert!(parts.meshes[0].normals.is_empty());
    assert_eq!(parts.meshes[0].colours[..2], [Vec4::ONE, Vec4::new(0.2, 0.2, 0.2, 1.0)]);
}

#[test]
fn a_broken_primitive_or_buffer_costs_what_lies_in_it() {
    let mut builder = square();
    builder.json["buffers"] = json!([{}, {"uri": "gone.bin", "byteLength": 36}]);
    let view = builder.push("bufferViews", json!({"buffer": 1, "byteLength": 36}));
    let accessor = builder
        .push("accessors", json!({"bufferView": view, "componentType": 5126, "type": "VEC3", "count": 3}));
    let primitives = builder.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({"attributes": {"POSITION": accessor}}));
    let sound = primitives[0].clone();
    primitives.push(sound);
    let parts = salvaged(&builder, &["buffers[1]: cannot read"]);
    assert_eq!(parts.instances.iter().map(|instance| instance.geometry).collect::<Vec<_>>(), [0, 2]);
}

#[test]
fn broken_skins_weights_and_targets_leave_the_mesh() {
    let mut builder = square();
    let joints = builder.accessor("VEC4", 5121, &[0; 16], 4);
    let weights = builder.floats("VEC4", &[1.0; 16]);
    builder.attribute("JOINTS_0", joints);
    builder.attribute("WEIGHTS_0", weights);
    let moved =
        builder.floats("VEC3", &[1.0, 0.0, 0.0, f32::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    builder.primitive()["targets"] = json!([{"POSITION": moved}, {"POSITION": 99}]);
    builder.json["skins"] = json!([{"joints": [7]}]);
    builder.json["nodes"][0]["skin"] = json!(0);
    let parts = salvaged(
        &builder,
        &["skins[0]: node 7", "primitives[0].targets[0].POSITION", "primitives[0].targets[1].POSITION"],
    );
    assert!(parts.skins.is_empty() && parts.instances[0].skin.is_none());
    let targets = &parts.meshes[0].morph_targets;
    assert_eq!(targets[0].positions[..2], [Vec3::X, Vec3::ZERO]);
    assert!(targets[1].positions.is_empty());
}

#[test]
fn a_broken_node_costs_its_branch_and_a_second_parent_nothing() {
    let mut builder = square();
    builder.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2, 9]},
        {"mesh": 0, "translation": [1e39, 0, 0], "children": [3]},
        {"mesh": 0, "children": [3, 0]},
        {"mesh": 0},
    ]);
    let parts = salvaged(
        &builder,
        &[
            "nodes[0]: node 9",
            "nodes[3]: it is a child of both",
            "nodes[0]: it is its own ancestor",
            "nodes[1]: its transform",
        ],
    );
    assert_eq!(parts.instances.len(), 2);
    assert!(parts.nodes.iter().all(|node| node.transform.to_affine() == Affine3A::IDENTITY));
}

#[test]
fn broken_cameras_lights_and_channels_are_left_out() {
    let mut builder = square();
    builder.json["nodes"][0]["children"] = json!([1, 2]);
    for (camera, intensity) in [(0, -1.0), (1, 2.0)] {
        builder.push("cameras", json!({"perspective": {"yfov": camera}, "name": format!("eye {camera}")}));
        let lights = &mut builder.json["extensions"]["KHR_lights_punctual"]["lights"];
        if lights.is_null() {
            *lights = json!([]);
        }
        let light = json!({"type": "point", "intensity": intensity, "name": "lamp"});
        lights.as_array_mut().unwrap().push(light);
        let node = json!({"camera": camera, "extensions": {"KHR_lights_punctual": {"light": camera}}});
        builder.push("nodes", node);
    }
    let times = builder.floats("SCALAR", &[0.0, 1.0]);
    let values = builder.floats("VEC3", &[0.0; 6]);
    builder.json["animations"] = json!([{
        "channels": [
            {"sampler": 0, "target": {"node": 1, "path": "translation"}},
            {"sampler": 1, "target": {"node": 1, "path": "scale"}},
        ],
        "samplers": [{"input": times, "output": 77}, {"input": times, "output": values}],
    }]);
    let parts = salvaged(
        &builder,
        &[
            "cameras[0] ('eye 0'): yfov",
            "lights[0] ('lamp'): its colour",
            "animations[0].channels[0]: accessor 77",
        ],
    );
    assert_eq!((parts.cameras.len(), parts.lights.len()), (1, 1));
    assert_eq!(parts.animations[0].channels.len(), 1);
}

#[test]
fn a_budget_and_an_empty_rest_stay_errors() {
    let mut builder = square();
    let zeros: Value = json!({"componentType": 5126, "type": "VEC3", "count": 1_u64 << 40});
    let accessor = builder.push("accessors", zeros);
    let primitives = builder.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({"attributes": {"POSITION": accessor}}));
    assert!(matches!(builder.load(), Err(LoadError::Limit { .. })));

    let mut builder = square();
    builder.attribute("POSITION", 99);
    let error = builder.load().unwrap_err().to_string();
    assert!(error.contains("meshes[0].primitives[0].attributes.POSITION ('Body'): accessor 99"), "{error}");
}

#[test]
fn names_in_messages_are_short_and_plain() {
    let mut builder = square();
    builder.json["nodes"][0]["name"] = json!(format!("\u{1b}[31m{}", "x".repeat(1000)));
    builder.json["nodes"][0]["children"] = json!([9]);
    let warning = builder.load().unwrap().warnings[0].to_string();
    assert!(warning.contains("\\u{1b}[31mxxx") && warning.contains("x…'"), "{warning}");
    assert!(warning.len() < 250 && !warning.contains('\u{1b}'), "{warning}");
}

#[test]
fn a_thousand_faults_are_not_all_said() {
    let mut builder = square();
    builder.json["nodes"][0]["children"] = json!((9..1009).collect::<Vec<_>>());
    let warnings = builder.load().unwrap().warnings;
    assert_eq!(warnings.len(), 100);
    assert_eq!(warnings.last(), Some(&LoadWarning::More { count: 901 }));
}
