//! A threshold method of one's own beside one of the table: `cargo run --release --example own_method` tells
//! which of them has less noise where sixteen frames are added up.

use std::error::Error;

use sheer_core::hash::{pcg3d, unit_from_bits};
use sheer_render::{
    Antialiasing, Pipeline, Settings, Stage,
    contract::{Site, Tables, Threshold},
    cpu::{OwnThreshold, Transparency},
};

/// A random number for each pixel and surface, moved on from frame to frame by an irrational step, so that
/// the frames of a pixel are spread evenly (Cranley and Patterson, "Randomization of number theoretic methods
/// for multiple integration", 1976). Surfaces have steps of their own: with one step for all, the same layers
/// would mask each other in every frame.
pub(crate) struct Rotation;

impl Threshold for Rotation {
    fn threshold(&self, site: &Site, _: &Tables) -> f32 {
        // Square roots of primes, without their whole parts.
        const STEPS: [f32; 4] = [0.414_214, 0.732_051, 0.236_068, 0.645_751];
        let surface = site.instance.wrapping_mul(31).wrapping_add(site.geometry);
        let [x, y] = site.pixel;
        let start = unit_from_bits(pcg3d([x, y, surface])[0]);
        (start + STEPS[surface as usize % 4] * (site.frame % 1024) as f32).fract()
    }
}

#[expect(clippy::print_stdout, reason = "a program that tells what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let [own, white] = errors([240, 135])?;
    println!("root mean square error: own method {own:.4}, roulette {white:.4}");
    Ok(())
}

/// Root mean square errors in linear light of [`Rotation`] and of `roulette`.
pub(crate) fn errors(size: [u32; 2]) -> Result<[f64; 2], Box<dyn Error>> {
    let exact = picture("baseline".parse::<sheer_render::Method>()?, size)?;
    let distance = |found: Vec<[f32; 4]>| {
        let difference = |(a, b): (&[f32; 4], &[f32; 4])| f64::from(a[1] - b[1]).powi(2);
        (found.iter().zip(&exact).map(difference).sum::<f64>() / exact.len() as f64).sqrt()
    };
    let own = picture(OwnThreshold(Rotation), size)?;
    let white = picture("roulette".parse::<sheer_render::Method>()?, size)?;
    Ok([distance(own), distance(white)])
}

/// The mean of sixteen frames, by a method of the table or one of the caller's.
fn picture(method: impl Transparency, size: [u32; 2]) -> Result<Vec<[f32; 4]>, Box<dyn Error>> {
    let scene = sheer_gallery::open("layers:count=4,alpha=0.3,colours=rainbow")?.scene;
    let mut stage = Stage::new(scene, &Default::default(), None)?;
    let settings = Settings { size, ..Settings::default() };
    let mut pipeline = Pipeline::with_own(method, Antialiasing::ACCUMULATE, settings)?;
    for index in 0..16 {
        stage.advance(pipeline.clock().at(index));
        pipeline.render(&stage, index)?;
    }
    Ok(pipeline.planes().colour.as_slice().to_vec())
}
