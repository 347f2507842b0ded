//! Small files that ask for much: by count, by reference, by instancing, by name, by nesting, by images.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{fs, iter, path::Path};

use serde_json::{Value, json};

/// A file in a folder, and what has to come of it.
pub(super) struct Hostile {
    pub(super) name: &'static str,
    pub(super) make: fn(&Path),
    pub(super) end: End,
}

/// What has to come of a file.
#[derive(Clone, Copy, Debug)]
pub(super) enum End {
    /// An error that says this, and names the memory limit.
    BeyondLimit(&'static str),
    /// An error that says this.
    Error(&'static str),
    /// A picture.
    Picture,
    /// Either.
    Any,
}

use End::{Any, BeyondLimit, Error, Picture};

pub(super) const FILES: &[Hostile] = &[
    // By count: what has no data costs nothing to ask for.
    Hostile { name: "zeros.gltf", make: zeros, end: BeyondLimit("nodes[0]") },
    Hostile { name: "zeros-instanced.gltf", make: zeros_instanced, end: BeyondLimit("meshes[0]") },
    Hostile { name: "endless.gltf", make: endless, end: BeyondLimit("meshes[0]") },
    Hostile { name: "sparse.gltf", make: sparse, end: BeyondLimit("nodes[0]") },
    Hostile { name: "keys.gltf", make: keys, end: BeyondLimit("animations[0]") },
    Hostile { name: "joints.gltf", make: joints, end: BeyondLimit("skins[0]") },
    Hostile { name: "targets.gltf", make: targets, end: BeyondLimit("meshes[0]") },
    Hostile { name: "meshopt.gltf", make: meshopt, end: BeyondLimit("nodes[0]") },
    // By reference.
    Hostile { name: "one-accessor.gltf", make: one_accessor, end: BeyondLimit("nodes[0]") },
    Hostile { name: "one-vertex-list.gltf", make: one_vertex_list, end: Picture },
    Hostile {
        name: "vertex-list-of-many.gltf",
        make: vertex_list_of_many,
        end: Error("more than a file of this size"),
    },
    Hostile { name: "unused-vertices.gltf", make: unused_vertices, end: Picture },
    Hostile { name: "one-buffer.gltf", make: one_buffer, end: Picture },
    Hostile { name: "one-image.gltf", make: one_image, end: Picture },
    Hostile { name: "one-inline-image.gltf", make: one_inline_image, end: Picture },
    Hostile { name: "cutoffs.gltf", make: cutoffs, end: BeyondLimit("textures") },
    Hostile { name: "textures.gltf", make: textures, end: Picture },
    Hostile { name: "one-skin.gltf", make: one_skin, end: Picture },
    Hostile { name: "weights-of-many.gltf", make: weights_of_many, end: Picture },
    // By instancing.
    Hostile { name: "instances.gltf", make: instances, end: BeyondLimit("nodes[0]") },
    Hostile { name: "tree.gltf", make: tree, end: BeyondLimit("nodes[") },
    // By name, and by what else is copied to each node.
    Hostile { name: "camera-name.gltf", make: camera_name, end: Picture },
    Hostile { name: "light-name.gltf", make: light_name, end: Picture },
    Hostile { name: "mesh-name.gltf", make: mesh_name, end: Picture },
    Hostile { name: "extension-name.gltf", make: extension_name, end: Picture },
    Hostile { name: "weights.gltf", make: weights, end: Picture },
    Hostile { name: "points-name.gltf", make: points_name, end: Any },
    // By nesting, and by what the JSON becomes.
    Hostile { name: "brackets.gltf", make: brackets, end: Any },
    Hostile { name: "chain.gltf", make: chain, end: Picture },
    Hostile { name: "materials.gltf", make: materials, end: BeyondLimit("JSON") },
    Hostile { name: "wrong-list.gltf", make: wrong_list, end: Any },
    Hostile { name: "wrong-objects.gltf", make: wrong_objects, end: BeyondLimit("JSON") },
    // By images: every format.
    Hostile { name: "png.gltf", make: png_bomb, end: Error("scale it down") },
    Hostile { name: "png-large.gltf", make: png_large, end: BeyondLimit("images[0]") },
    Hostile { name: "png-eight.gltf", make: png_eight, end: BeyondLimit("images[") },
    Hostile { name: "png-claims.gltf", make: png_claims, end: Error("scale it down") },
    Hostile { name: "jpeg.gltf", make: jpeg_bomb, end: Error("scale it down") },
    Hostile { name: "webp.gltf", make: webp_bomb, end: Error("scale it down") },
    Hostile { name: "ktx2.gltf", make: ktx2_bomb, end: Error("scale it down") },
    Hostile { name: "basis.gltf", make: basis_bomb, end: Error("scale it down") },
    Hostile { name: "many-show-one.gltf", make: many_show_one, end: Picture },
    // The plainer formats.
    Hostile { name: "continued.obj", make: continued, end: Error("this is no OBJ file") },
    Hostile { name: "tangled.obj", make: tangled, end: Picture },
    Hostile { name: "name.obj", make: object_name, end: Picture },
    Hostile { name: "corners.obj", make: corners, end: BeyondLimit("faces") },
    Hostile { name: "libraries.obj", make: libraries, end: Picture },
    Hostile { name: "materials.obj", make: obj_materials, end: Picture },
    Hostile { name: "masks.obj", make: masks, end: BeyondLimit("masks.mtl, line") },
    Hostile { name: "bmp.obj", make: bmp_bomb, end: Picture },
    Hostile { name: "elements.ply", make: elements, end: Any },
    Hostile { name: "points.ply", make: points, end: BeyondLimit("triangles") },
    Hostile { name: "strands.hair", make: strands, end: BeyondLimit("triangles") },
];

/// Three corners of a triangle that is seen.
const TRIANGLE: &str = "data:;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA";

/// One triangle at one node.
fn triangle() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"uri": TRIANGLE, "byteLength": 36}],
    })
}

/// So many triangles, whose corners are in a file, and keys of an animation.
pub(super) fn triangle_of(count: usize, uri: &str) -> Value {
    let mut json = triangle();
    let bytes = 36 * count;
    json["buffers"] = json!([{"uri": uri, "byteLength": bytes}]);
    json["bufferViews"] = json!([{"buffer": 0, "byteLength": bytes}]);
    json["accessors"] = json!([
        {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 * count},
        zero("SCALAR", 1),
        zero("VEC3", 1),
    ]);
    json["meshes"][0]["primitives"][0]["material"] = json!(0);
    json
}

/// As many times the same.
fn times(count: usize, value: &Value) -> Value {
    iter::repeat_n(value.clone(), count).collect()
}

/// Vectors or numbers without data.
fn zero(kind: &str, count: u64) -> Value {
    json!({"componentType": 5126, "type": kind, "count": count})
}

fn write(path: &Path, json: &Value) {
    fs::write(path, serde_json::to_vec(json).unwrap()).unwrap();
}

/// One triangle, changed.
fn changed(path: &Path, change: impl FnOnce(&mut Value)) {
    let mut json = triangle();
    change(&mut json);
    write(path, &json);
}

/// A megabyte.
fn long_name() -> String {
    "name ".repeat(200_000)
}

fn zeros(path: &Path) {
    changed(path, |json| json["accessors"][0] = zero("VEC3", 30_000_000));
}

fn zeros_instanced(path: &Path) {
    changed(path, |json| {
        json["accessors"] = json!([zero("VEC3", 30_000_000), zero("VEC3", 6)]);
        json["nodes"][0]["extensions"] =
            json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}});
        json["materials"] = json!([{"alphaMode": "BLEND", "doubleSided": true}]);
        json["meshes"][0]["primitives"][0]["material"] = json!(0);
    });
}

fn endless(path: &Path) {
    changed(path, |json| json["accessors"][0] = zero("VEC3", u64::MAX));
}

fn sparse(path: &Path) {
    changed(path, |json| {
        json["accessors"][0] = zero("VEC3", 90_000_000);
        json["accessors"][0]["sparse"] = json!({"count": 1,
            "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}});
    });
}

fn keys(path: &Path) {
    changed(path, |json| {
        json["accessors"] =
            json!([json["accessors"][0], zero("SCALAR", 40_000_000), zero("VEC3", 40_000_000)]);
        json["animations"] = json!([{"samplers": [{"input": 1, "output": 2}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]);
    });
}

fn joints(path: &Path) {
    changed(path, |json| {
        json["accessors"] = json!([json["accessors"][0], zero("MAT4", 20_000_000)]);
        json["skins"] = json!([{"joints": [0], "inverseBindMatrices": 1}]);
    });
}

fn targets(path: &Path) {
    changed(path, |json| {
        json["accessors"] = json!([zero("VEC3", 300_000)]);
        json["meshes"][0]["primitives"][0]["targets"] = times(2000, &json!({"POSITION": 0}));
    });
}

fn meshopt(path: &Path) {
    changed(path, |json| {
        json["accessors"][0]["count"] = json!(80_000_000);
        json["bufferViews"][0] = json!({"buffer": 0, "byteLength": 960_000_000, "extensions": {
            "EXT_meshopt_compression": {"buffer": 0, "byteLength": 36, "byteStride": 12,
                "count": 80_000_000, "mode": "ATTRIBUTES"}}});
    });
}

fn one_accessor(path: &Path) {
    changed(path, |json| {
        json["accessors"] = json!([zero("VEC3", 1 << 16)]);
        json["meshes"][0]["primitives"] = times(5000, &json!({"attributes": {"POSITION": 0}}));
    });
}

/// Primitives that use three each of 100,000 vertices.
fn one_vertex_list(path: &Path) {
    vertex_list(path, 100);
}

fn vertex_list_of_many(path: &Path) {
    vertex_list(path, 5000);
}

fn vertex_list(path: &Path, count: usize) {
    changed(path, |json| {
        json["accessors"] = json!([zero("VEC3", 100_000), {"bufferView": 0, "componentType": 5121,
            "type": "SCALAR", "count": 3}]);
        json["buffers"][0] = json!({"uri": "data:;base64,AAEC", "byteLength": 3});
        json["bufferViews"][0] = json!({"buffer": 0, "byteLength": 3});
        json["meshes"][0]["primitives"] =
            times(count, &json!({"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1}));
    });
}

/// A million vertices of which three are used, at 20,000 nodes.
fn unused_vertices(path: &Path) {
    changed(path, |json| {
        json["accessors"] = json!([zero("VEC3", 1_000_000), {"bufferView": 0, "componentType": 5121,
            "type": "SCALAR", "count": 3}]);
        json["meshes"][0]["primitives"][0]["indices"] = json!(1);
        json["buffers"][0] = json!({"uri": "data:;base64,AAEC", "byteLength": 3});
        json["bufferViews"][0] = json!({"buffer": 0, "byteLength": 3});
        json["nodes"] = times(20_000, &json!({"mesh": 0}));
    });
}

/// A file of 20 MB that a hundred buffers are in.
fn one_buffer(path: &Path) {
    let folder = path.parent().unwrap();
    fs::write(folder.join("large.bin"), vec![0_u8; 20_000_000]).unwrap();
    changed(path, |json| {
        let buffers = |at: usize| match at % 3 {
            0 => json!({"uri": "large.bin", "byteLength": 20_000_000}),
            1 => json!({"uri": "./large.bin", "byteLength": 36}),
            _ => json!({"uri": "sub/../large.bin", "byteLength": 36}),
        };
        json["buffers"] = (0..100).map(buffers).collect();
        json["bufferViews"] = (0..100).map(|at| json!({"buffer": at, "byteLength": 36})).collect();
        let accessor = |at| json!({"bufferView": at, "componentType": 5126, "type": "VEC3", "count": 3});
        json["accessors"] = (0..100).map(accessor).collect();
        let primitive = |at| json!({"attributes": {"POSITION": at}});
        json["meshes"][0]["primitives"] = (0..100).map(primitive).collect();
    });
}

/// A PNG of a side, black, of one bit a pixel.
fn black_png(side: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let row = side.div_ceil(8) as usize;
    encoder.write_header().unwrap().write_image_data(&vec![0; row * side as usize]).unwrap();
    bytes
}

/// Images, each a texture of a material of a primitive.
fn with_images(path: &Path, images: Value) {
    changed(path, |json| {
        let count = images.as_array().unwrap().len();
        json["images"] = images;
        json["textures"] = (0..count).map(|at| json!({"source": at})).collect();
        let material = |at| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": at}}});
        json["materials"] = (0..count).map(material).collect();
        let primitive = |at| json!({"attributes": {"POSITION": 0}, "material": at});
        json["meshes"][0]["primitives"] = (0..count).map(primitive).collect();
    });
}

fn one_image(path: &Path) {
    let folder = path.parent().unwrap();
    fs::write(folder.join("black.png"), black_png(2048)).unwrap();
    let uri = |at: usize| if at.is_multiple_of(2) { "black.png" } else { "./black.png" };
    with_images(path, (0..200).map(|at| json!({"uri": uri(at)})).collect());
}

/// Bytes as a data URI, percent by percent.
fn inline(bytes: &[u8]) -> String {
    bytes.iter().fold("data:,".to_owned(), |uri, byte| format!("{uri}%{byte:02x}"))
}

fn one_inline_image(path: &Path) {
    let png = black_png(1024);
    changed(path, |json| {
        json["buffers"] = json!([json["buffers"][0], {"uri": inline(&png), "byteLength": png.len()}]);
        let view = json!({"buffer": 1, "byteLength": png.len()});
        json["bufferViews"] =
            iter::once(json["bufferViews"][0].clone()).chain(iter::repeat_n(view, 400)).collect();
        json["images"] = (1..=400).map(|at| json!({"bufferView": at})).collect();
        json["textures"] = (0..400).map(|at| json!({"source": at})).collect();
        json["materials"] = (0..400).map(|at| json!({"emissiveTexture": {"index": at}})).collect();
        let primitive = |at| json!({"attributes": {"POSITION": 0}, "material": at});
        json["meshes"][0]["primitives"] = (0..400).map(primitive).collect();
    });
}

/// One image whose alpha is tested against 300 values: as many chains of levels.
fn cutoffs(path: &Path) {
    let folder = path.parent().unwrap();
    fs::write(folder.join("black.png"), black_png(2048)).unwrap();
    changed(path, |json| {
        json["images"] = json!([{"uri": "black.png"}]);
        json["textures"] = times(300, &json!({"source": 0}));
        let material = |at: usize| {
            json!({"alphaMode": "MASK", "alphaCutoff": (at + 1) as f64 / 302.0,
                "pbrMetallicRoughness": {"baseColorTexture": {"index": at}}})
        };
        json["materials"] = (0..300).map(material).collect();
        let primitive = |at| json!({"attributes": {"POSITION": 0}, "material": at});
        json["meshes"][0]["primitives"] = (0..300).map(primitive).collect();
    });
}

fn textures(path: &Path) {
    let folder = path.parent().unwrap();
    fs::write(folder.join("small.png"), black_png(8)).unwrap();
    const COUNT: usize = 20_000;
    changed(path, |json| {
        json["images"] = json!([{"uri": "small.png"}]);
        json["textures"] = times(COUNT, &json!({"source": 0}));
        let material = |at| json!({"emissiveTexture": {"index": at}});
        json["materials"] = (0..COUNT).map(material).collect();
        let primitive = |at| json!({"attributes": {"POSITION": 0}, "material": at});
        json["meshes"][0]["primitives"] = (0..COUNT).map(primitive).collect();
    });
}

/// 3,000 instances on a skin of 3,000 joints.
fn one_skin(path: &Path) {
    changed(path, |json| {
        json["accessors"] = json!([json["accessors"][0],
            {"componentType": 5121, "type": "VEC4", "count": 3}, zero("VEC4", 3)]);
        json["meshes"][0]["primitives"][0]["attributes"] =
            json!({"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2});
        json["nodes"] = times(3000, &json!({"mesh": 0, "skin": 0}));
        json["skins"] = json!([{"joints": (0..3000).collect::<Vec<_>>()}]);
    });
}

/// 5,000 channels that move the weights of 5,000 nodes.
fn weights_of_many(path: &Path) {
    const COUNT: usize = 5000;
    changed(path, |json| {
        json["accessors"] = json!([json["accessors"][0], zero("SCALAR", 1)]);
        json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
        json["nodes"] = times(COUNT, &json!({"mesh": 0}));
        let channel = |at| json!({"sampler": 0, "target": {"node": at, "path": "weights"}});
        json["animations"] = json!([{"samplers": [{"input": 1, "output": 1}],
            "channels": (0..COUNT).map(channel).collect::<Vec<_>>()}]);
    });
}

fn instances(path: &Path) {
    changed(path, |json| {
        json["accessors"] = json!([json["accessors"][0], zero("VEC3", 40_000_000)]);
        json["nodes"][0]["extensions"] =
            json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}});
    });
}

/// 2,000 primitives, drawn at 20,000 nodes.
fn tree(path: &Path) {
    changed(path, |json| {
        json["meshes"][0]["primitives"] = times(2000, &json!({"attributes": {"POSITION": 0}}));
        json["nodes"] = times(20_000, &json!({"mesh": 0}));
    });
}

fn camera_name(path: &Path) {
    changed(path, |json| {
        json["cameras"] =
            json!([{"name": long_name(), "type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
        json["nodes"] = iter::once(json!({"mesh": 0}))
            .chain(iter::repeat_n(json!({"camera": 0, "translation": [0, 0, 3]}), 3000))
            .collect();
    });
}

fn light_name(path: &Path) {
    changed(path, |json| {
        json["extensions"] =
            json!({"KHR_lights_punctual": {"lights": [{"name": long_name(), "type": "point"}]}});
        let node = json!({"extensions": {"KHR_lights_punctual": {"light": 0}}});
        json["nodes"] = iter::once(json!({"mesh": 0})).chain(iter::repeat_n(node, 1000)).collect();
    });
}

fn mesh_name(path: &Path) {
    changed(path, |json| {
        json["meshes"][0]["name"] = json!(long_name());
        json["meshes"][0]["primitives"] = times(2000, &json!({"attributes": {"POSITION": 0}}));
    });
}

fn extension_name(path: &Path) {
    changed(path, |json| {
        json["extensionsUsed"] = times(20, &json!(long_name()));
    });
}

fn weights(path: &Path) {
    changed(path, |json| {
        json["meshes"][0]["weights"] = times(500_000, &json!(0));
        json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
        json["nodes"] = times(1000, &json!({"mesh": 0}));
    });
}

fn points_name(path: &Path) {
    changed(path, |json| {
        json["meshes"][0]["name"] = json!(long_name());
        json["meshes"][0]["primitives"] =
            times(5000, &json!({"attributes": {"POSITION": 0, "WRONG": 7}, "mode": 0}));
    });
}

fn brackets(path: &Path) {
    let depth = 20_000_000;
    fs::write(path, format!(r#"{{"asset": {{"version": 2}}, "extras": {}"#, "[".repeat(depth))).unwrap();
}

fn chain(path: &Path) {
    const COUNT: usize = 100_000;
    changed(path, |json| {
        let node = |at: usize| json!({"children": if at + 1 < COUNT { vec![at + 1] } else { vec![] }});
        json["nodes"] = (0..COUNT).map(node).collect();
        json["nodes"][COUNT - 1]["mesh"] = json!(0);
    });
}

fn materials(path: &Path) {
    changed(path, |json| json["materials"] = times(2_000_000, &json!({})));
}

/// What parses as no list of nodes, and a long list elsewhere.
fn wrong_list(path: &Path) {
    changed(path, |json| {
        json["nodes"][0]["mesh"] = json!(0.5);
        json["extras"] = times(10_000_000, &json!(0));
    });
}

fn wrong_objects(path: &Path) {
    changed(path, |json| {
        json["nodes"][0]["mesh"] = json!("zero");
        json["extras"] = times(1_500_000, &json!({"a": 0}));
    });
}

/// One image.
fn with_image(path: &Path, bytes: &[u8]) {
    fs::write(path.with_extension("image"), bytes).unwrap();
    let name = path.with_extension("image").file_name().unwrap().to_str().unwrap().to_owned();
    with_images(path, json!([{"uri": name}]));
}

fn png_bomb(path: &Path) {
    with_image(path, &black_png(16_384));
}

fn png_large(path: &Path) {
    with_image(path, &black_png(12_000));
}

/// Eight files, each of which would be refused for its size alone.
fn png_eight(path: &Path) {
    let folder = path.parent().unwrap();
    let bytes = black_png(6000);
    let names = (0..8).map(|at| format!("eight-{at}.png"));
    names.clone().for_each(|name| fs::write(folder.join(name), &bytes).unwrap());
    with_images(path, names.map(|name| json!({"uri": name})).collect());
}

/// The header of a PNG that claims 60,000 pixels a side.
fn png_claims(path: &Path) {
    let mut bytes = black_png(8);
    bytes[16..24].copy_from_slice(&[0, 0, 0xEA, 0x60, 0, 0, 0xEA, 0x60]);
    let crc = bytes[12..29].iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    });
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    with_image(path, &bytes);
}

/// A picture in a format of the `image` crate.
fn encoded(format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(16, 16).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A JPEG whose frame header says 16,000 pixels a side.
fn jpeg_bomb(path: &Path) {
    let mut bytes = encoded(image::ImageFormat::Jpeg);
    let frame = bytes.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
    bytes[frame + 5..frame + 9].copy_from_slice(&[0x3e, 0x80, 0x3e, 0x80]);
    with_image(path, &bytes);
}

/// A lossless WebP that says 16,383 pixels a side.
fn webp_bomb(path: &Path) {
    let mut bytes = encoded(image::ImageFormat::WebP);
    let data = bytes.windows(4).position(|chunk| chunk == b"VP8L").unwrap() + 8;
    assert_eq!(bytes[data], 0x2f);
    let flags = bytes[data + 4] & 0xf0;
    // Sides less one in 14 bits each, of 16,383 pixels: the reader takes the largest there is for none.
    let sides = 0x3ffe_u32 << 14 | 0x3ffe;
    bytes[data + 1..data + 5].copy_from_slice(&sides.to_le_bytes());
    bytes[data + 4] |= flags;
    with_image(path, &bytes);
}

/// A KTX2 file of one level.
fn ktx2(format: u32, side: u32, scheme: u32, data: &[u8], unpacked: u64) -> Vec<u8> {
    let mut bytes = b"\xABKTX 20\xBB\r\n\x1A\n".to_vec();
    for word in [format, 1, side, side, 0, 0, 1, 1, scheme, 0, 0, 0, 0, 0, 0, 0, 0] {
        bytes.extend(word.to_le_bytes());
    }
    for long in [104, data.len() as u64, unpacked] {
        bytes.extend(long.to_le_bytes());
    }
    bytes.extend(data);
    bytes
}

/// A gigabyte of zeros in a Zstandard frame of blocks that repeat a byte (RFC 8878, 3.1.1.2).
fn ktx2_bomb(path: &Path) {
    let mut frame = vec![0x28, 0xB5, 0x2F, 0xFD, 0x00, 0x58];
    const BLOCK: u32 = 128 << 10;
    let count = (1 << 30) / BLOCK;
    for at in 0..count {
        let header = BLOCK << 3 | 1 << 1 | u32::from(at + 1 == count);
        frame.extend(&header.to_le_bytes()[..3]);
        frame.push(0);
    }
    with_image(path, &ktx2(37, 16_384, 2, &frame, 1 << 30));
}

fn basis_bomb(path: &Path) {
    with_image(path, &ktx2(0, 16_384, 0, &[0; 16], 16));
}

/// Each of many materials asks all texels of one image.
fn many_show_one(path: &Path) {
    fs::write(path.with_extension("png"), black_png(4096)).unwrap();
    changed(path, |json| {
        json["images"] = json!([{"uri": "many-show-one.png"}]);
        json["textures"] = json!([{"source": 0}]);
        let material = json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0},
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}},
        });
        json["materials"] = times(2000, &material);
        let primitive = |at| json!({"attributes": {"POSITION": 0}, "material": at});
        json["meshes"][0]["primitives"] = (0..2000).map(primitive).collect();
    });
}

/// One line in half a million lines.
fn continued(path: &Path) {
    fs::write(path, "\\\n".repeat(500_000)).unwrap();
}

/// Three vertices of a triangle that is seen, as OBJ.
const OBJ: &str = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\n";

/// Polygons that wind around themselves.
fn tangled(path: &Path) {
    let vertex = |at: u32| {
        let (sin, cos) = (2.4 * f64::from(at)).sin_cos();
        let radius = 1.0 + 0.3 * f64::from(at % 7);
        format!("v {:.3} {:.3} 0\n", radius * cos, radius * sin)
    };
    let vertices: String = (0..400).map(vertex).collect();
    let face: String = (1..=400).map(|at| format!(" {at}")).collect();
    fs::write(path, format!("{vertices}{}", format!("f{face}\n").repeat(600))).unwrap();
}

fn object_name(path: &Path) {
    let faces: String = (0..20_000).map(|at| format!("usemtl {at}\nf 1 2 3\n")).collect();
    fs::write(path, format!("o {}\n{OBJ}{faces}", long_name())).unwrap();
}

/// Faces of as many corners as fit.
fn corners(path: &Path) {
    fs::write(path, format!("{OBJ}f{}\n", " 1 2 3".repeat(4_000_000))).unwrap();
}

/// A file of materials under a thousand names.
fn libraries(path: &Path) {
    fs::write(path.with_extension("mtl"), "newmtl a\nKd 1 0 0\n".repeat(50_000)).unwrap();
    let names: String = (0..1000)
        .map(|at| format!("mtllib {}/libraries.mtl\n", "./".repeat(at % 100) + &at.to_string()))
        .collect();
    fs::write(path, format!("{OBJ}f 1 2 3\n{names}")).unwrap();
}

fn obj_materials(path: &Path) {
    fs::write(path.with_extension("png"), black_png(4096)).unwrap();
    let materials: String = (0..10_000).map(|at| format!("newmtl {at}\nmap_Kd materials.png\n")).collect();
    fs::write(path.with_extension("mtl"), materials).unwrap();
    let faces: String = (0..10_000).map(|at| format!("usemtl {at}\nf 1 2 3\n")).collect();
    fs::write(path, format!("mtllib materials.mtl\n{OBJ}{faces}")).unwrap();
}

/// Each material has an image of its own made of the same two.
fn masks(path: &Path) {
    fs::write(path.with_extension("png"), black_png(2048)).unwrap();
    let material = |at: u32| format!("newmtl {at}\nmap_Kd masks.png\nmap_d -o 0.{at} 0 masks.png\n");
    fs::write(path.with_extension("mtl"), (1..100).map(material).collect::<String>()).unwrap();
    let faces: String = (1..100).map(|at| format!("usemtl {at}\nf 1 2 3\n")).collect();
    fs::write(path, format!("mtllib masks.mtl\n{OBJ}{faces}")).unwrap();
}

/// Images that claim more than they hold, in the formats that only OBJ uses.
fn bmp_bomb(path: &Path) {
    let mut bmp = encoded(image::ImageFormat::Bmp);
    bmp[18..26].copy_from_slice(&[0, 0, 1, 0, 0, 0, 1, 0]);
    fs::write(path.with_extension("bmp"), bmp).unwrap();
    let mut tga = encoded(image::ImageFormat::Tga);
    tga[12..16].fill(0xff);
    fs::write(path.with_extension("tga"), tga).unwrap();
    let materials = "newmtl a\nmap_Kd bmp.bmp\nnewmtl b\nmap_Kd bmp.tga\n";
    fs::write(path.with_extension("mtl"), materials).unwrap();
    fs::write(path, format!("mtllib bmp.mtl\n{OBJ}usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n")).unwrap();
}

/// A header of elements that are nothing.
fn elements(path: &Path) {
    let elements = "element vertex 0\nelement face 4000000000\n".repeat(50_000);
    fs::write(path, format!("ply\nformat ascii 1.0\n{elements}end_header\n")).unwrap();
}

/// As many points as fit.
fn points(path: &Path) {
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3000000\nproperty char x\nproperty char y\n\
                  property char z\nend_header\n";
    let bytes: Vec<u8> = (0..9_000_000_u32).map(|at| (at % 251) as u8).collect();
    fs::write(path, [header.as_bytes(), &bytes].concat()).unwrap();
}

fn strands(path: &Path) {
    let mut bytes = b"HAIR".to_vec();
    for word in [1_000_000_u32, 2_000_000, 2, 1] {
        bytes.extend(word.to_le_bytes());
    }
    for number in [0.1_f32, 0.5, 1.0, 1.0, 1.0] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.resize(128, 0);
    let numbers = (0..6_000_000_u32).map(|at| (at % 1009) as f32);
    bytes.extend(numbers.flat_map(f32::to_le_bytes));
    fs::write(path, bytes).unwrap();
}
