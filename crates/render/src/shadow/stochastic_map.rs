//! Stochastic shadow maps (ST sections 3.2 and 3.6), coloured after McGuire and Enderton, *Colored Stochastic
//! Shadow Maps*, 2011.

use glam::{Vec2, Vec3};
use sheer_core::{
    bibliography,
    hash::{pcg4d, unit_from_bits},
    parameter::{Choice as _, ParameterInfo, ParameterRange, Switch, Values},
};

use super::{
    blockers::{Blockers, record},
    mask::{self, Sampling},
    projection::Projection,
    technique::{Map, RESOLUTION, Receiver, ShadowInfo, Technique, View},
};
use crate::{cost::Counters, stage::Stage};

/// The row of the technique in lists and help.
pub(super) const INFO: ShadowInfo = ShadowInfo {
    id: "stochastic-map",
    title: "a shadow map whose samples keep each blocker with the probability of its alpha",
    paper: "Enderton, Sintorn, Shirley, Luebke (ST), sections 3.2 and 3.6; colour: McGuire and Enderton 2011",
    works: &[&bibliography::ST, &bibliography::MCGUIRE_ENDERTON_2011],
    bias: "none but the filter's blur; correct=on: between blockers",
    parameters: &[
        RESOLUTION,
        ParameterInfo {
            key: "samples",
            default: "8",
            range: ParameterRange::Count(1, mask::MOST_SAMPLES),
            what: "samples a texel; the paper's MSAA has 8",
        },
        Sampling::parameter(
            "sampling",
            Sampling::Stratified,
            "a coin for each sample, or a random subset of alpha times the samples",
        ),
        Switch::parameter("correct", Switch::Off, "scale a texel's drop in visibility to its true total"),
        ParameterInfo {
            key: "filter",
            default: "2",
            range: ParameterRange::Count(0, 64),
            what: "width of percentage closer filtering in texels; 0 for the nearest texel alone",
        },
        ParameterInfo {
            key: "taps",
            default: "0",
            range: ParameterRange::Count(0, 256),
            what: "samples taken at random from the filter for each fragment; 0 for all",
        },
    ],
};

/// Stochastic shadow maps of a resolution, with a number of samples a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StochasticMap {
    resolution: u32,
    samples: u32,
    sampling: Sampling,
    correct: Switch,
    filter: u32,
    taps: u32,
}

impl StochasticMap {
    pub(super) fn new(values: &Values) -> Self {
        Self {
            resolution: values.count("resolution"),
            samples: values.count("samples"),
            sampling: values.choice("sampling"),
            correct: values.choice("correct"),
            filter: values.count("filter"),
            taps: values.count("taps"),
        }
    }

    fn is_corrected(&self) -> bool {
        self.correct == Switch::On
    }

    /// Numbers kept of a texel.
    fn stride(&self, channels: usize) -> usize {
        channels * self.samples as usize + if self.is_corrected() { Corrected::stride(channels) } else { 0 }
    }
}

impl Technique for StochasticMap {
    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn is_random(&self) -> bool {
        true
    }

    fn texel_bytes(&self, channels: usize) -> usize {
        self.stride(channels) * size_of::<f32>()
    }

    fn map(&self, view: &View<'_>) -> Box<dyn Map> {
        let projection = Projection::new(view.stage.frame(), view.light, self.resolution);
        let texels = record(view, &projection, |texel, blockers, texels| {
            self.draw(view, texel, blockers, texels);
        });
        Box::new(Samples { technique: *self, projection, channels: view.channels, key: view.key, texels })
    }

    fn values(&self) -> Vec<String> {
        vec![
            self.resolution.to_string(),
            self.samples.to_string(),
            self.sampling.word().to_owned(),
            self.correct.word().to_owned(),
            self.filter.to_string(),
            self.taps.to_string(),
        ]
    }
}

impl StochasticMap {
    /// Appends a texel: for each channel the depth of the first blocker that each sample keeps, then what the
    /// correction needs. A corrected map keeps the opaque surface apart from the samples, as the paper says
    /// it has to.
    fn draw(&self, view: &View<'_>, texel: usize, blockers: &Blockers, texels: &mut Vec<f32>) {
        let samples = self.samples as usize;
        let first = texels.len();
        let nothing = if self.is_corrected() { f32::INFINITY } else { blockers.opaque_depth };
        texels.resize(first + view.channels * samples, nothing);
        for blocker in &blockers.transparent {
            let seed = mask::seed(texel, blocker.triangle, view.key);
            for channel in 0..view.channels {
                // What a channel loses is its chance: the coverage times one less the tint (McGuire and
                // Enderton).
                let mut mask = self.sampling.mask(1.0 - blocker.through[channel], self.samples, seed);
                while mask != 0 {
                    let depth = &mut texels[first + channel * samples + mask.trailing_zeros() as usize];
                    *depth = depth.min(blocker.depth);
                    mask &= mask - 1;
                }
            }
        }
        if self.is_corrected() {
            let kept = |channel: usize| {
                let depths = &texels[first + channel * samples..][..samples];
                depths.iter().filter(|depth| depth.is_finite()).count() as f32 / samples as f32
            };
            let through = blockers.through();
            let drops: Vec<[f32; 2]> =
                (0..view.channels).map(|channel| [1.0 - through[channel], kept(channel)]).collect();
            let [_, last] = blockers.range();
            texels.extend([blockers.opaque_depth, last]);
            for [drop, estimate] in drops {
                texels.extend([drop, if estimate > 0.0 { drop / estimate } else { 0.0 }]);
            }
        }
    }
}

/// What alpha correction knows of a texel (ST section 3.6).
struct Corrected<'a>(&'a [f32]);

impl Corrected<'_> {
    /// Depths of the opaque surface and of the last transparent one; for each channel the true total drop,
    /// and the factor from the estimate to it.
    fn stride(channels: usize) -> usize {
        2 + 2 * channels
    }

    /// Corrects the share of samples that blocks a depth. Behind the last blocker the total is known, so that
    /// it is right even where no sample has kept anything; behind an opaque surface there is no light.
    fn blocked(&self, depth: f32, channel: usize, share: f32) -> f32 {
        let [opaque, last] = [self.0[0], self.0[1]];
        let [drop, factor] = [self.0[2 + 2 * channel], self.0[3 + 2 * channel]];
        if depth > opaque {
            1.0
        } else if depth > last {
            drop
        } else {
            share * factor
        }
    }
}

#[derive(Debug)]
struct Samples {
    technique: StochasticMap,
    projection: Projection,
    channels: usize,
    key: u32,
    texels: Vec<f32>,
}

impl Samples {
    /// Visibility at a depth of a texel by the share of its samples that are not nearer to the light (ST Eq.
    /// 4): all of them, or one.
    fn visibility(&self, texel: usize, depth: f32, one: Option<usize>) -> Vec3 {
        let samples = self.technique.samples as usize;
        let stride = self.technique.stride(self.channels);
        let texel = &self.texels[texel * stride..][..stride];
        let (drawn, corrected) = texel.split_at(self.channels * samples);
        let channel = |channel: usize| {
            let drawn = &drawn[channel * samples..][..samples];
            let blocked = match one {
                Some(sample) => f32::from(drawn[sample] < depth),
                None => drawn.iter().filter(|sample| **sample < depth).count() as f32 / samples as f32,
            };
            1.0 - if self.technique.is_corrected() {
                Corrected(corrected).blocked(depth, channel, blocked)
            } else {
                blocked
            }
        };
        if self.channels == 1 { Vec3::splat(channel(0)) } else { Vec3::from_array([0, 1, 2].map(channel)) }
    }
}

impl Map for Samples {
    fn transmittance(&self, stage: &Stage, receiver: &Receiver, _: &mut Counters) -> Vec3 {
        let StochasticMap { samples, filter, taps, .. } = self.technique;
        if taps == 0 {
            return self
                .projection
                .filter(stage, receiver, filter, |texel, depth| self.visibility(texel, depth, None));
        }
        let [a, b, c] = receiver.key;
        let [x, y, first, _] = pcg4d([a, b, c, self.key]);
        let start = Vec2::new(unit_from_bits(x), unit_from_bits(y));
        self.projection.random_taps(stage, receiver, filter, taps, start, |tap, texel, depth| {
            let sample = (first % samples + tap) % samples;
            self.visibility(texel, depth, Some(sample as usize))
        })
    }
}
