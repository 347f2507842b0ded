//! The hierarchy: nodes in order, and what hangs on them.

use std::collections::{HashMap, HashSet};

use glam::{Affine3A, Mat4, Quat, Vec3};

use super::{
    document::{Document, named},
    limits::MAX_DRAWN_TRIANGLES,
    material::Materials,
    mesh,
    schema::{self, Index},
};
use crate::{
    SceneError,
    camera::{Camera, CameraMotion, Lens},
    model::{Instance, Light, LightKind, Node, SceneParts, Skin, Transform},
};

/// Nodes sorted so that a parent stands before its children, with a way from the file's indices to the sorted
/// ones.
pub(super) struct Hierarchy {
    /// File index of each sorted node.
    order: Vec<Index>,
    /// Sorted index of each node of the file.
    sorted: Vec<u32>,
    /// Sorted index of the parent of each sorted node.
    parents: Vec<Option<u32>>,
    /// Whether each sorted node belongs to the scene shown, and is not hidden.
    shown: Vec<bool>,
}

/// A node in messages.
pub(super) fn place(document: &Document<'_>, index: Index) -> String {
    named("node", index, document.root.nodes.get(index).and_then(|node| node.name.as_deref()))
}

impl Hierarchy {
    pub(super) fn build(document: &Document<'_>) -> Result<Self, SceneError> {
        let nodes = &document.root.nodes;

        // Each node has at most one parent.
        let mut parent_of: Vec<Option<Index>> = vec![None; nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            for &child in &node.children {
                document.get(nodes, child, "node", &place(document, index))?;
                if let Some(other) = parent_of[child].replace(index) {
                    let problem = format!(
                        "it is a child of both node {other} and node {index}; a node has one parent, export the file again"
                    );
                    return Err(document.fault(place(document, child), problem));
                }
            }
        }

        // Breadth first from the roots; what is not reached hangs on itself.
        let mut order: Vec<Index> = (0..nodes.len()).filter(|&index| parent_of[index].is_none()).collect();
        let mut sorted = vec![u32::MAX; nodes.len()];
        let mut at = 0;
        while let Some(&index) = order.get(at) {
            sorted[index] = at as u32;
            order.extend(&nodes[index].children);
            at += 1;
        }
        if let Some(index) = sorted.iter().position(|&at| at == u32::MAX) {
            let problem = "it is its own ancestor; break the cycle and export the file again";
            return Err(document.fault(place(document, index), problem));
        }
        let parents: Vec<Option<u32>> =
            order.iter().map(|&index| parent_of[index].map(|parent| sorted[parent])).collect();

        // The scene shown; a file without scenes shows all it has.
        let scenes = &document.root.scenes;
        let scene = match document.root.scene {
            Some(index) => Some(document.get(scenes, index, "scene", "scene")?),
            None => scenes.first(),
        };
        let mut shown: Vec<bool> = parents.iter().map(|parent| scene.is_none() && parent.is_none()).collect();
        for &root in scene.map_or(&[][..], |scene| &scene.nodes) {
            document.get(nodes, root, "node", "scene")?;
            shown[sorted[root] as usize] = true;
        }
        for (at, &index) in order.iter().enumerate() {
            let inherited = parents[at].is_some_and(|parent| shown[parent as usize]);
            shown[at] = (shown[at] || inherited) && nodes[index].extensions.visibility.visible;
        }
        Ok(Self { order, sorted, parents, shown })
    }

    /// Sorted index of a node of the file.
    pub(super) fn sorted(
        &self,
        document: &Document<'_>,
        index: Index,
        place: &str,
    ) -> Result<u32, SceneError> {
        document.get(&self.sorted, index, "node", place).copied()
    }

    pub(super) fn nodes(&self, document: &Document<'_>) -> Result<Vec<Node>, SceneError> {
        let mut nodes = Vec::with_capacity(self.order.len());
        for (&index, &parent) in self.order.iter().zip(&self.parents) {
            let node = &document.root.nodes[index];
            let transform = transform(document, node, &place(document, index))?;
            nodes.push(Node { name: node.name.clone().unwrap_or_default(), parent, transform });
        }
        Ok(nodes)
    }

    /// The nodes shown, with their sorted index and file index.
    fn shown<'a>(
        &'a self,
        document: &'a Document<'_>,
    ) -> impl Iterator<Item = (u32, Index, &'a schema::Node)> {
        let nodes = self.order.iter().enumerate().filter(|(at, _)| self.shown[*at]);
        nodes.map(|(at, &index)| (at as u32, index, &document.root.nodes[index]))
    }

    pub(super) fn cameras(&self, document: &Document<'_>) -> Result<Vec<Camera>, SceneError> {
        let mut hung: Vec<_> = self
            .shown(document)
            .filter_map(|(at, index, node)| node.camera.map(|camera| (camera, index, at)))
            .collect();
        hung.sort_unstable();
        let mut cameras = Vec::new();
        let mut names = Names::default();
        for (camera, node, at) in hung {
            let described = document.get(&document.root.cameras, camera, "camera", &place(document, node))?;
            let camera_place = named("camera", camera, described.name.as_deref());
            let fault = |problem: &str| {
                document.fault(&camera_place, format!("{problem}; set it and export the file again"))
            };
            let lens = match (&described.perspective, &described.orthographic) {
                (Some(lens), _) => {
                    let valid = lens.yfov > 0.0 && lens.yfov < std::f32::consts::PI;
                    valid
                        .then_some(Lens::Perspective { yfov_rad: lens.yfov })
                        .ok_or_else(|| fault("yfov is not between 0 and π"))?
                }
                (None, Some(lens)) => {
                    // A negative magnification mirrors; its size is what is meant.
                    let half_height = lens.ymag.abs();
                    let valid = half_height > 0.0 && half_height.is_finite();
                    valid
                        .then_some(Lens::Orthographic { half_height })
                        .ok_or_else(|| fault("ymag is zero"))?
                }
                (None, None) => return Err(fault("it is neither perspective nor orthographic")),
            };
            let given = [&described.name, &document.root.nodes[node].name].into_iter().flatten();
            let base = given
                .into_iter()
                .find(|name| !name.is_empty())
                .cloned()
                .unwrap_or_else(|| format!("camera{camera}"));
            let name = names.unique(base);
            cameras.push(Camera { name, lens, motion: CameraMotion::Node(at) });
        }
        Ok(cameras)
    }

    pub(super) fn lights(&self, document: &Document<'_>) -> Result<Vec<Light>, SceneError> {
        let mut lights = Vec::new();
        for (at, index, node) in self.shown(document) {
            let Some(hung) = &node.extensions.light else { continue };
            let all = &document.root.extensions.lights_punctual.lights;
            let light = document.get(all, hung.light, "light", &place(document, index))?;
            let light_place = named("light", hung.light, light.name.as_deref());
            let fault = |problem: String| {
                document.fault(&light_place, format!("{problem}; correct it and export the file again"))
            };
            let intensity = Vec3::from(light.color) * light.intensity;
            if !intensity.is_finite() || intensity.min_element() < 0.0 {
                return Err(fault("its colour or intensity is negative or not finite".to_owned()));
            }
            let range = light.range.filter(|&range| range > 0.0).unwrap_or(f32::INFINITY);
            let kind = match light.kind.as_str() {
                "directional" => LightKind::Directional,
                "point" => LightKind::Point { range },
                "spot" => {
                    let outer = light.spot.outer_cone_angle.clamp(1e-4, std::f32::consts::FRAC_PI_2);
                    let inner = light.spot.inner_cone_angle.clamp(0.0, outer);
                    LightKind::Spot { range, inner_cone_rad: inner, outer_cone_rad: outer }
                }
                other => return Err(fault(format!("its type '{other}' is not directional, point or spot"))),
            };
            lights.push(Light { name: light.name.clone().unwrap_or_default(), node: at, intensity, kind });
        }
        Ok(lights)
    }

    pub(super) fn skins(&self, document: &Document<'_>) -> Result<Vec<Skin>, SceneError> {
        let mut skins = Vec::with_capacity(document.root.skins.len());
        for (index, skin) in document.root.skins.iter().enumerate() {
            let skin_place = named("skin", index, skin.name.as_deref());
            let joints = skin
                .joints
                .iter()
                .map(|&joint| self.sorted(document, joint, &skin_place))
                .collect::<Result<Vec<_>, _>>()?;
            let inverse_bind = match skin.inverse_bind_matrices {
                None => vec![Affine3A::IDENTITY; joints.len()],
                Some(accessor) => {
                    let matrices = document.floats::<16>(accessor, &skin_place)?;
                    let matrices = matrices.get(..joints.len()).ok_or_else(|| {
                        let problem = format!(
                            "{} joints have only {} inverse bind matrices; export the file again",
                            joints.len(),
                            matrices.len()
                        );
                        document.fault(&skin_place, problem)
                    })?;
                    matrices.iter().map(|matrix| Affine3A::from_mat4(Mat4::from_cols_array(matrix))).collect()
                }
            };
            if !inverse_bind.iter().all(Affine3A::is_finite) {
                let problem =
                    "an inverse bind matrix is not finite; bind the skin anew and export the file again";
                return Err(document.fault(&skin_place, problem));
            }
            skins.push(Skin { name: skin.name.clone().unwrap_or_default(), joints, inverse_bind });
        }
        Ok(skins)
    }

    /// Draws the meshes of all nodes shown.
    pub(super) fn place_meshes(
        &self,
        document: &Document<'_>,
        materials: &mut Materials<'_, '_>,
        parts: &mut SceneParts,
    ) -> Result<(), SceneError> {
        let mut library = mesh::Library::new(document);
        let mut next_id = 0_u32;
        let mut drawn_triangles = 0_u64;
        for (at, index, node) in self.shown(document) {
            let Some(mesh_index) = node.mesh else { continue };
            // What is drawn at the node: the primitives of its mesh, on what skin, how often and with which
            // weights.
            let node_place = place(document, index);
            let primitives = library.primitives(mesh_index, &node_place, materials, &mut parts.meshes)?;
            let skin = match node.skin {
                Some(skin) => {
                    document.get(&document.root.skins, skin, "skin", &node_place)?;
                    Some(skin as u32)
                }
                None => None,
            };
            let copies = instance_transforms(document, node, &node_place)?;
            let weights = if node.weights.is_empty() {
                &document.root.meshes[mesh_index].weights
            } else {
                &node.weights
            };
            // Each copy is an object, each of its primitives an instance.
            for node_from_object in copies {
                let id = next_id;
                next_id = next_id
                    .checked_add(1)
                    .ok_or_else(|| document.limit(&node_place, "there are more than 2³² objects"))?;
                for primitive in &primitives {
                    let mesh = &parts.meshes[primitive.mesh as usize];
                    // Both what is drawn and what is stored is bounded, since a file can ask for copies
                    // without end.
                    drawn_triangles += mesh.indices.len() as u64;
                    if drawn_triangles > MAX_DRAWN_TRIANGLES {
                        let problem = format!(
                            "with its instances the file draws more than {MAX_DRAWN_TRIANGLES} triangles; reduce or split it"
                        );
                        return Err(document.limit(&node_place, problem));
                    }
                    let target_count = mesh.morph_targets.len();
                    document.charge(
                        1,
                        size_of::<Instance>() + target_count * size_of::<f32>(),
                        &node_place,
                    )?;
                    // Weights that the file leaves out are zero; a skin needs a mesh with joints.
                    let mut morph_weights = weights.clone();
                    morph_weights.resize(target_count, 0.0);
                    if morph_weights.iter().any(|weight| !weight.is_finite()) {
                        return Err(document
                            .fault(&node_place, "a morph weight is not finite; export the file again"));
                    }
                    if skin.is_some() && mesh.influences_per_vertex == 0 {
                        document.repaired(
                            &node_place,
                            "it has a skin, but its mesh has no joints: drawn as a rigid mesh",
                        );
                    }
                    parts.instances.push(Instance {
                        node: at,
                        node_from_object,
                        mesh: primitive.mesh,
                        id,
                        geometry: primitive.geometry,
                        skin: skin.filter(|_| mesh.influences_per_vertex > 0),
                        morph_weights,
                    });
                }
            }
        }
        Ok(())
    }
}

/// Names given so far.
#[derive(Default)]
struct Names {
    taken: HashSet<String>,
    /// Last number added to a name.
    numbers: HashMap<String, u64>,
}

impl Names {
    /// `name`, or `name 2`, `name 3`, … if it is taken.
    fn unique(&mut self, name: String) -> String {
        let mut candidate = name.clone();
        while !self.taken.insert(candidate.clone()) {
            let number = self.numbers.entry(name.clone()).or_insert(1);
            *number += 1;
            candidate = format!("{name} {number}");
        }
        candidate
    }
}

fn transform(document: &Document<'_>, node: &schema::Node, place: &str) -> Result<Transform, SceneError> {
    let transform = match &node.matrix {
        Some(matrix) => Transform::Matrix(Affine3A::from_mat4(Mat4::from_cols_array(matrix))),
        None => {
            let rotation = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
            Transform::Trs {
                translation: node.translation.unwrap_or_default().into(),
                rotation: unit_rotation(document, rotation, place),
                scale: node.scale.unwrap_or([1.0; 3]).into(),
            }
        }
    };
    if !transform.to_affine().is_finite() {
        return Err(document.fault(place, "its transform is not finite; reset it and export the file again"));
    }
    Ok(transform)
}

/// A quaternion brought to unit length; none if it has no direction.
pub(super) fn unit_rotation(document: &Document<'_>, rotation: [f32; 4], place: &str) -> Quat {
    let rotation = Quat::from_array(rotation);
    let length = rotation.length();
    if length > 1e-10 && length.is_finite() {
        // Unit already, to the rounding of the file: keep the bits.
        return if (length - 1.0).abs() < 1e-6 { rotation } else { rotation / length };
    }
    document.repaired(place, "a rotation without direction was taken as none");
    Quat::IDENTITY
}

/// Transforms below a node at which its mesh is drawn (`EXT_mesh_gpu_instancing`).
fn instance_transforms(
    document: &Document<'_>,
    node: &schema::Node,
    place: &str,
) -> Result<Vec<Affine3A>, SceneError> {
    let Some(instancing) = &node.extensions.instancing else { return Ok(vec![Affine3A::IDENTITY]) };
    let place = format!("{place}, EXT_mesh_gpu_instancing");
    let attribute = |name: &str| instancing.attributes.get(name).copied();
    let translations =
        attribute("TRANSLATION").map(|index| document.floats::<3>(index, &place)).transpose()?;
    let rotations = attribute("ROTATION").map(|index| document.floats::<4>(index, &place)).transpose()?;
    let scales = attribute("SCALE").map(|index| document.floats::<3>(index, &place)).transpose()?;
    let counts = [
        translations.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
    ];
    let Some(count) = counts.into_iter().flatten().max() else { return Ok(vec![Affine3A::IDENTITY]) };
    if counts.into_iter().flatten().any(|other| other != count) {
        return Err(document.fault(place, "its attributes differ in number; export the file again"));
    }
    document.charge(count, size_of::<Affine3A>(), &place)?;
    let mut transforms = Vec::with_capacity(count);
    for at in 0..count {
        let translation = translations.as_ref().map_or(Vec3::ZERO, |list| list[at].into());
        let rotation =
            rotations.as_ref().map_or(Quat::IDENTITY, |list| unit_rotation(document, list[at], &place));
        let scale = scales.as_ref().map_or(Vec3::ONE, |list| list[at].into());
        let transform = Affine3A::from_scale_rotation_translation(scale, rotation, translation);
        if !transform.is_finite() {
            return Err(document.fault(
                place,
                format!("instance {at} has a transform that is not finite; export the file again"),
            ));
        }
        transforms.push(transform);
    }
    Ok(transforms)
}
