//! Polygons cut into triangles: a fan where that is right, and ears where it is not.

use glam::{Vec2, Vec3};

/// Corners that are held against others in the polygons of a file: a second or two. Cutting ears is quadratic
/// in the corners of most polygons, and cubic in those of some.
const MOST_WORK: u64 = 1 << 29;

/// Cuts the polygons of a file.
pub(super) struct Cutter {
    work_left: u64,
}

impl Cutter {
    pub(super) fn new() -> Self {
        Self { work_left: MOST_WORK }
    }

    /// Whether some polygons became fans that should not have, because there were too many of too many
    /// corners.
    pub(super) fn gave_up(&self) -> bool {
        self.work_left == 0
    }

    /// Triangles of a polygon of so many corners, at least three, in its own order; `at` says where a corner
    /// is.
    pub(super) fn triangles(&mut self, count: u32, at: impl Fn(u32) -> Vec3) -> Vec<[u32; 3]> {
        triangles(count, at, &mut self.work_left)
    }
}

fn triangles(count: u32, at: impl Fn(u32) -> Vec3, work_left: &mut u64) -> Vec<[u32; 3]> {
    let fan = || (2..count).map(|corner| [0, corner - 1, corner]).collect();
    if count < 4 {
        return fan();
    }
    // The plane of the polygon (Newell): the axis along which it is most extended drops out.
    let origin = at(0);
    let from_origin = |corner: u32| at(corner % count) - origin;
    let normal: Vec3 = (0..count).map(|corner| from_origin(corner).cross(from_origin(corner + 1))).sum();
    let normal = normal.abs().max_element().recip() * normal;
    if !normal.is_finite() {
        return fan();
    }
    let flat = |corner: u32| {
        let Vec3 { x, y, z } = from_origin(corner);
        let size = normal.abs();
        if size.z >= size.x.max(size.y) {
            Vec2::new(x, y) * Vec2::new(normal.z.signum(), 1.0)
        } else if size.y >= size.x {
            Vec2::new(z, x) * Vec2::new(normal.y.signum(), 1.0)
        } else {
            Vec2::new(y, z) * Vec2::new(normal.x.signum(), 1.0)
        }
    };
    let points: Vec<Vec2> = (0..count).map(flat).collect();
    let turn = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|corner| points[corner as usize]);
        (b - a).perp_dot(c - b)
    };
    let is_convex =
        (0..count).all(|corner| turn([corner, (corner + 1) % count, (corner + 2) % count]) >= 0.0);
    if is_convex || *work_left == 0 {
        return fan();
    }

    // Ears: corners whose triangle holds no other corner.
    let mut left: Vec<u32> = (0..count).collect();
    let mut triangles = Vec::with_capacity(count as usize - 2);
    while left.len() > 3 {
        let around =
            |at: usize| [left[(at + left.len() - 1) % left.len()], left[at], left[(at + 1) % left.len()]];
        let searched = if *work_left == 0 { 0 } else { left.len() };
        let is_ear = |at: &usize| {
            let [a, b, c] = around(*at);
            *work_left = work_left.saturating_sub(left.len() as u64);
            turn([a, b, c]) > 0.0
                && left.iter().filter(|corner| ![a, b, c].contains(corner)).all(|&other| {
                    let inside = |from: u32, to: u32| turn([from, to, other]) >= 0.0;
                    !(inside(a, b) && inside(b, c) && inside(c, a))
                })
        };
        // A polygon that crosses itself has none at some point: any corner will do.
        let ear = (0..searched).find(is_ear).unwrap_or(0);
        triangles.push(around(ear));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[Vec3]) -> f32 {
        let triangles = Cutter::new().triangles(points.len() as u32, |corner| points[corner as usize]);
        assert_eq!(triangles.len(), points.len() - 2);
        triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|corner| points[corner as usize]);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum()
    }

    #[test]
    fn a_concave_polygon_is_covered_once() {
        // An arrow head, whose fan around the first corner would reach outside, in three planes, both ways.
        let arrow = [(0.0, 0.0), (2.0, -1.0), (1.0, 0.0), (2.0, 1.0)];
        for [x, y] in [[Vec3::X, Vec3::Y], [Vec3::Y, Vec3::Z], [Vec3::Z, Vec3::X]] {
            let mut points: Vec<Vec3> = arrow.iter().map(|&(u, v)| x * u + y * v).collect();
            for _ in 0..2 {
                for _ in 0..4 {
                    points.rotate_left(1);
                    assert!((area(&points) - 1.0).abs() < 1e-6, "{points:?}");
                }
                points.reverse();
            }
        }
        // The fan of the second corner covers more.
        let fan: f32 = {
            let points: Vec<Vec3> =
                [1, 2, 3, 0].map(|at: usize| Vec3::new(arrow[at].0, arrow[at].1, 0.0)).into();
            (2..4).map(|at| 0.5 * (points[at - 1] - points[0]).cross(points[at] - points[0]).length()).sum()
        };
        assert!(fan > 1.5, "{fan}");
    }

    #[test]
    fn what_crosses_itself_or_has_no_area_ends_all_the_same() {
        let bow = [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::X, Vec3::Y, Vec3::splat(0.5)];
        let mut cutter = Cutter::new();
        assert_eq!(cutter.triangles(5, |corner| bow[corner as usize]).len(), 3);
        assert_eq!(cutter.triangles(6, |_| Vec3::ZERO).len(), 4);
        assert!(!cutter.gave_up());
    }

    #[test]
    fn tangled_polygons_of_many_corners_end_and_are_owned_up_to() {
        // A star that winds around its middle again and again.
        let star = |corner: u32| {
            let (sin, cos) = (2.4 * corner as f32).sin_cos();
            Vec3::new(cos, sin, 0.0) * (1.0 + 0.3 * (corner % 7) as f32)
        };
        let mut cutter = Cutter::new();
        assert_eq!(cutter.triangles(20_000, star).len(), 19_998);
        while !cutter.gave_up() {
            cutter.triangles(5000, star);
        }
        assert_eq!(cutter.triangles(5, star).len(), 3);
    }
}
