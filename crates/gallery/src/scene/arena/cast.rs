//! Who fights in the arena, where each of them stands and what they do when.

use glam::Vec3;
use sheer_core::colour::linear_from_hex;

use super::{
    body::{self, Team, Wardrobe},
    figure::{Actor, Body, Limb, Move, Part, Pose, enter, limb},
};
use crate::{builder::SceneBuilder, kit::palette::Palette, rng::Rng};

/// Everybody, by what they do.
pub(super) struct Cast {
    /// Holds the barrier against the golem.
    pub(super) warden: Actor,
    /// Throws water at the golem.
    pub(super) tidecaller: Actor,
    /// Stands in a pillar of light.
    pub(super) healer: Actor,
    /// One fights in front on the right, one at the golem's feet, one on the left behind.
    pub(super) knights: [Actor; 3],
    pub(super) golem: Actor,
    /// Throw fire and violet bolts.
    pub(super) warlocks: [Actor; 2],
    /// Each against the knight of the same index.
    pub(super) raiders: [Actor; 3],
}

const READY_LEGS: [Limb; 2] = [limb(-0.28, 0.10, 0.25), limb(0.38, 0.12, 0.45)];

/// Sword or axe drawn, shield before the body.
const FIGHTER: Pose = Pose {
    lean: 0.12,
    turn: -0.25,
    nod: 0.0,
    arms: [limb(0.35, 0.35, 1.35), limb(0.75, 0.15, 0.95)],
    legs: READY_LEGS,
};
const WIND_UP: Pose = Pose {
    lean: -0.12,
    turn: -0.75,
    nod: 0.0,
    arms: [limb(2.3, 0.65, 1.3), limb(0.7, 0.3, 0.9)],
    legs: READY_LEGS,
};
const STRIKE: Pose = Pose {
    lean: 0.48,
    turn: 0.65,
    nod: 0.0,
    arms: [limb(0.95, -0.35, 0.15), limb(0.1, 0.5, 0.9)],
    legs: [limb(-0.5, 0.1, 0.15), limb(0.75, 0.12, 0.7)],
};
/// Crouched behind the shield.
const BLOCK: Pose = Pose {
    lean: 0.28,
    turn: 0.15,
    nod: 0.1,
    arms: [limb(0.1, 0.6, 1.5), limb(1.25, 0.0, 0.55)],
    legs: [limb(-0.35, 0.15, 0.75), limb(0.75, 0.15, 1.1)],
};
/// Bent back, out of the way of a blade.
const DODGE: Pose = Pose {
    lean: -0.5,
    turn: 0.4,
    nod: 0.2,
    arms: [limb(0.2, 0.9, 0.9), limb(0.4, 0.8, 0.9)],
    legs: [limb(0.35, 0.2, 0.5), limb(-0.1, 0.3, 0.6)],
};

/// The blade passes from [`WIND_UP`] to [`STRIKE`].
pub(super) const SLASH: Move = &[(0.28, WIND_UP), (0.42, STRIKE), (0.62, STRIKE), (1.05, FIGHTER)];
const GUARD: Move = &[(0.2, BLOCK), (0.75, BLOCK), (1.1, FIGHTER)];
const DUCK: Move = &[(0.2, DODGE), (0.5, DODGE), (0.9, FIGHTER)];

const STRAIGHT_LEGS: [Limb; 2] = [limb(-0.08, 0.05, 0.0), limb(0.10, 0.05, 0.05)];

/// Staff upright beside the body.
const CASTER: Pose = Pose {
    lean: 0.05,
    turn: -0.15,
    nod: 0.0,
    arms: [limb(0.45, 0.25, 1.15), limb(0.25, 0.25, 0.7)],
    legs: STRAIGHT_LEGS,
};
const RAISE: Pose = Pose {
    lean: -0.15,
    turn: -0.35,
    nod: -0.1,
    arms: [limb(2.2, 0.3, 0.4), limb(1.5, 0.5, 0.4)],
    legs: STRAIGHT_LEGS,
};
const THRUST: Pose = Pose {
    lean: 0.32,
    turn: 0.45,
    nod: 0.0,
    arms: [limb(1.55, -0.1, 0.1), limb(0.2, 0.6, 0.6)],
    legs: [limb(-0.25, 0.06, 0.0), limb(0.25, 0.06, 0.05)],
};
/// Both hands against what comes.
const HOLD: Pose = Pose {
    lean: 0.2,
    turn: 0.0,
    nod: -0.05,
    arms: [limb(1.55, 0.25, 0.35), limb(1.6, 0.2, 0.15)],
    legs: [limb(-0.32, 0.08, 0.0), limb(0.30, 0.08, 0.15)],
};
const CALL: Pose = Pose {
    lean: -0.12,
    turn: 0.0,
    nod: -0.3,
    arms: [limb(2.35, 0.35, 0.3), limb(2.35, 0.45, 0.3)],
    legs: STRAIGHT_LEGS,
};

pub(super) const CAST: Move = &[(0.35, RAISE), (0.5, THRUST), (0.75, THRUST), (1.2, CASTER)];
const WARD: Move = &[(0.5, HOLD), (4.6, HOLD), (5.2, CASTER)];
const CHANT: Move = &[(0.5, CALL), (3.0, CALL), (3.6, CASTER)];

const GOLEM_LEGS: [Limb; 2] = [limb(-0.15, 0.22, 0.2), limb(0.35, 0.22, 0.45)];
const LOOM: Pose = Pose {
    lean: 0.22,
    turn: 0.0,
    nod: 0.0,
    arms: [limb(0.25, 0.4, 0.55), limb(0.25, 0.4, 0.55)],
    legs: GOLEM_LEGS,
};
const HEAVE: Pose = Pose {
    lean: -0.25,
    turn: 0.0,
    nod: -0.2,
    arms: [limb(2.6, 0.35, 0.5), limb(2.6, 0.35, 0.5)],
    legs: GOLEM_LEGS,
};
const SMASH: Pose = Pose {
    lean: 0.82,
    turn: 0.0,
    nod: -0.1,
    arms: [limb(1.20, 0.05, 0.1), limb(1.20, 0.05, 0.1)],
    legs: [limb(0.60, 0.25, 1.0), limb(0.95, 0.25, 0.95)],
};
const INHALE: Pose = Pose {
    lean: -0.2,
    turn: 0.1,
    nod: -0.35,
    arms: [limb(-0.3, 0.9, 0.9), limb(-0.3, 0.9, 0.9)],
    legs: GOLEM_LEGS,
};
const BREATHE: Pose = Pose {
    lean: 0.42,
    turn: 0.0,
    nod: 0.25,
    arms: [limb(0.75, 1.0, 1.0), limb(0.2, 1.0, 1.1)],
    legs: [limb(-0.3, 0.25, 0.35), limb(0.6, 0.25, 0.75)],
};
const REEL: Pose = Pose {
    lean: -0.3,
    turn: -0.5,
    nod: 0.3,
    arms: [limb(1.7, 0.3, 1.6), limb(-0.4, 0.9, 0.4)],
    legs: [limb(0.15, 0.25, 0.5), limb(-0.2, 0.3, 0.5)],
};

/// When the golem's fists reach the ground.
pub(super) const SMASH_SECS: f32 = 3.1;
/// When the golem breathes fire: start and end, seconds.
pub(super) const BREATH_SECS: [f32; 2] = [5.1, 7.3];

/// While the warden holds the barrier, and while water is called.
pub(super) const BARRIER_SECS: [f32; 2] = [4.1, 8.3];
pub(super) const WATER_SECS: [f32; 2] = [5.4, 7.8];

const GOLEM_SMASH: Move = &[(0.7, HEAVE), (0.95, HEAVE), (1.2, SMASH), (1.8, SMASH), (2.5, LOOM)];
const GOLEM_BREATH: Move =
    &[(0.5, INHALE), (0.75, BREATHE), (2.9, BREATHE), (3.2, REEL), (3.9, REEL), (4.8, LOOM)];

type Marks = &'static [(f32, f32, f32)];

const GOLEM_MARKS: Marks =
    &[(0.0, 4.1, -2.6), (0.8, 4.1, -2.6), (1.9, 3.0, -1.5), (8.2, 3.0, -1.5), (9.8, 4.1, -2.6)];
const WARDEN_MARKS: Marks =
    &[(0.0, -3.6, 1.5), (2.6, -3.6, 1.5), (3.6, -2.7, 1.5), (8.6, -2.7, 1.5), (9.8, -3.6, 1.5)];

/// What adding a figure takes.
struct Casting<'a> {
    builder: &'a mut SceneBuilder,
    wardrobe: Wardrobe,
    rng: Rng,
}

/// Adds all figures, each with its body, its path and its moves.
pub(super) fn assemble(builder: &mut SceneBuilder, palette: &Palette, seed: u32) -> Cast {
    let wardrobe = Wardrobe::new(builder, palette);
    let mut casting = Casting { builder, wardrobe, rng: Rng::new(seed, "cast") };
    let golem = casting.golem();
    let [warden, tidecaller, healer] = casting.mages();
    let warlocks = casting.warlocks();
    Cast {
        golem,
        warden,
        tidecaller,
        healer,
        knights: casting.knights(),
        warlocks,
        raiders: casting.raiders(),
    }
}

impl Casting<'_> {
    fn enter(
        &mut self,
        name: &str,
        body: Body,
        [marks, gaze]: [Marks; 2],
        guard: Pose,
        moves: &[(f32, Move)],
    ) -> Actor {
        enter(self.builder, name, body, &Part { marks, gaze, guard, moves, phase: self.rng.unit() })
    }

    fn golem(&mut self) -> Actor {
        let body = body::golem(&self.wardrobe, &mut self.rng);
        let gaze: Marks =
            &[(0.0, -1.5, 2.0), (3.6, -0.8, 1.8), (4.6, -2.7, 1.5), (7.6, -2.7, 1.5), (9.5, -1.5, 2.0)];
        let moves = [(SMASH_SECS - 1.2, GOLEM_SMASH), (BREATH_SECS[0] - 0.75, GOLEM_BREATH)];
        self.enter("golem", body, [GOLEM_MARKS, gaze], LOOM, &moves)
    }

    fn mages(&mut self) -> [Actor; 3] {
        let mage = |wardrobe: &Wardrobe, hex| body::mage(wardrobe, Team::Heroes, linear_from_hex(hex));
        let wardrobe = self.wardrobe;
        let warden = self.enter(
            "warden",
            mage(&wardrobe, BLUE),
            [WARDEN_MARKS, GOLEM_MARKS],
            CASTER,
            &[(1.2, CAST), (BARRIER_SECS[0] - 0.4, WARD)],
        );
        let tidecaller = self.enter(
            "tidecaller",
            mage(&wardrobe, 0x1a7a88),
            [&[(0.0, -5.4, 2.4), (1.5, -4.5, 2.3), (8.8, -4.5, 2.3), (9.8, -5.4, 2.4)], GOLEM_MARKS],
            CASTER,
            &[(0.7, CAST), (2.4, CAST), (WATER_SECS[0] - 0.5, CHANT)],
        );
        let healer = self.enter(
            "healer",
            mage(&wardrobe, 0xd8d2c4),
            [&[(0.0, -5.7, -1.4)], WARDEN_MARKS],
            CASTER,
            &[(1.9, CHANT), (6.0, CAST), (7.4, CAST)],
        );
        [warden, tidecaller, healer]
    }

    fn knights(&mut self) -> [Actor; 3] {
        let wardrobe = self.wardrobe;
        let knight = |hex| body::knight(&wardrobe, linear_from_hex(hex));
        let in_front = self.enter(
            "knight 1",
            knight(BLUE),
            [
                &[(0.0, -1.3, 4.2), (1.0, -1.3, 4.2), (2.2, 1.1, 3.9), (8.3, 1.1, 3.9), (9.9, -1.3, 4.2)],
                &[(0.0, 3.4, 3.3)],
            ],
            FIGHTER,
            &[(2.4, SLASH), (3.7, GUARD), (5.0, SLASH), (6.4, SLASH), (7.5, GUARD)],
        );
        let marks: Marks = &[
            (0.0, -1.7, -1.4),
            (3.3, -1.7, -1.4),
            (4.6, 0.6, -3.0),
            (7.2, 0.6, -3.0),
            (8.0, 0.0, -3.2),
            (9.8, -1.7, -1.4),
        ];
        let at_the_golem = self.enter(
            "knight 2",
            knight(BLUE),
            [marks, &[(0.0, 3.0, -1.5)]],
            FIGHTER,
            &[(2.7, GUARD), (4.7, SLASH), (5.8, SLASH), (6.9, SLASH)],
        );
        let behind = self.enter(
            "knight 3",
            knight(0x2a4aa8),
            [
                &[
                    (0.0, -4.4, -3.6),
                    (1.0, -4.4, -3.6),
                    (2.0, -3.3, -4.0),
                    (8.6, -3.3, -4.0),
                    (9.6, -4.4, -3.6),
                ],
                &[(0.0, -1.6, -4.4)],
            ],
            FIGHTER,
            &[(2.1, SLASH), (3.4, GUARD), (4.6, SLASH), (6.2, DUCK), (7.2, SLASH)],
        );
        [in_front, at_the_golem, behind]
    }

    fn warlocks(&mut self) -> [Actor; 2] {
        let wardrobe = self.wardrobe;
        let mage = |hex| body::mage(&wardrobe, Team::Raiders, linear_from_hex(hex));
        let violet = self.enter(
            "warlock 1",
            mage(0x3a1440),
            [&[(0.0, 6.4, 0.6), (1.6, 5.5, 0.4), (8.4, 5.5, 0.4), (9.8, 6.4, 0.6)], WARDEN_MARKS],
            CASTER,
            &[(1.6, CAST), (3.2, CAST), (4.8, CAST), (6.2, CAST), (7.6, CAST)],
        );
        let red = self.enter(
            "warlock 2",
            mage(0x501018),
            [&[(0.0, 1.0, -6.6)], &[(0.0, -5.0, -1.0)]],
            CASTER,
            &[(2.2, CAST), (4.2, CAST), (5.6, CAST), (7.0, CAST)],
        );
        [violet, red]
    }

    fn raiders(&mut self) -> [Actor; 3] {
        let wardrobe = self.wardrobe;
        let raider = || body::raider(&wardrobe, linear_from_hex(0x9c1c18));
        let in_front = self.enter(
            "raider 1",
            raider(),
            [
                &[(0.0, 4.9, 2.9), (0.9, 4.9, 2.9), (2.1, 2.65, 3.5), (8.2, 2.65, 3.5), (9.8, 4.9, 2.9)],
                &[(0.0, 1.1, 3.9)],
            ],
            FIGHTER,
            &[(2.7, DUCK), (3.6, SLASH), (5.2, GUARD), (6.7, DUCK), (7.6, SLASH)],
        );
        let beside_the_golem = self.enter(
            "raider 2",
            raider(),
            [
                &[(0.0, 7.4, -3.6), (3.0, 7.4, -3.6), (4.6, 6.2, -2.6), (8.0, 6.2, -2.6), (9.8, 7.4, -3.6)],
                WARDEN_MARKS,
            ],
            FIGHTER,
            &[(5.0, GUARD), (6.6, GUARD)],
        );
        let behind = self.enter(
            "raider 3",
            raider(),
            [
                &[
                    (0.0, -0.6, -5.6),
                    (1.0, -0.6, -5.6),
                    (2.0, -1.7, -4.6),
                    (8.6, -1.7, -4.6),
                    (9.6, -0.6, -5.6),
                ],
                &[(0.0, -3.3, -4.0)],
            ],
            FIGHTER,
            &[(2.3, GUARD), (3.3, SLASH), (4.8, DUCK), (6.0, SLASH), (7.3, GUARD)],
        );
        [in_front, beside_the_golem, behind]
    }
}

/// The blue of the heroes.
const BLUE: u32 = 0x2456c8;

/// The middle of somebody's chest, in the space of the chest.
pub(super) const HEART: Vec3 = Vec3::new(0.0, 0.3, 0.0);
