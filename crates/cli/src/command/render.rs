//! `sheer render`: a picture or a sequence of frames.

use std::{
    path::{Path, PathBuf},
    slice,
};

use anyhow::bail;
use sheer_core::parameter::Choice as _;
use sheer_image::{DisplayShare, FileFormat};
use sheer_lab::{Event, LabError, Progress as _, Tally, Timeline, play};
use sheer_render::{Antialiasing, Backend, Settings, temporal::jitter};

use crate::{
    args::{DEFAULT_SIZE, RenderArguments},
    backend::Task,
    output::{self, PictureOutput},
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

fn render<B: Backend>(arguments: &RenderArguments, backend: &B) -> anyhow::Result<()> {
    let console = arguments.machine.apply()?;
    let settings = arguments.light.under(arguments.frames.settings(DEFAULT_SIZE));
    let settings = Settings { raw: arguments.raw, ..settings };
    let antialiasing = arguments.antialiasing;
    // What can go wrong goes wrong before the first frame.
    let path = output_path(arguments)?;
    let output = PictureOutput::from_path(&path);
    let is_sequence = matches!(output, PictureOutput::Sequence { .. });
    // A frame that is not added up owes nothing to the ones before it.
    let is_added_up = antialiasing != Antialiasing::NONE && !settings.raw;
    let frame_count = if is_added_up || is_sequence { arguments.frames.frames } else { 1 };
    let format = output.check(settings.first_frame)?;
    if settings.raw && format != FileFormat::Exr {
        bail!("{}: --raw writes .exr files alone, give the output that ending", path.display());
    }

    let mut stage = arguments.scene.open(backend, settings.size, arguments.machine, console)?.stage;
    let mut pipeline = backend.pipeline(&arguments.method, antialiasing, settings)?;
    backend.notes(&pipeline).iter().for_each(|note| console.warn(note));
    let metadata = setup::metadata(backend, &arguments.scene, &arguments.method, antialiasing, &settings);
    let metadata = match format {
        FileFormat::Png => {
            metadata.with("tone", settings.tone.curve.word()).with("exposure_ev", settings.tone.exposure_ev)
        }
        FileFormat::Exr => metadata,
    };
    // Frames are written as they come, so that an interrupted sequence keeps those that it has.
    let mut tally = Tally::default();
    let bar = console.bar();
    bar.expect(u64::from(frame_count));
    let timeline = Timeline::of(&settings, antialiasing, frame_count);
    play(backend, &mut stage, slice::from_mut(&mut pipeline), timeline, |event| {
        match event {
            Event::Rendered { cost, .. } => tally.add(cost),
            Event::Frame { index, pipelines, stage } => {
                if is_sequence || index + 1 == frame_count {
                    let failed = |error| LabError::of_backend(backend, error);
                    let planes = backend.planes(&pipelines[0]).map_err(failed)?;
                    let share = match format {
                        FileFormat::Png => {
                            backend.display_share(stage, &settings, antialiasing).map_err(failed)?
                        }
                        FileFormat::Exr => DisplayShare::Nothing,
                    };
                    let frame = settings.first_frame + index;
                    let mut metadata = metadata.clone().with("frame", frame);
                    if settings.raw {
                        let offset = jitter(antialiasing, frame);
                        metadata = metadata.with("jitter.X", offset.x).with("jitter.Y", offset.y);
                    }
                    let written = output.write(frame, &planes, settings.tone, &share, &metadata);
                    written.map_err(|error| LabError::Output(error.into()))?;
                }
                bar.step();
            }
        }
        Ok(())
    })?;
    drop(bar);
    if tally.shaded() == 0.0 {
        console.warn(format_args!(
            "{}: nothing is in the picture; look from elsewhere (--camera static, orbit or one of the file's) or at another --time, `sheer inspect` tells what there is and where",
            arguments.scene.text,
        ));
    }

    let [width, height] = settings.size;
    let pixels = f64::from(width) * f64::from(height);
    console.note(format_args!(
        "wrote {}: {width}x{height}, {}, {antialiasing}, {frame_count} frame{}; {:.1} ms per frame, {:.2} shaded and {:.2} hits per pixel",
        path.display(),
        arguments.method,
        if frame_count == 1 { "" } else { "s" },
        tally.ms(0.5),
        tally.shaded() / pixels,
        tally.hits() / pixels,
    ));
    Ok(())
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
