//! `sheer calibrate`: what a method under an anti-aliasing shows of ten opacities, and the correction that sets it right (STD section 3.2.1).

use serde::Serialize;
use sheer_core::coverage::Correction;
use sheer_image::{Metadata, Planes, ToneCurve, display, encode_png};
use sheer_render::{Antialiasing, Background, Method, Pipeline, Stage};

use crate::{
    args::{CalibrateArguments, DEFAULT_SIZE, SceneArguments},
    backend::Cpu,
    failure::Misuse,
    output::{self, TextOutput},
    report::{
        calibration::{Calibration, Level},
        json::{self, Run},
        page,
    },
    setup,
};

/// Columns of the scene `calibration`.
pub(crate) const LEVELS: usize = 10;
/// Kept clear around each column and half: jitter and the neighbourhood of anti-aliasing reach across the edges.
const MARGIN_PX: f64 = 3.0;

/// What `correction=FILE` takes.
#[derive(Serialize)]
struct CorrectionFile {
    coefficients: [f32; 4],
}

pub(crate) fn run(arguments: &CalibrateArguments) -> anyhow::Result<()> {
    let talk = arguments.machine.apply()?;
    let settings = arguments.frames.settings(DEFAULT_SIZE);
    let areas = areas(settings.size)?;
    if settings.background != Background::Environment {
        return Err(Misuse("calibrate measures over black: leave --background out".to_owned()).into());
    }
    let html = arguments.html.as_deref().map(TextOutput::open).transpose()?;
    let file = arguments.output.as_deref().map(TextOutput::open).transpose()?;

    let scene = SceneArguments { text: "calibration".to_owned(), camera: None, alpha: None };
    let mut opened = scene.open(&Cpu, arguments.machine, talk)?;
    let stage = &mut opened.stage;
    let method = &arguments.method;
    let mut pipeline = Pipeline::new(method.clone(), arguments.antialiasing, settings)?;
    let frames = arguments.frames.frames;
    let progress = talk.progress(u64::from(frames));
    let measured = shown_opacities(stage, &mut pipeline, areas, frames, || progress.inc(1))?;
    progress.finish_and_clear();

    let run = setup::describe(&Cpu, &scene, &opened, &settings, frames);
    let calibration = calibration(run, method, arguments.antialiasing, measured)?;
    if let Some(output) = &html {
        let picture = display(&pipeline.planes().colour, ToneCurve::default());
        output
            .write(&page::calibration::text(&calibration, &encode_png(&picture, &Metadata::default())?)?)?;
    }
    if let Some(output) = &file {
        let coefficients = calibration.correction.coefficients();
        output.write(&json::text(&CorrectionFile { coefficients })?)?;
    }
    let replaces_table = |output: &Option<TextOutput<'_>>| output.as_ref().is_some_and(TextOutput::is_stdout);
    if replaces_table(&file) || replaces_table(&html) { Ok(()) } else { output::print(&calibration.text()) }
}

/// The ten opacities that a pipeline shows of the scene `calibration`, given the panels' [`areas`]: means over the last half of the frames.
pub(crate) fn shown_opacities(
    stage: &mut Stage,
    pipeline: &mut Pipeline,
    areas: [[u32; 4]; LEVELS],
    frames: u32,
    mut rendered: impl FnMut(),
) -> anyhow::Result<[f64; LEVELS]> {
    let mut sums = [0.0; LEVELS];
    for index in 0..frames {
        stage.advance(pipeline.clock().at(index));
        pipeline.render(stage, index)?;
        if index >= frames / 2 {
            for (sum, area) in sums.iter_mut().zip(areas) {
                *sum += mean_brightness(pipeline.planes(), area);
            }
        }
        rendered();
    }
    // The last column is opaque white.
    Ok(sums.map(|sum| sum / sums[LEVELS - 1]))
}

/// Fits the correction to what was measured.
pub(crate) fn calibration(
    run: Run,
    method: &Method,
    antialiasing: Antialiasing,
    measured: [f64; LEVELS],
) -> anyhow::Result<Calibration> {
    let wanted: [f64; LEVELS] = std::array::from_fn(|at| (at + 1) as f64 / LEVELS as f64);
    let fed = wanted.map(|wanted| f64::from(method.correction().coverage(wanted as f32)));
    let pairs: [[f64; 2]; LEVELS] = std::array::from_fn(|at| [measured[at], fed[at]]);
    let correction = Correction::fit(&pairs).ok_or_else(|| {
        anyhow::anyhow!("{method} shows fewer than four different opacities: there is no cubic through them; try more --frames")
    })?;
    let level = |at: usize| Level {
        number: at + 1,
        wanted: wanted[at],
        fed: fed[at],
        measured: measured[at],
        corrected: f64::from(correction.coverage(wanted[at] as f32)),
    };
    let levels = (0..LEVELS).map(level).collect();
    Ok(Calibration { run, method: method.to_string(), aa: antialiasing.to_string(), levels, correction })
}

/// First and end column and row of the inside of each transparent panel, pixels.
pub(crate) fn areas([width, height]: [u32; 2]) -> anyhow::Result<[[u32; 4]; LEVELS]> {
    let (width, height) = (f64::from(width), f64::from(height));
    // The scene's panels fill 16:9, whatever the picture's shape.
    let column_px = height * 16.0 / 9.0 / LEVELS as f64;
    let areas = std::array::from_fn(|level| {
        let left = width / 2.0 + (level as f64 - LEVELS as f64 / 2.0) * column_px;
        let first = (left.max(0.0) + MARGIN_PX).ceil();
        let end = ((left + column_px).min(width) - MARGIN_PX).floor();
        [first, end, MARGIN_PX, (height / 2.0 - MARGIN_PX).floor()].map(|edge| edge.max(0.0) as u32)
    });
    if areas.iter().any(|[first, end, top, bottom]| end <= first || bottom <= top) {
        let problem = "the picture is too small or too narrow to show ten columns; try --size 960x540";
        return Err(Misuse(problem.to_owned()).into());
    }
    Ok(areas)
}

fn mean_brightness(planes: &Planes, [first, end, top, bottom]: [u32; 4]) -> f64 {
    let (width, _) = planes.colour.size();
    let rows = planes.colour.as_slice().chunks_exact(width as usize);
    let rows = rows.skip(top as usize).take((bottom - top) as usize);
    let sum: f64 = rows.flat_map(|row| &row[first as usize..end as usize]).map(|&[r, ..]| f64::from(r)).sum();
    sum / (f64::from(end - first) * f64::from(bottom - top))
}
