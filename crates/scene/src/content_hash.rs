//! A number that tells scenes apart by all that they hold.

use std::fmt::{self, Write as _};

use rayon::prelude::*;
use sheer_core::hash::Fnv1a;

use crate::model::{Mesh, MorphTarget, SceneParts, Texture};

/// What has been hashed of a part.
struct PartHash(Fnv1a);

impl PartHash {
    fn new() -> Self {
        Self(Fnv1a::EMPTY)
    }

    /// A list with its length in front, so that no value can move from the end of one list to the start of
    /// the next unnoticed.
    fn add_list<const N: usize>(&mut self, length: usize, values: impl Iterator<Item = [u8; N]>) {
        self.0.add((length as u64).to_le_bytes());
        self.0.add(values.flatten());
    }

    /// Numbers of vectors, one after the other.
    fn add_vectors<const N: usize>(&mut self, vectors: impl ExactSizeIterator<Item = [f32; N]>) {
        self.add_list(vectors.len(), vectors.flatten().map(f32::to_le_bytes));
    }

    /// Small things by what `Debug` prints of them: names every field, and floats with as many digits as read
    /// back the same bits.
    fn add_described(&mut self, described: &impl fmt::Debug) {
        write!(self, "{described:?};").expect("what is written to it is only added up");
    }
}

impl fmt::Write for PartHash {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.add(text.bytes());
        Ok(())
    }
}

/// The hash of all parts but the scene's own name: a copy of a file shows the same. Each part is taken apart
/// by a pattern that names all of its fields, so that a new one cannot be forgotten.
pub(crate) fn of_parts(parts: &SceneParts) -> u64 {
    let SceneParts {
        name: _,
        nodes,
        meshes,
        instances,
        skins,
        materials,
        textures,
        animations,
        particles,
        lights,
        environment,
        cameras,
        exposure,
    } = parts;
    let mut hash = PartHash::new();
    hash.add_described(&(nodes, instances, skins, materials, animations));
    hash.add_described(&(particles, lights, environment, cameras, exposure));
    // Vertices and texels are nearly all of the bytes, and each mesh and image is hashed by itself, so that
    // they can be all at once.
    for part in meshes.par_iter().map(of_mesh).collect::<Vec<_>>() {
        hash.0.add(part.to_le_bytes());
    }
    for part in textures.par_iter().map(of_texture).collect::<Vec<_>>() {
        hash.0.add(part.to_le_bytes());
    }
    hash.0.value()
}

fn of_mesh(mesh: &Mesh) -> u64 {
    let Mesh {
        name,
        material,
        positions,
        normals,
        tangents,
        uv_sets,
        colours,
        indices,
        influences,
        influences_per_vertex,
        morph_targets,
    } = mesh;
    let mut hash = PartHash::new();
    hash.add_described(&(name, material, influences_per_vertex, uv_sets.len(), morph_targets.len()));
    hash.add_vectors(positions.iter().map(|position| position.to_array()));
    hash.add_vectors(normals.iter().map(|normal| normal.to_array()));
    hash.add_vectors(tangents.iter().map(|tangent| tangent.to_array()));
    for set in uv_sets {
        hash.add_vectors(set.iter().map(|uv| uv.to_array()));
    }
    hash.add_vectors(colours.iter().map(|colour| colour.to_array()));
    hash.add_list(indices.len(), indices.as_flattened().iter().map(|index| index.to_le_bytes()));
    hash.add_list(influences.len(), influences.iter().map(|influence| influence.joint.to_le_bytes()));
    hash.add_list(influences.len(), influences.iter().map(|influence| influence.weight.to_le_bytes()));
    for MorphTarget { positions, normals, tangents, colours, uv_sets } in morph_targets {
        hash.add_vectors(positions.iter().map(|offset| offset.to_array()));
        hash.add_vectors(normals.iter().map(|offset| offset.to_array()));
        hash.add_vectors(tangents.iter().map(|offset| offset.to_array()));
        hash.add_vectors(colours.iter().map(|offset| offset.to_array()));
        hash.add_described(&uv_sets.len());
        for set in uv_sets {
            hash.add_vectors(set.iter().map(|offset| offset.to_array()));
        }
    }
    hash.0.value()
}

fn of_texture(texture: &Texture) -> u64 {
    let Texture { name, image, srgb, wrap, filter, minification } = texture;
    let mut hash = PartHash::new();
    hash.add_described(&(name, image.size(), srgb, wrap, filter, minification));
    hash.0.add(image.as_slice().as_flattened().iter().copied());
    hash.0.value()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
    use sheer_core::hash::fnv1a;
    use sheer_image::Image;

    use super::*;
    use crate::{
        camera::Camera,
        environment::Lobe,
        model::{
            AlphaMode, Animation, Channel, Filter, Influence, Instance, Interpolation, Keys, LevelFilter,
            Light, LightKind, Material, Minification, Node, Property, Skin, TextureRef, Track, Transform,
            Wrap,
        },
        particle::{Particle, ParticleSystem, Turbulence},
    };

    /// Something of everything.
    fn parts() -> SceneParts {
        let mesh = Mesh {
            name: "mesh".to_owned(),
            material: 0,
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
            uv_sets: vec![vec![Vec2::ZERO, Vec2::X, Vec2::Y], vec![Vec2::ONE; 3]],
            colours: vec![Vec4::ONE; 3],
            indices: vec![[0, 1, 2]],
            influences: vec![Influence { joint: 0, weight: 0.25 }; 12],
            influences_per_vertex: 4,
            morph_targets: vec![MorphTarget {
                positions: vec![Vec3::Z; 3],
                normals: vec![Vec3::X; 3],
                tangents: vec![Vec3::Y; 3],
                colours: vec![Vec4::X; 3],
                uv_sets: vec![vec![Vec2::X; 3]],
            }],
        };
        let particle = Particle {
            birth_secs: 0.0,
            lifetime_secs: 2.0,
            origin: Vec3::ZERO,
            velocity: Vec3::Y,
            acceleration: Vec3::ZERO,
            half_size: [0.1, 0.2],
            rotation_rad: 0.0,
            spin_rad_per_sec: 0.0,
            alpha: 0.5,
            tint: Vec3::ONE,
            tile: 0,
        };
        let texture = Texture {
            name: "texture".to_owned(),
            image: Arc::new(Image::filled(2, 2, [10, 20, 30, 40]).unwrap()),
            srgb: true,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
            minification: Minification::default(),
        };
        let keys = Keys {
            times_secs: vec![0.0, 1.0],
            values: vec![Vec3::ZERO, Vec3::ONE],
            interpolation: Interpolation::Linear,
        };
        SceneParts {
            name: "everything".to_owned(),
            nodes: vec![Node { name: String::new(), parent: None, transform: Transform::IDENTITY }],
            meshes: vec![mesh],
            instances: vec![Instance {
                node: 0,
                node_from_object: Affine3A::IDENTITY,
                mesh: 0,
                id: 0,
                geometry: 0,
                skin: Some(0),
                morph_weights: vec![0.5],
            }],
            skins: vec![Skin {
                name: String::new(),
                joints: vec![0],
                inverse_bind: vec![Affine3A::IDENTITY],
            }],
            materials: vec![Material {
                base_colour_texture: Some(TextureRef::new(0)),
                ..Material::default()
            }],
            textures: vec![texture],
            animations: vec![Animation {
                name: String::new(),
                channels: vec![Channel { node: 0, track: Track::Translation(keys) }],
                properties: vec![Property::BaseColour { material: 0, factor: Keys::constant(Vec4::ONE) }],
            }],
            particles: vec![ParticleSystem {
                name: String::new(),
                material: 0,
                atlas: [1, 1],
                particles: vec![particle],
                loop_secs: Some(3.0),
                turbulence: Turbulence::default(),
                fade: [0.1, 0.2],
                near_fade: [0.0; 2],
            }],
            lights: vec![Light {
                name: String::new(),
                node: 0,
                intensity: Vec3::ONE,
                kind: LightKind::Directional,
            }],
            cameras: vec![Camera::fixed("static", 0.6, Vec3::Z, Vec3::ZERO)],
            exposure: 1.0,
            ..SceneParts::default()
        }
    }

    /// What stood in reports before: it left out most of a mesh, how textures are looked up, and the
    /// exposure.
    fn blind(parts: &SceneParts) -> u64 {
        let described = format!(
            "{:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
            parts.nodes,
            parts.materials,
            parts.instances,
            parts.skins,
            parts.animations,
            parts.particles,
            parts.cameras,
            parts.lights,
            parts.environment,
        );
        let vertices = parts.meshes.iter().flat_map(|mesh| &mesh.positions).flat_map(|at| at.to_array());
        let texels = parts.textures.iter().flat_map(|texture| texture.image.as_slice().as_flattened());
        let bytes = described.into_bytes().into_iter();
        fnv1a(bytes.chain(vertices.flat_map(f32::to_le_bytes)).chain(texels.copied()))
    }

    /// A change by the least that a float can change, or by one.
    type Change = (&'static str, fn(&mut SceneParts));

    /// What the hash used to see.
    const SEEN: &[Change] = &[
        ("position", |parts| parts.meshes[0].positions[2].z = f32::MIN_POSITIVE),
        ("texel", |parts| {
            parts.textures[0].image = Arc::new(Image::filled(2, 2, [10, 20, 31, 40]).unwrap());
        }),
        ("node", |parts| parts.nodes[0].transform = Transform::from_translation(Vec3::X)),
        ("instance", |parts| parts.instances[0].id = 1),
        ("weight at rest", |parts| parts.instances[0].morph_weights[0] = 0.5_f32.next_up()),
        ("skin", |parts| parts.skins[0].inverse_bind[0].translation.x = 1.0),
        ("material", |parts| parts.materials[0].alpha_mode = AlphaMode::Blend),
        ("roughness", |parts| parts.materials[0].roughness = 1.0_f32.next_down()),
        ("animation", |parts| {
            let keys = Keys {
                times_secs: vec![0.0],
                values: vec![Quat::IDENTITY],
                interpolation: Interpolation::Step,
            };
            parts.animations[0].channels[0].track = Track::Rotation(keys);
        }),
        ("animated property", |parts| {
            let factor = Keys::constant(Vec4::ZERO);
            parts.animations[0].properties[0] = Property::BaseColour { material: 0, factor };
        }),
        ("particle", |parts| parts.particles[0].particles[0].alpha = 0.5_f32.next_up()),
        ("light", |parts| parts.lights[0].intensity.y = 2.0),
        ("environment", |parts| {
            parts.environment.lobes.push(Lobe { direction: Vec3::Y, radiance: Vec3::ONE, sharpness: 4.0 });
        }),
        ("camera", |parts| parts.cameras[0] = Camera::fixed("static", 0.7, Vec3::Z, Vec3::ZERO)),
    ];
    /// What it did not.
    const UNSEEN: &[Change] = &[
        ("index", |parts| parts.meshes[0].indices[0] = [0, 2, 1]),
        ("one triangle more", |parts| parts.meshes[0].indices.push([0, 1, 2])),
        ("normal", |parts| parts.meshes[0].normals[1].x = 0.1),
        ("no normals", |parts| parts.meshes[0].normals.clear()),
        ("tangent", |parts| parts.meshes[0].tangents[1].w = -1.0),
        ("texture coordinate", |parts| parts.meshes[0].uv_sets[0][2].x = f32::MIN_POSITIVE),
        ("second set of coordinates", |parts| parts.meshes[0].uv_sets[1][2].x = 1.0_f32.next_up()),
        ("sets of coordinates exchanged", |parts| parts.meshes[0].uv_sets.swap(0, 1)),
        ("vertex colour", |parts| parts.meshes[0].colours[0].w = 0.5),
        ("joint", |parts| parts.meshes[0].influences[5].joint = 1),
        ("weight of a joint", |parts| parts.meshes[0].influences[5].weight = 0.25_f32.next_up()),
        ("morph displacement", |parts| parts.meshes[0].morph_targets[0].positions[0].x = 0.1),
        ("morphed colour", |parts| parts.meshes[0].morph_targets[0].colours[0].w = 0.1),
        ("morphed texture coordinate", |parts| parts.meshes[0].morph_targets[0].uv_sets[0][0].y = 0.1),
        ("morphed normal", |parts| parts.meshes[0].morph_targets[0].normals[0].y = 0.1),
        ("morphed tangent", |parts| parts.meshes[0].morph_targets[0].tangents[0].x = 0.1),
        ("displacements taken for normals", |parts| {
            let target = &mut parts.meshes[0].morph_targets[0];
            std::mem::swap(&mut target.positions, &mut target.normals);
        }),
        ("material of a mesh", |parts| parts.meshes[0].material = 1),
        ("colour space of a texture", |parts| parts.textures[0].srgb = false),
        ("wrapping", |parts| parts.textures[0].wrap[1] = Wrap::ClampToEdge),
        ("filter", |parts| parts.textures[0].filter = Filter::Nearest),
        ("filter of minified texels", |parts| parts.textures[0].minification.filter = Filter::Nearest),
        ("filter of levels", |parts| parts.textures[0].minification.levels = LevelFilter::Nearest),
        ("shape of an image", |parts| {
            parts.textures[0].image = Arc::new(Image::filled(4, 1, [10, 20, 30, 40]).unwrap());
        }),
        ("exposure", |parts| parts.exposure = 1.0_f32.next_up()),
    ];

    #[test]
    fn a_change_of_any_part_is_another_hash() {
        let whole = parts();
        for (name, change) in SEEN.iter().chain(UNSEEN) {
            let mut changed = parts();
            change(&mut changed);
            assert_ne!(of_parts(&changed), of_parts(&whole), "{name}");
        }
        assert_eq!(of_parts(&parts()), of_parts(&whole));
        assert_eq!(of_parts(&SceneParts { name: "a copy".to_owned(), ..parts() }), of_parts(&whole));
    }

    #[test]
    fn a_hash_of_positions_and_texels_alone_misses_what_this_one_is_for() {
        let whole = parts();
        let differs = |(_, change): &Change| {
            let mut changed = parts();
            change(&mut changed);
            blind(&changed) != blind(&whole)
        };
        assert!(SEEN.iter().all(differs));
        assert!(!UNSEEN.iter().any(differs));
    }
}
