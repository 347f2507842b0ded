//! Adding frames up over time. One technique a file; to add one, write `temporal/<name>.rs` after the pattern
//! of its neighbours and put its name into the table below: command line, lists, GPU and the tests that walk
//! all follow.

use std::{fmt, str::FromStr};

use glam::Vec2;
use sheer_core::{
    parameter::{Values, split_name},
    suggestion::suggestion,
};
use sheer_image::{ImageError, Planes};

pub use self::technique::AntialiasingInfo;
use self::{
    align::Reprojection,
    technique::{Past, Technique},
};
use crate::{
    contract::Alignment,
    settings::{FrameSettings, LayerSplit, Settings},
};

pub mod align;
mod jitter;
mod layer_history;
mod resample;
mod technique;

/// Why there is no such technique.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AntialiasingError {
    /// No technique has that name.
    #[error("there is no anti-aliasing '{name}'; there are: {known}{}", suggestion(.name, .known.split(", ")))]
    Unknown {
        /// What was asked for.
        name: String,
        /// The names of all techniques, separated by commas.
        known: String,
    },
    /// A key or a value is off.
    #[error("anti-aliasing '{technique}': {problem}")]
    Parameter {
        /// The name of the technique.
        technique: &'static str,
        /// What is wrong and what is allowed.
        problem: String,
    },
}

macro_rules! techniques {
    ($($module:ident :: $name:ident),+ $(,)?) => {
        $(mod $module;)+

        #[derive(Clone, Copy, Debug, PartialEq)]
        enum Kind {
            $($name($module::$name),)+
        }

        /// All techniques, in the order in which they are listed.
        pub const ANTIALIASINGS: &[AntialiasingInfo] = &[$($module::INFO),+];

        impl Antialiasing {
            /// What lists and help say of it, and what a GPU needs of it.
            #[must_use]
            pub fn info(&self) -> &'static AntialiasingInfo {
                match self.kind {
                    $(Kind::$name(_) => &const { $module::INFO },)+
                }
            }

            fn technique(&self) -> &dyn Technique {
                match &self.kind {
                    $(Kind::$name(technique) => technique,)+
                }
            }
        }

        impl FromStr for Antialiasing {
            type Err = AntialiasingError;

            fn from_str(text: &str) -> Result<Self, AntialiasingError> {
                let (name, settings) = split_name(text);
                $(if name == $module::INFO.id {
                    let values = Values::parse($module::INFO.parameters, settings).map_err(|problem| {
                        AntialiasingError::Parameter { technique: $module::INFO.id, problem }
                    })?;
                    return Ok(Self { kind: Kind::$name($module::$name::new(&values)) });
                })+
                let known = ANTIALIASINGS.iter().map(|info| info.id).collect::<Vec<_>>().join(", ");
                Err(AntialiasingError::Unknown { name: name.to_owned(), known })
            }
        }
    };
}

techniques! {
    none::None,
    accumulate::Accumulate,
    taa::Taa,
    layered::Layered,
}

/// How frames are added up (`-a`), with its parameters. Parse one from `name:key=value,key=value`; it prints
/// with the keys that differ from their defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Antialiasing {
    kind: Kind,
}

impl Antialiasing {
    /// Not at all: one sample through each pixel centre.
    pub const NONE: Self = Self { kind: Kind::None(none::None) };
    /// The plain mean of jittered frames of one moment: for stills and references.
    pub const ACCUMULATE: Self = Self { kind: Kind::Accumulate(accumulate::Accumulate) };
    /// Temporal anti-aliasing by reprojection (Salvi 2016).
    pub const TAA: Self = Self { kind: Kind::Taa(taa::Taa::DEFAULT) };
    /// Temporal anti-aliasing of what is transparent and what lies behind it, each by itself.
    pub const LAYERED: Self = Self { kind: Kind::Layered(layered::Layered::DEFAULT) };

    /// Each key with its value, as they would be typed.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, String)> {
        self.info().parameters.iter().map(|parameter| parameter.key).zip(self.technique().values())
    }
}

impl Default for Antialiasing {
    fn default() -> Self {
        Self::TAA
    }
}

impl fmt::Display for Antialiasing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.info().id)?;
        let mut separator = ':';
        for (parameter, (key, value)) in self.info().parameters.iter().zip(self.values()) {
            if value != parameter.default {
                write!(f, "{separator}{key}={value}")?;
                separator = ',';
            }
        }
        Ok(())
    }
}

/// Offset of a frame's sample from the pixel centre, each coordinate in (-0.5, 0.5) pixels.
#[must_use]
pub fn jitter(antialiasing: Antialiasing, frame: u32) -> Vec2 {
    antialiasing.technique().jitter(frame)
}

/// How many pixels around a crop ([`Settings::crop`]) are to be rendered with it, so that its own show what
/// they show in the whole picture: as far as a history looks around, frame after frame, where nothing moves.
/// Where something does, no margin suffices to the bit, since histories come from as far as things have moved
/// (docs/farm.md says what is left). 0 without a history, or with one of each pixel by itself.
#[must_use]
pub fn margin_px(antialiasing: Antialiasing) -> u32 {
    antialiasing.technique().margin_px()
}

/// How the technique wants the pixels of each frame split into layers, if it does.
#[must_use]
pub fn layers(antialiasing: Antialiasing) -> Option<LayerSplit> {
    antialiasing.technique().layers()
}

/// What becomes of the frames of a run: the technique that adds them up, and how each is split into layers.
/// Raw frames are not added up, and are split as they are seen.
#[must_use]
pub fn of_run(settings: &Settings, antialiasing: Antialiasing) -> (Antialiasing, Option<LayerSplit>) {
    let asked_for = layers(antialiasing);
    if settings.raw {
        (Antialiasing::NONE, asked_for.or(Some(LayerSplit::AS_SEEN)))
    } else {
        (antialiasing, asked_for)
    }
}

/// What has been added up: what [`crate::Pipeline`] keeps from frame to frame, and what other backends are
/// measured against.
#[derive(Clone, Debug)]
pub struct History {
    antialiasing: Antialiasing,
    past: Past,
}

impl History {
    /// A history of no frames yet, for frames of a width and height in pixels.
    ///
    /// # Errors
    /// [`ImageError::Size`] if a side is zero or memory does not suffice.
    pub fn new(antialiasing: Antialiasing, [width, height]: [u32; 2]) -> Result<Self, ImageError> {
        let past = Past { planes: Planes::new(width, height)?, layers: None, count: 0, still_count: 0 };
        Ok(Self { antialiasing, past })
    }

    /// The picture so far: colour added up, everything else of the last frame.
    #[must_use]
    pub fn planes(&self) -> &Planes {
        &self.past.planes
    }

    /// The same, given up.
    #[must_use]
    pub fn into_planes(self) -> Planes {
        self.past.planes
    }

    /// Starts anew: the next frame owes nothing to those before it.
    pub fn reset(&mut self) {
        self.past.layers = None;
        self.past.count = 0;
        self.past.still_count = 0;
    }

    /// Takes in the next frame, of a method whose motion vectors are aligned like this
    /// ([`crate::Method::alignment`]).
    ///
    /// # Errors
    /// [`ImageError::Size`] if memory does not suffice.
    pub fn add(
        &mut self,
        mut current: Planes,
        alignment: Alignment,
        settings: &FrameSettings,
    ) -> Result<(), ImageError> {
        let FrameSettings { run, frame, is_still, .. } = *settings;
        self.past.still_count = if is_still { self.past.still_count + 1 } else { 0 };
        let Settings { size, seed, .. } = run;
        let reprojection = Reprojection { alignment, size, region: run.region(), frame, seed };
        let layers = self.antialiasing.technique().resolve(&self.past, &mut current, reprojection)?;
        self.past = Past { planes: current, layers, count: self.past.count + 1, ..self.past };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More than any technique's jitter repeats after.
    const FRAMES: u32 = 64;

    #[test]
    fn every_technique_parses_by_its_own_name_and_prints_it_back() {
        for info in ANTIALIASINGS {
            let antialiasing: Antialiasing = info.id.parse().unwrap();
            assert_eq!(antialiasing.info().id, info.id);
            assert_eq!(antialiasing.to_string(), info.id, "defaults are not printed");
            let typed = info.parameters.iter().map(|known| (known.key, known.default.to_owned()));
            assert!(antialiasing.values().eq(typed), "{}", info.id);
        }
        assert_eq!(Antialiasing::default().to_string(), "taa");
    }

    #[test]
    fn a_wrong_name_or_key_says_what_there_is() {
        let unknown = "fxaa".parse::<Antialiasing>().unwrap_err().to_string();
        assert!(unknown.contains("'fxaa'; there are: none, accumulate, taa"), "{unknown}");
        let key = "none:weight=1".parse::<Antialiasing>().unwrap_err().to_string();
        assert!(key.contains("anti-aliasing 'none'") && key.contains("'weight'"), "{key}");
    }

    #[test]
    fn every_jitter_is_balanced_and_stays_inside_the_pixel() {
        for info in ANTIALIASINGS {
            let antialiasing: Antialiasing = info.id.parse().unwrap();
            let offsets: Vec<Vec2> = (0..FRAMES).map(|frame| jitter(antialiasing, frame)).collect();
            assert!(offsets.iter().all(|offset| offset.abs().max_element() < 0.5), "{}", info.id);
            let mean = offsets.iter().sum::<Vec2>() / FRAMES as f32;
            assert!(mean.abs().max_element() < 0.05, "{}: {mean}", info.id);
        }
        assert_eq!(jitter(Antialiasing::NONE, 7), Vec2::ZERO);
        assert_eq!(jitter(Antialiasing::TAA, 3), jitter(Antialiasing::TAA, 19));
        assert_ne!(jitter(Antialiasing::ACCUMULATE, 3), jitter(Antialiasing::ACCUMULATE, 19));
    }

    /// Histories of one pixel after frames that show `values`.
    fn added(antialiasing: Antialiasing, values: &[f32]) -> [f32; 4] {
        let mut history = History::new(antialiasing, [1, 1]).unwrap();
        add(&mut history, values)
    }

    fn add(history: &mut History, values: &[f32]) -> [f32; 4] {
        let run = Settings { size: [1, 1], ..Default::default() };
        for (frame, &value) in (0..).zip(values) {
            let mut planes = Planes::new(1, 1).unwrap();
            planes.colour[(0, 0)] = [value; 4];
            history
                .add(
                    planes,
                    Alignment::NONE,
                    &FrameSettings { run, frame, jitter: Vec2::ZERO, layers: None, is_still: false },
                )
                .unwrap();
        }
        history.planes().colour[(0, 0)]
    }

    #[test]
    fn what_stands_still_stays_as_it_is_under_every_technique() {
        for info in ANTIALIASINGS {
            assert_eq!(added(info.id.parse().unwrap(), &[0.5; 5]), [0.5; 4], "{}", info.id);
        }
    }

    #[test]
    fn a_history_that_is_reset_is_as_good_as_new() {
        for info in ANTIALIASINGS {
            let mut history = History::new(info.id.parse().unwrap(), [1, 1]).unwrap();
            let before = add(&mut history, &[0.3, 0.7, f32::INFINITY]);
            history.reset();
            let after = add(&mut history, &[0.1, 0.2]);
            assert_eq!(after, added(info.id.parse().unwrap(), &[0.1, 0.2]), "{}", info.id);
            assert_ne!(before, after);
        }
    }

    #[test]
    fn accumulation_is_the_plain_mean_and_no_anti_aliasing_the_last_frame() {
        assert_eq!(added(Antialiasing::ACCUMULATE, &[1.0, 2.0, 6.0]), [3.0; 4]);
        assert_eq!(added(Antialiasing::NONE, &[1.0, 2.0, 6.0]), [6.0; 4]);
    }
}
