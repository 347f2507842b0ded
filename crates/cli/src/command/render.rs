//! `sheer render`: a picture or a sequence of frames.

use std::{
    ops::Range,
    path::{Path, PathBuf},
    slice,
};

use anyhow::bail;
use sheer_core::parameter::Choice as _;
use sheer_image::{DisplayShare, FileFormat, Metadata};
use sheer_lab::{Event, Exposure, LabError, Progress as _, Tally, Timeline, play};
use sheer_render::{Antialiasing, Backend, Settings, temporal::jitter};

use crate::{
    args::{DEFAULT_SIZE, RenderArguments},
    backend::Task,
    console::{Bar, Console},
    output::{self, PictureOutput},
    schedule::{Memory, Stretch, stretches},
    setup,
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
    settings: Settings,
    antialiasing: Antialiasing,
    /// Where each frame is rendered for itself, of many samples.
    exposure: Option<Exposure>,
    path: PathBuf,
    output: PictureOutput,
    format: FileFormat,
    frames: Range<u32>,
    memory: Memory,
}

fn render<B: Backend>(arguments: &RenderArguments, backend: &B) -> anyhow::Result<()> {
    let console = arguments.machine.apply()?;
    let plan = Plan::of(arguments)?;
    let Plan { settings, antialiasing, ref output, .. } = plan;
    let stretches = plan.stretches(arguments.skip_existing);
    let written: usize = stretches.iter().map(|stretch| stretch.written.len()).sum();
    if written == 0 {
        console.note(format_args!("{} is there: nothing to render", plan.path.display()));
        return Ok(());
    }
    plan.warn_of_cold_start(&stretches, console);

    let mut stage = arguments.scene.open(backend, settings.size, arguments.machine, console)?.stage;
    let metadata = setup::metadata(backend, &arguments.scene, &arguments.method, antialiasing, &settings);
    let mut frames = Frames {
        backend,
        plan: &plan,
        metadata: plan.metadata(metadata),
        tally: Tally::default(),
        bar: console.bar(),
    };
    for (at, stretch) in stretches.iter().enumerate() {
        // Pipelines count frames from the first that they render.
        let settings = match plan.exposure {
            Some(exposure) => exposure.settings(settings),
            None => Settings { first_frame: stretch.rendered.start, ..settings },
        };
        let mut pipeline = backend.pipeline(&arguments.method, antialiasing, settings)?;
        if at == 0 {
            backend.notes(&pipeline).iter().for_each(|note| console.warn(note));
        }
        match plan.exposure {
            Some(exposure) => frames.expose(&mut stage, &mut pipeline, exposure, stretch)?,
            None => frames.play(&mut stage, &mut pipeline, &settings, stretch)?,
        }
    }
    let Frames { tally, bar, .. } = frames;
    drop(bar);
    if tally.shaded() == 0.0 {
        console.warn(format_args!(
            "{}: nothing is in the picture; look from elsewhere (--camera static, orbit or one of the file's, --eye) or at another --time, `sheer inspect` tells what there is and where",
            arguments.scene.text,
        ));
    }

    let [width, height] = settings.size;
    let pixels = f64::from(width) * f64::from(height);
    let count = match output {
        PictureOutput::Single(_) => plan.frames.len(),
        PictureOutput::Sequence { .. } => written,
    };
    let (what, of) = match plan.exposure {
        Some(Exposure { samples, .. }) => (format!("{samples} samples"), "sample"),
        None => (antialiasing.to_string(), "frame"),
    };
    console.note(format_args!(
        "wrote {}: {width}x{height}, {}, {what}, {count} frame{}; {:.1} ms per {of}, {:.2} shaded and {:.2} hits per pixel",
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
        let exposure = arguments.samples.map(|samples| Exposure { samples, shutter });
        let antialiasing = if exposure.is_some() { Antialiasing::ACCUMULATE } else { arguments.antialiasing };

        let path = output_path(arguments)?;
        let output = PictureOutput::from_path(&path);
        let is_sequence = matches!(output, PictureOutput::Sequence { .. });
        let format = output.check(settings.first_frame)?;
        if settings.raw && format != FileFormat::Exr {
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
        Ok(Self { settings, antialiasing, exposure, path, output, format, frames, memory })
    }

    /// The frames that are rendered and which of them are written.
    fn stretches(&self, skip_existing: bool) -> Vec<Stretch> {
        let last = self.frames.end - 1;
        let is_sequence = matches!(self.output, PictureOutput::Sequence { .. });
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

    fn metadata(&self, metadata: Metadata) -> Metadata {
        let tone = self.settings.tone;
        let metadata = match self.format {
            FileFormat::Png => metadata.with("tone", tone.curve.word()).with("exposure_ev", tone.exposure_ev),
            FileFormat::Exr => metadata,
        };
        match self.exposure {
            Some(Exposure { samples, shutter }) => metadata.with("samples", samples).with("shutter", shutter),
            None => metadata,
        }
    }
}

/// Renders frames and writes them as they come, so that an interrupted sequence keeps those that it has.
struct Frames<'p, B> {
    backend: &'p B,
    plan: &'p Plan,
    metadata: Metadata,
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
        let count = stretch.rendered.len() as u32;
        self.bar.expect(u64::from(count));
        let timeline = Timeline::of(settings, self.plan.antialiasing, count);
        play(self.backend, stage, slice::from_mut(pipeline), timeline, |event| {
            match event {
                Event::Rendered { cost, .. } => self.tally.add(cost),
                Event::Frame { index, pipelines, stage } => {
                    self.write(stretch, stretch.rendered.start + index, &pipelines[0], stage)?;
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
        self.bar.expect(stretch.rendered.len() as u64 * u64::from(exposure.samples));
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
        &self,
        stretch: &Stretch,
        frame: u32,
        pipeline: &B::Pipeline,
        stage: &B::Stage,
    ) -> sheer_lab::Result<()> {
        let Self { backend, plan, .. } = *self;
        if stretch.written.binary_search(&frame).is_err() {
            return Ok(());
        }
        let failed = |error| LabError::of_backend(backend, error);
        let planes = backend.planes(pipeline).map_err(failed)?;
        let Plan { settings, antialiasing, .. } = plan;
        let share = match plan.format {
            FileFormat::Png => backend.display_share(stage, settings, *antialiasing).map_err(failed)?,
            FileFormat::Exr => DisplayShare::Nothing,
        };
        let mut metadata = self.metadata.clone().with("frame", frame);
        if settings.raw {
            let offset = jitter(*antialiasing, frame);
            metadata = metadata.with("jitter.X", offset.x).with("jitter.Y", offset.y);
        }
        let written = plan.output.write(frame, &planes, settings.tone, &share, &metadata);
        written.map_err(|error| LabError::Output(error.into()))
    }
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
