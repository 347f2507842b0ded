//! Wavefront OBJ: faces, groups, materials, vertex colours; and the materials beside it, [`mtl`].
//!
//! Read by hand: the kept crate panics on a colour of two numbers, loses count of texture coordinates where a
//! face lacks them, and takes polylines for faces.
//!
//! Objects and groups are objects of the scene, each with one mesh a material. Faces are drawn from both
//! sides, since files do not say. Where normals are missing they are made: by smoothing groups where the file
//! has them, by the angle between faces where it has none. A file of vertices alone is drawn as points.

use std::collections::{HashMap, HashSet};

use glam::{Vec2, Vec3, Vec4};
use sheer_scene::model::{AlphaMode, Instance, Mesh, Node};

use super::{
    Loaded,
    crease::{self, Smoothing, corner_normals},
    polygon::Cutter,
    source::{self, Source},
    stroke::{self, Sketch, Strokes},
    text::{self, Line, next_number, shown},
    vertex_colour,
};
use crate::LoadError;

mod mtl;

/// Stands for an index that a corner does not have.
const NONE: u32 = u32::MAX;

/// Bytes of a vector, a position with a colour, a triangle and a stroke in lists that double as they grow.
const VECTOR_BYTES: usize = 2 * size_of::<Vec3>();
const POSITION_BYTES: usize = VECTOR_BYTES + 2 * size_of::<Vec4>();
const TRIANGLE_BYTES: usize = 2 * (size_of::<[Corner; 3]>() + size_of::<Smoothing>() + size_of::<[u32; 3]>());
const STROKE_BYTES: usize = 4 * size_of::<[u32; 2]>();
/// Bytes of a vertex of a mesh: position, normal, coordinates and colour, and its entry among those that are
/// known.
const VERTEX_BYTES: usize = 2 * (12 + 12 + 8 + 16) + 2 * size_of::<((Corner, [u32; 3]), u32)>();
/// Bytes of a piece of an object, with its mesh and its instance.
const PIECE_BYTES: usize = 1000;
/// Bytes of a name, and of a material that has one.
const NAME_BYTES: usize = 700;

/// A corner of a face: indices into the lists of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Corner {
    position: u32,
    uv: u32,
    normal: u32,
}

/// Faces of one object that share a material.
struct Piece {
    object: u32,
    material: u32,
    triangles: Vec<[Corner; 3]>,
    smoothing: Vec<Smoothing>,
    /// Indices of positions.
    lines: Vec<[u32; 2]>,
    points: Vec<u32>,
}

/// The file while it is read, line by line.
struct Reader<'s, 'a> {
    source: &'s Source<'a>,
    positions: Vec<Vec3>,
    /// Colour and alpha of each position as the file writes them, up to the last that has one; white before
    /// the first.
    colours: Vec<Vec4>,
    /// The greatest component of a colour.
    brightest: f64,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    objects: Names,
    materials: Names,
    /// Files of materials, each once, with the line that names it.
    libraries: Vec<(String, String)>,
    named_libraries: HashSet<String>,
    pieces: Vec<Piece>,
    piece_of: HashMap<(u32, u32), usize>,
    triangle_count: usize,
    cutter: Cutter,
    /// A face, a line, a point or something else was made of vertices.
    says_what_is_drawn: bool,
    object: u32,
    material: u32,
    smoothing: Smoothing,
}

/// Names in the order in which they came up.
#[derive(Default)]
struct Names {
    names: Vec<String>,
    number_of: HashMap<String, u32>,
}

impl Names {
    fn number(&mut self, name: String, source: &Source<'_>) -> Result<u32, LoadError> {
        if let Some(&number) = self.number_of.get(&name) {
            return Ok(number);
        }
        source.take(NAME_BYTES + 2 * name.len(), "names")?;
        let number = self.names.len() as u32;
        self.names.push(name.clone());
        self.number_of.insert(name, number);
        Ok(number)
    }
}

pub(super) fn read(bytes: &[u8], source: Source<'_>) -> Result<Loaded, LoadError> {
    let mut reader = Reader {
        source: &source,
        positions: Vec::new(),
        colours: Vec::new(),
        brightest: 0.0,
        uvs: Vec::new(),
        normals: Vec::new(),
        objects: Names::default(),
        materials: Names::default(),
        libraries: Vec::new(),
        named_libraries: HashSet::new(),
        pieces: Vec::new(),
        piece_of: HashMap::new(),
        triangle_count: 0,
        cutter: Cutter::new(),
        says_what_is_drawn: false,
        object: 0,
        material: 0,
        smoothing: Smoothing::Angle,
    };
    // What stands before any name belongs to these.
    reader.objects.number(String::new(), &source)?;
    reader.materials.number(String::new(), &source)?;
    for line in text::lines(bytes) {
        reader.read_line(&line)?;
    }
    if reader.pieces.is_empty() && !looks_like_obj(bytes) {
        let problem = "this is no OBJ file: no line of it begins with a word of the format; export it again";
        return Err(source.fault("line 1", problem));
    }
    if reader.cutter.gave_up() {
        source.repaired("faces", "of concave polygons of many corners some were taken for convex ones");
    }
    reader.finish_vertices()?;

    let mut parts = source.parts();
    (parts.materials, parts.textures) = mtl::read(&source, &reader.libraries, &reader.materials.names)?;
    parts.nodes = vec![Node::default()];
    let mut geometries: HashMap<u32, u32> = HashMap::new();
    let mut sketches = Vec::new();
    for piece in &reader.pieces {
        let mut add = |mesh: Mesh| {
            let geometry = geometries.entry(piece.object).or_insert(0);
            parts.instances.push(Instance {
                mesh: parts.meshes.len() as u32,
                id: piece.object,
                geometry: *geometry,
                ..Instance::default()
            });
            *geometry += 1;
            parts.meshes.push(mesh);
            parts.meshes.len() as u32 - 1
        };
        if !piece.triangles.is_empty() {
            add(reader.mesh(piece)?);
        }
        if !piece.lines.is_empty() {
            let (mesh, numbers) = reader.thread(piece, piece.lines.as_flattened());
            let ends = numbers.chunks_exact(2).map(|ends| [ends[0], ends[1]]);
            sketches.push(Sketch { mesh: add(mesh), strokes: Strokes::Lines(ends.collect()) });
        }
        if !piece.points.is_empty() {
            let (mesh, numbers) = reader.thread(piece, &piece.points);
            sketches.push(Sketch { mesh: add(mesh), strokes: Strokes::Points(numbers) });
        }
    }
    // Colours of vertices may be transparent, too.
    for mesh in parts.meshes.iter().filter(|mesh| mesh.colours.iter().any(|colour| colour.w < 1.0)) {
        parts.materials[mesh.material as usize].alpha_mode = AlphaMode::Blend;
    }
    for sketch in &mut sketches {
        if let Some(said) = sketch.strokes.thin_out() {
            source.repaired("points and lines", said);
        }
        source.take(sketch.strokes.body_bytes(), "points and lines")?;
    }
    stroke::draw(&mut parts, sketches);
    source.finish(parts)
}

/// Whether some line begins with one of the words of the format.
fn looks_like_obj(bytes: &[u8]) -> bool {
    text::lines(bytes).any(|line| {
        matches!(
            line.words().next(),
            Some(b"v" | b"vt" | b"vn" | b"f" | b"l" | b"p" | b"o" | b"g" | b"mtllib")
        )
    })
}

impl Reader<'_, '_> {
    fn read_line(&mut self, line: &Line<'_>) -> Result<(), LoadError> {
        let source = self.source;
        let mut words = line.words();
        let Some(word) = words.next() else { return Ok(()) };
        // A line that is not sound keeps its number among those of its kind.
        let lost = |problem: String| source.lost(line.place(), format!("{problem}; the line was left out"));
        match word {
            b"v" => {
                source.take(POSITION_BYTES, "vertices")?;
                if let Err(problem) = self.read_position(&mut words) {
                    lost(problem)?;
                    self.positions.push(Vec3::NAN);
                }
            }
            b"vt" => {
                source.take(VECTOR_BYTES, "texture coordinates")?;
                let uv = read_uv(&mut words).or_else(|problem| lost(problem).map(|()| Vec2::ZERO))?;
                self.uvs.push(if uv.is_finite() { uv } else { Vec2::ZERO });
            }
            b"vn" => {
                source.take(VECTOR_BYTES, "normals")?;
                let normal = read_normal(&mut words).or_else(|problem| lost(problem).map(|()| Vec3::ZERO))?;
                self.normals.push(normal.try_normalize().unwrap_or(Vec3::ZERO));
            }
            b"f" | b"fo" => self.read_face(line, words)?,
            b"l" => self.read_strokes(line, words, true)?,
            b"p" => self.read_strokes(line, words, false)?,
            b"o" | b"g" => self.object = self.objects.number(line.rest(), source)?,
            b"usemtl" => self.material = self.materials.number(line.rest(), source)?,
            b"mtllib" => {
                let name = line.rest();
                if self.named_libraries.insert(name.clone()) {
                    self.libraries.push((line.place(), name));
                }
            }
            b"s" => {
                self.smoothing = match words.next() {
                    None | Some(b"off" | b"0") => Smoothing::Flat,
                    Some(group) => Smoothing::Group(text::number(group).unwrap_or(1)),
                };
            }
            b"curv" | b"curv2" | b"surf" | b"call" | b"csh" => {
                self.says_what_is_drawn = true;
                source.repaired(line.place(), format!("'{}' has no effect here", shown(word)));
            }
            // Words for free-form surfaces that stand around these, display attributes, and what exporters
            // add of their own.
            _ => {}
        }
        Ok(())
    }

    /// `v x y z`, with a weight, three numbers of a colour, or four with its alpha.
    fn read_position<'w>(&mut self, words: &mut impl Iterator<Item = &'w [u8]>) -> Result<(), String> {
        let mut numbers = [0.0_f32; 7];
        let mut count = 0;
        for (number, word) in numbers.iter_mut().zip(words) {
            *number = text::number(word)?;
            count += 1;
        }
        if count < 3 {
            return Err(
                "a vertex needs three numbers; the line is cut short, export the file again".to_owned()
            );
        }
        let [x, y, z, r, g, b, a] = numbers;
        if count >= 6 {
            // Infinity stands for white and opaque, whatever the unit.
            let colour = Vec4::new(r, g, b, if count == 7 { a } else { f32::INFINITY });
            let finite = colour.to_array().into_iter().filter(|value| value.is_finite());
            self.brightest = finite.map(f64::from).fold(self.brightest, f64::max);
            self.colours.resize(self.positions.len(), Vec4::INFINITY);
            self.colours.push(colour);
        }
        self.positions.push(Vec3::new(x, y, z));
        Ok(())
    }

    /// Makes colours linear, and points of vertices of which nothing was made.
    fn finish_vertices(&mut self) -> Result<(), LoadError> {
        let whole = vertex_colour::whole_of_shares(self.brightest);
        self.colours.iter_mut().for_each(|colour| *colour = vertex_colour::linear(*colour, whole));
        if !self.says_what_is_drawn {
            let sound = (0..).zip(&self.positions).filter(|(_, position)| position.is_finite());
            let points: Vec<u32> = sound.map(|(index, _)| index).collect();
            if !points.is_empty() {
                self.source.take(STROKE_BYTES * points.len(), "vertices")?;
                let piece = self.piece()?;
                self.pieces[piece].points = points;
            }
        }
        Ok(())
    }

    fn read_face<'w>(
        &mut self,
        line: &Line<'_>,
        words: impl Iterator<Item = &'w [u8]>,
    ) -> Result<(), LoadError> {
        self.says_what_is_drawn = true;
        let mut corners = Vec::with_capacity(4);
        let mut missing = None;
        for word in words {
            match self.corner(word, &mut missing) {
                Ok(corner) => corners.push(corner),
                Err(problem) => {
                    return self.source.lost(line.place(), format!("a face was left out: {problem}"));
                }
            }
        }
        if let Some(missing) = missing {
            self.source.lost(line.place(), format!("a face is drawn without a part of it: {missing}"))?;
        }
        if corners.len() < 3 {
            return self.source.lost(line.place(), "a face of fewer than three corners was left out");
        }
        if corners.iter().any(|corner| !self.positions[corner.position as usize].is_finite()) {
            return self.source.lost(line.place(), "a face with a vertex that is not finite was left out");
        }
        self.triangle_count += corners.len() - 2;
        self.source.check_triangle_count(self.triangle_count, "faces")?;
        self.source.take(TRIANGLE_BYTES * (corners.len() - 2), "faces")?;
        let piece = self.piece()?;
        let piece = &mut self.pieces[piece];
        let at = |corner: u32| self.positions[corners[corner as usize].position as usize];
        for triangle in self.cutter.triangles(corners.len() as u32, at) {
            piece.triangles.push(triangle.map(|corner| corners[corner as usize]));
            piece.smoothing.push(self.smoothing);
        }
        Ok(())
    }

    /// Index of the piece that what comes next belongs to.
    fn piece(&mut self) -> Result<usize, LoadError> {
        let (object, material) = (self.object, self.material);
        if let Some(&piece) = self.piece_of.get(&(object, material)) {
            return Ok(piece);
        }
        self.source.take(PIECE_BYTES, "objects")?;
        let piece = self.pieces.len();
        self.piece_of.insert((object, material), piece);
        self.pieces.push(Piece {
            object,
            material,
            triangles: Vec::new(),
            smoothing: Vec::new(),
            lines: Vec::new(),
            points: Vec::new(),
        });
        Ok(piece)
    }

    /// A line through vertices, or single ones.
    fn read_strokes<'w>(
        &mut self,
        line: &Line<'_>,
        words: impl Iterator<Item = &'w [u8]>,
        are_joined: bool,
    ) -> Result<(), LoadError> {
        self.says_what_is_drawn = true;
        let mut positions = Vec::new();
        for word in words {
            // Texture coordinates of lines say nothing here.
            match self.corner(word, &mut None) {
                Ok(corner) if self.positions[corner.position as usize].is_finite() => {
                    positions.push(corner.position);
                }
                Ok(_) => self.source.lost(line.place(), "a vertex that is not finite was left out")?,
                Err(problem) => {
                    self.source.lost(line.place(), format!("a vertex was left out: {problem}"))?;
                }
            }
        }
        self.source.take(STROKE_BYTES * positions.len(), "points and lines")?;
        let piece = self.piece()?;
        let piece = &mut self.pieces[piece];
        if are_joined {
            piece.lines.extend(positions.windows(2).map(|ends| [ends[0], ends[1]]));
        } else {
            piece.points.extend(positions);
        }
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1, or backwards from -1, the last. What is wrong with
    /// coordinates or normal, without which there still is a corner, is in `missing`.
    fn corner(&self, word: &[u8], missing: &mut Option<String>) -> Result<Corner, String> {
        let mut numbers = word.split(|&byte| byte == b'/');
        let mut index = |count: usize, what: &str| -> Result<u32, String> {
            let Some(number) = numbers.next().filter(|number| !number.is_empty()) else { return Ok(NONE) };
            let index: i64 = text::number(number)?;
            let found = if index < 0 { index.saturating_add(count as i64) } else { index - 1 };
            if (0..count as i64).contains(&found) {
                Ok(found as u32)
            } else {
                Err(format!("it refers to {what} {index}, but {count} stand before it"))
            }
        };
        let position = index(self.positions.len(), "vertex")?;
        if position == NONE {
            return Err(format!("'{}' names no vertex; correct it or export the file again", shown(word)));
        }
        let mut or_none = |found: Result<u32, String>| {
            found.unwrap_or_else(|problem| {
                missing.get_or_insert(problem);
                NONE
            })
        };
        let uv = or_none(index(self.uvs.len(), "texture coordinate"));
        let normal = or_none(index(self.normals.len(), "normal"));
        Ok(Corner { position, uv, normal })
    }

    /// The mesh of a piece, in which each combination of indices is a vertex.
    fn mesh(&self, piece: &Piece) -> Result<Mesh, LoadError> {
        let mut mesh = self.empty_mesh(piece);
        let corners = || piece.triangles.as_flattened().iter();
        let given = |corner: &Corner| {
            self.normals.get(corner.normal as usize).copied().filter(|normal| *normal != Vec3::ZERO)
        };
        let has_uvs = corners().any(|corner| corner.uv != NONE);
        if has_uvs {
            mesh.uv_sets.push(Vec::new());
        }
        let lacks_normals = corners().any(|corner| given(corner).is_none());
        let is_flat = piece.smoothing.iter().all(|smoothing| *smoothing == Smoothing::Flat);
        // What is flat all over and has no normals needs none.
        let stays_flat = is_flat && corners().all(|corner| given(corner).is_none());
        let made = (lacks_normals && !stays_flat).then(|| self.made_normals(piece)).transpose()?;
        let has_normals = made.is_some() || !lacks_normals;

        let mut vertex_of: HashMap<(Corner, [u32; 3]), u32> = HashMap::new();
        for (index, corners) in piece.triangles.iter().enumerate() {
            let mut vertices = [0; 3];
            for (at, &corner) in corners.iter().enumerate() {
                let made = made.as_ref().map(|made| made[index][at]);
                // Of an empty face any direction will do.
                let normal = given(&corner).or(made).unwrap_or(Vec3::Y).try_normalize().unwrap_or(Vec3::Y);
                // Vertices are the same if what they look like is.
                let key = Corner { normal: NONE, ..corner };
                let normal_key = if has_normals { normal.to_array().map(f32::to_bits) } else { [0; 3] };
                let next = mesh.positions.len() as u32;
                vertices[at] = *vertex_of.entry((key, normal_key)).or_insert(next);
                if vertices[at] != next {
                    continue;
                }
                self.source.take(VERTEX_BYTES, "vertices")?;
                mesh.positions.push(self.positions[corner.position as usize]);
                if has_normals {
                    mesh.normals.push(normal);
                }
                if !self.colours.is_empty() {
                    mesh.colours.push(self.colour(corner.position));
                }
                if let [set] = &mut mesh.uv_sets[..] {
                    set.push(self.uvs.get(corner.uv as usize).copied().unwrap_or(Vec2::ZERO));
                }
            }
            mesh.indices.push(vertices);
        }
        Ok(mesh)
    }

    fn empty_mesh(&self, piece: &Piece) -> Mesh {
        Mesh {
            name: source::name(&self.objects.names[piece.object as usize]),
            material: piece.material,
            ..Mesh::default()
        }
    }

    /// The colour of a position, where any has one; those after the last are white.
    fn colour(&self, position: u32) -> Vec4 {
        self.colours.get(position as usize).copied().unwrap_or(Vec4::ONE)
    }

    /// A mesh of the positions of points and lines, and their numbers in it.
    fn thread(&self, piece: &Piece, positions: &[u32]) -> (Mesh, Vec<u32>) {
        let mut mesh = self.empty_mesh(piece);
        let mut number_of: HashMap<u32, u32> = HashMap::new();
        let number = |&position: &u32| {
            *number_of.entry(position).or_insert_with(|| {
                mesh.positions.push(self.positions[position as usize]);
                if !self.colours.is_empty() {
                    mesh.colours.push(self.colour(position));
                }
                mesh.positions.len() as u32 - 1
            })
        };
        let numbers = positions.iter().map(number).collect();
        (mesh, numbers)
    }

    /// Normals for all corners of a piece.
    fn made_normals(&self, piece: &Piece) -> Result<Vec<[Vec3; 3]>, LoadError> {
        self.source.take(crease::bytes(piece.triangles.len()), "normals")?;
        // Positions of the piece alone, so that many small pieces do not each walk the whole list.
        let mut number_of: HashMap<u32, u32> = HashMap::new();
        let mut positions = Vec::new();
        let triangles: Vec<[u32; 3]> = (piece.triangles.iter())
            .map(|corners| {
                corners.map(|corner| {
                    *number_of.entry(corner.position).or_insert_with(|| {
                        positions.push(self.positions[corner.position as usize]);
                        positions.len() as u32 - 1
                    })
                })
            })
            .collect();
        Ok(corner_normals(&positions, &triangles, |triangle| piece.smoothing[triangle]))
    }
}

fn read_uv<'w>(words: &mut impl Iterator<Item = &'w [u8]>) -> Result<Vec2, String> {
    let u = next_number(words)?;
    // A curve has one coordinate, a volume three.
    let v: f32 = words.next().map_or(Ok(0.0), text::number)?;
    Ok(Vec2::new(u, 1.0 - v))
}

fn read_normal<'w>(words: &mut impl Iterator<Item = &'w [u8]>) -> Result<Vec3, String> {
    Ok(Vec3::new(next_number(words)?, next_number(words)?, next_number(words)?))
}
