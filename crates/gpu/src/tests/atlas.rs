//! The atlas holds every texture once and none over another.

use std::{collections::HashSet, sync::Arc};

use sheer_image::Image;
use sheer_scene::{
    Scene, SceneParts,
    model::{Filter, Minification, Texture, Wrap},
};

use crate::{error::GpuError, scene::atlas::Atlas};

fn atlas(textures: &[Texture], limits: &wgpu::Limits) -> Result<Atlas, GpuError> {
    let parts = SceneParts { textures: textures.to_vec(), exposure: 1.0, ..SceneParts::default() };
    Atlas::new(&Scene::new(parts).unwrap(), limits)
}

fn texture(name: &str, width: u32, height: u32) -> Texture {
    Texture {
        name: name.to_owned(),
        image: Arc::new(Image::filled(width, height, [0; 4]).unwrap()),
        srgb: true,
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Linear,
        minification: Minification::default(),
    }
}

fn limits(side: u32, layers: u32) -> wgpu::Limits {
    wgpu::Limits {
        max_texture_dimension_2d: side,
        max_texture_array_layers: layers,
        ..wgpu::Limits::default()
    }
}

/// Every texel that a texture covers, or the first that another covers already or that lies outside.
fn covered(atlas: &Atlas) -> Result<HashSet<[u32; 3]>, [u32; 3]> {
    let mut covered = HashSet::new();
    for region in atlas.stored.iter().flat_map(|&index| &atlas.regions[index]) {
        let [width, height] = region.size;
        for texel in (0..width * height).map(|at| [at % width, at / width]) {
            let [x, y] = [region.origin[0] + texel[0], region.origin[1] + texel[1]];
            let at = [x, y, region.layer];
            if x >= atlas.side || y >= atlas.side || region.layer >= atlas.layers || !covered.insert(at) {
                return Err(at);
            }
        }
    }
    Ok(covered)
}

fn many() -> Vec<Texture> {
    let sizes = [(1, 1), (3, 700), (1000, 20), (512, 512), (640, 640), (900, 900), (64, 64), (65, 33)];
    (0..24)
        .map(|index| sizes[index % sizes.len()])
        .map(|(width, height)| texture("", width, height))
        .collect()
}

#[test]
fn no_two_textures_overlap_and_none_leaves_its_layer() {
    let textures = many();
    let atlas = atlas(&textures, &limits(16384, 2048)).unwrap();
    assert_eq!(atlas.side, 1024);
    let images = textures.iter().map(|texture| texture.image.size());
    let levels = images.flat_map(|(width, height)| {
        (0..=width.max(height).ilog2()).map(move |level| [width, height].map(|side| (side >> level).max(1)))
    });
    let texels: u32 = levels.map(|[width, height]| width * height).sum();
    assert_eq!(covered(&atlas).unwrap().len() as u32, texels);
    assert!(atlas.layers < 12, "{} layers", atlas.layers);
}

#[test]
fn an_overlap_would_be_noticed() {
    let textures = many();
    let mut atlas = atlas(&textures, &limits(16384, 2048)).unwrap();
    let first = atlas.regions[atlas.stored[0]].clone();
    atlas.regions[atlas.stored[1]] = first;
    assert!(covered(&atlas).is_err());
}

#[test]
fn textures_that_share_an_image_are_stored_once() {
    let mut textures = vec![texture("a", 8, 8), texture("b", 8, 8), texture("c", 4, 4)];
    textures[2].image = Arc::clone(&textures[0].image);
    let atlas = atlas(&textures, &limits(16384, 2048)).unwrap();
    assert_eq!(atlas.stored.len(), 2);
    assert_eq!(atlas.regions[2], atlas.regions[0]);
    assert_ne!(atlas.regions[1], atlas.regions[0]);
}

#[test]
fn layers_are_as_large_as_the_largest_texture_asks_and_the_device_allows() {
    let side = |width, most| atlas(&[texture("", width, 7)], &limits(most, 4)).unwrap().side;
    assert_eq!(side(5, 16384), 1024);
    assert_eq!(side(1024, 16384), 1024);
    assert_eq!(side(1025, 16384), 2048);
    assert_eq!(side(1025, 1500), 1500);
    let empty = atlas(&[], &limits(16384, 4)).unwrap();
    assert_eq!((empty.side, empty.layers), (1, 1));
}

#[test]
fn a_texture_that_is_too_much_is_named_with_what_to_do() {
    let wide = atlas(&[texture("small", 8, 8), texture("wide", 3000, 8)], &limits(2048, 4)).unwrap_err();
    assert!(matches!(wide, GpuError::Limit { needed: 3000, limit: 2048, .. }), "{wide}");
    assert!(wide.to_string().contains("'wide'") && wide.to_string().contains("--backend cpu"), "{wide}");
    let full: Vec<_> = ["a", "b", "c"].map(|name| texture(name, 1024, 1024)).into();
    let many = atlas(&full, &limits(2048, 2)).unwrap_err();
    assert!(matches!(many, GpuError::Limit { needed: 3, limit: 2, .. }), "{many}");
    assert!(many.to_string().contains("'c'"), "{many}");
}
