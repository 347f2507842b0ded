//! Pictures to be checked.

use std::fs;

use sheer_image::Planes;
use sheer_render::{Antialiasing, Settings, Stage, backend::Cpu};
use sheer_scene::CameraChoice;

use crate::{LabError, Result};

/// A stage of a scene that needs no warnings.
pub(super) fn stage(scene: &str, threads: Option<usize>) -> Result<Stage> {
    Ok(Stage::new(sheer_gallery::open(scene)?.scene, &CameraChoice::Default, threads)?)
}

/// A stage of a glTF file that the binary carries, given by its files with the glTF one first, and every
/// material as transparent as asked.
pub(super) fn stage_of_files(files: &[(&str, &[u8])], alpha: f32, threads: Option<usize>) -> Result<Stage> {
    let folder = tempfile::tempdir()?;
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes)?;
    }
    let path = folder.path().join(files[0].0);
    let path = path.to_str().ok_or_else(|| {
        LabError::NoResult(
            "the folder of temporary files has a name that is not UTF-8: set TMPDIR".to_owned(),
        )
    })?;
    let scene = sheer_gallery::open(path)?.scene.with_alpha(alpha);
    Ok(Stage::new(scene, &CameraChoice::Default, threads)?)
}

/// What `sheer render` would write.
pub(super) fn render(
    scene: &str,
    method: &str,
    antialiasing: Antialiasing,
    settings: Settings,
    frames: u32,
    threads: Option<usize>,
) -> Result<Planes> {
    let mut stage = stage(scene, threads)?;
    play(&mut stage, method, antialiasing, settings, frames)
}

/// The same from a stage that is there already.
pub(super) fn play(
    stage: &mut Stage,
    method: &str,
    antialiasing: Antialiasing,
    settings: Settings,
    frames: u32,
) -> Result<Planes> {
    let method = method.parse()?;
    Ok(crate::picture(&Cpu, stage, &method, antialiasing, settings, frames)?.0)
}

/// Mean linear colour.
pub(super) fn mean_colour(planes: &Planes) -> [f64; 3] {
    let pixels = planes.colour.as_slice();
    let sum = pixels.iter().fold([0.0; 3], |sum, pixel| [0, 1, 2].map(|at| sum[at] + f64::from(pixel[at])));
    sum.map(|sum| sum / pixels.len() as f64)
}
