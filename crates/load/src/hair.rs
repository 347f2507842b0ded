//! Hair files (Yuksel, *HAIR file format*, <http://www.cemyuksel.com/research/hairmodels/>): strands of
//! points with thickness, transparency and colour, drawn as twisting ribbons like the hairs of the built-in
//! scenes.
//!
//! A header of 128 bytes is followed by up to five arrays, of which the header says which are there:
//! segments of each strand, points, and thickness, transparency and colour of each point. What is not there
//! has one value for the whole file, in the header. Little endian; +Z is up.

use glam::{Quat, Vec3, Vec4};
use sheer_core::{
    colour::linear_from_srgb,
    hash::{pcg4d, unit_from_bits},
};
use sheer_scene::model::{AlphaMode, Material, Mesh, ShadingModel};

use super::{Loaded, single, source::Source, stroke::WIDTH_SHARE};
use crate::LoadError;

pub(super) const SIGNATURE: &[u8; 4] = b"HAIR";
const HEADER_BYTES: usize = 128;
/// Bits of the header's word that say which arrays there are.
const HAS_SEGMENTS: u32 = 1;
const HAS_POINTS: u32 = 1 << 1;
const HAS_THICKNESS: u32 = 1 << 2;
const HAS_TRANSPARENCY: u32 = 1 << 3;
const HAS_COLOURS: u32 = 1 << 4;
/// How far a ribbon turns on its way, so that it is not seen edge-on all along.
const TWIST_RAD: f32 = std::f32::consts::PI;
/// Bytes of a point: two vertices of position, direction and colour and four triangles, in lists that double
/// as they grow.
const POINT_BYTES: usize = 2 * (2 * (12 + 12 + 16) + 4 * 12);
/// Perceptual roughness of hair, as in the built-in scenes.
const ROUGHNESS: f32 = 0.35;

/// Numbers one after the other.
struct Bytes<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// The next array of `count` elements, or those of them that are there, and what is missing.
    fn array(&mut self, count: usize, element_bytes: usize, what: &str) -> (&'a [u8], Option<String>) {
        let rest = &self.bytes[self.at..];
        let length = count.saturating_mul(element_bytes);
        let missing = (length > rest.len()).then(|| {
            format!(
                "{count} {what} of {element_bytes} bytes should stand here, but the file ends after {} bytes; copy or export it again",
                self.bytes.len()
            )
        });
        let array = &rest[..length.min(rest.len() / element_bytes * element_bytes)];
        self.at += array.len();
        (array, missing)
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn float(bytes: &[u8], index: usize) -> f32 {
    f32::from_bits(word(bytes, 4 * index))
}

fn vector(bytes: &[u8], index: usize) -> Vec3 {
    Vec3::new(float(bytes, 3 * index), float(bytes, 3 * index + 1), float(bytes, 3 * index + 2))
}

/// An array, and the value of the points that are not in it.
struct Array<'a, T> {
    bytes: &'a [u8],
    element_bytes: usize,
    read: fn(&[u8], usize) -> T,
    default: T,
}

impl<T: Copy> Array<'_, T> {
    fn at(&self, index: usize) -> T {
        let is_there = index < self.bytes.len() / self.element_bytes;
        if is_there { (self.read)(self.bytes, index) } else { self.default }
    }
}

/// What a file says of its points.
struct Points<'a> {
    positions: &'a [u8],
    thickness: Array<'a, f32>,
    transparency: Array<'a, f32>,
    colours: Array<'a, Vec3>,
}

impl Points<'_> {
    fn width(&self, index: usize) -> f32 {
        self.thickness.at(index)
    }

    /// Linear colour and opacity.
    fn colour(&self, index: usize) -> Vec4 {
        let transparency = self.transparency.at(index);
        let colour = self.colours.at(index);
        let alpha = if transparency.is_nan() { 1.0 } else { 1.0 - transparency.clamp(0.0, 1.0) };
        colour.max(Vec3::ZERO).min(Vec3::ONE).map(linear_from_srgb).extend(alpha)
    }
}

pub(super) fn read(bytes: &[u8], source: Source<'_>) -> Result<Loaded, LoadError> {
    // The header.
    if bytes.len() < HEADER_BYTES || !bytes.starts_with(SIGNATURE) {
        let problem =
            "this is no hair file: it does not begin with 'HAIR' and a header of 128 bytes; export it again";
        return Err(source.fault("header", problem));
    }
    let [strand_count, point_count] = [4, 8].map(|at| word(bytes, at) as usize);
    let (arrays, default_segments) = (word(bytes, 12), word(bytes, 16) as usize);
    let [default_thickness, default_transparency] = [20, 24].map(|at| f32::from_bits(word(bytes, at)));
    let default_colour = vector(&bytes[28..40], 0);
    if arrays & HAS_POINTS == 0 {
        return Err(source.fault("byte 12", "the file has no points, so there is no hair; export it again"));
    }

    // The arrays. What is missing of one has the value for all.
    let mut rest = Bytes { bytes, at: HEADER_BYTES };
    let mut array = |bit: u32, count: usize, element_bytes: usize, what: &str| -> Result<&[u8], LoadError> {
        if arrays & bit == 0 {
            return Ok(&[]);
        }
        let place = format!("byte {}", rest.at);
        let (array, missing) = rest.array(count, element_bytes, what);
        if let Some(missing) = missing {
            source.lost(place, missing)?;
        }
        Ok(array)
    };
    let segments = array(HAS_SEGMENTS, strand_count, 2, "numbers of segments")?;
    let positions = array(HAS_POINTS, point_count, 12, "points")?;
    let thickness = array(HAS_THICKNESS, point_count, 4, "thicknesses")?;
    let transparency = array(HAS_TRANSPARENCY, point_count, 4, "transparencies")?;
    let colours = array(HAS_COLOURS, point_count, 12, "colours")?;
    let point_count = positions.len() / 12;
    let mut points = Points {
        positions,
        thickness: Array { bytes: thickness, element_bytes: 4, read: float, default: default_thickness },
        transparency: Array {
            bytes: transparency,
            element_bytes: 4,
            read: float,
            default: default_transparency,
        },
        colours: Array { bytes: colours, element_bytes: 12, read: vector, default: default_colour },
    };
    if (0..point_count).all(|index| !points.width(index).is_normal()) && point_count > 0 {
        let extent = extent(&points, point_count);
        points.thickness = Array { bytes: &[], default: WIDTH_SHARE * extent, ..points.thickness };
        source.repaired("points", "they have no thickness, and were drawn about a pixel wide");
    }

    // Each strand becomes a ribbon.
    source.check_triangle_count(point_count.saturating_mul(2), "points")?;
    source.take(point_count * POINT_BYTES, "points")?;
    let mut mesh = Mesh { name: "hair".to_owned(), ..Mesh::default() };
    let mut first = 0;
    let mut broken_count = 0_usize;
    for strand in 0..strand_count {
        let segment_count = match arrays & HAS_SEGMENTS {
            0 => default_segments,
            _ => match segments.get(2 * strand..2 * strand + 2) {
                Some(count) => usize::from(u16::from_le_bytes([count[0], count[1]])),
                None => break,
            },
        };
        let end = first + segment_count + 1;
        if end > point_count {
            let what = format!(
                "it needs points {first} to {end}, but there are only {point_count}; it and those after it were left out"
            );
            source.lost(format_args!("strand {strand}"), what)?;
            break;
        }
        broken_count += usize::from(!add_ribbon(&mut mesh, &points, first..end, strand as u32));
        first = end;
    }
    if broken_count > 0 {
        let strands =
            if broken_count == 1 { "one strand".to_owned() } else { format!("{broken_count} strands") };
        source.lost(
            "points",
            format!("{strands} with a point or thickness that is not finite were left out"),
        )?;
    }

    let mut parts = source.parts();
    let is_opaque = mesh.colours.iter().all(|colour| colour.w >= 1.0);
    let material = Material {
        name: "hair".to_owned(),
        model: ShadingModel::Fibre,
        alpha_mode: if is_opaque { AlphaMode::Opaque } else { AlphaMode::Blend },
        roughness: ROUGHNESS,
        double_sided: true,
        ..Material::default()
    };
    single::place_with(&mut parts, mesh, material, single::from_z_up());
    source.finish(parts)
}

/// Length of the diagonal of a box around the points that are finite; 1 if that is nothing.
fn extent(points: &Points<'_>, point_count: usize) -> f32 {
    let all = (0..point_count).map(|index| vector(points.positions, index)).filter(|point| point.is_finite());
    let [low, high] = all
        .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], point| [low.min(point), high.max(point)]);
    let extent = (high - low).length();
    if extent > 0.0 && extent.is_finite() { extent } else { 1.0 }
}

/// Adds the ribbon of a strand, with the direction of the hair in the place of normals; nothing, and false,
/// where a number is not finite.
fn add_ribbon(mesh: &mut Mesh, points: &Points<'_>, strand: std::ops::Range<usize>, number: u32) -> bool {
    let position = |index: usize| vector(points.positions, index);
    if !strand.clone().all(|index| position(index).is_finite() && points.width(index).is_finite()) {
        return false;
    }
    let [first, last] = [strand.start, strand.end - 1];
    let first_vertex = mesh.positions.len() as u32;
    // Each ribbon starts out turned another way.
    let [luck, ..] = pcg4d([number, 0, 0, 0]).map(unit_from_bits);
    let mut side = None;
    for index in strand.clone() {
        let along = (position((index + 1).min(last)) - position(index.saturating_sub(1).max(first)))
            .normalize_or(Vec3::Z);
        // Carried along without turning, so that the twist alone turns it.
        let carried = side.unwrap_or_else(|| {
            Quat::from_axis_angle(along, luck * std::f32::consts::TAU) * along.any_orthonormal_vector()
        });
        let across = (carried - along * along.dot(carried))
            .try_normalize()
            .unwrap_or_else(|| along.any_orthonormal_vector());
        side = Some(across);
        let way = (index - first) as f32 / (last - first).max(1) as f32;
        let half = Quat::from_axis_angle(along, TWIST_RAD * way) * across * (0.5 * points.width(index));
        let colour = points.colour(index);
        for edge in [position(index) - half, position(index) + half] {
            mesh.positions.push(edge);
            mesh.normals.push(along);
            mesh.colours.push(colour);
        }
    }
    for segment in 0..(last - first) as u32 {
        let at = first_vertex + 2 * segment;
        mesh.indices.extend([[at, at + 1, at + 3], [at, at + 3, at + 2]]);
    }
    true
}
