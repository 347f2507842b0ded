//! A scene that other renderers can read: puffs of smoke as glTF, without textures, since those are filtered
//! differently by everyone. A puff is a quad of four triangles, opaque in the middle and transparent at its
//! corners, in a colour of its own.

use std::{
    fs::{self, File},
    io::{BufWriter, Write as _},
    path::{Path, PathBuf},
};

use anyhow::Context as _;
use glam::{Vec3, Vec4, vec3};
use serde_json::json;

use crate::scenes::{Geometry, camera_ray, pcg, unit};

/// Opacity in the middle of the thickest puff.
const DENSEST: f32 = 0.8;
/// glTF's numbers for 32-bit floats and indices.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Writes NAME.gltf and NAME.bin into a folder, for the first of the scenes: the cloud of quads; returns the
/// path of the former.
pub(crate) fn write(folder: &Path) -> anyhow::Result<PathBuf> {
    let [cloud, ..] = Geometry::all();
    let (mut positions, mut colours, mut indices): (Vec<Vec3>, Vec<Vec4>, Vec<u32>) = Default::default();
    for (puff, halves) in cloud.triangles.chunks_exact(2).enumerate() {
        let corners = [halves[0][0], halves[0][1], halves[0][2], halves[1][2]];
        let draw = |of: u32| unit(pcg(4 * puff as u32 + of));
        let colour = vec3(draw(0), draw(1), draw(2));
        let first = positions.len() as u32;
        positions.extend(corners);
        positions.push(0.5 * (corners[0] + corners[2]));
        colours.extend([colour.extend(0.0); 4]);
        colours.push(colour.extend(DENSEST * draw(3)));
        indices.extend((0..4).flat_map(|edge| [first + edge, first + (edge + 1) % 4, first + 4]));
    }

    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let (path, binary) = (folder.join("smoke.gltf"), folder.join("smoke.bin"));
    let mut out = BufWriter::new(File::create(&binary).with_context(|| binary.display().to_string())?);
    let floats = positions.iter().flat_map(|p| p.to_array()).chain(colours.iter().flat_map(|c| c.to_array()));
    for float in floats {
        out.write_all(&float.to_le_bytes())?;
    }
    for index in &indices {
        out.write_all(&index.to_le_bytes())?;
    }
    out.flush()?;

    let sizes = [12 * positions.len(), 16 * colours.len(), 4 * indices.len()];
    let starts = [0, sizes[0], sizes[0] + sizes[1]];
    let views: Vec<_> = starts
        .iter()
        .zip(sizes)
        .map(|(start, size)| json!({ "buffer": 0, "byteOffset": start, "byteLength": size }))
        .collect();
    let low = positions.iter().copied().reduce(Vec3::min).unwrap_or_default();
    let high = positions.iter().copied().reduce(Vec3::max).unwrap_or_default();
    // A ray through the middle of the upper edge tells where the camera is and how much it sees.
    let ray = camera_ray([0.5, 0.0], [1, 1]);
    let half = (ray.direction.y / -ray.direction.z).atan();
    let document = json!({
        "asset": { "version": "2.0", "generator": "sheer-peers" },
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0 }, { "camera": 0, "translation": ray.origin.to_array() }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 2.0 * half, "znear": 1e-3 } }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "COLOR_0": 1 }, "indices": 2, "material": 0
        }] }],
        "materials": [{
            "alphaMode": "BLEND", "doubleSided": true, "extensions": { "KHR_materials_unlit": {} }
        }],
        "buffers": [{ "uri": "smoke.bin", "byteLength": starts[2] + sizes[2] }],
        "bufferViews": views,
        "accessors": [
            { "bufferView": 0, "componentType": FLOAT, "type": "VEC3", "count": positions.len(),
              "min": low.to_array(), "max": high.to_array() },
            { "bufferView": 1, "componentType": FLOAT, "type": "VEC4", "count": colours.len() },
            { "bufferView": 2, "componentType": UNSIGNED_INT, "type": "SCALAR", "count": indices.len() },
        ],
    });
    fs::write(&path, serde_json::to_string(&document)?).with_context(|| path.display().to_string())?;
    Ok(path)
}
