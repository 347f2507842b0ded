//! What frames are rendered with, from keywords to the library's settings.

use pyo3::{exceptions::PyValueError, prelude::*};
use sheer_core::{parameter::Choice as _, suggestion::suggestion};
use sheer_image::{Tone, ToneCurve};
use sheer_render::{
    Antialiasing, Background, Method, Settings, Shadow,
    limits::{FRAME_RATES, LAST_FRAME, LONGEST_SIDE_PX, MOST_EXPOSURE_EV, MOST_FRAMES, MOST_THREADS},
};

use crate::error::Raise as _;

/// Keywords that all runs have.
pub(crate) struct Keywords<'a> {
    pub(crate) size: (u32, u32),
    pub(crate) first_frame: u32,
    pub(crate) time: f32,
    pub(crate) fps: f32,
    pub(crate) background: &'a str,
    pub(crate) shadow: Option<&'a str>,
    pub(crate) tone: Option<&'a str>,
    pub(crate) exposure: f32,
    pub(crate) seed: u32,
}

impl Keywords<'_> {
    /// The library's settings.
    pub(crate) fn settings(&self) -> PyResult<Settings> {
        let (width, height) = self.size;
        if ![width, height].iter().all(|side| (1..=LONGEST_SIDE_PX).contains(side)) {
            let problem = format!(
                "size is ({width}, {height}): give width and height, each from 1 to {LONGEST_SIDE_PX}"
            );
            return Err(PyValueError::new_err(problem));
        }
        check(
            self.first_frame <= LAST_FRAME,
            "first_frame",
            self.first_frame,
            format!("an index up to {LAST_FRAME}"),
        )?;
        check(self.time.is_finite(), "time", self.time, "a number of seconds".to_owned())?;
        let (least, most) = FRAME_RATES.into_inner();
        check(
            FRAME_RATES.contains(&self.fps),
            "fps",
            self.fps,
            format!("frames a second from {least} to {most}"),
        )?;
        let stops = format!("stops from -{MOST_EXPOSURE_EV} to {MOST_EXPOSURE_EV}");
        check(self.exposure.abs() <= MOST_EXPOSURE_EV, "exposure", self.exposure, stops)?;
        let background: Result<Background, String> = self.background.parse();
        let background = background.map_err(|problem| {
            PyValueError::new_err(format!("background is {:?}: {problem}", self.background))
        })?;
        let shadow = self.shadow.map_or(Ok(Shadow::default()), |text| {
            text.parse().map_err(|error: sheer_render::shadow::ShadowError| error.raise())
        })?;
        Ok(Settings {
            size: [width, height],
            crop: None,
            seed: self.seed,
            background,
            shadow,
            start_secs: self.time,
            first_frame: self.first_frame,
            frames_per_sec: self.fps,
            raw: false,
            tone: Tone {
                curve: self.tone.map_or(Ok(ToneCurve::default()), curve)?,
                exposure_ev: self.exposure,
            },
        })
    }
}

fn curve(text: &str) -> PyResult<ToneCurve> {
    ToneCurve::from_word(text).ok_or_else(|| {
        let words = ToneCurve::WORDS;
        let nearest = suggestion(text, words.iter().copied());
        PyValueError::new_err(format!(
            "there is no tone curve {text:?}; there are: {}{nearest}",
            words.join(", ")
        ))
    })
}

/// Refuses a value that cannot be.
pub(crate) fn check(is_sound: bool, name: &str, value: impl ToString, wanted: String) -> PyResult<()> {
    if is_sound {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("{name} is {}: give {wanted}", value.to_string())))
}

/// Refuses what no run has: frames, and threads.
pub(crate) fn check_run(frames: u32, threads: Option<usize>) -> PyResult<()> {
    check(
        (1..=MOST_FRAMES).contains(&frames),
        "frames",
        frames,
        format!("a number from 1 to {MOST_FRAMES}"),
    )?;
    let is_sound = threads.is_none_or(|threads| (1..=MOST_THREADS).contains(&threads));
    check(
        is_sound,
        "threads",
        threads.unwrap_or(0),
        format!("a number from 1 to {MOST_THREADS}, or None for all processors"),
    )
}

/// A method as the command line names it.
pub(crate) fn method(text: &str) -> PyResult<Method> {
    text.parse::<Method>().map_err(|error| error.raise())
}

/// Anti-aliasing as the command line names it.
pub(crate) fn antialiasing(text: &str) -> PyResult<Antialiasing> {
    text.parse::<Antialiasing>().map_err(|error| error.raise())
}

/// The names of the transparency methods; each takes keys as in "std:hybrid=0.5".
#[pyfunction]
pub(crate) fn methods() -> Vec<&'static str> {
    sheer_render::method::METHODS.iter().map(|method| method.id).collect()
}
