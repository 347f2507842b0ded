//! Pictures that were made elsewhere, held against a reference, alone or as frames of a clip.

use sheer_image::{Image, Picture, Tone, display};
use sheer_metrics::{error_map, video_vdp_jod};

use crate::{
    ERROR_FULL_SCALE, LabError, Result, Seeded,
    figures::{Column, Figures, Name},
    quality::Quality,
    shown::Shown,
};

/// How a picture, or a clip, does against a reference: means over its frames.
#[derive(Clone, Debug)]
pub struct Judged {
    /// What it is called.
    pub name: String,
    /// How many frames were held against those of the reference.
    pub frames: u32,
    /// Structural similarity as displayed; 1: equal.
    pub ssim: f64,
    /// Peak signal-to-noise ratio as displayed, decibels; none where it equals the reference.
    pub psnr_db: Option<f64>,
    /// Of the differences of successive displayed frames; none where they equal those of the reference, or
    /// for one frame.
    pub tpsnr_db: Option<f64>,
    /// ColorVideoVDP in just-objectionable differences, 10: no visible one; where it was asked for.
    pub vdp_jod: Option<f64>,
    /// FLIP as displayed; 0: equal.
    pub flip: f64,
    /// Standard deviation of the displayed error over time; none for one frame.
    pub flicker: Option<f64>,
    /// Root mean square error in linear light.
    pub rms: f64,
    /// Mean error in linear light, with its sign.
    pub bias: f64,
    /// The last frame as a display shows it: sRGB, straight alpha.
    pub picture: Image<[u8; 4]>,
    /// Where its error is, in false colours up to [`ERROR_FULL_SCALE`].
    pub error_map: Image<[u8; 4]>,
}

/// How frames are held against those of a reference.
#[derive(Clone, Copy, Debug, Default)]
pub struct Judging {
    /// How linear light is shown.
    pub tone: Tone,
    /// At which a clip is played, for the metric that judges it as a whole; none leaves that out.
    pub vdp_frames_per_sec: Option<f32>,
}

impl Judging {
    /// Holds a clip of one frame or more against a reference of as many. `frame` reads a frame of the
    /// reference and the one that is held against it, by their number from 0.
    ///
    /// # Errors
    /// What `frame` says; [`LabError::Misuse`] if two pictures differ in size, or there is no frame;
    /// [`LabError`] of the metric if they are too small for it.
    pub fn judge(
        &self,
        name: &str,
        frames: u32,
        mut frame: impl FnMut(u32) -> Result<(Picture, Picture)>,
    ) -> Result<Judged> {
        let mut judgement = Judgement::new(*self);
        let mut last = None;
        for index in 0..frames {
            let (reference, picture) = frame(index)?;
            let shown = |picture: &Picture| Shown::new(&picture.colour, self.tone, &picture.share);
            let (expected, found) = (shown(&reference), shown(&picture));
            judgement.add(name, &expected, &found)?;
            last = Some((expected, found, picture));
        }
        let Some((expected, found, picture)) = last else {
            return Err(LabError::Misuse(format!("{name} has no frame to hold against the reference")));
        };
        judgement.judged(name, &expected, &found, &picture)
    }
}

/// A clip on its way to [`Judged`].
pub(crate) struct Judgement {
    judging: Judging,
    frames: u32,
    quality: Quality,
    /// Frames of the reference and of the clip, where they are judged as a whole.
    clips: [Vec<Image<[u8; 3]>>; 2],
}

impl Judgement {
    pub(crate) fn new(judging: Judging) -> Self {
        Self { judging, frames: 0, quality: Quality::default(), clips: Default::default() }
    }

    /// Takes the next frame.
    ///
    /// # Errors
    /// [`LabError::Misuse`] if it differs in size from the reference; [`LabError`] of the metrics if it is
    /// too small for them.
    pub(crate) fn add(&mut self, name: &str, expected: &Shown, found: &Shown) -> Result<()> {
        let sizes = [expected.linear.size(), found.linear.size()];
        if sizes[0] != sizes[1] {
            let [(w, h), (width, height)] = sizes;
            return Err(LabError::Misuse(format!(
                "{name} is {width}x{height} and the reference {w}x{h}: pictures are compared pixel by pixel"
            )));
        }
        self.frames += 1;
        self.quality.add(expected, found)?;
        if self.judging.vdp_frames_per_sec.is_some() {
            for (clip, frame) in self.clips.iter_mut().zip([expected, found]) {
                clip.push(frame.in_bytes());
            }
        }
        Ok(())
    }

    /// What came of it, with the last frame that it took.
    pub(crate) fn judged(
        &self,
        name: &str,
        expected: &Shown,
        found: &Shown,
        picture: &Picture,
    ) -> Result<Judged> {
        let Self { judging: Judging { tone, vdp_frames_per_sec }, frames, ref quality, ref clips } = *self;
        let vdp_jod = vdp_frames_per_sec.map(|per_sec| video_vdp_jod(&clips[0], &clips[1], per_sec));
        Ok(Judged {
            name: name.to_owned(),
            frames,
            ssim: quality.ssim(),
            psnr_db: quality.psnr_db(),
            tpsnr_db: quality.tpsnr_db(),
            vdp_jod: vdp_jod.transpose()?,
            flip: quality.flip(),
            flicker: (frames > 1).then(|| quality.flicker()),
            rms: quality.rms(),
            bias: quality.bias(),
            picture: display(&picture.colour, tone, &picture.share),
            error_map: error_map(&expected.displayed, &found.displayed, ERROR_FULL_SCALE)?,
        })
    }
}

/// What figures are shown, in their order.
const COLUMNS: &[Column<Judged>] = &[
    Column {
        title: "frames",
        meaning: "How many frames were held against those of the reference; figures are means over them.",
        decimals: 0,
        is_optional: false,
        is_time: false,
        value: |row| Some(f64::from(row.frames)),
    },
    Column {
        title: "SSIM",
        meaning: "Structural similarity to the reference as displayed. 1 is the same picture; above 0.98 few people see a difference.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.ssim),
    },
    Column {
        title: "PSNR dB",
        meaning: "Peak signal-to-noise ratio as displayed, decibels: 6 more means half the error. A dash: no error at all.",
        decimals: 2,
        is_optional: false,
        is_time: false,
        value: |row| row.psnr_db,
    },
    Column {
        title: "tPSNR dB",
        meaning: "Peak signal-to-noise ratio of the change from one frame to the next, decibels: what shimmers lowers it, a steady error does not. A dash: no error at all.",
        decimals: 2,
        is_optional: true,
        is_time: false,
        value: |row| row.tpsnr_db,
    },
    Column {
        title: "VDP JOD",
        meaning: "ColorVideoVDP: quality to a viewer before a 30 inch 4K monitor in an office. 10 is no visible difference; at 9, three in four viewers prefer the reference.",
        decimals: 3,
        is_optional: true,
        is_time: false,
        value: |row| row.vdp_jod,
    },
    Column {
        title: "FLIP",
        meaning: "Difference that an eye would notice when the two pictures alternate on a display. 0 is none, 1 the most.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.flip),
    },
    Column {
        title: "flicker",
        meaning: "How much the error changes from frame to frame: its standard deviation over time, display white being 1.",
        decimals: 4,
        is_optional: true,
        is_time: false,
        value: |row| row.flicker,
    },
    Column {
        title: "RMS",
        meaning: "Root mean square error in linear light.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.rms),
    },
    Column {
        title: "bias",
        meaning: "Mean error in linear light with its sign. Above 0 is too bright.",
        decimals: 5,
        is_optional: false,
        is_time: false,
        value: |row| Some(row.bias),
    },
];

/// The figure of this title.
pub(crate) fn figure(judged: &Judged, title: &str) -> Option<f64> {
    let column = COLUMNS.iter().find(|column| column.title == title)?;
    (column.value)(judged)
}

/// What a row is.
const NAMES: [Name<Judged>; 1] = [("picture", |row| row.name.clone())];

/// The table; of pictures that were made with several seeds it has means with their intervals.
#[must_use]
pub fn picture_figures<'r>(rows: impl IntoIterator<Item = &'r Seeded<Judged>>) -> Figures {
    Figures::over_seeds(&NAMES, COLUMNS, rows)
}

#[cfg(test)]
mod tests {
    use sheer_image::DisplayShare;

    use super::*;

    const JUDGING: Judging = Judging {
        tone: Tone { curve: sheer_image::ToneCurve::PbrNeutral, exposure_ev: 0.0 },
        vdp_frames_per_sec: None,
    };

    fn grey(value: f32) -> Picture {
        let colour = Image::filled(16, 16, [value, value, value, 1.0]).unwrap();
        Picture { colour, share: DisplayShare::Everything }
    }

    #[test]
    fn a_picture_equals_itself_and_a_brighter_one_does_not() {
        let same = JUDGING.judge("same", 1, |_| Ok((grey(0.5), grey(0.5)))).unwrap();
        assert_eq!((same.rms, same.bias, same.psnr_db, same.flicker), (0.0, 0.0, None, None));
        let brighter = JUDGING.judge("brighter", 1, |_| Ok((grey(0.5), grey(0.75)))).unwrap();
        assert!((brighter.bias - 0.25).abs() < 1e-6 && (brighter.rms - 0.25).abs() < 1e-6, "{brighter:?}");
        assert!(brighter.ssim < 1.0 && brighter.flip > 0.0);
    }

    #[test]
    fn a_steady_error_does_not_flicker_and_one_that_comes_and_goes_does() {
        let error_of = |index: u32| if index.is_multiple_of(2) { 0.5 } else { 0.6 };
        let steady = JUDGING.judge("steady", 4, |_| Ok((grey(0.5), grey(0.6)))).unwrap();
        let flickering =
            JUDGING.judge("flickering", 4, |index| Ok((grey(0.5), grey(error_of(index))))).unwrap();
        assert!(steady.flicker.unwrap() < 1e-6, "{:?}", steady.flicker);
        assert!(flickering.flicker.unwrap() > 0.01, "{:?}", flickering.flicker);
        assert!(flickering.tpsnr_db.unwrap() < 40.0);
    }

    #[test]
    fn pictures_of_two_sizes_are_refused() {
        let small = Picture { colour: Image::filled(8, 8, [0.0; 4]).unwrap(), ..grey(0.0) };
        let refused = JUDGING.judge("a.png", 1, |_| Ok((grey(0.0), small.clone()))).unwrap_err().to_string();
        assert!(refused.contains("a.png is 8x8 and the reference 16x16"), "{refused}");
    }
}
