//! Methods that play the same clip and are held against the exact answer.

use sheer_image::{DisplayShare, Image, display};
use sheer_metrics::{Ghosting, error_map, video_vdp_jod};
use sheer_render::{Antialiasing, Backend, Clock, Method, Settings};

use crate::{
    Foreign, ForeignJudged, Judging, LabError, Measured, Progress, REFERENCE, Result, Seeded, Tally,
    Timeline, Truth,
    foreign::Beside,
    measured::AgainstTruth,
    play::{Event, pipelines, play},
    quality::{ERROR_FULL_SCALE, Quality},
    shown::Shown,
};

/// The methods with the reference among them, as the first unless the user placed it.
///
/// # Errors
/// None: the reference is a method.
pub fn with_reference(mut methods: Vec<Method>) -> Result<Vec<Method>> {
    if !methods.iter().any(|method| method.to_string() == REFERENCE) {
        methods.insert(0, REFERENCE.parse()?);
    }
    Ok(methods)
}

/// Frames under one anti-aliasing.
#[derive(Clone, Copy, Debug)]
pub struct Clip {
    /// What all methods have in common.
    pub settings: Settings,
    /// How frames are added up.
    pub antialiasing: Antialiasing,
    /// How many frames.
    pub frame_count: u32,
    /// For the metric that judges a clip as a whole.
    pub keeps_frames: bool,
}

/// What is known of a method on its way through a clip.
#[derive(Default)]
struct Record {
    tally: Tally,
    /// Against the reference under the same anti-aliasing.
    quality: Quality,
    /// Against the truth, where it is asked for.
    against_truth: Quality,
    ghosting: Ghosting<3>,
    /// The last half of the frames as a display shows them, where they are kept.
    shown: Vec<Image<[u8; 3]>>,
}

/// What the last frame of a clip and, where frames are kept, the clip as a whole are held against.
struct Judge<'a> {
    /// The last frame.
    last: &'a Shown,
    /// The frames that count, as a display shows them.
    clip: &'a [Image<[u8; 3]>],
}

impl Judge<'_> {
    fn error_map(&self, last: &Shown) -> Result<Image<[u8; 4]>> {
        Ok(error_map(&self.last.displayed, &last.displayed, ERROR_FULL_SCALE)?)
    }
}

impl Clip {
    /// Renders all methods, the reference among them, frame by frame, and holds each against the reference,
    /// and against the truth if there is one; one for each method, in order.
    ///
    /// # Errors
    /// What the backend says; [`LabError::Misuse`] if the reference is not among the methods, or the truth is
    /// one of other settings.
    pub fn play<B: Backend>(
        &self,
        backend: &B,
        stage: &mut B::Stage,
        methods: &[Method],
        truth: Option<&mut Truth>,
        progress: &dyn Progress,
    ) -> Result<Vec<Measured>> {
        let contestants = (methods, &[self.settings.seed][..]);
        let (measured, _) = self.play_beside(backend, stage, contestants, truth, &[], progress)?;
        Ok(measured.into_iter().map(Seeded::into_first).collect())
    }

    /// The same with each of several seeds, and with pictures of other programs beside the methods, held
    /// against the same frames. The reference is rendered once and stands for all seeds: where even shadows
    /// are random ([`Shadow::is_random`](sheer_render::Shadow::is_random)), give one seed at a time, which is
    /// that of the settings.
    ///
    /// # Errors
    /// Those of [`Self::play`], those of reading the pictures, and [`LabError::Misuse`] if one is not of the
    /// size of the clip or the last frame has none, or there is no seed.
    pub fn play_beside<B: Backend>(
        &self,
        backend: &B,
        stage: &mut B::Stage,
        contestants @ (_, seeds): (&[Method], &[u32]),
        truth: Option<&mut Truth>,
        foreign: &[Foreign<'_>],
        progress: &dyn Progress,
    ) -> Result<(Vec<Seeded<Measured>>, Vec<ForeignJudged>)> {
        if seeds.is_empty() {
            return Err(LabError::Misuse("there is no seed to render with".to_owned()));
        }
        let vdp_frames_per_sec = self.keeps_frames.then(|| self.frames_per_sec());
        let judging = Judging { tone: self.settings.tone, vdp_frames_per_sec };
        let mut beside = Beside::new(foreign, judging, self.frame_count);
        let measured = self.play_seeds(backend, stage, contestants, truth, &mut beside, progress)?;
        let seeded = measured.into_iter().filter_map(|mut runs| match runs.pop() {
            Some(run) if runs.is_empty() && seeds.len() > 1 => Some(Seeded::once_for_all(run)),
            last => {
                runs.extend(last);
                Seeded::of(runs)
            }
        });
        Ok((seeded.collect(), beside.judged(self.antialiasing)?))
    }

    /// The same with several seeds of each method, which share the reference and the truth: one for each seed
    /// of each method, and one for the reference.
    pub(crate) fn play_seeds<B: Backend>(
        &self,
        backend: &B,
        stage: &mut B::Stage,
        (methods, seeds): (&[Method], &[u32]),
        mut truth: Option<&mut Truth>,
        beside: &mut Beside<'_>,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Measured>>> {
        let is_reference = |method: &Method| method.to_string() == REFERENCE;
        let contestants: Vec<(&Method, u32)> = methods
            .iter()
            .flat_map(|method| {
                let seeds = if is_reference(method) { &seeds[..1] } else { seeds };
                seeds.iter().map(move |&seed| (method, seed))
            })
            .collect();
        let reference_at = contestants.iter().position(|(method, _)| is_reference(method));
        let reference_at = reference_at
            .ok_or_else(|| LabError::Misuse(format!("{REFERENCE} has to be among the methods")))?;
        let mut pipelines = Vec::with_capacity(contestants.len());
        for &(method, seed) in &contestants {
            let settings = Settings { seed, ..self.settings };
            pipelines.extend(self::pipelines(backend, [method], self.antialiasing, settings)?);
        }
        // Other seeds have the same to say.
        for (pipeline, _) in pipelines.iter().zip(&contestants).filter(|(_, (_, seed))| *seed == seeds[0]) {
            backend.notes(pipeline).iter().for_each(|note| progress.warn(note));
        }
        let tone = self.settings.tone;
        let frame_of = |pipeline: &B::Pipeline, share: &DisplayShare| {
            let planes = backend.planes(pipeline).map_err(|error| LabError::of_backend(backend, error))?;
            Ok::<_, LabError>(Shown::new(&planes.colour, tone, share))
        };
        // The same for all methods: it depends on what is seen, not on how that is found.
        let share_of = |stage: &B::Stage| {
            let share = backend.display_share(stage, &self.settings, self.antialiasing);
            share.map_err(|error| LabError::of_backend(backend, error))
        };

        // The frames of the truth come first: the stage has to be held at each of their moments.
        let timeline = Timeline::of(&self.settings, self.antialiasing, self.frame_count);
        if let Some(truth) = &mut truth {
            if *truth.settings() != self.settings {
                return Err(LabError::Misuse("the truth is one of a clip with other settings".to_owned()));
            }
            truth.render(backend, stage, timeline, progress)?;
        }
        let truth = truth.as_deref();

        // Frame by frame, and each held against the reference in the half of the frames that counts.
        let mut records: Vec<Record> = contestants.iter().map(|_| Record::default()).collect();
        let mut shown_truths = Vec::new();
        play(backend, stage, &mut pipelines, timeline, |event| {
            match event {
                Event::Rendered { at, cost, .. } => {
                    records[at].tally.add(cost);
                    progress.step();
                    progress.go_on()?;
                }
                // The history has settled in the last half.
                Event::Frame { index, pipelines, stage } if index >= self.frame_count / 2 => {
                    let share = share_of(stage)?;
                    let reference = frame_of(&pipelines[reference_at], &share)?;
                    let truth = truth.and_then(|truth| truth.of_frame(timeline, index));
                    let truth = truth.map(|truth| (truth.shown(tone), &truth.uncovered));
                    for (record, pipeline) in records.iter_mut().zip(pipelines) {
                        let shown = frame_of(pipeline, &share)?;
                        record.quality.add(&reference, &shown)?;
                        if let Some((truth, uncovered)) = &truth {
                            record.against_truth.add(truth, &shown)?;
                            record.ghosting.add(&truth.linear, &shown.linear, uncovered)?;
                        }
                        if self.keeps_frames {
                            record.shown.push(shown.in_bytes());
                        }
                    }
                    beside.add(
                        index,
                        &reference,
                        truth.as_ref().map(|(truth, uncovered)| (truth, *uncovered)),
                    )?;
                    if self.keeps_frames {
                        shown_truths.extend(truth.map(|(truth, _)| truth.in_bytes()));
                    }
                }
                Event::Frame { .. } => {}
            }
            Ok(())
        })?;

        // What remains to be judged once: the last picture, and the clip as a whole.
        let share = share_of(stage)?;
        let reference = frame_of(&pipelines[reference_at], &share)?;
        let reference = Judge { last: &reference, clip: &records[reference_at].shown };
        let last_truth = truth.and_then(|truth| truth.of_frame(timeline, self.frame_count - 1));
        let last_truth = last_truth.map(|truth| truth.shown(tone));
        let truth = last_truth.as_ref().map(|last| Judge { last, clip: &shown_truths });
        let mut measured: Vec<Vec<Measured>> = Vec::with_capacity(methods.len());
        for (at, ((&(method, seed), pipeline), record)) in
            contestants.iter().zip(&pipelines).zip(&records).enumerate()
        {
            let mut of_seed = self.measured(backend, (method, pipeline), &share, record)?;
            let last = frame_of(pipeline, &share)?;
            of_seed.vdp_jod = self.vdp_jod(&reference, record)?;
            if at != reference_at {
                of_seed.error_map = Some(reference.error_map(&last)?);
            }
            if let Some(truth) = &truth {
                of_seed.against_truth = Some(self.against_truth(truth, record, &last)?);
            }
            if seed == seeds[0] {
                measured.push(vec![of_seed]);
            } else {
                measured.last_mut().expect("the first seed comes first").push(of_seed);
            }
        }
        Ok(measured)
    }

    /// At which the clip is played.
    fn frames_per_sec(&self) -> f32 {
        // Frames that are added up at one moment are shown as fast as those that move.
        let moment =
            Clock::new(&Settings { start_secs: 0.0, first_frame: 0, ..self.settings }, Antialiasing::TAA)
                .at(1);
        1.0 / (moment.time_secs - moment.previous_secs)
    }

    /// Of the last of the frames that were kept, as many as there are to hold them against.
    fn vdp_jod(&self, judge: &Judge<'_>, record: &Record) -> Result<Option<f64>> {
        let judged = || &record.shown[record.shown.len() - judge.clip.len()..];
        let jod = self.keeps_frames.then(|| video_vdp_jod(judge.clip, judged(), self.frames_per_sec()));
        Ok(jod.transpose()?)
    }

    fn against_truth(&self, truth: &Judge<'_>, record: &Record, last: &Shown) -> Result<AgainstTruth> {
        let quality = &record.against_truth;
        Ok(AgainstTruth {
            ssim: quality.ssim(),
            psnr_db: quality.psnr_db(),
            tpsnr_db: quality.tpsnr_db(),
            vdp_jod: self.vdp_jod(truth, record)?,
            flip: quality.flip(),
            flicker: quality.flicker(),
            ghosting: record.ghosting.value(),
            bias: quality.bias(),
            rms: quality.rms(),
            error_map: truth.error_map(last)?,
        })
    }

    /// Everything that needs no more than the method's own record.
    fn measured<B: Backend>(
        &self,
        backend: &B,
        (method, pipeline): (&Method, &B::Pipeline),
        share: &DisplayShare,
        Record { tally, quality, .. }: &Record,
    ) -> Result<Measured> {
        let planes = backend.planes(pipeline).map_err(|error| LabError::of_backend(backend, error))?;
        let [width, height] = self.settings.size;
        let pixels = f64::from(width) * f64::from(height);
        let hits_per_pixel = tally.hits() / pixels;
        Ok(Measured {
            method: method.clone(),
            antialiasing: self.antialiasing,
            frame_ms: tally.frame_ms(),
            ms_median: tally.ms(0.5),
            ms_min: tally.ms(0.0),
            ms_max: tally.ms(1.0),
            ssim: quality.ssim(),
            psnr_db: quality.psnr_db(),
            tpsnr_db: quality.tpsnr_db(),
            vdp_jod: None,
            flip: quality.flip(),
            flicker: quality.flicker(),
            bias: quality.bias(),
            rms: quality.rms(),
            against_truth: None,
            shaded_per_pixel: tally.shaded() / pixels,
            hits_per_pixel,
            memory_bytes_per_pixel: backend.bytes_per_pixel(pipeline, hits_per_pixel),
            merged_per_pixel: tally.merged() / pixels,
            picture: display(&planes.colour, self.settings.tone, share),
            error_map: None,
        })
    }
}
