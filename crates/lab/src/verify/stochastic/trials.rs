//! Pixels full of made-up fragments, filled by the methods' own code.

use glam::Vec3;
use sheer_metrics::statistics::Moments;
use sheer_render::{
    Method,
    contract::{
        Fragment, OrderedCompositing, PixelSite, Selection, Threshold, UnorderedCompositing, Visitor,
    },
};

use super::stack::Stack;
use crate::{LabError, Result};

/// The final colours of `count` pixels, each with random numbers of its own, under a compositing method.
pub(super) fn pixels(
    method: &str,
    stack: &Stack,
    count: u32,
    seed: u32,
    visit: impl FnMut([f64; 3]),
) -> Result<()> {
    method.parse::<Method>()?.visit(Trials { stack, count, seed, visit })
}

/// Moments of a function of each channel.
pub(super) fn moments(
    method: &str,
    stack: &Stack,
    count: u32,
    seed: u32,
    of: impl Fn(usize, f64) -> f64,
) -> Result<[Moments; 3]> {
    let mut moments = [Moments::default(); 3];
    pixels(method, stack, count, seed, |colour| {
        for (channel, moments) in moments.iter_mut().enumerate() {
            moments.add(of(channel, colour[channel]));
        }
    })?;
    Ok(moments)
}

struct Trials<'a, F> {
    stack: &'a Stack,
    count: u32,
    seed: u32,
    visit: F,
}

impl<F: FnMut([f64; 3])> Visitor for Trials<'_, F> {
    type Output = Result<()>;

    fn threshold(self, _: &impl Threshold) -> Self::Output {
        Err(LabError::Misuse("a method of one fragment takes no made-up ones".to_owned()))
    }

    fn selection(self, _: &impl Selection) -> Self::Output {
        Err(LabError::Misuse("a method of one fragment takes no made-up ones".to_owned()))
    }

    fn ordered(self, _: &impl OrderedCompositing) -> Self::Output {
        Err(LabError::Misuse("a method that wants its fragments in order takes no made-up ones".to_owned()))
    }

    fn unordered(mut self, method: &impl UnorderedCompositing) -> Self::Output {
        let samples = method.samples();
        let background = Vec3::from_array(self.stack.background.map(|value| value as f32));
        for trial in 0..self.count {
            // Another pixel and another frame: neighbours may be stratified among themselves, frames never
            // are.
            let site = PixelSite {
                pixel: [trial % 1024, trial / 1024],
                frame: trial,
                seed: self.seed,
                depth_range: [1.0, 1000.0],
            };
            let mut pixel = method.begin(&site);
            for pass in 0..method.pass_count() {
                if method.begin_pass(&mut pixel, pass).is_break() {
                    break;
                }
                // Back to front: the worst order for a z-buffer.
                for (place, layer) in self.stack.layers.iter().enumerate().rev() {
                    let fragment = Fragment {
                        alpha: layer.alpha as f32,
                        coverage: samples.all(),
                        depths: &[1.0 + place as f32],
                        order: layer.id,
                        instance: layer.id,
                        geometry: 0,
                        primitive: 0,
                        is_back: false,
                    };
                    let shade = || Vec3::from_array(layer.rgb.map(|value| value as f32));
                    if method.add(&mut pixel, pass, &fragment, shade).is_break() {
                        break;
                    }
                }
            }
            let seen: f32 =
                (0..samples.count as usize).map(|sample| method.transmittance(&pixel, sample)).sum();
            let colour = method.resolve(&pixel) + seen / samples.count as f32 * background;
            (self.visit)(colour.to_array().map(f64::from));
        }
        Ok(())
    }
}
