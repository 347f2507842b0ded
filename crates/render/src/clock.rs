//! From the index of a frame to the moment that it shows.

use crate::{settings::Settings, stage::Moment, temporal::Antialiasing};

/// Maps frame indices to time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    start_secs: f32,
    first_frame: u32,
    frames_per_sec: f32,
    stands: bool,
}

impl Clock {
    /// The clock of a run: it stands still for anti-aliasing that adds up one moment.
    #[must_use]
    pub fn new(settings: &Settings, antialiasing: Antialiasing) -> Self {
        Self {
            start_secs: settings.start_secs,
            first_frame: settings.first_frame,
            frames_per_sec: settings.frames_per_sec,
            stands: antialiasing.info().time_stands_still,
        }
    }

    /// The moment of frame `index`, counted from the run's first. A single frame counts as moving if the
    /// run's frames do.
    #[must_use]
    pub fn at(&self, index: u32) -> Moment {
        let time_of = |index: u32| self.start_secs + index as f32 / self.frames_per_sec;
        if self.stands {
            let time_secs = time_of(self.first_frame);
            return Moment { time_secs, previous_secs: time_secs };
        }
        let index = self.first_frame + index;
        Moment { time_secs: time_of(index), previous_secs: time_of(index.saturating_sub(1)) }
    }
}
