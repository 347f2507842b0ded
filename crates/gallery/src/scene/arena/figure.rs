//! Figures of the arena: a skeleton of rigid parts, poses, and a part in the fight played at a fixed rate
//! into keyframes.
//!
//! A figure faces +Z, its right hand is at -X, limbs hang along -Y. Angles are radians.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, EulerRot, Quat, Vec2, Vec3};
use sheer_scene::model::{Animation, Channel, Influence, Interpolation, Keys, Track};

use crate::{builder::SceneBuilder, shape::Model};

/// The clip starts anew after this time.
pub(super) const CLIP_SECS: f32 = 10.0;
/// Keys a second: a strike of 0.15 s still gets three.
const KEYS_PER_SEC: u32 = 20;
const KEY_COUNT: u32 = CLIP_SECS as u32 * KEYS_PER_SEC + 1;

/// Joints by index; [`ROOT`] is a point on the ground.
pub(super) const ROOT: usize = 0;
const HIPS: usize = 1;
pub(super) const CHEST: usize = 2;
pub(super) const HEAD: usize = 3;
/// Upper arm and forearm, thigh and shin, right then left.
const ARM: [usize; 2] = [4, 6];
pub(super) const RIGHT_HAND: usize = 5;
pub(super) const LEFT_HAND: usize = 7;
const LEG: [usize; 2] = [8, 10];
const JOINT_COUNT: usize = 12;
const PARENT: [usize; JOINT_COUNT] = [ROOT, ROOT, HIPS, CHEST, CHEST, 4, CHEST, 6, HIPS, 8, HIPS, 10];
const JOINT_NAMES: [&str; JOINT_COUNT] = [
    "root",
    "hips",
    "chest",
    "head",
    "right arm",
    "right hand",
    "left arm",
    "left hand",
    "right thigh",
    "right shin",
    "left thigh",
    "left shin",
];
/// Joints of a cape, from the shoulders down.
const CAPE_JOINTS: usize = 4;

/// Lengths of a skeleton in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Build {
    pub(super) thigh: f32,
    pub(super) shin: f32,
    /// Reach of the foot from the ankle forwards to the toes and back to the heel; it is one with its shin.
    pub(super) toe: f32,
    pub(super) heel: f32,
    /// Half the distance of the hip joints, and of the shoulders.
    pub(super) hip: f32,
    pub(super) shoulder: f32,
    /// Height of the shoulders and of the neck above the hips.
    pub(super) shoulder_height: f32,
    pub(super) neck: f32,
    /// How far the neck lies in front of the spine.
    pub(super) stoop: f32,
    pub(super) upper_arm: f32,
}

/// What hangs on the joints, each part in the space of its joint.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) build: Build,
    pub(super) hips: Model,
    pub(super) chest: Model,
    pub(super) head: Model,
    /// Right then left: upper and lower part.
    pub(super) arms: [[Model; 2]; 2],
    pub(super) legs: [[Model; 2]; 2],
    /// A cape in the space of the chest, and its length.
    pub(super) cape: Option<(Model, f32)>,
}

/// Angles of an arm or a leg.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Limb {
    pub(super) forward: f32,
    /// Swing away from the body, to the side.
    pub(super) out: f32,
    /// Bend of elbow or knee.
    pub(super) flex: f32,
}

/// Angles of a whole figure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pose {
    /// Of the chest: how far it leans forwards, and how far it turns to the figure's left.
    pub(super) lean: f32,
    pub(super) turn: f32,
    /// How far the head looks down.
    pub(super) nod: f32,
    /// The right arm, then the left.
    pub(super) arms: [Limb; 2],
    pub(super) legs: [Limb; 2],
}

pub(super) const fn limb(forward: f32, out: f32, flex: f32) -> Limb {
    Limb { forward, out, flex }
}

impl Limb {
    fn mix(self, to: Self, s: f32) -> Self {
        let mix = |from: f32, to: f32| from + (to - from) * s;
        Self {
            forward: mix(self.forward, to.forward),
            out: mix(self.out, to.out),
            flex: mix(self.flex, to.flex),
        }
    }
}

impl Pose {
    fn mix(self, to: Self, s: f32) -> Self {
        let mix = |from: f32, to: f32| from + (to - from) * s;
        Self {
            lean: mix(self.lean, to.lean),
            turn: mix(self.turn, to.turn),
            nod: mix(self.nod, to.nod),
            arms: [0, 1].map(|side| self.arms[side].mix(to.arms[side], s)),
            legs: [0, 1].map(|side| self.legs[side].mix(to.legs[side], s)),
        }
    }
}

/// Poses with seconds since the start of a move.
pub(super) type Move = &'static [(f32, Pose)];

/// A figure's part in the fight.
pub(super) struct Part<'a> {
    /// Where it stands when: seconds, x, z. Between marks that differ it walks; the last is the first, since
    /// the clip loops.
    pub(super) marks: &'a [(f32, f32, f32)],
    /// The point on the ground that it faces: seconds, x, z.
    pub(super) gaze: &'a [(f32, f32, f32)],
    /// How it stands when nothing happens.
    pub(super) guard: Pose,
    /// When a move begins, and which; it ends in the guard.
    pub(super) moves: &'a [(f32, Move)],
    /// Shifts its breath against that of others, in turns.
    pub(super) phase: f32,
}

/// A figure on stage.
#[derive(Clone, Debug)]
pub(super) struct Actor {
    /// The node that stands where it stands.
    pub(super) root: u32,
    /// World from joint at each key.
    keys: Vec<[Affine3A; JOINT_COUNT]>,
    moves: Vec<(f32, Move)>,
}

impl Actor {
    /// A point in the space of a joint, in world.
    pub(super) fn point(&self, joint: usize, offset: Vec3, time_secs: f32) -> Vec3 {
        let at = time_secs.rem_euclid(CLIP_SECS) * KEYS_PER_SEC as f32;
        let before = (at as usize).min(self.keys.len() - 2);
        let [from, to] = [before, before + 1].map(|key| self.keys[key][joint].transform_point3(offset));
        from.lerp(to, at - before as f32)
    }

    /// When it begins this move.
    pub(super) fn starts(&self, wanted: Move) -> impl Iterator<Item = f32> {
        self.moves.iter().filter(move |(_, own)| *own == wanted).map(|(start, _)| *start)
    }

    /// Lets a node go where the figure goes, upright, `height` above the ground.
    pub(super) fn follow(&self, node: u32, height: f32) -> Channel {
        let values = self.keys.iter().map(|key| Vec3::from(key[ROOT].translation) + Vec3::Y * height);
        Channel { node, track: Track::Translation(baked(values.collect())) }
    }
}

/// A key of the clip each, straight between.
fn baked<T>(values: Vec<T>) -> Keys<T> {
    let times_secs = (0..KEY_COUNT).map(time_of_key).collect();
    Keys { times_secs, values, interpolation: Interpolation::Linear }
}

fn time_of_key(key: u32) -> f32 {
    key as f32 / KEYS_PER_SEC as f32
}

/// Smooth from one mark to the next, held outside.
fn along(marks: &[(f32, f32, f32)], time_secs: f32) -> Vec2 {
    let next = marks.partition_point(|mark| mark.0 <= time_secs);
    let at = |index: usize| Vec2::new(marks[index].1, marks[index].2);
    if next == 0 || next == marks.len() {
        return at(next.saturating_sub(1));
    }
    let s = (time_secs - marks[next - 1].0) / (marks[next].0 - marks[next - 1].0);
    at(next - 1).lerp(at(next), s * s * (3.0 - 2.0 * s))
}

impl Part<'_> {
    /// The pose without what walking adds.
    fn pose(&self, time_secs: f32) -> Pose {
        let begun = self.moves.iter().rev().find(|(start, _)| *start <= time_secs);
        let mut pose = self.guard;
        if let Some((start, keys)) = begun {
            let since = time_secs - start;
            let mut before = (0.0, self.guard);
            for &key in *keys {
                if since < key.0 {
                    let s = (since - before.0) / (key.0 - before.0);
                    pose = before.1.mix(key.1, s * s * (3.0 - 2.0 * s));
                    break;
                }
                before = key;
            }
        }
        // Five breaths a clip, so that it loops.
        let breath = (TAU * (5.0 * time_secs / CLIP_SECS + self.phase)).sin();
        pose.lean += 0.025 * breath;
        for arm in &mut pose.arms {
            arm.out += 0.02 * breath;
            arm.flex += 0.03 * breath;
        }
        pose
    }

    /// Local transforms of all joints at each key, and how fast the figure goes forwards.
    fn play(&self, build: &Build) -> Vec<([(Vec3, Quat); JOINT_COUNT], f32)> {
        let step_secs = 1.0 / KEYS_PER_SEC as f32;
        let mut travelled = 0.0;
        let play = |key| {
            let time_secs = time_of_key(key);
            let [before, here, after] =
                [-0.5, 0.0, 0.5].map(|s| along(self.marks, time_secs + s * step_secs));
            let towards = along(self.gaze, time_secs) - here;
            let heading = towards.normalize_or(Vec2::Y);
            let velocity = (after - before) / step_secs;
            let speed = velocity.dot(heading);
            // A step takes about 0.7 m, whatever the size of the pace.
            travelled += (velocity.length() * step_secs).copysign(speed);
            let stride = (velocity.length() / (1.2 * (build.thigh + build.shin))).min(1.0);
            let mut pose = self.pose(time_secs);
            let pace = PI * travelled / (0.8 * (build.thigh + build.shin));
            pose.lean += 0.12 * stride.copysign(speed);
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                let (swing, lift) = (sign * pace.sin(), (sign * pace.cos()).max(0.0));
                let walking = limb(0.55 * swing + 0.1, 0.03, 0.2 + 0.8 * lift);
                pose.legs[side] = pose.legs[side].mix(walking, stride);
                pose.arms[side].forward -= 0.25 * stride * swing;
            }
            (local_transforms(build, &pose, here, heading), speed)
        };
        (0..KEY_COUNT).map(play).collect()
    }
}

fn local_transforms(build: &Build, pose: &Pose, at: Vec2, heading: Vec2) -> [(Vec3, Quat); JOINT_COUNT] {
    // The lower foot stands on the ground, on its toes or its heel.
    let reach = |leg: &Limb| {
        let (sin, cos) = (leg.forward - leg.flex).sin_cos();
        let sole = (-build.toe * sin).max(build.heel * sin);
        leg.out.cos() * (build.thigh * leg.forward.cos() + build.shin * cos + sole)
    };
    let hip_height = reach(&pose.legs[0]).max(reach(&pose.legs[1]));
    let bend = |angle: f32| Quat::from_rotation_x(angle);
    let mut joints = [(Vec3::ZERO, Quat::IDENTITY); JOINT_COUNT];
    joints[ROOT] = (Vec3::new(at.x, 0.0, at.y), Quat::from_rotation_y(heading.x.atan2(heading.y)));
    // Part of a lean is in the hips.
    joints[HIPS] = (Vec3::Y * hip_height, Quat::from_rotation_y(0.3 * pose.turn));
    joints[CHEST] = (Vec3::ZERO, Quat::from_euler(EulerRot::YXZ, 0.7 * pose.turn, pose.lean, 0.0));
    joints[HEAD] = (Vec3::new(0.0, build.neck, build.stoop), bend(pose.nod - 0.7 * pose.lean));
    for (side, sign) in [(0, -1.0), (1, 1.0)] {
        let (arm, leg) = (&pose.arms[side], &pose.legs[side]);
        let swing = |limb: &Limb| Quat::from_euler(EulerRot::ZXY, sign * limb.out, -limb.forward, 0.0);
        joints[ARM[side]] = (Vec3::new(sign * build.shoulder, build.shoulder_height, 0.0), swing(arm));
        joints[ARM[side] + 1] = (Vec3::Y * -build.upper_arm, bend(-arm.flex));
        joints[LEG[side]] = (Vec3::X * (sign * build.hip), swing(leg));
        joints[LEG[side] + 1] = (Vec3::Y * -build.thigh, bend(leg.flex));
    }
    joints
}

/// Adds a figure with its joints, hangs its parts on them and bakes the moves of its part into keys.
pub(super) fn enter(builder: &mut SceneBuilder, name: &str, body: Body, part: &Part<'_>) -> Actor {
    let played = part.play(&body.build);
    let mut nodes = [0; JOINT_COUNT];
    for joint in 0..JOINT_COUNT {
        let parent = (joint != ROOT).then(|| nodes[PARENT[joint]]);
        nodes[joint] =
            builder.joint(&format!("{name}: {}", JOINT_NAMES[joint]), parent, played[0].0[joint].0);
    }
    let mut channels = Vec::new();
    for joint in 0..JOINT_COUNT {
        let rotations = played.iter().map(|(joints, _)| joints[joint].1).collect();
        channels.push(Channel { node: nodes[joint], track: Track::Rotation(baked(rotations)) });
        if joint == ROOT || joint == HIPS {
            let translations = played.iter().map(|(joints, _)| joints[joint].0).collect();
            channels.push(Channel { node: nodes[joint], track: Track::Translation(baked(translations)) });
        }
    }
    let [right_arm, left_arm] = body.arms;
    let [right_leg, left_leg] = body.legs;
    let limbs = [right_arm, left_arm, right_leg, left_leg].into_iter().flatten();
    let parts = [body.hips, body.chest, body.head].into_iter().chain(limbs);
    for (joint, model) in (HIPS..).zip(parts) {
        let prop = builder.prop(&format!("{name}: {}", JOINT_NAMES[joint]), model);
        builder.hang(&prop, nodes[joint]);
    }
    if let Some(cape) = body.cape {
        let speeds: Vec<f32> = played.iter().map(|(_, speed)| *speed).collect();
        let top = Vec3::new(0.0, body.build.shoulder_height + 0.03, -0.15);
        channels.extend(wear_cape(builder, name, cape, (nodes[CHEST], top), &speeds, part.phase));
    }
    builder.animate(Animation { name: name.to_owned(), channels, properties: Vec::new() });
    let world = |(joints, _): &([(Vec3, Quat); JOINT_COUNT], f32)| {
        let mut world = [Affine3A::IDENTITY; JOINT_COUNT];
        for (joint, &(translation, rotation)) in joints.iter().enumerate() {
            let parent = if joint == ROOT { Affine3A::IDENTITY } else { world[PARENT[joint]] };
            world[joint] = parent * Affine3A::from_rotation_translation(rotation, translation);
        }
        world
    };
    Actor { root: nodes[ROOT], keys: played.iter().map(world).collect(), moves: part.moves.to_vec() }
}

/// A cape of a length, hung up at a point in the space of the chest, bends along a chain of joints: it trails
/// behind a figure that runs, and sways.
fn wear_cape(
    builder: &mut SceneBuilder,
    name: &str,
    (model, length): (Model, f32),
    (chest, top): (u32, Vec3),
    speeds: &[f32],
    phase: f32,
) -> Vec<Channel> {
    let link = length / (CAPE_JOINTS - 1) as f32;
    let origins: Vec<Vec3> = (0..CAPE_JOINTS).map(|joint| top - Vec3::Y * (link * joint as f32)).collect();
    let mut joints: Vec<u32> = Vec::new();
    for _ in 0..CAPE_JOINTS {
        let (parent, offset) = joints.last().map_or((chest, top), |&above| (above, Vec3::Y * -link));
        joints.push(builder.joint(&format!("{name}: cape"), Some(parent), offset));
    }
    let channels = joints.iter().enumerate().map(|(joint, &node)| {
        let sway = |key: usize| {
            let time_secs = time_of_key(key as u32);
            // Four sways a clip; each joint lags behind the one above it.
            let turn = 4.0 * time_secs / CLIP_SECS + phase - 0.14 * joint as f32;
            // Cloth follows with a delay of a fifth of a second a joint.
            let lagged = speeds[key.saturating_sub(joint * KEYS_PER_SEC as usize / 5)];
            let trail = (0.35 * lagged).clamp(-0.1, 0.75);
            let hang = if joint == 0 { 0.22 + trail } else { 0.02 + 0.15 * trail };
            Quat::from_euler(EulerRot::XZY, hang + 0.09 * (TAU * turn).sin(), 0.06 * (TAU * turn).cos(), 0.0)
        };
        let rotations = (0..speeds.len()).map(sway).collect();
        Channel { node, track: Track::Rotation(baked(rotations)) }
    });
    let channels: Vec<Channel> = channels.collect();
    builder.drape(&format!("{name}: cape"), model, joints, &origins, |position| {
        let at = ((top.y - position.y) / link).clamp(0.0, (CAPE_JOINTS - 1) as f32);
        let above = (at as usize).min(CAPE_JOINTS - 2);
        let share = at - above as f32;
        let pull = |joint: usize, weight| Influence { joint: joint as u16, weight };
        [pull(above, 1.0 - share), pull(above + 1, share), Influence::default(), Influence::default()]
    });
    channels
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUILD: Build = Build {
        thigh: 0.45,
        shin: 0.45,
        toe: 0.2,
        heel: 0.1,
        hip: 0.1,
        shoulder: 0.2,
        shoulder_height: 0.5,
        neck: 0.6,
        stoop: 0.0,
        upper_arm: 0.3,
    };

    #[test]
    fn arms_rise_forwards_and_outwards_and_a_foot_stays_on_the_ground() {
        let pose = Pose {
            arms: [limb(PI / 2.0, 0.0, 0.0), limb(0.0, PI / 2.0, 0.0)],
            legs: [limb(0.6, 0.0, 0.9), limb(-0.3, 0.0, 0.2)],
            ..Pose::default()
        };
        let joints = local_transforms(&BUILD, &pose, Vec2::ZERO, Vec2::Y);
        let hand = |side: usize| joints[ARM[side]].1 * -Vec3::Y;
        assert!(hand(0).distance(Vec3::Z) < 1e-5 && hand(1).distance(Vec3::X) < 1e-5);
        let foot = |side: usize| {
            let (thigh, shin) = (joints[LEG[side]].1, joints[LEG[side] + 1].1);
            let sole = |along: f32| {
                let point = shin * Vec3::new(0.0, -BUILD.shin, along);
                joints[HIPS].0.y + (thigh * (joints[LEG[side] + 1].0 + point)).y
            };
            sole(BUILD.toe).min(sole(-BUILD.heel))
        };
        assert!(foot(0).min(foot(1)).abs() < 1e-5, "{} {}", foot(0), foot(1));
    }

    #[test]
    fn a_part_holds_its_guard_before_and_after_a_move() {
        let raised = Pose { lean: 1.0, ..Pose::default() };
        let nod: Move = Box::leak(Box::new([(0.5, raised), (1.0, Pose::default())]));
        let moves: &[(f32, Move)] = &[(2.0, nod)];
        let marks = &[(0.0, 0.0, 0.0), (10.0, 0.0, 0.0)];
        let part = Part { marks, gaze: marks, guard: Pose::default(), moves, phase: 0.0 };
        assert!((part.pose(2.5).lean - 1.0).abs() < 0.03);
        for time_secs in [0.0, 1.9, 3.1, 9.0] {
            assert!(part.pose(time_secs).lean.abs() < 0.03, "{time_secs}");
        }
    }
}
