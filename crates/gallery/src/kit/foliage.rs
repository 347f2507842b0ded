//! Trees, bushes and flowers: clumps of cut-out cards on branches.
//!
//! A card shows a cluster of leaves from both sides and is shaded with the normal of the crown that it
//! belongs to, not its own: light then falls on a tree as on a soft round body.

use std::f32::consts::TAU;

use glam::{Quat, Vec2, Vec3};

use crate::{
    kit::{leaf::Cluster, palette::Palette},
    paint::smoothstep,
    rng::Rng,
    shape::{Model, Shape, Vertex},
};

/// How a tree grows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Habit {
    /// Height of the top of the crown, metres.
    pub(crate) height: f32,
    /// Radius of the crown, metres.
    pub(crate) radius: f32,
    /// Where the crown begins, share of the height.
    pub(crate) clear: f32,
    pub(crate) clump_count: u32,
    pub(crate) cards_per_clump: u32,
    /// Share of the cards that begin to turn yellow.
    pub(crate) turning: f32,
}

/// A tree that stands at the origin.
pub(crate) fn tree(palette: &Palette, rng: &mut Rng, habit: Habit) -> Model {
    let mut model = Model::default();
    let low = habit.height * habit.clear;
    let radii = Vec3::new(habit.radius, 0.5 * (habit.height - low), habit.radius);
    let centre = Vec3::Y * (low + radii.y);

    // A trunk that leans a little and flares at its foot.
    let lean = Vec3::new(rng.about(0.0, 0.25), 0.0, rng.about(0.0, 0.25));
    let thick = 0.026 * habit.height;
    let spine = |share: f32| lean * share * share + Vec3::Y * (share * habit.height * 0.86);
    let mut trunk: Vec<(Vec3, f32)> =
        vec![(spine(0.0) - Vec3::Y * 0.05, thick * 1.9), (spine(0.02), thick * 1.35)];
    trunk.extend((1..=9).map(|i| i as f32 / 9.0).map(|share| (spine(share), thick * (1.06 - 0.95 * share))));
    let bark = model.paint(palette.bark, Vec3::ONE);
    bark.tube(&trunk, 10);

    for clump in clump_centres(rng, habit.clump_count) {
        let middle = centre + clump * radii * 0.80 + lean * 0.6;
        // A bough leaves the trunk below its clump and bends upwards.
        let foot_height =
            (0.62 * middle.y - 0.25 * middle.with_y(0.0).length()).clamp(0.8 * low, 0.80 * habit.height);
        let share = foot_height / (habit.height * 0.86);
        let foot = spine(share);
        let bend = foot.lerp(middle, 0.5) - Vec3::Y * 0.12 * foot.distance(middle);
        let root = thick * (1.06 - 0.95 * share) * 0.42;
        let bough: Vec<(Vec3, f32)> = (0..=5)
            .map(|i| i as f32 / 5.0)
            .map(|s| {
                let point = foot.lerp(bend, s).lerp(bend.lerp(middle, s), s);
                (point, root * (1.0 - 0.8 * s))
            })
            .collect();
        model.paint(palette.bark, Vec3::splat(0.85)).tube(&bough, 5);
        for _ in 0..4 {
            let twig = middle + rng.direction() * radii * 0.26;
            model.paint(palette.bark, Vec3::splat(0.8)).tube(&[(middle, 0.014), (twig, 0.004)], 3);
        }
        let size = 0.34 * habit.radius * rng.between(0.8, 1.15);
        for _ in 0..habit.cards_per_clump {
            let out = rng.direction();
            let at = middle + out * Vec3::new(size, 0.72 * size, size) * rng.unit().cbrt();
            let from_centre = (at - centre) / radii;
            // Deep inside and underneath it is dark.
            let depth = from_centre.length().min(1.1);
            let sunk = 0.40 + 0.60 * smoothstep(0.25, 1.0, depth);
            let under = 0.72 + 0.28 * smoothstep(-0.9, 0.5, from_centre.y + 0.5 * out.y);
            let normal = (from_centre.normalize_or(Vec3::Y) * 0.65 + out * 0.55 + Vec3::Y * 0.25).normalize();
            let cluster = if rng.happens(habit.turning) { Cluster::Turning } else { Cluster::Green };
            let tint = Vec3::splat(sunk * under * rng.between(0.85, 1.15));
            let half_size = rng.between(0.30, 0.44);
            card(model.paint(palette.leaves, tint), rng, cluster, at, normal, half_size);
        }
    }
    model
}

/// Unit-ball positions that keep their distance (best of several candidates).
fn clump_centres(rng: &mut Rng, count: u32) -> Vec<Vec3> {
    let mut centres: Vec<Vec3> = Vec::new();
    for _ in 0..count {
        let candidates: Vec<Vec3> =
            (0..12).map(|_| rng.direction() * rng.between(0.35, 1.0).sqrt()).collect();
        let room = |p: &Vec3| centres.iter().map(|c| c.distance_squared(*p)).fold(f32::MAX, f32::min);
        let best = candidates.into_iter().max_by(|a, b| room(a).total_cmp(&room(b)));
        centres.extend(best);
    }
    centres
}

/// One leaf card, seen from both sides with the same normal.
fn card(shape: &mut Shape, rng: &mut Rng, cluster: Cluster, centre: Vec3, normal: Vec3, half_size: f32) {
    let facing = (normal + 0.9 * rng.direction()).normalize_or(Vec3::Y);
    let turn = Quat::from_axis_angle(facing, rng.between(0.0, TAU));
    let right = turn * facing.any_orthonormal_vector() * half_size;
    let up = facing.cross(right);
    let corner = cluster.corner();
    let mut vertex = |x: f32, y: f32| {
        let position = centre + right * x + up * y;
        let uv = corner + Vec2::new(0.25 + 0.25 * x, 0.25 - 0.25 * y);
        shape.vertex(Vertex { position, normal, uv })
    };
    let [a, b, c, d] = [vertex(-1.0, -1.0), vertex(1.0, -1.0), vertex(1.0, 1.0), vertex(-1.0, 1.0)];
    shape.indices.extend([[a, b, c], [a, c, d], [a, c, b], [a, d, c]]);
}

/// A row of flowers or a hedge: cards that fill a box, with normals away from its long axis.
pub(crate) fn planting(
    model: &mut Model,
    palette: &Palette,
    rng: &mut Rng,
    cluster: Cluster,
    (low, high): (Vec3, Vec3),
    card_count: u32,
) {
    let (centre, extent) = (0.5 * (low + high), 0.5 * (high - low));
    for _ in 0..card_count {
        let inside = Vec3::new(rng.about(0.0, 1.0), rng.about(0.0, 1.0), rng.about(0.0, 1.0));
        let at = centre + inside * extent;
        let normal = (inside * Vec3::new(0.3, 1.0, 1.0) + Vec3::Y * 0.6).normalize_or(Vec3::Y);
        let tint = Vec3::splat((0.55 + 0.45 * smoothstep(-1.0, 0.6, inside.y)) * rng.between(0.85, 1.15));
        let size = 0.85 * extent.y.min(extent.z) * rng.between(0.8, 1.2);
        card(model.paint(palette.leaves, tint), rng, cluster, at, normal, size);
    }
}
