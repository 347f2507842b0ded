//! Adding frames up over time.

use std::{fmt, str::FromStr};

use glam::Vec2;
use rayon::prelude::*;
use sheer_image::{Image, ImageError, Planes};

use crate::{
    contract::Alignment,
    settings::{FrameSettings, Settings},
};

mod align;
pub mod taa;

/// How frames are added up (`-a`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Antialiasing {
    /// Not at all: one sample through each pixel centre.
    None,
    /// The plain mean of jittered frames of one moment: for stills and references.
    Accumulate,
    /// Temporal anti-aliasing by reprojection (Salvi 2016).
    #[default]
    Taa,
}

impl Antialiasing {
    /// All, in the order in which they are listed.
    pub const ALL: [Self; 3] = [Self::None, Self::Accumulate, Self::Taa];

    /// The word on the command line.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Accumulate => "accumulate",
            Self::Taa => "taa",
        }
    }
}

impl fmt::Display for Antialiasing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

impl FromStr for Antialiasing {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|known| known.word() == text).ok_or_else(|| {
            let known = Self::ALL.map(Self::word).join(", ");
            format!("there is no anti-aliasing '{text}'; there are: {known}")
        })
    }
}

/// Samples before the jitter of a moving picture repeats: an exponential average of weight 0.1 forgets in about as many, and 16 is coprime
/// to the 9 frames of the STD walk, so that every threshold meets every offset.
const JITTER_PERIOD: u32 = 16;

/// Offset of a frame's sample from the pixel centre, in (-0.5, 0.5) pixels: Halton's sequence of bases 2 and 3.
#[must_use]
pub fn jitter(antialiasing: Antialiasing, frame: u32) -> Vec2 {
    let index = match antialiasing {
        Antialiasing::None => return Vec2::ZERO,
        Antialiasing::Accumulate => frame.wrapping_add(1),
        Antialiasing::Taa => frame % JITTER_PERIOD + 1,
    };
    Vec2::new(radical_inverse(index, 2), radical_inverse(index, 3)) - 0.5
}

/// The digits of `index` in a base, mirrored at the point.
fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut value, mut weight) = (0.0, 1.0);
    while index > 0 {
        weight /= base as f32;
        value += weight * (index % base) as f32;
        index /= base;
    }
    value
}

/// What has been added up: what [`crate::Pipeline`] keeps from frame to frame, and what other backends are measured against.
#[derive(Clone, Debug)]
pub struct History {
    antialiasing: Antialiasing,
    planes: Planes,
    count: u32,
}

impl History {
    /// Empty.
    ///
    /// # Errors
    /// [`ImageError::Size`] if a side is zero or memory does not suffice.
    pub fn new(antialiasing: Antialiasing, [width, height]: [u32; 2]) -> Result<Self, ImageError> {
        Ok(Self { antialiasing, planes: Planes::new(width, height)?, count: 0 })
    }

    /// How frames are added up.
    #[must_use]
    pub fn antialiasing(&self) -> Antialiasing {
        self.antialiasing
    }

    /// The picture so far: colour added up, everything else of the last frame.
    #[must_use]
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// Takes in the next frame, of a method whose motion vectors are aligned like this
    /// ([`crate::Method::alignment`]).
    ///
    /// # Errors
    /// [`ImageError::Size`] if memory does not suffice.
    pub fn add(
        &mut self,
        current: Planes,
        alignment: Alignment,
        settings: &FrameSettings,
    ) -> Result<(), ImageError> {
        let mut current = current;
        if self.count > 0 {
            match self.antialiasing {
                Antialiasing::None => {}
                Antialiasing::Accumulate => add_to_mean(&self.planes.colour, &mut current.colour, self.count),
                Antialiasing::Taa => {
                    let FrameSettings { run: Settings { size, seed, .. }, frame, .. } = *settings;
                    let reprojection = align::Reprojection { alignment, size, frame, seed };
                    current.colour = taa::resolve(&current, &self.planes.colour, self.count, reprojection)?;
                }
            }
        }
        self.count += 1;
        self.planes = current;
        Ok(())
    }
}

/// Turns `current` into the mean of `count` earlier frames, given by theirs, and itself.
fn add_to_mean(mean: &Image<[f32; 4]>, current: &mut Image<[f32; 4]>, count: u32) {
    let weight = 1.0 / (count as f32 + 1.0);
    current.par_rows_mut().zip(mean.par_rows()).for_each(|(current, mean)| {
        for (current, mean) in current.iter_mut().zip(mean) {
            *current =
                std::array::from_fn(|channel| mean[channel] + (current[channel] - mean[channel]) * weight);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jitter_is_balanced_and_stays_inside_the_pixel() {
        let offsets: Vec<Vec2> = (0..JITTER_PERIOD).map(|frame| jitter(Antialiasing::Taa, frame)).collect();
        assert!(offsets.iter().all(|offset| offset.abs().max_element() < 0.5));
        let mean = offsets.iter().sum::<Vec2>() / JITTER_PERIOD as f32;
        assert!(mean.abs().max_element() < 0.05, "{mean}");
        assert_eq!(jitter(Antialiasing::None, 7), Vec2::ZERO);
        assert_eq!(jitter(Antialiasing::Taa, 3), jitter(Antialiasing::Taa, 3 + JITTER_PERIOD));
        assert_ne!(jitter(Antialiasing::Accumulate, 3), jitter(Antialiasing::Accumulate, 3 + JITTER_PERIOD));
    }

    #[test]
    fn accumulation_is_the_plain_mean() {
        let run = crate::Settings { size: [1, 1], ..Default::default() };
        let settings = FrameSettings { run, frame: 0, jitter: Vec2::ZERO };
        let mut history = History::new(Antialiasing::Accumulate, [1, 1]).unwrap();
        for value in [1.0, 2.0, 6.0] {
            let mut planes = Planes::new(1, 1).unwrap();
            planes.colour[(0, 0)] = [value; 4];
            history.add(planes, Alignment::NONE, &settings).unwrap();
        }
        assert_eq!(history.planes().colour[(0, 0)], [3.0; 4]);
    }
}
