//! What a scene takes in memory.

use std::{collections::HashSet, sync::Arc};

use crate::{
    cost::TEXEL_BYTES,
    frame::FrameSize,
    model::{Mesh, MorphTarget, SceneParts},
    texture::level_bytes,
};

/// What a scene takes in memory, roughly, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneMemory {
    /// Meshes, each once.
    pub geometry: u64,
    /// Images, each once, with the levels that are looked up from afar.
    pub textures: u64,
    /// Frames on the CPU: triangles where they are drawn, and the hierarchy over them.
    pub frame: u64,
}

impl SceneMemory {
    pub(crate) fn of(parts: &SceneParts) -> Self {
        let mut seen = HashSet::new();
        let images = parts.textures.iter().map(|texture| &texture.image);
        let images = images.filter(|image| seen.insert(Arc::as_ptr(image)));
        let texels: u64 = images.map(|image| image.as_slice().len() as u64).sum();
        Self {
            geometry: parts.meshes.iter().map(mesh_bytes).sum(),
            textures: (texels * TEXEL_BYTES).saturating_add(level_bytes(parts)),
            frame: FrameSize::of(parts).bytes,
        }
    }
}

fn mesh_bytes(mesh: &Mesh) -> u64 {
    fn bytes<T>(list: &[T]) -> usize {
        size_of_val(list)
    }
    fn of_sets<T>(sets: &[Vec<T>]) -> usize {
        sets.iter().map(|set| bytes(set)).sum()
    }
    let Mesh {
        name,
        material: _,
        positions,
        normals,
        tangents,
        uv_sets,
        colours,
        indices,
        influences,
        influences_per_vertex: _,
        morph_targets,
    } = mesh;
    let own = name.len()
        + bytes(positions)
        + bytes(normals)
        + bytes(tangents)
        + of_sets(uv_sets)
        + bytes(colours)
        + bytes(indices)
        + bytes(influences);
    let of_target = |MorphTarget { positions, normals, tangents, colours, uv_sets }: &MorphTarget| {
        bytes(positions) + bytes(normals) + bytes(tangents) + bytes(colours) + of_sets(uv_sets)
    };
    (own + morph_targets.iter().map(of_target).sum::<usize>()) as u64
}
