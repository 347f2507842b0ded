//! Makes small files: a triangle to start from, and ways to add to it.

use std::path::Path;

use serde_json::{Value, json};
use sheer_image::{Image, Metadata, encode_png};
use sheer_load::{LoadError, LoadOptions, Loaded, read_gltf};

/// A file in the making.
pub(crate) struct Builder {
    /// Everything but the buffers.
    pub(crate) json: Value,
    binary: Vec<u8>,
}

impl Builder {
    /// One triangle at one node, positions in accessor 0, no indices.
    pub(crate) fn triangle() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "accessors": [], "bufferViews": [],
            "meshes": [{"name": "Body", "primitives": [{"attributes": {}}]}],
            "nodes": [{"name": "root", "mesh": 0}],
            "scenes": [{"nodes": [0]}],
        });
        let mut builder = Self { json, binary: Vec::new() };
        let positions = builder.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        builder.attribute("POSITION", positions);
        builder
    }

    /// Adds bytes as a buffer view.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        self.binary.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    /// Adds an accessor of floats.
    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(kind, 5126, &bytes, values.len() / components(kind))
    }

    /// Adds an accessor of any component type.
    pub(crate) fn accessor(&mut self, kind: &str, component: u32, bytes: &[u8], count: usize) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
        )
    }

    /// Appends to one of the root's arrays.
    pub(crate) fn push(&mut self, array: &str, value: Value) -> usize {
        if self.json[array].is_null() {
            self.json[array] = json!([]);
        }
        let array = self.json[array].as_array_mut().unwrap();
        array.push(value);
        array.len() - 1
    }

    /// Gives the triangle an attribute.
    pub(crate) fn attribute(&mut self, name: &str, accessor: usize) {
        self.primitive()["attributes"][name] = json!(accessor);
    }

    /// The triangle's primitive.
    pub(crate) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Gives the triangle a material.
    pub(crate) fn material(&mut self, material: Value) {
        let index = self.push("materials", material);
        self.primitive()["material"] = json!(index);
    }

    /// Adds a texture of one texel.
    pub(crate) fn texture(&mut self, texel: [u8; 4]) -> usize {
        let view = self.view(&png(texel));
        let image = self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        self.push("textures", json!({"source": image}))
    }

    /// As a GLB container.
    pub(crate) fn glb(&self) -> Vec<u8> {
        glb(self.json.clone(), &self.binary)
    }

    /// As a GLB container, loaded.
    pub(crate) fn load(&self) -> Result<Loaded, LoadError> {
        self.load_with(&LoadOptions::default())
    }

    /// The same, where anything broken is an error.
    pub(crate) fn load_strictly(&self) -> Result<Loaded, LoadError> {
        self.load_with(&LoadOptions { strict: true, ..LoadOptions::default() })
    }

    fn load_with(&self, options: &LoadOptions) -> Result<Loaded, LoadError> {
        read_gltf(&self.glb(), Path::new("made/test.glb"), options)
    }

    /// The buffer as a file of its own, and the JSON that refers to it.
    pub(crate) fn separate(&self, uri: &str) -> (Vec<u8>, &[u8]) {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"uri": uri, "byteLength": self.binary.len()}]);
        (serde_json::to_vec(&json).unwrap(), &self.binary)
    }
}

/// A GLB container whose first buffer is `binary`.
pub(crate) fn glb(mut json: Value, binary: &[u8]) -> Vec<u8> {
    let buffer = json!({"byteLength": binary.len()});
    match json["buffers"].as_array_mut().and_then(|buffers| buffers.first_mut()) {
        Some(first) => *first = buffer,
        None => json["buffers"] = json!([buffer]),
    }
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend(((28 + text.len() + binary.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

fn components(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        other => panic!("{other}"),
    }
}

fn png(texel: [u8; 4]) -> Vec<u8> {
    encode_png(&Image::filled(1, 1, texel).unwrap(), &Metadata::default()).unwrap()
}
