//! What lies behind a pixel: `cargo run --release --example fragments` lists the fragments in the middle of a
//! picture of smoke, front to back, with what is left to see behind each.

use std::error::Error;

use glam::Vec2;
use sheer_render::Stage;

/// A surface behind a point of the picture.
pub(crate) struct Fragment {
    /// World units from the eye.
    pub(crate) distance: f32,
    /// 1 is opaque.
    pub(crate) alpha: f32,
    /// What is seen of things behind this fragment and all in front of it.
    pub(crate) transmittance: f32,
}

#[expect(clippy::print_stdout, reason = "a program that tells what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    for Fragment { distance, alpha, transmittance } in fragments([480, 270])? {
        println!("{distance:8.3} away, alpha {alpha:.3}, behind it {transmittance:.4} is seen");
    }
    Ok(())
}

/// The fragments in the middle of a picture of so many pixels.
pub(crate) fn fragments(size: [u32; 2]) -> Result<Vec<Fragment>, Box<dyn Error>> {
    let scene = sheer_gallery::open("smoke-square")?.scene;
    let stage = Stage::new(scene, &Default::default(), None)?;
    let middle_px = Vec2::new(size[0] as f32, size[1] as f32) / 2.0;
    let mut transmittance = 1.0;
    let list = stage.fragments_through(middle_px, size).into_iter().map(|fragment| {
        transmittance *= 1.0 - fragment.alpha;
        Fragment { distance: fragment.distance, alpha: fragment.alpha, transmittance }
    });
    Ok(list.collect())
}
