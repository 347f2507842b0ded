//! Town houses: walls with real openings, roofs of single tiles.
//!
//! A house stands with its front in the plane z = 0, looking along +Z, from x = -width/2 to width/2, and
//! reaches back to z = -depth.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use sheer_core::colour::linear_from_hex;

use crate::{
    kit::{foliage::planting, leaf::Cluster, palette::Palette},
    paint::smoothstep,
    rng::Rng,
    shape::{Model, Shape, Vertex},
};

/// What a front is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Wall {
    /// Plaster painted in this linear colour.
    Plaster(Vec3),
    /// Red brick with stone trim.
    Brick,
    /// Plaster of this linear colour between beams, above a plain ground floor.
    HalfTimber(Vec3),
}

/// What a roof is covered with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Covering {
    /// Curved tiles in straight columns, each over the side of the next.
    Pantile,
    /// Small flat tiles, each row shifted by half a tile.
    Plain,
}

/// How a house is built.
#[derive(Clone, Copy, Debug)]
pub(crate) struct House {
    pub(crate) width: f32,
    pub(crate) depth: f32,
    pub(crate) storey_count: u32,
    /// Rise of the roof over half its span.
    pub(crate) pitch: f32,
    /// The gable looks to the front.
    pub(crate) gable_front: bool,
    pub(crate) wall: Wall,
    /// Painted frames and trim.
    pub(crate) trim: Vec3,
    /// Painted doors, shutters and shop fronts.
    pub(crate) paint: Vec3,
    pub(crate) covering: Covering,
    pub(crate) roof: Vec3,
    pub(crate) shutters: bool,
    pub(crate) shop: bool,
    pub(crate) dormer_count: u32,
}

const GROUND_FLOOR: f32 = 3.3;
const STOREY: f32 = 2.85;
/// Eaves reach this far over the wall.
const EAVES: f32 = 0.42;
/// Depth of a window: from the face of the wall to the glass, metres.
const REVEAL: f32 = 0.16;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Use {
    Window,
    Shop,
    Door,
    Attic,
}

/// A hole in a wall.
#[derive(Clone, Copy, Debug)]
struct Opening {
    low: Vec2,
    high: Vec2,
    use_: Use,
}

/// A house that is being built.
struct Site<'a> {
    house: House,
    palette: &'a Palette,
    rng: &'a mut Rng,
    model: Model,
}

impl House {
    /// Height of the eaves.
    pub(crate) fn eaves(&self) -> f32 {
        GROUND_FLOOR + STOREY * (self.storey_count - 1) as f32
    }

    fn span(&self) -> f32 {
        if self.gable_front { self.width } else { self.depth }
    }

    /// Height of the ridge.
    pub(crate) fn ridge(&self) -> f32 {
        self.eaves() + 0.5 * self.span() * self.pitch
    }

    /// Builds the house from the ground up: walls, what fills their openings, trim, dirt, roof.
    pub(crate) fn build(self, palette: &Palette, rng: &mut Rng) -> Model {
        let mut site = Site { house: self, palette, rng, model: Model::default() };
        let openings = site.openings();
        site.front_wall(&openings);
        site.other_walls();
        for opening in &openings {
            site.fit(opening);
        }
        site.trim(&openings);
        if self.shop {
            site.awning(&openings);
        }
        let eaves = self.eaves();
        // Dirt splashes up from the street, the eaves and what juts out keep the sky away.
        site.model.shade(|p, n| {
            let street = 0.72 + 0.28 * smoothstep(0.0, 1.1, p.y);
            let sheltered = if n.z > 0.5 && p.z < 0.1 && !self.gable_front {
                1.0 - 0.30 * smoothstep(eaves - 0.9, eaves, p.y)
            } else {
                1.0
            };
            street * sheltered
        });
        site.roof();
        site.model
    }
}

impl Site<'_> {
    fn wall_at(&self, storey: u32) -> (u32, Vec3) {
        match self.house.wall {
            Wall::Plaster(tint) | Wall::HalfTimber(tint) => {
                let tint = if storey == 0 { tint * 0.9 } else { tint };
                (self.palette.plaster, tint)
            }
            Wall::Brick => (self.palette.brick, Vec3::ONE),
        }
    }

    fn openings(&mut self) -> Vec<Opening> {
        let House { width, storey_count, gable_front, shop, .. } = self.house;
        let bay_count = (width / 2.35).floor().max(2.0) as u32;
        let bay = width / bay_count as f32;
        let door_bay = self.rng.below(bay_count);
        let mut openings = Vec::new();
        for storey in 0..storey_count {
            let floor = if storey == 0 { 0.0 } else { GROUND_FLOOR + STOREY * (storey - 1) as f32 };
            for index in 0..bay_count {
                let middle = -0.5 * width + bay * (index as f32 + 0.5);
                let (use_, half, low, high) = match (storey, index == door_bay) {
                    (0, true) => (Use::Door, 0.58, 0.0, 2.65),
                    (0, false) if shop => (Use::Shop, 0.5 * bay - 0.28, 0.62, 2.55),
                    (0, false) => (Use::Window, 0.52, 1.0, 2.55),
                    _ => (Use::Window, 0.50, floor + 0.80, floor + 2.25),
                };
                openings.push(Opening {
                    low: Vec2::new(middle - half, low),
                    high: Vec2::new(middle + half, high),
                    use_,
                });
            }
        }
        if gable_front && self.house.ridge() - self.house.eaves() > 2.6 {
            let low = self.house.eaves() + 0.45;
            openings.push(Opening {
                low: Vec2::new(-0.38, low),
                high: Vec2::new(0.38, low + 1.05),
                use_: Use::Attic,
            });
        }
        openings
    }

    /// The front, cut into a grid along the edges of its openings, so that textures run through.
    fn front_wall(&mut self, openings: &[Opening]) {
        let House { width, gable_front, .. } = self.house;
        let (eaves, ridge) = (self.house.eaves(), self.house.ridge());
        let top = if gable_front { ridge } else { eaves };
        let mut xs = vec![-0.5 * width, 0.5 * width];
        let mut ys = vec![0.0, 0.45, 1.1, GROUND_FLOOR, eaves - 0.9, eaves, top];
        if gable_front {
            xs.push(0.0);
        }
        for opening in openings {
            xs.extend([opening.low.x, opening.high.x]);
            ys.extend([opening.low.y, opening.high.y]);
        }
        let sort = |mut values: Vec<f32>| {
            values.sort_by(f32::total_cmp);
            values.dedup_by(|a, b| (*a - *b).abs() < 1e-3);
            values
        };
        let (xs, ys) = (sort(xs), sort(ys));
        // Above the eaves the gable narrows to the ridge.
        let limit = |y: f32| 0.5 * width * ((ridge - y) / (ridge - eaves)).clamp(0.0, 1.0);
        for rows in ys.windows(2) {
            let storey = if rows[0] < GROUND_FLOOR - 0.01 { 0 } else { 1 };
            let (material, tint) = self.wall_at(storey);
            let shape = self.model.paint(material, tint);
            for columns in xs.windows(2) {
                let middle = Vec2::new(0.5 * (columns[0] + columns[1]), 0.5 * (rows[0] + rows[1]));
                let open = |o: &Opening| middle.cmpgt(o.low).all() && middle.cmplt(o.high).all();
                if openings.iter().any(open) {
                    continue;
                }
                let cut = |x: f32, y: f32| {
                    let reach = if gable_front && y > eaves { limit(y) } else { f32::MAX };
                    Vec3::new(x.clamp(-reach, reach), y, 0.0)
                };
                let corners = [
                    cut(columns[0], rows[0]),
                    cut(columns[1], rows[0]),
                    cut(columns[1], rows[1]),
                    cut(columns[0], rows[1]),
                ];
                let (bottom, upper) = (corners[1].x - corners[0].x, corners[2].x - corners[3].x);
                if bottom < 1e-4 && upper < 1e-4 {
                } else if upper < 1e-4 {
                    shape.triangle([corners[0], corners[1], corners[2]]);
                } else {
                    shape.quad(corners);
                }
            }
        }
        // The jambs of the holes.
        let (material, tint) = self.wall_at(1);
        let shape = self.model.paint(material, tint * 0.8);
        for Opening { low, high, .. } in openings {
            let (size, back) = (*high - *low, -Vec3::Z * REVEAL);
            shape.panel(low.extend(0.0), back, Vec3::Y * size.y);
            shape.panel(high.with_y(low.y).extend(-REVEAL), -back, Vec3::Y * size.y);
            shape.panel(low.extend(0.0), Vec3::X * size.x, back);
            shape.panel(low.with_y(high.y).extend(-REVEAL), Vec3::X * size.x, -back);
        }
    }

    fn other_walls(&mut self) {
        let House { width, depth, gable_front, .. } = self.house;
        let (eaves, ridge) = (self.house.eaves(), self.house.ridge());
        let (material, tint) = self.wall_at(1);
        let shape = self.model.paint(material, tint * 0.94);
        let (right, back) = (0.5 * width, -depth);
        let breaks = [0.0, 1.1, eaves];
        for rows in breaks.windows(2) {
            let up = Vec3::Y * (rows[1] - rows[0]);
            shape.panel(Vec3::new(right, rows[0], 0.0), Vec3::Z * back, up);
            shape.panel(Vec3::new(-right, rows[0], back), -Vec3::Z * back, up);
            shape.panel(Vec3::new(right, rows[0], back), -Vec3::X * width, up);
        }
        if gable_front {
            shape.triangle([
                Vec3::new(right, eaves, back),
                Vec3::new(-right, eaves, back),
                Vec3::new(0.0, ridge, back),
            ]);
        } else {
            let peak = 0.5 * back;
            shape.triangle([
                Vec3::new(right, eaves, 0.0),
                Vec3::new(right, eaves, back),
                Vec3::new(right, ridge, peak),
            ]);
            shape.triangle([
                Vec3::new(-right, eaves, back),
                Vec3::new(-right, eaves, 0.0),
                Vec3::new(-right, ridge, peak),
            ]);
        }
    }

    /// Fills an opening: frame, bars and glass, or a door.
    fn fit(&mut self, opening: &Opening) {
        let Opening { low, high, use_ } = *opening;
        let size = high - low;
        let House { trim, paint, shutters, .. } = self.house;
        let front = -REVEAL + 0.06;
        let bars = if use_ == Use::Shop || use_ == Use::Door { paint } else { trim };
        let wood = self.palette.planks;

        let mut pane_low = low;
        if use_ == Use::Door {
            // A leaf with two sunk fields under a fanlight.
            let leaf_top = low.y + 2.12;
            let shape = self.model.paint(wood, paint);
            shape.block(low.extend(-REVEAL - 0.04), Vec3::new(high.x, leaf_top, -REVEAL));
            for (bottom, top) in [(0.18, 0.86), (1.02, 1.96)] {
                for side in [0.0, 0.5] {
                    let left = low.x + 0.09 + side * (size.x - 0.08);
                    let right = left + 0.5 * size.x - 0.14;
                    shape.block(
                        Vec3::new(left, low.y + bottom, -REVEAL),
                        Vec3::new(right, low.y + top, -REVEAL + 0.022),
                    );
                }
            }
            let knob = self.model.paint(self.palette.metal, Vec3::new(0.75, 0.55, 0.25));
            let at = Vec3::new(low.x + 0.08, low.y + 0.98, -REVEAL);
            knob.block(at - Vec3::new(0.02, 0.09, 0.0), at + Vec3::new(0.02, 0.09, 0.012));
            knob.block(at - Vec3::new(0.0, 0.012, 0.0), at + Vec3::new(0.13, 0.012, 0.05));
            pane_low.y = leaf_top + 0.05;
            let step = self.model.paint(self.palette.slabs, Vec3::splat(1.1));
            step.block(Vec3::new(low.x - 0.18, 0.0, -REVEAL), Vec3::new(high.x + 0.18, 0.13, 0.42));
        }

        // A frame all around.
        let frame = self.model.paint(wood, bars);
        let bar = 0.065;
        let back = -REVEAL;
        frame.block(pane_low.extend(back), Vec3::new(pane_low.x + bar, high.y, front));
        frame.block(Vec3::new(high.x - bar, pane_low.y, back), high.extend(front));
        frame.block(Vec3::new(low.x + bar, high.y - bar, back), Vec3::new(high.x - bar, high.y, front));
        frame.block(pane_low.extend(back) + Vec3::X * bar, Vec3::new(high.x - bar, pane_low.y + bar, front));
        // Bars that divide the glass: a cross-shaped grid in windows, a transom in shop fronts.
        let middle = 0.5 * (low.x + high.x);
        let (inner_low, inner_high) = (pane_low.y + bar, high.y - bar);
        if use_ == Use::Window || use_ == Use::Attic {
            let depth = front - 0.015;
            frame.block(
                Vec3::new(middle - 0.04, inner_low, back),
                Vec3::new(middle + 0.04, inner_high, front),
            );
            for share in [0.36, 0.70] {
                let y = inner_low + share * (inner_high - inner_low);
                for (left, right) in [(low.x + bar, middle - 0.04), (middle + 0.04, high.x - bar)] {
                    frame.block(Vec3::new(left, y - 0.016, back), Vec3::new(right, y + 0.016, depth));
                }
            }
        } else if use_ == Use::Shop {
            let y = inner_low + 0.78 * (inner_high - inner_low);
            frame.block(Vec3::new(low.x + bar, y - 0.025, back), Vec3::new(high.x - bar, y + 0.025, front));
            frame.block(
                Vec3::new(middle - 0.025, y + 0.025, back),
                Vec3::new(middle + 0.025, inner_high, front),
            );
        }
        // The glass; in a window it shows any of the rooms, elsewhere a dark one.
        let quarter = if use_ == Use::Window {
            *self.rng.pick(&[
                Vec2::ZERO,
                Vec2::new(0.5, 0.0),
                Vec2::new(0.5, 0.0),
                Vec2::new(0.0, 0.5),
                Vec2::new(0.5, 0.5),
            ])
        } else {
            Vec2::ZERO
        };
        self.model.paint(self.palette.panes, Vec3::ONE).fitted_panel(
            pane_low.extend(back + 0.012),
            Vec3::X * size.x,
            Vec3::Y * (high.y - pane_low.y),
            quarter,
            quarter + 0.5,
        );

        // What a window has outside: a sill, and shutters on both sides.
        if use_ == Use::Window {
            self.sill(low, high);
            if shutters {
                let leaf = self.model.paint(wood, paint);
                for (left, right) in [(low.x - 0.53, low.x - 0.03), (high.x + 0.03, high.x + 0.53)] {
                    leaf.block(Vec3::new(left, low.y, 0.015), Vec3::new(right, high.y, 0.055));
                    for y in [low.y + 0.18, high.y - 0.28] {
                        leaf.block(Vec3::new(left + 0.03, y, 0.055), Vec3::new(right - 0.03, y + 0.1, 0.075));
                    }
                }
            }
        }
    }

    /// A window sill, here and there with flowers.
    fn sill(&mut self, low: Vec2, high: Vec2) {
        let (material, tint) = self.stone();
        self.model
            .paint(material, tint)
            .block(Vec3::new(low.x - 0.1, low.y - 0.075, -REVEAL), Vec3::new(high.x + 0.1, low.y, 0.13));
        if low.y > 2.0 && self.rng.happens(0.38) {
            let (left, right) = (low.x + 0.02, high.x - 0.02);
            self.model
                .paint(self.palette.planks, linear_from_hex(0x6a4630))
                .block(Vec3::new(left, low.y, -0.03), Vec3::new(right, low.y + 0.17, 0.14));
            let bed =
                (Vec3::new(left + 0.04, low.y + 0.10, -0.02), Vec3::new(right - 0.04, low.y + 0.42, 0.24));
            planting(&mut self.model, self.palette, self.rng, Cluster::Blossom, bed, 26);
        }
    }

    /// What trims and plinths are made of.
    fn stone(&self) -> (u32, Vec3) {
        match self.house.wall {
            Wall::Plaster(_) | Wall::Brick => (self.palette.slabs, Vec3::new(1.5, 1.42, 1.3)),
            Wall::HalfTimber(_) => (self.palette.timber, linear_from_hex(0x5a3d2a)),
        }
    }

    fn trim(&mut self, openings: &[Opening]) {
        let House { width, wall, gable_front, .. } = self.house;
        let (eaves, half) = (self.house.eaves(), 0.5 * width);
        let (material, tint) = self.stone();

        // Plinth between the doors.
        let mut from = -half;
        let mut doors: Vec<_> = openings.iter().filter(|o| o.use_ == Use::Door).collect();
        doors.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
        let plinth = self.model.paint(self.palette.ashlar, Vec3::splat(0.85));
        for door in &doors {
            plinth.block(Vec3::new(from, 0.0, 0.0), Vec3::new(door.low.x - 0.16, 0.42, 0.05));
            from = door.high.x + 0.16;
        }
        plinth.block(Vec3::new(from, 0.0, 0.0), Vec3::new(half, 0.42, 0.05));

        // Stone surrounds the openings of plain walls; half-timbered ones have beams there.
        if !matches!(wall, Wall::HalfTimber(_)) {
            let shape = self.model.paint(material, tint);
            for Opening { low, high, use_ } in openings {
                let bottom = if *use_ == Use::Door { 0.0 } else { low.y };
                for (left, right) in [(low.x - 0.12, low.x), (high.x, high.x + 0.12)] {
                    if !self.house.shutters || *use_ != Use::Window {
                        shape.block(Vec3::new(left, bottom, -0.01), Vec3::new(right, high.y, 0.03));
                    }
                }
                shape.block(
                    Vec3::new(low.x - 0.15, high.y, -0.01),
                    Vec3::new(high.x + 0.15, high.y + 0.16, 0.045),
                );
            }
            // A string course above the ground floor and a cornice under the eaves.
            shape.block(
                Vec3::new(-half, GROUND_FLOOR - 0.12, 0.0),
                Vec3::new(half, GROUND_FLOOR + 0.06, 0.07),
            );
            if !gable_front {
                shape.block(Vec3::new(-half, eaves - 0.30, 0.0), Vec3::new(half, eaves - 0.12, 0.10));
                shape.block(Vec3::new(-half, eaves - 0.12, 0.0), Vec3::new(half, eaves + 0.02, 0.18));
            }
        } else {
            self.timber_frame(openings);
        }
        if self.house.shop {
            let board = self.model.paint(self.palette.planks, self.house.paint);
            board.block(Vec3::new(-half + 0.15, 2.74, 0.0), Vec3::new(half - 0.15, 3.15, 0.09));
        }
    }

    fn timber_frame(&mut self, openings: &[Opening]) {
        let House { width, gable_front, storey_count, .. } = self.house;
        let (eaves, ridge, half) = (self.house.eaves(), self.house.ridge(), 0.5 * width);
        let beam = self.model.paint(self.palette.timber, linear_from_hex(0x5a3d2a));
        let (thick, out) = (0.18, 0.06);
        let mut lay = |from: Vec2, to: Vec2, width: f32| {
            let side = if (to - from).x.abs() > (to - from).y.abs() { Vec3::Y } else { Vec3::X };
            beam.beam(from.extend(0.01), to.extend(0.01), side, width, out);
        };
        for storey in 1..=storey_count {
            let y = GROUND_FLOOR + STOREY * (storey - 1) as f32;
            lay(Vec2::new(-half, y), Vec2::new(half, y), 0.24);
        }
        for storey in 1..storey_count {
            let low = GROUND_FLOOR + STOREY * (storey - 1) as f32;
            let high = low + STOREY;
            let windows: Vec<_> = openings
                .iter()
                .filter(|o| o.use_ == Use::Window && o.low.y > low && o.high.y < high)
                .collect();
            for x in [-half + 0.1, half - 0.1] {
                lay(Vec2::new(x, low + 0.12), Vec2::new(x, high - 0.12), 0.2);
            }
            for window in &windows {
                for x in [window.low.x - 0.09, window.high.x + 0.09] {
                    lay(Vec2::new(x, low + 0.12), Vec2::new(x, high - 0.12), thick);
                }
                lay(
                    Vec2::new(window.low.x, window.high.y + 0.08),
                    Vec2::new(window.high.x, window.high.y + 0.08),
                    0.16,
                );
                // A cross under each window.
                let (l, r) = (window.low.x + 0.02, window.high.x - 0.02);
                let (b, t) = (low + 0.14, window.low.y - 0.09);
                lay(Vec2::new(l, b), Vec2::new(r, t), 0.12);
                lay(Vec2::new(r, b), Vec2::new(l, t), 0.12);
            }
            // Braces in the outer fields.
            if let (Some(first), Some(last)) = (windows.first(), windows.last()) {
                lay(Vec2::new(-half + 0.24, low + 0.2), Vec2::new(first.low.x - 0.2, high - 0.2), 0.16);
                lay(Vec2::new(half - 0.24, low + 0.2), Vec2::new(last.high.x + 0.2, high - 0.2), 0.16);
            }
        }
        if gable_front {
            // Struts of the gable: posts up to the slope, and a collar above the attic window.
            let slope = (ridge - eaves) / half;
            let posts = (half / 1.1).floor() as i32;
            for index in -posts..=posts {
                let x = 1.1 * index as f32;
                let top = ridge - slope * x.abs() - 0.15;
                if index != 0 && top > eaves + 0.4 {
                    lay(Vec2::new(x, eaves + 0.12), Vec2::new(x, top), 0.16);
                }
            }
            let collar = eaves + 1.62;
            if collar < ridge - 0.5 {
                let reach = (ridge - collar) / slope - 0.1;
                lay(Vec2::new(-reach, collar), Vec2::new(reach, collar), 0.18);
                lay(Vec2::new(0.0, collar + 0.1), Vec2::new(0.0, ridge - 0.15), 0.18);
            }
        }
    }

    /// A striped awning over each run of shop windows.
    fn awning(&mut self, openings: &[Opening]) {
        for shop in openings.iter().filter(|o| o.use_ == Use::Shop) {
            let (left, right) = (shop.low.x - 0.15, shop.high.x + 0.15);
            let (top, drop, reach) = (2.72, 0.5, 1.25);
            let cloth = self.model.paint(self.palette.awning, Vec3::ONE);
            let run = Vec3::X * (right - left);
            cloth.panel(Vec3::new(left, top - drop, reach), run, Vec3::new(0.0, drop, 0.1 - reach));
            cloth.panel(Vec3::new(left, top - drop - 0.2, reach), run, Vec3::Y * 0.2);
            let rods = self.model.paint(self.palette.iron, Vec3::splat(0.06));
            for x in [left + 0.03, right - 0.03] {
                let foot = Vec3::new(x, 1.9, 0.03);
                rods.tube(&[(foot, 0.014), (Vec3::new(x, top - drop - 0.02, reach - 0.02), 0.014)], 6);
            }
        }
    }

    fn roof(&mut self) {
        let House { width, depth, gable_front, covering, roof, trim, .. } = self.house;
        let (eaves, ridge) = (self.house.eaves(), self.house.ridge());
        // The slopes run along the ridge; a gable that looks to the front lets its roof jut out over it.
        let (run, length) = if gable_front { (-Vec3::Z, depth + 0.35) } else { (Vec3::X, width + 0.10) };
        let middle =
            if gable_front { Vec3::Z * 0.35 } else { Vec3::new(-0.5 * width - 0.05, 0.0, -0.5 * depth) };
        let half_span = 0.5 * self.house.span();
        let rise = ridge - eaves;
        let slope = rise / half_span;
        let thickness = 0.10;
        for side in [1.0, -1.0] {
            // Seen from outside, along the eaves from left to right.
            let right = run * side;
            let start = middle + if side > 0.0 { Vec3::ZERO } else { run * length };
            let out = right.cross(Vec3::Y);
            let foot = start + out * (half_span + EAVES) + Vec3::Y * (eaves - EAVES * slope + thickness);
            let up = Vec3::Y * (rise + EAVES * slope) - out * (half_span + EAVES);
            let hidden = !gable_front && side < 0.0;
            let slope_plane = Slope { foot, run: right * length, up };
            slope_plane.cover(&mut self.model, self.palette, self.rng, covering, roof, hidden);

            // Boarding underneath, and a fascia along the eaves.
            let normal = slope_plane.normal();
            let boards = self.model.paint(self.palette.planks, trim * 0.45);
            let sunk = foot - normal * thickness;
            boards.panel(sunk + right * length, -right * length, up);
            boards.panel(sunk, right * length, normal * (thickness - 0.015));
            let verge = self.model.paint(self.palette.planks, trim * 0.8);
            verge.quad([
                foot - normal * thickness,
                foot - normal * 0.01,
                foot + up - normal * 0.01,
                foot + up - normal * thickness,
            ]);
            let far = foot + right * length;
            verge.quad([
                far - normal * 0.01,
                far - normal * thickness,
                far + up - normal * thickness,
                far + up - normal * 0.01,
            ]);
            if !hidden {
                self.gutter(foot, right * length, out, gable_front);
            }
        }
        self.ridge_tiles(middle + Vec3::Y * (ridge + thickness + 0.02), run * length, roof);
        self.chimneys(middle, run * length, ridge);
        if !gable_front {
            self.dormers(slope);
        }
    }

    fn gutter(&mut self, foot: Vec3, run: Vec3, out: Vec3, gable_front: bool) {
        let zinc = self.model.paint(self.palette.iron, Vec3::new(0.30, 0.31, 0.32));
        let line = foot + out * 0.05 - Vec3::Y * 0.06;
        zinc.tube(&[(line, 0.06), (line + run, 0.06)], 7);
        if !gable_front {
            let corner = line + run - run.normalize() * 0.22;
            let wall = Vec3::new(corner.x, corner.y - 0.55, 0.08);
            zinc.tube(
                &[(corner, 0.04), (corner - Vec3::Y * 0.12, 0.04), (wall, 0.04), (wall.with_y(0.1), 0.04)],
                7,
            );
        }
    }

    fn ridge_tiles(&mut self, from: Vec3, run: Vec3, tint: Vec3) {
        let count = (run.length() / 0.42).ceil() as u32;
        for index in 0..count {
            let (a, b) = (index as f32 / count as f32, (index as f32 + 1.06) / count as f32);
            let shade = self.rng.between(0.75, 1.05);
            let shape = self.model.paint(self.palette.tiles, tint * shade);
            shape.tube(
                &[
                    (from + run * a - Vec3::Y * 0.05, 0.115),
                    (from + run * b.min(1.0) - Vec3::Y * 0.05, 0.135),
                ],
                8,
            );
        }
    }

    fn chimneys(&mut self, from: Vec3, run: Vec3, ridge: f32) {
        let along = run.normalize();
        let places = if run.length() > 9.0 { vec![0.2, 0.8] } else { vec![*self.rng.pick(&[0.22, 0.72])] };
        for share in places {
            let at = from + run * share;
            let (half, top) = (Vec3::new(0.36, 0.0, 0.46), ridge + self.rng.between(1.0, 1.5));
            let half = if along.z.abs() > 0.5 { Vec3::new(half.z, 0.0, half.x) } else { half };
            let foot = at.with_y(ridge - 1.2);
            self.model
                .paint(self.palette.brick, Vec3::splat(0.85))
                .block(foot - half, (at + half).with_y(top));
            let rim = Vec3::new(0.07, 0.0, 0.07);
            let slab = self.model.paint(self.palette.slabs, Vec3::splat(1.1));
            slab.block((at - half - rim).with_y(top), (at + half + rim).with_y(top + 0.10));
            let pots = self.model.paint(self.palette.tiles, linear_from_hex(0xa5603f));
            for side in [-0.19, 0.19] {
                let offset = if along.z.abs() > 0.5 { Vec3::X } else { Vec3::Z } * side;
                let profile = [
                    (0.12, 0.0),
                    (0.10, 0.3),
                    (0.105, 0.34),
                    (0.135, 0.36),
                    (0.135, 0.42),
                    (0.09, 0.42),
                    (0.085, 0.2),
                ];
                pots.lathe((at + offset).with_y(top + 0.10), &profile, 12);
            }
        }
    }

    /// Small gabled windows in the front slope.
    fn dormers(&mut self, slope: f32) {
        let House { width, dormer_count, covering, roof, trim, .. } = self.house;
        let eaves = self.house.eaves();
        for index in 0..dormer_count {
            let x = width * ((index as f32 + 0.5) / dormer_count as f32 - 0.5);
            // The face stands a little behind the wall, its foot on the slope.
            let (face, half, height, rise) = (-0.55, 0.62, 1.15, 0.55);
            let foot = eaves + slope * -face + 0.05;
            let (left, right, top) = (x - half, x + half, foot + height);
            let (material, tint) = self.wall_at(1);
            let walls = self.model.paint(material, tint * 0.95);
            let depth = (height + rise) / slope + 0.3;
            walls.block(Vec3::new(left, foot - 0.4, face - depth), Vec3::new(right, top, face));
            walls.triangle([
                Vec3::new(left, top, face),
                Vec3::new(right, top, face),
                Vec3::new(x, top + rise, face),
            ]);
            // The window sits on the face: a shallow casing, bars and a pane.
            let frame = self.model.paint(self.palette.planks, trim);
            let (l, r, b, t) = (x - 0.40, x + 0.40, foot + 0.18, top - 0.08);
            frame.block(Vec3::new(l - 0.08, b - 0.08, face), Vec3::new(l, t + 0.08, face + 0.05));
            frame.block(Vec3::new(r, b - 0.08, face), Vec3::new(r + 0.08, t + 0.08, face + 0.05));
            frame.block(Vec3::new(l, t, face), Vec3::new(r, t + 0.08, face + 0.05));
            frame.block(Vec3::new(l, b - 0.08, face), Vec3::new(r, b, face + 0.09));
            frame.block(Vec3::new(x - 0.03, b, face), Vec3::new(x + 0.03, t, face + 0.035));
            self.model.paint(self.palette.panes, Vec3::ONE).fitted_panel(
                Vec3::new(l, b, face + 0.012),
                Vec3::X * (r - l),
                Vec3::Y * (t - b),
                Vec2::ZERO,
                Vec2::splat(0.5),
            );
            let (verge, over) = (0.14, 0.22);
            let pitch = rise / half;
            for side in [-1.0, 1.0] {
                let foot_point =
                    Vec3::new(x + side * (half + verge), top - verge * pitch + 0.05, face + over);
                let up = Vec3::new(-side * (half + verge), rise + verge * pitch, 0.0);
                let run = Vec3::new(0.0, 0.0, -(depth + over));
                let plane = if side > 0.0 {
                    Slope { foot: foot_point, run, up }
                } else {
                    Slope { foot: foot_point + run, run: -run, up }
                };
                plane.cover(&mut self.model, self.palette, self.rng, covering, roof, false);
                let normal = plane.normal();
                let verges = self.model.paint(self.palette.planks, trim * 0.8);
                let low = foot_point - normal * 0.07;
                let corners = [low, low + normal * 0.06, low + up + normal * 0.06, low + up];
                let corners = if side > 0.0 {
                    [corners[0], corners[1], corners[2], corners[3]]
                } else {
                    [corners[1], corners[0], corners[3], corners[2]]
                };
                verges.quad(corners);
                let under = plane.foot - normal * 0.06;
                verges.panel(under + plane.run, -plane.run, up);
            }
        }
    }
}

/// A roof slope: `foot` is its lower left corner seen from outside, `run` goes along the eaves, `up` to the
/// ridge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slope {
    pub(crate) foot: Vec3,
    pub(crate) run: Vec3,
    pub(crate) up: Vec3,
}

impl Slope {
    fn normal(&self) -> Vec3 {
        self.run.cross(self.up).normalize()
    }

    /// Lays tiles, or where nobody looks a plain sheet.
    pub(crate) fn cover(
        &self,
        model: &mut Model,
        palette: &Palette,
        rng: &mut Rng,
        covering: Covering,
        tint: Vec3,
        hidden: bool,
    ) {
        let shape = model.paint(palette.tiles, tint * if hidden { 0.75 } else { 0.45 });
        shape.panel(self.foot - self.normal() * 0.012, self.run, self.up);
        if hidden {
            return;
        }
        let (width, exposure) = match covering {
            Covering::Pantile => (0.26, 0.35),
            Covering::Plain => (0.22, 0.20),
        };
        let (columns, rows) = (
            (self.run.length() / width).round().max(1.0) as u32,
            (self.up.length() / exposure).round().max(1.0) as u32,
        );
        for row in 0..rows {
            for column in 0..columns {
                // Colour drifts over the roof, and every tile was fired on its own.
                let place = Vec2::new(column as f32 / 9.0, row as f32 / 6.0);
                let drift = 0.06 * ((place.x * 1.3 + place.y).sin() + (place.y * 1.7 - place.x * 0.6).sin());
                let own = tint * (rng.between(0.78, 1.12) + drift);
                let own = own * Vec3::new(1.0, rng.between(0.93, 1.05), rng.between(0.88, 1.06));
                let shape = model.paint(palette.tiles, own);
                shape.shift_uv(Vec2::new(rng.unit(), rng.unit()) * 1.5);
                self.tile(shape, covering, (column, columns), (row, rows));
                shape.shift_uv(Vec2::ZERO);
            }
        }
    }

    fn tile(
        &self,
        shape: &mut Shape,
        covering: Covering,
        (column, columns): (u32, u32),
        (row, rows): (u32, u32),
    ) {
        let (cell_x, cell_y) = (self.run / columns as f32, self.up / rows as f32);
        let normal = self.normal();
        let (segments, raise, overlap, swell) = match covering {
            Covering::Pantile => (3, 0.030, 1.22, 0.038),
            Covering::Plain => (1, 0.026, 1.9, 0.0),
        };
        let shift = if covering == Covering::Plain && row % 2 == 1 { 0.5 } else { 0.0 };
        // The shifted rows begin and end with half a tile.
        let (left, right) = ((column as f32 - shift).max(0.0), (column + 1) as f32 - shift);
        let right = if column + 1 == columns { columns as f32 } else { right - 0.02 };
        let low = self.foot + cell_y * row as f32;
        let top = (overlap as f32).min((rows - row) as f32);
        let first = shape.positions.len() as u32;
        for s in 0..=segments {
            let share = s as f32 / segments as f32;
            let wave = swell * (0.5 - 0.5 * (2.0 * PI * share).cos());
            let lean = swell * PI * (2.0 * PI * share).sin() / cell_x.length();
            let tilted = (normal - cell_x.normalize() * lean).normalize();
            let base = low + cell_x * (left + (right - left) * share);
            let uv = Vec2::new(share * cell_x.length(), 0.0);
            let bottom = base + normal * (raise + wave);
            let head = base + cell_y * top + normal * wave;
            let drop = normal * (0.02 + 0.4 * wave.min(0.02));
            let shifted = |v: f32| uv + Vec2::new(low.x + low.z, v);
            shape.vertex(Vertex { position: bottom, normal: tilted, uv: shifted(0.0) });
            shape.vertex(Vertex { position: head, normal: tilted, uv: shifted(-top * cell_y.length()) });
            let front = -cell_y.normalize();
            shape.vertex(Vertex { position: bottom - drop, normal: front, uv: shifted(0.02) });
            shape.vertex(Vertex { position: bottom, normal: front, uv: shifted(0.0) });
        }
        for s in 0..segments {
            let at = first + 4 * s;
            shape.indices.extend([[at, at + 4, at + 5], [at, at + 5, at + 1]]);
            shape.indices.extend([[at + 2, at + 6, at + 7], [at + 2, at + 7, at + 3]]);
        }
    }
}
