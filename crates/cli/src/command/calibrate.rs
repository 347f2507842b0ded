//! `sheer calibrate`: what a method under an anti-aliasing shows of ten opacities, and the correction that sets it right (STD section 3.2.1).

use serde::Serialize;
use sheer_core::coverage::Correction;
use sheer_image::Planes;
use sheer_render::{Background, Pipeline};

use crate::{
    args::{CalibrateArguments, DEFAULT_SIZE, SceneArguments},
    failure::Misuse,
    output::{self, TextOutput},
    report::{
        json,
        table::{Table, number},
    },
};

/// Columns of the scene `calibration`.
const LEVELS: usize = 10;
/// Kept clear around each column and half: jitter and the neighbourhood of anti-aliasing reach across the edges.
const MARGIN_PX: f64 = 3.0;

/// What `correction=FILE` takes.
#[derive(Serialize)]
struct CorrectionFile {
    coefficients: [f32; 4],
}

/// Of one column.
struct Level {
    wanted: f64,
    fed: f64,
    measured: f64,
}

pub(crate) fn run(arguments: &CalibrateArguments) -> anyhow::Result<()> {
    let talk = arguments.machine.apply()?;
    let settings = arguments.frames.settings(DEFAULT_SIZE);
    let areas = areas(settings.size)?;
    if settings.background != Background::Environment {
        return Err(Misuse("calibrate measures over black: leave --background out".to_owned()).into());
    }
    let file = arguments.output.as_deref().map(TextOutput::open).transpose()?;

    let scene = SceneArguments { text: "calibration".to_owned(), camera: None, alpha: None };
    let mut stage = scene.open(arguments.machine, talk)?.stage;
    let method = &arguments.method;
    let mut pipeline = Pipeline::new(method.clone(), arguments.antialiasing, settings)?;
    let frames = arguments.frames.frames;
    let progress = talk.progress(u64::from(frames));
    let mut sums = [0.0; LEVELS];
    for index in 0..frames {
        stage.advance(pipeline.clock().at(index));
        pipeline.render(&stage, index)?;
        if index >= frames / 2 {
            for (sum, area) in sums.iter_mut().zip(areas) {
                *sum += mean_brightness(pipeline.planes(), area);
            }
        }
        progress.inc(1);
    }
    progress.finish_and_clear();

    let levels: [Level; LEVELS] = std::array::from_fn(|at| {
        let wanted = (at + 1) as f64 / LEVELS as f64;
        let fed = f64::from(method.correction().coverage(wanted as f32));
        // The last column is opaque white.
        Level { wanted, fed, measured: sums[at] / sums[LEVELS - 1] }
    });
    let pairs = levels.each_ref().map(|level| [level.measured, level.fed]);
    let correction = Correction::fit(&pairs).ok_or_else(|| {
        anyhow::anyhow!("{method} shows fewer than four different opacities: there is no cubic through them; try more --frames")
    })?;
    let text = json::text(&CorrectionFile { coefficients: correction.coefficients() })?;
    match &file {
        Some(output) if output.is_stdout() => output.write(&text),
        Some(output) => output.write(&text).and_then(|()| output::print(&report(&levels, correction))),
        None => output::print(&report(&levels, correction)),
    }
}

/// First and end column and row of the inside of each transparent panel, pixels.
fn areas([width, height]: [u32; 2]) -> anyhow::Result<[[u32; 4]; LEVELS]> {
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

fn report(levels: &[Level], correction: Correction) -> String {
    let mut table = Table::new(&["level", "wanted", "measured", "corrected"]);
    for (at, level) in levels.iter().enumerate() {
        let corrected = f64::from(correction.coverage(level.wanted as f32));
        let cells = [level.wanted, level.measured, corrected].map(|value| number(value, 4));
        table.add([vec![(at + 1).to_string()], cells.to_vec()].concat());
    }
    let [c0, c1, c2, c3] = correction.coefficients().map(f64::from);
    let squares = levels.iter().map(|level| {
        let m = level.measured;
        (c0 + c1 * m + c2 * m * m + c3 * m.powi(3) - level.fed).powi(2)
    });
    let residual = (squares.sum::<f64>() / levels.len() as f64).sqrt();
    format!(
        "{}\ncoverage to feed, from opacity wanted: {c0:.4} + {c1:.4} a + {c2:.4} a^2 + {c3:.4} a^3\nroot mean square residual: {residual:.4}\n\n{}",
        table.text(),
        plot(levels, correction)
    )
}

/// Over the wanted opacities: `.` themselves, `o` measured, `x` corrected.
fn plot(levels: &[Level], correction: Correction) -> String {
    const ROWS: usize = 10;
    let row = |value: f64| (value.clamp(0.0, 1.0) * ROWS as f64).round() as usize;
    let mut text = String::new();
    for at in (0..=ROWS).rev() {
        let mut line = format!("{:.1} |", at as f64 / ROWS as f64);
        for level in levels {
            let corrected = f64::from(correction.coverage(level.wanted as f32));
            let marks = [(level.wanted, '.'), (level.measured, 'o'), (corrected, 'x')];
            line.push(' ');
            line.extend(marks.map(|(value, mark)| if row(value) == at { mark } else { ' ' }));
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text + ". wanted  o measured  x corrected\n"
}
