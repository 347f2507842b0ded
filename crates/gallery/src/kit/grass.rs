//! Grass and flowers: blended cards that bend in the wind.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use sheer_core::colour::linear_from_hex;
use sheer_image::Image;

use crate::{
    kit::wind::Sway,
    paint::{Spot, paint_colour, smoothstep},
    rng::Rng,
    shape::{Shape, Vertex},
};

/// Which quarter of the atlas a card shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sward {
    /// Many blades of different height.
    Blades,
    /// A few long blades that bear ears.
    Ears,
    /// Daisies among blades.
    Daisies,
    /// Poppies among blades.
    Poppies,
}

const SWARDS: [Sward; 4] = [Sward::Blades, Sward::Ears, Sward::Daisies, Sward::Poppies];
/// Texels along an edge of the atlas; half an edge is one card.
const ATLAS_SIZE: u32 = 768;

/// A stalk of a card, in its unit square with y upwards.
struct Stalk {
    foot: f32,
    /// How far the tip lies to the side.
    lean: f32,
    height: f32,
    half_width: f32,
    colour: Vec3,
    head: Head,
}

/// What a stalk ends in.
#[derive(Clone, Copy, PartialEq)]
enum Head {
    Point,
    Ear,
    Daisy,
    Poppy,
}

/// Paints the atlas; where nothing grows the colour goes on, so that no fringe shows.
pub(crate) fn atlas(seed: u32) -> Image<[u8; 4]> {
    let mut rng = Rng::new(seed, "grass atlas");
    let quarters = SWARDS.map(|sward| {
        let stalks = stalks(&mut rng, sward);
        let mean = stalks.iter().map(|stalk| stalk.colour).sum::<Vec3>() / stalks.len() as f32;
        (stalks, mean)
    });
    let texel = 2.0 / ATLAS_SIZE as f32;
    paint_colour(ATLAS_SIZE, |Spot { uv, .. }| {
        let quarter = (uv * 2.0).floor().min(Vec2::ONE);
        let (stalks, mean) = &quarters[(quarter.y * 2.0 + quarter.x) as usize];
        let p = uv * 2.0 - quarter;
        let p = Vec2::new(p.x, 1.0 - p.y);
        let mut sum = (*mean, 0.0);
        for stalk in stalks {
            let (colour, alpha) = stalk.at(p, texel);
            if alpha > 0.0 {
                sum = (
                    if sum.1 > 0.0 { sum.0.lerp(colour, alpha) } else { colour },
                    sum.1 + alpha * (1.0 - sum.1),
                );
            }
        }
        sum
    })
}

fn stalks(rng: &mut Rng, sward: Sward) -> Vec<Stalk> {
    let greens = [0x7c9440, 0x688436, 0x8ea24a, 0x9aa352, 0x5c7a34].map(linear_from_hex);
    let straw = [0xc9b873, 0xb8a862, 0xd6c88a].map(linear_from_hex);
    let (blades, heads, head) = match sward {
        Sward::Blades => (26, 0, Head::Point),
        Sward::Ears => (7, 8, Head::Ear),
        Sward::Daisies => (11, 4, Head::Daisy),
        Sward::Poppies => (9, 3, Head::Poppy),
    };
    (0..blades + heads)
        .map(|index| {
            let bears = index >= blades;
            let tones: &[Vec3] = if bears && head == Head::Ear { &straw } else { &greens };
            let (low, high) = if bears { (0.68, 0.88) } else { (0.35, 0.95) };
            let foot = rng.between(0.22, 0.78);
            let lean = rng.about(0.35 * (foot - 0.5), 0.16).clamp(0.10 - foot, 0.90 - foot);
            Stalk {
                foot,
                lean,
                height: rng.between(low, high),
                half_width: if bears { 0.0055 } else { rng.between(0.010, 0.019) },
                colour: *rng.pick(tones) * rng.between(0.75, 1.15),
                head: if bears { head } else { Head::Point },
            }
        })
        .collect()
}

impl Stalk {
    /// Colour and cover at a point; `texel` softens the edges.
    fn at(&self, p: Vec2, texel: f32) -> (Vec3, f32) {
        let edge = |inside: f32| smoothstep(-1.2 * texel, 1.2 * texel, inside);
        if self.head != Head::Point {
            let found = self.head_at(p - Vec2::new(self.foot + self.lean, self.height), edge);
            if found.1 > 0.0 {
                return found;
            }
        }
        let way = p.y / self.height;
        if way >= 1.0 {
            return (self.colour, 0.0);
        }
        let taper = if self.head == Head::Point { (1.0 - way).powf(0.7) } else { 1.0 };
        let off = (p.x - self.foot - self.lean * way * way).abs();
        let rib = 0.88 + 0.24 * smoothstep(0.0, self.half_width, off);
        // Darker and denser at the foot, thin enough at the tip that light comes through.
        (self.colour * rib * (0.45 + 0.75 * way), edge(self.half_width * taper - off) * (0.95 - 0.30 * way))
    }

    fn head_at(&self, p: Vec2, edge: impl Fn(f32) -> f32) -> (Vec3, f32) {
        let radius = p.length();
        let angle = p.y.atan2(p.x);
        match self.head {
            Head::Point => (self.colour, 0.0),
            Head::Ear => {
                // An awn-fringed spindle along the stalk.
                let along = ((p.y + 0.02) / 0.11).clamp(-1.0, 1.0);
                let half = 0.020 * (1.0 - along * along).sqrt();
                let grains = 0.8 + 0.3 * (along * 26.0).sin() * p.x.signum();
                (self.colour * grains, 0.85 * edge(half - (p.x - 0.25 * self.lean * p.y).abs()))
            }
            Head::Daisy => {
                let heart = edge(0.020 - radius);
                let petal = 0.050 + 0.014 * (angle * 11.0).cos();
                let white = Vec3::splat(0.88 - 2.0 * radius);
                (white.lerp(Vec3::new(0.85, 0.55, 0.06), heart), 0.92 * edge(petal - radius))
            }
            Head::Poppy => {
                let petal = 0.066 + 0.010 * (angle * 4.0 + 0.6).cos() + 0.003 * (angle * 17.0).sin();
                let heart = edge(0.015 - radius);
                let red = Vec3::new(0.80, 0.075, 0.03) * (0.65 + 0.4 * smoothstep(0.0, 0.07, radius));
                // Petals thin as paper let light through.
                (red.lerp(Vec3::splat(0.02), heart), 0.80 * edge(petal - radius))
            }
        }
    }
}

/// A card that stands in the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Card {
    pub(crate) foot: Vec3,
    /// Unit vector along its width.
    pub(crate) across: Vec3,
    pub(crate) height: f32,
    pub(crate) sward: Sward,
    pub(crate) tint: Vec3,
    /// How late each wave of the wind arrives at it.
    pub(crate) phase_rad: f32,
}

/// Bands of a card: two are enough to bend.
const BANDS: u32 = 2;

impl Card {
    /// A card that stands at a point: mostly grass, here and there a flower.
    pub(crate) fn at(foot: Vec3, height: f32, rng: &mut Rng) -> Self {
        let sward = match rng.unit() {
            share if share < 0.66 => Sward::Blades,
            share if share < 0.88 => Sward::Ears,
            share if share < 0.95 => Sward::Daisies,
            _ => Sward::Poppies,
        };
        let across = Vec2::from_angle(rng.between(0.0, PI));
        Self {
            foot,
            across: Vec3::new(across.x, 0.0, across.y),
            height: height * rng.between(0.75, 1.25),
            sward,
            tint: Vec3::new(rng.between(0.85, 1.2), 1.0, rng.between(0.8, 1.1)) * rng.between(0.8, 1.15),
            phase_rad: 1.1 * foot.dot(Vec3::new(1.0, 0.0, 0.35)) + rng.about(0.0, 0.5),
        }
    }

    /// Adds the card as it stands while the wind has swung this far; `wind` is its direction and strength, 1
    /// a fresh breeze.
    pub(crate) fn build(&self, shape: &mut Shape, wind: Vec3, sway: Sway) {
        let push = 0.30 + 0.16 * sway.billow(self.phase_rad) + 0.06 * sway.flutter(2.2 * self.phase_rad);
        let bend = wind * push * self.height;
        let half = self.across * (0.5 * self.height);
        let corner = match self.sward {
            Sward::Blades => Vec2::ZERO,
            Sward::Ears => Vec2::new(0.5, 0.0),
            Sward::Daisies => Vec2::new(0.0, 0.5),
            Sward::Poppies => Vec2::splat(0.5),
        };
        let first = shape.positions.len() as u32;
        shape.brush(self.tint.extend(1.0));
        for band in 0..=BANDS {
            let way = band as f32 / BANDS as f32;
            let middle = self.foot + Vec3::Y * (self.height * way) + bend * (way * way);
            let normal = (Vec3::Y * self.height + bend * (2.0 * way)).normalize();
            for (side, u) in [(-1.0, 0.01), (1.0, 0.49)] {
                let uv = corner + Vec2::new(u, 0.49 - 0.48 * way);
                shape.vertex(Vertex { position: middle + half * side, normal, uv });
            }
        }
        for band in 0..BANDS {
            let at = first + 2 * band;
            shape.indices.extend([[at, at + 1, at + 3], [at, at + 3, at + 2]]);
        }
    }
}

/// A random point of a disc around the origin, denser towards its middle.
pub(crate) fn strewn(rng: &mut Rng, radius: f32) -> Vec2 {
    Vec2::from_angle(rng.between(0.0, TAU)) * (radius * rng.unit().powf(0.72))
}
