//! Damaged files: whatever happens to the bytes or the JSON, loading ends with a scene or an error.

use std::{fs, path::Path};

use serde_json::{Value, json};
use sheer_core::hash::Pcg32;
use sheer_scene::{LoadOptions, load::read_gltf};

use crate::{assets, builder::glb};

/// Files whose first buffer is put into the container, so that it is damaged too.
const SEEDS: &[&str] = &[
    "AnimatedMorphCube-Quantized/AnimatedMorphCube.gltf",
    "MeshPrimitiveModes/MeshPrimitiveModes.gltf",
    #[cfg(feature = "draco")]
    "MorphPrimitivesTest-Draco/MorphPrimitivesTest.gltf",
    "SimpleInstancing/SimpleInstancing.gltf",
    "SimpleSparseAccessor/SimpleSparseAccessor.gltf",
    #[cfg(feature = "ktx2")]
    "TextureVariants-Embedded-KTX/TextureVariants-Embedded-KTX.gltf",
    "TriangleWithoutIndices/TriangleWithoutIndices.gltf",
    "VertexColorTest/VertexColorTest.gltf",
    "pirate-meshopt/pirate.glb",
    "Fox/Fox.gltf",
];
/// Damaged versions of each, of each of the three kinds.
const ROUNDS: u32 = 100;

/// A place in a list of so many.
fn place(chance: &mut Pcg32, count: usize) -> usize {
    chance.below(count as u32) as usize
}

/// The JSON and first buffer of a file.
fn seed(path: &Path) -> (Value, Vec<u8>) {
    let bytes = fs::read(path).unwrap();
    if bytes.starts_with(b"glTF") {
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        return (serde_json::from_slice(&bytes[20..20 + length]).unwrap(), bytes[28 + length..].to_vec());
    }
    let json: Value = serde_json::from_slice(&bytes).unwrap();
    let uri = json["buffers"][0]["uri"].as_str().unwrap();
    let folder = path.parent().unwrap();
    let binary = if uri.starts_with("data:") { None } else { Some(fs::read(folder.join(uri)).unwrap()) };
    (json, binary.unwrap_or_default())
}

fn container(json: &Value, binary: &[u8]) -> Vec<u8> {
    // An embedded buffer stays where it is.
    if binary.is_empty() { serde_json::to_vec(json).unwrap() } else { glb(json.clone(), binary) }
}

/// All places in a JSON value, as pointers.
fn pointers(value: &Value, at: &str, all: &mut Vec<String>) {
    match value {
        Value::Array(list) => {
            for (key, value) in list.iter().enumerate() {
                pointers(value, &format!("{at}/{key}"), all);
            }
        }
        Value::Object(map) => {
            for (key, value) in map {
                pointers(value, &format!("{at}/{key}"), all);
            }
        }
        _ => {}
    }
    all.push(at.to_owned());
}

/// Replaces a value by an extreme one, or by one from elsewhere in the file.
fn swap_value(json: &mut Value, chance: &mut Pcg32) {
    let mut all = Vec::new();
    pointers(json, "", &mut all);
    let target = all[place(chance, all.len())].clone();
    let extremes = [
        json!(0),
        json!(1),
        json!(-1),
        json!(3),
        json!(255),
        json!(65536),
        json!(4_294_967_295_u32),
        json!(u64::MAX),
        json!(1_000_000_000),
        json!(1e38),
        json!(-1e-30),
        json!(0.5),
        json!(""),
        json!("SCALAR"),
        json!("../x"),
        json!("data:,"),
        json!(null),
        json!([]),
        json!({}),
        json!(true),
    ];
    let value = if place(chance, 4) == 0 {
        json.pointer(&all[place(chance, all.len())]).cloned().unwrap_or_default()
    } else {
        extremes[place(chance, extremes.len())].clone()
    };
    if let Some(place) = json.pointer_mut(&target) {
        *place = value;
    }
}

#[test]
fn no_damage_makes_the_loader_panic() {
    let mut chance = Pcg32::new(2026, 0);
    let (mut loaded, mut refused) = (0, 0);
    for name in SEEDS {
        let path = assets::path(name);
        let (json, binary) = seed(&path);
        let whole = container(&json, &binary);
        // What is not damaged loads.
        read_gltf(&whole, &path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));

        let mut try_to_load = |bytes: &[u8]| match read_gltf(bytes, &path, &LoadOptions::default()) {
            Ok(_) => loaded += 1,
            Err(_) => refused += 1,
        };
        for _ in 0..ROUNDS {
            let mut flipped = whole.clone();
            for _ in 0..=place(&mut chance, 4) {
                let at = place(&mut chance, flipped.len());
                flipped[at] ^= 1 << place(&mut chance, 8);
            }
            try_to_load(&flipped);

            // Damage to the binary part alone is found late, deep in the decoders.
            let mut spoiled = binary.clone();
            for _ in 0..=place(&mut chance, 4) {
                let end = spoiled.len();
                if end > 0 {
                    spoiled[place(&mut chance, end)] = chance.next_u32() as u8;
                }
            }
            try_to_load(&container(&json, &spoiled));

            try_to_load(&whole[..place(&mut chance, whole.len())]);

            let mut swapped = json.clone();
            for _ in 0..=place(&mut chance, 3) {
                swap_value(&mut swapped, &mut chance);
            }
            // The container stays whole, so that the JSON is looked at.
            if swapped.is_object() {
                try_to_load(&container(&swapped, &binary));
            }
        }
    }
    // Both outcomes have been exercised thousands of times in all.
    assert!(loaded > 300 && refused > 1000 && loaded + refused > 2000, "{loaded} loaded, {refused} refused");
}
