//! Deep opacity maps (Yuksel and Keyser, *Deep Opacity Maps*, 2008): layers of accumulated opacity that start
//! at the first blocker of each texel.
//!
//! Two deviations, which make the light behind all layers exact. The layers of a texel end at its last
//! blocker, not after a length that the user has to find for each scene; and what is summed is the optical
//! depth `-ln(1 - alpha)`, not alpha.

use glam::Vec3;
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use super::{
    blockers::record,
    deep_map::FILTER,
    projection::Projection,
    technique::{Map, RESOLUTION, Receiver, ShadowInfo, Technique, View},
};
use crate::{contract::MIN_VISIBILITY, cost::Counters, stage::Stage};

/// The row of the technique in lists and help.
pub(super) const INFO: ShadowInfo = ShadowInfo {
    id: "opacity-map",
    title: "opacity accumulated in a few layers between the first and the last blocker of a texel",
    paper: "Yuksel and Keyser 2008, Deep Opacity Maps",
    works: &[&bibliography::YUKSEL_KEYSER_2008],
    bias: "up to the drop in visibility across the layer that a fragment is in",
    parameters: &[
        RESOLUTION,
        ParameterInfo {
            key: "layers",
            default: "8",
            range: ParameterRange::Count(1, 256),
            what: "layers between the first and the last blocker",
        },
    ],
};

/// Optical depth of a blocker of which a channel lets some light pass; bounded where that is less than anyone
/// would see.
pub(super) fn optical_depth(through: f32) -> f32 {
    -through.clamp(MIN_VISIBILITY, 1.0).ln()
}

/// Deep opacity maps of a resolution, with a number of layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OpacityMap {
    resolution: u32,
    layers: u32,
}

impl OpacityMap {
    pub(super) fn new(values: &Values) -> Self {
        Self { resolution: values.count("resolution"), layers: values.count("layers") }
    }

    /// Numbers kept of a texel: depths of the opaque surface, the first and the last blocker; then the
    /// layers.
    fn stride(&self, channels: usize) -> usize {
        3 + channels * self.layers as usize
    }
}

impl Technique for OpacityMap {
    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn texel_bytes(&self, channels: usize) -> usize {
        self.stride(channels) * size_of::<f32>()
    }

    fn map(&self, view: &View<'_>) -> Box<dyn Map> {
        let projection = Projection::new(view.stage.frame(), view.light, self.resolution);
        let layers = self.layers as usize;
        let texels = record(view, &projection, |_, blockers, texels| {
            let [first, last] = blockers.range();
            texels.extend([blockers.opaque_depth, first, last]);
            let start = texels.len();
            texels.resize(start + view.channels * layers, 0.0);
            for blocker in &blockers.transparent {
                // The first blocker is in the first layer, the last in the last.
                let share = (blocker.depth - first) / (last - first).max(f32::MIN_POSITIVE);
                let layer = ((share * layers as f32) as usize).min(layers - 1);
                for channel in 0..view.channels {
                    texels[start + channel * layers + layer] += optical_depth(blocker.through[channel]);
                }
            }
            for channel in texels[start..].chunks_exact_mut(layers) {
                channel.iter_mut().fold(0.0, |sum, layer| {
                    *layer += sum;
                    *layer
                });
            }
        });
        Box::new(Layers { technique: *self, projection, channels: view.channels, texels })
    }

    fn values(&self) -> Vec<String> {
        vec![self.resolution.to_string(), self.layers.to_string()]
    }
}

#[derive(Debug)]
struct Layers {
    technique: OpacityMap,
    projection: Projection,
    channels: usize,
    texels: Vec<f32>,
}

/// Optical depth in front of a depth: linear across a layer, from what lies before it to what has gathered at
/// its end.
fn evaluate(layers: &[f32], [first, last]: [f32; 2], depth: f32) -> f32 {
    let total = layers[layers.len() - 1];
    if depth <= first {
        0.0
    } else if depth > last {
        total
    } else {
        let at = (depth - first) / (last - first) * layers.len() as f32;
        let layer = (at as usize).min(layers.len() - 1);
        let before = if layer == 0 { 0.0 } else { layers[layer - 1] };
        before + (at - layer as f32).min(1.0) * (layers[layer] - before)
    }
}

impl Map for Layers {
    fn transmittance(&self, stage: &Stage, receiver: &Receiver, _: &mut Counters) -> Vec3 {
        let layers = self.technique.layers as usize;
        let stride = self.technique.stride(self.channels);
        self.projection.filter(stage, receiver, FILTER, |texel, depth| {
            let texel = &self.texels[texel * stride..][..stride];
            let (&[opaque, first, last], layered) =
                texel.split_first_chunk().expect("a texel starts with three depths");
            if depth > opaque {
                return Vec3::ZERO;
            }
            let channel = |channel: usize| {
                (-evaluate(&layered[channel * layers..][..layers], [first, last], depth)).exp()
            };
            if self.channels == 1 {
                Vec3::splat(channel(0))
            } else {
                Vec3::from_array([0, 1, 2].map(channel))
            }
        })
    }
}
