//! PLY (Turk, *The PLY Polygon File Format*, 1994): text and binary of both byte orders; triangles, polygons
//! and triangle strips, with normals, colours with alpha, and texture coordinates of vertices.
//!
//! Read by hand: elements go straight into arrays, and what a header promises is held against the size of
//! the file before anything is allocated. Colours are taken as meant for the display, as scanners and editors
//! write them; those of faces count where vertices have none. A file that is cut short is drawn up to there.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};
use sheer_scene::model::{Mesh, Transform};

use super::{
    Loaded,
    crease::{self, Smoothing, corner_normals},
    polygon::Cutter,
    single::{self, GREY},
    source::Source,
    stroke::{self, Sketch, Strokes},
    text::{number, shown, words},
    vertex_colour::{linear, whole_of_shares},
};
use crate::LoadError;

/// A file begins with this word.
pub(super) const SIGNATURE: &[u8; 3] = b"ply";
/// Names of properties that messages list.
const MOST_NAMES: usize = 8;
/// Bytes of a vertex with all that it may have, of a triangle and of an edge, in lists that double as they
/// grow.
const VERTEX_BYTES: usize = 2 * (12 + 12 + 16 + 8 + 1);
const TRIANGLE_BYTES: usize = 2 * (size_of::<[u32; 3]>() + size_of::<Vec4>());
const EDGE_BYTES: usize = 4 * size_of::<[u32; 2]>();
/// Bytes of a vertex that is divided at a crease: its entry among those that are known.
const DIVISION_BYTES: usize = 2 * size_of::<(Look, u32)>();

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

    /// What stands for 1 where numbers, of which this is the greatest, are shares of a whole: the greatest of
    /// the type, or of a smaller one that is meant.
    fn whole(self, greatest: f64) -> f64 {
        let own = match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::I32 => i32::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::F32 | Self::F64 => return whole_of_shares(greatest),
        };
        [u8::MAX.into(), u16::MAX.into()]
            .into_iter()
            .find(|whole| greatest <= *whole)
            .map_or(own, |whole| own.min(whole))
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
#[derive(Clone)]
struct Body<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    /// Number of the line, of text.
    line: usize,
    /// Place of and problem with the first word of text that is no number.
    wrong: Option<(String, String)>,
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
            // It is taken for no number, which whatever it belongs to can do without.
            return Ok(number(&rest[..end]).unwrap_or_else(|problem| {
                let place = self.place();
                self.wrong.get_or_insert((place, problem));
                f64::NAN
            }));
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
struct Model<'s, 'a> {
    source: &'s Source<'a>,
    mesh: Mesh,
    /// Vertices with a position that is not finite.
    broken: Vec<bool>,
    edges: Vec<[u32; 2]>,
    cutter: Cutter,
    /// Linear colour of each triangle, if faces have one.
    face_colours: Vec<Vec4>,
    dropped_count: usize,
    has_colours: bool,
}

/// Why an element cannot be read to its end.
enum Stop {
    /// What is wrong with the file, and what to do.
    Fault(String),
    /// It takes too much.
    Limit(LoadError),
}

impl From<String> for Stop {
    fn from(problem: String) -> Self {
        Self::Fault(problem)
    }
}

impl From<LoadError> for Stop {
    fn from(error: LoadError) -> Self {
        Self::Limit(error)
    }
}

pub(super) fn read(bytes: &[u8], source: Source<'_>) -> Result<Loaded, LoadError> {
    let (elements, mut body) = read_header(bytes).map_err(|(place, problem)| source.fault(place, problem))?;
    let mut model = Model {
        source: &source,
        mesh: Mesh::default(),
        broken: Vec::new(),
        edges: Vec::new(),
        cutter: Cutter::new(),
        face_colours: Vec::new(),
        dropped_count: 0,
        has_colours: false,
    };
    // What stands before the vertices that it refers to is read after them.
    let mut put_off: Vec<(&Element, Body<'_>)> = Vec::new();
    let last_vertices = elements.iter().rposition(|element| element.name == "vertex").unwrap_or(0);
    for (at, element) in elements.iter().enumerate() {
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
        let outcome = if at < last_vertices && element.name != "vertex" {
            put_off.push((element, body.clone()));
            skip(element, &mut body)
        } else {
            model.read(element, &mut body)
        };
        if stopped(&source, &body, outcome)? {
            break;
        }
    }
    let mut wrong = body.wrong;
    for (element, mut body) in put_off {
        let outcome = model.read(element, &mut body);
        stopped(&source, &body, outcome)?;
        wrong = wrong.or(body.wrong);
    }
    if let Some((place, problem)) = wrong {
        source.lost(place, format!("{problem}; what needs the number was left out"))?;
    }
    let Model { mut mesh, broken, edges, cutter, face_colours, dropped_count, has_colours, .. } = model;
    if dropped_count > 0 {
        let faces = if dropped_count == 1 { "one face".to_owned() } else { format!("{dropped_count} faces") };
        let what = format!("{faces} with a vertex that is not there or not finite were left out");
        source.lost("faces", what)?;
    }
    if cutter.gave_up() {
        source.repaired("faces", "of concave polygons of many corners some were taken for convex ones");
    }
    for (at, _) in broken.iter().enumerate().filter(|(_, broken)| **broken) {
        mesh.positions[at] = Vec3::ZERO;
    }
    let base_colour = if has_colours { Vec4::ONE } else { GREY };
    let mut parts = source.parts();
    if !mesh.indices.is_empty() {
        divide(&mut mesh, &face_colours, &source)?;
        single::place(&mut parts, mesh, base_colour, Transform::IDENTITY);
        return source.finish(parts);
    }
    // Without faces the vertices themselves are meant, or the edges between them.
    let sound = (0..mesh.positions.len() as u32).filter(|&vertex| !broken[vertex as usize]);
    let mut strokes = if edges.is_empty() { Strokes::Points(sound.collect()) } else { Strokes::Lines(edges) };
    if let Some(said) = strokes.thin_out() {
        source.repaired("vertices", said);
    }
    source.take(strokes.body_bytes(), "vertices")?;
    single::place(&mut parts, mesh, base_colour, Transform::IDENTITY);
    stroke::draw(&mut parts, vec![Sketch { mesh: 0, strokes }]);
    source.finish(parts)
}

/// Whether an element was not read to its end, and nothing can be after it. What was read of it is drawn.
fn stopped(source: &Source<'_>, body: &Body<'_>, outcome: Result<(), Stop>) -> Result<bool, LoadError> {
    match outcome {
        Ok(()) => Ok(false),
        Err(Stop::Limit(error)) => Err(error),
        Err(Stop::Fault(problem)) => {
            source.lost(body.place(), format!("{problem}; what stands before it is drawn"))?;
            Ok(true)
        }
    }
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
                return Ok((elements, Body { bytes, at, encoding, line: line_number + 1, wrong: None }));
            }
            [word, ..] => return Err(fault(format!("'{}' is no word of a PLY header", shown(word)))),
        }
    }
    unreachable!("a file ends before line numbers do");
}

fn skip(element: &Element, body: &mut Body<'_>) -> Result<(), Stop> {
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

/// The places of three properties, each of which has one of several names.
fn all_of(element: &Element, names: [&[&str]; 3]) -> Option<[usize; 3]> {
    match names.map(|names| element.property(names)) {
        [Some(a), Some(b), Some(c)] => Some([a, b, c]),
        _ => None,
    }
}

/// Red, green and blue, and alpha, where they are.
struct ColourProperties {
    rgb: Option<[usize; 3]>,
    alpha: Option<usize>,
    /// The greatest number of any of the four.
    greatest: f64,
}

impl ColourProperties {
    const NONE: Self = Self { rgb: None, alpha: None, greatest: 0.0 };

    fn of(element: &Element) -> Self {
        let rgb = [
            &["red", "r", "diffuse_red"][..],
            &["green", "g", "diffuse_green"],
            &["blue", "b", "diffuse_blue"],
        ];
        let alpha = element.property(&["alpha", "a", "diffuse_alpha"]);
        Self { rgb: all_of(element, rgb), alpha, ..Self::NONE }
    }

    fn are_there(&self) -> bool {
        self.rgb.is_some() || self.alpha.is_some()
    }

    fn indices(&self) -> impl Iterator<Item = usize> {
        self.rgb.into_iter().flatten().chain(self.alpha)
    }

    /// The numbers of an element; what is not there is infinite.
    fn read(&mut self, values: &[f64]) -> Vec4 {
        self.greatest = self.indices().map(|at| values[at]).fold(self.greatest, f64::max);
        let at = |at: usize| values[at] as f32;
        let rgb = self.rgb.map_or(Vec3::INFINITY, |rgb| Vec3::from(rgb.map(at)));
        rgb.extend(self.alpha.map_or(f32::INFINITY, at))
    }

    /// Makes them linear, in the unit that the greatest of them is of.
    fn finish(&self, element: &Element, colours: &mut [Vec4]) {
        let kind = self.indices().next().map_or(Kind::F32, |at| element.properties[at].kind);
        let whole = kind.whole(self.greatest);
        colours.iter_mut().for_each(|colour| *colour = linear(*colour, whole));
    }
}

/// The property that holds the vertices of a face or a strip: a list of that name, or the only one of whole
/// numbers.
fn vertex_list(element: &Element) -> Result<usize, String> {
    let is_list =
        |property: &Property| property.length.is_some() && !matches!(property.kind, Kind::F32 | Kind::F64);
    let lists = || element.properties.iter().enumerate().filter(|(_, property)| is_list(property));
    let is_named = |property: &Property| matches!(property.name.as_str(), "vertex_indices" | "vertex_index");
    let found = lists().find(|(_, property)| is_named(property));
    let found = found.or_else(|| lists().next().filter(|_| lists().count() == 1));
    found.map(|(at, _)| at).ok_or_else(|| {
        format!("its '{}' have no list vertex_indices; export the file again", shown(element.name.as_bytes()))
    })
}

impl Model<'_, '_> {
    /// Reads an element as what its name says.
    fn read(&mut self, element: &Element, body: &mut Body<'_>) -> Result<(), Stop> {
        match element.name.as_str() {
            "vertex" => self.read_vertices(element, body)?,
            "face" => self.read_faces(element, body)?,
            "tristrips" => self.read_strips(element, body)?,
            "edge" => self.read_edges(element, body)?,
            name => {
                let place = format!("element '{}'", shown(name.as_bytes()));
                self.source.repaired(place, "it is not drawn");
                skip(element, body)?;
            }
        }
        Ok(self.source.check_triangle_count(self.mesh.indices.len(), &element.name)?)
    }

    /// Says which properties of an element have no effect.
    fn tell_unused(&self, element: &Element, used: impl IntoIterator<Item = usize>) {
        let mut is_used = vec![false; element.properties.len()];
        used.into_iter().for_each(|at| is_used[at] = true);
        let unused = || element.properties.iter().zip(&is_used).filter(|(_, used)| !**used);
        let names: Vec<String> = unused()
            .take(MOST_NAMES)
            .map(|(property, _)| format!("'{}'", shown(property.name.as_bytes())))
            .collect();
        let more = if unused().count() > MOST_NAMES { " and more" } else { "" };
        if !names.is_empty() {
            let place = format!("element '{}'", shown(element.name.as_bytes()));
            self.source
                .repaired(place, format!("properties without effect here: {}{more}", names.join(", ")));
        }
    }

    fn read_vertices(&mut self, element: &Element, body: &mut Body<'_>) -> Result<(), Stop> {
        if !self.mesh.positions.is_empty() {
            return Err("there are two lists of vertices; export the file again".to_owned().into());
        }
        let Some(position) = all_of(element, [&["x"], &["y"], &["z"]]) else {
            return Err("its vertices have no x, y and z; export the file again".to_owned().into());
        };
        let normal = [&["nx", "normal_x"][..], &["ny", "normal_y"], &["nz", "normal_z"]];
        let normal = all_of(element, normal);
        let mut colour = ColourProperties::of(element);
        let uv = [&["u", "s", "texture_u", "texcoord_u"][..], &["v", "t", "texture_v", "texcoord_v"]];
        let uv = uv.map(|names| element.property(names));
        let uv = if let [Some(u), Some(v)] = uv { Some([u, v]) } else { None };
        let used = position.into_iter().chain(normal.into_iter().flatten()).chain(colour.indices());
        self.tell_unused(element, used.chain(uv.into_iter().flatten()));
        self.has_colours |= colour.rgb.is_some();
        if uv.is_some() {
            self.mesh.uv_sets.push(Vec::new());
        }

        let mut values = vec![0.0; element.properties.len()];
        let mut outcome = Ok(());
        for _ in 0..element.count {
            outcome = self.source.take(VERTEX_BYTES, "vertices").map_err(Stop::from).and_then(|()| {
                for (value, property) in values.iter_mut().zip(&element.properties) {
                    // Of a list the last element is kept, which nobody asks for.
                    read_property(property, body, |read| *value = read)?;
                }
                Ok(())
            });
            if outcome.is_err() {
                break;
            }
            let vector = |at: [usize; 3]| Vec3::from(at.map(|at| values[at] as f32));
            let position = vector(position);
            self.broken.push(!position.is_finite());
            self.mesh.positions.push(position);
            if let Some(normal) = normal {
                self.mesh.normals.push(vector(normal).try_normalize().unwrap_or(Vec3::ZERO));
            }
            if colour.are_there() {
                self.mesh.colours.push(colour.read(&values));
            }
            if let (Some([u, v]), [set]) = (uv, &mut self.mesh.uv_sets[..]) {
                let uv = Vec2::new(values[u] as f32, 1.0 - values[v] as f32);
                set.push(if uv.is_finite() { uv } else { Vec2::ZERO });
            }
        }
        colour.finish(element, &mut self.mesh.colours);
        outcome
    }

    /// Whether there is a vertex of that number, at a finite place.
    fn is_sound(&self, vertex: f64) -> bool {
        let count = self.mesh.positions.len();
        vertex >= 0.0 && vertex < count as f64 && vertex.fract() == 0.0 && !self.broken[vertex as usize]
    }

    /// Adds triangles of sound vertices.
    fn add(&mut self, triangles: &[[f64; 3]]) -> Result<(), LoadError> {
        self.source.take(TRIANGLE_BYTES * triangles.len(), "faces")?;
        self.mesh.indices.extend(triangles.iter().map(|corners| corners.map(|corner| corner as u32)));
        Ok(())
    }

    fn read_faces(&mut self, element: &Element, body: &mut Body<'_>) -> Result<(), Stop> {
        if element.count == 0 {
            return Ok(());
        }
        let list = vertex_list(element)?;
        // Where vertices have colours, too, those are meant.
        let mut colour = ColourProperties::of(element);
        if !self.mesh.colours.is_empty() {
            colour = ColourProperties::NONE;
        }
        self.tell_unused(element, colour.indices().chain([list]));
        self.has_colours |= colour.rgb.is_some();
        let first_coloured = self.face_colours.len();
        // Triangles of strips before them are white.
        if colour.are_there() {
            self.face_colours.resize(self.mesh.indices.len(), Vec4::INFINITY);
        }
        let mut corners = Vec::new();
        let mut values = vec![0.0; element.properties.len()];
        let mut outcome = Ok(());
        for _ in 0..element.count {
            corners.clear();
            outcome = (values.iter_mut().zip(&element.properties).enumerate()).try_for_each(
                |(at, (value, property))| {
                    read_property(property, body, |read| {
                        *value = read;
                        if at == list {
                            corners.push(read);
                        }
                    })
                },
            );
            if outcome.is_err() {
                break;
            }
            self.add_polygon(&corners)?;
            if colour.are_there() {
                self.face_colours.resize(self.mesh.indices.len(), colour.read(&values));
            }
        }
        colour.finish(element, &mut self.face_colours[first_coloured..]);
        Ok(outcome?)
    }

    /// Adds the triangles of a polygon, or of what is left of it without vertices that are not sound.
    fn add_polygon(&mut self, corners: &[f64]) -> Result<(), LoadError> {
        let are_sound = corners.iter().all(|&corner| self.is_sound(corner));
        if !are_sound || corners.len() < 3 {
            self.dropped_count += 1;
            return Ok(());
        }
        let at = |corner: u32| self.mesh.positions[corners[corner as usize] as usize];
        let triangles = self.cutter.triangles(corners.len() as u32, at);
        let triangles: Vec<[f64; 3]> =
            triangles.into_iter().map(|triangle| triangle.map(|corner| corners[corner as usize])).collect();
        self.add(&triangles)
    }

    fn read_strips(&mut self, element: &Element, body: &mut Body<'_>) -> Result<(), Stop> {
        if element.count == 0 {
            return Ok(());
        }
        let list = vertex_list(element)?;
        self.tell_unused(element, [list]);
        let mut corners = Vec::new();
        for _ in 0..element.count {
            corners.clear();
            let mut outcome = Ok(());
            for (at, property) in element.properties.iter().enumerate() {
                outcome = outcome.and_then(|()| {
                    read_property(property, body, |read| {
                        if at == list {
                            corners.push(read);
                        }
                    })
                });
            }
            // A negative number begins a new strip; every second triangle is turned around.
            for strip in corners.split(|&corner| corner < 0.0) {
                for (at, window) in strip.windows(3).enumerate() {
                    let [a, b, c] = [window[0], window[1], window[2]];
                    let triangle = if at % 2 == 0 { [a, b, c] } else { [b, a, c] };
                    if triangle.into_iter().all(|corner| self.is_sound(corner)) {
                        self.add(&[triangle])?;
                    } else {
                        self.dropped_count += 1;
                    }
                }
            }
            outcome?;
        }
        Ok(())
    }

    fn read_edges(&mut self, element: &Element, body: &mut Body<'_>) -> Result<(), Stop> {
        let ends = ["vertex1", "vertex2"].map(|name| element.property(&[name]));
        let [Some(from), Some(to)] = ends else { return skip(element, body) };
        let mut values = vec![0.0; element.properties.len()];
        for _ in 0..element.count {
            for (value, property) in values.iter_mut().zip(&element.properties) {
                read_property(property, body, |read| *value = read)?;
            }
            let ends = [values[from], values[to]];
            if ends.into_iter().all(|end| self.is_sound(end)) {
                self.source.take(EDGE_BYTES, "edges")?;
                self.edges.push(ends.map(|end| end as u32));
            } else {
                self.dropped_count += 1;
            }
        }
        Ok(())
    }
}

/// What tells a vertex at a place from others there: its number in the file, and the bits of its normal and
/// of the colour of its face.
type Look = (u32, [u32; 3], [u32; 4]);

/// Makes the normals that a file lacks, and gives the colours of faces to vertices; those at creases, and
/// between faces of different colours, are divided.
fn divide(mesh: &mut Mesh, face_colours: &[Vec4], source: &Source<'_>) -> Result<(), LoadError> {
    let has_normals = !mesh.normals.is_empty() && !mesh.normals.contains(&Vec3::ZERO);
    if has_normals && face_colours.is_empty() {
        return Ok(());
    }
    let made = if has_normals {
        None
    } else {
        source.take(crease::bytes(mesh.indices.len()), "normals")?;
        Some(corner_normals(&mesh.positions, &mesh.indices, |_| Smoothing::Angle))
    };
    let mut divided = Mesh { uv_sets: vec![Vec::new(); mesh.uv_sets.len()], ..Mesh::default() };
    let mut vertex_of: HashMap<Look, u32> = HashMap::new();
    for (face, corners) in mesh.indices.iter().enumerate() {
        // Triangles of strips after the faces are white.
        let face_colour = face_colours.get(face).copied().unwrap_or(Vec4::ONE);
        let mut vertices = [0; 3];
        for (corner, &number) in corners.iter().enumerate() {
            let vertex = number as usize;
            let given = mesh.normals.get(vertex).copied().filter(|given| *given != Vec3::ZERO);
            // Of an empty face any will do.
            let normal = given.or(made.as_ref().map(|made| made[face][corner])).unwrap_or(Vec3::Y);
            let normal = normal.try_normalize().unwrap_or(Vec3::Y);
            let look =
                (number, normal.to_array().map(f32::to_bits), face_colour.to_array().map(f32::to_bits));
            let next = divided.positions.len() as u32;
            vertices[corner] = *vertex_of.entry(look).or_insert(next);
            if vertices[corner] != next {
                continue;
            }
            source.take(VERTEX_BYTES + DIVISION_BYTES, "vertices")?;
            divided.positions.push(mesh.positions[vertex]);
            divided.normals.push(normal);
            if !face_colours.is_empty() {
                divided.colours.push(face_colour);
            } else {
                divided.colours.extend(mesh.colours.get(vertex));
            }
            for (to, from) in divided.uv_sets.iter_mut().zip(&mesh.uv_sets) {
                to.push(from[vertex]);
            }
        }
        divided.indices.push(vertices);
    }
    *mesh = divided;
    Ok(())
}
