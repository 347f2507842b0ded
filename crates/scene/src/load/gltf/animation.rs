//! Animations: the first one, and every further one that moves nothing moved already.

use std::collections::HashSet;

use glam::{Quat, Vec3};

use super::{
    document::Document,
    node::{Hierarchy, unit_rotation},
    schema::{self, Index},
};
use crate::{
    SceneError,
    load::LoadWarning,
    model::{Animation, Channel, Interpolation, Keys, Node, Track, Transform},
};

/// The animations that play together. Nodes with a matrix that are animated get their transform taken apart.
pub(super) fn read(
    document: &Document<'_>,
    hierarchy: &Hierarchy,
    nodes: &mut [Node],
) -> Result<Vec<Animation>, SceneError> {
    let mut taken: HashSet<(Index, &str)> = HashSet::new();
    let mut animations = Vec::new();
    for (index, animation) in document.root.animations.iter().enumerate() {
        let place = format!("animations[{index}]");
        let targets = || {
            animation
                .channels
                .iter()
                .filter_map(|channel| Some((channel.target.node?, channel.target.path.as_str())))
        };
        if targets().any(|target| taken.contains(&target)) {
            document.warn(LoadWarning::AnimationSkipped { place: document.titled(&place) });
            continue;
        }
        let mut channels = Vec::with_capacity(animation.channels.len());
        for (number, channel) in animation.channels.iter().enumerate() {
            let place = format!("{place}.channels[{number}]");
            let Some(node) = channel.target.node else { continue };
            let sorted = hierarchy.sorted(document, node, &place);
            let Some(sorted) = document.salvage(sorted, "left out")? else { continue };
            if !taken.insert((node, &channel.target.path)) {
                document.repaired(&place, "another channel moves the same property: left out");
                continue;
            }
            let track = read_track(document, animation, channel, node, &place);
            let Some(track) = document.salvage(track, "left out")?.flatten() else { continue };
            if !matches!(track, Track::MorphWeights(_)) {
                take_apart(document, &mut nodes[sorted as usize], &place);
            }
            channels.push(Channel { node: sorted, track });
        }
        if !channels.is_empty() {
            animations.push(Animation { name: animation.name.clone().unwrap_or_default(), channels });
        }
    }
    Ok(animations)
}

fn read_track(
    document: &Document<'_>,
    animation: &schema::Animation,
    channel: &schema::AnimationChannel,
    node: Index,
    place: &str,
) -> Result<Option<Track>, SceneError> {
    let sampler = document.get(&animation.samplers, channel.sampler, "animation sampler", place)?;
    let interpolation = match sampler.interpolation.as_deref() {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        Some(other) => {
            let problem =
                format!("interpolation '{other}' is not LINEAR, STEP or CUBICSPLINE; export the file again");
            return Err(document.fault(place, problem));
        }
    };
    let values_per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let times_secs = key_times(document, sampler.input, place)?;
    let value_count = times_secs.len() * values_per_key;
    let output = Output { document, accessor: sampler.output, value_count, place };
    Ok(Some(match channel.target.path.as_str() {
        "translation" => {
            let values = output.values(<Vec3 as From<[f32; 3]>>::from)?;
            Track::Translation(Keys { times_secs, values, interpolation })
        }
        "scale" => {
            let values = output.values(<Vec3 as From<[f32; 3]>>::from)?;
            Track::Scale(Keys { times_secs, values, interpolation })
        }
        "rotation" => {
            let mut values = output.values(Quat::from_array)?;
            // Tangents, which stand before and after each spline key, have any length.
            let keys = values.iter_mut().skip(values_per_key / 2).step_by(values_per_key);
            keys.for_each(|value| *value = unit_rotation(document, value.to_array(), place));
            Track::Rotation(Keys { times_secs, values, interpolation })
        }
        "weights" => {
            let Some(target_count) = morph_target_count(document, node) else {
                document
                    .repaired(place, "it moves the morph weights of a node without morph targets: left out");
                return Ok(None);
            };
            let values = output.weights(target_count)?;
            Track::MorphWeights(Keys { times_secs, values, interpolation })
        }
        // `KHR_animation_pointer`, which is warned about as an extension.
        "pointer" => return Ok(None),
        other => {
            document.repaired(place, &format!("it moves the unknown property '{other}': left out"));
            return Ok(None);
        }
    }))
}

/// Key times made strictly increasing: keys at one time, a common way to write a jump, are moved apart by the
/// least bits.
fn key_times(document: &Document<'_>, accessor: Index, place: &str) -> Result<Vec<f32>, SceneError> {
    let mut times = document.scalars(accessor, place)?;
    if times.is_empty() {
        return Err(
            document.fault(place, format!("accessor {accessor} holds no key times; export the file again"))
        );
    }
    // What the file says, and what became of it.
    let (mut last_read, mut last) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
    for (key, time) in times.iter_mut().enumerate() {
        let is_sound = time.is_finite() && *time >= last_read;
        last_read = *time;
        if is_sound && *time <= last {
            *time = last.next_up();
            document.repaired(place, "keys at the same time were moved apart");
        }
        if !is_sound {
            let problem = format!(
                "key {key} of accessor {accessor} is not later than the one before it; sort the keys and export the file again"
            );
            return Err(document.fault(place, problem));
        }
        last = *time;
    }
    Ok(times)
}

/// How many weights the mesh at a node has; `None` without a mesh or targets.
fn morph_target_count(document: &Document<'_>, node: Index) -> Option<usize> {
    let mesh = document.root.meshes.get(document.root.nodes.get(node)?.mesh?)?;
    mesh.primitives.first().map(|primitive| primitive.targets.len()).filter(|&count| count > 0)
}

/// The values of a sampler.
struct Output<'d, 'a> {
    document: &'d Document<'a>,
    accessor: Index,
    value_count: usize,
    place: &'d str,
}

impl Output<'_, '_> {
    fn values<const N: usize, T>(&self, convert: impl Fn([f32; N]) -> T) -> Result<Vec<T>, SceneError> {
        let values = self.document.floats::<N>(self.accessor, self.place)?;
        self.check_count(values.len(), self.value_count)?;
        self.check_finite(values.iter().flatten())?;
        Ok(values.into_iter().map(convert).collect())
    }

    /// One list of weights a value.
    fn weights(&self, target_count: usize) -> Result<Vec<Vec<f32>>, SceneError> {
        let values = self.document.scalars(self.accessor, self.place)?;
        self.check_count(values.len(), self.value_count.saturating_mul(target_count))?;
        self.check_finite(&values)?;
        self.document.charge(
            self.value_count,
            size_of::<Vec<f32>>() + target_count * size_of::<f32>(),
            self.place,
        )?;
        Ok(values.chunks_exact(target_count).map(<[f32]>::to_vec).collect())
    }

    fn check_count(&self, found: usize, wanted: usize) -> Result<(), SceneError> {
        if found == wanted {
            return Ok(());
        }
        let problem = format!(
            "accessor {} holds {found} values where its keys need {wanted}; export the file again",
            self.accessor
        );
        Err(self.document.fault(self.place, problem))
    }

    fn check_finite<'v>(&self, values: impl IntoIterator<Item = &'v f32>) -> Result<(), SceneError> {
        if values.into_iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        let problem = format!(
            "accessor {} holds a value that is not finite; repair the animation and export the file again",
            self.accessor
        );
        Err(self.document.fault(self.place, problem))
    }
}

/// Makes the transform of a node one that can be animated.
fn take_apart(document: &Document<'_>, node: &mut Node, place: &str) {
    if let Transform::Matrix(matrix) = node.transform {
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        let transform = Transform::Trs { translation, rotation, scale };
        node.transform = if transform.to_affine().is_finite() { transform } else { Transform::IDENTITY };
        document.repaired(place, "it moves a node with a matrix, which was taken apart");
    }
}
