//! Methods that play the same clip and are held against the exact answer.

use sheer_image::{Image, Metadata, Planes, ToneCurve, display_over_black, encode_png, u8_from_unit};
use sheer_metrics::{Flicker, TemporalPsnr, bias, error_map, flip, psnr_db, rms, ssim, video_vdp_jod};
use sheer_render::{Antialiasing, Clock, Method, Settings};

use crate::{
    backend::Renderer,
    report::{json::ComparisonRow, page::comparison::Entry},
    tally::Tally,
};

/// The method that has no error, in all figures.
pub(crate) const REFERENCE: &str = "baseline";
/// Error of a displayed image that error maps show in their last colour.
pub(crate) const ERROR_FULL_SCALE: f32 = 0.25;

/// The methods with the reference among them, as the first unless the user placed it.
pub(crate) fn with_reference(mut methods: Vec<Method>) -> anyhow::Result<Vec<Method>> {
    if !methods.iter().any(|method| method.to_string() == REFERENCE) {
        methods.insert(0, REFERENCE.parse()?);
    }
    Ok(methods)
}

/// Frames under one anti-aliasing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clip {
    /// What all methods have in common.
    pub(crate) settings: Settings,
    /// How frames are added up.
    pub(crate) antialiasing: Antialiasing,
    /// How many frames.
    pub(crate) frame_count: u32,
    /// For the metric that judges a clip as a whole.
    pub(crate) keeps_frames: bool,
}

/// A method on its way through a clip.
struct Contestant<'m, P> {
    method: &'m Method,
    pipeline: P,
    tally: Tally,
    quality: Quality,
    /// The last half of the frames as a display shows them, where they are kept.
    shown: Vec<Image<[u8; 3]>>,
}

/// A frame as figures see it.
struct Shown {
    linear: Image<[f32; 3]>,
    displayed: Image<[f32; 3]>,
}

impl Shown {
    fn new(planes: &Planes) -> Self {
        let linear = planes.colour.par_map(|&[r, g, b, _]| [r, g, b]);
        Self { linear, displayed: display_over_black(&planes.colour, ToneCurve::default()) }
    }

    fn in_bytes(&self) -> Image<[u8; 3]> {
        self.displayed.par_map(|pixel| pixel.map(u8_from_unit))
    }
}

/// Sums over frames.
#[derive(Default)]
struct Quality {
    frames: u32,
    ssim: f64,
    psnr_db: f64,
    flip: f64,
    bias: f64,
    rms: f64,
    flicker: Flicker<3>,
    tpsnr: TemporalPsnr<3>,
}

impl Quality {
    fn add(&mut self, reference: &Shown, shown: &Shown) -> anyhow::Result<()> {
        self.frames += 1;
        self.ssim += ssim(&reference.displayed, &shown.displayed)?;
        self.psnr_db += psnr_db(&reference.displayed, &shown.displayed)?;
        self.flip += flip(&reference.displayed, &shown.displayed)?;
        self.bias += bias(&reference.linear, &shown.linear)?;
        self.rms += rms(&reference.linear, &shown.linear)?;
        self.flicker.add(&reference.displayed, &shown.displayed)?;
        self.tpsnr.add(&reference.displayed, &shown.displayed)?;
        Ok(())
    }

    fn mean(&self, sum: f64) -> f64 {
        sum / f64::from(self.frames)
    }
}

impl Clip {
    /// Renders all methods, the reference among them, frame by frame, so that a change in the machine's speed meets all of them and no clip has
    /// to be kept. `noted`: takes what the user should know; `rendered`: is called after every frame.
    pub(crate) fn play<R: Renderer>(
        &self,
        renderer: &R,
        stage: &mut R::Stage,
        methods: &[Method],
        mut noted: impl FnMut(&str),
        mut rendered: impl FnMut(),
    ) -> anyhow::Result<Vec<Entry>> {
        let contestant = |method| {
            let pipeline = renderer.pipeline(method, self.antialiasing, self.settings)?;
            let (tally, quality) = (Tally::default(), Quality::default());
            Ok(Contestant { method, pipeline, tally, quality, shown: Vec::new() })
        };
        let mut contestants = methods.iter().map(contestant).collect::<anyhow::Result<Vec<_>>>()?;
        for contestant in &contestants {
            renderer.notes(&contestant.pipeline).iter().for_each(|note| noted(note));
        }
        let reference_at = methods.iter().position(|method| method.to_string() == REFERENCE);
        let reference_at = reference_at.expect("the reference was put among the methods");
        let shown = |pipeline: &R::Pipeline| renderer.planes(pipeline).map(|planes| Shown::new(&planes));
        let clock = Clock::new(&self.settings, self.antialiasing);
        for index in 0..self.frame_count {
            renderer.advance(stage, clock.at(index))?;
            for turn in 0..methods.len() {
                // No method is always the first after the change of frame.
                let contestant = &mut contestants[(turn + index as usize) % methods.len()];
                contestant.tally.add(renderer.render(&mut contestant.pipeline, stage, index)?);
                rendered();
            }
            // The history has settled in the last half.
            if index >= self.frame_count / 2 {
                let reference = shown(&contestants[reference_at].pipeline)?;
                for contestant in &mut contestants {
                    let shown = shown(&contestant.pipeline)?;
                    contestant.quality.add(&reference, &shown)?;
                    if self.keeps_frames {
                        contestant.shown.push(shown.in_bytes());
                    }
                }
            }
        }
        let reference = shown(&contestants[reference_at].pipeline)?;
        let reference_clip = &contestants[reference_at].shown;
        let entries = contestants.iter().enumerate().map(|(at, contestant)| {
            let vdp_jod = self
                .keeps_frames
                .then(|| video_vdp_jod(reference_clip, &contestant.shown, self.frames_per_sec()));
            let reference = (at != reference_at).then_some(&reference);
            self.entry(renderer, contestant, reference, vdp_jod.transpose()?)
        });
        entries.collect()
    }

    /// At which the clip is played.
    fn frames_per_sec(&self) -> f32 {
        // Frames that are added up at one moment are shown as fast as those that move.
        let moment =
            Clock::new(&Settings { start_secs: 0.0, first_frame: 0, ..self.settings }, Antialiasing::Taa)
                .at(1);
        1.0 / (moment.time_secs - moment.previous_secs)
    }

    fn entry<R: Renderer>(
        &self,
        renderer: &R,
        contestant: &Contestant<'_, R::Pipeline>,
        reference: Option<&Shown>,
        vdp_jod: Option<f64>,
    ) -> anyhow::Result<Entry> {
        let Contestant { method, pipeline, tally, quality, .. } = contestant;
        let planes = &*renderer.planes(pipeline)?;
        let [width, height] = self.settings.size;
        let pixels = f64::from(width) * f64::from(height);
        let hits_per_pixel = tally.hits() / pixels;
        let psnr_db = quality.mean(quality.psnr_db);
        let row = ComparisonRow {
            method: method.to_string(),
            aa: self.antialiasing.to_string(),
            ms_median: tally.ms(0.5),
            ms_min: tally.ms(0.0),
            ms_max: tally.ms(1.0),
            ssim: quality.mean(quality.ssim),
            psnr_db: psnr_db.is_finite().then_some(psnr_db),
            tpsnr_db: quality.tpsnr.value_db().filter(|tpsnr_db| tpsnr_db.is_finite()),
            vdp_jod,
            flip: Some(quality.mean(quality.flip)),
            flicker: quality.flicker.value(),
            bias: quality.mean(quality.bias),
            rms: quality.mean(quality.rms),
            shaded_per_pixel: tally.shaded() / pixels,
            hits_per_pixel,
            memory_bytes_per_pixel: renderer.bytes_per_pixel(pipeline, hits_per_pixel),
            merged_per_pixel: tally.merged() / pixels,
        };
        let plain = Metadata::default();
        let picture = sheer_image::display(&planes.colour, ToneCurve::default());
        let error = |reference: &Shown| -> anyhow::Result<Vec<u8>> {
            let map = error_map(&reference.displayed, &Shown::new(planes).displayed, ERROR_FULL_SCALE)?;
            Ok(encode_png(&map, &plain)?)
        };
        Ok(Entry {
            info: method.info(),
            row,
            frame_ms: tally.frame_ms(),
            picture_png: encode_png(&picture, &plain)?,
            error_png: reference.map(error).transpose()?,
        })
    }
}
