//! Deep shadow maps (Lokovic and Veach, *Deep Shadow Maps*, 2000): each texel keeps the visibility along its
//! ray as a piecewise linear function, compressed to a tolerance. One ray a texel; what the paper averages
//! over a texel's area is left to the filter of the lookup.

use glam::Vec3;
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use super::{
    blockers::record,
    projection::Projection,
    technique::{Map, RESOLUTION, Receiver, ShadowInfo, Technique, View},
};
use crate::{cost::Counters, stage::Stage};

/// The row of the technique in lists and help.
pub(super) const INFO: ShadowInfo = ShadowInfo {
    id: "deep-map",
    title: "a visibility function for each texel, compressed to a tolerance",
    paper: "Lokovic and Veach 2000, Deep Shadow Maps",
    works: &[&bibliography::LOKOVIC_VEACH_2000],
    bias: "up to the tolerance, and the filter's blur",
    parameters: &[
        RESOLUTION,
        ParameterInfo {
            key: "tolerance",
            default: "0.01",
            range: ParameterRange::Real(0.0, 0.5),
            what: "the most by which compression moves a visibility; 0 keeps every blocker",
        },
    ],
};

/// Texels whose visibilities a lookup mixes: neighbours, by their distance.
pub(super) const FILTER: u32 = 1;

/// Deep shadow maps of a resolution, compressed to a tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DeepMap {
    resolution: u32,
    tolerance: f32,
}

impl DeepMap {
    pub(super) fn new(values: &Values) -> Self {
        Self { resolution: values.count("resolution"), tolerance: values.real("tolerance") }
    }
}

impl Technique for DeepMap {
    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn texel_bytes(&self, channels: usize) -> usize {
        // A vertex or two are seldom too few for a mean.
        channels * (size_of::<u32>() + 2 * size_of::<Vertex>())
    }

    fn map(&self, view: &View<'_>) -> Box<dyn Map> {
        let projection = Projection::new(view.stage.frame(), view.light, self.resolution);
        // The depth of a vertex is never negative, so a negative one can head each function.
        let stream = record(view, &projection, |_, blockers, vertices| {
            for channel in 0..view.channels {
                vertices.push(Vertex { depth: -1.0, visibility: 1.0 });
                let steps =
                    blockers.transparent.iter().map(|blocker| (blocker.depth, blocker.through[channel]));
                let opaque = Some((blockers.opaque_depth, 0.0)).filter(|(depth, _)| depth.is_finite());
                compress(steps.chain(opaque), self.tolerance, vertices);
            }
        });
        let mut starts = Vec::with_capacity(projection.texels() * view.channels + 1);
        let mut vertices = Vec::with_capacity(stream.len());
        for vertex in stream {
            if vertex.depth < 0.0 {
                starts.push(vertices.len());
            } else {
                vertices.push(vertex);
            }
        }
        starts.push(vertices.len());
        Box::new(Functions { projection, channels: view.channels, starts, vertices })
    }

    fn values(&self) -> Vec<String> {
        vec![self.resolution.to_string(), self.tolerance.to_string()]
    }
}

/// A corner of a visibility function. Two at one depth are a step; the function is 1 before the first and
/// constant after the last.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Vertex {
    depth: f32,
    visibility: f32,
}

/// Slopes that keep a segment within the tolerance of all steps so far.
#[derive(Clone, Copy, Debug)]
struct Slopes {
    least: f32,
    most: f32,
}

impl Slopes {
    /// None rises: visibility never does. Being within the tolerance at the start, a level segment always is
    /// an answer to one more flat piece.
    const ANY: Self = Self { least: f32::NEG_INFINITY, most: 0.0 };

    /// Those that also pass a depth within the tolerance of a visibility.
    fn through(self, start: Vertex, depth: f32, visibility: f32, tolerance: f32) -> Option<Self> {
        let run = depth - start.depth;
        if run <= 0.0 {
            return ((start.visibility - visibility).abs() <= tolerance).then_some(self);
        }
        let slope = |end: f32| (end - start.visibility) / run;
        let least = self.least.max(slope(visibility - tolerance));
        let most = self.most.min(slope(visibility + tolerance));
        (least <= most).then_some(Self { least, most })
    }

    /// Where the middle one is at a depth.
    fn at(self, start: Vertex, depth: f32) -> Vertex {
        let slope = if self.least.is_finite() { 0.5 * (self.least + self.most) } else { 0.0 };
        Vertex { depth, visibility: start.visibility + slope * (depth - start.depth) }
    }
}

/// Appends a function that is nowhere farther than the tolerance from the one that `steps` (depth, share that
/// passes) make, with the greedy choice of segments of Lokovic and Veach (section 3.2). A step that no
/// segment can cross within the tolerance stays a step, and no light at all stays none.
fn compress(steps: impl Iterator<Item = (f32, f32)>, tolerance: f32, vertices: &mut Vec<Vertex>) {
    let mut truth = 1.0;
    let mut start = Vertex { depth: 0.0, visibility: 1.0 };
    let mut slopes = Slopes::ANY;
    let mut last_depth = 0.0;
    for (depth, through) in steps {
        // The flat piece before the step.
        slopes = slopes.through(start, depth, truth, tolerance).unwrap_or_else(|| {
            start = slopes.at(start, last_depth);
            vertices.push(start);
            Slopes::ANY.through(start, depth, truth, tolerance).unwrap_or(Slopes::ANY)
        });
        // The step.
        truth *= through;
        let crossing = if truth > 0.0 { slopes.through(start, depth, truth, tolerance) } else { None };
        slopes = crossing.unwrap_or_else(|| {
            vertices.push(slopes.at(start, depth));
            start = Vertex { depth, visibility: truth };
            vertices.push(start);
            Slopes::ANY
        });
        last_depth = depth;
    }
    if last_depth > start.depth {
        vertices.push(slopes.at(start, last_depth));
    }
}

/// Visibility in front of whatever is at a depth.
fn evaluate(function: &[Vertex], depth: f32) -> f32 {
    let next = function.partition_point(|vertex| vertex.depth < depth);
    let before =
        next.checked_sub(1).map_or(Vertex { depth: 0.0, visibility: 1.0 }, |before| function[before]);
    let Some(after) = function.get(next) else { return before.visibility };
    let share = (depth - before.depth) / (after.depth - before.depth);
    if share > 0.0 {
        before.visibility + share * (after.visibility - before.visibility)
    } else {
        before.visibility
    }
}

#[derive(Debug)]
struct Functions {
    projection: Projection,
    channels: usize,
    /// Where the function of each texel and channel starts, and the last one ends.
    starts: Vec<usize>,
    vertices: Vec<Vertex>,
}

impl Map for Functions {
    fn transmittance(&self, stage: &Stage, receiver: &Receiver, _: &mut Counters) -> Vec3 {
        self.projection.filter(stage, receiver, FILTER, |texel, depth| {
            let channel = |channel: usize| {
                let function = texel * self.channels + channel;
                evaluate(&self.vertices[self.starts[function]..self.starts[function + 1]], depth)
            };
            if self.channels == 1 {
                Vec3::splat(channel(0))
            } else {
                Vec3::from_array([0, 1, 2].map(channel))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use sheer_core::hash::Pcg32;

    use super::*;

    fn random_steps(count: u32, seed: u64) -> Vec<(f32, f32)> {
        let mut random = Pcg32::new(seed, 0);
        let mut depth = 1.0;
        let step = |_| {
            // Some share a depth.
            depth += if random.below(4) == 0 { 0.0 } else { random.next_f32() };
            (depth, if random.below(8) == 0 { 0.3 } else { random.range(0.9, 1.0) })
        };
        (0..count).map(step).collect()
    }

    fn truth(steps: &[(f32, f32)], depth: f32) -> f32 {
        steps.iter().filter(|step| step.0 < depth).map(|step| step.1).product()
    }

    /// The largest error just before and just after each step, and between steps.
    fn worst(steps: &[(f32, f32)], function: &[Vertex]) -> f32 {
        let depths = steps.iter().flat_map(|step| [step.0, step.0 * (1.0 + 1e-6), step.0 + 0.07]);
        let ends = [0.0, 0.5, 1e6];
        let error = |depth: f32| (evaluate(function, depth) - truth(steps, depth)).abs();
        depths.chain(ends).map(error).fold(0.0, f32::max)
    }

    fn compressed(steps: &[(f32, f32)], tolerance: f32) -> Vec<Vertex> {
        let mut vertices = Vec::new();
        compress(steps.iter().copied(), tolerance, &mut vertices);
        vertices
    }

    #[test]
    fn compression_keeps_its_tolerance_and_saves_vertices() {
        for seed in 0..200 {
            let steps = random_steps(60, seed);
            let mut sizes = Vec::new();
            for tolerance in [0.0, 0.01, 0.05, 0.2] {
                let function = compressed(&steps, tolerance);
                // What is compared is rounded to 32 bits.
                let error = worst(&steps, &function);
                assert!(error <= tolerance + 1e-4, "seed {seed}, tolerance {tolerance}: {error}");
                let falls = function.windows(2).all(|pair| {
                    pair[0].depth <= pair[1].depth && pair[0].visibility >= pair[1].visibility - 0.2
                });
                assert!(falls, "{function:?}");
                sizes.push(function.len());
            }
            assert!(sizes[3] < sizes[1] && sizes[3] * 4 < sizes[0], "{sizes:?}");
        }
        // Negative control: a function without its middle vertex is found out.
        let steps = random_steps(60, 0);
        let mut damaged = compressed(&steps, 0.01);
        damaged.remove(damaged.len() / 2);
        assert!(worst(&steps, &damaged) > 0.02, "the check is blind");
    }

    #[test]
    fn nothing_passes_an_opaque_surface() {
        let function = compressed(&[(1.0, 0.995), (2.0, 0.995), (3.0, 0.0)], 0.1);
        assert_eq!(evaluate(&function, 3.0001), 0.0);
        assert!(evaluate(&function, 3.0) > 0.85);
        assert_eq!(evaluate(&[], 5.0), 1.0);
    }
}
