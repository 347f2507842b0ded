//! What files mean.

use std::{fs, sync::Arc};

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use serde_json::json;
use sheer_load::{LoadWarning, Loaded, open};
use sheer_scene::{
    Animator, Beam, CameraChoice, ClipPlanes, Environment, Lens, Scene,
    model::{
        AlphaMode, Factor, Filter, Interpolation, Keys, LevelFilter, LightKind, Material, Mesh, Minification,
        Property, SceneParts, ShadingModel, Track, Transform, Wrap,
    },
};

use crate::builder::Builder;

fn parts(builder: &Builder) -> SceneParts {
    builder.load().unwrap().scene.parts().clone()
}

fn mesh(builder: &Builder) -> Mesh {
    parts(builder).meshes.remove(0)
}

fn material(builder: &Builder) -> Material {
    parts(builder).materials.remove(0)
}

#[test]
fn a_triangle_comes_out_as_it_went_in() {
    let loaded = Builder::triangle().load().unwrap();
    assert!(loaded.warnings.is_empty());
    let parts = loaded.scene.parts();
    assert_eq!(parts.name, "test");
    assert_eq!(parts.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(parts.meshes[0].indices, [[0, 1, 2]]);
    assert!(parts.meshes[0].normals.is_empty());
    // The default material of the specification is a rough metal.
    assert_eq!((parts.materials[0].metallic, parts.materials[0].roughness), (1.0, 1.0));
    assert_eq!(parts.environment.zenith, Environment::default().zenith);
    assert_eq!(parts.exposure, 1.0);
}

#[test]
fn buffers_may_lie_beside_the_file_under_any_name() {
    let folder = tempfile::tempdir().unwrap();
    for (uri, name) in
        [("a b.bin", "a b.bin"), ("c%20d.bin", "c d.bin"), ("50%.bin", "50%.bin"), ("e%2Bf.bin", "e%2Bf.bin")]
    {
        let builder = Builder::triangle();
        let (json, binary) = builder.separate(uri);
        fs::write(folder.path().join(name), binary).unwrap();
        let file = folder.path().join("Box With Spaces.gltf");
        fs::write(&file, json).unwrap();
        let loaded = open(file.to_str().unwrap()).unwrap();
        assert_eq!(loaded.scene.parts().meshes[0].indices.len(), 1, "{uri}");
    }
}

#[test]
fn only_the_scene_shown_is_drawn() {
    let mut builder = Builder::triangle();
    builder.json["nodes"] =
        json!([{"mesh": 0, "children": [1]}, {"mesh": 0}, {"mesh": 0}, {"children": [4]}, {"mesh": 0}]);
    let drawn = |builder: &Builder| parts(builder).instances.len();
    builder.json["scenes"] = json!([{"nodes": [0]}, {"nodes": [2, 3]}]);
    assert_eq!(drawn(&builder), 2);
    builder.json["scene"] = json!(1);
    assert_eq!(drawn(&builder), 2);
    builder.json["nodes"][3]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    assert_eq!(drawn(&builder), 1);
    builder.json.as_object_mut().unwrap().remove("scene");
    builder.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(drawn(&builder), 3);
}

#[test]
fn parents_stand_before_their_children_whatever_the_order_in_the_file() {
    let mut builder = Builder::triangle();
    builder.json["nodes"] = json!([{"name": "leaf", "mesh": 0}, {"name": "middle", "children": [0]}, {"name": "root", "children": [1]}]);
    builder.json["scenes"][0]["nodes"] = json!([2]);
    let parts = parts(&builder);
    let names: Vec<_> = parts.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["root", "middle", "leaf"]);
    assert_eq!(parts.nodes.iter().map(|node| node.parent).collect::<Vec<_>>(), [None, Some(0), Some(1)]);
    assert_eq!(parts.instances[0].node, 2);
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_needs_no_recursion() {
    let mut builder = Builder::triangle();
    let mut nodes: Vec<_> = (1..100_000).map(|child| json!({"children": [child]})).collect();
    nodes.push(json!({"mesh": 0}));
    builder.json["nodes"] = json!(nodes);
    assert_eq!(parts(&builder).instances[0].node, 99_999);
}

#[test]
fn mirrored_nodes_keep_their_winding() {
    let mut builder = Builder::triangle();
    builder.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    let parts = parts(&builder);
    assert_eq!(parts.meshes[0].indices, [[0, 1, 2]]);
    assert!(parts.nodes[0].transform.to_affine().matrix3.determinant() < 0.0);
}

#[test]
fn all_component_types_become_numbers() {
    let cases: [(u32, &[u8], bool, [f32; 2]); 7] = [
        (5120, &[127, 0x81], true, [1.0, -1.0]),
        (5120, &[0x80, 3], true, [-1.0, 3.0 / 127.0]),
        (5120, &[0x80, 3], false, [-128.0, 3.0]),
        (5121, &[255, 51], true, [1.0, 0.2]),
        (5122, &[0xFF, 0x7F, 0x01, 0x80], true, [1.0, -1.0]),
        (5123, &[0xFF, 0xFF, 0, 0], true, [1.0, 0.0]),
        (5123, &[0xFF, 0xFF, 2, 0], false, [65535.0, 2.0]),
    ];
    for (component, bytes, normalised, expected) in cases {
        let mut builder = Builder::triangle();
        let uvs = builder.accessor("VEC2", component, &bytes.repeat(3), 3);
        builder.json["accessors"][uvs]["normalized"] = json!(normalised);
        builder.attribute("TEXCOORD_0", uvs);
        assert_eq!(mesh(&builder).uv_sets[0], [Vec2::from(expected); 3], "{component} {normalised}");
    }
}

#[test]
fn strides_and_offsets_are_followed() {
    let mut builder = Builder::triangle();
    let uvs = builder.accessor("VEC2", 5121, &[9, 9, 1, 2, 9, 9, 3, 4, 9, 9, 5, 6], 3);
    let view = builder.json["accessors"][uvs]["bufferView"].as_u64().unwrap() as usize;
    builder.json["bufferViews"][view]["byteStride"] = json!(4);
    builder.json["accessors"][uvs]["byteOffset"] = json!(2);
    builder.attribute("TEXCOORD_0", uvs);
    assert_eq!(mesh(&builder).uv_sets[0], [Vec2::new(1.0, 2.0), Vec2::new(3.0, 4.0), Vec2::new(5.0, 6.0)]);
}

#[test]
fn sparse_accessors_replace_elements_with_a_view_or_without() {
    for with_view in [true, false] {
        let mut builder = Builder::triangle();
        let indices = builder.view(&[2, 0]);
        let values = builder.view(&[0, 0, 0, 64, 0, 0, 64, 64, 0, 0, 128, 64]);
        let sparse = json!({
            "count": 1,
            "indices": {"bufferView": indices, "byteOffset": 0, "componentType": 5121},
            "values": {"bufferView": values},
        });
        let positions = &mut builder.json["accessors"][0];
        positions["sparse"] = sparse;
        if !with_view {
            positions.as_object_mut().unwrap().remove("bufferView");
        }
        let last = Vec3::new(2.0, 3.0, 4.0);
        let expected = if with_view { [Vec3::ZERO, Vec3::X, last] } else { [Vec3::ZERO, Vec3::ZERO, last] };
        assert_eq!(mesh(&builder).positions, expected);
    }
}

#[test]
fn joint_sets_are_joined_and_weights_sum_to_one() {
    let mut builder = Builder::triangle();
    let joints = builder.accessor("VEC4", 5121, &[0, 1, 200, 0].repeat(3), 3);
    let first = builder.floats("VEC4", &[1.0, 0.5, 0.0, 0.0].repeat(3));
    let second = builder.floats("VEC4", &[0.5, 0.0, 0.0, 0.0].repeat(3));
    for (name, accessor) in
        [("JOINTS_0", joints), ("WEIGHTS_0", first), ("JOINTS_1", joints), ("WEIGHTS_1", second)]
    {
        builder.attribute(name, accessor);
    }
    builder.json["skins"] = json!([{"joints": [0, 1]}]);
    builder.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {}]);
    let parts = parts(&builder);
    assert_eq!(parts.instances[0].skin, Some(0));
    assert_eq!(parts.skins[0].inverse_bind, [Affine3A::IDENTITY; 2]);
    let influences = &parts.meshes[0].influences[..8];
    assert_eq!(parts.meshes[0].influences_per_vertex, 8);
    assert_eq!(
        influences.iter().map(|influence| influence.weight).collect::<Vec<_>>(),
        [0.5, 0.25, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0]
    );
    // Joint 200 pulls nothing and so need not exist.
    assert_eq!(influences[2].joint, 0);
}

#[test]
fn a_node_overrides_the_morph_weights_of_its_mesh() {
    let mut builder = Builder::triangle();
    let deltas = builder.accessor("VEC3", 5120, &[1, 2, 3, 0].repeat(3), 3);
    let view = builder.json["accessors"][deltas]["bufferView"].as_u64().unwrap() as usize;
    builder.json["bufferViews"][view]["byteStride"] = json!(4);
    builder.primitive()["targets"] = json!([{"POSITION": deltas}, {}]);
    builder.json["meshes"][0]["weights"] = json!([0.5]);
    let at_mesh = parts(&builder);
    assert_eq!(at_mesh.instances[0].morph_weights, [0.5, 0.0]);
    assert_eq!(at_mesh.meshes[0].morph_targets[0].positions, [Vec3::new(1.0, 2.0, 3.0); 3]);
    assert!(at_mesh.meshes[0].morph_targets[1].positions.is_empty());
    builder.json["nodes"][0]["weights"] = json!([0.25, 1]);
    assert_eq!(parts(&builder).instances[0].morph_weights, [0.25, 1.0]);
}

/// A channel that moves a property of node 0 between two keys.
fn animate(builder: &mut Builder, name: &str, path: &str, interpolation: &str, output: usize) {
    let times = builder.floats("SCALAR", &[0.0, 1.0]);
    builder.push(
        "animations",
        json!({
            "name": name,
            "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
            "samplers": [{"input": times, "output": output, "interpolation": interpolation}],
        }),
    );
}

#[test]
fn the_first_animation_plays_with_those_that_move_something_else() {
    let mut builder = Builder::triangle();
    let moves = builder.floats("VEC3", &[0.0; 6]);
    animate(&mut builder, "first", "translation", "STEP", moves);
    animate(&mut builder, "again", "translation", "LINEAR", moves);
    animate(&mut builder, "other", "scale", "LINEAR", moves);
    let Loaded { scene, warnings, .. } = builder.load().unwrap();
    let names: Vec<_> = scene.parts().animations.iter().map(|animation| animation.name.as_str()).collect();
    assert_eq!(names, ["first", "other"]);
    assert_eq!(warnings, [LoadWarning::AnimationSkipped { place: "animations[1] ('again')".to_owned() }]);
}

#[test]
fn cubic_rotations_keep_their_tangents_and_get_unit_keys() {
    let mut builder = Builder::triangle();
    let keys = [[9.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0], [0.0, 7.0, 0.0, 0.0]].concat().repeat(2);
    let output = builder.floats("VEC4", &keys);
    animate(&mut builder, "", "rotation", "CUBICSPLINE", output);
    let parts = parts(&builder);
    let Track::Rotation(keys) = &parts.animations[0].channels[0].track else { panic!("not a rotation") };
    assert_eq!(keys.interpolation, Interpolation::CubicSpline);
    assert_eq!(keys.values.len(), 6);
    assert_eq!((keys.values[0].x, keys.values[1], keys.values[2].y), (9.0, Quat::IDENTITY, 7.0));
}

#[test]
fn morph_weights_are_animated_together() {
    let mut builder = Builder::triangle();
    builder.primitive()["targets"] = json!([{}, {}, {}]);
    let output = builder.accessor("SCALAR", 5121, &[0, 51, 255, 0, 0, 0], 6);
    builder.json["accessors"][output]["normalized"] = json!(true);
    animate(&mut builder, "", "weights", "LINEAR", output);
    let parts = parts(&builder);
    let Track::MorphWeights(keys) = &parts.animations[0].channels[0].track else { panic!("not weights") };
    assert_eq!(keys.values, [[0.0, 0.2, 1.0], [0.0; 3]]);
}

#[test]
fn keys_at_one_time_stay_a_jump_and_a_matrix_is_taken_apart() {
    let mut builder = Builder::triangle();
    builder.json["nodes"][0]["matrix"] = json!([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1]);
    let output = builder.floats("VEC3", &[0.0; 9]);
    animate(&mut builder, "", "translation", "LINEAR", output);
    let times = builder.floats("SCALAR", &[1.0; 3]);
    builder.json["animations"][0]["samplers"][0]["input"] = json!(times);
    let Loaded { scene, warnings, .. } = builder.load().unwrap();
    let Track::Translation(keys) = &scene.parts().animations[0].channels[0].track else {
        panic!("not a translation")
    };
    let second = 1.0_f32.next_up();
    assert_eq!(keys.times_secs, [1.0, second, second.next_up()]);
    assert!(
        matches!(scene.parts().nodes[0].transform, Transform::Trs { scale, .. } if scale.abs_diff_eq(Vec3::splat(2.0), 1e-6))
    );
    assert_eq!(warnings.len(), 2);
}

/// Adds a channel that moves what a JSON pointer names between two keys to the last animation.
fn animate_pointer(builder: &mut Builder, pointer: &str, kind: &str, values: &[f32]) {
    let times = builder.floats("SCALAR", &[0.0, 1.0]);
    let output = builder.floats(kind, values);
    if builder.json["animations"].is_null() {
        builder.push("animations", json!({"channels": [], "samplers": []}));
    }
    let animation = &mut builder.json["animations"][0];
    let samplers = animation["samplers"].as_array_mut().unwrap();
    samplers.push(json!({"input": times, "output": output}));
    let sampler = samplers.len() - 1;
    let target = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}});
    let channels = animation["channels"].as_array_mut().unwrap();
    channels.push(json!({"sampler": sampler, "target": target}));
}

#[test]
fn animation_pointers_change_materials_lights_and_nodes() {
    let mut builder = Builder::triangle();
    builder.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    let texture = builder.texture([1, 2, 3, 4]);
    builder.material(json!({
        "emissiveFactor": [1, 0.5, 0],
        "alphaMode": "MASK",
        "pbrMetallicRoughness": {"baseColorTexture": {
            "index": texture, "extensions": {"KHR_texture_transform": {"offset": [0.25, 0.5], "scale": [2, 3]}}}},
    }));
    builder.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "point", "color": [1, 0, 0], "intensity": 3}]}});
    let hung = json!({"light": 0});
    builder.json["nodes"][0]["extensions"] =
        json!({"KHR_lights_punctual": hung, "KHR_node_visibility": {"visible": false}});
    builder.json["nodes"][0]["children"] = json!([1]);
    builder.push("nodes", json!({"extensions": {"KHR_lights_punctual": hung}}));
    let material = "/materials/0";
    animate_pointer(&mut builder, "/nodes/0/translation", "VEC3", &[0.0; 6]);
    animate_pointer(&mut builder, "/nodes/0/extensions/KHR_node_visibility/visible", "SCALAR", &[0.0, 1.0]);
    animate_pointer(
        &mut builder,
        &format!("{material}/pbrMetallicRoughness/baseColorFactor"),
        "VEC4",
        &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0],
    );
    animate_pointer(&mut builder, &format!("{material}/alphaCutoff"), "SCALAR", &[0.1, 0.9]);
    let strength = format!("{material}/extensions/KHR_materials_emissive_strength/emissiveStrength");
    animate_pointer(&mut builder, &strength, "SCALAR", &[1.0, 5.0]);
    let laid = "pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform";
    animate_pointer(&mut builder, &format!("{material}/{laid}/rotation"), "SCALAR", &[0.0, 1.0]);
    let light = "/extensions/KHR_lights_punctual/lights/0";
    animate_pointer(&mut builder, &format!("{light}/intensity"), "SCALAR", &[0.0, 6.0]);
    animate_pointer(&mut builder, "/cameras/0/perspective/aspectRatio", "SCALAR", &[0.1, 0.2]);

    let Loaded { scene, warnings, .. } = builder.load().unwrap();
    let pointer = "/cameras/0/perspective/aspectRatio".to_owned();
    assert_eq!(
        warnings,
        [LoadWarning::NotAnimated { place: "animations[0].channels[7]".to_owned(), pointer }]
    );
    let parts = scene.parts();
    assert_eq!(parts.instances.len(), 1, "what an animation shows is part of the scene");
    let animation = &parts.animations[0];
    assert_eq!((animation.channels.len(), animation.properties.len()), (1, 6));
    assert_eq!(animation.duration_secs(), 1.0);
    let at_end = |keys: &Keys<f32>| keys.value_at(1.0);
    assert!(
        matches!(&animation.properties[0], Property::Visibility { node: 0, visible } if at_end(visible) == 1.0)
    );
    assert!(matches!(&animation.properties[1],
        Property::BaseColour { material: 0, factor } if factor.value_at(0.5).w == 0.5));
    assert!(matches!(&animation.properties[2],
        Property::Factor { which: Factor::AlphaCutoff, value, .. } if at_end(value) == 0.9));
    // What is not animated stays as the file has it.
    assert!(matches!(&animation.properties[3], Property::Emissive { factor, strength, .. }
        if factor.value_at(1.0) == Vec3::new(1.0, 0.5, 0.0) && at_end(strength) == 5.0));
    assert!(
        matches!(&animation.properties[4], Property::TextureTransform { offset, rotation_rad, scale, .. }
        if offset.value_at(1.0) == Vec2::new(0.25, 0.5)
            && scale.value_at(1.0) == Vec2::new(2.0, 3.0)
            && at_end(rotation_rad) == 1.0)
    );
    // The light hangs on two nodes.
    assert!(matches!(&animation.properties[5], Property::LightIntensity { lights, colour, intensity }
        if *lights == [0, 1] && colour.value_at(0.0) == Vec3::X && at_end(intensity) == 6.0));
}

#[test]
fn the_shape_of_a_light_is_animated() {
    let mut builder = Builder::triangle();
    builder.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "range": 2, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}}]}});
    builder.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    let light = "/extensions/KHR_lights_punctual/lights/0";
    animate_pointer(&mut builder, &format!("{light}/range"), "SCALAR", &[2.0, 4.0]);
    animate_pointer(&mut builder, &format!("{light}/spot/innerConeAngle"), "SCALAR", &[0.2, 1.2]);
    animate_pointer(&mut builder, &format!("{light}/spot/outerConeAngle"), "SCALAR", &[0.4, 0.8]);
    let loaded = builder.load().unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = Arc::new(loaded.scene);
    let mut animator = Animator::new(Arc::clone(&scene), scene.camera(&CameraChoice::Default).unwrap());
    for (time_secs, inner, outer, far) in
        [(0.0, 0.2, 0.4, 2.0), (0.25, 0.45, 0.5, 2.5), (0.75, 0.7, 0.7, 3.5)]
    {
        let frame = animator.advance(time_secs, 0.0);
        let LightKind::Spot { range, inner_cone_rad, outer_cone_rad } = frame.lights()[0].kind else {
            panic!("it is a spot")
        };
        // The inner cone stays within the outer one.
        let found = Vec3::new(range, inner_cone_rad, outer_cone_rad);
        assert!((found - Vec3::new(far, inner, outer)).length() < 1e-5, "{time_secs}: {found}");
        assert_eq!(frame.is_still(), time_secs == 0.0);
    }
}

#[test]
fn transmission_fades_where_it_is_the_same_all_over() {
    let pointer = "/materials/0/extensions/KHR_materials_transmission/transmissionFactor";
    let glass = |factor: f32, values: &[f32]| {
        let mut builder = Builder::triangle();
        let transmission = json!({"transmissionFactor": factor});
        builder.material(json!({
            "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0},
            "extensions": {"KHR_materials_transmission": transmission},
        }));
        animate_pointer(&mut builder, pointer, "SCALAR", values);
        builder
    };
    // From clear to opaque, from opaque to clear: what is transmitted is missing of the alpha.
    for (factor, values) in [(1.0, [1.0, 0.0]), (0.0, [0.0, 1.0])] {
        let scene = Arc::new(glass(factor, &values).load().unwrap().scene);
        let mut animator = Animator::new(Arc::clone(&scene), scene.camera(&CameraChoice::Default).unwrap());
        for (time_secs, of_one) in [(0.0, values[0]), (0.5, 0.5), (0.999_99, values[1])] {
            let frame = animator.advance(time_secs, 0.0);
            let material = &frame.materials()[0];
            assert!((material.transmission - 0.85 * of_one).abs() < 1e-4, "{factor} {time_secs}");
            assert!(
                (frame.opacity(0, 0.2, 0.2, 0.0) - (1.0 - 0.85 * of_one)).abs() < 1e-4,
                "{factor} {time_secs}"
            );
            if of_one >= 0.5 || time_secs == 0.0 {
                assert_eq!(frame.tints_light(), of_one > 0.0, "{factor} {time_secs}");
            }
        }
    }
    // Where an image says how much, it stays as it is, which is said.
    let mut textured = glass(1.0, &[1.0, 0.0]);
    let texture = textured.texture([128, 0, 0, 255]);
    textured.json["materials"][0]["extensions"]["KHR_materials_transmission"]["transmissionTexture"] =
        json!({"index": texture});
    let warnings = textured.load().unwrap().warnings;
    assert!(
        warnings
            .iter()
            .any(|said| matches!(said, LoadWarning::NotAnimated { pointer: what, .. } if what == pointer)),
        "{warnings:?}"
    );
}

#[test]
fn an_alpha_fades_together_with_transmission() {
    let mut builder = Builder::triangle();
    builder.material(json!({
        "alphaMode": "BLEND",
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}},
    }));
    let colours = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0];
    animate_pointer(&mut builder, "/materials/0/pbrMetallicRoughness/baseColorFactor", "VEC4", &colours);
    let scene = Arc::new(builder.load().unwrap().scene);
    let mut animator = Animator::new(Arc::clone(&scene), scene.camera(&CameraChoice::Default).unwrap());
    for time_secs in [0.0, 0.5] {
        let opacity = animator.advance(time_secs, 0.0).opacity(0, 0.2, 0.2, 0.0);
        assert!((opacity - 0.15 * (1.0 - time_secs)).abs() < 1e-5, "{time_secs}: {opacity}");
    }
}

#[test]
fn tangents_morph_as_the_file_says() {
    let mut builder = Builder::triangle();
    let normals = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tangents = builder.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(3));
    builder.attribute("NORMAL", normals);
    builder.attribute("TANGENT", tangents);
    let moves = builder.floats("VEC3", &[-1.0, 1.0, 0.0].repeat(3));
    builder.primitive()["targets"] = json!([{"TANGENT": moves}]);
    builder.json["meshes"][0]["weights"] = json!([1.0]);
    let texture = builder.texture([255, 128, 128, 255]);
    builder.material(json!({"normalTexture": {"index": texture}}));
    let loaded = builder.load_strictly().unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(loaded.scene.parts().meshes[0].morph_targets[0].tangents, [Vec3::new(-1.0, 1.0, 0.0); 3]);
    // The map bends the normal all the way to the tangent, which the morph has turned by a right angle.
    let normal = |weight: f32| {
        let mut parts = loaded.scene.parts().clone();
        parts.instances[0].morph_weights = vec![weight];
        let scene = Arc::new(Scene::new(parts).unwrap());
        let camera = scene.camera(&CameraChoice::Default).unwrap();
        let beam = Beam { direction: Vec3::NEG_Z, width: 0.0 };
        let animator = Animator::new(scene, camera);
        animator.frame().surface(0, 0.25, 0.25, true, beam).normal
    };
    let (rest, turned) = (normal(0.0), normal(1.0));
    assert!(rest.x > 0.99 && turned.y > 0.99, "{rest} and {turned}");
}

#[test]
fn the_lens_of_a_camera_is_animated_wherever_it_hangs() {
    let mut builder = Builder::triangle();
    builder.json["cameras"] = json!([{"perspective": {"yfov": 0.5, "znear": 0.25, "zfar": 8}}]);
    builder.json["nodes"][0]["children"] = json!([1, 2]);
    for _ in 0..2 {
        builder.push("nodes", json!({"camera": 0}));
    }
    animate_pointer(&mut builder, "/cameras/0/perspective/yfov", "SCALAR", &[0.5, 1.5]);
    animate_pointer(&mut builder, "/cameras/0/perspective/zfar", "SCALAR", &[8.0, 0.0]);
    let scene = Arc::new(builder.load().unwrap().scene);
    for name in ["camera0", "camera0 2"] {
        let camera = scene.camera(&CameraChoice::Named(name.to_owned())).unwrap();
        let mut animator = Animator::new(Arc::clone(&scene), camera);
        let frame = animator.advance(0.5, 0.25);
        assert_eq!(frame.camera().lens, Lens::Perspective { yfov_rad: 1.0 });
        assert_eq!(frame.camera().clip, ClipPlanes { near: 0.25, far: 4.0 });
        assert_eq!(frame.previous_camera().lens, Lens::Perspective { yfov_rad: 0.75 });
        // A far plane may not meet the near one.
        assert!(animator.advance(0.99, 0.99).camera().clip.far > 0.25);
    }
    // What stands still does so altogether.
    let camera = scene.camera(&CameraChoice::Named("static".to_owned())).unwrap();
    let still = Animator::new(scene, camera).advance(0.5, 0.5).camera().lens;
    assert_eq!(still, Lens::Perspective { yfov_rad: 0.5 });
}

#[test]
fn a_hidden_node_stays_hidden_if_the_animation_that_shows_it_is_lost() {
    let mut builder = Builder::triangle();
    builder.json["nodes"][0]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    animate_pointer(&mut builder, "/nodes/0/extensions/KHR_node_visibility/visible", "SCALAR", &[1.0, 1.0]);
    builder.json["animations"][0]["samplers"][0]["output"] = json!(99);
    let parts = parts(&builder);
    let [animation] = &parts.animations[..] else { panic!("{:?}", parts.animations) };
    assert!(matches!(&animation.properties[..],
        [Property::Visibility { node: 0, visible }] if visible.value_at(0.5) == 0.0));
}

#[test]
fn clip_planes_come_from_the_camera_and_may_be_left_out() {
    let mut builder = Builder::triangle();
    builder.json["cameras"] = json!([
        {"perspective": {"yfov": 0.5, "znear": 0.25, "zfar": 8}},
        {"perspective": {"yfov": 0.5, "znear": 0.5}},
        {"orthographic": {"xmag": 1, "ymag": 2, "znear": 0, "zfar": 3}},
        {"orthographic": {"xmag": 1, "ymag": 2, "znear": 3, "zfar": 3}},
    ]);
    builder.json["nodes"][0]["children"] = json!([1, 2, 3, 4]);
    for camera in 0..4 {
        builder.push("nodes", json!({"camera": camera}));
    }
    let loaded = builder.load().unwrap();
    let clips: Vec<_> =
        loaded.scene.parts().cameras.iter().map(|camera| [camera.clip.near, camera.clip.far]).collect();
    assert_eq!(clips, [[0.25, 8.0], [0.5, f32::INFINITY], [0.0, 3.0], [0.0, f32::INFINITY]]);
    let said = loaded.warnings[0].to_string();
    assert!(said.contains("cameras[3]: znear is 3 and zfar 3"), "{said}");
}

#[test]
fn cameras_get_names_of_their_own() {
    let mut builder = Builder::triangle();
    builder.json["cameras"] = json!([
        {"type": "perspective", "name": "view", "perspective": {"yfov": 0.5, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 2, "zfar": 9, "znear": 0}},
    ]);
    builder.json["nodes"] =
        json!([{"camera": 1}, {"camera": 0}, {"camera": 0}, {"camera": 1, "name": "view"}]);
    builder.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let cameras = parts(&builder).cameras;
    let names: Vec<_> = cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["view", "view 2", "camera1", "view 3"]);
    assert_eq!(cameras[0].lens, Lens::Perspective { yfov_rad: 0.5 });
    assert_eq!(cameras[2].lens, Lens::Orthographic { half_height: 2.0 });
}

#[test]
fn lights_of_a_file_dim_the_surroundings() {
    let mut builder = Builder::triangle();
    builder.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "directional", "color": [1, 0.5, 0], "intensity": 2},
        {"type": "point", "range": 3},
        {"type": "spot", "spot": {"innerConeAngle": 0.25}},
    ]}});
    let hung = |light: u32| json!({"extensions": {"KHR_lights_punctual": {"light": light}}});
    builder.json["nodes"] = json!([hung(0), hung(1), hung(2)]);
    builder.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let parts = parts(&builder);
    assert_eq!(parts.lights[0].intensity, Vec3::new(2.0, 1.0, 0.0));
    let kinds: Vec<_> = parts.lights.iter().map(|light| light.kind).collect();
    let spot = LightKind::Spot {
        range: f32::INFINITY,
        inner_cone_rad: 0.25,
        outer_cone_rad: std::f32::consts::FRAC_PI_4,
    };
    assert_eq!(kinds, [LightKind::Directional, LightKind::Point { range: 3.0 }, spot]);
    // They shine in addition to the surroundings, not in their place.
    assert_eq!(format!("{:?}", parts.environment), format!("{:?}", Environment::default()));
}

#[test]
fn materials_say_how_alpha_and_light_are_meant() {
    let mut builder = Builder::triangle();
    builder.material(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6},
        "alphaMode": "MASK", "doubleSided": true, "emissiveFactor": [1, 0.5, 0],
        "extensions": {"KHR_materials_unlit": {}, "KHR_materials_emissive_strength": {"emissiveStrength": 4}},
    }));
    let masked = material(&builder);
    assert_eq!(masked.alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!(masked.base_colour, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!((masked.metallic, masked.roughness, masked.double_sided), (0.5, 0.6, true));
    assert_eq!((masked.model, masked.emissive), (ShadingModel::Unlit, Vec3::new(4.0, 2.0, 0.0)));
    builder.json["materials"][0]["alphaMode"] = json!("BLEND");
    assert_eq!(material(&builder).alpha_mode, AlphaMode::Blend);
}

#[test]
fn texture_transforms_turn_as_the_extension_says() {
    let mut builder = Builder::triangle();
    let texture = builder.texture([1, 2, 3, 4]);
    let quarter = std::f32::consts::FRAC_PI_2;
    builder.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture, "texCoord": 0, "extensions": {
        "KHR_texture_transform": {"offset": [10, 20], "rotation": quarter, "scale": [2, 3], "texCoord": 1},
    }}}}));
    let used = material(&builder).base_colour_texture.unwrap();
    assert_eq!(used.uv_set, 1);
    // Scaled, then turned counter-clockwise as seen with v pointing down, then moved.
    let moved = used.transform.transform_point2(Vec2::ONE);
    assert!(moved.abs_diff_eq(Vec2::new(10.0 + 3.0, 20.0 - 2.0), 1e-5), "{moved}");
}

#[test]
fn one_image_serves_as_colour_and_as_data() {
    let mut builder = Builder::triangle();
    let texture = builder.texture([1, 2, 3, 4]);
    builder.json["samplers"] = json!([{"magFilter": 9728, "wrapS": 33071, "wrapT": 33648}]);
    builder.json["textures"][texture]["sampler"] = json!(0);
    builder.material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": texture}, "metallicRoughnessTexture": {"index": texture}},
        "normalTexture": {"index": texture, "scale": 0.5}, "occlusionTexture": {"index": texture, "strength": 0.25},
    }));
    let parts = parts(&builder);
    assert_eq!(
        parts.textures.iter().map(|texture| texture.srgb).collect::<std::collections::BTreeSet<_>>().len(),
        2
    );
    assert_eq!(parts.textures.len(), 2);
    assert!(Arc::ptr_eq(&parts.textures[0].image, &parts.textures[1].image));
    assert_eq!(parts.textures[0].image.as_slice(), [[1, 2, 3, 4]]);
    assert_eq!(parts.textures[0].wrap, [Wrap::ClampToEdge, Wrap::MirroredRepeat]);
    assert_eq!(parts.textures[0].filter, Filter::Nearest);
    assert_eq!((parts.materials[0].normal_scale, parts.materials[0].occlusion_strength), (0.5, 0.25));
}

#[test]
fn samplers_say_how_textures_are_minified() {
    let minification = |min_filter: Option<u32>| {
        let mut builder = Builder::triangle();
        let texture = builder.texture([1, 2, 3, 4]);
        builder.json["samplers"] = json!([{"minFilter": min_filter}]);
        builder.json["textures"][texture]["sampler"] = json!(0);
        builder.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));
        let Minification { filter, levels } = parts(&builder).textures[0].minification;
        (filter, levels)
    };
    assert_eq!(minification(None), (Filter::Linear, LevelFilter::Linear));
    assert_eq!(minification(Some(9728)), (Filter::Nearest, LevelFilter::None));
    assert_eq!(minification(Some(9729)), (Filter::Linear, LevelFilter::None));
    assert_eq!(minification(Some(9984)), (Filter::Nearest, LevelFilter::Nearest));
    assert_eq!(minification(Some(9985)), (Filter::Linear, LevelFilter::Nearest));
    assert_eq!(minification(Some(9986)), (Filter::Nearest, LevelFilter::Linear));
    assert_eq!(minification(Some(9987)), (Filter::Linear, LevelFilter::Linear));
}

#[test]
fn webp_images_come_before_their_fallback() {
    let mut builder = Builder::triangle();
    let texture = builder.texture([255; 4]);
    let webp = "data:image/webp;base64,UklGRiIAAABXRUJQVlA4IBYAAAAwAQCdASoBAAEADsD+JaQAA3AAAAAA";
    let image = builder.push("images", json!({"uri": webp}));
    builder.json["textures"][texture]["extensions"] = json!({"EXT_texture_webp": {"source": image}});
    builder.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    builder.material(json!({"emissiveTexture": {"index": texture}}));
    let parts = parts(&builder);
    assert_eq!(parts.textures[0].image.size(), (1, 1));
    assert_ne!(parts.textures[0].image.as_slice(), [[255; 4]]);
}

#[test]
fn transmission_lowers_alpha() {
    let transmits = |factor: f32| json!({"KHR_materials_transmission": {"transmissionFactor": factor}});
    let glass = |base: serde_json::Value, mode: &str| {
        let mut builder = Builder::triangle();
        builder.material(json!({"name": "glass", "alphaMode": mode, "pbrMetallicRoughness": base, "extensions": transmits(1.0)}));
        let loaded = builder.load().unwrap();
        assert_eq!(
            loaded.warnings,
            [LoadWarning::UnrefractedTransmission { material: "materials[0] ('glass')".to_owned() }]
        );
        loaded.scene.parts().materials[0].clone()
    };
    let clear = glass(json!({"metallicFactor": 0}), "OPAQUE");
    assert_eq!(clear.alpha_mode, AlphaMode::Blend);
    assert!((clear.base_colour.w - 0.15).abs() < 1e-6);
    // What is taken out of the opacity colours the light that passes.
    assert!((clear.transmission - 0.85).abs() < 1e-6);
    let blended = glass(json!({"metallicFactor": 0, "baseColorFactor": [1, 1, 1, 0.5]}), "BLEND");
    assert!((blended.base_colour.w - 0.075).abs() < 1e-6);
    // A metal transmits nothing.
    let metal = glass(json!({"metallicFactor": 1}), "OPAQUE");
    assert_eq!((metal.base_colour.w, metal.transmission), (1.0, 0.0));
}

#[test]
fn a_volume_absorbs_by_its_colour_and_distance() {
    let glass = |transmission: f32, volume: serde_json::Value| {
        let mut builder = Builder::triangle();
        builder.material(json!({"name": "glass", "pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": transmission}, "KHR_materials_volume": volume,
        }}));
        builder.json["extensionsUsed"] = json!(["KHR_materials_transmission", "KHR_materials_volume"]);
        let loaded = builder.load().unwrap();
        (loaded.scene.parts().materials[0].clone(), loaded.warnings)
    };
    let amber = json!({"thicknessFactor": 0.5, "attenuationDistance": 2, "attenuationColor": [1, 0.5, 0]});
    let (material, warnings) = glass(1.0, amber.clone());
    assert_eq!(
        warnings,
        [LoadWarning::UnrefractedTransmission { material: "materials[0] ('glass')".to_owned() }]
    );
    assert_eq!((material.thickness, material.absorption.x), (0.5, 0.0));
    // Half is left after two units; of black nothing.
    assert!((material.absorption.y - 2.0_f32.ln() / 2.0).abs() < 1e-6, "{}", material.absorption);
    assert!((-material.absorption.z * 0.5).exp() < 1e-6, "{}", material.absorption);
    // Without transmission, thickness or distance there is nothing to absorb.
    assert_eq!(glass(0.0, amber).0.absorption, Vec3::ZERO);
    for nothing in [json!({}), json!({"attenuationColor": [1, 0.5, 0], "thicknessFactor": 1})] {
        let (material, warnings) = glass(1.0, nothing);
        assert_eq!((material.absorption, warnings.len()), (Vec3::ZERO, 1));
    }
    // What is out of range is left out, and said.
    for odd in [json!({"thicknessFactor": -1}), json!({"thicknessFactor": 1, "attenuationDistance": 0})] {
        let (material, warnings) = glass(1.0, odd);
        assert_eq!(material.thickness, 0.0);
        assert!(
            warnings.iter().any(|warning| warning.to_string().contains("KHR_materials_volume")),
            "{warnings:?}"
        );
    }
}

#[test]
fn a_thickness_texture_is_kept_as_data() {
    let mut builder = Builder::triangle();
    let thickness = builder.texture([0, 128, 0, 255]);
    builder.material(json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 1, "thicknessTexture": {"index": thickness}, "attenuationDistance": 1, "attenuationColor": [1, 0.5, 0.25]},
    }}));
    let parts = parts(&builder);
    let used = parts.materials[0].thickness_texture.unwrap();
    let texture = &parts.textures[used.texture as usize];
    assert!(!texture.srgb && texture.image.as_slice() == [[0, 128, 0, 255]]);
}

#[test]
fn a_transmission_texture_goes_into_the_base_colour() {
    let mut builder = Builder::triangle();
    let base = builder.texture([10, 20, 30, 0]);
    let half = builder.texture([128, 0, 0, 0]);
    builder.material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": base}, "metallicFactor": 0},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": {"index": half}}},
    }));
    let parts = parts(&builder);
    assert_eq!(parts.materials[0].alpha_mode, AlphaMode::Blend);
    assert_eq!(parts.textures.len(), 1);
    // The alpha of an opaque material's texture means nothing: what is left is 1 - 0.85 · 128/255.
    assert_eq!(parts.textures[0].image.as_slice(), [[10, 20, 30, 146]]);
}

#[test]
fn colours_and_texture_coordinates_are_morphed() {
    let mut builder = Builder::triangle();
    let colours = builder.floats("VEC4", &[1.0; 12]);
    builder.attribute("COLOR_0", colours);
    let uvs = builder.floats("VEC2", &[0.0; 6]);
    builder.attribute("TEXCOORD_0", uvs);
    builder.attribute("TEXCOORD_1", uvs);
    let fading = builder.floats("VEC4", &[0.0, 0.0, 0.0, -0.5].repeat(3));
    let darker = builder.floats("VEC3", &[-0.25; 9]);
    let sliding = builder.floats("VEC2", &[0.5; 6]);
    builder.primitive()["targets"] = json!([
        {"COLOR_0": fading, "_OWN": fading}, {"COLOR_0": darker, "TEXCOORD_1": sliding, "TANGENT": darker},
        {"COLOR_1": fading, "TEXCOORD_2": sliding},
    ]);
    let loaded = builder.load().unwrap();
    let targets = &loaded.scene.parts().meshes[0].morph_targets;
    assert_eq!(targets[0].colours, [Vec4::new(0.0, 0.0, 0.0, -0.5); 3]);
    assert_eq!(targets[1].colours, [Vec4::new(-0.25, -0.25, -0.25, 0.0); 3]);
    assert_eq!(targets[1].uv_sets, [vec![], vec![Vec2::splat(0.5); 3]]);
    let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("COLOR_1") && warnings[1].contains("TEXCOORD_2"), "{warnings:?}");
    assert!(warnings[0].contains("meshes[0].primitives[0] ('Body')"), "{warnings:?}");
}

#[test]
fn specular_glossiness_is_converted_and_wins_over_its_fallback() {
    let glossy = json!({"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0, 0, 0, 0.5], "specularFactor": [1, 0.5, 0.25], "glossinessFactor": 0.75}});
    let mut builder = Builder::triangle();
    builder.material(json!({"extensions": glossy}));
    let metal = material(&builder);
    assert!(
        (metal.metallic - 1.0).abs() < 1e-3
            && metal.base_colour.abs_diff_eq(Vec4::new(1.0, 0.5, 0.25, 0.5), 1e-3)
    );
    assert_eq!(metal.roughness, 0.25);
    let texture = builder.texture([255, 128, 64, 128]);
    builder.json["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"]["diffuseTexture"] =
        json!({"index": texture});
    let textured = parts(&builder);
    assert_eq!(textured.textures.len(), 2);
    assert_eq!(textured.textures[0].image[(0, 0)][3], 128);
    assert_eq!(textured.textures[1].image[(0, 0)][1..3], [64, 255]);
    builder.json["materials"][0]["pbrMetallicRoughness"] = json!({"roughnessFactor": 0.125});
    assert_eq!(material(&builder).roughness, 1.0);
    assert_eq!(parts(&builder).textures.len(), 2);
    // Unlit materials have no other colour than that of the core.
    builder.json["materials"][0]["extensions"]["KHR_materials_unlit"] = json!({});
    assert_eq!(material(&builder).roughness, 0.125);
}

#[test]
fn extensions_without_effect_are_named_once() {
    let mut builder = Builder::triangle();
    builder.json["extensionsUsed"] =
        json!(["KHR_materials_ior", "KHR_materials_sheen", "KHR_materials_ior", "VENDOR_new"]);
    builder.json["extensionsRequired"] = json!(["KHR_materials_sheen"]);
    let names: Vec<_> = builder.load().unwrap().warnings.iter().map(ToString::to_string).collect();
    assert_eq!(names.len(), 3);
    assert!(names[2].contains("VENDOR_new"));
}

#[test]
fn gpu_instances_stand_where_their_attributes_say() {
    let mut builder = Builder::triangle();
    let places = builder.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
    let scales = builder.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    builder.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places, "SCALE": scales, "_ID": 0}}});
    let parts = parts(&builder);
    let moved: Vec<_> =
        parts.instances.iter().map(|instance| instance.node_from_object.transform_point3(Vec3::X)).collect();
    assert_eq!(moved, [Vec3::new(2.0, 0.0, 0.0), Vec3::new(2.0, 2.0, 0.0)]);
    assert_eq!([parts.instances[0].id, parts.instances[1].id], [0, 1]);
}

#[test]
fn a_mesh_that_is_drawn_often_is_stored_once() {
    let (count, triangle_count) = (400_u16, 4032);
    for by_extension in [true, false] {
        let mut builder = Builder::triangle();
        let indices = [0_u16, 1, 2].map(u16::to_le_bytes).as_flattened().repeat(triangle_count);
        let indices = builder.accessor("SCALAR", 5123, &indices, 3 * triangle_count);
        builder.primitive()["indices"] = json!(indices);
        let places: Vec<[f32; 3]> = (0..count).map(|place| [f32::from(place), 0.0, 0.0]).collect();
        if by_extension {
            let places = builder.floats("VEC3", places.as_flattened());
            builder.json["nodes"][0]["extensions"] =
                json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
        } else {
            let nodes = places.iter().map(|place| json!({"mesh": 0, "translation": place}));
            builder.json["nodes"] = nodes.collect();
            builder.json["scenes"][0]["nodes"] = (0..count).collect();
        }
        let scene = builder.load().unwrap().scene;
        assert_eq!(scene.parts().meshes.len(), 1);
        let camera = scene.camera(&CameraChoice::Default).unwrap();
        let animator = Animator::new(Arc::new(scene), camera);
        let frame = animator.frame();
        assert_eq!((frame.triangles().len(), frame.instances().len()), (0, usize::from(count)));
        assert_eq!(frame.triangle_count(), usize::from(count) * triangle_count);
        let (last, first) = (frame.triangle_count() as u32 - 1, (usize::from(count) - 1) * triangle_count);
        assert_eq!(frame.corners(last)[1], Vec3::new(f32::from(count), 0.0, 0.0));
        assert_eq!(frame.object(last).first_triangle as usize, first);
    }
}

#[test]
fn vertex_colours_have_three_components_or_four() {
    let mut builder = Builder::triangle();
    let colours = builder.accessor("VEC4", 5123, &[0xFF, 0xFF, 0, 0, 0, 0, 0x33, 0x33].repeat(3), 3);
    builder.json["accessors"][colours]["normalized"] = json!(true);
    builder.attribute("COLOR_0", colours);
    assert_eq!(mesh(&builder).colours, [Vec4::new(1.0, 0.0, 0.0, 0.2); 3]);
    let opaque = builder.floats("VEC3", &[0.5; 9]);
    builder.attribute("COLOR_0", opaque);
    assert_eq!(mesh(&builder).colours, [Vec4::new(0.5, 0.5, 0.5, 1.0); 3]);
}
