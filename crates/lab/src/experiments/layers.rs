//! Constant layers, whose picture has a closed form, under an exponential average.

use sheer_gallery::{LayerColours, layers_closed_form};
use sheer_render::{Antialiasing, Backend, Settings};
use sheer_scene::CameraChoice;

use super::lab::Lab;
use crate::{
    LabError, Result, Timeline,
    play::{Event, play},
};

/// Weight of a new frame in the exponential average (STD Eq. 2).
const WEIGHT: f64 = 0.1;

/// Root mean square over pixels, channels and the last 18 of 90 frames by which an exponential average misses
/// the closed form, one for each seed.
pub(super) fn exponential_errors<B: Backend>(
    lab: &Lab<'_, B>,
    method: &str,
    count: u32,
    alpha: f32,
) -> Result<Vec<f64>> {
    const SIZE: [u32; 2] = [48, 27];
    const FRAMES: u32 = 90;
    const MEASURED: u32 = 18;
    let scene = format!("layers:count={count},alpha={alpha},colours=red-green,background=1");
    let expected = layers_closed_form(count, alpha, LayerColours::RedGreen, 1.0).as_dvec3();
    let stage =
        lab.backend.stage(sheer_gallery::open(&scene)?.scene.into(), &CameraChoice::Default, lab.threads);
    let mut stage = stage.map_err(|error| LabError::of_backend(lab.backend, error))?;
    let mut errors = Vec::new();
    for seed in lab.seeds() {
        let (mut sum, mut terms) = (0.0, 0_u32);
        let settings = Settings { size: SIZE, seed, ..Settings::default() };
        let mut pipelines = lab.pipelines(&[method], Antialiasing::NONE, settings)?;
        let mut averages = vec![glam::DVec3::ZERO; (SIZE[0] * SIZE[1]) as usize];
        play(lab.backend, &mut stage, &mut pipelines, Timeline::Still(FRAMES), |event| {
            let Event::Frame { index, pipelines, .. } = event else { return Ok(()) };
            // A young average is a plain mean, as that of TAA.
            let weight = WEIGHT.max(1.0 / (f64::from(index) + 1.0));
            let planes = lab.planes(&pipelines[0])?;
            for (average, &[r, g, b, _]) in averages.iter_mut().zip(planes.colour.as_slice()) {
                *average += weight * (glam::Vec3::new(r, g, b).as_dvec3() - *average);
                if index >= FRAMES - MEASURED {
                    sum += (*average - expected).length_squared();
                    terms += 3;
                }
            }
            Ok(())
        })?;
        errors.push((sum / f64::from(terms)).sqrt());
    }
    Ok(errors)
}
