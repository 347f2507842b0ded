//! Damaged files of every format: whatever happens to their bytes or numbers, loading ends with a scene or an
//! error, in the memory that it may take.
//!
//! `SHEER_DAMAGE=N` damages N times as many files.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{
    env, fs,
    panic::{self, AssertUnwindSafe},
    path::{Path, PathBuf},
    sync::atomic::{AtomicU32, Ordering},
};

use rayon::prelude::*;
use serde_json::{Value, json};
use sheer_core::{hash::Pcg32, text::MemorySize};
use sheer_load::{LoadError, LoadOptions, Loaded, open_with, read, read_gltf};

/// A sound file, and how often each kind of damage is done to it: less often to what takes long.
struct Row {
    file: &'static str,
    read: fn(&[u8], &Path, &LoadOptions) -> Result<Loaded, LoadError>,
    rounds: u32,
}

/// A file of `assets/gltf`. Its first buffer is put into a container, so that it is damaged, too; other files
/// that it refers to are not there.
const fn gltf(file: &'static str, rounds: u32) -> Row {
    Row { file, read: read_gltf, rounds }
}

/// A file of `assets/formats`, which is damaged as it is.
const fn plain(file: &'static str) -> Row {
    Row { file, read, rounds: 300 }
}

/// The materials of an OBJ file that lies beside them, with their image.
fn read_materials(bytes: &[u8], path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let folder = tempfile::tempdir().unwrap();
    for name in ["pane.obj", "pane.tga"] {
        fs::copy(assets("formats").join(name), folder.path().join(name)).unwrap();
    }
    fs::write(folder.path().join(path.file_name().unwrap()), bytes).unwrap();
    open_with(folder.path().join("pane.obj"), options)
}

/// A folder of the project's files for tests.
fn assets(folder: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets")).join(folder)
}

/// A format is a row, or a few.
const ROWS: &[Row] = &[
    gltf("AnimatedMorphCube-Quantized/AnimatedMorphCube.gltf", 350),
    gltf("MeshPrimitiveModes/MeshPrimitiveModes.gltf", 350),
    #[cfg(feature = "draco")]
    gltf("MorphPrimitivesTest-Draco/MorphPrimitivesTest.gltf", 350),
    #[cfg(feature = "draco")]
    gltf("draco-unused-points/compressed.gltf", 350),
    gltf("SimpleInstancing/SimpleInstancing.gltf", 350),
    gltf("SimpleSparseAccessor/SimpleSparseAccessor.gltf", 350),
    #[cfg(feature = "ktx2")]
    gltf("TextureVariants-Embedded-KTX/TextureVariants-Embedded-KTX.gltf", 350),
    gltf("TriangleWithoutIndices/TriangleWithoutIndices.gltf", 350),
    gltf("VertexColorTest/VertexColorTest.gltf", 350),
    gltf("pirate-meshopt/pirate.glb", 200),
    gltf("Fox/Fox.gltf", 100),
    plain("pane.obj"),
    Row { file: "pane.mtl", read: read_materials, rounds: 300 },
    plain("pane.ply"),
    plain("pane-big-endian.ply"),
    plain("pane.stl"),
    plain("pane-text.stl"),
    plain("strands.hair"),
];

/// What a damaged file may take; the sound ones take far less.
const LIMIT: MemorySize = MemorySize(100_000_000);
/// What all that are loaded at once, and the test around them, may take.
const PEAK_BYTES: u64 = 1_000_000_000;

/// A sound file in pieces.
struct Seed {
    path: PathBuf,
    /// As it is read.
    whole: Vec<u8>,
    /// JSON and binary chunk, of glTF.
    parts: Option<(Value, Vec<u8>)>,
}

impl Seed {
    fn open(row: &Row) -> Self {
        // Nothing lies beside it.
        let path = Path::new("nowhere").join(row.file);
        let file = assets("gltf").join(row.file);
        if !file.exists() {
            return Self { path, whole: fs::read(assets("formats").join(row.file)).unwrap(), parts: None };
        }
        let bytes = fs::read(&file).unwrap();
        let (json, binary) = parts_of(&bytes, file.parent().unwrap());
        let whole = container(&json, &binary);
        Self { path, whole, parts: Some((json, binary)) }
    }
}

/// The JSON and first buffer of a glTF file.
fn parts_of(bytes: &[u8], folder: &Path) -> (Value, Vec<u8>) {
    if bytes.starts_with(b"glTF") {
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        return (serde_json::from_slice(&bytes[20..20 + length]).unwrap(), bytes[28 + length..].to_vec());
    }
    let json: Value = serde_json::from_slice(bytes).unwrap();
    let uri = json["buffers"][0]["uri"].as_str().unwrap();
    let binary = if uri.starts_with("data:") { Vec::new() } else { fs::read(folder.join(uri)).unwrap() };
    (json, binary)
}

/// A GLB container, or the JSON alone where the buffer is in it.
fn container(json: &Value, binary: &[u8]) -> Vec<u8> {
    if binary.is_empty() || !json.is_object() {
        return serde_json::to_vec(json).unwrap();
    }
    let mut json = json.clone();
    let buffer = json!({"byteLength": binary.len()});
    match json["buffers"].as_array_mut().and_then(|buffers| buffers.first_mut()) {
        Some(first) => *first = buffer,
        None => json["buffers"] = json!([buffer]),
    }
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend(((28 + text.len() + binary.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text.as_slice()), (b"BIN\0", binary)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

/// A place in a list of so many, of which there is one at least.
fn place(chance: &mut Pcg32, count: usize) -> usize {
    chance.below(count as u32) as usize
}

/// A kind of damage; none where the file has nothing of the kind.
type Damage = fn(&Seed, &mut Pcg32) -> Option<Vec<u8>>;

const DAMAGES: &[(&str, Damage)] = &[
    ("bits turned over", |seed, chance| Some(turned(seed.whole.clone(), chance))),
    ("cut short", |seed, chance| Some(seed.whole[..place(chance, seed.whole.len())].to_vec())),
    ("extreme words", |seed, chance| Some(overwritten(seed.whole.clone(), chance))),
    ("extreme numbers", |seed, chance| renumbered(&seed.whole, chance)),
    ("moved pieces", |seed, chance| Some(moved(&seed.whole, chance))),
    // Damage to the binary part alone is found late, deep in the decoders.
    ("spoiled data", |seed, chance| {
        let (json, binary) = seed.parts.as_ref().filter(|(_, binary)| !binary.is_empty())?;
        let binary = if chance.below(2) == 0 {
            turned(binary.clone(), chance)
        } else {
            overwritten(binary.clone(), chance)
        };
        Some(container(json, &binary))
    }),
    // The container stays whole, so that the JSON is looked at.
    ("swapped values", |seed, chance| {
        let (mut json, binary) = seed.parts.clone()?;
        for _ in 0..=place(chance, 3) {
            swap_value(&mut json, chance);
        }
        Some(container(&json, &binary))
    }),
];

fn turned(mut bytes: Vec<u8>, chance: &mut Pcg32) -> Vec<u8> {
    for _ in 0..=place(chance, 4) {
        let at = place(chance, bytes.len());
        bytes[at] ^= 1 << place(chance, 8);
    }
    bytes
}

fn overwritten(mut bytes: Vec<u8>, chance: &mut Pcg32) -> Vec<u8> {
    const WORDS: [u32; 8] =
        [0, 1, 0x7fff_ffff, 0x8000_0000, u32::MAX, f32::NAN.to_bits(), f32::MAX.to_bits(), 0x0001_0000];
    for _ in 0..=place(chance, 3) {
        let at = place(chance, bytes.len());
        let word = WORDS[place(chance, WORDS.len())].to_le_bytes();
        bytes.iter_mut().skip(at).zip(word).for_each(|(byte, new)| *byte = new);
    }
    bytes
}

/// Another number in the place of one that is written in digits.
fn renumbered(bytes: &[u8], chance: &mut Pcg32) -> Option<Vec<u8>> {
    const NUMBERS: [&str; 12] = [
        "0",
        "1",
        "-1",
        "65536",
        "4294967295",
        "4294967296",
        "18446744073709551616",
        "1e39",
        "-1e-40",
        "nan",
        "0.5",
        "",
    ];
    let is_first = |&at: &usize| bytes[at].is_ascii_digit() && (at == 0 || !bytes[at - 1].is_ascii_digit());
    // The first one from anywhere on.
    let from = place(chance, bytes.len());
    let start = (from..bytes.len()).chain(0..from).find(is_first)?;
    let length = bytes[start..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let number = NUMBERS[place(chance, NUMBERS.len())].as_bytes();
    Some([&bytes[..start], number, &bytes[start + length..]].concat())
}

/// A piece left out, or written twice, or written over another.
fn moved(bytes: &[u8], chance: &mut Pcg32) -> Vec<u8> {
    let start = place(chance, bytes.len());
    let length = (1 + place(chance, 64)).min(bytes.len() - start);
    let piece = &bytes[start..start + length];
    match place(chance, 3) {
        0 => [&bytes[..start], &bytes[start + length..]].concat(),
        1 => [&bytes[..start], piece, &bytes[start..]].concat(),
        _ => {
            let mut moved = bytes.to_vec();
            let to = place(chance, bytes.len() - length + 1);
            moved[to..to + length].copy_from_slice(piece);
            moved
        }
    }
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
        json!(2.0),
        json!(""),
        json!("SCALAR"),
        json!("../x"),
        json!("data:,"),
        json!("\u{1b}[2J"),
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

/// The most memory that this process has had, in bytes, where the system says so.
fn peak_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

#[test]
fn no_damage_makes_a_loader_panic_or_take_more_than_it_may() {
    let factor: u32 = env::var("SHEER_DAMAGE").ok().map_or(1, |factor| factor.parse().unwrap());
    let (loaded, refused) = (AtomicU32::new(0), AtomicU32::new(0));
    let mut faults = Vec::new();
    for (row_number, row) in ROWS.iter().enumerate() {
        let seed = Seed::open(row);
        let options = LoadOptions { memory_limit: Some(LIMIT), ..LoadOptions::default() };
        let strict = LoadOptions { strict: true, ..options.clone() };
        // What is not damaged loads.
        (row.read)(&seed.whole, &seed.path, &options).unwrap_or_else(|error| panic!("{error}"));

        let attempt = |round: u32| -> Vec<String> {
            let mut faults = Vec::new();
            for (kind, (name, damage)) in DAMAGES.iter().enumerate() {
                let stream = u64::from(round) * DAMAGES.len() as u64 + kind as u64;
                let mut chance = Pcg32::new(2026 + row_number as u64, stream);
                let Some(bytes) = damage(&seed, &mut chance) else { continue };
                let options = if chance.below(4) == 0 { &strict } else { &options };
                let read = || (row.read)(&bytes, &seed.path, options);
                match panic::catch_unwind(AssertUnwindSafe(read)) {
                    Ok(Ok(_)) => loaded.fetch_add(1, Ordering::Relaxed),
                    Ok(Err(_)) => refused.fetch_add(1, Ordering::Relaxed),
                    Err(_) => {
                        faults.push(format!("{}, {name}, round {round}", row.file));
                        0
                    }
                };
            }
            faults
        };
        faults.extend((0..row.rounds * factor).into_par_iter().flat_map_iter(attempt).collect::<Vec<_>>());
    }
    assert!(faults.is_empty(), "it panics: {faults:#?}");
    let (loaded, refused) = (loaded.into_inner(), refused.into_inner());
    println!("{loaded} loaded, {refused} refused, {:?} bytes at most", peak_bytes());
    // Both outcomes have been exercised thousands of times.
    assert!(loaded > 2_000 && refused > 5_000 && loaded + refused >= 20_000, "{loaded}, {refused}");
    assert!(peak_bytes().is_none_or(|peak| peak < PEAK_BYTES), "{:?}", peak_bytes());
}

#[test]
fn every_kind_of_damage_changes_the_file() {
    let seed = Seed::open(&ROWS[0]);
    for (name, damage) in DAMAGES {
        let mut changed = 0;
        for round in 0..100 {
            let bytes = damage(&seed, &mut Pcg32::new(1, round)).unwrap();
            changed += u32::from(bytes != seed.whole);
        }
        assert!(changed > 80, "{name}: {changed} of 100");
    }
}
