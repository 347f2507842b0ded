//! A camera of one's own, one shaded fragment a pixel, layered accumulation: what an interactive program does
//! each frame. `cargo run --release --example fly` tells how far each frame is from the exact picture.

use std::error::Error;

use glam::Vec3;
use sheer_render::{Antialiasing, Pipeline, Settings, Stage};
use sheer_scene::camera::{CameraPose, Lens};

#[expect(clippy::print_stdout, reason = "a program that tells what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    for (index, error) in errors([480, 270], 24)?.iter().enumerate() {
        println!("frame {index}: {error:.4} from the exact picture, root mean square");
    }
    Ok(())
}

/// The camera of a moment: it rises in front of the panes and looks at their middle.
fn pose(time_secs: f32) -> CameraPose {
    let eye = Vec3::new(0.4 * time_secs, 0.3 * time_secs, 3.0);
    CameraPose::looking_at(Lens::Orthographic { half_height: 0.9 }, eye, Vec3::ZERO)
}

/// Flies a number of frames and holds each against all fragments of the same sample, added up likewise: root
/// mean square of the difference in linear light.
pub(crate) fn errors(size: [u32; 2], frames: u32) -> Result<Vec<f64>, Box<dyn Error>> {
    let scene = sheer_gallery::open("layers:count=8,alpha=0.3,colours=rainbow")?.scene;
    let mut stage = Stage::new(scene, &Default::default(), None)?;
    let settings = Settings { size, ..Settings::default() };
    let pipeline = |method: &str| -> Result<Pipeline, Box<dyn Error>> {
        Ok(Pipeline::new(method.parse()?, Antialiasing::LAYERED, settings)?)
    };
    // Both see the same stage: it is animated, and its tree built, once a frame.
    let (mut fast, mut exact) = (pipeline("joint")?, pipeline("baseline")?);
    let mut errors = Vec::new();
    for index in 0..frames {
        let moment = fast.clock().at(index);
        // Half-way the camera jumps, and the past says nothing of what it sees now.
        let is_cut = index == frames / 2;
        stage.look_from(pose(moment.time_secs + if index >= frames / 2 { 1.0 } else { 0.0 }));
        if is_cut {
            fast.reset_history();
            exact.reset_history();
        }
        stage.advance(moment);
        fast.render(&stage, index)?;
        exact.render(&stage, index)?;
        let pairs = fast.planes().colour.as_slice().iter().zip(exact.planes().colour.as_slice());
        let square = |(a, b): (&[f32; 4], &[f32; 4])| -> f64 {
            (0..3).map(|channel| f64::from(a[channel] - b[channel]).powi(2)).sum()
        };
        let count = 3.0 * f64::from(size[0]) * f64::from(size[1]);
        errors.push((pairs.map(square).sum::<f64>() / count).sqrt());
    }
    Ok(errors)
}
