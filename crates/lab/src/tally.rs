//! What frames cost, gathered over a run.

use sheer_metrics::statistics::quantile;
use sheer_render::{Counters, StepTime, Timings};

/// The cost of each frame of one method.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    frames: Vec<Timings>,
    sum: Counters,
    /// Milliseconds of each frame that had the step, by its name, in the order in which steps came up.
    steps: Vec<(&'static str, Vec<f64>)>,
}

impl Tally {
    /// Takes the next frame.
    pub fn add(&mut self, (counters, timings): (Counters, Timings)) {
        self.frames.push(timings);
        self.sum = self.sum + counters;
    }

    /// Takes the steps of the next frame.
    pub fn add_steps(&mut self, steps: &[StepTime]) {
        for &StepTime { name, ms } in steps {
            match self.steps.iter_mut().find(|(known, _)| *known == name) {
                Some((_, all)) => all.push(ms),
                None => self.steps.push((name, vec![ms])),
            }
        }
    }

    /// Each step and the median of its milliseconds.
    pub fn steps(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.steps.iter().map(|(name, ms)| (*name, quantile(ms, 0.5)))
    }

    /// Milliseconds of each frame, without temporal anti-aliasing.
    #[must_use]
    pub fn frame_ms(&self) -> Vec<f64> {
        self.frames.iter().map(Timings::frame_ms).collect()
    }

    /// The `share`-quantile of the milliseconds of a frame: 0 the least, 0.5 the median, 1 the most.
    #[must_use]
    pub fn ms(&self, share: f64) -> f64 {
        quantile(&self.frame_ms(), share)
    }

    /// The median of the milliseconds spent on animation and acceleration structure.
    #[must_use]
    pub fn build_ms(&self) -> f64 {
        quantile(&self.frames.iter().map(|frame| frame.build_ms).collect::<Vec<_>>(), 0.5)
    }

    /// The median of the milliseconds spent on shadow maps.
    #[must_use]
    pub fn shadow_ms(&self) -> f64 {
        quantile(&self.frames.iter().map(|frame| frame.shadow_ms).collect::<Vec<_>>(), 0.5)
    }

    /// The median of the milliseconds spent on adding frames up over time, no part of [`Self::ms`].
    #[must_use]
    pub fn resolve_ms(&self) -> f64 {
        quantile(&self.frames.iter().map(|frame| frame.resolve_ms).collect::<Vec<_>>(), 0.5)
    }

    /// The median of the milliseconds of a frame with all that it takes.
    #[must_use]
    pub fn whole_ms(&self) -> f64 {
        let whole = self.frames.iter().map(|frame| frame.frame_ms() + frame.resolve_ms);
        quantile(&whole.collect::<Vec<_>>(), 0.5)
    }

    /// Camera and shadow rays of a frame, mean.
    #[must_use]
    pub fn rays(&self) -> f64 {
        self.per_frame(self.sum.camera_rays + self.sum.shadow_rays)
    }

    /// Fragments shaded in a frame, mean.
    #[must_use]
    pub fn shaded(&self) -> f64 {
        self.per_frame(self.sum.shaded)
    }

    /// Hits of camera rays in a frame, mean.
    #[must_use]
    pub fn hits(&self) -> f64 {
        self.per_frame(self.sum.hits)
    }

    /// Fragments merged in a frame for want of a place, mean.
    #[must_use]
    pub fn merged(&self) -> f64 {
        self.per_frame(self.sum.merged)
    }

    /// Million rays a second of tracing and shading.
    #[must_use]
    pub fn mray_per_s(&self) -> f64 {
        let trace_ms: f64 = self.frames.iter().map(|frame| frame.trace_ms).sum();
        (self.sum.camera_rays + self.sum.shadow_rays) as f64 / (trace_ms * 1e3)
    }

    fn per_frame(&self, sum: u64) -> f64 {
        sum as f64 / self.frames.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_keep_their_order_and_have_their_median() {
        let mut tally = Tally::default();
        for ms in [1.0, 2.0, 9.0] {
            tally.add_steps(&[StepTime { name: "trace", ms }, StepTime { name: "blend", ms: 0.5 }]);
        }
        assert_eq!(tally.steps().collect::<Vec<_>>(), [("trace", 2.0), ("blend", 0.5)]);
    }
}
