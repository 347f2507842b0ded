//! `sheer render`: a picture or a sequence of frames.

use std::path::{Path, PathBuf};

use sheer_render::{Antialiasing, Clock};

use crate::{
    args::{DEFAULT_SIZE, RenderArguments},
    backend::{Renderer, Task},
    output::{self, PictureOutput},
    setup,
    tally::Tally,
};

pub(crate) fn run(arguments: &RenderArguments) -> anyhow::Result<()> {
    arguments.backend.run(arguments)
}

impl Task for RenderArguments {
    fn run_on(&self, renderer: &impl Renderer) -> anyhow::Result<()> {
        render(self, renderer)
    }
}

fn render(arguments: &RenderArguments, renderer: &impl Renderer) -> anyhow::Result<()> {
    let talk = arguments.machine.apply()?;
    let settings = arguments.light.under(arguments.frames.settings(DEFAULT_SIZE));
    let antialiasing = arguments.antialiasing;
    let path = output_path(arguments)?;
    let output = PictureOutput::from_path(&path);
    let is_sequence = matches!(output, PictureOutput::Sequence { .. });
    // Without anti-aliasing a frame owes nothing to the ones before it.
    let frame_count = match antialiasing {
        Antialiasing::None if !is_sequence => 1,
        _ => arguments.frames.frames,
    };
    output.check(settings.first_frame)?;

    let mut stage = arguments.scene.open(renderer, arguments.machine, talk)?.stage;
    let mut pipeline = renderer.pipeline(&arguments.method, antialiasing, settings)?;
    renderer.notes(&pipeline).iter().for_each(|note| talk.warn(note));
    let clock = Clock::new(&settings, antialiasing);
    let metadata = setup::metadata(renderer, &arguments.scene, &arguments.method, antialiasing, &settings);
    let mut tally = Tally::default();
    let progress = talk.progress(u64::from(frame_count));
    for index in 0..frame_count {
        renderer.advance(&mut stage, clock.at(index))?;
        tally.add(renderer.render(&mut pipeline, &mut stage, index)?);
        if is_sequence || index + 1 == frame_count {
            let frame = settings.first_frame + index;
            output.write(frame, &*renderer.planes(&pipeline)?, &metadata.clone().with("frame", frame))?;
        }
        progress.inc(1);
    }
    progress.finish_and_clear();

    let [width, height] = settings.size;
    let pixels = f64::from(width) * f64::from(height);
    talk.note(format_args!(
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
    Ok(folder.join(format!("{}.png", arguments.scene.file_stem())))
}
