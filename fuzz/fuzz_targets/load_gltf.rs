//! Any bytes, taken for a glTF file, give a scene or an error.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use sheer_core::text::MemorySize;
use sheer_load::LoadOptions;

fuzz_target!(|bytes: &[u8]| {
    let options = LoadOptions { memory_limit: Some(MemorySize(1 << 30)), ..LoadOptions::default() };
    // The folder does not exist: files beside the input are never there.
    let _ = sheer_load::read_gltf(bytes, Path::new("nowhere/input.glb"), &options);
});
