//! A girl who sits on the ground, with hair and a scarf in the wind.
//!
//! She is carved like a doll and looks along +Z in her own space.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Vec2, Vec3, Vec4};

use crate::{
    kit::{
        body::{Body, Form},
        hair::{self, Strand},
        wind::Sway,
    },
    paint::smoothstep,
    rng::Rng,
    shape::{Model, Shape, Vertex},
};

/// Segments of a hair: 165,000 triangles that move at the default count, which every frame pays for. Fewer
/// show corners where locks curl.
pub(crate) const SEGMENTS: usize = 6;
/// Width of a hair at its root with 15,000 of them, metres: half a pixel at the default size.
const WIDTH: f32 = 0.0017;
const SCALP: Form =
    Form::Ellipsoid { centre: Vec3::new(0.0, 0.862, -0.010), radii: Vec3::new(0.107, 0.117, 0.119) };
const SKIRT: Vec3 = Vec3::new(0.035, 0.075, 0.13);
const AUBURN: Vec3 = Vec3::new(0.36, 0.145, 0.060);

/// Materials of the figure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wardrobe {
    pub(crate) skin: u32,
    pub(crate) linen: u32,
}

fn limb(from: Vec3, to: Vec3, radius_from: f32, radius_to: f32) -> Form {
    Form::Limb { from, to, radius_from, radius_to }
}

fn ball(centre: Vec3, radii: Vec3) -> Form {
    Form::Ellipsoid { centre, radii }
}

/// What hair and scarf must not enter.
fn solid() -> Body {
    let v = Vec3::new;
    Body {
        forms: vec![
            SCALP,
            ball(v(0.0, 0.845, 0.015), v(0.100, 0.118, 0.112)),
            limb(v(0.0, 0.34, -0.01), v(0.0, 0.58, -0.02), 0.120, 0.118),
            ball(v(0.0, 0.615, -0.02), v(0.172, 0.060, 0.085)),
            limb(v(0.0, 0.62, -0.01), v(0.0, 0.76, 0.0), 0.046, 0.044),
        ],
        blend: 0.05,
    }
}

/// All of her that is opaque.
pub(crate) fn figure(wardrobe: Wardrobe) -> Model {
    let v = Vec3::new;
    let mut model = Model::default();
    let skin = Vec3::new(0.72, 0.44, 0.31);
    let blouse = Vec3::new(0.80, 0.74, 0.62);
    let shape = model.paint(wardrobe.linen, blouse);
    for form in [
        limb(v(0.0, 0.36, -0.01), v(0.0, 0.57, -0.02), 0.112, 0.116),
        ball(v(0.0, 0.610, -0.02), v(0.165, 0.055, 0.080)),
    ] {
        form.mesh(shape, 0.0);
    }
    for side in [-1.0, 1.0] {
        limb(v(side * 0.150, 0.605, -0.01), v(side * 0.200, 0.44, 0.09), 0.050, 0.044).mesh(shape, 0.0);
        limb(v(side * 0.200, 0.44, 0.09), v(side * 0.110, 0.39, 0.27), 0.044, 0.034).mesh(shape, 0.0);
    }
    let shape = model.paint(wardrobe.skin, skin);
    for side in [-1.0, 1.0] {
        limb(v(side * 0.110, 0.39, 0.27), v(side * 0.020, 0.385, 0.36), 0.028, 0.024).mesh(shape, 0.0);
    }
    limb(v(0.0, 0.62, -0.01), v(0.0, 0.76, 0.0), 0.043, 0.042).mesh(shape, 0.0);
    ball(v(0.0, 0.845, 0.015), v(0.098, 0.115, 0.110)).mesh(shape, 0.0);
    ball(v(0.0, 0.785, 0.060), v(0.052, 0.042, 0.052)).mesh(shape, 0.0);
    ball(v(0.0, 0.832, 0.124), v(0.0125, 0.016, 0.017)).mesh(shape, 0.0);
    model.tint(wardrobe.skin, |p, _| {
        let cheek = |side: f32| 1.0 - smoothstep(0.010, 0.036, p.distance(v(side * 0.055, 0.812, 0.10)));
        skin.lerp(Vec3::new(0.78, 0.26, 0.20), 0.55 * (cheek(-1.0) + cheek(1.0)).min(1.0))
    });
    let dark = model.paint(wardrobe.linen, Vec3::new(0.05, 0.02, 0.015));
    for side in [-1.0, 1.0] {
        // Her eyes are closed: a line of lashes on each side.
        let lash =
            |s: f32| v(side * (0.022 + 0.034 * s), 0.853 - 0.011 * (PI * s).sin(), 0.121 - 0.020 * s * s);
        let lashes: Vec<(Vec3, f32)> = (0..=8).map(|i| (lash(i as f32 / 8.0), 0.0024)).collect();
        dark.tube(&lashes, 6);
    }
    let lip = model.paint(wardrobe.skin, Vec3::new(0.55, 0.13, 0.11));
    ball(v(0.0, 0.796, 0.111), v(0.016, 0.006, 0.007)).mesh(lip, 0.0);
    SCALP.mesh(model.paint(wardrobe.linen, AUBURN * 0.35), 0.002);
    dress(model.paint(wardrobe.linen, SKIRT));
    model
}

/// A wide skirt over drawn-up knees, in folds.
fn dress(shape: &mut Shape) {
    let (rings, sides) = (22, 120);
    let point = |ring: u32, side: u32| {
        let down = ring as f32 / rings as f32;
        let turn = -TAU * side as f32 / sides as f32;
        let direction = Vec2::from_angle(turn);
        let folds = 1.0 + 0.05 * down * (turn * 17.0 + 2.0 * (turn * 3.0).sin()).sin();
        let radius = (0.112 + 0.36 * down.powf(1.25)) * folds;
        let knees = (-((turn + 0.75 * TAU) / 0.75).powi(2)).exp() * (PI * down.powf(0.8)).sin();
        let height = 0.40 * (1.0 - down.powf(0.75)) + 0.18 * knees - 0.01;
        Vec3::new(direction.x * radius, height, direction.y * (radius + 0.10 * knees) + 0.08 * down)
    };
    let grid: Vec<Vec<Vec3>> =
        (0..=rings).map(|ring| (0..=sides).map(|side| point(ring, side % sides)).collect()).collect();
    sheet(shape, &grid, Lie::Surface, |_, _| SKIRT.extend(1.0));
}

/// What a sheet has for normals.
#[derive(Clone, Copy)]
enum Lie {
    /// Those of its surface.
    Surface,
    /// The direction of its rows, for cloth that is lit as the threads it is woven of.
    Threads,
}

/// Adds a grid of points as a smooth surface; rows run downwards, columns counter-clockwise seen from outside
/// or from left to right.
fn sheet(shape: &mut Shape, grid: &[Vec<Vec3>], lie: Lie, colour: impl Fn(f32, f32) -> Vec4) {
    let (rows, columns) = (grid.len(), grid[0].len());
    let first = shape.positions.len() as u32;
    let closed = grid[0][0].distance(grid[0][columns - 1]) < 1e-6;
    for row in 0..rows {
        for column in 0..columns {
            let at = |row: usize, column: usize| grid[row][column];
            // A closed sheet goes on behind its seam.
            let (left, right) = if closed {
                (
                    if column == 0 { columns - 2 } else { column - 1 },
                    if column + 1 == columns { 1 } else { column + 1 },
                )
            } else {
                (column.saturating_sub(1), (column + 1).min(columns - 1))
            };
            let along = at(row, right) - at(row, left);
            let down = at((row + 1).min(rows - 1), column) - at(row.saturating_sub(1), column);
            let (u, v) = (column as f32 / (columns - 1) as f32, row as f32 / (rows - 1) as f32);
            shape.brush(colour(u, v));
            let normal = match lie {
                Lie::Surface => down.cross(along),
                Lie::Threads => along,
            };
            let normal = normal.normalize_or(Vec3::Y);
            shape.vertex(Vertex { position: at(row, column), normal, uv: Vec2::new(u, v) });
        }
    }
    for row in 0..rows as u32 - 1 {
        for column in 0..columns as u32 - 1 {
            let at = first + row * columns as u32 + column;
            let below = at + columns as u32;
            shape.indices.extend([[at, below, below + 1], [at, below + 1, at + 1]]);
        }
    }
}

/// The wind as she feels it: direction and strength, 1 a fresh breeze.
pub(crate) type Wind = Vec3;

/// Everything of a hair that is left to chance, so that it can be built in every pose.
#[derive(Clone, Debug)]
pub(crate) struct Hair {
    rest: [Vec3; SEGMENTS + 1],
    side: Vec3,
    twist_rad: f32,
    width: f32,
    colour: Vec3,
    lift: Vec3,
    phase_rad: f32,
}

/// Where a hair can be rooted: the top, the back and the sides of the head, with a hairline over the
/// forehead.
fn on_scalp(out: Vec3) -> bool {
    out.y > -0.62 && out.z < 0.34 + 0.62 * out.y && (out.z < 0.10 || out.y > 0.30)
}

/// A head of hair in her own space.
pub(crate) fn hairs(count: u32, alpha_seed: u32, wind: Wind) -> Vec<Hair> {
    let mut rng = Rng::new(alpha_seed, "girl's hair");
    let solid = solid();
    let scalp = Body { forms: vec![SCALP], blend: 0.01 };
    let width = WIDTH * (15_000.0 / count.max(1) as f32).powf(0.6).clamp(0.5, 10.0);
    (0..count)
        .map(|_| {
            let (root, normal) = loop {
                let (root, normal) = scalp.surface_point(&mut rng);
                if on_scalp(normal) {
                    break (root, normal);
                }
            };
            let mut hair = Hair::grow(&mut rng, &solid, (root, normal), alpha_seed, wind);
            hair.width = width * rng.between(0.7, 1.3);
            hair
        })
        .collect()
}

impl Hair {
    /// Lets a hair stream from its root with the wind, its lock together.
    fn grow(rng: &mut Rng, solid: &Body, (root, normal): (Vec3, Vec3), seed: u32, wind: Wind) -> Self {
        let tuft = hair::tuft(root, 0.034, seed);
        let [rise, drift, curl, long] = tuft.luck;
        let stray = rng.happens(0.05);
        let loose = rng.gaussian() * if stray { 0.16 } else { 0.035 };
        let length = (0.62 + 0.36 * long) * rng.between(0.78, 1.05);
        let step = length / SEGMENTS as f32;
        let downwind = wind.normalize();
        let beside = downwind.cross(Vec3::Y).normalize();
        // Locks rise, sink and drift apart; those from the nape hang.
        let heavy = 3.0 * (0.86 - root.y).max(0.0);
        let aim = downwind + Vec3::Y * (0.30 * rise - 0.33 - heavy) + beside * (0.40 * (drift - 0.5)) + loose;
        let mut direction = (normal * 0.22 + (aim - normal * aim.dot(normal)) * 0.8).normalize();
        let inward = tuft.centre - root;
        let mut rest = [root; SEGMENTS + 1];
        for i in 1..=SEGMENTS {
            let way = i as f32 / SEGMENTS as f32;
            let wave = (TAU * (1.1 * way + curl)).cos() * 0.20 * way;
            let mut next = rest[i - 1] + direction * step + inward * (1.1 / SEGMENTS as f32);
            next += (Vec3::Y + beside * (2.0 * drift - 1.0)) * (wave * step);
            let field = solid.field(next);
            if field.distance < 0.010 * way.sqrt() {
                next += field.away * (0.010 * way.sqrt() - field.distance);
            }
            rest[i] = next;
            direction = direction.lerp(aim, 0.42).normalize();
        }
        Self {
            rest,
            side: rng.direction(),
            twist_rad: rng.between(0.8, 2.2),
            width: WIDTH,
            colour: AUBURN * rng.between(0.75, 1.25) + Vec3::new(0.10, 0.05, 0.015) * rng.unit(),
            lift: Vec3::Y * 0.8 + beside * (1.4 * drift - 0.7),
            phase_rad: TAU * 0.35 * curl + rng.about(0.0, 0.35),
        }
    }

    /// Adds the hair as it flies while the wind has swung this far.
    pub(crate) fn build(&self, shape: &mut Shape, alpha: f32, sway: Sway) {
        let mut points = self.rest;
        for (i, point) in points.iter_mut().enumerate() {
            let way = i as f32 / SEGMENTS as f32;
            // Waves run outwards and grow.
            let billow = 0.085 * way.powf(1.4) * sway.billow(self.phase_rad + 3.0 * way);
            let flutter = 0.022 * way * sway.flutter(2.0 * self.phase_rad + 6.5 * way);
            *point += self.lift * (billow + flutter);
        }
        let Self { side, twist_rad, width, .. } = *self;
        hair::ribbon(shape, &Strand { points: &points, width, side, twist_rad }, |way| {
            let colour = self.colour * (0.55 + 0.6 * way);
            colour.extend(alpha * (1.0 - 0.8 * way * way))
        });
    }
}

/// The scarf: once around the neck, and out with the wind, in her own space.
pub(crate) fn scarf(shape: &mut Shape, alpha: f32, wind: Wind, sway: Sway) {
    let downwind = wind.normalize();
    let beside = downwind.cross(Vec3::Y).normalize();
    let start = Vec3::new(0.0, 0.665, 0.0) + downwind * 0.085;
    let (rows, columns) = (12, 90);
    let point = |row: usize, column: usize| {
        let (out, over) = (column as f32 / columns as f32, row as f32 / rows as f32 - 0.5);
        let reach = 1.55 * out;
        let billow = (0.03 + 0.15 * out) * out.sqrt() * sway.billow(5.2 * out + 0.5);
        let flutter = 0.045 * out * sway.flutter(11.0 * out + 1.0 * over);
        // Standing ripples keep it from ever being flat.
        let ripple = 0.05 * out * (9.0 * out + 1.5 * over).sin();
        let sink = -0.26 * (PI * (0.85 * out)).sin() + 0.12 * out * out;
        let centre = start
            + downwind * reach
            + Vec3::Y * (sink + 0.6 * billow)
            + beside * (ripple + billow + flutter - 0.12 * out);
        // Gathered at the neck, wide at the end; it turns a little on its way.
        let turn = 0.35 + 0.7 * (3.1 * out).sin();
        let across = Vec3::Y * turn.cos() + beside * turn.sin();
        centre - across * over * (0.07 + 0.25 * smoothstep(0.0, 0.35, out)) + downwind * (0.10 * out * over)
    };
    let grid: Vec<Vec<Vec3>> =
        (0..=rows).map(|row| (0..=columns).map(|column| point(row, column)).collect()).collect();
    sheet(shape, &grid, Lie::Threads, |out, over| {
        let hem = smoothstep(0.40, 0.44, (over - 0.5).abs()).max(smoothstep(0.955, 0.965, out));
        let stripe = smoothstep(0.35, 0.65, 0.5 + 0.5 * (out * TAU * 9.0).sin()) * smoothstep(0.5, 0.6, out);
        let coral = Vec3::new(0.86, 0.13, 0.07).lerp(Vec3::new(0.95, 0.62, 0.22), stripe);
        coral.extend((alpha * (1.0 + 0.5 * hem.max(0.5 * stripe))).min(1.0))
    });
    // The turn around the neck is the same cloth, in more layers.
    let wrap: Vec<(Vec3, f32)> = (0..=28)
        .map(|i| {
            let (sin, cos) = (TAU * i as f32 / 28.0).sin_cos();
            let rise = 0.010 * (TAU * i as f32 / 14.0).sin();
            (Vec3::new(0.066 * cos, 0.668 + rise, 0.070 * sin - 0.002), 0.030)
        })
        .collect();
    shape.brush(Vec4::new(0.84, 0.12, 0.065, (1.6 * alpha).min(1.0)));
    shape.tube(&wrap, 12);
}

/// Puts a shape of hers into the world.
pub(crate) fn placed(material: u32, shape: &Shape, world_from_girl: Affine3A) -> Model {
    let mut moved = Shape::default();
    moved.append(shape, world_from_girl);
    Model::from_shape(material, moved)
}
