//! The truth: the exact answer with many samples a pixel at the moment of a frame.
//!
//! A history shows the past, so the exact answer under the same anti-aliasing has errors of its own: it is
//! blurred by resampling and trails ghosts. What it should converge to is a picture of one moment,
//! anti-aliased by nothing but samples of that moment: the exact method under `accumulate`, the stage held.
//!
//! It is dear, so it is made for the last quarter of the frames alone, before the clip is played, and kept:
//! all methods and all anti-aliasings of a run share it.

use sheer_core::coverage::Correction;
use sheer_image::{DisplayShare, Image, Tone, display};
use sheer_metrics::Uncovering;
use sheer_render::{Antialiasing, Backend, Counters, Method, Moment, Settings};

use crate::{
    LabError, Progress, REFERENCE, Reference, Result, Timeline,
    play::{Event, pipelines, play},
    shown::Shown,
};

/// Of the frames of a clip one in so many is judged against the truth: the last ones.
const SHARE: u32 = 4;
/// Surfaces of a lower opacity than this count as none where it is asked what hides what.
const FAINTEST: f32 = 0.05;
/// How fast coverage rises from nothing to all at an opacity of [`FAINTEST`].
const STEEP: f32 = 1e6;

/// The exact answer with many samples a pixel at moments of a clip, made as they are asked for.
#[derive(Debug)]
pub struct Truth {
    settings: Settings,
    samples: u32,
    frames: Vec<TruthFrame>,
}

/// A frame of the truth.
#[derive(Debug)]
pub(crate) struct TruthFrame {
    moment: Moment,
    /// Linear, premultiplied.
    pub(crate) colour: Image<[f32; 4]>,
    /// How much of it is display-referred.
    share: DisplayShare,
    /// Pixels that were [uncovered](Uncovering) lately.
    pub(crate) uncovered: Image<bool>,
}

impl TruthFrame {
    /// As figures see it.
    pub(crate) fn shown(&self, tone: Tone) -> Shown {
        Shown::new(&self.colour, tone, &self.share)
    }
}

impl Truth {
    /// Of clips with these settings, all of one scene; nothing is rendered yet.
    #[must_use]
    pub fn new(settings: Settings, samples: u32) -> Self {
        Self { settings, samples, frames: Vec::new() }
    }

    /// The truth that is among the references of clips with these settings, if one is.
    ///
    /// # Errors
    /// [`LabError::Misuse`] if there are two.
    pub fn among(references: &[Reference], settings: Settings) -> Result<Option<Self>> {
        let mut samples = references.iter().filter_map(|reference| match *reference {
            Reference::Truth { samples } => Some(samples),
            Reference::Same => None,
        });
        let truth = samples.next().map(|samples| Self::new(settings, samples));
        if samples.next().is_some() {
            let problem = "there is one truth a comparison; give --reference truth:samples=N once";
            return Err(LabError::Misuse(problem.to_owned()));
        }
        Ok(truth)
    }

    /// What its clips have in common.
    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The last frame of a clip that has been played, as a display shows it: sRGB, straight alpha.
    #[must_use]
    pub fn picture(&self, timeline: Timeline<'_>) -> Option<Image<[u8; 4]>> {
        let last = self.of_frame(timeline, timeline.frames().checked_sub(1)?)?;
        Some(display(&last.colour, self.settings.tone, &last.share))
    }

    /// The first frame of a clip that is judged against the truth.
    fn first_judged(timeline: Timeline<'_>) -> u32 {
        let count = timeline.frames();
        count.saturating_sub((count / SHARE).max(1))
    }

    /// The truth of a frame that is judged, counted from the clip's first.
    pub(crate) fn of_frame(&self, timeline: Timeline<'_>, index: u32) -> Option<&TruthFrame> {
        let moment = timeline.moment(index)?;
        let is_judged = index >= Self::first_judged(timeline);
        self.frames.iter().find(|frame| is_judged && frame.moment == moment)
    }

    /// Renders what a clip needs and is not there yet. The stage is left where it was needed last.
    ///
    /// # Errors
    /// What the backend says; [`LabError::Misuse`] if it does not run what the truth takes.
    pub(crate) fn render<B: Backend>(
        &mut self,
        backend: &B,
        stage: &mut B::Stage,
        timeline: Timeline<'_>,
        progress: &dyn Progress,
    ) -> Result<()> {
        let end = timeline.frames();
        let first = Self::first_judged(timeline);
        let missing = (first..end).filter(|&index| self.of_frame(timeline, index).is_none());
        let missing: Vec<u32> = missing.collect();
        let Some(&first) = missing.first() else { return Ok(()) };
        // Where time stands still, one moment has the truth of all frames.
        let stands = timeline.moment(first).is_some_and(|moment| moment.time_secs == moment.previous_secs);
        let count = if stands { 1 } else { missing.len() as u32 };
        progress.expect(u64::from(count) * u64::from(self.samples));

        // From as many frames before as an uncovered pixel may have been hidden in.
        let mut nearest = self.pipeline(backend, &nearest_surface()?, Antialiasing::NONE)?;
        let mut uncovering = Uncovering::new();
        let mut counters = Counters::default();
        let frames = match stands {
            true => first..first + 1,
            false => first.saturating_sub(Uncovering::FRAMES as u32)..end,
        };
        for index in frames {
            let Some(moment) = timeline.moment(index) else { break };
            let failed = |error| LabError::of_backend(backend, error);
            backend.advance(stage, moment).map_err(failed)?;
            backend.render(&mut nearest, stage, index).map_err(failed)?;
            let uncovered = uncovering.add(&*backend.planes(&nearest).map_err(failed)?)?;
            if index >= first && self.of_frame(timeline, index).is_none() {
                let colour = self.colour(backend, stage, &mut counters, progress)?;
                let share = backend.display_share(stage, &self.settings, Antialiasing::ACCUMULATE);
                let share = share.map_err(failed)?;
                self.frames.push(TruthFrame { moment, colour, share, uncovered });
            }
        }
        self.warn_of_overflow(backend, counters.merged, count, progress);
        Ok(())
    }

    /// The truth of the moment that the stage is at.
    fn colour<B: Backend>(
        &self,
        backend: &B,
        stage: &mut B::Stage,
        counters: &mut Counters,
        progress: &dyn Progress,
    ) -> Result<Image<[f32; 4]>> {
        let mut exact = [self.pipeline(backend, &REFERENCE.parse()?, Antialiasing::ACCUMULATE)?];
        play(backend, stage, &mut exact, Timeline::Still(self.samples), |event| {
            if let Event::Rendered { cost: (of_sample, _), .. } = event {
                *counters = *counters + of_sample;
                progress.step();
                progress.go_on()?;
            }
            Ok(())
        })?;
        let planes = backend.planes(&exact[0]).map_err(|error| LabError::of_backend(backend, error))?;
        Ok(planes.into_owned().colour)
    }

    fn pipeline<B: Backend>(
        &self,
        backend: &B,
        method: &Method,
        antialiasing: Antialiasing,
    ) -> Result<B::Pipeline> {
        // Jitter and the noise of shadow maps go by the number of the frame: all moments have the same.
        let settings = Settings { first_frame: 0, ..self.settings };
        let pipelines = pipelines(backend, [method], antialiasing, settings);
        let mut pipelines = pipelines.map_err(|error| match error {
            LabError::Unsupported(why) => LabError::Misuse(format!(
                "--backend {} has no truth, which takes {method} under {antialiasing}: {why}",
                backend.name()
            )),
            other => other,
        })?;
        Ok(pipelines.remove(0))
    }

    /// A rasteriser's lists hold so many fragments and no more.
    fn warn_of_overflow<B: Backend>(&self, backend: &B, merged: u64, moments: u32, progress: &dyn Progress) {
        if merged > 0 {
            let [width, height] = self.settings.size.map(f64::from);
            let per_pixel = merged as f64 / (width * height * f64::from(self.samples) * f64::from(moments));
            progress.warn(&format!(
                "the truth is not exact on {}: there was no place for {per_pixel:.3} fragments a pixel; take --backend gpu:ray or cpu",
                backend.name()
            ));
        }
    }
}

/// A method whose planes are those of the nearest surface, transparent or not, on any backend: all that is
/// more than faint counts as opaque.
fn nearest_surface() -> Result<Method> {
    let correction = Correction::new([-STEEP * FAINTEST, STEEP, 0.0, 0.0]).expect("the numbers are finite");
    Ok("roulette".parse::<Method>()?.with_correction(correction, "the nearest surface"))
}

#[cfg(test)]
mod tests {
    use sheer_render::{Stage, backend::Cpu};

    use super::*;
    use crate::{Clip, Measured, Silent, with_reference};

    const SIZE: [u32; 2] = [48, 27];

    fn stage(scene: &str, camera: &str) -> Stage {
        let camera = sheer_scene::CameraChoice::Named(camera.to_owned());
        Stage::new(sheer_gallery::open(scene).unwrap().scene, &camera, Some(1)).unwrap()
    }

    fn timeline(clip: &Clip) -> Timeline<'static> {
        Timeline::of(&clip.settings, clip.antialiasing, clip.frame_count)
    }

    fn clip(antialiasing: Antialiasing, frame_count: u32) -> Clip {
        let settings = Settings { size: SIZE, ..Settings::default() };
        Clip { settings, antialiasing, frame_count, keeps_frames: false }
    }

    /// The reference, then the methods.
    fn play_with(clip: &Clip, stage: &mut Stage, truth: &mut Truth, methods: &[&str]) -> Vec<Measured> {
        let methods = methods.iter().map(|method| method.parse().unwrap()).collect();
        let methods = with_reference(methods).unwrap();
        clip.play(&Cpu, stage, &methods, Some(truth), &Silent).unwrap()
    }

    #[test]
    fn the_truth_of_what_stands_still_is_what_accumulates_there() {
        let mut stage = stage("pane:alpha=1", "static");
        let clip = clip(Antialiasing::ACCUMULATE, 16);
        let mut truth = Truth::new(clip.settings, 16);
        let measured = play_with(&clip, &mut stage, &mut truth, &[]);
        assert_eq!(truth.frames.len(), 1, "one moment has one truth");
        assert_eq!(truth.picture(timeline(&clip)).as_ref(), Some(&measured[0].picture));
        let against = measured[0].against_truth.as_ref().unwrap();
        assert!(against.ghosting.is_none(), "nothing moves");
        // Negative control: other samples are another picture, as there are edges.
        let mut coarse = Truth::new(clip.settings, 1);
        let measured = play_with(&clip, &mut stage, &mut coarse, &[]);
        assert!(measured[0].against_truth.as_ref().unwrap().rms > 1e-3);
        assert_ne!(coarse.picture(timeline(&clip)).as_ref(), Some(&measured[0].picture));
    }

    #[test]
    fn a_method_without_bias_comes_near_the_truth_and_a_wrong_one_stays_off() {
        let mut stage = stage("pane", "static");
        let rms = |stage: &mut Stage, frame_count| {
            let clip = clip(Antialiasing::ACCUMULATE, frame_count);
            let mut truth = Truth::new(clip.settings, 64);
            let measured = play_with(&clip, stage, &mut truth, &["roulette", "roulette:correction=dlss"]);
            [1, 2].map(|at| measured[at].against_truth.as_ref().unwrap().rms)
        };
        let [few, _] = rms(&mut stage, 8);
        let [many, wrong] = rms(&mut stage, 128);
        // Sixteen times as many samples have a quarter of the noise.
        assert!(many < 0.35 * few, "{few}, {many}");
        assert!(wrong > 2.0 * many, "{many}, {wrong}");
    }

    #[test]
    fn the_last_quarter_is_judged_and_all_antialiasings_share_it() {
        let mut stage = stage("pane", "path");
        let of = |antialiasing| clip(antialiasing, 9);
        let mut truth = Truth::new(of(Antialiasing::NONE).settings, 2);
        let jagged = play_with(&of(Antialiasing::NONE), &mut stage, &mut truth, &["std"]);
        assert_eq!(truth.frames.len(), 2);
        let first = truth.frames[0].colour.clone();
        let smooth = play_with(&of(Antialiasing::TAA), &mut stage, &mut truth, &["std"]);
        assert_eq!(truth.frames.len(), 2);
        assert_eq!(truth.frames[0].colour, first);
        assert!(truth.of_frame(timeline(&of(Antialiasing::TAA)), 6).is_none());
        assert!(truth.of_frame(timeline(&of(Antialiasing::TAA)), 7).is_some());
        // The reference has errors of its own now, and every frame has changes.
        for measured in jagged.iter().chain(&smooth) {
            let against = measured.against_truth.as_ref().unwrap();
            assert!(against.ssim < 1.0 && against.tpsnr_db.is_some(), "{against:?}");
        }
        // A single frame is the last quarter of itself.
        let one = clip(Antialiasing::NONE, 1);
        let measured = play_with(&one, &mut stage, &mut Truth::new(one.settings, 2), &[]);
        assert!(measured[0].against_truth.as_ref().unwrap().tpsnr_db.is_none());
    }

    #[test]
    fn what_moves_uncovers_pixels_and_taa_leaves_ghosts_there() {
        let mut stage = stage("arena", "static");
        let settings = Settings { size: SIZE, start_secs: 6.0, ..Settings::default() };
        let of = |antialiasing| Clip { settings, ..clip(antialiasing, 12) };
        let mut truth = Truth::new(settings, 4);
        let ghosting = |clip: Clip, stage: &mut Stage, truth: &mut Truth| {
            let measured = play_with(&clip, stage, truth, &[]);
            measured[0].against_truth.as_ref().unwrap().ghosting.unwrap()
        };
        let [none, taa] = [Antialiasing::NONE, Antialiasing::TAA]
            .map(|antialiasing| ghosting(of(antialiasing), &mut stage, &mut truth));
        let uncovered: usize = truth
            .frames
            .iter()
            .map(|frame| frame.uncovered.as_slice().iter().filter(|uncovered| **uncovered).count())
            .sum();
        let pixels = truth.frames.len() * (SIZE[0] * SIZE[1]) as usize;
        assert!(uncovered > 0 && uncovered < pixels / 2, "{uncovered} of {pixels}");
        // Negative control: without a history there are no ghosts.
        assert!(none.abs() < 0.5 * taa.abs(), "{none}, {taa}");
    }

    #[test]
    fn a_clip_with_other_settings_is_refused() {
        let mut stage = stage("layers:count=1", "static");
        let clip = clip(Antialiasing::NONE, 1);
        let mut truth = Truth::new(Settings { seed: 1, ..clip.settings }, 1);
        let methods = with_reference(Vec::new()).unwrap();
        let refused = clip.play(&Cpu, &mut stage, &methods, Some(&mut truth), &Silent);
        assert!(matches!(refused, Err(LabError::Misuse(_))), "{refused:?}");
    }
}
