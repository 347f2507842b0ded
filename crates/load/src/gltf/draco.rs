//! `KHR_draco_mesh_compression`, decoded by the `draco-oxide` crates.
//!
//! A few bytes of Draco can stand for any number of triangles, and the decoder trusts the counts in the
//! stream. So they are read here first and held against the accessors, which have to state the same counts
//! (extension, "Conformance") and are paid for; the other numbers that cost memory are found by
//! [`draco_walk`].

use std::collections::BTreeMap;

use sheer_core::caught_panic;

use super::{
    accessor::Component,
    document::Document,
    draco_walk::{self, Walk},
    schema::{self, Primitive},
};
use crate::LoadError;

/// Bytes before the metadata or the connectivity (Draco bitstream specification, section 4).
const HEADER_BYTES: usize = 11;
/// Where in the header the flags lie, and which of them announces metadata.
const FLAGS: std::ops::Range<usize> = 9..11;
const METADATA_FLAG: u16 = 0x8000;
/// What the decoder takes for a triangle while it works on the connectivity: corners, their opposites, seams.
const BYTES_PER_TRIANGLE: usize = 128;

/// A primitive after decompression.
pub(super) struct Decoded {
    /// Vertex indices, three a triangle.
    pub indices: Vec<u32>,
    /// Attributes by the name that glTF gives them.
    pub attributes: BTreeMap<String, Attribute>,
}

/// A vertex attribute, one element a vertex, tightly packed.
pub(super) struct Attribute {
    component: Component,
    components: usize,
    bytes: Vec<u8>,
}

/// Decodes the triangles and attributes of a primitive; `None` if it is not compressed.
pub(super) fn decode(
    document: &Document<'_>,
    primitive: &Primitive,
    place: &str,
) -> Result<Option<Decoded>, LoadError> {
    let Some(extension) = &primitive.extensions.draco else { return Ok(None) };
    let place = format!("{place}.extensions.KHR_draco_mesh_compression");
    let fault = |problem: &str| document.fault(&place, format!("{problem}; compress the file again"));
    let (data, _) = document.view(extension.buffer_view, &place)?;

    // What the accessors promise.
    let accessor_count = |accessor: Option<usize>| -> Result<usize, LoadError> {
        let Some(accessor) = accessor else { return Ok(0) };
        Ok(document.get(&document.root.accessors, accessor, "accessor", &place)?.count)
    };
    let index_count = accessor_count(primitive.indices)?;
    let vertex_count = accessor_count(primitive.attributes.get("POSITION").copied())?;
    let stream = without_metadata(data).ok_or_else(|| fault("the Draco metadata is cut short"))?;
    let counts =
        Counts::read(&stream).ok_or_else(|| fault("the Draco header is cut short or of an unknown kind"))?;
    if counts.triangles.checked_mul(3) != Some(index_count) || !counts.plausible(vertex_count) {
        return Err(fault(
            "the Draco data holds other numbers of triangles or vertices than the accessors say",
        ));
    }
    document.charge(counts.triangles, BYTES_PER_TRIANGLE, &place)?;

    // The decoder is young: whatever invariant of its own it finds broken by bad data must not end the
    // program.
    let attempt = caught_panic::catch(|| decode_stream(&stream));
    let mesh = attempt
        .unwrap_or_else(|_| Err("the Draco data is damaged".to_owned()))
        .map_err(|problem| fault(&problem))?;
    let points = Points::of(&mesh, vertex_count)
        .ok_or_else(|| fault("a triangle refers to a vertex that is not there"))?;
    collect(document, extension, &mesh, &points, &place).map(Some)
}

/// The numbers at the head of the connectivity.
struct Counts {
    triangles: usize,
    /// How many vertices or points the stream says it holds.
    vertices: usize,
    /// Edgebreaker symbols and splits; zero for sequential connectivity.
    symbols: usize,
    splits: usize,
}

impl Counts {
    /// Reads the connectivity header (Draco bitstream specification, sections 5 and 6).
    fn read(stream: &[u8]) -> Option<Self> {
        let (header, rest) = stream.split_at_checked(HEADER_BYTES)?;
        let mut walk = Walk(rest);
        match header[8] {
            0 => {
                let triangles = walk.varint()?;
                Some(Self { triangles, vertices: walk.varint()?, symbols: 0, splits: 0 })
            }
            1 => {
                let _traversal = walk.byte()?;
                let (vertices, triangles) = (walk.varint()?, walk.varint()?);
                let _attribute_data = walk.byte()?;
                Some(Self { triangles, vertices, symbols: walk.varint()?, splits: walk.varint()? })
            }
            _ => None,
        }
    }

    /// Whether a mesh of so many vertices can have these counts. Vertices with seams are counted once in the
    /// connectivity.
    fn plausible(&self, vertex_count: usize) -> bool {
        self.vertices <= vertex_count && self.symbols <= self.triangles && self.splits <= self.symbols
    }
}

/// Decodes a stream whose counts are known to be affordable.
fn decode_stream(stream: &[u8]) -> Result<draco_oxide_core::mesh::Mesh, String> {
    draco_walk::check(stream).ok_or("the Draco data is damaged or of a kind that is not read")?;
    draco_oxide_decoder::decode_mesh(stream).map_err(|error| error.to_string())
}

/// The points of a decoded mesh that are vertices. Encoders that reorder a mesh may leave numbers of points
/// unused, so that the greatest is beyond the number of vertices.
struct Points {
    /// How many vertices.
    count: usize,
    /// The points in use, ascending, where they are not the first `count`.
    used: Option<Vec<usize>>,
}

impl Points {
    /// `None` if more than `vertex_count` points are in use.
    fn of(mesh: &draco_oxide_core::mesh::Mesh, vertex_count: usize) -> Option<Self> {
        let points = || mesh.faces.iter().flatten().map(|&point| usize::from(point));
        if points().all(|point| point < vertex_count) {
            return Some(Self { count: vertex_count, used: None });
        }
        let mut used: Vec<usize> = points().collect();
        used.sort_unstable();
        used.dedup();
        (used.len() <= vertex_count).then_some(Self { count: used.len(), used: Some(used) })
    }

    fn of_vertex(&self, vertex: usize) -> usize {
        self.used.as_ref().map_or(vertex, |used| used[vertex])
    }

    /// Of a point in use.
    fn vertex_of(&self, point: usize) -> u32 {
        let rank = self.used.as_ref().map_or(Ok(point), |used| used.binary_search(&point));
        rank.unwrap_or_default() as u32
    }
}

/// Attributes by name, spread to one element a vertex.
fn collect(
    document: &Document<'_>,
    extension: &schema::Draco,
    mesh: &draco_oxide_core::mesh::Mesh,
    points: &Points,
    place: &str,
) -> Result<Decoded, LoadError> {
    let fault = |problem: String| document.fault(place, format!("{problem}; compress the file again"));
    let mut attributes = BTreeMap::new();
    for (name, &id) in &extension.attributes {
        let found = mesh.attributes.iter().find(|attribute| attribute.get_id().as_usize() == id as usize);
        let found = found.ok_or_else(|| fault(format!("there is no attribute {id} for {name}")))?;
        let component = Component::from_draco(found.get_component_type());
        let component =
            component.ok_or_else(|| fault(format!("{name} is of a type that glTF does not have")))?;
        let components = found.get_num_components();
        let element_bytes = components * component.size();
        document.charge(points.count, element_bytes, place)?;
        let unique = found.get_data_as_bytes();
        let mut bytes = Vec::with_capacity(points.count * element_bytes);
        for point in (0..points.count).map(|vertex| points.of_vertex(vertex)) {
            // Vertices share values through a map, or have their own.
            let value = match found.point_map_as_slice() {
                Some(map) => map.get(point).map(|&value| usize::from(value)),
                None => Some(point),
            };
            let element =
                value.and_then(|value| unique.get(value * element_bytes..(value + 1) * element_bytes));
            bytes.extend_from_slice(
                element.ok_or_else(|| fault(format!("{name} has fewer values than vertices")))?,
            );
        }
        attributes.insert(name.clone(), Attribute { component, components, bytes });
    }
    let indices = mesh.faces.iter().flatten().map(|&point| points.vertex_of(usize::from(point))).collect();
    Ok(Decoded { indices, attributes })
}

impl Attribute {
    /// Elements as numbers; `normalised` is the accessor's flag.
    pub(super) fn floats<const N: usize>(
        &self,
        document: &Document<'_>,
        normalised: bool,
        place: &str,
    ) -> Result<Vec<[f32; N]>, LoadError> {
        self.elements(document, place, |bytes| self.component.float(bytes, normalised))
    }

    /// Elements as unsigned integers.
    pub(super) fn integers<const N: usize>(
        &self,
        document: &Document<'_>,
        place: &str,
    ) -> Result<Vec<[u32; N]>, LoadError> {
        if !self.component.is_unsigned() {
            return Err(document.fault(
                place,
                "the Draco attribute does not hold unsigned integers; compress the file again",
            ));
        }
        self.elements(document, place, |bytes| self.component.unsigned(bytes))
    }

    fn elements<T, const N: usize>(
        &self,
        document: &Document<'_>,
        place: &str,
        convert: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<[T; N]>, LoadError> {
        if self.components != N {
            let problem = format!(
                "the Draco attribute has {} components instead of {N}; compress the file again",
                self.components
            );
            return Err(document.fault(place, problem));
        }
        let size = self.component.size();
        let elements = self.bytes.chunks_exact(N * size);
        document.charge(elements.len(), size_of::<[T; N]>(), place)?;
        Ok(elements.map(|element| std::array::from_fn(|at| convert(&element[at * size..]))).collect())
    }
}

/// The stream with its metadata, which glTF has no use for, cut out (Draco bitstream specification, section
/// 4.2).
fn without_metadata(data: &[u8]) -> Option<Vec<u8>> {
    let (header, rest) = data.split_at_checked(HEADER_BYTES)?;
    let mut walk = Walk(rest);
    let mut stream = header.to_vec();
    let flags = u16::from_le_bytes([header[FLAGS.start], header[FLAGS.start + 1]]);
    if flags & METADATA_FLAG != 0 {
        stream[FLAGS].copy_from_slice(&(flags & !METADATA_FLAG).to_le_bytes());
        // One tree for each attribute listed, after the attribute's id, then one for the whole geometry.
        for _ in 0..walk.varint()? {
            walk.varint()?;
            skip_metadata_tree(&mut walk)?;
        }
        skip_metadata_tree(&mut walk)?;
    }
    stream.extend_from_slice(walk.0);
    Some(stream)
}

/// Skips names, values and subtrees, which follow each other depth first, by counting the subtrees still to
/// come on each level.
fn skip_metadata_tree(walk: &mut Walk<'_>) -> Option<()> {
    let mut open = vec![1_usize];
    let mut is_root = true;
    while let Some(trees) = open.last_mut() {
        let Some(left) = trees.checked_sub(1) else {
            open.pop();
            continue;
        };
        *trees = left;
        if !std::mem::take(&mut is_root) {
            let name_bytes = walk.byte()?;
            walk.take(usize::from(name_bytes))?;
        }
        for _ in 0..walk.varint()? {
            let name_bytes = walk.byte()?;
            walk.take(usize::from(name_bytes))?;
            let value_bytes = walk.varint()?;
            walk.take(value_bytes)?;
        }
        open.push(walk.varint()?);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_is_cut_out_at_any_depth() {
        let header = |flags: u16| [b"DRACO\x02\x02\x01\x01".as_slice(), &flags.to_le_bytes()].concat();
        // One attribute with an entry; a geometry tree with a subtree in a subtree.
        let metadata = b"\x01\x07\x01\x01k\x02vv\x00\x00\x01\x01a\x00\x01\x01b\x01\x01k\x00\x00";
        let data = [header(METADATA_FLAG).as_slice(), metadata, b"rest"].concat();
        assert_eq!(without_metadata(&data).unwrap(), [header(0).as_slice(), b"rest"].concat());
        for length in 0..data.len() - 4 {
            assert!(without_metadata(&data[..length]).is_none(), "{length}");
        }
    }
}
