//! `sheer render`: a picture or a sequence of frames.

use std::{
    borrow::Cow,
    ops::Range,
    path::{Path, PathBuf},
    slice,
};

use anyhow::bail;
use sheer_image::{DisplayShare, ImageError, Metadata, Piece, Region, SampleRange, display};
use sheer_lab::{Event, Exposure, LabError, Progress as _, Tally, Timeline, play};
use sheer_render::{
    Antialiasing, Backend, Background, Clock, Settings,
    temporal::{jitter, margin_px},
};

use crate::{
    args::{DEFAULT_SIZE, RenderArguments, SampleSpan},
    backend::Task,
    console::{Bar, Console},
    failure::Misuse,
    output::{self, PictureOutput},
    schedule::{Memory, Stretch, stretches},
    setup::{self, Opened, View},
    video::{Video, VideoFormat, VideoStream},
};

pub(crate) fn run(arguments: &RenderArguments) -> anyhow::Result<()> {
    arguments.backend.run(arguments)
}

impl Task for RenderArguments {
    fn run_on<B: Backend + 'static>(&self, backend: &B) -> anyhow::Result<()> {
        render(self, backend)
    }
}

/// What is to be rendered, settled before the first frame.
struct Plan {
    /// The crop with what is rendered around it.
    settings: Settings,
    /// What is written of the picture.
    piece: Piece,
    /// How much is rendered around a crop, pixels.
    margin: u32,
    antialiasing: Antialiasing,
    /// Where each frame is rendered for itself, of many samples.
    exposure: Option<Exposure>,
    path: PathBuf,
    output: PictureOutput,
    frames: Range<u32>,
    memory: Memory,
}

fn render<B: Backend>(arguments: &RenderArguments, backend: &B) -> anyhow::Result<()> {
    let console = arguments.machine.apply()?;
    let plan = Plan::of(arguments)?;
    let Plan { settings, piece, antialiasing, .. } = plan;
    let stretches = plan.stretches(arguments.skip_existing);
    let written: usize = stretches.iter().map(|stretch| stretch.written.len()).sum();
    if written == 0 {
        console.note(format_args!("{} is there: nothing to render", plan.path.display()));
        return Ok(());
    }
    plan.warn_of_cold_start(&stretches, console);
    plan.warn_of_frames_left_out(arguments, console);

    let metadata = setup::metadata(backend, &arguments.scene, &arguments.method, antialiasing, &settings);
    let metadata = plan.metadata(metadata);
    // What is missing for a video is said before a scene is opened, which may take its time.
    let video = plan.start_video(&metadata)?;
    let opened = arguments.scene.open(backend, settings.size, arguments.machine, console)?;
    let Opened { mut stage, view } = opened;
    let metadata = match plan.output.is_displayed() {
        true => metadata,
        false => metadata.with("scene_hash", view.scene_hash()),
    };
    let bar = console.bar();
    let mut frames = Frames { backend, plan: &plan, metadata, view, video, tally: Tally::default(), bar };
    for (at, stretch) in stretches.iter().enumerate() {
        // Pipelines count frames from the first that they render.
        let settings = match plan.exposure {
            Some(exposure) => exposure.settings(settings),
            None => Settings { first_frame: stretch.rendered.start, ..settings },
        };
        let mut pipeline =
            backend.pipeline(&arguments.method, antialiasing, plan.at_first_sample(settings))?;
        if at == 0 {
            backend.notes(&pipeline).iter().for_each(|note| console.warn(note));
        }
        match plan.exposure {
            Some(exposure) => frames.expose(&mut stage, &mut pipeline, exposure, stretch)?,
            None => frames.play(&mut stage, &mut pipeline, &settings, stretch)?,
        }
    }
    let Frames { tally, bar, video, .. } = frames;
    drop(bar);
    video.map(Video::finish).transpose()?;
    // A part of a picture may well be empty.
    if tally.shaded() == 0.0 && arguments.crop.is_none() {
        console.warn(format_args!(
            "{}: nothing is in the picture; look from elsewhere (--camera static, orbit or one of the file's, --eye) or at another --time, `sheer inspect` tells what there is and where",
            arguments.scene.text,
        ));
    }

    let pixels = settings.region().pixel_count() as f64;
    let [width, height] = piece.picture;
    let shape = match arguments.crop {
        Some(Region { width: columns, height: rows, .. }) => format!("{columns}x{rows} of {width}x{height}"),
        None => format!("{width}x{height}"),
    };
    let count = if plan.output.has_all_frames() { written } else { plan.frames.len() };
    let (what, of) = match plan.exposure {
        Some(Exposure { samples, part: None, .. }) => (format!("{samples} samples"), "sample"),
        Some(Exposure { part: Some(part), .. }) => (format!("samples {part}"), "sample"),
        None => (antialiasing.to_string(), "frame"),
    };
    console.note(format_args!(
        "wrote {}: {shape}, {}, {what}, {count} frame{}; {:.1} ms per {of}, {:.2} shaded and {:.2} hits per pixel",
        plan.path.display(),
        arguments.method,
        if count == 1 { "" } else { "s" },
        tally.ms(0.5),
        tally.shaded() / pixels,
        tally.hits() / pixels,
    ));
    Ok(())
}

impl Plan {
    /// What can go wrong goes wrong here.
    fn of(arguments: &RenderArguments) -> anyhow::Result<Self> {
        let settings = arguments.light.under(arguments.frames.settings(DEFAULT_SIZE)?);
        let settings = Settings { raw: arguments.raw, ..settings };
        let shutter = arguments.shutter;
        let exposure = arguments.samples.map(|samples| Exposure { samples, shutter, part: None });
        let antialiasing = if exposure.is_some() { Antialiasing::ACCUMULATE } else { arguments.antialiasing };

        let path = output_path(arguments)?;
        let output = PictureOutput::from_path(&path);
        let is_sequence = output.has_all_frames();
        output.check(settings.first_frame).map_err(with_video_endings)?;
        if settings.raw && output.is_displayed() {
            bail!("{}: --raw writes .exr files alone, give the output that ending", path.display());
        }

        // A frame that is not added up owes nothing to the ones before it.
        let is_added_up = exposure.is_none() && antialiasing != Antialiasing::NONE && !settings.raw;
        let count = if is_added_up || is_sequence { arguments.frames.count() } else { 1 };
        let frames = settings.first_frame..settings.first_frame + count;
        let memory = if !is_added_up {
            Memory::Frames(0)
        } else if antialiasing.info().time_stands_still || !is_sequence {
            Memory::Run
        } else {
            Memory::Frames(arguments.warm_up.unwrap_or(antialiasing.info().warm_up_frames))
        };
        let of = match exposure {
            Some(Exposure { samples, .. }) => Some(samples),
            None => (antialiasing == Antialiasing::ACCUMULATE && !is_sequence).then_some(count),
        };
        let samples = arguments.sample_range.map(|span| sample_range(span, of)).transpose()?;
        let exposure = exposure.map(|exposure| Exposure { part: samples, ..exposure });

        // A picture that is not added up needs nothing around it.
        let picture = settings.size;
        let most = if is_added_up { margin_px(antialiasing) } else { 0 };
        let margin = if most > 0 { arguments.margin.unwrap_or(most) } else { 0 };
        if let Some(crop) = arguments.crop.filter(|crop| !crop.is_within(picture)) {
            let [width, height] = picture;
            let problem = format!("--crop {crop} reaches beyond the picture of {width}x{height} pixels");
            return Err(Misuse(problem).into());
        }
        let crop = arguments.crop.map(|crop| crop.grown(margin, picture));
        let region = arguments.crop.unwrap_or(Region::whole(picture));
        let piece = Piece { picture, region, samples };
        if let PictureOutput::Video(VideoFormat::Mp4, _) = output {
            check_mp4(&piece, settings.background)?;
        }
        let settings = Settings { crop, ..settings };
        Ok(Self { settings, piece, margin, antialiasing, exposure, path, output, frames, memory })
    }

    /// Begins the video, if the output is one.
    fn start_video(&self, metadata: &Metadata) -> anyhow::Result<Option<Video<'_>>> {
        let PictureOutput::Video(format, ref path) = self.output else { return Ok(None) };
        let Settings { frames_per_sec, background, tone, .. } = self.settings;
        let size = self.piece.region.size();
        let has_alpha = background == Background::None;
        let metadata = tone.described(self.piece.described(metadata.clone()));
        let stream = VideoStream { format, size, frames_per_sec, has_alpha };
        Ok(Some(Video::start(path, stream, &metadata)?))
    }

    /// The settings of a pipeline that begins with the first sample that is asked for; an exposure counts
    /// them itself.
    fn at_first_sample(&self, settings: Settings) -> Settings {
        match (self.exposure, self.piece.samples) {
            (None, Some(SampleRange { first, .. })) => {
                Settings { first_frame: settings.first_frame + first, ..settings }
            }
            _ => settings,
        }
    }

    /// Time of what a frame shows, seconds.
    fn time_secs(&self, frame: u32) -> f32 {
        let stands = self.exposure.is_none() && self.antialiasing.info().time_stands_still;
        let first_frame = if stands { self.frames.start } else { frame };
        Clock::new(&Settings { first_frame, ..self.settings }, Antialiasing::NONE).at(0).time_secs
    }

    /// The frames that are rendered and which of them are written.
    fn stretches(&self, skip_existing: bool) -> Vec<Stretch> {
        let last = self.frames.end - 1;
        let is_sequence = self.output.has_all_frames();
        stretches(self.frames.clone(), self.memory, |frame| {
            (is_sequence || frame == last) && !(skip_existing && self.output.path(frame).is_file())
        })
    }

    /// Says what a history that is too short does to the first frames of a part.
    fn warn_of_cold_start(&self, stretches: &[Stretch], console: Console) {
        let Memory::Frames(warm_up) = self.memory else { return };
        let enough = self.antialiasing.info().warm_up_frames;
        let is_added_up = self.exposure.is_none() && !self.settings.raw;
        let cold = stretches.iter().find(|stretch| stretch.rendered.start > 0);
        if let Some(stretch) = cold.filter(|_| is_added_up && warm_up < enough) {
            console.warn(format_args!(
                "frame {} comes after {warm_up} frames of history and will not quite fit to an unbroken clip (docs/farm.md says by how much); --warm-up {enough}, the default, is enough",
                stretch.written[0]
            ));
        }
    }

    /// Says which frame one picture shows of several that were asked for and do not add up.
    fn warn_of_frames_left_out(&self, arguments: &RenderArguments, console: Console) {
        let asked = if arguments.frames.frames.is_some() { arguments.frames.count() } else { 1 };
        if self.output.has_all_frames() || asked <= self.frames.len() as u32 {
            return;
        }
        let first = self.frames.start;
        let option = match arguments {
            RenderArguments { samples: Some(_), .. } => "--samples",
            RenderArguments { raw: true, .. } => "--raw",
            _ => "-a none",
        };
        console.warn(format_args!(
            "{} is frame {first} alone: under {option} each of the {asked} frames stands for itself; put #### into the name for all of them, or give --first-frame {} for the last",
            self.path.display(),
            first + asked - 1,
        ));
    }

    /// What all frames have in common.
    fn metadata(&self, metadata: Metadata) -> Metadata {
        let metadata = if self.margin > 0 && self.settings.crop.is_some() {
            metadata.with("margin", self.margin)
        } else {
            metadata
        };
        match self.exposure {
            Some(Exposure { samples, shutter, .. }) => {
                metadata.with("samples", samples).with("shutter", shutter)
            }
            None => metadata,
        }
    }

    /// What a frame has of its own: `rendered` are those that have been rendered one after the other up to
    /// it.
    fn frame_metadata(&self, metadata: Metadata, rendered: Range<u32>, view: &View) -> Metadata {
        let (frame, count) = (rendered.end - 1, rendered.len() as u32);
        let time_secs = self.time_secs(frame);
        let metadata = metadata.with("frame", frame).with("time_secs", time_secs);
        let metadata = metadata.with("pose", view.pose(time_secs));
        let info = self.antialiasing.info();
        if self.settings.raw {
            let offset = jitter(self.antialiasing, frame);
            return metadata.with("jitter.X", offset.x).with("jitter.Y", offset.y);
        }
        if self.exposure.is_some() || self.antialiasing == Antialiasing::NONE {
            metadata
        } else if info.time_stands_still {
            metadata.with("samples", count)
        } else if count > info.warm_up_frames {
            // More frames do not show.
            metadata.with("history", format_args!("{} frames or more", info.warm_up_frames + 1))
        } else {
            metadata.with("history", format_args!("{count} frames"))
        }
    }
}

/// The error where no picture file ends with what the user typed: videos are known to this command alone.
fn with_video_endings(error: anyhow::Error) -> anyhow::Error {
    match error.downcast_ref() {
        Some(ImageError::UnknownExtension { path }) => Misuse(format!(
            "cannot tell the format of {}: end its name with .png or .exr, or with .mp4 or .webm for a video",
            path.display()
        ))
        .into(),
        _ => error,
    }
}

/// Refuses what H.264 with colour of half the resolution cannot hold, and players ask for no other.
fn check_mp4(piece: &Piece, background: Background) -> Result<(), Misuse> {
    if background == Background::None {
        let problem = "an .mp4 holds no alpha: leave --background none out, or write a .webm";
        return Err(Misuse(problem.to_owned()));
    }
    let [width, height] = piece.region.size();
    let [even_width, even_height] = [width, height].map(|side| side.next_multiple_of(2));
    if [width, height] == [even_width, even_height] {
        return Ok(());
    }
    let option = if piece.region == Region::whole(piece.picture) { "--size" } else { "--crop" };
    Err(Misuse(format!(
        "an .mp4 has even sides, and {option} asks for {width}x{height} pixels: make that {even_width}x{even_height}, or write a .webm"
    )))
}

/// Renders frames and writes them as they come, so that an interrupted sequence keeps those that it has.
struct Frames<'p, B> {
    backend: &'p B,
    plan: &'p Plan,
    metadata: Metadata,
    view: View,
    /// Where the output is one.
    video: Option<Video<'p>>,
    tally: Tally,
    bar: Bar,
}

impl<B: Backend> Frames<'_, B> {
    /// Frames that add up.
    fn play(
        &mut self,
        stage: &mut B::Stage,
        pipeline: &mut B::Pipeline,
        settings: &Settings,
        stretch: &Stretch,
    ) -> sheer_lab::Result<()> {
        let count = self.plan.piece.samples.map_or(stretch.rendered.len() as u32, |part| part.count());
        // Of a part of the samples, the last one stands for the frame.
        let first = stretch.rendered.end - count;
        self.bar.expect(u64::from(count));
        let timeline = Timeline::of(settings, self.plan.antialiasing, count);
        play(self.backend, stage, slice::from_mut(pipeline), timeline, |event| {
            match event {
                Event::Rendered { cost, .. } => self.tally.add(cost),
                Event::Frame { index, pipelines, stage } => {
                    self.write(stretch, first + index, &pipelines[0], stage)?;
                    self.bar.step();
                }
            }
            Ok(())
        })
    }

    /// Frames of many samples each.
    fn expose(
        &mut self,
        stage: &mut B::Stage,
        pipeline: &mut B::Pipeline,
        exposure: Exposure,
        stretch: &Stretch,
    ) -> sheer_lab::Result<()> {
        self.bar.expect((stretch.rendered.len() * exposure.rendered().len()) as u64);
        for frame in stretch.rendered.clone() {
            let (tally, bar) = (&mut self.tally, &self.bar);
            exposure.render(self.backend, stage, pipeline, &self.plan.settings, frame, |cost| {
                tally.add(cost);
                bar.step();
                Ok(())
            })?;
            self.write(stretch, frame, pipeline, stage)?;
        }
        Ok(())
    }

    /// Writes a frame if it is one to be written.
    fn write(
        &mut self,
        stretch: &Stretch,
        frame: u32,
        pipeline: &B::Pipeline,
        stage: &B::Stage,
    ) -> sheer_lab::Result<()> {
        let Self { backend, plan, ref mut video, .. } = *self;
        if stretch.written.binary_search(&frame).is_err() {
            return Ok(());
        }
        let failed = |error| LabError::of_backend(backend, error);
        let mut planes = backend.planes(pipeline).map_err(failed)?;
        let Plan { settings, piece, antialiasing, .. } = plan;
        let rendered = settings.region();
        if rendered != piece.region {
            planes = Cow::Owned(planes.cut(piece.region.seen_from(&rendered))?);
        }
        let share = if plan.output.is_displayed() || !piece.is_whole() {
            let settings = Settings { crop: Some(piece.region), ..*settings };
            backend.display_share(stage, &settings, *antialiasing).map_err(failed)?
        } else {
            DisplayShare::Nothing
        };
        if let Some(video) = video {
            let added = video.add(&display(&planes.colour, settings.tone, &share));
            return added.map_err(|error| LabError::Output(error.into()));
        }
        let added_up = stretch.rendered.start..frame + 1;
        let metadata = plan.frame_metadata(self.metadata.clone(), added_up, &self.view);
        let written = plan.output.write(frame, &planes, piece, settings.tone, &share, &metadata);
        written.map_err(|error| LabError::Output(error.into()))
    }
}

/// The samples that are asked for, of so many; none where there is no mean of samples.
fn sample_range(SampleSpan { first, end }: SampleSpan, of: Option<u32>) -> anyhow::Result<SampleRange> {
    let problem = match of {
        Some(of) if end <= of => return Ok(SampleRange { first, end, of }),
        Some(of) => format!("--sample-range {first}..{end} reaches beyond the {of} samples that there are"),
        None => {
            "--sample-range is a part of the mean of -a accumulate, in one file, or of --samples".to_owned()
        }
    };
    Err(Misuse(problem).into())
}

/// The file that the user named, or one in a folder of ours.
fn output_path(arguments: &RenderArguments) -> anyhow::Result<PathBuf> {
    if let Some(path) = &arguments.output {
        return Ok(path.clone());
    }
    let folder = Path::new(output::FOLDER);
    output::open_folder(folder)?;
    let extension = if arguments.raw { "exr" } else { "png" };
    Ok(folder.join(format!("{}.{extension}", arguments.scene.file_stem())))
}
