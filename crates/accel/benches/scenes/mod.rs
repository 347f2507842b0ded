//! Three seeded scenes and the rays through them, for every program that measures the tracer.
//!
//! * `smoke`: 50k textured camera-facing quads in a cloud, many layers a ray.
//! * `hair`: a ball under one million thin triangles.
//! * `mixed`: terrain and balls, 70 % of 500k triangles, among textured cards.

use std::f32::consts::TAU;

use glam::{Vec3, vec3};
use sheer_accel::Ray;

/// Triangles from this on are halves of textured cards, those before are opaque (or hair).
pub(crate) struct Geometry {
    pub(crate) name: &'static str,
    pub(crate) triangles: Vec<[Vec3; 3]>,
    first_card: u32,
    /// Opacity of what is not a card.
    solid_alpha: f32,
}

/// PCG output permutation over a counter: a small generator whose sequence is ours.
pub(crate) struct Random(pub(crate) u32);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        unit(pcg(self.0))
    }

    pub(crate) fn in_ball(&mut self) -> Vec3 {
        loop {
            let p = vec3(self.next(), self.next(), self.next()) * 2.0 - 1.0;
            if p.length_squared() <= 1.0 {
                return p;
            }
        }
    }
}

pub(crate) fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

pub(crate) fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// Two triangles whose texture runs from corner 0 to corner 2.
pub(crate) fn push_quad(triangles: &mut Vec<[Vec3; 3]>, centre: Vec3, x: Vec3, y: Vec3) {
    let corners = [centre - x - y, centre + x - y, centre + x + y, centre - x + y];
    triangles.push([corners[0], corners[1], corners[2]]);
    triangles.push([corners[0], corners[2], corners[3]]);
}

fn smoke() -> Geometry {
    let mut random = Random(1);
    let mut triangles = Vec::new();
    for _ in 0..50_000 {
        let centre = random.in_ball() * vec3(2.4, 1.2, 1.2);
        let (sin, cos) = (random.next() * TAU).sin_cos();
        let size = 0.02 + 0.03 * random.next();
        push_quad(&mut triangles, centre, vec3(cos, sin, 0.0) * size, vec3(-sin, cos, 0.0) * size);
    }
    Geometry { name: "smoke", triangles, first_card: 0, solid_alpha: 1.0 }
}

fn hair() -> Geometry {
    let mut random = Random(2);
    let mut triangles = Vec::new();
    for _ in 0..31_250 {
        let mut direction = random.in_ball().normalize();
        let mut point = direction * 1.2;
        let side = direction.cross(random.in_ball()).normalize() * 0.0008;
        for segment in 0..16 {
            let next = point + direction * 0.035;
            let (near, far) =
                (side * (1.0 - segment as f32 / 17.0), side * (1.0 - (segment + 1) as f32 / 17.0));
            triangles.push([point - near, point + near, next + far]);
            triangles.push([point - near, next + far, next - far]);
            point = next;
            direction = (direction + random.in_ball() * 0.2 - vec3(0.0, 0.1, 0.0)).normalize();
        }
    }
    Geometry { name: "hair", triangles, first_card: u32::MAX, solid_alpha: 0.4 }
}

pub(crate) fn push_ball(triangles: &mut Vec<[Vec3; 3]>, centre: Vec3, radius: f32, rings: u32) {
    let point = |ring: u32, step: u32| {
        let (polar, turn) = (0.5 * TAU * ring as f32 / rings as f32, TAU * step as f32 / (2 * rings) as f32);
        centre + vec3(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin()) * radius
    };
    for ring in 0..rings {
        for step in 0..2 * rings {
            let (a, b) = (point(ring, step), point(ring, step + 1));
            let (c, d) = (point(ring + 1, step + 1), point(ring + 1, step));
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
}

fn mixed() -> Geometry {
    let mut random = Random(3);
    let mut triangles = Vec::new();
    let cells = 250;
    let height = |i: u32, j: u32| {
        let (x, z) = (i as f32 / cells as f32 * 8.0 - 4.0, j as f32 / cells as f32 * 8.0 - 4.0);
        vec3(x, -1.0 + 0.2 * (3.0 * x).sin() * (2.0 * z).cos() + 0.01 * unit(pcg(i * 4096 + j)), z)
    };
    for i in 0..cells {
        for j in 0..cells {
            let (a, b, c, d) = (height(i, j), height(i, j + 1), height(i + 1, j + 1), height(i + 1, j));
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
    while triangles.len() < 350_000 {
        let centre = random.in_ball() * vec3(3.0, 0.8, 3.0);
        push_ball(&mut triangles, centre, 0.05 + 0.15 * random.next(), 24);
    }
    let first_card = triangles.len() as u32;
    while triangles.len() < 500_000 {
        let centre = random.in_ball() * vec3(3.0, 1.0, 3.0);
        let x = random.in_ball().normalize();
        let y = x.cross(random.in_ball()).normalize();
        push_quad(&mut triangles, centre, x * 0.03, y * 0.03);
    }
    Geometry { name: "mixed", triangles, first_card, solid_alpha: 1.0 }
}

/// Alpha of a round puff, 32 x 32.
pub(crate) fn texture() -> Vec<f32> {
    (0..32 * 32)
        .map(|texel| {
            let (x, y) = ((texel % 32) as f32 / 15.5 - 1.0, (texel / 32) as f32 / 15.5 - 1.0);
            (1.0 - x * x - y * y).max(0.0) * (0.3 + 0.4 * unit(pcg(texel)))
        })
        .collect()
}

impl Geometry {
    pub(crate) fn all() -> [Self; 3] {
        [smoke(), hair(), mixed()]
    }

    /// Opacity where `u` and `v` are the weights of a triangle's second and third vertex.
    #[inline(always)]
    pub(crate) fn alpha(&self, texture: &[f32], triangle: u32, u: f32, v: f32) -> f32 {
        if triangle < self.first_card {
            return self.solid_alpha;
        }
        let (x, y) = if (triangle - self.first_card).is_multiple_of(2) { (u + v, v) } else { (u, u + v) };
        let texel = |x: f32| ((x * 32.0) as usize).min(31);
        texture[texel(y) * 32 + texel(x)]
    }
}

/// The camera is at +4 z and looks along -z, through a picture that is as far away as it is high. `point_px`
/// counts from the picture's upper left corner, `size` is that of the picture in pixels.
pub(crate) fn camera_ray(point_px: [f32; 2], [width, height]: [u32; 2]) -> Ray {
    let x = point_px[0] - width as f32 / 2.0;
    let y = height as f32 / 2.0 - point_px[1];
    let direction = vec3(x, y, -(height as f32)) / height as f32;
    Ray { origin: vec3(0.0, 0.2, 4.0), direction, t_min: 0.0, t_max: f32::INFINITY }
}

/// From the point at `t` on a ray towards a light.
pub(crate) fn shadow_ray(ray: &Ray, t: f32) -> Ray {
    let light = vec3(3.0, 6.0, 3.0);
    let origin = ray.origin + ray.direction * t;
    Ray { origin, direction: light - origin, t_min: 1e-4, t_max: 1.0 }
}
