//! Leaves and blossoms: the atlas of clusters that the cards of plants show.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use sheer_core::colour::linear_from_hex;
use sheer_image::Image;

use crate::{
    paint::{Spot, paint_colour, smoothstep},
    rng::Rng,
};

/// Which quarter of the leaf atlas a card shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cluster {
    /// Leaves in summer green.
    Green,
    /// Leaves that begin to turn.
    Turning,
    /// Red blossoms among dark leaves, for window boxes.
    Blossom,
    /// Small leaves, so dense that little shows through.
    Hedge,
}

impl Cluster {
    /// Its upper left corner in texture coordinates; it is half as wide and high as the atlas.
    pub(crate) fn corner(self) -> Vec2 {
        match self {
            Self::Green => Vec2::new(0.0, 0.0),
            Self::Turning => Vec2::new(0.5, 0.0),
            Self::Blossom => Vec2::new(0.0, 0.5),
            Self::Hedge => Vec2::new(0.5, 0.5),
        }
    }
}

/// One leaf of a cluster, in the unit square of its quarter.
struct Leaf {
    base: Vec2,
    along: Vec2,
    length: f32,
    width: f32,
    colour: Vec3,
    /// A blossom is round and has no veins.
    round: bool,
}

/// Paints the 2×2 atlas of [`Cluster`]s; outside the leaves the colour goes on, so that no dark fringe shows.
pub(crate) fn leaf_atlas(seed: u32) -> Image<[u8; 4]> {
    let mut rng = Rng::new(seed, "leaf atlas");
    let clusters = [Cluster::Green, Cluster::Turning, Cluster::Blossom, Cluster::Hedge].map(|cluster| {
        let leaves = sprig(&mut rng, cluster);
        let mean = leaves.iter().map(|leaf| leaf.colour).sum::<Vec3>() / leaves.len() as f32;
        (Blocks::new(leaves), mean)
    });
    paint_colour(512, |Spot { uv, .. }| {
        let quarter = (uv * 2.0).floor().min(Vec2::ONE);
        let (leaves, mean) = &clusters[(quarter.y * 2.0 + quarter.x) as usize];
        let p = uv * 2.0 - quarter;
        leaves.near(p).find_map(|leaf| leaf.at(p)).map_or((*mean, 0.0), |colour| (colour, 1.0))
    })
}

/// The leaves of a cluster by where they may lie: nearly all are somewhere else than any point.
struct Blocks {
    leaves: Vec<Leaf>,
    /// Indices of the leaves that may reach into each block of the unit square, the uppermost first; row by
    /// row.
    reaching: Vec<Vec<usize>>,
}

impl Blocks {
    /// Blocks along an edge.
    const COUNT: usize = 16;

    fn new(leaves: Vec<Leaf>) -> Self {
        let reaching = (0..Self::COUNT * Self::COUNT).map(|block| {
            let low = Vec2::new((block % Self::COUNT) as f32, (block / Self::COUNT) as f32);
            let [low, high] = [low, low + 1.0].map(|corner| corner / Self::COUNT as f32);
            let reaches = |leaf: &Leaf| {
                let [from, to] = leaf.bounds();
                from.cmple(high).all() && to.cmpge(low).all()
            };
            (0..leaves.len()).rev().filter(|&index| reaches(&leaves[index])).collect()
        });
        let reaching = reaching.collect();
        Self { leaves, reaching }
    }

    /// The leaves that may cover a point of the unit square, the uppermost first.
    fn near(&self, p: Vec2) -> impl Iterator<Item = &Leaf> {
        let [column, row] = (p * Self::COUNT as f32).to_array().map(|at| at as usize);
        self.reaching[row * Self::COUNT + column].iter().map(|&index| &self.leaves[index])
    }
}

fn sprig(rng: &mut Rng, cluster: Cluster) -> Vec<Leaf> {
    let greens = [0x5f7a2c, 0x4c6b25, 0x6f8a35, 0x56702a, 0x3f5e22].map(linear_from_hex);
    let golds = [0xa08a2e, 0x8a8530, 0xb59432, 0x6f7a2c, 0x9a7428].map(linear_from_hex);
    let deep = [0x3c5a2a, 0x476a30, 0x34502a, 0x55753a].map(linear_from_hex);
    let petals = [0xc8283c, 0xd84a58, 0xb01c34, 0xe06a72].map(linear_from_hex);
    let (count, length) = match cluster {
        Cluster::Green | Cluster::Turning => (26, 0.25),
        Cluster::Blossom => (60, 0.13),
        Cluster::Hedge => (90, 0.13),
    };
    (0..count)
        .map(|index| {
            let round = cluster == Cluster::Blossom && index > 24;
            let tones: &[Vec3] = match cluster {
                _ if round => &petals,
                Cluster::Green => &greens,
                Cluster::Turning => {
                    if rng.happens(0.55) {
                        &golds
                    } else {
                        &greens
                    }
                }
                Cluster::Blossom | Cluster::Hedge => &deep,
            };
            let turn = rng.between(0.0, TAU);
            let reach = rng.unit().sqrt() * (0.44 - 0.8 * length);
            let base = Vec2::splat(0.5) + Vec2::from_angle(turn) * reach;
            let length = length * rng.between(0.75, 1.15);
            Leaf {
                base,
                along: Vec2::from_angle(turn + rng.about(0.0, 0.9)),
                length: if round { 0.6 * length } else { length },
                width: length * if round { 0.55 } else { rng.between(0.42, 0.56) },
                colour: *rng.pick(tones) * rng.between(0.8, 1.2),
                round,
            }
        })
        .collect()
}

impl Leaf {
    /// Corners of a square that it lies in, with a little more around it than rounding may take.
    fn bounds(&self) -> [Vec2; 2] {
        let (along, across) = (self.along * self.length, self.along.perp() * (0.5 * self.width));
        let reach = 0.5 * along.abs() + across.abs() + 1e-4;
        let middle = self.base + 0.5 * along;
        [middle - reach, middle + reach]
    }

    /// Its colour at a point of the quarter, if it covers the point.
    fn at(&self, p: Vec2) -> Option<Vec3> {
        let offset = p - self.base;
        let (s, t) =
            (offset.dot(self.along) / self.length, offset.dot(self.along.perp()) / (0.5 * self.width));
        if !(0.0..1.0).contains(&s) || t.abs() > 1.0 {
            return None;
        }
        if self.round {
            let radius_squared = (2.0 * s - 1.0).powi(2) + t * t;
            return (radius_squared < 1.0).then(|| self.colour * (1.15 - 0.4 * radius_squared));
        }
        // Widest at a third of its length, pointed at the tip.
        let half_width = (PI * s.powf(0.72)).sin().max(0.0) * (1.0 - 0.25 * s);
        if t.abs() > half_width {
            return None;
        }
        let midrib = 1.0 - smoothstep(0.03, 0.10, t.abs());
        let side_veins = (((s - 0.35 * t.abs()) * 9.0).fract() - 0.5).abs();
        let shade = 0.86 + 0.30 * midrib + 0.12 * smoothstep(0.40, 0.5, side_veins) + 0.10 * t.signum();
        Some(self.colour * shade)
    }
}
