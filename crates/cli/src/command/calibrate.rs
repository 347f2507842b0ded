//! `sheer calibrate`: what a method under an anti-aliasing shows of ten opacities, and the correction that
//! sets it right (STD section 3.2.1).

use serde::Serialize;
use sheer_image::{DisplayShare, Metadata, display, encode_png};
use sheer_lab::{
    Progress as _, Timeline,
    calibrate::{Calibration, areas, shown_opacities},
};
use sheer_render::{Backend, Background};

use crate::{
    args::{CalibrateArguments, DEFAULT_SIZE, SceneArguments},
    backend::Task,
    failure::Misuse,
    output::{self, TextOutput},
    report::{calibration::Report, json, page},
    setup,
};

/// What `correction=FILE` takes.
#[derive(Serialize)]
struct CorrectionFile {
    coefficients: [f32; 4],
}

pub(crate) fn run(arguments: &CalibrateArguments) -> anyhow::Result<()> {
    arguments.backend.run(arguments)
}

impl Task for CalibrateArguments {
    fn run_on<B: Backend + 'static>(&self, backend: &B) -> anyhow::Result<()> {
        calibrate(self, backend)
    }
}

fn calibrate<B: Backend>(arguments: &CalibrateArguments, backend: &B) -> anyhow::Result<()> {
    let CalibrateArguments { method, antialiasing, .. } = arguments;
    let console = arguments.machine.apply()?;
    let settings = arguments.frames.settings(DEFAULT_SIZE)?;
    let areas = areas(settings.size)?;
    if settings.background != Background::Environment {
        return Err(Misuse("calibrate measures over black: leave --background out".to_owned()).into());
    }
    let html = arguments.html.as_deref().map(TextOutput::open).transpose()?;
    let file = arguments.output.as_deref().map(TextOutput::open).transpose()?;

    let scene = SceneArguments::of("calibration");
    let mut opened = scene.open(backend, settings.size, arguments.machine, console)?;
    let mut pipeline = backend.pipeline(method, *antialiasing, settings)?;
    backend.notes(&pipeline).iter().for_each(|note| console.warn(note));
    let frames = arguments.frames.count();
    let bar = console.bar();
    bar.expect(u64::from(frames));
    let timeline = Timeline::of(&settings, *antialiasing, frames);
    let measured = shown_opacities(backend, &mut opened.stage, &mut pipeline, areas, timeline, &bar)?;
    drop(bar);

    let report = Report {
        run: setup::describe(backend, &scene, &opened, &settings, frames),
        method: method.to_string(),
        aa: antialiasing.to_string(),
        calibration: Calibration::fit(method, measured)?,
    };
    if let Some(output) = &html {
        let picture = display(&backend.planes(&pipeline)?.colour, settings.tone, &DisplayShare::Nothing);
        let picture_png = encode_png(&picture, &Metadata::default())?;
        output.write(&page::calibration::text(&report, &picture_png)?)?;
    }
    if let Some(output) = &file {
        let coefficients = report.calibration.correction.coefficients();
        output.write(&json::text(&CorrectionFile { coefficients })?)?;
    }
    let replaces_table = |output: &Option<TextOutput<'_>>| output.as_ref().is_some_and(TextOutput::is_stdout);
    if replaces_table(&file) || replaces_table(&html) { Ok(()) } else { output::print(&report.text()) }
}
