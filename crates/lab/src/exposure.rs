//! Frames of final quality: each is the mean of samples of its own interval of time.

use std::ops::Range;

use sheer_image::SampleRange;
use sheer_render::{Antialiasing, Backend, Clock, Counters, Moment, Settings, Timings};

use crate::{LabError, Result};

/// How the frames of a playing clip are exposed: each is rendered anew, as the plain mean of jittered samples
/// that are spread over the time that the shutter is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Samples a pixel and frame; at least one.
    pub samples: u32,
    /// Share of the time from a frame to the next that the shutter is open, around the frame's moment: 0
    /// shows one moment, 0.5 is usual for film.
    pub shutter: f32,
    /// Which of the samples are rendered, all if none: a frame is the mean of these.
    pub part: Option<SampleRange>,
}

impl Exposure {
    /// The settings of a pipeline that exposes frames of a run, under [`Antialiasing::ACCUMULATE`]: it counts
    /// samples, from the run's first frame on.
    #[must_use]
    pub fn settings(&self, run: Settings) -> Settings {
        Settings { first_frame: 0, ..run }
    }

    /// Renders a frame of a run into a pipeline made with [`Self::settings`]; `watch` hears what each sample
    /// cost. The planes of depth, motion and ids are those of the last sample.
    ///
    /// # Errors
    /// What the backend or `watch` says.
    pub fn render<B: Backend>(
        &self,
        backend: &B,
        stage: &mut B::Stage,
        pipeline: &mut B::Pipeline,
        run: &Settings,
        frame: u32,
        mut watch: impl FnMut((Counters, Timings)) -> Result<()>,
    ) -> Result<()> {
        let failed = |error| LabError::of_backend(backend, error);
        backend.reset_history(pipeline);
        for sample in self.rendered() {
            backend.advance(stage, self.moment(run, frame, sample)).map_err(failed)?;
            // Another place in the patterns of thresholds for every sample of every frame.
            let index = frame.wrapping_mul(self.samples).wrapping_add(sample);
            watch(backend.render(pipeline, stage, index).map_err(failed)?)?;
        }
        Ok(())
    }

    /// The samples of a frame that are rendered.
    #[must_use]
    pub fn rendered(&self) -> Range<u32> {
        self.part.map_or(0..self.samples, |part| part.first..part.end)
    }

    /// When a sample of a frame is taken; motion is that from frame to frame.
    fn moment(&self, run: &Settings, frame: u32, sample: u32) -> Moment {
        let clock = Clock::new(&Settings { first_frame: 0, ..*run }, Antialiasing::NONE);
        let Moment { time_secs, previous_secs } = clock.at(frame);
        let along = (sample as f32 + 0.5) / self.samples as f32 - 0.5;
        let offset_secs = self.shutter * along / run.frames_per_sec;
        Moment { time_secs: time_secs + offset_secs, previous_secs: previous_secs + offset_secs }
    }
}

#[cfg(test)]
mod tests {
    use sheer_render::{Method, Stage, backend::Cpu};

    use super::*;

    fn run() -> Settings {
        Settings { size: [24, 14], start_secs: 6.0, frames_per_sec: 10.0, ..Settings::default() }
    }

    fn exposed(exposure: Exposure, frames: &[u32]) -> Vec<Vec<[f32; 4]>> {
        let scene = sheer_gallery::open("arena").unwrap().scene;
        let mut stage = Stage::new(scene, &Default::default(), Some(1)).unwrap();
        let method: Method = "baseline".parse().unwrap();
        let settings = exposure.settings(run());
        let mut pipeline = Cpu.pipeline(&method, Antialiasing::ACCUMULATE, settings).unwrap();
        let mut picture = |&frame: &u32| {
            exposure.render(&Cpu, &mut stage, &mut pipeline, &run(), frame, |_| Ok(())).unwrap();
            pipeline.planes().colour.as_slice().to_vec()
        };
        frames.iter().map(&mut picture).collect()
    }

    #[test]
    fn samples_are_spread_around_the_moment_of_their_frame() {
        let exposure = Exposure { samples: 4, shutter: 0.5, part: None };
        let times = [0, 1, 2, 3].map(|sample| exposure.moment(&run(), 3, sample).time_secs);
        let expected = [6.28125, 6.29375, 6.30625, 6.31875];
        assert!(times.iter().zip(expected).all(|(time, wanted)| (time - wanted).abs() < 1e-5), "{times:?}");
        let Moment { time_secs, previous_secs } = exposure.moment(&run(), 3, 2);
        assert!((time_secs - previous_secs - 0.1).abs() < 1e-5, "{time_secs} {previous_secs}");
        let shut = Exposure { shutter: 0.0, ..exposure };
        assert_eq!(shut.moment(&run(), 3, 0), shut.moment(&run(), 3, 3));
    }

    #[test]
    fn a_frame_owes_nothing_to_those_before_it() {
        let exposure = Exposure { samples: 3, shutter: 0.5, part: None };
        let both = exposed(exposure, &[2, 5]);
        let alone = exposed(exposure, &[5]);
        assert_eq!(both[1], alone[0]);
        assert_ne!(both[0], both[1]);
    }

    #[test]
    fn the_parts_of_a_frame_are_its_own_samples() {
        let whole = Exposure { samples: 5, shutter: 1.0, part: None };
        let part = |first, end| Exposure { part: Some(SampleRange { first, end, of: 5 }), ..whole };
        let [all, early, late] =
            [whole, part(0, 2), part(2, 5)].map(|exposure| exposed(exposure, &[4]).concat());
        assert_ne!(early, late);
        for ((all, early), late) in all.iter().zip(&early).zip(&late) {
            for channel in 0..4 {
                let mean = (2.0 * early[channel] + 3.0 * late[channel]) / 5.0;
                assert!((all[channel] - mean).abs() < 1e-5 * mean.max(1.0), "{all:?} {early:?} {late:?}");
            }
        }
    }

    #[test]
    fn an_open_shutter_blurs_what_moves() {
        let shut = exposed(Exposure { samples: 8, shutter: 0.0, part: None }, &[4]);
        let open = exposed(Exposure { samples: 8, shutter: 1.0, part: None }, &[4]);
        assert_ne!(shut, open);
    }
}
