//! All textures of a scene, with their levels, in the layers of one array texture.
//!
//! Shaders then reach every texture by arithmetic, without the binding arrays that many adapters lack. Texels
//! are read one by one and weighted in the shader, so that neighbours need no gap between them.

use std::{collections::HashMap, iter::zip, sync::Arc};

use etagere::{AtlasAllocator, size2};
use sheer_scene::{MipChain, Scene, model::Texture};

use crate::error::GpuError;

/// Least side of a layer: small textures share a few layers instead of taking one each.
const LEAST_SIDE: u32 = 1024;

/// Where an image lies in the atlas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Region {
    /// Index of the layer of the array texture.
    pub(crate) layer: u32,
    /// Column and row of the upper left texel in the layer.
    pub(crate) origin: [u32; 2],
    /// Width and height, texels.
    pub(crate) size: [u32; 2],
}

/// An arrangement of textures.
#[derive(Debug)]
pub(crate) struct Atlas {
    /// Width and height of the layers, texels; 1 if there is no texture.
    pub(crate) side: u32,
    /// How many layers, at least 1.
    pub(crate) layers: u32,
    /// Of each texture the image, then its levels; textures that share levels share regions.
    pub(crate) regions: Vec<Vec<Region>>,
    /// Of each texture the first one that has the same levels.
    pub(crate) owners: Vec<usize>,
    /// The textures that are their own owners.
    pub(crate) stored: Vec<usize>,
}

/// Images of a texture that stand one below the other: the texture's own alone, or all levels after it.
struct Column {
    texture: usize,
    /// Index of the first among the levels.
    first: usize,
    sizes: Vec<[u32; 2]>,
}

impl Column {
    /// The two of a texture; the second is empty where there are no levels.
    fn of(texture: usize, chain: &MipChain) -> [Self; 2] {
        let mut sizes: Vec<[u32; 2]> = chain.images().map(|image| image.size().into()).collect();
        let levels = sizes.split_off(1);
        [Self { texture, first: 0, sizes }, Self { texture, first: 1, sizes: levels }]
    }

    /// Height and width of all together: the first is the widest.
    fn extent(&self) -> (u32, u32) {
        let height = self.sizes.iter().map(|[_, height]| height).sum();
        (height, self.sizes.first().map_or(0, |[width, _]| *width))
    }
}

impl Atlas {
    /// Finds a region for each image and each level, as few layers as shelves of them need.
    ///
    /// # Errors
    /// [`GpuError::Limit`] names the texture that is too large or for which no layer is left.
    pub(crate) fn new(scene: &Scene, limits: &wgpu::Limits) -> Result<Self, GpuError> {
        let textures = &scene.parts().textures;
        let longest = |texture: &Texture| texture.image.width().max(texture.image.height());
        let most = limits.max_texture_dimension_2d;
        for texture in textures {
            if longest(texture) > most {
                return Err(GpuError::Limit {
                    what: format!("the longer side of texture '{}', in texels,", texture.name),
                    needed: longest(texture).into(),
                    limit: most.into(),
                    instead: "scale the texture down or take --backend cpu".to_owned(),
                });
            }
        }
        let Some(largest) = textures.iter().map(longest).max() else {
            return Ok(Self {
                side: 1,
                layers: 1,
                regions: Vec::new(),
                owners: Vec::new(),
                stored: Vec::new(),
            });
        };
        let side = largest.max(LEAST_SIDE).next_power_of_two().min(most);

        // Tall ones first, which packs shelves best; equals in the order of the scene, so that the
        // arrangement is always the same.
        let mut first_with: HashMap<*const MipChain, usize> = HashMap::new();
        let owners: Vec<usize> = scene
            .mip_chains()
            .enumerate()
            .map(|(index, chain)| *first_with.entry(Arc::as_ptr(chain)).or_insert(index))
            .collect();
        let stored: Vec<usize> = (0..textures.len()).filter(|&index| owners[index] == index).collect();
        let chains: Vec<_> = scene.mip_chains().collect();
        let mut columns: Vec<Column> =
            stored.iter().flat_map(|&index| Column::of(index, chains[index])).collect();
        columns.retain(|column| !column.sizes.is_empty());
        columns.sort_by_key(|column| std::cmp::Reverse(column.extent()));

        let mut layers: Vec<AtlasAllocator> = Vec::new();
        let mut regions: Vec<Vec<Region>> =
            chains.iter().map(|chain| vec![Region::default(); chain.images().len()]).collect();
        for column in &columns {
            let Region { layer, origin: [x, mut y], .. } = allocate(&mut layers, side, column.extent());
            if layers.len() as u64 > u64::from(limits.max_texture_array_layers) {
                return Err(GpuError::Limit {
                    what: format!(
                        "the texture atlas, in layers up to texture '{}',",
                        textures[column.texture].name
                    ),
                    needed: layers.len() as u64,
                    limit: limits.max_texture_array_layers.into(),
                    instead: "take smaller or fewer textures, or --backend cpu".to_owned(),
                });
            }
            for (region, &size) in regions[column.texture][column.first..].iter_mut().zip(&column.sizes) {
                *region = Region { layer, origin: [x, y], size };
                y += size[1];
            }
        }
        for (index, &owner) in owners.iter().enumerate() {
            regions[index] = regions[owner].clone();
        }
        Ok(Self { side, layers: layers.len() as u32, regions, owners, stored })
    }

    /// Makes the texture and sends every image.
    pub(crate) fn upload(&self, device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> wgpu::Texture {
        let atlas = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("scene atlas"),
            size: extent(self.side, self.side, self.layers),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let chains: Vec<_> = scene.mip_chains().collect();
        let stored = self.stored.iter().flat_map(|&index| zip(&self.regions[index], chains[index].images()));
        for (&Region { layer, origin: [x, y], size: [width, height] }, image) in stored {
            queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &atlas,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x, y, z: layer },
                    aspect: wgpu::TextureAspect::All,
                },
                image.as_slice().as_flattened(),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * width),
                    rows_per_image: Some(height),
                },
                extent(width, height, 1),
            );
        }
        atlas
    }

    /// Bytes of device memory that the array texture takes: 4 a texel of every layer, filled or not.
    pub(crate) fn bytes(&self) -> u64 {
        4 * u64::from(self.side) * u64::from(self.side) * u64::from(self.layers)
    }
}

fn extent(width: u32, height: u32, depth_or_array_layers: u32) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers }
}

/// A region for a column, by height and width, that fits into an empty layer: in the first layer with room or
/// in a new one.
fn allocate(layers: &mut Vec<AtlasAllocator>, side: u32, (height, width): (u32, u32)) -> Region {
    let size = size2(width as i32, height as i32);
    let found = layers
        .iter_mut()
        .enumerate()
        .find_map(|(layer, allocator)| allocator.allocate(size).map(|allocation| (layer, allocation)));
    let (layer, allocation) = found.unwrap_or_else(|| {
        let mut allocator = AtlasAllocator::new(size2(side as i32, side as i32));
        let allocation = allocator.allocate(size).expect("no column is larger than a layer");
        layers.push(allocator);
        (layers.len() - 1, allocation)
    });
    let corner = allocation.rectangle.min;
    Region { layer: layer as u32, origin: [corner.x as u32, corner.y as u32], size: [width, height] }
}
