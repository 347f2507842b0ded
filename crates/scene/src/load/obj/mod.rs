//! Wavefront OBJ: faces, groups, materials, vertex colours; and the materials beside it, [`mtl`].
//!
//! Read by hand: the kept crate panics on a colour of two numbers, loses count of texture coordinates where a
//! face lacks them, and takes polylines for faces.
//!
//! Objects and groups are objects of the scene, each with one mesh a material. Faces are drawn from both
//! sides, since files do not say. Where normals are missing they are made: by smoothing groups where the file
//! has them, by the angle between faces where it has none.

use std::collections::HashMap;

use glam::{Affine3A, Vec2, Vec3, Vec4};
use sheer_core::colour::linear_from_srgb;

use super::{
    Loaded,
    crease::{Smoothing, corner_normals},
    source::Source,
    stroke::{self, Sketch, Strokes},
    text::{self, Line, next_number, shown},
};
use crate::{
    SceneError,
    model::{AlphaMode, Instance, Mesh, Node, Transform},
};

mod mtl;
mod polygon;

/// Stands for an index that a corner does not have.
const NONE: u32 = u32::MAX;

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
    /// Linear colour and alpha of each position, from the first that has one on.
    colours: Vec<Vec4>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    objects: Names,
    materials: Names,
    libraries: Vec<(String, String)>,
    pieces: Vec<Piece>,
    piece_of: HashMap<(u32, u32), usize>,
    triangle_count: usize,
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
    fn number(&mut self, name: String) -> u32 {
        *self.number_of.entry(name).or_insert_with_key(|name| {
            self.names.push(name.clone());
            self.names.len() as u32 - 1
        })
    }
}

pub(super) fn read(bytes: &[u8], source: Source<'_>) -> Result<Loaded, SceneError> {
    let mut reader = Reader {
        source: &source,
        positions: Vec::new(),
        colours: Vec::new(),
        uvs: Vec::new(),
        normals: Vec::new(),
        objects: Names::default(),
        materials: Names::default(),
        libraries: Vec::new(),
        pieces: Vec::new(),
        piece_of: HashMap::new(),
        triangle_count: 0,
        object: 0,
        material: 0,
        smoothing: Smoothing::Angle,
    };
    // What stands before any name belongs to these.
    reader.objects.number(String::new());
    reader.materials.number(String::new());
    for line in text::lines(bytes) {
        reader.read_line(&line)?;
    }
    if reader.pieces.is_empty() && !looks_like_obj(bytes) {
        let problem = "this is no OBJ file: no line of it begins with a word of the format; export it again";
        return Err(source.fault("line 1", problem));
    }

    let mut parts = source.parts();
    (parts.materials, parts.textures) = mtl::read(&source, &reader.libraries, &reader.materials.names)?;
    parts.nodes = vec![Node { name: String::new(), parent: None, transform: Transform::IDENTITY }];
    let mut geometries: HashMap<u32, u32> = HashMap::new();
    let mut sketches = Vec::new();
    for piece in &reader.pieces {
        let mut add = |mesh: Mesh| {
            let geometry = geometries.entry(piece.object).or_insert(0);
            parts.instances.push(Instance {
                node: 0,
                node_from_object: Affine3A::IDENTITY,
                mesh: parts.meshes.len() as u32,
                id: piece.object,
                geometry: *geometry,
                skin: None,
                morph_weights: Vec::new(),
            });
            *geometry += 1;
            parts.meshes.push(mesh);
            parts.meshes.len() as u32 - 1
        };
        if !piece.triangles.is_empty() {
            add(reader.mesh(piece));
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
    fn read_line(&mut self, line: &Line<'_>) -> Result<(), SceneError> {
        let source = self.source;
        let fault = |problem: String| source.fault(line.place(), problem);
        let mut words = line.words();
        let Some(word) = words.next() else { return Ok(()) };
        match word {
            b"v" => self.read_position(&mut words).map_err(fault)?,
            b"vt" => {
                let u = next_number(&mut words).map_err(fault)?;
                // A curve has one coordinate, a volume three.
                let v: f32 = words.next().map_or(Ok(0.0), text::number).map_err(fault)?;
                let uv = Vec2::new(u, 1.0 - v);
                self.uvs.push(if uv.is_finite() { uv } else { Vec2::ZERO });
            }
            b"vn" => {
                let mut next = || next_number::<f32>(&mut words).map_err(fault);
                let normal = Vec3::new(next()?, next()?, next()?);
                self.normals.push(normal.try_normalize().unwrap_or(Vec3::ZERO));
            }
            b"f" | b"fo" => self.read_face(line, words)?,
            b"l" => self.read_strokes(line, words, true)?,
            b"p" => self.read_strokes(line, words, false)?,
            b"o" | b"g" => self.object = self.objects.number(line.rest()),
            b"usemtl" => self.material = self.materials.number(line.rest()),
            b"mtllib" => self.libraries.push((line.place(), line.rest())),
            b"s" => {
                self.smoothing = match words.next() {
                    None | Some(b"off" | b"0") => Smoothing::Flat,
                    Some(group) => Smoothing::Group(text::number(group).unwrap_or(1)),
                };
            }
            b"curv" | b"curv2" | b"surf" | b"call" | b"csh" => {
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
            self.colours.resize(self.positions.len(), Vec4::ONE);
            let alpha = if count == 7 { a } else { 1.0 };
            let share = |value: f32| if value > 0.0 { value.min(1.0) } else { 0.0 };
            let [r, g, b] = [r, g, b].map(|value| linear_from_srgb(share(value)));
            self.colours.push(Vec4::new(r, g, b, share(alpha)));
        } else if !self.colours.is_empty() {
            self.colours.push(Vec4::ONE);
        }
        self.positions.push(Vec3::new(x, y, z));
        Ok(())
    }

    fn read_face<'w>(
        &mut self,
        line: &Line<'_>,
        words: impl Iterator<Item = &'w [u8]>,
    ) -> Result<(), SceneError> {
        let mut corners = Vec::with_capacity(4);
        for word in words {
            match self.corner(word) {
                Ok(corner) => corners.push(corner),
                Err(CornerFault::NotANumber(problem)) => {
                    return Err(self.source.fault(line.place(), problem));
                }
                Err(CornerFault::NotThere(what)) => {
                    let place = line.place();
                    let what = format!("a face was left out: it refers to {what}");
                    return self.source.lost(place, what);
                }
            }
        }
        if corners.len() < 3 {
            return self.source.lost(line.place(), "a face of fewer than three corners was left out");
        }
        if corners.iter().any(|corner| !self.positions[corner.position as usize].is_finite()) {
            return self.source.lost(line.place(), "a face with a vertex that is not finite was left out");
        }
        self.triangle_count += corners.len() - 2;
        self.source.check_triangle_count(self.triangle_count, "faces")?;
        let piece = self.piece();
        let piece = &mut self.pieces[piece];
        let at = |corner: u32| self.positions[corners[corner as usize].position as usize];
        for triangle in polygon::triangles(corners.len() as u32, at) {
            piece.triangles.push(triangle.map(|corner| corners[corner as usize]));
            piece.smoothing.push(self.smoothing);
        }
        Ok(())
    }

    /// Index of the piece that what comes next belongs to.
    fn piece(&mut self) -> usize {
        let pieces = &mut self.pieces;
        *self.piece_of.entry((self.object, self.material)).or_insert_with_key(|&(object, material)| {
            pieces.push(Piece {
                object,
                material,
                triangles: Vec::new(),
                smoothing: Vec::new(),
                lines: Vec::new(),
                points: Vec::new(),
            });
            pieces.len() - 1
        })
    }

    /// A line through vertices, or single ones.
    fn read_strokes<'w>(
        &mut self,
        line: &Line<'_>,
        words: impl Iterator<Item = &'w [u8]>,
        are_joined: bool,
    ) -> Result<(), SceneError> {
        let mut positions = Vec::new();
        for word in words {
            match self.corner(word) {
                Ok(corner) if self.positions[corner.position as usize].is_finite() => {
                    positions.push(corner.position);
                }
                Ok(_) => {}
                Err(CornerFault::NotANumber(problem)) => {
                    return Err(self.source.fault(line.place(), problem));
                }
                Err(CornerFault::NotThere(what)) => {
                    let what = format!("a vertex was left out: it refers to {what}");
                    self.source.lost(line.place(), what)?;
                }
            }
        }
        let piece = self.piece();
        let piece = &mut self.pieces[piece];
        if are_joined {
            piece.lines.extend(positions.windows(2).map(|ends| [ends[0], ends[1]]));
        } else {
            piece.points.extend(positions);
        }
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1, or backwards from -1, the last.
    fn corner(&self, word: &[u8]) -> Result<Corner, CornerFault> {
        let mut numbers = word.split(|&byte| byte == b'/');
        let mut index = |count: usize, what: &str| -> Result<u32, CornerFault> {
            let Some(number) = numbers.next().filter(|number| !number.is_empty()) else { return Ok(NONE) };
            let index: i64 = text::number(number).map_err(CornerFault::NotANumber)?;
            let found = if index < 0 { count as i64 + index } else { index - 1 };
            if (0..count as i64).contains(&found) {
                Ok(found as u32)
            } else {
                Err(CornerFault::NotThere(format!("{what} {index}, but {count} stand before it")))
            }
        };
        let position = index(self.positions.len(), "vertex")?;
        if position == NONE {
            let problem = format!("'{}' names no vertex; correct it or export the file again", shown(word));
            return Err(CornerFault::NotANumber(problem));
        }
        let uv = index(self.uvs.len(), "texture coordinate")?;
        let normal = index(self.normals.len(), "normal")?;
        Ok(Corner { position, uv, normal })
    }

    /// The mesh of a piece, in which each combination of indices is a vertex.
    fn mesh(&self, piece: &Piece) -> Mesh {
        let mut mesh = Mesh {
            name: self.objects.names[piece.object as usize].clone(),
            material: piece.material,
            ..Mesh::default()
        };
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
        let made = (lacks_normals && !stays_flat).then(|| self.made_normals(piece));
        let has_normals = made.is_some() || !lacks_normals;

        let mut vertex_of: HashMap<(Corner, [u32; 3]), u32> = HashMap::new();
        for (index, corners) in piece.triangles.iter().enumerate() {
            let vertices = std::array::from_fn(|at| {
                let corner = corners[at];
                let made = made.as_ref().map(|made| made[index][at]);
                // Of an empty face any direction will do.
                let normal = given(&corner).or(made).unwrap_or(Vec3::Y).try_normalize().unwrap_or(Vec3::Y);
                // Vertices are the same if what they look like is.
                let key = Corner { normal: NONE, ..corner };
                let normal_key = if has_normals { normal.to_array().map(f32::to_bits) } else { [0; 3] };
                *vertex_of.entry((key, normal_key)).or_insert_with(|| {
                    mesh.positions.push(self.positions[corner.position as usize]);
                    if has_normals {
                        mesh.normals.push(normal);
                    }
                    if !self.colours.is_empty() {
                        // Positions after the last coloured one are white.
                        let colour = self.colours.get(corner.position as usize);
                        mesh.colours.push(colour.copied().unwrap_or(Vec4::ONE));
                    }
                    if let [set] = &mut mesh.uv_sets[..] {
                        set.push(self.uvs.get(corner.uv as usize).copied().unwrap_or(Vec2::ZERO));
                    }
                    mesh.positions.len() as u32 - 1
                })
            });
            mesh.indices.push(vertices);
        }
        mesh
    }

    /// A mesh of the positions of points and lines, and their numbers in it.
    fn thread(&self, piece: &Piece, positions: &[u32]) -> (Mesh, Vec<u32>) {
        let mut mesh = Mesh {
            name: self.objects.names[piece.object as usize].clone(),
            material: piece.material,
            ..Mesh::default()
        };
        let mut number_of: HashMap<u32, u32> = HashMap::new();
        let number = |&position: &u32| {
            *number_of.entry(position).or_insert_with(|| {
                mesh.positions.push(self.positions[position as usize]);
                if !self.colours.is_empty() {
                    mesh.colours.push(self.colours.get(position as usize).copied().unwrap_or(Vec4::ONE));
                }
                mesh.positions.len() as u32 - 1
            })
        };
        let numbers = positions.iter().map(number).collect();
        (mesh, numbers)
    }

    /// Normals for all corners of a piece.
    fn made_normals(&self, piece: &Piece) -> Vec<[Vec3; 3]> {
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
        corner_normals(&positions, &triangles, |triangle| piece.smoothing[triangle])
    }
}

/// What is wrong with a corner.
enum CornerFault {
    /// It is not what a corner looks like; with what to do.
    NotANumber(String),
    /// It refers to something that is not there: what, and how many there are.
    NotThere(String),
}
