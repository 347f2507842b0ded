//! The one source of randomness in built-in scenes: seeded streams, one for each thing, so that a change to
//! the trees leaves the houses alone.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use sheer_core::hash::{Pcg32, fnv1a};

/// A seeded random stream.
pub(crate) struct Rng {
    generator: Pcg32,
}

impl Rng {
    /// The stream of the thing called `purpose`.
    pub(crate) fn new(seed: u32, purpose: &str) -> Self {
        Self { generator: Pcg32::new(u64::from(seed), fnv1a(purpose.bytes())) }
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        self.generator.next_f32()
    }

    /// Uniform in [`low`, `high`).
    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        self.generator.range(low, high)
    }

    /// Uniform around `value`, at most `spread` away from it.
    pub(crate) fn about(&mut self, value: f32, spread: f32) -> f32 {
        self.between(value - spread, value + spread)
    }

    /// A whole number, uniform from 0 to `count - 1`.
    pub(crate) fn below(&mut self, count: u32) -> u32 {
        self.generator.below(count)
    }

    /// True with this probability.
    pub(crate) fn happens(&mut self, probability: f32) -> bool {
        self.unit() < probability
    }

    /// One of the choices, each as likely as the others; there must be one at least.
    pub(crate) fn pick<'a, T>(&mut self, choices: &'a [T]) -> &'a T {
        &choices[self.below(choices.len() as u32) as usize]
    }

    /// Uniform on the unit sphere.
    pub(crate) fn direction(&mut self) -> Vec3 {
        let height = self.between(-1.0, 1.0);
        let around = Vec2::from_angle(self.between(0.0, TAU)) * (1.0 - height * height).max(0.0).sqrt();
        Vec3::new(around.x, height, around.y)
    }

    /// Normally distributed in each coordinate, of unit variance, cut at three standard deviations.
    pub(crate) fn gaussian(&mut self) -> Vec3 {
        let mut pair = || {
            let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt().min(3.0);
            Vec2::from_angle(self.between(0.0, TAU)) * radius
        };
        let (first, second) = (pair(), pair());
        Vec3::new(first.x, first.y, second.x)
    }

    /// A random order (Fisher and Yates).
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last as u32 + 1) as usize);
        }
    }
}
