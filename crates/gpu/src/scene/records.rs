//! The records that shaders read, made from what the scene holds.

use bytemuck::Zeroable as _;
use glam::{Mat3, Vec3};
use sheer_scene::{
    FrameLight, Look, MorphedAttributes, Object as FrameObject,
    environment::Lobe as EnvironmentLobe,
    model::{LightKind, Material as SceneMaterial, Mesh, Texture as SceneTexture, TextureRef},
};

use super::atlas::{Atlas, Region};
use crate::shader::record::scene::{
    LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, LOOK_DEFORMED, LOOK_QUAD, LOOK_RIGID, Light, Lobe, Material,
    MeshOffsets, NONE, Object, TEXTURE_BASE_COLOUR, TEXTURE_COUNT, TEXTURE_EMISSIVE,
    TEXTURE_METALLIC_ROUGHNESS, TEXTURE_NORMAL, TEXTURE_OCCLUSION, TEXTURE_THICKNESS, Texture, TextureUse,
};

impl MeshOffsets {
    /// The offsets of a quad, which has no mesh.
    const NOWHERE: Self = Self {
        first_index: 0,
        vertex_count: 0,
        positions: NONE,
        normals: NONE,
        tangents: NONE,
        colours: NONE,
        uv_sets: 0,
        uv_set_count: 0,
    };

    /// Appends a mesh's lists to the buffers' contents.
    pub(crate) fn append(mesh: &Mesh, attributes: &mut Vec<f32>, indices: &mut Vec<u32>) -> Self {
        let first_index = indices.len() as u32;
        indices.extend(mesh.indices.as_flattened());
        let mut list = |floats: &[f32]| {
            let offset = attributes.len() as u32;
            attributes.extend_from_slice(floats);
            if floats.is_empty() { NONE } else { offset }
        };
        let offsets = Self {
            first_index,
            vertex_count: mesh.positions.len() as u32,
            positions: list(bytemuck::cast_slice(&mesh.positions)),
            normals: list(bytemuck::cast_slice(&mesh.normals)),
            tangents: list(bytemuck::cast_slice(&mesh.tangents)),
            colours: list(bytemuck::cast_slice(&mesh.colours)),
            uv_sets: attributes.len() as u32,
            uv_set_count: mesh.uv_sets.len() as u32,
        };
        mesh.uv_sets.iter().for_each(|set| attributes.extend_from_slice(bytemuck::cast_slice(set)));
        offsets
    }
}

/// Where the attributes lie that a morphed mesh does not have from itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct MorphedOffsets {
    colours: Option<u32>,
    uv_sets: Option<u32>,
}

impl MorphedOffsets {
    /// Appends the lists to the buffer's contents.
    pub(super) fn append(lists: &MorphedAttributes, attributes: &mut Vec<f32>) -> Self {
        let colours = (!lists.colours.is_empty()).then_some(attributes.len() as u32);
        attributes.extend_from_slice(bytemuck::cast_slice(&lists.colours));
        let uv_sets = (!lists.uv_sets.is_empty()).then_some(attributes.len() as u32);
        lists.uv_sets.iter().for_each(|set| attributes.extend_from_slice(bytemuck::cast_slice(set)));
        Self { colours, uv_sets }
    }

    fn of(self, mesh: MeshOffsets) -> MeshOffsets {
        MeshOffsets {
            colours: self.colours.unwrap_or(mesh.colours),
            uv_sets: self.uv_sets.unwrap_or(mesh.uv_sets),
            ..mesh
        }
    }
}

impl Object {
    pub(super) fn new(object: &FrameObject, meshes: &[MeshOffsets], morphed: &[MorphedOffsets]) -> Self {
        let mut record = Self {
            id: object.id,
            geometry: object.geometry,
            material: object.material,
            first_triangle: object.first_triangle,
            look: LOOK_QUAD,
            first_deformed_normal: NONE,
            mesh: MeshOffsets::NOWHERE,
            axes: [0.0; 18],
        };
        match *object.look() {
            Look::Rigid { mesh, normal_from_object, vector_from_object } => {
                record.look = LOOK_RIGID;
                record.mesh = meshes[mesh as usize];
                let columns = |matrix: &Mat3| matrix.to_cols_array();
                record.axes[..9].copy_from_slice(&columns(&normal_from_object));
                record.axes[9..].copy_from_slice(&columns(&vector_from_object));
            }
            Look::Deformed { mesh, first_normal, attributes } => {
                record.look = LOOK_DEFORMED;
                record.mesh = meshes[mesh as usize];
                if let Some(index) = attributes {
                    record.mesh = morphed[index as usize].of(record.mesh);
                }
                record.first_deformed_normal = first_normal.unwrap_or(NONE);
            }
            Look::Quad { right, up, tile_origin, tile_size, tint } => {
                record.axes[..3].copy_from_slice(&right.to_array());
                record.axes[3..6].copy_from_slice(&up.to_array());
                record.axes[6..8].copy_from_slice(&tile_origin.to_array());
                record.axes[8..10].copy_from_slice(&tile_size.to_array());
                record.axes[10..13].copy_from_slice(&tint.to_array());
            }
        }
        record
    }
}

impl TextureUse {
    fn new(used: Option<&TextureRef>) -> Self {
        let of = |used: &TextureRef| Self {
            x_axis: used.transform.matrix2.x_axis,
            y_axis: used.transform.matrix2.y_axis,
            translation: used.transform.translation,
            texture: used.texture,
            uv_set: used.uv_set,
        };
        used.map_or(Self { texture: NONE, ..Self::zeroed() }, of)
    }
}

impl Material {
    pub(crate) fn new(material: &SceneMaterial) -> Self {
        let mut textures = [None; TEXTURE_COUNT];
        textures[TEXTURE_BASE_COLOUR] = material.base_colour_texture;
        textures[TEXTURE_METALLIC_ROUGHNESS] = material.metallic_roughness_texture;
        textures[TEXTURE_EMISSIVE] = material.emissive_texture;
        textures[TEXTURE_OCCLUSION] = material.occlusion_texture;
        textures[TEXTURE_NORMAL] = material.normal_texture;
        textures[TEXTURE_THICKNESS] = material.thickness_texture;
        Self {
            base_colour: material.base_colour.truncate(),
            model: material.model as u32,
            emissive: material.emissive,
            metallic: material.metallic,
            roughness: material.roughness,
            transmission: material.transmission,
            normal_scale: material.normal_scale,
            occlusion_strength: material.occlusion_strength,
            absorption: material.absorption,
            thickness: if material.absorption == Vec3::ZERO { 0.0 } else { material.thickness },
            textures: textures.map(|used| TextureUse::new(used.as_ref())),
        }
    }
}

impl Texture {
    /// Records of all textures, then of their levels.
    pub(crate) fn all(textures: &[SceneTexture], atlas: &Atlas) -> Vec<Self> {
        let place = |region: &Region| Self {
            origin: region.origin.into(),
            size: region.size.into(),
            layer: region.layer,
            ..Self::zeroed()
        };
        let mut levels = Vec::new();
        let mut first_levels = vec![0; textures.len()];
        for &index in &atlas.stored {
            first_levels[index] = (textures.len() + levels.len()) as u32;
            levels.extend(atlas.regions[index][1..].iter().map(place));
        }
        let record = |(index, texture): (usize, &SceneTexture)| Self {
            wrap: texture.wrap.map(|wrap| wrap as u32).into(),
            filtering: texture.filter as u32,
            srgb: u32::from(texture.srgb),
            minified_filtering: texture.minification.filter as u32,
            level_filtering: texture.minification.levels as u32,
            first_level: first_levels[atlas.owners[index]],
            last_level: atlas.regions[index].len() as u32 - 1,
            ..place(&atlas.regions[index][0])
        };
        textures.iter().enumerate().map(record).chain(levels).collect()
    }
}

impl Light {
    pub(crate) fn new(light: &FrameLight) -> Self {
        let (kind, range, cone_rad) = match light.kind {
            LightKind::Directional => (LIGHT_DIRECTIONAL, f32::MAX, [0.0; 2]),
            LightKind::Point { range } => (LIGHT_POINT, range, [0.0; 2]),
            LightKind::Spot { range, inner_cone_rad, outer_cone_rad } => {
                (LIGHT_SPOT, range, [inner_cone_rad, outer_cone_rad])
            }
        };
        let [inner_cosine, outer_cosine] = cone_rad.map(f32::cos);
        Self {
            position: light.position,
            kind,
            direction: light.direction,
            range: range.min(f32::MAX),
            intensity: light.intensity,
            inner_cosine,
            outer_cosine,
            padding: [0; 3],
        }
    }
}

impl Lobe {
    pub(crate) fn new(lobe: &EnvironmentLobe) -> Self {
        Self { direction: lobe.direction, sharpness: lobe.sharpness, radiance: lobe.radiance, padding: 0 }
    }
}
