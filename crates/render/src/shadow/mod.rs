//! Shadows: how much light passes everything between a light and a point. One technique a file; to add one,
//! write `shadow/<name>.rs` after the pattern of its neighbours and put its name into the table below: the
//! command line, the lists and the tests that walk all follow.
//!
//! A technique makes a `Map` for each light at the start of a frame, and shading asks it. Maps are traced
//! from the light through the texels of a `projection`; deep rays need none.

use std::{fmt, str::FromStr, time::Instant};

use glam::Vec3;
use sheer_core::{
    hash::pcg3d,
    parameter::{Values, split_name},
    suggestion::suggestion,
};
use sheer_scene::FrameLight;

use self::technique::{Map, Technique, View};
pub(crate) use self::technique::{Receiver, toward};
pub use self::{
    mask::Sampling,
    technique::{LIFT_ROUNDING, ShadowInfo},
};
use crate::{cost::Counters, error::RenderError, stage::Stage};

mod blockers;
mod mask;
pub mod projection;
mod technique;
pub mod visibility;

/// Why there is no such technique.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShadowError {
    /// No technique has that name.
    #[error("there is no shadow technique '{name}'; there are: {known}{}", suggestion(.name, .known.split(", ")))]
    Unknown {
        /// What was asked for.
        name: String,
        /// The names of all techniques, separated by commas.
        known: String,
    },
    /// A key or a value is off.
    #[error("shadow technique '{technique}': {problem}")]
    Parameter {
        /// The name of the technique.
        technique: &'static str,
        /// What is wrong and what is allowed.
        problem: String,
    },
}

macro_rules! shadows {
    ($($module:ident :: $name:ident),+ $(,)?) => {
        $(mod $module;)+

        #[derive(Clone, Copy, Debug, PartialEq)]
        enum Kind {
            $($name($module::$name),)+
        }

        /// All techniques, in the order in which they are listed.
        pub const SHADOWS: &[ShadowInfo] = &[$($module::INFO),+];

        impl Shadow {
            /// What lists and help say of it.
            #[must_use]
            pub fn info(&self) -> &'static ShadowInfo {
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

        impl FromStr for Shadow {
            type Err = ShadowError;

            fn from_str(text: &str) -> Result<Self, ShadowError> {
                let (name, settings) = split_name(text);
                $(if name == $module::INFO.id {
                    let values = Values::parse($module::INFO.parameters, settings)
                        .map_err(|problem| ShadowError::Parameter { technique: $module::INFO.id, problem })?;
                    return Ok(Self { kind: Kind::$name($module::$name::new(&values)) });
                })+
                let known = SHADOWS.iter().map(|info| info.id).collect::<Vec<_>>().join(", ");
                Err(ShadowError::Unknown { name: name.to_owned(), known })
            }
        }
    };
}

shadows! {
    deep::Deep,
    stochastic_map::StochasticMap,
    deep_map::DeepMap,
    opacity_map::OpacityMap,
    fourier::Fourier,
}

/// A shadow technique with its parameters. Parse one from `name:key=value,key=value`; it prints with all its
/// keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    kind: Kind,
}

impl Shadow {
    /// Whether what light arrives hangs on the seed of a run, even where methods are exact.
    #[must_use]
    pub fn is_random(&self) -> bool {
        self.technique().is_random()
    }

    /// The value of one of its keys, as it would be typed; None if it has no such key.
    #[must_use]
    pub fn value(&self, key: &str) -> Option<String> {
        let index = self.info().parameters.iter().position(|parameter| parameter.key == key)?;
        self.technique().values().into_iter().nth(index)
    }
}

impl Default for Shadow {
    fn default() -> Self {
        Self { kind: Kind::Deep(deep::Deep) }
    }
}

impl fmt::Display for Shadow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.info().id)?;
        let values = self.technique().values();
        for (index, (parameter, value)) in self.info().parameters.iter().zip(values).enumerate() {
            write!(f, "{}{}={value}", if index == 0 { ':' } else { ',' }, parameter.key)?;
        }
        Ok(())
    }
}

/// The most bytes that the maps of a frame may take: more is a slip rather than a wish.
const MOST_BYTES: usize = 4 << 30;

/// Pixels of a picture of which nothing is known.
const USUAL_PIXELS: usize = 1 << 18;

/// The shadows of one frame: a map for each light.
#[derive(Debug)]
pub struct Shadows {
    maps: Vec<Box<dyn Map>>,
    rays: u64,
    build_ms: f64,
}

impl Shadows {
    /// Makes the maps of a stage's lights for frame `frame` of a run with a seed.
    ///
    /// # Errors
    /// [`RenderError::ShadowMaps`] if they would take too much memory.
    pub fn new(stage: &Stage, shadow: &Shadow, frame: u32, seed: u32) -> Result<Self, RenderError> {
        Self::for_pixels(stage, shadow, frame, seed, USUAL_PIXELS)
    }

    /// The same for a picture of so many pixels: what is worth making depends on how often it is asked.
    pub(crate) fn for_pixels(
        stage: &Stage,
        shadow: &Shadow,
        frame: u32,
        seed: u32,
        pixels: usize,
    ) -> Result<Self, RenderError> {
        let start = Instant::now();
        let technique = shadow.technique();
        let channels = if stage.frame().tints_light() { 3 } else { 1 };
        let lights = stage.frame().lights();
        let count = |light| projection::texel_count(light, technique.resolution());
        let texels: usize = lights.iter().map(count).sum();
        let bytes = texels.saturating_mul(technique.texel_bytes(channels));
        if bytes > MOST_BYTES {
            return Err(RenderError::ShadowMaps { lights: lights.len(), mebibytes: bytes >> 20 });
        }
        let maps = stage.pool().install(|| {
            let map = |(index, light): (usize, &FrameLight)| {
                let [key, ..] = pcg3d([frame, seed, index as u32]);
                technique.map(&View { stage, light, pixels, channels, key })
            };
            lights.iter().enumerate().map(map).collect()
        });
        Ok(Self { maps, rays: texels as u64, build_ms: start.elapsed().as_secs_f64() * 1e3 })
    }

    /// Milliseconds that making the maps took.
    #[must_use]
    pub fn build_ms(&self) -> f64 {
        self.build_ms
    }

    /// How many rays made them.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Share of the light of one of the frame's lights, red, green and blue, that arrives at a point of a
    /// surface with a unit normal; textures in between are seen to the texel. `key` is hashed where taps are
    /// random.
    ///
    /// # Panics
    /// If the stage's frame has no such light.
    #[must_use]
    pub fn transmittance(
        &self,
        stage: &Stage,
        light: usize,
        position: Vec3,
        normal: Vec3,
        key: [u32; 3],
    ) -> Vec3 {
        let (to_light, distance) = toward(&stage.frame().lights()[light], position);
        let receiver = Receiver { position, normal, to_light, distance, width: 0.0, key };
        self.at(stage, light, &receiver, &mut Counters::default())
    }

    pub(crate) fn at(
        &self,
        stage: &Stage,
        light: usize,
        receiver: &Receiver,
        counters: &mut Counters,
    ) -> Vec3 {
        self.maps[light].transmittance(stage, receiver, counters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_technique_parses_by_its_own_name_and_prints_all_its_keys() {
        for info in SHADOWS {
            let shadow: Shadow = info.id.parse().unwrap();
            assert_eq!(shadow.info().id, info.id);
            let text = shadow.to_string();
            assert_eq!(text.parse(), Ok(shadow), "{text}");
            for known in info.parameters {
                assert_eq!(shadow.value(known.key).as_deref(), Some(known.default), "{text}");
            }
            assert_eq!(shadow.value("depth-of-field"), None);
            let defaults = info.parameters.iter().map(|known| format!("{}={}", known.key, known.default));
            let defaults = defaults.collect::<Vec<_>>().join(",");
            assert_eq!(
                text,
                if defaults.is_empty() { info.id.to_owned() } else { format!("{}:{defaults}", info.id) }
            );
        }
        assert_eq!(Shadow::default().to_string(), "deep");
    }

    #[test]
    fn a_wrong_name_or_key_says_what_there_is() {
        let unknown = "shallow".parse::<Shadow>().unwrap_err().to_string();
        assert!(unknown.contains("deep, stochastic-map, deep-map, opacity-map, fourier"), "{unknown}");
        let key = "fourier:layers=3".parse::<Shadow>().unwrap_err().to_string();
        assert!(key.contains("terms (1..="), "{key}");
        assert!("stochastic-map:samples=65".parse::<Shadow>().is_err(), "a mask has 64 bits");
    }
}
