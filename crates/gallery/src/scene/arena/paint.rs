//! What is painted for the arena: runes, energy, flames and banners. Colour is linear, alpha is opacity.

use std::f32::consts::{PI, TAU};

use glam::{IVec2, Vec2, Vec3};
use sheer_image::Image;

use crate::paint::{Fractal, Noise, Spot, paint_colour, smoothstep, texel_middles};

/// Columns and rows of [`flames`].
pub(super) const FLAME_ATLAS: [u32; 2] = [4, 4];
/// Number of tiles of the atlas that show flames: the first twelve. The constants below are the others.
pub(super) const FLAME_TILES: u32 = 12;
pub(super) const GLOW: u32 = 12;
pub(super) const SPARK: u32 = 13;
pub(super) const DROP: u32 = 14;

/// 1 within `half` of the line, 0 half as far again away.
fn stroke(distance: f32, half: f32) -> f32 {
    1.0 - smoothstep(half, 1.5 * half, distance.abs())
}

/// Distance to the segment between two points.
fn to_segment(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, along))
}

/// A letter that nobody can read, made of strokes between the points of a 3×3 grid, in the square from -1 to
/// 1.
fn rune(noise: Noise, p: Vec2, letter: i32) -> f32 {
    let point = |index: u32| {
        let pick = noise.lattice(IVec2::new(letter, index as i32), IVec2::splat(64), 3) * 8.999;
        Vec2::new((pick as u32 % 3) as f32 - 1.0, (pick as u32 / 3) as f32 - 1.0) * 0.62
    };
    let stem = to_segment(p, Vec2::new(0.0, -0.7), Vec2::new(0.0, 0.7));
    let nearest = (0..3).map(|index| to_segment(p, point(index), point(index + 1))).fold(stem, f32::min);
    stroke(nearest, 0.12)
}

/// A magic circle: rings, a band of runes and a star, on a faint disc.
pub(super) fn circle(seed: u32) -> Image<[u8; 4]> {
    let noise = Noise { seed: seed.wrapping_add(700) };
    // A star of seven points, each joined to the third after it.
    let corner = |index: u32| Vec2::from_angle(TAU * index as f32 / 7.0) * 0.70;
    let star: Vec<[Vec2; 2]> = (0..7).map(|index| [corner(index), corner(index + 3)]).collect();
    paint_colour(512, |Spot { uv, .. }| {
        let p = uv * 2.0 - 1.0;
        let radius = p.length();
        let angle = p.y.atan2(p.x) / TAU + 0.5;
        let rings =
            [0.96, 0.91, 0.70, 0.35].map(|at| stroke(radius - at, if at > 0.95 { 0.018 } else { 0.008 }));
        let letters = 24.0;
        let letter = (angle * letters).floor();
        let within =
            Vec2::new((angle * letters - letter) * 2.0 - 1.0, (radius - 0.805) / 0.09) * Vec2::new(1.25, 1.0);
        let runes = if within.y.abs() < 1.0 { rune(noise, within, letter as i32) } else { 0.0 };
        let star = star.iter().map(|&[from, to]| to_segment(p, from, to)).fold(f32::MAX, f32::min);
        let lines = rings.into_iter().fold(runes.max(stroke(star, 0.010)), f32::max);
        let disc = 0.16 * (1.0 - smoothstep(0.93, 0.97, radius)) * (0.4 + 0.6 * radius * radius);
        (Vec3::ONE, (0.95 * lines).max(disc))
    })
}

/// One triangle of a shield, edge bright and middle clear; barycentric weights lie at (1 - u - v, u, v).
pub(super) fn facet() -> Image<[u8; 4]> {
    paint_colour(128, |Spot { uv, .. }| {
        let edge = uv.x.min(uv.y).min(1.0 - uv.x - uv.y).max(0.0);
        let line = 1.0 - smoothstep(0.006, 0.03, edge);
        let glow = (1.0 - edge * 3.2).max(0.0).powi(2);
        (Vec3::splat(0.30 + 0.30 * glow + 0.40 * line), 0.19 + 0.20 * glow + 0.17 * line)
    })
}

/// A barrier: curtains of light with rows of runes; v runs from the top down to the ground, u tiles.
pub(super) fn curtain(seed: u32) -> Image<[u8; 4]> {
    let noise = Noise { seed: seed.wrapping_add(710) };
    let across = texel_middles(512);
    let down: Vec<f32> = across.iter().map(|at| at * 0.5).collect();
    let streaks = noise.fractal(IVec2::new(28, 2), 3).coarse_sheet(&across, &down, 3);
    let wisps = Noise { seed: noise.seed + 1 }.fractal(IVec2::new(5, 4), 4).sheet(512);
    paint_colour(512, |Spot { uv, texel }| {
        let height = 1.0 - uv.y;
        let (streaks, wisps) = (streaks[texel], wisps[texel]);
        let mut lines = stroke(height - 0.02, 0.018).max(stroke(height - 0.975, 0.012));
        for (row, (middle, count)) in [(0.22, 10.0), (0.58, 14.0), (0.86, 18.0)].into_iter().enumerate() {
            let letter = (uv.x * count).floor();
            let within = Vec2::new((uv.x * count - letter) * 2.0 - 1.0, (height - middle) * count * 1.3);
            if within.y.abs() < 1.0 {
                lines = lines.max(0.85 * rune(noise, within, letter as i32 + 20 * row as i32));
            }
            lines = lines.max(0.7 * stroke((height - middle).abs() - 0.95 / count, 0.005));
        }
        let body = (0.36 + 0.22 * streaks + 0.16 * wisps).clamp(0.14, 0.7);
        let value = 0.35 + 0.25 * (streaks + 0.5).clamp(0.0, 1.0);
        (Vec3::splat(value.max(lines)), body.max(0.95 * lines))
    })
}

/// Twelve tongues of flame, a soft glow, a spark and a drop. Flames are white within, yellow around it and
/// red at their rim.
pub(super) fn flames(seed: u32) -> Image<[u8; 4]> {
    let noise = |tile: u32| Noise { seed: seed.wrapping_mul(29).wrapping_add(720 + tile) };
    let [columns, rows] = FLAME_ATLAS;
    let flames: Vec<Flame> = (0..columns * rows).map(|tile| Flame::new(noise(tile))).collect();
    paint_colour(512, |Spot { uv, .. }| {
        let scaled = uv * Vec2::new(FLAME_ATLAS[0] as f32, FLAME_ATLAS[1] as f32);
        let cell = scaled.floor();
        let p = (scaled - cell) * 2.0 - 1.0;
        let tile = (cell.y * FLAME_ATLAS[0] as f32 + cell.x) as u32;
        let radius = p.length();
        let rim = 1.0 - smoothstep(0.75, 0.96, radius);
        match tile {
            GLOW => (Vec3::ONE, rim * (1.0 - radius).max(0.0).powi(2)),
            SPARK => (Vec3::ONE, rim * (1.0 - smoothstep(0.12, 0.6, radius)).powi(2)),
            DROP => (Vec3::splat(0.75 + 0.25 * (1.0 - radius)), 0.85 * (1.0 - smoothstep(0.55, 0.8, radius))),
            _ => flames[tile as usize].at(p, rim),
        }
    })
}

/// The noise that a tongue of flame is made of.
struct Flame {
    warp: [Fractal; 2],
    body: Fractal,
}

impl Flame {
    fn new(noise: Noise) -> Self {
        let warp = [noise, Noise { seed: noise.seed + 99 }].map(|noise| noise.fractal(IVec2::splat(3), 3));
        Self { warp, body: Noise { seed: noise.seed + 7 }.fractal(IVec2::splat(4), 4) }
    }

    fn at(&self, p: Vec2, rim: f32) -> (Vec3, f32) {
        let uv = 0.5 * p + 0.5;
        let warp = Vec2::new(self.warp[0].at(uv), self.warp[1].at(uv));
        let body = self.body.at(uv + 0.16 * warp);
        let heat = (1.15 - 1.25 * (p + 0.35 * warp).length() + 0.75 * body).clamp(0.0, 1.0) * rim;
        let colour = Vec3::new(1.0, (0.9 * heat.powf(1.1)).max(0.05), 0.6 * heat.powi(3) + 0.004);
        (colour, smoothstep(0.04, 0.55, heat) * 0.92)
    }
}

/// A trail of a blade: streaks along v that thin out towards the inside.
pub(super) fn trail(seed: u32) -> Image<[u8; 4]> {
    let streaks = Noise { seed: seed.wrapping_add(740) }.fractal(IVec2::new(14, 1), 2).sheet(128);
    paint_colour(128, |Spot { uv, texel }| {
        let streaks = 0.75 + 0.5 * streaks[texel];
        let fade = (PI * uv.y).sin();
        (Vec3::splat(0.6 + 0.4 * uv.x), (0.85 * uv.x * uv.x * streaks * fade).clamp(0.0, 0.9))
    })
}

/// A banner with a sun in a ring, its tail cut into points and its hem torn.
pub(super) fn banner(seed: u32) -> Image<[u8; 4]> {
    let noise = Noise { seed: seed.wrapping_add(750) };
    let weave = noise.fractal(IVec2::splat(40), 2).sheet(256);
    let tears = noise.fractal(IVec2::new(9, 3), 3).sheet(256);
    let holes = Noise { seed: noise.seed + 3 }.fractal(IVec2::new(6, 12), 2).sheet(256);
    paint_colour(256, |Spot { uv, texel }| {
        let weave = 1.0 + 0.12 * weave[texel];
        let folds = 0.88 + 0.12 * (uv.x * 21.0 + 2.0 * uv.y).sin();
        // Cloth is 2.6 times as long as wide.
        let p = (uv - Vec2::new(0.5, 0.36)) * Vec2::new(1.0, 2.6);
        let (radius, angle) = (p.length(), p.y.atan2(p.x));
        let ray = 0.17 + 0.05 * (angle * 8.0).cos();
        let border = (0.5 - (uv.x - 0.5).abs()).min(uv.y * 2.6);
        let gold = stroke(radius - 0.30, 0.022)
            .max(1.0 - smoothstep(0.0, 0.02, radius - ray))
            .max(stroke(border - 0.065, 0.016));
        let tear = tears[texel];
        let tail = 0.86 + 0.12 * ((uv.x - 0.5).abs() * 4.0 - 1.0).abs() + 0.05 * tear;
        let hole = holes[texel] > 0.62 + 0.25 * (1.0 - uv.y);
        let there = uv.y < tail && border > 0.012 + 0.012 * tear && !hole;
        let colour = Vec3::splat(0.5).lerp(Vec3::new(1.0, 0.80, 0.42), gold) * weave * folds;
        (colour, f32::from(there))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_star_is_there() {
        let circle = circle(1);
        for index in 0..7 {
            let corner = |index: u32| Vec2::from_angle(TAU * index as f32 / 7.0) * 0.70;
            let middle = (0.5 * (corner(index) + corner(index + 3)) + 1.0) * 256.0;
            assert!(circle[(middle.x as u32, middle.y as u32)][3] > 200, "line {index}");
        }
    }
}
