//! Vertex normals where a file has none: smooth across faces that meet at a blunt angle, with a crease where
//! the angle is sharp.

use glam::{DVec3, Vec3};

/// Faces that meet at less than this angle between their normals are parts of one smooth surface: 45°, which
/// keeps the edges of boxes and prisms of up to seven sides.
const CREASE_COSINE: f32 = std::f32::consts::FRAC_1_SQRT_2;
/// Faces at one vertex that are compared with each other; beyond it they stay flat, as at the tip of a cone.
const MOST_FACES: usize = 256;

/// How the normals of a triangle are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Smoothing {
    /// It is flat.
    Flat,
    /// It is smooth where it meets others of the same number, whatever the angle.
    Group(u32),
    /// It is smooth where it meets others at a blunt angle.
    Angle,
}

/// Bytes that making the normals of so many triangles takes, with a list of the positions that they have.
pub(super) fn bytes(triangle_count: usize) -> usize {
    let of_triangle = size_of::<Face>() + size_of::<[Vec3; 3]>() + 2 * size_of::<[u32; 3]>();
    let of_position = size_of::<Vec3>() + 2 * size_of::<u32>() + 4 * size_of::<[u32; 2]>();
    // Positions that no other triangle has are three a triangle.
    triangle_count.saturating_mul(of_triangle + 3 * of_position)
}

/// Normals at the corners of triangles, unit vectors; zero where all faces at a corner are empty.
///
/// Each is the sum of the normals of the faces that are smooth there, weighted by their angles at the corner
/// (Thürmer and Wüthrich 1998, *Computing Vertex Normals from Polygonal Facets*), so that it does not depend
/// on how a face was cut into triangles.
pub(super) fn corner_normals(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    smoothing: impl Fn(usize) -> Smoothing,
) -> Vec<[Vec3; 3]> {
    let faces: Vec<Face> = triangles.iter().map(|corners| Face::new(positions, *corners)).collect();

    // The triangles at each position, one list after the other.
    let mut starts = vec![0_u32; positions.len() + 1];
    for &corner in triangles.as_flattened() {
        starts[corner as usize + 1] += 1;
    }
    for at in 1..starts.len() {
        starts[at] += starts[at - 1];
    }
    let mut filled = starts.clone();
    let mut around = vec![0_u32; triangles.len() * 3];
    for (triangle, corners) in triangles.iter().enumerate() {
        for &corner in corners {
            around[filled[corner as usize] as usize] = triangle as u32;
            filled[corner as usize] += 1;
        }
    }

    let normal_at = |triangle: usize, corner: u32| {
        let own = smoothing(triangle);
        let range = starts[corner as usize] as usize..starts[corner as usize + 1] as usize;
        if own == Smoothing::Flat || range.len() > MOST_FACES {
            return faces[triangle].normal;
        }
        let smooth = around[range].iter().map(|&other| other as usize).filter(|&other| match own {
            Smoothing::Angle => {
                smoothing(other) == own
                    && (other == triangle || faces[other].normal.dot(faces[triangle].normal) > CREASE_COSINE)
            }
            _ => smoothing(other) == own,
        });
        let weighted = smooth.map(|other| {
            let at = triangles[other].iter().position(|other| *other == corner).unwrap_or(0);
            faces[other].normal * faces[other].angles_rad[at]
        });
        weighted.sum::<Vec3>().try_normalize().unwrap_or(faces[triangle].normal)
    };
    (triangles.iter().enumerate())
        .map(|(triangle, corners)| corners.map(|corner| normal_at(triangle, corner)))
        .collect()
}

/// What a triangle adds to the normals at its corners.
struct Face {
    /// Unit, or zero without an area.
    normal: Vec3,
    angles_rad: [f32; 3],
}

impl Face {
    fn new(positions: &[Vec3], corners: [u32; 3]) -> Self {
        // In double precision no area vanishes.
        let [a, b, c] = corners.map(|corner| positions[corner as usize].as_dvec3());
        let angle = |at: DVec3, one: DVec3, other: DVec3| {
            let (one, other) = (one - at, other - at);
            one.cross(other).length().atan2(one.dot(other)) as f32
        };
        Self {
            normal: (b - a).cross(c - a).normalize_or_zero().as_vec3(),
            angles_rad: [angle(a, b, c), angle(b, c, a), angle(c, a, b)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares of two triangles each that share an edge and meet at an angle.
    fn folded(angle_rad: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (sin, cos) = angle_rad.sin_cos();
        let positions = vec![
            Vec3::new(-1.0, 0.0, 0.0),
            Vec3::new(-1.0, 0.0, 1.0),
            Vec3::ZERO,
            Vec3::Z,
            Vec3::new(cos, sin, 0.0),
            Vec3::new(cos, sin, 1.0),
        ];
        (positions, vec![[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]])
    }

    #[test]
    fn blunt_angles_are_smooth_and_sharp_ones_creased() {
        for (degrees, is_smooth) in [(30.0_f32, true), (60.0, false)] {
            let (positions, triangles) = folded(degrees.to_radians());
            let normals = corner_normals(&positions, &triangles, |_| Smoothing::Angle);
            let (left, right) = (normals[1][0], normals[2][0]);
            assert_eq!((left - right).length() < 1e-5, is_smooth, "{degrees}: {left} and {right}");
            assert!((normals[0][0] - Vec3::Y).length() < 1e-6, "away from the edge it is flat");
        }
    }

    #[test]
    fn groups_are_smooth_at_any_angle_and_only_among_themselves() {
        let (positions, triangles) = folded(1.2);
        let normals = corner_normals(&positions, &triangles, |_| Smoothing::Group(1));
        assert!((normals[1][0] - normals[2][0]).length() < 1e-5);
        let apart = corner_normals(&positions, &triangles, |triangle| {
            Smoothing::Group(if triangle < 2 { 1 } else { 2 })
        });
        assert!((apart[1][0] - Vec3::Y).length() < 1e-6, "{}", apart[1][0]);
        let flat = corner_normals(&positions, &triangles, |_| Smoothing::Flat);
        assert_eq!(flat[2][0], flat[3][2]);
    }

    #[test]
    fn tiny_triangles_have_normals_and_empty_ones_none() {
        let positions = [Vec3::ZERO, Vec3::X * 1e-15, Vec3::Z * 1e-15];
        let normals = corner_normals(&positions, &[[0, 2, 1], [0, 0, 1]], |_| Smoothing::Flat);
        assert!((normals[0][0] - Vec3::Y).length() < 1e-5, "{}", normals[0][0]);
        assert_eq!(normals[1][0], Vec3::ZERO);
    }
}
