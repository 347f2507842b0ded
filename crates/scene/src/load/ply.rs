//! PLY (Turk, *The PLY Polygon File Format*, 1994): text and binary of both byte orders; triangles, polygons
//! and triangle strips, with normals, colours with alpha, and texture coordinates of vertices.
//!
//! Read by hand: elements go straight into arrays, and what a header promises is held against the size of
//! the file before anything is allocated. Colours are taken as meant for the display, as scanners and editors
//! write them.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};
use sheer_core::colour::linear_from_srgb;

use super::{
    Loaded,
    crease::{Smoothing, corner_normals},
    single::{self, GREY},
    source::Source,
    stroke::{self, Sketch, Strokes},
    text::{number, shown, words},
};
use crate::{
    SceneError,
    model::{Mesh, Transform},
};

/// A file begins with this word.
pub(super) const SIGNATURE: &[u8; 3] = b"ply";

/// Types of numbers, under their old and new names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn from_word(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// What stands for 1 where numbers are shares of a whole.
    fn whole(self) -> f64 {
        match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::I32 => i32::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

struct Property {
    name: String,
    kind: Kind,
    /// The type of a list's length; none of a single number.
    length: Option<Kind>,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

impl Element {
    fn property(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|property| {
            property.length.is_none() && names.iter().any(|name| property.name.eq_ignore_ascii_case(name))
        })
    }
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// What comes after the header, read number by number.
struct Body<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    /// Number of the line, of text.
    line: usize,
}

impl Body<'_> {
    /// Where the next number is, for messages.
    fn place(&self) -> String {
        match self.encoding {
            Encoding::Text => format!("line {}", self.line),
            _ => format!("byte {}", self.at),
        }
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next number.
    fn number(&mut self, kind: Kind) -> Result<f64, String> {
        const CUT_SHORT: &str = "the file ends before its last element; copy or export it again";
        if self.encoding == Encoding::Text {
            while let Some(byte) = self.bytes.get(self.at).filter(|byte| byte.is_ascii_whitespace()) {
                self.line += usize::from(*byte == b'\n');
                self.at += 1;
            }
            let rest = &self.bytes[self.at..];
            let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
            if end == 0 {
                return Err(CUT_SHORT.to_owned());
            }
            self.at += end;
            return number(&rest[..end]);
        }
        let mut word = [0; 8];
        let size = kind.bytes();
        let bytes = self.bytes.get(self.at..self.at + size).ok_or(CUT_SHORT)?;
        word[..size].copy_from_slice(bytes);
        if self.encoding == Encoding::BigEndian {
            word[..size].reverse();
        }
        self.at += size;
        let [a, b, c, d, ..] = word;
        let four = [a, b, c, d];
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes([a]).into(),
            Kind::U8 => a.into(),
            Kind::I16 => i16::from_le_bytes([a, b]).into(),
            Kind::U16 => u16::from_le_bytes([a, b]).into(),
            Kind::I32 => i32::from_le_bytes(four).into(),
            Kind::U32 => u32::from_le_bytes(four).into(),
            Kind::F32 => f32::from_le_bytes(four).into(),
            Kind::F64 => f64::from_le_bytes(word),
        })
    }

    /// The length of a list, which must fit into what is left.
    fn length(&mut self, kind: Kind) -> Result<usize, String> {
        let length = self.number(kind)?;
        let fits = length >= 0.0 && length <= self.left() as f64 && length.fract() == 0.0;
        fits.then_some(length as usize).ok_or_else(|| {
            format!("a list of {length} elements is more than the file holds; export it again")
        })
    }
}

/// What is drawn of a file.
#[derive(Default)]
struct Model {
    mesh: Mesh,
    /// Vertices with a position that is not finite.
    broken: Vec<bool>,
    edges: Vec<[u32; 2]>,
    dropped_count: usize,
    has_colours: bool,
}

pub(super) fn read(bytes: &[u8], source: Source<'_>) -> Result<Loaded, SceneError> {
    let (elements, mut body) = read_header(bytes).map_err(|(place, problem)| source.fault(place, problem))?;
    let mut model = Model::default();
    for element in &elements {
        // Each element takes at least a byte.
        if !element.properties.is_empty() && element.count > body.left() {
            let problem = format!(
                "{} of '{}' are promised, but only {} bytes follow; copy or export the file again",
                element.count,
                shown(element.name.as_bytes()),
                body.left()
            );
            return Err(source.fault(body.place(), problem));
        }
        let outcome = match element.name.as_str() {
            "vertex" => read_vertices(element, &mut body, &mut model),
            "face" => read_faces(element, &mut body, &mut model),
            "tristrips" => read_strips(element, &mut body, &mut model),
            "edge" => read_edges(element, &mut body, &mut model),
            _ => {
                source.repaired(
                    format_args!("element '{}'", shown(element.name.as_bytes())),
                    "it is not drawn",
                );
                skip(element, &mut body)
            }
        };
        outcome.map_err(|problem| source.fault(body.place(), problem))?;
        source.check_triangle_count(model.mesh.indices.len(), &element.name)?;
    }
    if model.dropped_count > 0 {
        let what = format!(
            "{} with a vertex that is not there or not finite were left out",
            if model.dropped_count == 1 {
                "one face".to_owned()
            } else {
                format!("{} faces", model.dropped_count)
            }
        );
        source.repaired("faces", what);
    }
    for (at, _) in model.broken.iter().enumerate().filter(|(_, broken)| **broken) {
        model.mesh.positions[at] = Vec3::ZERO;
    }
    let base_colour = if model.has_colours { Vec4::ONE } else { GREY };
    let mut parts = source.parts();
    if !model.mesh.indices.is_empty() {
        complete_normals(&mut model.mesh);
        single::place(&mut parts, model.mesh, base_colour, Transform::IDENTITY);
        return source.finish(parts);
    }
    // Without faces the vertices themselves are meant, or the edges between them.
    let sound = (0..model.mesh.positions.len() as u32).filter(|&vertex| !model.broken[vertex as usize]);
    let mut strokes =
        if model.edges.is_empty() { Strokes::Points(sound.collect()) } else { Strokes::Lines(model.edges) };
    if let Some(said) = strokes.thin_out() {
        source.repaired("vertices", said);
    }
    single::place(&mut parts, model.mesh, base_colour, Transform::IDENTITY);
    stroke::draw(&mut parts, vec![Sketch { mesh: 0, strokes }]);
    source.finish(parts)
}

/// Elements and what follows them; a fault is a place and a problem.
fn read_header(bytes: &[u8]) -> Result<(Vec<Element>, Body<'_>), (String, String)> {
    let mut elements: Vec<Element> = Vec::new();
    let mut encoding = None;
    let mut at = 0;
    for line_number in 1.. {
        let place = || format!("line {line_number}");
        let fault = |problem: String| (place(), format!("{problem}; export the file again"));
        let rest = &bytes[at..];
        let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let end = end.ok_or_else(|| fault("the header has no end: 'end_header' is missing".to_owned()))?;
        let line = &rest[..end];
        at += end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
        let found: Vec<&[u8]> = words(line).take(6).collect();
        match found[..] {
            [b"ply"] if line_number == 1 => {}
            _ if line_number == 1 => {
                return Err(fault("this is no PLY file: it does not begin with 'ply'".to_owned()));
            }
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", word, ..] => {
                encoding = Some(match word {
                    b"ascii" => Encoding::Text,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(fault(format!("'{}' is no format of PLY", shown(word)))),
                });
            }
            [b"element", name, count, ..] => {
                let count = number(count).map_err(|problem| (place(), problem))?;
                let name = String::from_utf8_lossy(name).into_owned();
                elements.push(Element { name, count, properties: Vec::new() });
            }
            [b"property", ref described @ ..] => {
                let kind = |word: &[u8]| {
                    Kind::from_word(word).ok_or_else(|| fault(format!("'{}' is no type of PLY", shown(word))))
                };
                let (name, kind, length) = match *described {
                    [b"list", length, of, name] => (name, kind(of)?, Some(kind(length)?)),
                    [of, name] => (name, kind(of)?, None),
                    _ => return Err(fault("a property needs a type and a name".to_owned())),
                };
                let element = elements.last_mut();
                let element =
                    element.ok_or_else(|| fault("a property stands before the first element".to_owned()))?;
                let name = String::from_utf8_lossy(name).into_owned();
                element.properties.push(Property { name, kind, length });
            }
            [b"end_header", ..] => {
                let encoding = encoding.ok_or_else(|| fault("the header names no format".to_owned()))?;
                return Ok((elements, Body { bytes, at, encoding, line: line_number + 1 }));
            }
            [word, ..] => return Err(fault(format!("'{}' is no word of a PLY header", shown(word)))),
        }
    }
    unreachable!("a file ends before line numbers do");
}

fn skip(element: &Element, body: &mut Body<'_>) -> Result<(), String> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            read_property(property, body, |_| ())?;
        }
    }
    Ok(())
}

/// Reads a number, or each number of a list.
fn read_property(property: &Property, body: &mut Body<'_>, mut take: impl FnMut(f64)) -> Result<(), String> {
    let count = match property.length {
        Some(length) => body.length(length)?,
        None => 1,
    };
    for _ in 0..count {
        take(body.number(property.kind)?);
    }
    Ok(())
}

fn read_vertices(element: &Element, body: &mut Body<'_>, model: &mut Model) -> Result<(), String> {
    if !model.mesh.positions.is_empty() {
        return Err("there are two lists of vertices; export the file again".to_owned());
    }
    let position = ["x", "y", "z"].map(|name| element.property(&[name]));
    let [Some(x), Some(y), Some(z)] = position else {
        return Err("its vertices have no x, y and z; export the file again".to_owned());
    };
    let all = |names: [&[&str]; 3]| match names.map(|names| element.property(names)) {
        [Some(a), Some(b), Some(c)] => Some([a, b, c]),
        _ => None,
    };
    let normal = all([&["nx", "normal_x"], &["ny", "normal_y"], &["nz", "normal_z"]]);
    let colour =
        all([&["red", "r", "diffuse_red"], &["green", "g", "diffuse_green"], &["blue", "b", "diffuse_blue"]]);
    let alpha = element.property(&["alpha", "a", "diffuse_alpha"]);
    let uv = [&["u", "s", "texture_u", "texcoord_u"][..], &["v", "t", "texture_v", "texcoord_v"]]
        .map(|names| element.property(names));
    model.has_colours = colour.is_some();
    let mesh = &mut model.mesh;
    if uv.iter().all(Option::is_some) {
        mesh.uv_sets.push(Vec::new());
    }

    let mut values = vec![0.0; element.properties.len()];
    for _ in 0..element.count {
        for (value, property) in values.iter_mut().zip(&element.properties) {
            // Of a list the last element is kept, which nobody asks for.
            read_property(property, body, |read| *value = read)?;
        }
        let vector = |[x, y, z]: [usize; 3]| Vec3::new(values[x] as f32, values[y] as f32, values[z] as f32);
        let share = |at: usize| {
            let share = (values[at] / element.properties[at].kind.whole()) as f32;
            if share > 0.0 { share.min(1.0) } else { 0.0 }
        };
        let position = vector([x, y, z]);
        model.broken.push(!position.is_finite());
        mesh.positions.push(position);
        if let Some(normal) = normal {
            mesh.normals.push(vector(normal).try_normalize().unwrap_or(Vec3::ZERO));
        }
        if colour.is_some() || alpha.is_some() {
            let rgb =
                colour.map_or(Vec3::ONE, |colour| Vec3::from(colour.map(|at| linear_from_srgb(share(at)))));
            mesh.colours.push(rgb.extend(alpha.map_or(1.0, share)));
        }
        if let ([Some(u), Some(v)], [set]) = (uv, &mut mesh.uv_sets[..]) {
            let uv = Vec2::new(values[u] as f32, 1.0 - values[v] as f32);
            set.push(if uv.is_finite() { uv } else { Vec2::ZERO });
        }
    }
    Ok(())
}

/// The property that holds the vertices of a face or a strip.
fn vertex_list(element: &Element) -> Result<usize, String> {
    let is_list = |property: &Property| {
        property.length.is_some() && matches!(property.name.as_str(), "vertex_indices" | "vertex_index")
    };
    element
        .properties
        .iter()
        .position(is_list)
        .ok_or_else(|| format!("its '{}' have no list vertex_indices; export the file again", element.name))
}

/// Calls `polygon` with the vertices of each element.
fn for_each_list(
    element: &Element,
    body: &mut Body<'_>,
    mut polygon: impl FnMut(&[f64]),
) -> Result<(), String> {
    if element.count == 0 {
        return Ok(());
    }
    let list = vertex_list(element)?;
    let mut corners = Vec::new();
    for _ in 0..element.count {
        corners.clear();
        for (at, property) in element.properties.iter().enumerate() {
            read_property(property, body, |value| {
                if at == list {
                    corners.push(value);
                }
            })?;
        }
        polygon(&corners);
    }
    Ok(())
}

impl Model {
    /// Whether there is a vertex of that number, at a finite place.
    fn is_sound(&self, vertex: f64) -> bool {
        let count = self.mesh.positions.len();
        vertex >= 0.0 && vertex < count as f64 && vertex.fract() == 0.0 && !self.broken[vertex as usize]
    }

    /// Adds a triangle if its vertices are sound.
    fn add(&mut self, corners: [f64; 3]) -> bool {
        let is_sound = corners.into_iter().all(|corner| self.is_sound(corner));
        if is_sound {
            self.mesh.indices.push(corners.map(|corner| corner as u32));
        }
        is_sound
    }
}

fn read_faces(element: &Element, body: &mut Body<'_>, model: &mut Model) -> Result<(), String> {
    for_each_list(element, body, |corners| {
        // A polygon is a fan around its first vertex.
        let mut whole = corners.len() >= 3;
        for at in 2..corners.len() {
            whole &= model.add([corners[0], corners[at - 1], corners[at]]);
        }
        model.dropped_count += usize::from(!whole);
    })
}

fn read_strips(element: &Element, body: &mut Body<'_>, model: &mut Model) -> Result<(), String> {
    for_each_list(element, body, |corners| {
        // A negative number begins a new strip; every second triangle is turned around.
        for strip in corners.split(|&corner| corner < 0.0) {
            for (at, window) in strip.windows(3).enumerate() {
                let [a, b, c] = [window[0], window[1], window[2]];
                let sound = model.add(if at % 2 == 0 { [a, b, c] } else { [b, a, c] });
                model.dropped_count += usize::from(!sound);
            }
        }
    })
}

fn read_edges(element: &Element, body: &mut Body<'_>, model: &mut Model) -> Result<(), String> {
    let ends = ["vertex1", "vertex2"].map(|name| element.property(&[name]));
    let [Some(from), Some(to)] = ends else { return skip(element, body) };
    let mut values = vec![0.0; element.properties.len()];
    for _ in 0..element.count {
        for (value, property) in values.iter_mut().zip(&element.properties) {
            read_property(property, body, |read| *value = read)?;
        }
        let ends = [values[from], values[to]];
        if ends.into_iter().all(|end| model.is_sound(end)) {
            model.edges.push(ends.map(|end| end as u32));
        } else {
            model.dropped_count += 1;
        }
    }
    Ok(())
}

/// Makes the normals that a file lacks; vertices at creases are divided.
fn complete_normals(mesh: &mut Mesh) {
    if !mesh.normals.is_empty() && !mesh.normals.contains(&Vec3::ZERO) {
        return;
    }
    let made = corner_normals(&mesh.positions, &mesh.indices, |_| Smoothing::Angle);
    let given = std::mem::take(&mut mesh.normals);
    let mut divided = Mesh { uv_sets: vec![Vec::new(); mesh.uv_sets.len()], ..Mesh::default() };
    let mut vertex_of: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    for (corners, made) in mesh.indices.iter().zip(made) {
        let vertices = std::array::from_fn(|corner| {
            let vertex = corners[corner] as usize;
            let normal = given.get(vertex).copied().filter(|given| *given != Vec3::ZERO);
            // Of an empty face any will do.
            let normal = normal.unwrap_or(made[corner]).try_normalize().unwrap_or(Vec3::Y);
            let key = (corners[corner], normal.to_array().map(f32::to_bits));
            *vertex_of.entry(key).or_insert_with(|| {
                divided.positions.push(mesh.positions[vertex]);
                divided.normals.push(normal);
                divided.colours.extend(mesh.colours.get(vertex));
                for (to, from) in divided.uv_sets.iter_mut().zip(&mesh.uv_sets) {
                    to.push(from[vertex]);
                }
                divided.positions.len() as u32 - 1
            })
        });
        divided.indices.push(vertices);
    }
    *mesh = divided;
}
