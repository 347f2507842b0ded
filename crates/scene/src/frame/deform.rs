//! Morphing and skinning on the CPU.

use glam::{Affine3A, Mat3, Vec3, Vec4};

use super::{
    footprint::evening_power,
    pose::{NodePose, instance_moves, moving_nodes},
    property::Properties,
    storage::MorphedAttributes,
};
use crate::model::{Instance, SceneParts};

/// The matrix that takes normals along with an affine map; also right for mirrored and flattened ones.
///
/// Its scale is arbitrary, but never such that lengths vanish.
pub(super) fn normal_matrix(vector_from_object: Mat3) -> Mat3 {
    let Mat3 { x_axis, y_axis, z_axis } = vector_from_object;
    let vector_from_object = vector_from_object * evening_power(x_axis.abs().max(y_axis.abs()), z_axis);
    let Mat3 { x_axis, y_axis, z_axis } = vector_from_object;
    // The cofactor matrix: inverse transpose times the determinant, without dividing by it.
    let cofactors = Mat3::from_cols(y_axis.cross(z_axis), z_axis.cross(x_axis), x_axis.cross(y_axis));
    if vector_from_object.determinant() < 0.0 { -cofactors } else { cofactors }
}

/// The morph weights of an instance at the moment.
fn morph_weights<'a>(instance: &'a Instance, pose: &'a NodePose) -> &'a [f32] {
    pose.morph_weights.get(&instance.node).unwrap_or(&instance.morph_weights)
}

/// Colours and texture coordinates of an instance, if its mesh morphs any.
pub(super) fn morph_attributes(parts: &SceneParts, pose: &NodePose, index: u32) -> Option<MorphedAttributes> {
    let instance = &parts.instances[index as usize];
    let mesh = &parts.meshes[instance.mesh as usize];
    let targets = &mesh.morph_targets;
    let mut morphed = MorphedAttributes::default();
    if targets.iter().any(|target| !target.colours.is_empty()) {
        morphed.colours.clone_from(&mesh.colours);
    }
    if targets.iter().any(|target| target.uv_sets.iter().any(|set| !set.is_empty())) {
        morphed.uv_sets.clone_from(&mesh.uv_sets);
    }
    if morphed == MorphedAttributes::default() {
        return None;
    }
    let weights = morph_weights(instance, pose);
    for (target, &weight) in targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        let colours = morphed.colours.iter_mut().zip(&target.colours);
        colours.for_each(|(colour, delta)| *colour += *delta * weight);
        for (set, deltas) in morphed.uv_sets.iter_mut().zip(&target.uv_sets) {
            set.iter_mut().zip(deltas).for_each(|(uv, delta)| *uv += *delta * weight);
        }
    }
    let in_range = |colour: Vec4| colour.max(Vec4::ZERO).min(Vec3::MAX.extend(1.0));
    morphed.colours.iter_mut().for_each(|colour| *colour = in_range(*colour));
    Some(morphed)
}

/// World positions of a morphed and skinned instance; its unit normals, and behind them the directions of its
/// tangents, are appended to `normals`.
pub(super) fn deform(
    parts: &SceneParts,
    pose: &NodePose,
    index: u32,
    world_from_object: Affine3A,
    normals: &mut Vec<Vec3>,
) -> Vec<Vec3> {
    let instance = &parts.instances[index as usize];
    let mesh = &parts.meshes[instance.mesh as usize];
    let weights = morph_weights(instance, pose);

    let mut positions = mesh.positions.clone();
    let mut own_normals = mesh.normals.clone();
    let mut own_tangents: Vec<Vec3> = mesh.tangents.iter().map(|tangent| tangent.truncate()).collect();
    for (target, &weight) in mesh.morph_targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        positions
            .iter_mut()
            .zip(&target.positions)
            .for_each(|(position, delta)| *position += *delta * weight);
        own_normals.iter_mut().zip(&target.normals).for_each(|(normal, delta)| *normal += *delta * weight);
        own_tangents
            .iter_mut()
            .zip(&target.tangents)
            .for_each(|(tangent, delta)| *tangent += *delta * weight);
    }

    let joints = instance.skin.map_or(&[][..], |skin| &pose.joints[skin as usize]);
    let rigid = normal_matrix(Mat3::from(world_from_object.matrix3));
    let bend = |vector_from_object: Mat3, tangent: Option<&mut Vec3>| {
        if let Some(tangent) = tangent {
            *tangent = (vector_from_object * *tangent).normalize_or_zero();
        }
    };
    for (vertex, position) in positions.iter_mut().enumerate() {
        let (normal, tangent) = (own_normals.get_mut(vertex), own_tangents.get_mut(vertex));
        let per_vertex = mesh.influences_per_vertex;
        if joints.is_empty() || per_vertex == 0 {
            *position = world_from_object.transform_point3(*position);
            if let Some(normal) = normal {
                *normal = (rigid * *normal).normalize_or_zero();
            }
            bend(Mat3::from(world_from_object.matrix3), tangent);
            continue;
        }
        let influences = &mesh.influences[vertex * per_vertex..][..per_vertex];
        let mut blended = Affine3A::ZERO;
        for influence in influences {
            let joint = &joints[usize::from(influence.joint)];
            blended.matrix3 += joint.matrix3 * influence.weight;
            blended.translation += joint.translation * influence.weight;
        }
        *position = blended.transform_point3(*position);
        if let Some(normal) = normal {
            *normal = (normal_matrix(Mat3::from(blended.matrix3)) * *normal).normalize_or_zero();
        }
        bend(Mat3::from(blended.matrix3), tangent);
    }
    normals.extend(own_normals);
    normals.extend(own_tangents);
    positions
}

/// Calls `visit` with the world position of each vertex of each instance at each of the times at which it is
/// shown, of those that never move once.
pub(crate) fn for_each_vertex_over_time(
    parts: &SceneParts,
    times_secs: &[f32],
    visit: &mut impl FnMut(Vec3),
) {
    let node_moves = moving_nodes(parts);
    let mut are_visited = vec![false; parts.instances.len()];
    for &time_secs in times_secs {
        let pose = NodePose::at(parts, time_secs);
        let properties = Properties::at(parts, time_secs);
        for (index, instance) in parts.instances.iter().enumerate() {
            let is_known = are_visited[index] && !instance_moves(parts, &node_moves, index as u32);
            if is_known || properties.hides(instance.node) {
                continue;
            }
            are_visited[index] = true;
            let mesh = &parts.meshes[instance.mesh as usize];
            let world_from_object = pose.world_from_node[instance.node as usize] * instance.node_from_object;
            if instance.skin.is_some() || !mesh.morph_targets.is_empty() {
                deform(parts, &pose, index as u32, world_from_object, &mut Vec::new())
                    .into_iter()
                    .for_each(&mut *visit);
            } else {
                mesh.positions
                    .iter()
                    .for_each(|&position| visit(world_from_object.transform_point3(position)));
            }
        }
    }
}
