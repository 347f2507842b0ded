//! The hierarchy: nodes in order, and what hangs on them.

use std::collections::{HashMap, HashSet};

use glam::{Affine3A, Mat4, Quat, Vec3};
use sheer_scene::{
    camera::{Camera, CameraMotion, ClipPlanes, Lens},
    model::{Instance, Light, LightKind, LightNumber, Node, SceneParts, Skin, Transform},
};

use super::{
    document::Document,
    material::Materials,
    mesh, pointer,
    schema::{self, Index},
};
use crate::{LoadError, stroke::Sketch};

/// Nodes sorted so that a parent stands before its children, with a way from the file's indices to the sorted
/// ones.
pub(super) struct Hierarchy {
    /// File index of each sorted node.
    order: Vec<Index>,
    /// Sorted index of each node of the file.
    sorted: Vec<u32>,
    /// Sorted index of the parent of each sorted node.
    parents: Vec<Option<u32>>,
    /// `parent_from_node` of each sorted node at rest.
    transforms: Vec<Transform>,
    /// Whether each sorted node belongs to the scene shown, and is not hidden, or not always.
    shown: Vec<bool>,
    /// Sorted nodes that are hidden unless an animation shows them.
    pub hidden_at_rest: Vec<u32>,
}

/// A node in messages.
pub(super) fn place(index: Index) -> String {
    format!("nodes[{index}]")
}

impl Hierarchy {
    pub(super) fn build(document: &Document<'_>) -> Result<Self, LoadError> {
        let nodes = &document.root.nodes;
        let (mut parent_of, mut children) = family(document)?;

        // Breadth first from the roots. What is not reached hangs on itself: it is cut loose.
        let mut order: Vec<Index> = (0..nodes.len()).filter(|&index| parent_of[index].is_none()).collect();
        let mut sorted = vec![u32::MAX; nodes.len()];
        let (mut at, mut reached) = (0, 0);
        loop {
            while let Some(&index) = order.get(at) {
                sorted[index] = at as u32;
                order.extend(&children[index]);
                at += 1;
            }
            reached += sorted[reached..].iter().take_while(|&&at| at != u32::MAX).count();
            if reached == nodes.len() {
                break;
            }
            let problem = "it is its own ancestor; break the cycle and export the file again";
            document.lose(document.fault(place(reached), problem), "taken out of its parent")?;
            if let Some(parent) = parent_of[reached].take() {
                children[parent].retain(|&child| child != reached);
            }
            order.push(reached);
        }
        let parents: Vec<Option<u32>> =
            order.iter().map(|&index| parent_of[index].map(|parent| sorted[parent])).collect();

        // The scene shown; a file without scenes shows all it has.
        let mut shown = vec![false; nodes.len()];
        match scene_shown(document)? {
            None => shown.iter_mut().zip(&parents).for_each(|(shown, parent)| *shown = parent.is_none()),
            Some(scene) => {
                for &root in &scene.nodes {
                    let sorted = document.get(&sorted, root, "node", "scene");
                    if let Some(&sorted) = document.salvage(sorted, "left out")? {
                        shown[sorted as usize] = true;
                    }
                }
            }
        }
        // What an animation may show belongs to it.
        let fading: HashSet<Index> = pointer::animated_visibilities(document).collect();
        let mut hidden_at_rest = Vec::new();
        let mut transforms = Vec::with_capacity(nodes.len());
        for (at, &index) in order.iter().enumerate() {
            let read = transform(document, &nodes[index], &place(index));
            let read = document.salvage(read, "it and what hangs on it are not drawn")?;
            let inherited = parents[at].is_some_and(|parent| shown[parent as usize]);
            let is_visible = nodes[index].extensions.visibility.visible;
            if !is_visible && fading.contains(&index) {
                hidden_at_rest.push(at as u32);
            }
            shown[at] = (shown[at] || inherited) && (is_visible || fading.contains(&index)) && read.is_some();
            transforms.push(read.unwrap_or(Transform::IDENTITY));
        }
        Ok(Self { order, sorted, parents, transforms, shown, hidden_at_rest })
    }

    /// Sorted index of a node of the file.
    pub(super) fn sorted(
        &self,
        document: &Document<'_>,
        index: Index,
        place: &str,
    ) -> Result<u32, LoadError> {
        document.get(&self.sorted, index, "node", place).copied()
    }

    /// File index of the nodes that are hidden unless an animation shows them.
    pub(super) fn hidden_at_rest(&self) -> impl Iterator<Item = Index> {
        self.hidden_at_rest.iter().map(|&at| self.order[at as usize])
    }

    /// Marks what hangs on marked nodes as well; nodes are in the order of the file.
    pub(super) fn with_descendants(&self, mut marked: Vec<bool>) -> Vec<bool> {
        for (at, &index) in self.order.iter().enumerate() {
            marked[index] |= self.parents[at].is_some_and(|parent| marked[self.order[parent as usize]]);
        }
        marked
    }

    pub(super) fn nodes(&self, document: &Document<'_>) -> Vec<Node> {
        let name = |index: Index| document.root.nodes[index].name.clone().unwrap_or_default();
        let nodes = self.order.iter().zip(&self.parents).zip(&self.transforms);
        nodes.map(|((&index, &parent), &transform)| Node { name: name(index), parent, transform }).collect()
    }

    /// The nodes shown, with their sorted index and file index.
    pub(super) fn shown<'a>(
        &'a self,
        document: &'a Document<'_>,
    ) -> impl Iterator<Item = (u32, Index, &'a schema::Node)> {
        let nodes = self.order.iter().enumerate().filter(|(at, _)| self.shown[*at]);
        nodes.map(|(at, &index)| (at as u32, index, &document.root.nodes[index]))
    }

    pub(super) fn cameras(&self, document: &Document<'_>) -> Result<Cameras, LoadError> {
        let mut hung: Vec<_> = self
            .shown(document)
            .filter_map(|(at, index, node)| node.camera.map(|camera| (camera, index, at)))
            .collect();
        hung.sort_unstable();
        let mut cameras = Cameras::default();
        let mut names = Names::default();
        for (camera, node, at) in hung {
            let Some(lens) = document.salvage(lens(document, camera, node), "left out")? else { continue };
            let clip = document.salvage(clip_planes(document, camera), "taken for none")?.unwrap_or_default();
            let given = [&document.root.cameras[camera].name, &document.root.nodes[node].name];
            let base = given
                .into_iter()
                .flatten()
                .find(|name| !name.is_empty())
                .cloned()
                .unwrap_or_else(|| format!("camera{camera}"));
            document.charge(1, size_of::<Camera>() + 3 * base.len(), &format!("cameras[{camera}]"))?;
            let name = names.unique(base);
            cameras.sound.push(Camera { name, lens, clip, motion: CameraMotion::Node(at) });
            cameras.file_index.push(camera);
        }
        Ok(cameras)
    }

    pub(super) fn lights(&self, document: &Document<'_>) -> Result<Lights, LoadError> {
        let mut lights = Lights::default();
        for (at, index, node) in self.shown(document) {
            let Some(hung) = &node.extensions.light else { continue };
            if let Some(light) = document.salvage(light(document, hung.light, index, at), "left out")? {
                lights.sound.push(light);
                lights.file_index.push(hung.light);
            }
        }
        Ok(lights)
    }

    pub(super) fn skins(&self, document: &Document<'_>) -> Result<Skins, LoadError> {
        let mut skins = Skins::default();
        for (index, skin) in document.root.skins.iter().enumerate() {
            let read =
                document.salvage(self.skin(document, index, skin), "what it bends is drawn as it is")?;
            skins.index_of.push(read.is_some().then_some(skins.sound.len() as u32));
            skins.sound.extend(read);
        }
        Ok(skins)
    }

    fn skin(&self, document: &Document<'_>, index: Index, skin: &schema::Skin) -> Result<Skin, LoadError> {
        let place = format!("skins[{index}]");
        let joints = skin
            .joints
            .iter()
            .map(|&joint| self.sorted(document, joint, &place))
            .collect::<Result<Vec<_>, _>>()?;
        let inverse_bind = match skin.inverse_bind_matrices {
            None => vec![Affine3A::IDENTITY; joints.len()],
            Some(accessor) => {
                let matrices = document.floats::<16>(accessor, &format!("{place}.inverseBindMatrices"))?;
                let matrices = matrices.get(..joints.len()).ok_or_else(|| {
                    let problem = format!(
                        "{} joints have only {} inverse bind matrices; export the file again",
                        joints.len(),
                        matrices.len()
                    );
                    document.fault(&place, problem)
                })?;
                matrices.iter().map(|matrix| Affine3A::from_mat4(Mat4::from_cols_array(matrix))).collect()
            }
        };
        if !inverse_bind.iter().all(Affine3A::is_finite) {
            let problem =
                "an inverse bind matrix is not finite; bind the skin anew and export the file again";
            return Err(document.fault(&place, problem));
        }
        Ok(Skin { name: skin.name.clone().unwrap_or_default(), joints, inverse_bind })
    }

    /// Draws the meshes of all nodes shown; those of points and lines are still to be given triangles.
    pub(super) fn place_meshes(
        &self,
        document: &Document<'_>,
        materials: &mut Materials<'_, '_>,
        skins: &Skins,
        parts: &mut SceneParts,
    ) -> Result<Vec<Sketch>, LoadError> {
        let mut library = mesh::Library::new(document);
        let mut next_id = 0_u32;
        for (at, index, node) in self.shown(document) {
            let Some(mesh_index) = node.mesh else { continue };
            // What is drawn at the node: the primitives of its mesh, on what skin, how often and with which
            // weights.
            let node_place = place(index);
            let primitives = library.primitives(mesh_index, &node_place, materials, &mut parts.meshes);
            let Some(primitives) = document.salvage(primitives, "not drawn")? else { continue };
            let skin = match node.skin {
                Some(skin) => {
                    let index = document.get(&skins.index_of, skin, "skin", &node_place);
                    document.salvage(index, "drawn as a rigid mesh")?.copied().flatten()
                }
                None => None,
            };
            let copies = instance_transforms(document, node, &node_place);
            let Some(copies) = document.salvage(copies, "not drawn")? else { continue };
            let mut weights = if node.weights.is_empty() {
                document.root.meshes[mesh_index].weights.clone()
            } else {
                node.weights.clone()
            };
            if weights.iter().any(|weight| !weight.is_finite()) {
                let fault =
                    document.fault(&node_place, "a morph weight is not finite; export the file again");
                document.lose(fault, "it became 0")?;
                weights.iter_mut().filter(|weight| !weight.is_finite()).for_each(|weight| *weight = 0.0);
            }
            // Which skin each primitive hangs on.
            let mut hung = Vec::with_capacity(primitives.len());
            for primitive in &primitives {
                hung.push(match skin {
                    Some(skin) => {
                        let joint_count = skins.sound[skin as usize].joints.len();
                        primitive.hangs_on(document, &node_place, joint_count)?.then_some(skin)
                    }
                    None => None,
                });
            }
            // Each copy is an object, each of its primitives an instance.
            for node_from_object in copies {
                let id = next_id;
                next_id = next_id
                    .checked_add(1)
                    .ok_or_else(|| document.limit(&node_place, "there are more than 2³² objects"))?;
                for (primitive, &skin) in primitives.iter().zip(&hung) {
                    let mesh = &parts.meshes[primitive.mesh as usize];
                    let target_count = mesh.morph_targets.len();
                    document.charge(
                        1,
                        size_of::<Instance>() + target_count * size_of::<f32>(),
                        &node_place,
                    )?;
                    // Weights that the file leaves out are zero.
                    let mut morph_weights: Vec<f32> = weights.iter().copied().take(target_count).collect();
                    morph_weights.resize(target_count, 0.0);
                    parts.instances.push(Instance {
                        node: at,
                        node_from_object,
                        mesh: primitive.mesh,
                        id,
                        geometry: primitive.geometry,
                        skin,
                        morph_weights,
                    });
                }
            }
        }
        Ok(library.sketches)
    }
}

/// The cameras that are sound, one for each node on which one hangs.
#[derive(Default)]
pub(super) struct Cameras {
    pub sound: Vec<Camera>,
    /// Of each its index in the file.
    pub file_index: Vec<Index>,
}

/// The lights that are sound, one for each node on which one hangs.
#[derive(Default)]
pub(super) struct Lights {
    pub sound: Vec<Light>,
    /// Of each its index in the file.
    pub file_index: Vec<Index>,
}

/// The skins of a file that are sound.
#[derive(Default)]
pub(super) struct Skins {
    pub sound: Vec<Skin>,
    /// Index into `sound` of each skin of the file.
    index_of: Vec<Option<u32>>,
}

/// Parent and children of each node of the file: what names no node or has a parent already is left out.
#[expect(clippy::type_complexity, reason = "two lists that are taken apart at once")]
fn family(document: &Document<'_>) -> Result<(Vec<Option<Index>>, Vec<Vec<Index>>), LoadError> {
    let nodes = &document.root.nodes;
    let mut parent_of: Vec<Option<Index>> = vec![None; nodes.len()];
    let mut children: Vec<Vec<Index>> = vec![Vec::new(); nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        for &child in &node.children {
            let found = document.get(nodes, child, "node", &place(index));
            if document.salvage(found, "left out")?.is_none() {
                continue;
            }
            if let Some(other) = parent_of[child] {
                let problem = format!(
                    "it is a child of both node {other} and node {index}; a node has one parent, export the file again"
                );
                document.lose(document.fault(place(child), problem), "it stays with the first")?;
                continue;
            }
            parent_of[child] = Some(index);
            children[index].push(child);
        }
    }
    Ok((parent_of, children))
}

/// The scene that is shown, if the file has scenes.
fn scene_shown<'d>(document: &'d Document<'_>) -> Result<Option<&'d schema::Scene>, LoadError> {
    let scenes = &document.root.scenes;
    let named = match document.choices.scene.or(document.root.scene) {
        Some(index) => document.salvage(document.get(scenes, index, "scene", "scene"), "left out")?,
        None => None,
    };
    Ok(named.or(scenes.first()))
}

/// The lens of a camera that hangs on a node of the file.
fn lens(document: &Document<'_>, camera: Index, node: Index) -> Result<Lens, LoadError> {
    let described = document.get(&document.root.cameras, camera, "camera", &place(node))?;
    let fault = |problem: &str| {
        document.fault(format!("cameras[{camera}]"), format!("{problem}; set it and export the file again"))
    };
    match (&described.perspective, &described.orthographic) {
        (Some(lens), _) => {
            let valid = lens.yfov > 0.0 && lens.yfov < std::f32::consts::PI;
            valid
                .then_some(Lens::Perspective { yfov_rad: lens.yfov })
                .ok_or_else(|| fault("yfov is not between 0 and π"))
        }
        (None, Some(lens)) => {
            // A negative magnification mirrors; its size is what is meant.
            let half_height = lens.ymag.abs();
            let valid = half_height > 0.0 && half_height.is_finite();
            valid.then_some(Lens::Orthographic { half_height }).ok_or_else(|| fault("ymag is zero"))
        }
        (None, None) => Err(fault("it is neither perspective nor orthographic")),
    }
}

/// The near and the far plane of a camera of the file; what it leaves out cuts nothing.
fn clip_planes(document: &Document<'_>, camera: Index) -> Result<ClipPlanes, LoadError> {
    let described = &document.root.cameras[camera];
    let planes = match (&described.perspective, &described.orthographic) {
        (Some(lens), _) => [lens.znear, lens.zfar],
        (None, Some(lens)) => [lens.znear, lens.zfar],
        (None, None) => [None; 2],
    };
    let [near, far] = planes;
    let clip = ClipPlanes { near: near.unwrap_or(0.0), far: far.unwrap_or(f32::INFINITY) };
    if 0.0 <= clip.near && clip.near < clip.far {
        return Ok(clip);
    }
    let problem = format!(
        "znear is {} and zfar {}, but they must not be negative, and zfar must be greater; correct them and export the file again",
        clip.near, clip.far
    );
    Err(document.fault(format!("cameras[{camera}]"), problem))
}

/// A light that hangs on a node, by its index in the file and by its sorted one.
fn light(document: &Document<'_>, light: Index, node: Index, sorted: u32) -> Result<Light, LoadError> {
    let all = &document.root.extensions.lights_punctual.lights;
    let described = document.get(all, light, "light", &place(node))?;
    let fault = |problem: String| {
        document.fault(
            format!("extensions.KHR_lights_punctual.lights[{light}]"),
            format!("{problem}; correct it and export the file again"),
        )
    };
    let intensity = Vec3::from(described.color) * described.intensity;
    if !intensity.is_finite() || intensity.min_element() < 0.0 {
        return Err(fault("its colour or intensity is negative or not finite".to_owned()));
    }
    let range = described.range.filter(|&range| range > 0.0).unwrap_or(f32::INFINITY);
    let kind = match described.kind.as_str() {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point { range },
        "spot" => {
            let mut kind = LightKind::Spot { range, inner_cone_rad: 0.0, outer_cone_rad: 0.0 };
            kind.set(LightNumber::InnerCone, described.spot.inner_cone_angle);
            kind.set(LightNumber::OuterCone, described.spot.outer_cone_angle);
            kind.with_nested_cones()
        }
        other => return Err(fault(format!("its type '{other}' is not directional, point or spot"))),
    };
    Ok(Light { name: described.name.clone().unwrap_or_default(), node: sorted, intensity, kind })
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

fn transform(document: &Document<'_>, node: &schema::Node, place: &str) -> Result<Transform, LoadError> {
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
) -> Result<Vec<Affine3A>, LoadError> {
    let Some(instancing) = &node.extensions.instancing else { return Ok(vec![Affine3A::IDENTITY]) };
    let place = format!("{place}.extensions.EXT_mesh_gpu_instancing");
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
