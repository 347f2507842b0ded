//! The scenes in `assets/gltf`.

use std::path::PathBuf;

#[cfg(feature = "draco")]
#[test]
fn a_draco_mesh_may_leave_numbers_of_points_unused() {
    let of = |name: &str| load(&format!("draco-unused-points/{name}.gltf")).scene;
    let corners = |scene: &sheer_scene::Scene| {
        let mesh = &scene.parts().meshes[0];
        let mut triangles: Vec<Vec<[i64; 3]>> = mesh
            .indices
            .iter()
            .map(|triangle| {
                // Quantisation moves corners by less than the grid is wide.
                let mut corners: Vec<[i64; 3]> = triangle
                    .iter()
                    .map(|&corner| {
                        (mesh.positions[corner as usize] * 500.0).round().to_array().map(|at| at as i64)
                    })
                    .collect();
                corners.sort_unstable();
                corners
            })
            .collect();
        triangles.sort_unstable();
        triangles
    };
    let (compressed, plain) = (corners(&of("compressed")), corners(&of("plain")));
    assert_eq!((compressed.len(), plain.len()), (8, 8));
    for (compressed, plain) in compressed.iter().flatten().zip(plain.iter().flatten()) {
        for (a, b) in compressed.iter().zip(plain) {
            assert!((a - b).abs() <= 1, "{compressed:?} in place of {plain:?}");
        }
    }
}

#[cfg(feature = "ktx2")]
use serde_json::json;
use sheer_load::{Loaded, open};

#[cfg(feature = "ktx2")]
use crate::builder::Builder;

/// A file below `assets/gltf`.
pub(crate) fn path(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/gltf")).join(name)
}

fn load(name: &str) -> Loaded {
    open(path(name).to_str().unwrap()).unwrap()
}

/// What a file holds, counted.
#[derive(Debug, PartialEq)]
struct Counts {
    triangles: usize,
    instances: usize,
    materials: usize,
    textures: usize,
    channels: usize,
    skins: usize,
    morph_targets: usize,
    warnings: usize,
}

#[test]
fn the_scenes_of_others_load_with_what_they_hold() {
    let of = |name: &str| {
        let Loaded { scene, warnings, .. } = load(name);
        let parts = scene.parts();
        Counts {
            triangles: parts
                .instances
                .iter()
                .map(|instance| parts.meshes[instance.mesh as usize].indices.len())
                .sum(),
            instances: parts.instances.len(),
            materials: parts.materials.len(),
            textures: parts.textures.len(),
            channels: parts.animations.iter().map(|animation| animation.channels.len()).sum(),
            skins: parts.skins.len(),
            morph_targets: parts.meshes.iter().map(|mesh| mesh.morph_targets.len()).sum(),
            warnings: warnings.len(),
        }
    };
    let plain = Counts {
        triangles: 12,
        instances: 1,
        materials: 1,
        textures: 0,
        channels: 0,
        skins: 0,
        morph_targets: 0,
        warnings: 0,
    };
    assert_eq!(
        of("AnimatedMorphCube-Quantized/AnimatedMorphCube.gltf"),
        Counts { channels: 1, morph_targets: 2, ..plain }
    );
    assert_eq!(
        of("Fox/Fox.gltf"),
        Counts { triangles: 576, textures: 1, channels: 21, skins: 1, warnings: 2, ..plain }
    );
    // Seven points of eight triangles; six, seven and six lines of six; beside them a material of their own.
    let modes = of("MeshPrimitiveModes/MeshPrimitiveModes.gltf");
    assert_eq!(modes, Counts { triangles: 16 + 56 + 36 + 42 + 36, instances: 7, materials: 2, ..plain });
    assert_eq!(of("MultiUVTest/MultiUVTest.gltf"), Counts { textures: 2, ..plain });
    assert_eq!(
        of("SimpleInstancing/SimpleInstancing.gltf"),
        Counts { triangles: 1500, instances: 125, ..plain }
    );
    assert_eq!(of("SimpleSparseAccessor/SimpleSparseAccessor.gltf"), plain);
    assert_eq!(of("TriangleWithoutIndices/TriangleWithoutIndices.gltf"), Counts { triangles: 1, ..plain });
    assert_eq!(of("pirate-meshopt/pirate.glb"), Counts { triangles: 5010, ..plain });
    let colours = of("VertexColorTest/VertexColorTest.gltf");
    assert_eq!(colours, Counts { triangles: 36, instances: 2, materials: 2, textures: 2, ..plain });
    let mirrored = of("NegativeScaleTest/NegativeScaleTest.gltf");
    assert_eq!((mirrored.triangles, mirrored.instances, mirrored.warnings), (7724, 11, 0));
}

#[cfg(feature = "draco")]
#[test]
fn a_draco_mesh_decodes_to_a_closed_shape_with_matching_morph_targets() {
    let loaded = load("MorphPrimitivesTest-Draco/MorphPrimitivesTest.gltf");
    let parts = loaded.scene.parts();
    assert_eq!(parts.meshes.iter().map(|mesh| mesh.indices.len()).collect::<Vec<_>>(), [24, 8]);
    for mesh in &parts.meshes {
        assert_eq!(mesh.morph_targets[0].positions.len(), mesh.positions.len());
        // The test asset's cloth is one unit wide.
        assert!(
            mesh.positions.iter().all(|position| position.abs().max_element() < 1.0),
            "{:?}",
            mesh.positions
        );
        assert!(mesh.normals.iter().all(|normal| normal.is_normalized()));
        assert!(
            mesh.uv_sets[0].iter().all(|uv| (-0.01..=1.01).contains(&uv.x) && (-0.01..=1.01).contains(&uv.y))
        );
    }
}

#[cfg(feature = "ktx2")]
#[test]
fn basis_textures_decode_to_their_colours() {
    let loaded = load("TextureVariants-Embedded-KTX/TextureVariants-Embedded-KTX.gltf");
    let texels: Vec<_> =
        loaded.scene.parts().textures.iter().map(|texture| texture.image.as_slice().to_vec()).collect();
    // Both materials show the same cyan square.
    assert_eq!(texels, vec![vec![[0, 255, 255, 255]; 16]; 2]);
}

#[cfg(feature = "ktx2")]
#[test]
fn both_codecs_of_basis_universal_give_back_a_gradient() {
    // ETC1S keeps four texels to a colour line; UASTC is close to what went in.
    for (name, mean_error) in [("gradient-etc1s.ktx2", 12.0), ("gradient-uastc.ktx2", 2.0)] {
        let mut builder = Builder::triangle();
        let view = builder.view(&std::fs::read(path("basis").join(name)).unwrap());
        builder.json["images"] = json!([{"bufferView": view, "mimeType": "image/ktx2"}]);
        builder.json["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
        builder.material(json!({"emissiveTexture": {"index": 0}}));
        let loaded = builder.load().unwrap();
        let image = &loaded.scene.parts().textures[0].image;
        assert_eq!(image.size(), (16, 16));
        let mut error = 0.0;
        for y in 0..16_u32 {
            for x in 0..16_u32 {
                let expected = [16 * x, 16 * y, 128, 255 - 8 * x];
                let difference = |channel: usize| image[(x, y)][channel].abs_diff(expected[channel] as u8);
                error += (0..4).map(|channel| f64::from(difference(channel))).sum::<f64>() / 1024.0;
            }
        }
        assert!(error < mean_error, "{name}: {error}");
    }
}

#[test]
fn a_meshopt_mesh_has_vertices_where_its_triangles_are() {
    let loaded = load("pirate-meshopt/pirate.glb");
    let (centre, radius) = loaded.scene.bounding_sphere();
    // The figure is about two units tall and stands on the ground.
    assert!((centre.y - 0.95).abs() < 0.05 && (radius - 1.24).abs() < 0.05, "{centre} {radius}");
    let mesh = &loaded.scene.parts().meshes[0];
    let used: std::collections::HashSet<_> = mesh.indices.iter().flatten().collect();
    assert_eq!(used.len(), mesh.positions.len());
}

#[test]
fn instanced_copies_have_their_own_ids() {
    let loaded = load("SimpleInstancing/SimpleInstancing.gltf");
    let ids: std::collections::HashSet<_> =
        loaded.scene.parts().instances.iter().map(|instance| instance.id).collect();
    assert_eq!(ids.len(), 125);
}
