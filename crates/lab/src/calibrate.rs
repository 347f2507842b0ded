//! What a method under an anti-aliasing shows of ten opacities, and the correction that sets it right (STD
//! section 3.2.1).

use sheer_core::coverage::Correction;
use sheer_image::Planes;
use sheer_render::{Backend, Method};

use crate::{
    LabError, Progress, Result, Timeline,
    figures::{Column, Figures},
    play::{Event, play},
};

/// Columns of the scene `calibration`.
pub const LEVELS: usize = 10;
/// Kept clear around each column and half: jitter and the neighbourhood of anti-aliasing reach across the
/// edges.
const MARGIN_PX: f64 = 3.0;

/// What a method under an anti-aliasing shows of some opacities, and the correction that sets it right.
#[derive(Debug)]
pub struct Calibration {
    /// By opacity, ascending.
    pub levels: Vec<Level>,
    /// From the opacity wanted to the coverage to feed.
    pub correction: Correction,
}

/// One column of the scene.
#[derive(Debug)]
pub struct Level {
    /// From 1.
    pub number: usize,
    /// Opacity of the material.
    pub wanted: f64,
    /// Coverage that the method was fed with for it.
    pub fed: f64,
    /// Opacity in the picture.
    pub measured: f64,
    /// Coverage that shows what is wanted.
    pub corrected: f64,
}

const COLUMNS: &[Column<Level>] = &[
    Column {
        title: "wanted",
        meaning: "Opacity of the material.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |level| Some(level.wanted),
    },
    Column {
        title: "measured",
        meaning: "Opacity that the picture shows: brightness of white with this opacity over black, the mean over the last half of the frames.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |level| Some(level.measured),
    },
    Column {
        title: "corrected",
        meaning: "Coverage to feed the method with, so that it shows the opacity that is wanted.",
        decimals: 4,
        is_optional: false,
        is_time: false,
        value: |level| Some(level.corrected),
    },
];

impl Calibration {
    /// Fits the correction to what a method showed.
    ///
    /// # Errors
    /// [`LabError::NoResult`] if it shows too few opacities to fit a cubic to.
    pub fn fit(method: &Method, measured: [f64; LEVELS]) -> Result<Self> {
        let wanted: [f64; LEVELS] = std::array::from_fn(|at| (at + 1) as f64 / LEVELS as f64);
        let fed = wanted.map(|wanted| f64::from(method.correction().coverage(wanted as f32)));
        let pairs: [[f64; 2]; LEVELS] = std::array::from_fn(|at| [measured[at], fed[at]]);
        let correction = Correction::fit(&pairs).ok_or_else(|| {
            LabError::NoResult(format!(
                "{method} shows fewer than four different opacities: there is no cubic through them; try more --frames"
            ))
        })?;
        let level = |at: usize| Level {
            number: at + 1,
            wanted: wanted[at],
            fed: fed[at],
            measured: measured[at],
            corrected: f64::from(correction.coverage(wanted[at] as f32)),
        };
        Ok(Self { levels: (0..LEVELS).map(level).collect(), correction })
    }

    /// The table.
    #[must_use]
    pub fn figures(&self) -> Figures {
        Figures::new(&[("level", |level: &Level| level.number.to_string())], COLUMNS, &self.levels)
    }

    /// Root mean square distance of the cubic from the points that it was fitted to.
    #[must_use]
    pub fn residual(&self) -> f64 {
        let [c0, c1, c2, c3] = self.correction.coefficients().map(f64::from);
        let squares = self.levels.iter().map(|level| {
            let m = level.measured;
            (c0 + c1 * m + c2 * m * m + c3 * m.powi(3) - level.fed).powi(2)
        });
        (squares.sum::<f64>() / self.levels.len() as f64).sqrt()
    }
}

/// The ten opacities that a pipeline shows of the scene `calibration`, given the panels' [`areas`]: means
/// over the last half of the frames.
///
/// # Errors
/// What the backend says.
pub fn shown_opacities<B: Backend>(
    backend: &B,
    stage: &mut B::Stage,
    pipeline: &mut B::Pipeline,
    areas: [[u32; 4]; LEVELS],
    timeline: Timeline<'_>,
    progress: &dyn Progress,
) -> Result<[f64; LEVELS]> {
    let mut sums = [0.0; LEVELS];
    play(backend, stage, std::slice::from_mut(pipeline), timeline, |event| {
        let Event::Frame { index, pipelines, .. } = event else { return Ok(()) };
        if index >= timeline.frames() / 2 {
            let planes =
                backend.planes(&pipelines[0]).map_err(|error| LabError::of_backend(backend, error))?;
            for (sum, area) in sums.iter_mut().zip(areas) {
                *sum += mean_brightness(&planes, area);
            }
        }
        progress.step();
        Ok(())
    })?;
    // The last column is opaque white.
    Ok(sums.map(|sum| sum / sums[LEVELS - 1]))
}

/// First and end column and row of the inside of each transparent panel, pixels.
///
/// # Errors
/// [`LabError::Misuse`] if the picture is too small to tell the columns apart.
pub fn areas([width, height]: [u32; 2]) -> Result<[[u32; 4]; LEVELS]> {
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
        return Err(LabError::Misuse(problem.to_owned()));
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
