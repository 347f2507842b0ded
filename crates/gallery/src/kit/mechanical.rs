//! Shapes of machine parts: extruded outlines with bevelled edges, turned parts, gears, coils and bent pipes.
//!
//! Outlines lie in the x-y plane, counter-clockwise around the material, and are extruded along z.

use std::f32::consts::{PI, TAU};

use earcut::Earcut;
use glam::{Affine3A, Quat, Vec2, Vec3};

use crate::shape::{Shape, Vertex};

/// Edges that turn by less than about 40 degrees look round, as in [`Shape::lathe`].
const SOFT: f32 = 0.766;
/// The pressure angle of common gears, 20 degrees (ISO 53).
const PRESSURE_ANGLE_RAD: f32 = 0.349_066;
/// Tooth heights above and below the pitch circle in modules (ISO 53, profile A).
const ADDENDUM: f32 = 1.0;
const DEDENDUM: f32 = 1.25;
/// Each tooth is thinner than half the pitch by this share of the module, so that meshing flanks never
/// coincide.
const BACKLASH: f32 = 0.06;
/// Points of an involute flank.
const FLANK_POINTS: u32 = 3;

/// A closed polygon; its last corner is joined to its first.
pub(crate) type Outline = Vec<Vec2>;

/// A circle of so many corners.
pub(crate) fn circle(centre: Vec2, radius: f32, count: u32) -> Outline {
    (0..count).map(|i| centre + radius * Vec2::from_angle(TAU * i as f32 / count as f32)).collect()
}

/// A rectangle around the origin with round corners.
pub(crate) fn rounded_rectangle(half: Vec2, radius: f32) -> Outline {
    let corners = [half, Vec2::new(-half.x, half.y), -half, Vec2::new(half.x, -half.y)];
    rounded(&corners, radius, 5)
}

/// A polygon with its corners rounded off: `radius` is the distance from a corner at which the rounding
/// begins.
pub(crate) fn rounded(corners: &[Vec2], radius: f32, steps: u32) -> Outline {
    let count = corners.len();
    let mut outline = Vec::with_capacity(count * (steps as usize + 1));
    for (i, &corner) in corners.iter().enumerate() {
        let towards = |other: Vec2| {
            let edge = other - corner;
            corner + edge.normalize_or_zero() * radius.min(0.48 * edge.length())
        };
        let (from, to) = (towards(corners[(i + count - 1) % count]), towards(corners[(i + 1) % count]));
        // A quadratic Bézier: near enough to an arc for any corner.
        outline.extend((0..=steps).map(|s| {
            let s = s as f32 / steps as f32;
            from.lerp(corner, s).lerp(corner.lerp(to, s), s)
        }));
    }
    outline
}

/// The convex hull of points (Andrew 1979).
pub(crate) fn hull(points: impl IntoIterator<Item = Vec2>) -> Outline {
    let mut points: Vec<Vec2> = points.into_iter().collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut chain: Outline = Vec::new();
    for pass in 0..2 {
        let start = chain.len();
        let sweep: Box<dyn Iterator<Item = &Vec2>> =
            if pass == 0 { Box::new(points.iter()) } else { Box::new(points.iter().rev()) };
        for &point in sweep {
            while chain.len() >= start + 2
                && (chain[chain.len() - 1] - chain[chain.len() - 2]).perp_dot(point - chain[chain.len() - 1])
                    <= 1e-6
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
    }
    chain
}

/// A wall of even thickness along an open path; the path is its middle.
pub(crate) fn wall(path: &[Vec2], thickness: f32) -> Outline {
    let last = path.len() - 1;
    let across = |i: usize| {
        let before = (path[i] - path[i.saturating_sub(1)]).normalize_or_zero();
        let after = (path[(i + 1).min(last)] - path[i]).normalize_or_zero();
        let (before, after) = (if i == 0 { after } else { before }, if i == last { before } else { after });
        (before + after).perp() / (1.0 + before.dot(after)).max(0.3)
    };
    let side = |i: usize, sign: f32| path[i] + across(i) * (0.5 * sign * thickness);
    (0..=last).map(|i| side(i, -1.0)).chain((0..=last).rev().map(|i| side(i, 1.0))).collect()
}

/// An outline moved into its material, or out of it where `by` is negative.
pub(crate) fn inset(outline: &[Vec2], by: f32) -> Outline {
    let count = outline.len();
    let normal = |i: usize| (outline[(i + 1) % count] - outline[i]).normalize_or_zero().perp();
    (0..count)
        .map(|i| {
            let (before, after) = (normal((i + count - 1) % count), normal(i));
            // The mitre of a sharp corner is cut so that it does not run away.
            outline[i] + by * (before + after) / (1.0 + before.dot(after)).max(0.3)
        })
        .collect()
}

/// Radius of the pitch circle of a gear.
pub(crate) fn pitch_radius(teeth: u32, module: f32) -> f32 {
    0.5 * module * teeth as f32
}

/// A spur gear with involute teeth; the middle of a tooth lies on +x.
pub(crate) fn gear(teeth: u32, module: f32) -> Outline {
    let pitch = pitch_radius(teeth, module);
    let base = pitch * PRESSURE_ANGLE_RAD.cos();
    let (tip, root) = (pitch + ADDENDUM * module, pitch - DEDENDUM * module);
    // The involute function: how far the flank has wound up at a radius.
    let wound = |radius: f32| {
        let tangent = ((radius / base).powi(2) - 1.0).max(0.0).sqrt();
        tangent - tangent.atan()
    };
    let half_at_pitch = (0.25 * PI - 0.5 * BACKLASH) * module / pitch;
    let half_angle = |radius: f32| half_at_pitch + wound(pitch) - wound(radius.max(base));
    let flank = |s: u32| {
        let low = base.max(root);
        low + (tip - low) * s as f32 / (FLANK_POINTS - 1) as f32
    };
    let mut outline = Vec::new();
    for tooth in 0..teeth {
        let middle = TAU * tooth as f32 / teeth as f32;
        let mut point = |radius: f32, offset: f32| outline.push(radius * Vec2::from_angle(middle + offset));
        let foot = half_angle(base.max(root));
        // The fillet at the foot widens towards the next tooth.
        let spread = foot + 0.3 * (PI / teeth as f32 - foot);
        point(root, -spread);
        (0..FLANK_POINTS).for_each(|s| point(flank(s), -half_angle(flank(s))));
        (0..FLANK_POINTS).rev().for_each(|s| point(flank(s), half_angle(flank(s))));
        point(root, spread);
    }
    outline
}

/// A rectangular section to be turned: a ring.
pub(crate) fn ring(inner: f32, outer: f32, low: f32, high: f32) -> [(f32, f32); 5] {
    [(inner, low), (outer, low), (outer, high), (inner, high), (inner, low)]
}

/// A bevelled disc or drum to be turned.
pub(crate) fn drum(radius: f32, low: f32, high: f32, bevel: f32) -> [(f32, f32); 6] {
    [
        (0.0, low),
        (radius - bevel, low),
        (radius, low + bevel),
        (radius, high - bevel),
        (radius - bevel, high),
        (0.0, high),
    ]
}

/// A half circle to be turned: a ball.
pub(crate) fn ball(radius: f32, steps: u32) -> Vec<(f32, f32)> {
    let at = |i: u32| {
        let (sin, cos) = (PI * i as f32 / steps as f32).sin_cos();
        (if i == 0 || i == steps { 0.0 } else { radius * sin }, -radius * cos)
    };
    (0..=steps).map(at).collect()
}

/// `world_from_part` of a part that is drawn standing on the origin along +Y and stands on `foot` along
/// `axis`.
pub(crate) fn stand(foot: Vec3, axis: Vec3) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_arc(Vec3::Y, axis.normalize()), foot)
}

/// A smooth curve through points (Catmull-Rom), `steps` pieces from each to the next.
pub(crate) fn bend(points: &[Vec3], steps: u32) -> Vec<Vec3> {
    let last = points.len() - 1;
    let at = |i: isize| points[i.clamp(0, last as isize) as usize];
    let mut curve = Vec::new();
    for i in 0..last as isize {
        let [p, q, r, s] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        curve.extend((0..steps).map(|step| {
            let t = step as f32 / steps as f32;
            0.5 * (2.0 * q
                + (r - p) * t
                + (2.0 * p - 5.0 * q + 4.0 * r - s) * t * t
                + (3.0 * q - p - 3.0 * r + s) * t * t * t)
        }));
    }
    curve.push(points[last]);
    curve
}

impl Shape {
    /// Draws as `draw` says and moves what it has drawn; the move is rigid.
    pub(crate) fn moved(&mut self, self_from_drawn: Affine3A, draw: impl FnOnce(&mut Self)) {
        let first = self.positions.len();
        draw(self);
        for position in &mut self.positions[first..] {
            *position = self_from_drawn.transform_point3(*position);
        }
        for normal in &mut self.normals[first..] {
            *normal = self_from_drawn.transform_vector3(*normal);
        }
    }

    /// A [`Shape::lathe`] around `axis` through `foot`.
    pub(crate) fn turned(&mut self, foot: Vec3, axis: Vec3, profile: &[(f32, f32)], segment_count: u32) {
        self.moved(stand(foot, axis), |shape| shape.lathe(Vec3::ZERO, profile, segment_count));
    }

    /// A prism from `low` to `high` with bevelled edges: the first outline is its outside, the others are
    /// holes through it.
    pub(crate) fn extrude(&mut self, outlines: &[Outline], low: f32, high: f32, bevel: f32) {
        let outlines: Vec<Outline> = oriented(outlines);
        let caps: Vec<Outline> = outlines.iter().map(|outline| inset(outline, bevel)).collect();
        self.cap(&caps, low, -1.0);
        self.cap(&caps, high, 1.0);
        for (outline, cap) in outlines.iter().zip(&caps) {
            self.band([outline, outline], [low + bevel, high - bevel]);
            if bevel > 0.0 {
                self.band([cap, outline], [low, low + bevel]);
                self.band([outline, cap], [high - bevel, high]);
            }
        }
    }

    /// Extrudes along +Y what [`Self::extrude`] extrudes along +Z: the outlines give x and -z.
    pub(crate) fn extrude_up(&mut self, outlines: &[Outline], low: f32, high: f32, bevel: f32) {
        let upright = Affine3A::from_rotation_x(-0.5 * PI);
        self.moved(upright, |shape| shape.extrude(outlines, low, high, bevel));
    }

    /// A flat face with holes; `facing` is 1 or -1 along z.
    fn cap(&mut self, outlines: &[Outline], height: f32, facing: f32) {
        let mut holes: Vec<u32> = Vec::new();
        let mut count = outlines[0].len() as u32;
        for hole in &outlines[1..] {
            holes.push(count);
            count += hole.len() as u32;
        }
        let points: Vec<Vec2> = outlines.iter().flatten().copied().collect();
        let mut corners: Vec<u32> = Vec::new();
        Earcut::new().earcut(points.iter().map(|point| point.to_array()), &holes, &mut corners);
        let first = self.positions.len() as u32;
        for &point in &points {
            self.vertex(Vertex { position: point.extend(height), normal: Vec3::Z * facing, uv: point });
        }
        for &[a, b, c] in corners.as_chunks::<3>().0 {
            let at = |i: u32| points[i as usize];
            let turns_left = (at(b) - at(a)).perp_dot(at(c) - at(a)) > 0.0;
            let [b, c] = if turns_left == (facing > 0.0) { [b, c] } else { [c, b] };
            self.indices.push([first + a, first + b, first + c]);
        }
    }

    /// A strip between two outlines of as many points, the lower one first.
    fn band(&mut self, outlines: [&Outline; 2], heights: [f32; 2]) {
        let count = outlines[0].len();
        let corner = |level: usize, i: usize| outlines[level][i % count].extend(heights[level]);
        let face = |i: usize| {
            let i = i % count;
            let along = corner(0, i + 1) - corner(0, i) + corner(1, i + 1) - corner(1, i);
            along.cross(corner(1, i) - corner(0, i)).normalize_or_zero()
        };
        for i in 0..count {
            let own = face(i);
            let soft = |other: Vec3| if own.dot(other) > SOFT { (own + other).normalize() } else { own };
            let (start, end) = (soft(face(i + count - 1)), soft(face(i + 1)));
            let first = self.positions.len() as u32;
            for (level, at, normal) in [(0, i, start), (0, i + 1, end), (1, i + 1, end), (1, i, start)] {
                let position = corner(level, at);
                self.vertex(Vertex { position, normal, uv: Vec2::new(position.x, position.z) });
            }
            self.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }

    /// A round pipe along points; its open ends are closed by flat discs.
    pub(crate) fn pipe(&mut self, points: &[Vec3], radius: f32, segment_count: u32) {
        let points: Vec<(Vec3, f32)> = points.iter().map(|&point| (point, radius)).collect();
        self.tube(&points, segment_count);
        let last = points.len() - 1;
        for (at, before) in [(0, 1), (last, last - 1)] {
            let (end, out) = (points[at].0, points[at].0 - points[before].0);
            self.turned(end, out, &[(radius, 0.0), (0.0, 0.0)], segment_count);
        }
    }

    /// A coil spring from y = 0 upwards, wound closely at its ends as ground springs are.
    pub(crate) fn coil(&mut self, radius: f32, wire: f32, height: f32, turns: f32, segment_counts: [u32; 2]) {
        let count = (turns * segment_counts[0] as f32) as u32;
        let points: Vec<Vec3> = (0..=count)
            .map(|i| {
                let s = i as f32 / count as f32;
                let around = radius * Vec2::from_angle(TAU * turns * s);
                // Half the mean pitch at the ends.
                let climb = s - 0.5 * (TAU * s).sin() / TAU;
                Vec3::new(around.x, wire + climb * (height - 2.0 * wire), around.y)
            })
            .collect();
        self.pipe(&points, wire, segment_counts[1]);
    }
}

/// The first counter-clockwise, the others clockwise: the material lies on the left of them all.
fn oriented(outlines: &[Outline]) -> Vec<Outline> {
    let doubled_area = |outline: &Outline| -> f32 {
        (0..outline.len()).map(|i| outline[i].perp_dot(outline[(i + 1) % outline.len()])).sum()
    };
    let turned = |(i, outline): (usize, &Outline)| {
        let mut outline = outline.clone();
        if (doubled_area(&outline) > 0.0) != (i == 0) {
            outline.reverse();
        }
        outline
    };
    outlines.iter().enumerate().map(turned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(shape: &Shape) -> f32 {
        let corner = |i: u32| shape.positions[i as usize];
        shape.indices.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum::<f32>() / 6.0
    }

    fn normals_agree_with_winding(shape: &Shape) -> bool {
        shape.indices.iter().all(|&[a, b, c]| {
            let corner = |i: u32| shape.positions[i as usize];
            let face = (corner(b) - corner(a)).cross(corner(c) - corner(a));
            // Slivers have no face to speak of.
            face.length() < 1e-9 || [a, b, c].iter().all(|&i| face.dot(shape.normals[i as usize]) > 0.0)
        })
    }

    /// How much of the directed surface is left over: nothing if it is closed.
    fn leak(shape: &Shape) -> f32 {
        let corner = |i: u32| shape.positions[i as usize];
        let face = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a));
        shape.indices.iter().map(face).sum::<Vec3>().length()
    }

    fn area(outline: &[Vec2]) -> f32 {
        0.5 * (0..outline.len()).map(|i| outline[i].perp_dot(outline[(i + 1) % outline.len()])).sum::<f32>()
    }

    #[test]
    fn extrusions_look_outwards_whichever_way_their_outlines_run() {
        let mut hole = circle(Vec2::new(0.2, 0.1), 0.3, 40);
        let square = rounded_rectangle(Vec2::new(1.0, 0.8), 0.2);
        let expected = 0.5 * (area(&square) - area(&hole));
        for _ in 0..2 {
            let mut shape = Shape::default();
            shape.extrude(&[square.clone(), hole.clone()], 0.25, 0.75, 0.0);
            assert!((volume(&shape) - expected).abs() < 1e-4, "{} {expected}", volume(&shape));
            assert!(normals_agree_with_winding(&shape) && leak(&shape) < 1e-4);
            let mut bevelled = Shape::default();
            bevelled.extrude(&[square.clone(), hole.clone()], 0.25, 0.75, 0.02);
            assert!(volume(&bevelled) < expected && volume(&bevelled) > 0.97 * expected);
            assert!(normals_agree_with_winding(&bevelled) && leak(&bevelled) < 1e-4);
            hole.reverse();
        }
        // Negative control: an inside-out solid is found.
        let mut wrong = Shape::default();
        wrong.extrude(&[square], 0.0, 1.0, 0.0);
        wrong.indices.iter_mut().for_each(|corners| corners.swap(0, 1));
        assert!(volume(&wrong) < 0.0 && !normals_agree_with_winding(&wrong));
    }

    #[test]
    fn gears_walls_coils_and_pipes_are_solid() {
        let mut gear_wheel = Shape::default();
        gear_wheel.extrude(&[gear(24, 0.1), circle(Vec2::ZERO, 0.5, 48)], 0.0, 0.3, 0.01);
        let mut bent = Shape::default();
        bent.extrude(&[wall(&[Vec2::ZERO, Vec2::X, Vec2::new(1.5, 1.0)], 0.1)], 0.0, 1.0, 0.01);
        let mut coil = Shape::default();
        coil.coil(0.5, 0.05, 2.0, 5.0, [32, 10]);
        let mut pipe = Shape::default();
        pipe.pipe(&bend(&[Vec3::ZERO, Vec3::Y, Vec3::new(1.0, 2.0, 0.0)], 8), 0.2, 24);
        let mut sphere = Shape::default();
        sphere.turned(Vec3::X, Vec3::Z, &ball(0.5, 24), 48);
        assert!((volume(&sphere) - 4.0 / 3.0 * PI * 0.125).abs() < 0.01);
        for (name, shape) in
            [("gear", gear_wheel), ("wall", bent), ("coil", coil), ("pipe", pipe), ("ball", sphere)]
        {
            assert!(
                volume(&shape) > 0.0 && leak(&shape) < 1e-3,
                "{name}: {} {}",
                volume(&shape),
                leak(&shape)
            );
            assert!(normals_agree_with_winding(&shape), "{name}");
        }
    }

    #[test]
    fn a_gear_fills_half_its_pitch_circle_with_teeth() {
        let (teeth, module) = (24, 0.1);
        let outline = gear(teeth, module);
        let radius = |p: &Vec2| p.length() / module;
        let tallest = outline.iter().map(radius).fold(0.0, f32::max);
        let deepest = outline.iter().map(radius).fold(f32::MAX, f32::min);
        assert!((tallest - 13.0).abs() < 1e-4 && (deepest - 10.75).abs() < 1e-4, "{tallest} {deepest}");
        let pitch = pitch_radius(teeth, module);
        let crossings =
            outline.windows(2).filter(|pair| (pair[0].length() > pitch) != (pair[1].length() > pitch));
        assert_eq!(crossings.count() as u32, 2 * teeth);
        assert!(area(&outline) > 0.0);
    }

    #[test]
    fn a_hull_keeps_what_is_outside_and_drops_what_is_inside() {
        let square = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        let outline = hull(square.into_iter().chain([Vec2::splat(0.5), Vec2::new(0.5, 0.0)]));
        assert_eq!(outline.len(), 4);
        assert!((area(&outline) - 1.0).abs() < 1e-6);
        assert!((area(&inset(&outline, 0.1)) - 0.64).abs() < 1e-5);
    }
}
