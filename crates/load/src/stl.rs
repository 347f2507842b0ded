//! STL, binary and text: bare triangles, with colours where the dialects of VisCAM or Magics have them.
//!
//! Read by hand: the kept crate takes a binary file whose header begins with `solid`, as many do, for text,
//! and knows no colours. Files have +Z up, as 3D printers do, and say nothing of normals but the winding.

use std::collections::HashMap;

use glam::{Vec3, Vec4};
use sheer_core::colour::linear_from_srgb;
use sheer_scene::model::Mesh;

use super::{
    Loaded,
    single::{self, GREY},
    source::Source,
    text,
};
use crate::LoadError;

const HEADER_BYTES: usize = 80;
/// A normal, three corners and a word of attributes.
const TRIANGLE_BYTES: usize = 50;
/// Of the attributes: a colour is there (VisCAM), or is not (Magics).
const COLOUR_FLAG: u16 = 0x8000;

/// Bytes of a triangle, and of a vertex with its entry among those that are known, in lists that double as
/// they grow.
const INDEX_BYTES: usize = 2 * size_of::<[u32; 3]>();
const VERTEX_BYTES: usize = 2 * (size_of::<Vec3>() + size_of::<Vec4>() + size_of::<([u32; 7], u32)>());

/// Triangles as they are read; corners of the same bits are one vertex.
struct Solid<'s, 'a> {
    source: &'s Source<'a>,
    mesh: Mesh,
    vertex_of: HashMap<[u32; 7], u32>,
    dropped_count: usize,
}

impl<'s, 'a> Solid<'s, 'a> {
    fn new(source: &'s Source<'a>) -> Self {
        Self { source, mesh: Mesh::default(), vertex_of: HashMap::new(), dropped_count: 0 }
    }

    fn add(&mut self, corners: [Vec3; 3], colour: Option<Vec4>) -> Result<(), LoadError> {
        if !corners.iter().all(|corner| corner.is_finite()) {
            self.dropped_count += 1;
            return Ok(());
        }
        self.source.take(INDEX_BYTES, "triangles")?;
        let mut vertices = [0; 3];
        for (vertex, corner) in vertices.iter_mut().zip(corners) {
            let colour = colour.unwrap_or(Vec4::ONE);
            let mut key = [0; 7];
            key[..3].copy_from_slice(&corner.to_array().map(f32::to_bits));
            key[3..].copy_from_slice(&colour.to_array().map(f32::to_bits));
            let next = self.mesh.positions.len() as u32;
            *vertex = *self.vertex_of.entry(key).or_insert(next);
            if *vertex == next {
                self.source.take(VERTEX_BYTES, "triangles")?;
                self.mesh.positions.push(corner);
                self.mesh.colours.push(colour);
            }
        }
        self.mesh.indices.push(vertices);
        Ok(())
    }
}

/// Whether a file that begins with these bytes is STL text.
pub(super) fn begins_like_stl(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().starts_with(b"solid")
}

pub(super) fn read(bytes: &[u8], source: Source<'_>) -> Result<Loaded, LoadError> {
    let mut parts = source.parts();
    let (solid, base) =
        if is_binary(bytes) { read_binary(bytes, &source)? } else { read_text(bytes, &source)? };
    let Solid { mut mesh, dropped_count, .. } = solid;
    if dropped_count > 0 {
        let triangles =
            if dropped_count == 1 { "one triangle".to_owned() } else { format!("{dropped_count} triangles") };
        source
            .lost("triangles", format!("{triangles} with a coordinate that is not finite were left out"))?;
    }
    if mesh.colours.iter().all(|colour| *colour == Vec4::ONE) {
        mesh.colours.clear();
    }
    single::place(&mut parts, mesh, base, single::from_z_up());
    source.finish(parts)
}

/// Text begins with `solid`; so do the headers of many binary files, whose length gives them away, or that
/// they hold a byte that no text does.
fn is_binary(bytes: &[u8]) -> bool {
    if !begins_like_stl(bytes) {
        return true;
    }
    let claimed = claimed_count(bytes).map(|count| HEADER_BYTES + 4 + count * TRIANGLE_BYTES);
    claimed == Some(bytes.len()) || bytes.iter().take(1024).any(|&byte| byte == 0)
}

fn claimed_count(bytes: &[u8]) -> Option<usize> {
    let word = bytes.get(HEADER_BYTES..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*word) as usize)
}

fn read_binary<'s, 'a>(bytes: &[u8], source: &'s Source<'a>) -> Result<(Solid<'s, 'a>, Vec4), LoadError> {
    let Some(mut claimed) = claimed_count(bytes) else {
        let problem =
            "this is no STL file: neither text that begins with 'solid' nor 84 bytes of a binary header";
        return Err(source.fault("header", problem));
    };
    let (header, body) = (&bytes[..HEADER_BYTES], &bytes[HEADER_BYTES + 4..]);
    let whole = body.len() / TRIANGLE_BYTES;
    if claimed > whole {
        if whole == 0 {
            let problem = format!(
                "{claimed} triangles are promised, but the file ends after {} bytes; copy or export it again",
                bytes.len()
            );
            return Err(source.fault("byte 80", problem));
        }
        source.lost("byte 80", format!("{claimed} triangles are promised, only {whole} are there"))?;
    } else if claimed == 0 && whole > 0 {
        // A program that was writing and never came back to the number.
        source.repaired("byte 80", format!("no triangles are promised, but {whole} are there"));
        claimed = whole;
    } else if claimed < whole {
        let bytes = body.len() - claimed * TRIANGLE_BYTES;
        source.repaired(
            "byte 80",
            format!("{claimed} triangles are promised; {bytes} bytes after them were left out"),
        );
    }
    source.check_triangle_count(claimed.min(whole), "byte 80")?;
    // Magics writes the colour of the whole into the header, with its opacity.
    let whole_colour = header.windows(10).find(|window| window.starts_with(b"COLOR="));
    let whole_colour = whole_colour.map(|window| {
        let [r, g, b, a] = [6, 7, 8, 9].map(|at| f32::from(window[at]) / 255.0);
        Vec4::new(linear_from_srgb(r), linear_from_srgb(g), linear_from_srgb(b), a)
    });
    let mut solid = Solid::new(source);
    for record in body.chunks_exact(TRIANGLE_BYTES).take(claimed) {
        let float =
            |at: usize| f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]);
        let corner = |at: usize| Vec3::new(float(at), float(at + 4), float(at + 8));
        let attributes = u16::from_le_bytes([record[48], record[49]]);
        let colour = facet_colour(attributes, whole_colour.is_some());
        // Of the whole's colour the facet's own stands in the place.
        let colour = match (colour, whole_colour) {
            (Some(colour), Some(whole)) => Some(colour.with_w(whole.w)),
            (None, Some(whole)) => Some(whole),
            (colour, None) => colour,
        };
        solid.add([corner(12), corner(24), corner(36)], colour)?;
    }
    let is_coloured = solid.mesh.colours.iter().any(|colour| *colour != Vec4::ONE);
    Ok((solid, if is_coloured { Vec4::ONE } else { GREY }))
}

/// The colour in a facet's attributes, five bits a channel.
fn facet_colour(attributes: u16, is_magics: bool) -> Option<Vec4> {
    // Magics sets the flag where the whole's colour holds, and has red in the low bits.
    if (attributes & COLOUR_FLAG != 0) == is_magics {
        return None;
    }
    let channel = |shift: u16| linear_from_srgb(f32::from(attributes >> shift & 31) / 31.0);
    let [low, middle, high] = [channel(0), channel(5), channel(10)];
    Some(if is_magics { Vec4::new(low, middle, high, 1.0) } else { Vec4::new(high, middle, low, 1.0) })
}

fn read_text<'s, 'a>(bytes: &[u8], source: &'s Source<'a>) -> Result<(Solid<'s, 'a>, Vec4), LoadError> {
    let mut solid = Solid::new(source);
    let mut corners: Vec<Vec3> = Vec::new();
    let mut is_ended = false;
    for line in text::lines(bytes) {
        let mut words = line.words();
        let Some(word) = words.next() else { continue };
        is_ended = false;
        match word.to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let corner = vector(&mut words).or_else(|problem| {
                    let what = format!("{problem}; the facet was left out");
                    source.lost(line.place(), what).map(|()| Vec3::NAN)
                })?;
                corners.push(corner);
            }
            b"endloop" | b"endfacet" => {
                // A loop has three corners; more are a fan.
                for at in 2..corners.len() {
                    solid.add([corners[0], corners[at - 1], corners[at]], None)?;
                }
                if matches!(corners.len(), 1 | 2) {
                    source.lost(line.place(), "a facet of fewer than three corners was left out")?;
                }
                corners.clear();
            }
            b"endsolid" => is_ended = true,
            b"solid" | b"facet" | b"outer" | b"end" => {}
            _ => {
                source.lost(
                    line.place(),
                    format!("'{}' is no word of STL; the line was left out", text::shown(word)),
                )?;
            }
        }
    }
    if !is_ended {
        source.lost("end", "the file ends without 'endsolid': it may be cut short")?;
    }
    source.check_triangle_count(solid.mesh.indices.len(), "triangles")?;
    Ok((solid, GREY))
}

fn vector<'w>(words: &mut impl Iterator<Item = &'w [u8]>) -> Result<Vec3, String> {
    Ok(Vec3::new(text::next_number(words)?, text::next_number(words)?, text::next_number(words)?))
}
