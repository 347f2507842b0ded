//! Fourier opacity mapping (Jansen and Bavoil, *Fourier Opacity Mapping*, 2010): each texel keeps the
//! absorption along its ray as the first terms of a Fourier series.
//!
//! One deviation: the series of a texel spans its own blockers, not the whole depth of the light. The last
//! blocker lies inside the period, so that the light behind it is exact; at a blocker the series is soft, and
//! between blockers it rings.

use std::f32::consts::TAU;

use glam::Vec3;
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};

use super::{
    blockers::record,
    deep_map::FILTER,
    opacity_map::optical_depth,
    projection::Projection,
    technique::{Map, RESOLUTION, Receiver, ShadowInfo, Technique, View},
};
use crate::{cost::Counters, stage::Stage};

/// The row of the technique in lists and help.
pub(super) const INFO: ShadowInfo = ShadowInfo {
    id: "fourier",
    title: "absorption along the light as a short Fourier series",
    paper: "Jansen and Bavoil 2010, Fourier Opacity Mapping",
    works: &[&bibliography::JANSEN_BAVOIL_2010],
    bias: "soft at blockers, rings between them; exact behind the last",
    parameters: &[
        RESOLUTION,
        ParameterInfo {
            key: "terms",
            default: "7",
            range: ParameterRange::Count(1, 64),
            what: "sines and as many cosines; the paper has 3 or 7 beside the constant",
        },
    ],
};

/// Share of the depth between the first and the last blocker that the period has on either side of them.
/// Without it the two ends would be one point of the circle, and the ringing of the last blocker would darken
/// the first; much more spends the terms on emptiness.
const MARGIN: f32 = 0.25;

/// Fourier opacity mapping with a number of terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fourier {
    resolution: u32,
    terms: u32,
}

impl Fourier {
    pub(super) fn new(values: &Values) -> Self {
        Self { resolution: values.count("resolution"), terms: values.count("terms") }
    }

    /// Numbers kept of a texel: depths of the opaque surface and of the ends of the period; for each channel
    /// the constant, then pairs.
    fn stride(&self, channels: usize) -> usize {
        3 + channels * self.coefficients()
    }

    fn coefficients(&self) -> usize {
        1 + 2 * self.terms as usize
    }
}

impl Technique for Fourier {
    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn texel_bytes(&self, channels: usize) -> usize {
        self.stride(channels) * size_of::<f32>()
    }

    fn map(&self, view: &View<'_>) -> Box<dyn Map> {
        let projection = Projection::new(view.stage.frame(), view.light, self.resolution);
        let count = self.coefficients();
        let texels = record(view, &projection, |texel, blockers, texels| {
            let [first, last] = blockers.range();
            // One blocker alone gets a period of its texel's size.
            let margin = (MARGIN * (last - first)).max(projection.texel_side(texel, first));
            let period = if first.is_finite() { [first - margin, last + margin] } else { [first, last] };
            texels.extend([blockers.opaque_depth, period[0], period[1]]);
            let start = texels.len();
            texels.resize(start + view.channels * count, 0.0);
            for blocker in &blockers.transparent {
                let turn = (blocker.depth - period[0]) / (period[1] - period[0]);
                for channel in 0..view.channels {
                    let series = &mut texels[start + channel * count..][..count];
                    add(series, turn, optical_depth(blocker.through[channel]));
                }
            }
        });
        Box::new(Series { technique: *self, projection, channels: view.channels, texels })
    }

    fn values(&self) -> Vec<String> {
        vec![self.resolution.to_string(), self.terms.to_string()]
    }
}

/// Adds an optical depth at a position in the period, 0 to 1 (their Eq. 5): the coefficients a0 / 2, a1, b1,
/// a2, b2…
fn add(series: &mut [f32], turn: f32, optical_depth: f32) {
    series[0] += optical_depth;
    for (index, pair) in series[1..].chunks_exact_mut(2).enumerate() {
        let (sin, cos) = (TAU * (index + 1) as f32 * turn).sin_cos();
        pair[0] += 2.0 * optical_depth * cos;
        pair[1] += 2.0 * optical_depth * sin;
    }
}

/// Optical depth up to a position in the period: the integral of the series (their Eq. 6).
fn evaluate(series: &[f32], turn: f32) -> f32 {
    // No light is made up where the series rings below nothing, and none is lost from the whole at the end of
    // the period.
    let turn = turn.clamp(0.0, 1.0);
    let terms = series[1..].chunks_exact(2).enumerate().map(|(index, pair)| {
        let frequency = TAU * (index + 1) as f32;
        let (sin, cos) = (frequency * turn).sin_cos();
        (pair[0] * sin + pair[1] * (1.0 - cos)) / frequency
    });
    (series[0] * turn + terms.sum::<f32>()).max(0.0)
}

#[derive(Debug)]
struct Series {
    technique: Fourier,
    projection: Projection,
    channels: usize,
    texels: Vec<f32>,
}

impl Map for Series {
    fn transmittance(&self, stage: &Stage, receiver: &Receiver, _: &mut Counters) -> Vec3 {
        let stride = self.technique.stride(self.channels);
        let count = self.technique.coefficients();
        self.projection.filter(stage, receiver, FILTER, |texel, depth| {
            let texel = &self.texels[texel * stride..][..stride];
            let (&[opaque, first, last], series) =
                texel.split_first_chunk().expect("a texel starts with three depths");
            if depth > opaque {
                return Vec3::ZERO;
            }
            if depth <= first {
                return Vec3::ONE;
            }
            let turn = (depth - first) / (last - first);
            let channel = |channel: usize| (-evaluate(&series[channel * count..][..count], turn)).exp();
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
    use std::f32::consts::PI;

    use super::*;

    /// The tail of the series of a step is at most `1 / (π (n + 1) |sin π x|)` at a distance of `x` periods
    /// (Abel's summation), and the step has it once at the position asked for and once at the start of the
    /// period.
    fn bound(terms: usize, blockers: &[(f32, f32)], turn: f32) -> f32 {
        let tail = |distance: f32| 1.0 / (PI * (terms + 1) as f32 * (PI * distance).sin().abs());
        blockers.iter().map(|(at, depth)| depth * (tail(turn - at) + tail(*at))).sum()
    }

    #[test]
    fn the_series_is_within_its_ringing_and_exact_at_the_end() {
        let blockers = [(0.2, 0.5), (0.35, 0.1), (0.7, 1.2)];
        for terms in [1, 3, 7, 31] {
            let mut series = vec![0.0; 1 + 2 * terms];
            blockers.iter().for_each(|&(at, depth)| add(&mut series, at, depth));
            for step in 0..=100 {
                let turn = step as f32 / 100.0;
                let truth: f32 = blockers.iter().filter(|(at, _)| *at < turn).map(|(_, depth)| depth).sum();
                let error = (evaluate(&series, turn) - truth).abs();
                assert!(error <= bound(terms, &blockers, turn) + 1e-4, "{terms} terms at {turn}: {error}");
            }
            assert!((evaluate(&series, 1.0) - 1.8).abs() < 1e-4 && evaluate(&series, 0.0).abs() < 1e-6);
        }
        // Negative control: a series with a wrong sign leaves its bound.
        let mut series = vec![0.0; 63];
        blockers.iter().for_each(|&(at, depth)| add(&mut series, -at, depth));
        assert!((evaluate(&series, 0.5) - 0.6).abs() > bound(31, &blockers, 0.5), "the check is blind");
    }
}
