//! Meshes: vertex attributes of one glTF primitive become one [`Mesh`].

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};
use sheer_scene::model::{Influence, Mesh, MorphTarget};

#[cfg(feature = "draco")]
use super::draco;
use super::{
    document::Document,
    material::Materials,
    schema::{Accessor, Index, Primitive},
    topology::{self, StrokePattern, Topology, TrianglePattern},
};
use crate::{
    LoadError, LoadWarning,
    stroke::{Sketch, Strokes},
};

/// Joints are 16 bits here as in glTF; a file with a wider type may still hold small ones.
const MAX_JOINT: u32 = u16::MAX as u32;
/// Texture coordinate sets that are looked for; the specification asks for two.
const MAX_UV_SETS: usize = 8;
/// Joint sets that are looked for, of four joints each; the specification asks for one.
const MAX_JOINT_SETS: usize = 8;

/// Vertices that no triangle has are left out if there may be more: a list may serve many primitives.
pub(super) const MOST_UNUSED: usize = 1024;

/// The meshes read so far: a mesh of the file is read when first drawn.
pub(super) struct Library<'d, 'a> {
    document: &'d Document<'a>,
    read: Vec<Option<Vec<DrawnPrimitive>>>,
    /// Those of points and lines.
    pub sketches: Vec<Sketch>,
}

/// A primitive that has triangles.
#[derive(Clone, Copy)]
pub(super) struct DrawnPrimitive {
    /// Index into the scene's meshes.
    pub mesh: u32,
    /// Index in the glTF mesh.
    pub geometry: u32,
    /// How many joints a skin must have for it; 0 of a mesh without joints.
    joint_count: usize,
}

impl DrawnPrimitive {
    /// Whether a skin of so many joints can bend it.
    pub(super) fn hangs_on(
        self,
        document: &Document<'_>,
        node_place: &str,
        joint_count: usize,
    ) -> Result<bool, LoadError> {
        if self.joint_count == 0 {
            document.repaired(node_place, "it has a skin, but its mesh has no joints: drawn as a rigid mesh");
            return Ok(false);
        }
        if self.joint_count > joint_count {
            let problem = format!(
                "its mesh hangs on joint {}, but its skin has only {joint_count}; bind the skin anew and export the file again",
                self.joint_count - 1
            );
            document.lose(document.fault(node_place, problem), "drawn as a rigid mesh")?;
            return Ok(false);
        }
        Ok(true)
    }
}

impl<'d, 'a> Library<'d, 'a> {
    pub(super) fn new(document: &'d Document<'a>) -> Self {
        Self { document, read: vec![None; document.root.meshes.len()], sketches: Vec::new() }
    }

    /// The primitives of a mesh of the file, read into `meshes` the first time.
    pub(super) fn primitives(
        &mut self,
        index: Index,
        node_place: &str,
        materials: &mut Materials<'_, '_>,
        meshes: &mut Vec<Mesh>,
    ) -> Result<Vec<DrawnPrimitive>, LoadError> {
        let mesh = self.document.get(&self.document.root.meshes, index, "mesh", node_place)?;
        if let Some(primitives) = &self.read[index] {
            return Ok(primitives.clone());
        }
        let mut drawn = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("meshes[{index}].primitives[{number}]");
            let read = Reader::new(self.document, primitive, place.clone()).and_then(|reader| reader.mesh());
            let Some((mut read, strokes)) = self.document.salvage(read, "not drawn")?.flatten() else {
                continue;
            };
            read.name = mesh.name.clone().unwrap_or_default();
            read.material = materials.index(self.document.choices.material_of(primitive), &place)?;
            let joints = read.influences.iter().map(|influence| usize::from(influence.joint) + 1);
            let index = meshes.len() as u32;
            drawn.push(DrawnPrimitive {
                mesh: index,
                geometry: number as u32,
                joint_count: joints.max().unwrap_or(0),
            });
            self.sketches.extend(strokes.map(|strokes| Sketch { mesh: index, strokes }));
            meshes.push(read);
        }
        self.read[index] = Some(drawn.clone());
        Ok(drawn)
    }
}

/// One primitive and where its data comes from.
struct Reader<'d, 'a> {
    document: &'d Document<'a>,
    primitive: &'d Primitive,
    place: String,
    #[cfg(feature = "draco")]
    draco: Option<draco::Decoded>,
}

impl<'d, 'a> Reader<'d, 'a> {
    fn new(document: &'d Document<'a>, primitive: &'d Primitive, place: String) -> Result<Self, LoadError> {
        #[cfg(feature = "draco")]
        let draco = draco::decode(document, primitive, &place)?;
        Ok(Self {
            document,
            primitive,
            place,
            #[cfg(feature = "draco")]
            draco,
        })
    }

    /// The triangles, or points or lines to make some of; `None` if there is nothing to draw.
    fn mesh(&self) -> Result<Option<(Mesh, Option<Strokes>)>, LoadError> {
        let document = self.document;
        let Some(topology) = Topology::from_code(self.primitive.mode.unwrap_or(4)) else {
            let problem = "its mode is none of the seven of glTF 2.0; export the file again";
            return Err(document.fault(&self.place, problem));
        };
        // A primitive may leave its positions to an extension (glTF 2.0, 3.7.2.1); none that is known here
        // does.
        let Some(positions) = self.floats::<3>("POSITION")? else {
            document.repaired(&self.place, "it has no positions and is not drawn");
            return Ok(None);
        };
        let mut positions: Vec<Vec3> = positions.into_iter().map(Vec3::from).collect();
        let (mut indices, mut strokes) = match topology {
            Topology::Triangles(pattern) => (self.triangles(pattern, positions.len())?, None),
            Topology::Strokes(pattern) => (Vec::new(), Some(self.strokes(pattern, positions.len())?)),
        };
        if let Some(vertex) = positions.iter().position(|position| !position.is_finite()) {
            document
                .lose(self.not_finite("POSITION", vertex), "the triangles of such vertices are not drawn")?;
            indices.retain(|corners| corners.iter().all(|&at| positions[at as usize].is_finite()));
            if let Some(strokes) = &mut strokes {
                strokes.retain(|at| positions[at as usize].is_finite());
            }
            // Where no triangle refers to them, they are to change nothing.
            let first = indices.first().map_or(Vec3::ZERO, |corners| positions[corners[0] as usize]);
            positions
                .iter_mut()
                .filter(|position| !position.is_finite())
                .for_each(|position| *position = first);
        }
        if indices.is_empty() && strokes.as_ref().is_none_or(Strokes::is_empty) {
            return Ok(None);
        }
        let mut mesh = Mesh { positions, indices, ..Mesh::default() };
        self.read_frame(&mut mesh)?;
        self.read_uv_sets(&mut mesh)?;
        self.read_colours(&mut mesh)?;
        self.read_influences(&mut mesh)?;
        self.read_morph_targets(&mut mesh)?;
        // What stays is bounded by what is drawn.
        if strokes.is_none() && mesh.positions.len() > 3 * mesh.indices.len() + MOST_UNUSED {
            self.document.give_back(leave_out_unused(&mut mesh));
        }
        Ok(Some((mesh, strokes)))
    }

    /// The points or lines.
    fn strokes(&self, pattern: StrokePattern, vertex_count: usize) -> Result<Strokes, LoadError> {
        let place = format!("{}.indices", self.place);
        let listed = self.told_indices(vertex_count, &place)?;
        let count = listed.as_ref().map_or(vertex_count, Vec::len);
        self.document.charge(count, size_of::<[u32; 2]>(), &place)?;
        let mut strokes = match &listed {
            Some(listed) => topology::strokes(pattern, count, |at| listed[at]),
            None => topology::strokes(pattern, count, |at| at as u32),
        };
        strokes.retain(|index| (index as usize) < vertex_count);
        if let Some(said) = strokes.thin_out() {
            self.document.repaired(&self.place, &said);
        }
        self.document.charge(1, strokes.body_bytes(), &place)?;
        Ok(strokes)
    }

    /// The indices, if there are any; that some refer to no vertex has been said.
    fn told_indices(&self, vertex_count: usize, place: &str) -> Result<Option<Vec<u32>>, LoadError> {
        let listed = self.indices(place)?;
        if let Some(wild) = listed.iter().flatten().find(|&&index| index as usize >= vertex_count) {
            let problem =
                format!("index {wild} refers to one of only {vertex_count} vertices; export the file again");
            self.document.lose(self.document.fault(place, problem), "what refers to it is not drawn")?;
        }
        Ok(listed)
    }

    fn triangles(&self, pattern: TrianglePattern, vertex_count: usize) -> Result<Vec<[u32; 3]>, LoadError> {
        let place = format!("{}.indices", self.place);
        let listed = self.told_indices(vertex_count, &place)?;
        let count = listed.as_ref().map_or(vertex_count, Vec::len);
        self.document.charge(pattern.triangle_count(count), size_of::<[u32; 3]>(), &place)?;
        if pattern.leftover(count) > 0 {
            self.document.repaired(&place, "the last triangle is not complete and was left out");
        }
        let mut triangles = match &listed {
            Some(listed) => topology::triangles(pattern, count, |at| listed[at]),
            None => topology::triangles(pattern, count, |at| at as u32),
        };
        triangles.retain(|corners| corners.iter().all(|&index| (index as usize) < vertex_count));
        Ok(triangles)
    }

    fn indices(&self, place: &str) -> Result<Option<Vec<u32>>, LoadError> {
        #[cfg(feature = "draco")]
        if let Some(decoded) = &self.draco {
            return Ok(Some(decoded.indices.clone()));
        }
        let Some(accessor) = self.primitive.indices else { return Ok(None) };
        let indices = self.document.integers::<1>(accessor, place)?;
        Ok(Some(indices.into_iter().map(|[index]| index).collect()))
    }

    /// Reads normals and tangents, and makes them unit vectors.
    fn read_frame(&self, mesh: &mut Mesh) -> Result<(), LoadError> {
        let vertex_count = mesh.positions.len();
        let Some(normals) = self.sound_floats::<3>("NORMAL", vertex_count)? else { return Ok(()) };
        mesh.normals = normals.into_iter().map(|normal| Vec3::from(normal).normalize_or_zero()).collect();
        if mesh.normals.contains(&Vec3::ZERO) {
            fill_missing_normals(mesh);
            self.document.repaired(&self.place, "normals without direction were made from the triangles");
        }
        // Without normals tangents mean nothing (glTF 2.0, 3.7.2.1).
        let Some(tangents) = self.sound_floats::<4>("TANGENT", vertex_count)? else { return Ok(()) };
        let tangents: Vec<Vec4> = tangents
            .into_iter()
            .map(Vec4::from)
            .map(|tangent| {
                tangent.truncate().normalize_or_zero().extend(if tangent.w < 0.0 { -1.0 } else { 1.0 })
            })
            .collect();
        if tangents.iter().any(|tangent| tangent.truncate() == Vec3::ZERO) {
            self.document
                .repaired(&self.place, "tangents without direction were made from the texture coordinates");
        } else {
            mesh.tangents = tangents;
        }
        Ok(())
    }

    fn read_uv_sets(&self, mesh: &mut Mesh) -> Result<(), LoadError> {
        let vertex_count = mesh.positions.len();
        for set in 0..MAX_UV_SETS {
            let name = format!("TEXCOORD_{set}");
            let Some(uvs) = self.sound_floats::<2>(&name, vertex_count)? else { continue };
            let mut uvs: Vec<Vec2> = uvs.into_iter().map(Vec2::from).collect();
            if uvs.iter().any(|uv| !uv.is_finite()) {
                uvs.iter_mut().filter(|uv| !uv.is_finite()).for_each(|uv| *uv = Vec2::ZERO);
                self.document.repaired(
                    &format!("{}.attributes.{name}", self.place),
                    "coordinates that were not finite became 0",
                );
            }
            // A gap in the numbers is filled, so that set n stays number n.
            self.document.charge(
                (set - mesh.uv_sets.len()) * vertex_count,
                size_of::<Vec2>(),
                &self.place,
            )?;
            mesh.uv_sets.resize(set, vec![Vec2::ZERO; vertex_count]);
            mesh.uv_sets.push(uvs);
        }
        Ok(())
    }

    fn read_colours(&self, mesh: &mut Mesh) -> Result<(), LoadError> {
        let Some(&accessor) = self.primitive.attributes.get("COLOR_0") else { return Ok(()) };
        let vertex_count = mesh.positions.len();
        // An accessor that is not there has no components; reading it says so.
        let components = self.document.root.accessors.get(accessor).map_or(0, Accessor::component_count);
        let colours = if components == 3 {
            let opaque = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
            self.sound_floats::<3>("COLOR_0", vertex_count)?.map(|rgb| rgb.into_iter().map(opaque).collect())
        } else {
            self.sound_floats::<4>("COLOR_0", vertex_count)?
        };
        mesh.colours = colours.unwrap_or_default().into_iter().map(Vec4::from).collect();
        if let Some(vertex) = mesh.colours.iter().position(|colour| !colour.is_finite()) {
            self.document.lose(self.not_finite("COLOR_0", vertex), "such colours became white")?;
            mesh.colours
                .iter_mut()
                .filter(|colour| !colour.is_finite())
                .for_each(|colour| *colour = Vec4::ONE);
        }
        for colour in &mut mesh.colours {
            *colour = colour.max(Vec4::ZERO).min(Vec3::MAX.extend(1.0));
        }
        Ok(())
    }

    fn read_influences(&self, mesh: &mut Mesh) -> Result<(), LoadError> {
        let influences = self.influences(mesh.positions.len());
        let influences = self.document.salvage(influences, "drawn as a rigid mesh")?;
        (mesh.influences, mesh.influences_per_vertex) = influences.unwrap_or_default();
        Ok(())
    }

    /// The joints that pull each vertex, and how many there are a vertex.
    fn influences(&self, vertex_count: usize) -> Result<(Vec<Influence>, usize), LoadError> {
        let mut sets = Vec::new();
        for set in 0..MAX_JOINT_SETS {
            let joints = self.sized_integers(&format!("JOINTS_{set}"), vertex_count)?;
            let weights = self.sized_floats::<4>(&format!("WEIGHTS_{set}"), vertex_count)?;
            let (Some(joints), Some(weights)) = (joints, weights) else { break };
            sets.push((joints, weights));
        }
        let per_vertex = 4 * sets.len();
        self.document.charge(vertex_count * per_vertex, size_of::<Influence>(), &self.place)?;
        let mut influences = Vec::with_capacity(vertex_count * per_vertex);
        for vertex in 0..vertex_count {
            let start = influences.len();
            for (set, (joints, weights)) in sets.iter().enumerate() {
                for (&joint, &weight) in joints[vertex].iter().zip(&weights[vertex]) {
                    if joint > MAX_JOINT {
                        let place = format!("{}.attributes.JOINTS_{set}", self.place);
                        let problem = format!(
                            "vertex {vertex} hangs on joint {joint}, but there are at most 65536; export the file again"
                        );
                        return Err(self.document.fault(place, problem));
                    }
                    if !weight.is_finite() {
                        return Err(self.not_finite(&format!("WEIGHTS_{set}"), vertex));
                    }
                    // A joint without weight may be any number in the file.
                    let pulls = weight > 0.0;
                    let joint = if pulls { joint as u16 } else { 0 };
                    influences.push(Influence { joint, weight: weight.max(0.0) });
                }
            }
            normalise_weights(&mut influences[start..]);
        }
        Ok((influences, per_vertex))
    }

    fn read_morph_targets(&self, mesh: &mut Mesh) -> Result<(), LoadError> {
        let mut targets = Vec::with_capacity(self.primitive.targets.len());
        for (number, target) in self.primitive.targets.iter().enumerate() {
            let reader = TargetReader { reader: self, target, number, vertex_count: mesh.positions.len() };
            targets.push(reader.read(mesh)?);
        }
        mesh.morph_targets = targets;
        Ok(())
    }

    /// An attribute, if the primitive has it.
    fn floats<const N: usize>(&self, name: &str) -> Result<Option<Vec<[f32; N]>>, LoadError> {
        let Some(&accessor) = self.primitive.attributes.get(name) else { return Ok(None) };
        let place = format!("{}.attributes.{name}", self.place);
        #[cfg(feature = "draco")]
        if let Some(attribute) = self.draco.as_ref().and_then(|decoded| decoded.attributes.get(name)) {
            let normalised =
                self.document.get(&self.document.root.accessors, accessor, "accessor", &place)?.normalized;
            return attribute.floats(self.document, normalised, &place).map(Some);
        }
        self.document.floats(accessor, &place).map(Some)
    }

    fn sized_floats<const N: usize>(
        &self,
        name: &str,
        vertex_count: usize,
    ) -> Result<Option<Vec<[f32; N]>>, LoadError> {
        let values = self.floats(name)?;
        if let Some(values) = &values {
            self.check_count(values.len(), vertex_count, &format!("{}.attributes.{name}", self.place))?;
        }
        Ok(values)
    }

    /// The same, or nothing where the attribute is broken.
    fn sound_floats<const N: usize>(
        &self,
        name: &str,
        vertex_count: usize,
    ) -> Result<Option<Vec<[f32; N]>>, LoadError> {
        let values = self.sized_floats(name, vertex_count);
        Ok(self.document.salvage(values, "drawn without it")?.flatten())
    }

    fn sized_integers(&self, name: &str, vertex_count: usize) -> Result<Option<Vec<[u32; 4]>>, LoadError> {
        let Some(&accessor) = self.primitive.attributes.get(name) else { return Ok(None) };
        let place = format!("{}.attributes.{name}", self.place);
        #[cfg(feature = "draco")]
        if let Some(attribute) = self.draco.as_ref().and_then(|decoded| decoded.attributes.get(name)) {
            let values = attribute.integers(self.document, &place)?;
            self.check_count(values.len(), vertex_count, &place)?;
            return Ok(Some(values));
        }
        let values = self.document.integers(accessor, &place)?;
        self.check_count(values.len(), vertex_count, &place)?;
        Ok(Some(values))
    }

    fn check_count(&self, count: usize, vertex_count: usize, place: &str) -> Result<(), LoadError> {
        if count == vertex_count {
            return Ok(());
        }
        let problem = format!("there are {count} values for {vertex_count} positions; export the file again");
        Err(self.document.fault(place, problem))
    }

    fn not_finite(&self, name: &str, vertex: usize) -> LoadError {
        let accessor = self.primitive.attributes.get(name).copied().unwrap_or_default();
        self.document.fault(format!("{}.attributes.{name}", self.place), not_finite_text(accessor, vertex))
    }
}

/// One morph target of a primitive.
struct TargetReader<'r, 'd, 'a> {
    reader: &'r Reader<'d, 'a>,
    target: &'d BTreeMap<String, Index>,
    number: usize,
    vertex_count: usize,
}

impl TargetReader<'_, '_, '_> {
    fn read(&self, mesh: &Mesh) -> Result<MorphTarget, LoadError> {
        let mut morphs = MorphTarget::default();
        for (name, &accessor) in self.target {
            let uv_set: Option<usize> = name.strip_prefix("TEXCOORD_").and_then(|set| set.parse().ok());
            match (name.as_str(), uv_set) {
                ("POSITION", _) => morphs.positions = self.deltas(name, accessor, Vec3::from_array)?,
                ("NORMAL", _) if !mesh.normals.is_empty() => {
                    morphs.normals = self.deltas(name, accessor, Vec3::from_array)?;
                }
                ("TANGENT", _) if !mesh.tangents.is_empty() => {
                    morphs.tangents = self.deltas(name, accessor, Vec3::from_array)?;
                }
                // There is nothing to displace: those that are made follow positions and coordinates.
                ("NORMAL" | "TANGENT", _) => {}
                ("COLOR_0", _) if !mesh.colours.is_empty() => {
                    let components = self
                        .reader
                        .document
                        .root
                        .accessors
                        .get(accessor)
                        .map_or(0, Accessor::component_count);
                    morphs.colours = if components == 3 {
                        self.deltas(name, accessor, |[r, g, b]| Vec4::new(r, g, b, 0.0))?
                    } else {
                        self.deltas(name, accessor, Vec4::from_array)?
                    };
                }
                (_, Some(set)) if set < mesh.uv_sets.len() => {
                    morphs.uv_sets.resize(morphs.uv_sets.len().max(set + 1), Vec::new());
                    morphs.uv_sets[set] = self.deltas(name, accessor, Vec2::from_array)?;
                }
                // An application's own.
                (name, _) if name.starts_with('_') => {}
                (name, _) => {
                    let document = self.reader.document;
                    let (place, attribute) = (document.titled(&self.reader.place), name.to_owned());
                    document.warn(LoadWarning::MorphIgnored { place, attribute });
                }
            }
        }
        Ok(morphs)
    }

    /// Displacements of an attribute; none where they are broken, 0 where they are not finite.
    fn deltas<const N: usize, T>(
        &self,
        name: &str,
        accessor: Index,
        convert: impl Fn([f32; N]) -> T,
    ) -> Result<Vec<T>, LoadError> {
        let Self { reader, number, vertex_count, .. } = *self;
        let document = reader.document;
        let place = format!("{}.targets[{number}].{name}", reader.place);
        let read = document.floats::<N>(accessor, &place).and_then(|deltas| {
            reader.check_count(deltas.len(), vertex_count, &place)?;
            Ok(deltas)
        });
        let mut deltas = document.salvage(read, "it does not move")?.unwrap_or_default();
        let is_wild = |delta: &[f32; N]| delta.iter().any(|value| !value.is_finite());
        if let Some(vertex) = deltas.iter().position(is_wild) {
            let fault = document.fault(&place, not_finite_text(accessor, vertex));
            document.lose(fault, "such vertices do not move")?;
            deltas.iter_mut().filter(|delta| is_wild(delta)).for_each(|delta| *delta = [0.0; N]);
        }
        Ok(deltas.into_iter().map(convert).collect())
    }
}

fn not_finite_text(accessor: Index, element: usize) -> String {
    format!(
        "element {element} of accessor {accessor} is not finite; repair the mesh and export the file again"
    )
}

/// Weights that sum to one; a vertex that nothing pulls hangs on its first joint.
fn normalise_weights(influences: &mut [Influence]) {
    let sum: f32 = influences.iter().map(|influence| influence.weight).sum();
    if sum > 0.0 && sum.is_finite() {
        influences.iter_mut().for_each(|influence| influence.weight /= sum);
    } else if let Some(first) = influences.first_mut() {
        first.weight = 1.0;
    }
}

/// Area-weighted normals of the triangles around each vertex that has none.
fn fill_missing_normals(mesh: &mut Mesh) {
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.indices {
        let [a, b, c] = triangle.map(|index| mesh.positions[index as usize]);
        let doubled_area = (b - a).cross(c - a);
        for &index in triangle {
            sums[index as usize] += doubled_area;
        }
    }
    for (normal, sum) in mesh.normals.iter_mut().zip(sums) {
        if *normal == Vec3::ZERO {
            *normal = sum.normalize_or(Vec3::Y);
        }
    }
}

/// Leaves out the vertices that no triangle has, and says how many bytes they took.
fn leave_out_unused(mesh: &mut Mesh) -> usize {
    fn pick<T: Copy>(list: &mut Vec<T>, used: &[usize], per_vertex: usize) -> usize {
        if list.is_empty() {
            return 0;
        }
        let all_bytes = size_of_val(list.as_slice());
        let values = used.iter().flat_map(|&vertex| &list[vertex * per_vertex..][..per_vertex]);
        *list = values.copied().collect();
        all_bytes.saturating_sub(size_of_val(list.as_slice()))
    }
    let mut new_index: Vec<Option<u32>> = vec![None; mesh.positions.len()];
    let mut used: Vec<usize> = Vec::new();
    for corner in mesh.indices.iter_mut().flatten() {
        let old = *corner as usize;
        *corner = *new_index[old].get_or_insert_with(|| {
            used.push(old);
            used.len() as u32 - 1
        });
    }
    let Mesh {
        name: _,
        material: _,
        positions,
        normals,
        tangents,
        uv_sets,
        colours,
        indices: _,
        influences,
        influences_per_vertex,
        morph_targets,
    } = mesh;
    let mut bytes = pick(positions, &used, 1) + pick(normals, &used, 1) + pick(tangents, &used, 1);
    bytes += uv_sets.iter_mut().map(|set| pick(set, &used, 1)).sum::<usize>();
    bytes += pick(colours, &used, 1) + pick(influences, &used, *influences_per_vertex);
    for MorphTarget { positions, normals, tangents, colours, uv_sets } in morph_targets {
        bytes += pick(positions, &used, 1) + pick(normals, &used, 1) + pick(tangents, &used, 1);
        bytes += pick(colours, &used, 1);
        bytes += uv_sets.iter_mut().map(|set| pick(set, &used, 1)).sum::<usize>();
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_or_rest_on_the_first_joint() {
        let pull = |weight| Influence { joint: 7, weight };
        let mut influences = [pull(0.5), pull(1.5), pull(0.0)];
        normalise_weights(&mut influences);
        assert_eq!(influences.map(|influence| influence.weight), [0.25, 0.75, 0.0]);
        let mut nothing = [pull(0.0); 2];
        normalise_weights(&mut nothing);
        assert_eq!(nothing.map(|influence| influence.weight), [1.0, 0.0]);
    }

    #[test]
    fn unused_vertices_are_left_out_of_every_list() {
        let place = |vertex: usize| Vec3::splat(vertex as f32);
        let places: Vec<Vec3> = (0..9).map(place).collect();
        let mut mesh = Mesh {
            positions: places.clone(),
            normals: places.clone(),
            tangents: places.iter().map(|place| place.extend(1.0)).collect(),
            uv_sets: vec![Vec::new(), places.iter().map(|place| place.truncate()).collect()],
            colours: places.iter().map(|place| place.extend(0.5)).collect(),
            indices: vec![[8, 2, 4], [4, 2, 8]],
            influences: (0..36).map(|at| Influence { joint: at / 4, weight: 0.25 }).collect(),
            influences_per_vertex: 4,
            morph_targets: vec![MorphTarget { positions: places.clone(), ..MorphTarget::default() }],
            ..Mesh::default()
        };
        // Six of nine vertices, with three vectors, two of four, one of two, four influences and a target.
        assert_eq!(leave_out_unused(&mut mesh), 6 * (3 * 12 + 2 * 16 + 8 + 4 * 8));
        let kept = [8, 2, 4].map(place);
        assert_eq!(mesh.indices, [[0, 1, 2], [2, 1, 0]]);
        assert_eq!((mesh.positions, mesh.normals), (kept.to_vec(), kept.to_vec()));
        assert_eq!(mesh.tangents, kept.map(|place| place.extend(1.0)));
        assert_eq!(mesh.uv_sets, [vec![], kept.map(|place| place.truncate()).to_vec()]);
        assert_eq!(mesh.colours, kept.map(|place| place.extend(0.5)));
        assert_eq!(
            mesh.influences.iter().map(|influence| influence.joint).collect::<Vec<_>>(),
            [8, 8, 8, 8, 2, 2, 2, 2, 4, 4, 4, 4]
        );
        assert_eq!(mesh.morph_targets[0].positions, kept);
        assert!(mesh.morph_targets[0].normals.is_empty());
    }

    #[test]
    fn a_missing_normal_comes_from_the_triangles() {
        let mut mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::X, Vec3::ZERO, Vec3::ZERO],
            indices: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        fill_missing_normals(&mut mesh);
        assert_eq!(mesh.normals, [Vec3::X, Vec3::Z, Vec3::Z]);
    }
}
