//! What a file will take in memory, counted before any of it is taken: a few bytes can ask for any number of
//! vertices without data, copies of a mesh, or uses of an accessor.
//!
//! The counts are those that the file states, as far as its buffers, as long as they say they are, can hold
//! them. What is wrong with them is said by whoever reads them.

use std::collections::{BTreeMap, HashSet};

use sheer_core::text::MemorySize;
use sheer_scene::{
    LEAST_SHARED, Sharing,
    cost::{self, Drawn},
    model::{Factor, TextureSlot},
};

use super::{
    document::Document,
    mesh::MOST_UNUSED,
    node::{self, Hierarchy},
    pointer::{self, Pointed},
    schema::{self, Index, Primitive},
    topology::Topology,
};
use crate::{LoadError, stroke};

/// Holds what the scene will take against the memory that is left.
pub(super) fn check(document: &Document<'_>, hierarchy: &Hierarchy) -> Result<(), LoadError> {
    if document.options.memory_limit.is_none() {
        return Ok(());
    }
    let root = &document.root;
    let mut counts = Counts { document, animated_materials: HashSet::new() };
    let mut sum = Sum::default();

    // Animations, which nodes they move or show, and which materials they change.
    let mut moves = vec![false; root.nodes.len()];
    let mut fades = vec![false; root.nodes.len()];
    for (index, animation) in root.animations.iter().enumerate() {
        if !document.choices.plays(index) {
            continue;
        }
        let place = || format!("animations[{index}]");
        for channel in &animation.channels {
            match pointer::of_target(&channel.target).as_deref().and_then(pointer::parse) {
                Some(Pointed::Node { node, .. }) => {
                    if let Some(moved) = moves.get_mut(node) {
                        *moved = true;
                    }
                }
                Some(Pointed::Visibility { node }) => {
                    if let Some(faded) = fades.get_mut(node) {
                        *faded = true;
                    }
                }
                Some(
                    Pointed::BaseColour { material }
                    | Pointed::Transmission { material }
                    | Pointed::Factor { material, which: Factor::AlphaCutoff }
                    | Pointed::TextureTransform { material, slot: TextureSlot::BaseColour, .. },
                ) => {
                    counts.animated_materials.insert(material);
                }
                _ => {}
            }
            if let Some(sampler) = animation.samplers.get(channel.sampler) {
                sum.add(counts.keys(sampler), place);
            }
        }
    }
    // What is hidden because its animation does not play has been made all the same.
    hierarchy.hidden_at_rest().for_each(|node| fades[node] = true);
    let (moves, fades) = (hierarchy.with_descendants(moves), hierarchy.with_descendants(fades));
    let shares_at = |index: Index, node: &schema::Node| node.skin.is_none() && !fades[index];

    // Skins: matrices as they are read and as they are kept.
    for (index, skin) in root.skins.iter().enumerate() {
        let matrices = skin.inverse_bind_matrices.map_or(0, |accessor| counts.elements(accessor));
        let joints = 4 * skin.joints.len() as u64;
        sum.add(matrices.saturating_mul(64 + 64).saturating_add(joints), || format!("skins[{index}]"));
    }

    // Meshes, each read once, and how many rigid copies there are of each.
    let mut meshes: Vec<Option<MeshCost>> = Vec::new();
    meshes.resize_with(root.meshes.len(), || None);
    let drawn = || hierarchy.shown(document).filter_map(|(_, index, node)| Some((index, node, node.mesh?)));
    for (index, node, mesh_index) in drawn() {
        let Some(mesh) = root.meshes.get(mesh_index) else { continue };
        let cost = meshes[mesh_index].get_or_insert_with(|| {
            let cost = MeshCost::of(&counts, mesh);
            sum.add(cost.stored_bytes, || format!("meshes[{mesh_index}]"));
            cost
        });
        if shares_at(index, node) {
            cost.rigid_copies = cost.rigid_copies.saturating_add(counts.copies(node));
        }
    }

    // Copies, or instances that share their triangles where that saves enough of them.
    let saved =
        |cost: &MeshCost| cost.rigid_copies.saturating_sub(1).saturating_mul(cost.shareable_triangles);
    let all_saved = meshes.iter().flatten().map(saved).fold(0, u64::saturating_add);
    let shares = all_saved >= Sharing::default().least_saved;
    for (mesh_index, cost) in meshes.iter().enumerate() {
        if let Some(cost) = cost.as_ref().filter(|cost| shares && cost.rigid_copies > 1) {
            sum.add(cost.shared_bytes, || format!("meshes[{mesh_index}]"));
        }
    }
    for (index, node, mesh_index) in drawn() {
        let Some(cost) = meshes.get(mesh_index).and_then(Option::as_ref) else { continue };
        let is_shared = shares && shares_at(index, node) && cost.rigid_copies > 1;
        let each = if is_shared { &cost.instance_bytes } else { &cost.copy_bytes };
        let each = each[usize::from(moves[index] || !shares_at(index, node))];
        sum.add(counts.copies(node).saturating_mul(each), || node::place(index));
    }

    let left = document.memory_left();
    if sum.bytes <= left {
        return Ok(());
    }
    let [all, here, left] = [sum.bytes, sum.largest.0, left].map(MemorySize);
    let problem = format!(
        "the scene takes about {all} of memory, {here} of it here, and {left} are left of the limit; simplify it, or raise --memory-limit"
    );
    Err(document.limit(sum.largest.1, problem))
}

/// What has been counted, and the largest part of it.
#[derive(Default)]
struct Sum {
    bytes: u64,
    largest: (u64, String),
}

impl Sum {
    fn add(&mut self, bytes: u64, place: impl FnOnce() -> String) {
        self.bytes = self.bytes.saturating_add(bytes);
        if bytes > self.largest.0 {
            self.largest = (bytes, place());
        }
    }
}

/// A mesh in numbers, of those that stay and of those that move.
struct MeshCost {
    /// What it takes itself, however often it is drawn.
    stored_bytes: u64,
    /// What each copy takes.
    copy_bytes: [u64; 2],
    /// What each instance takes where they share their triangles, and what these triangles take.
    instance_bytes: [u64; 2],
    shared_bytes: u64,
    shareable_triangles: u64,
    /// How many there are without a skin.
    rigid_copies: u64,
}

impl MeshCost {
    fn of(counts: &Counts<'_>, mesh: &schema::Mesh) -> Self {
        let mut cost = Self {
            stored_bytes: 0,
            copy_bytes: [0; 2],
            instance_bytes: [0; 2],
            shared_bytes: 0,
            shareable_triangles: 0,
            rigid_copies: 0,
        };
        let mut most_unused = 0;
        for primitive in mesh.primitives.iter().map(|primitive| counts.primitive(primitive)) {
            cost.stored_bytes = cost.stored_bytes.saturating_add(primitive.stored_bytes);
            // Points and lines take more as bodies than they were read.
            most_unused = most_unused.max(primitive.read_bytes.saturating_sub(primitive.stored_bytes));
            let bytes = [false, true].map(|is_moved| {
                let how = Drawn { moves: primitive.deforms || is_moved, is_opaque: primitive.is_opaque };
                cost::of_object(primitive.triangles, how)
            });
            let is_shareable = !primitive.deforms && primitive.triangles >= LEAST_SHARED as u64;
            if is_shareable {
                cost.shareable_triangles = cost.shareable_triangles.saturating_add(primitive.triangles);
                cost.shared_bytes = cost.shared_bytes.saturating_add(bytes[0]);
            }
            for (at, bytes) in bytes.into_iter().enumerate() {
                let instance = if is_shareable { cost::of_object(0, Drawn::default()) } else { bytes };
                cost.copy_bytes[at] = cost.copy_bytes[at].saturating_add(bytes);
                cost.instance_bytes[at] = cost.instance_bytes[at].saturating_add(instance);
            }
        }
        cost.stored_bytes = cost.stored_bytes.saturating_add(most_unused);
        cost
    }
}

/// A primitive in numbers.
struct PrimitiveCost {
    triangles: u64,
    /// What it takes while it is read.
    read_bytes: u64,
    /// What it takes itself, however often it is drawn.
    stored_bytes: u64,
    deforms: bool,
    is_opaque: bool,
}

/// The numbers of a file.
struct Counts<'r> {
    document: &'r Document<'r>,
    /// What has them is made anew for each frame.
    animated_materials: HashSet<Index>,
}

impl Counts<'_> {
    /// How often the mesh of a node is drawn there.
    fn copies(&self, node: &schema::Node) -> u64 {
        node.extensions.instancing.as_ref().map_or(1, |instancing| {
            instancing.attributes.values().map(|&accessor| self.elements(accessor)).max().unwrap_or(1)
        })
    }

    fn primitive(&self, primitive: &Primitive) -> PrimitiveCost {
        let root = &self.document.root;
        let elements = |attributes: &BTreeMap<String, Index>, name: &str| {
            attributes.get(name).map_or(0, |&accessor| self.elements(accessor))
        };
        let vertices = elements(&primitive.attributes, "POSITION");
        let listed = primitive.indices.map(|accessor| self.elements(accessor));
        let corners = listed.unwrap_or(vertices);
        let count = usize::try_from(corners).unwrap_or(usize::MAX);
        // Points and lines become bodies of triangles, with vertices of their own.
        let (triangles, body_vertices) = match Topology::from_code(primitive.mode.unwrap_or(4)) {
            Some(Topology::Triangles(pattern)) => (pattern.triangle_count(count) as u64, None),
            Some(Topology::Strokes(_)) => {
                let [triangles, vertices] = stroke::most_of_bodies(count);
                (triangles, Some(vertices))
            }
            None => (0, None),
        };

        // Vectors of floats, as they are in memory; joints and weights are read as such and put together.
        let attribute = |(name, &accessor): (&String, &Index)| {
            let bytes_each = match name.split('_').next() {
                Some("POSITION" | "NORMAL") => 12,
                Some("TEXCOORD") => 8,
                Some("TANGENT" | "COLOR") => 16,
                Some("JOINTS" | "WEIGHTS") => 32,
                _ => 0,
            };
            let elements = self.elements(accessor);
            let used = triangles.saturating_mul(3).saturating_add(MOST_UNUSED as u64);
            let stored = body_vertices.unwrap_or(elements.min(used));
            [elements, stored].map(|count| count.saturating_mul(bytes_each))
        };
        let targets = primitive.targets.iter().flatten();
        let attributes = primitive.attributes.iter().chain(targets).map(attribute);
        // Vertices that no triangle has are read, and left out.
        let indices = corners.saturating_mul(4).saturating_add(triangles.saturating_mul(12));
        let [read_bytes, stored_bytes] = attributes.fold([indices; 2], |sums, bytes| {
            [sums[0].saturating_add(bytes[0]), sums[1].saturating_add(bytes[1])]
        });

        let index = self.document.choices.material_of(primitive);
        let is_opaque = index.and_then(|index| root.materials.get(index)).is_none_or(is_opaque);
        // What stays opaque does not change its opacity.
        let fades = !is_opaque && index.is_some_and(|index| self.animated_materials.contains(&index));
        let deforms = fades || !primitive.targets.is_empty() || primitive.attributes.contains_key("JOINTS_0");
        PrimitiveCost { triangles, read_bytes, stored_bytes, deforms, is_opaque }
    }

    /// Times and values of an animation.
    fn keys(&self, sampler: &schema::AnimationSampler) -> u64 {
        // Weights are a list for each key.
        let values = self.elements(sampler.output).saturating_mul(16 + 24);
        self.elements(sampler.input).saturating_mul(4).saturating_add(values)
    }

    /// How many elements an accessor states, or its buffer can hold at most.
    fn elements(&self, accessor: Index) -> u64 {
        let root = &self.document.root;
        let Some(accessor) = root.accessors.get(accessor) else { return 0 };
        let stated = accessor.count as u64;
        let view = accessor.buffer_view.and_then(|view| root.buffer_views.get(view));
        match view.filter(|view| view.extensions.meshopt.is_none()) {
            // An element takes a byte at least.
            Some(view) => stated.min(view.byte_length as u64),
            None => stated,
        }
    }
}

fn is_opaque(material: &schema::Material) -> bool {
    matches!(material.alpha_mode.as_deref(), None | Some("OPAQUE"))
        && material.extensions.transmission.is_none()
}
