//! Where nodes and cameras are at a time.

use std::collections::HashMap;

use glam::{Affine3A, Quat};

use crate::{
    camera::{Camera, CameraMotion, CameraPose, Lens},
    model::{LensNumber, Property, SceneParts, Track, Transform},
};

/// All nodes at one moment.
pub(super) struct NodePose {
    pub(super) world_from_node: Vec<Affine3A>,
    /// `world_from_object` in the pose of each joint of each skin: many instances share one.
    pub(super) joints: Vec<Vec<Affine3A>>,
    /// Animated morph weights by node.
    pub(super) morph_weights: HashMap<u32, Vec<f32>>,
}

impl NodePose {
    pub(super) fn at(parts: &SceneParts, time_secs: f32) -> Self {
        let mut local: Vec<Transform> = parts.nodes.iter().map(|node| node.transform).collect();
        let mut morph_weights = HashMap::new();
        for animation in &parts.animations {
            let time_secs = animation.looped(time_secs);
            for channel in &animation.channels {
                match (&channel.track, &mut local[channel.node as usize]) {
                    (Track::Translation(keys), Transform::Trs { translation, .. }) => {
                        *translation = keys.value_at(time_secs);
                    }
                    (Track::Rotation(keys), Transform::Trs { rotation, .. }) => {
                        *rotation = unit(keys.value_at(time_secs));
                    }
                    (Track::Scale(keys), Transform::Trs { scale, .. }) => *scale = keys.value_at(time_secs),
                    (Track::MorphWeights(keys), _) => {
                        morph_weights.entry(channel.node).or_insert_with(|| keys.value_at(time_secs));
                    }
                    // Validation has refused animated matrices.
                    (_, Transform::Matrix(_)) => {}
                }
            }
        }
        let mut world_from_node: Vec<Affine3A> = Vec::with_capacity(parts.nodes.len());
        for (node, transform) in parts.nodes.iter().zip(local) {
            let parent = node.parent.map_or(Affine3A::IDENTITY, |parent| world_from_node[parent as usize]);
            world_from_node.push(parent * transform.to_affine());
        }
        let joints = parts.skins.iter().map(|skin| {
            let world_from_joint = skin.joints.iter().map(|&joint| world_from_node[joint as usize]);
            world_from_joint.zip(&skin.inverse_bind).map(|(world, bind)| world * *bind).collect()
        });
        let joints = joints.collect();
        Self { world_from_node, joints, morph_weights }
    }
}

/// A quaternion made unit again; the identity if it has no direction.
fn unit(rotation: Quat) -> Quat {
    if rotation.length_squared() > 1e-12 { rotation.normalize() } else { Quat::IDENTITY }
}

/// Which nodes an animation moves, directly or through a parent.
pub(super) fn moving_nodes(parts: &SceneParts) -> Vec<bool> {
    let mut moves = vec![false; parts.nodes.len()];
    for channel in parts.animations.iter().flat_map(|animation| &animation.channels) {
        moves[channel.node as usize] |= !matches!(channel.track, Track::MorphWeights(_));
    }
    for (index, node) in parts.nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            moves[index] |= moves[parent as usize];
        }
    }
    moves
}

/// Deformed instances always count as moving: their normals live with the frame.
pub(super) fn instance_moves(parts: &SceneParts, node_moves: &[bool], index: u32) -> bool {
    let instance = &parts.instances[index as usize];
    let mesh = &parts.meshes[instance.mesh as usize];
    instance.skin.is_some() || !mesh.morph_targets.is_empty() || node_moves[instance.node as usize]
}

/// The pose of a camera at a time, on whatever it moves.
pub(crate) fn camera_pose(parts: &SceneParts, camera: &Camera, time_secs: f32) -> CameraPose {
    if let Some(pose) = camera.pose_on_rails(time_secs) {
        return pose;
    }
    let CameraMotion::Node(node) = camera.motion else {
        unreachable!("only a camera on a node has no rails");
    };
    let world_from_node = NodePose::at(parts, time_secs).world_from_node[node as usize];
    let (_, rotation, translation) = world_from_node.to_scale_rotation_translation();
    let mut pose = CameraPose {
        world_from_camera: Affine3A::from_rotation_translation(unit(rotation), translation),
        lens: camera.lens,
        clip: camera.clip,
    };
    for animation in &parts.animations {
        let time_secs = animation.looped(time_secs);
        for property in &animation.properties {
            if let Property::Lens { cameras, which, value } = property
                && cameras.iter().any(|&index| parts.cameras[index as usize].name == camera.name)
            {
                set_lens(&mut pose, *which, value.value_at(time_secs));
            }
        }
    }
    pose.clip.far = pose.clip.far.max(pose.clip.near.next_up());
    pose
}

/// Sets a number of a camera, as near as it may be.
fn set_lens(pose: &mut CameraPose, which: LensNumber, value: f32) {
    /// Nothing is seen through a lens that is narrower; nearly half of all through one that is that much
    /// short of the widest.
    const NARROWEST: f32 = 1e-4;
    match (which, &mut pose.lens) {
        (LensNumber::FieldOfView, Lens::Perspective { yfov_rad }) => {
            *yfov_rad = value.clamp(NARROWEST, std::f32::consts::PI - NARROWEST);
        }
        (LensNumber::HalfHeight, Lens::Orthographic { half_height }) => {
            *half_height = value.abs().clamp(f32::MIN_POSITIVE, f32::MAX);
        }
        (LensNumber::Near, _) => pose.clip.near = value.clamp(0.0, f32::MAX),
        (LensNumber::Far, _) => pose.clip.far = value.max(0.0),
        (LensNumber::FieldOfView | LensNumber::HalfHeight, _) => {}
    }
}
