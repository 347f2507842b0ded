//! Hairs as ribbons: flat, twisting, narrowing to a point, with the direction of the hair in the place of
//! normals ([`ShadingModel::Fibre`](sheer_scene::model::ShadingModel::Fibre)).
//!
//! A ribbon does not turn towards the camera: it twists on its way instead, so that no hair is seen edge-on
//! all along, and its shadow is as thin as itself.

use glam::{IVec3, Quat, Vec2, Vec3, Vec4};
use sheer_core::hash::{pcg4d, unit_from_bits};
use sheer_scene::model::{AlphaMode, Material, ShadingModel};

use crate::shape::{Shape, Vertex};

/// The course of one hair, from which its ribbon is built.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strand<'a> {
    /// Points of its middle line from the root to the tip, at least two.
    pub(crate) points: &'a [Vec3],
    /// Width at the root; it narrows towards the tip.
    pub(crate) width: f32,
    /// Roughly the direction of its width at the root.
    pub(crate) side: Vec3,
    /// How far it has turned at the tip.
    pub(crate) twist_rad: f32,
}

/// Triangles of a hair of so many segments: the last one ends in a point.
#[cfg(test)]
pub(crate) const fn triangle_count(segment_count: u32) -> u32 {
    2 * segment_count - 1
}

/// Adds a hair; `colour` gives its linear colour and alpha by the share of the way from root (0) to tip (1).
pub(crate) fn ribbon(shape: &mut Shape, strand: &Strand<'_>, colour: impl Fn(f32) -> Vec4) {
    let points = strand.points;
    let last = points.len() - 1;
    let first = shape.positions.len() as u32;
    let mut side = strand.side;
    for (i, &point) in points.iter().enumerate() {
        let along = (points[(i + 1).min(last)] - points[i.saturating_sub(1)]).normalize_or(Vec3::Y);
        // Carried along without turning, so that the twist alone turns it.
        side = (side - along * along.dot(side)).try_normalize().unwrap_or(along.any_orthonormal_vector());
        let way = i as f32 / last as f32;
        let across = Quat::from_axis_angle(along, strand.twist_rad * way) * side;
        // Full over the first half, then narrowing ever faster.
        let half = across * (0.5 * strand.width * (1.0 - way * way));
        shape.brush(colour(way));
        let mut vertex =
            |position: Vec3, u: f32| shape.vertex(Vertex { position, normal: along, uv: Vec2::new(u, way) });
        if i == last {
            vertex(point, 0.5);
        } else {
            vertex(point - half, 0.0);
            vertex(point + half, 1.0);
        }
    }
    for i in 0..last as u32 - 1 {
        let at = first + 2 * i;
        shape.indices.extend([[at, at + 1, at + 3], [at, at + 3, at + 2]]);
    }
    let at = first + 2 * last as u32;
    shape.indices.push([at - 2, at - 1, at]);
}

/// Hairs that keep together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tuft {
    /// Near the middle of their roots.
    pub(crate) centre: Vec3,
    /// What they share, 0 to 1.
    pub(crate) luck: [f32; 4],
}

/// The tuft of a root: points are strewn through space, one a cell of this size, and the nearest one counts.
pub(crate) fn tuft(root: Vec3, size: f32, seed: u32) -> Tuft {
    let cell = (root / size).floor().as_ivec3();
    let mut best = (f32::MAX, Vec3::ZERO, IVec3::ZERO);
    for index in 0..27 {
        let at = cell + IVec3::new(index % 3 - 1, index / 3 % 3 - 1, index / 9 - 1);
        let [x, y, z, _] = luck(at, seed);
        let centre = (at.as_vec3() + Vec3::new(x, y, z)) * size;
        let distance = centre.distance_squared(root);
        if distance < best.0 {
            best = (distance, centre, at);
        }
    }
    Tuft { centre: best.1, luck: luck(best.2, seed ^ 0x9e37_79b9) }
}

fn luck(cell: IVec3, seed: u32) -> [f32; 4] {
    pcg4d([cell.x as u32, cell.y as u32, cell.z as u32, seed]).map(unit_from_bits)
}

/// The material of hair: everything else is in the colours of its vertices.
pub(crate) fn material(name: &str, roughness: f32) -> Material {
    Material {
        name: name.to_owned(),
        model: ShadingModel::Fibre,
        alpha_mode: AlphaMode::Blend,
        roughness,
        double_sided: true,
        ..Material::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ribbon_tapers_to_a_point_and_keeps_its_length() {
        let points: Vec<Vec3> =
            (0..=6).map(|i| Vec3::new(0.1 * i as f32, 0.02 * (i * i) as f32, 0.3)).collect();
        let mut shape = Shape::default();
        let strand = Strand { points: &points, width: 0.01, side: Vec3::Z, twist_rad: 2.0 };
        ribbon(&mut shape, &strand, |way| Vec4::new(1.0, 1.0, 1.0, 1.0 - way));
        assert_eq!(shape.indices.len() as u32, triangle_count(6));
        assert_eq!(shape.positions.len(), 13);
        let widths: Vec<f32> =
            (0..6).map(|i| shape.positions[2 * i].distance(shape.positions[2 * i + 1])).collect();
        assert!((widths[0] - 0.01).abs() < 1e-6, "{widths:?}");
        assert!(widths.windows(2).all(|pair| pair[1] < pair[0]), "{widths:?}");
        for (i, &point) in points.iter().take(6).enumerate() {
            let middle = 0.5 * (shape.positions[2 * i] + shape.positions[2 * i + 1]);
            let across = shape.positions[2 * i + 1] - shape.positions[2 * i];
            assert!(middle.distance(point) < 1e-6);
            assert!(across.dot(shape.normals[2 * i]).abs() < 1e-6, "flat across its direction");
        }
        assert_eq!(shape.positions[12], points[6]);
        assert_eq!(shape.colours[12].w, 0.0);
        assert!(shape.indices.iter().flatten().all(|&index| index < 13));
    }
}
