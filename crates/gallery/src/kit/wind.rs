//! Wind: what sways in it is built at rest and in the extremes of two travelling waves, and each moment mixes
//! these poses.
//!
//! A wave that arrives at a place `phase` late is `cos(ωt - phase) = cos ωt cos phase + sin ωt sin phase`:
//! two poses and two weights are enough for any number of places, each with its own phase.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};
use sheer_scene::model::{Interpolation, Keys};

/// All wind repeats after this time.
pub(crate) const LOOP_SECS: f32 = 6.0;
/// How often each wave swings in a loop: a slow billow and a flutter. Whole numbers close the loop.
const SWINGS: [u32; 2] = [2, 5];
/// Keys a swing: a cubic through sixteen of them is off by less than a thousandth of the amplitude.
const KEYS_PER_SWING: u32 = 16;

/// How far the waves have swung: the cosine and the sine of each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sway([[f32; 2]; 2]);

impl Sway {
    /// Rest, and then each weight alone.
    pub(crate) const POSES: [Self; 5] = [
        Self([[0.0, 0.0], [0.0, 0.0]]),
        Self([[1.0, 0.0], [0.0, 0.0]]),
        Self([[0.0, 1.0], [0.0, 0.0]]),
        Self([[0.0, 0.0], [1.0, 0.0]]),
        Self([[0.0, 0.0], [0.0, 1.0]]),
    ];

    /// Slow wave where it arrives this much late.
    pub(crate) fn billow(self, phase_rad: f32) -> f32 {
        self.wave(0, phase_rad)
    }

    /// Fast wave where it arrives this much late.
    pub(crate) fn flutter(self, phase_rad: f32) -> f32 {
        self.wave(1, phase_rad)
    }

    fn wave(self, wave: usize, phase_rad: f32) -> f32 {
        let (sin, cos) = phase_rad.sin_cos();
        self.0[wave][0] * cos + self.0[wave][1] * sin
    }
}

/// The weights of the poses after the first, over one loop.
pub(crate) fn weights() -> Keys<Vec<f32>> {
    let count = KEYS_PER_SWING * SWINGS[1];
    let mut keys =
        Keys { times_secs: Vec::new(), values: Vec::new(), interpolation: Interpolation::CubicSpline };
    for key in 0..=count {
        // The last key is the first one, to the bit.
        let turns = SWINGS.map(|swings| (swings * key % (swings * count)) as f32 / count as f32);
        let speeds = SWINGS.map(|swings| TAU * swings as f32 / LOOP_SECS);
        let value: Vec<f32> =
            turns.iter().flat_map(|turn| [(TAU * turn).cos(), (TAU * turn).sin()]).collect();
        let slope: Vec<f32> = turns
            .iter()
            .zip(speeds)
            .flat_map(|(turn, speed)| [-(TAU * turn).sin() * speed, (TAU * turn).cos() * speed])
            .collect();
        keys.times_secs.push(LOOP_SECS * key as f32 / count as f32);
        keys.values.extend([slope.clone(), value, slope]);
    }
    keys
}

/// Whole turns around an axis, one a loop.
pub(crate) fn turns(axis: Vec3) -> Keys<Quat> {
    let quarter = |key: u32| Quat::from_axis_angle(axis, 0.25 * TAU * key as f32);
    Keys {
        times_secs: (0..=4).map(|key| 0.25 * LOOP_SECS * key as f32).collect(),
        values: (0..=4).map(quarter).collect(),
        interpolation: Interpolation::Linear,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_follow_the_waves_and_close_their_loop() {
        let keys = weights();
        for step in 0..200 {
            let time_secs = LOOP_SECS * step as f32 / 200.0;
            let value = keys.value_at(time_secs);
            for (wave, swings) in SWINGS.into_iter().enumerate() {
                let (sin, cos) = (TAU * swings as f32 * step as f32 / 200.0).sin_cos();
                let error = (value[2 * wave] - cos).abs().max((value[2 * wave + 1] - sin).abs());
                assert!(error < 1e-3, "{error} at {time_secs}");
            }
        }
        assert_eq!(keys.value_at(0.0), keys.value_at(LOOP_SECS));
    }

    #[test]
    fn a_wave_arrives_late_by_its_phase() {
        let swung = |turn_rad: f32| Sway([[turn_rad.cos(), turn_rad.sin()], [0.0, 0.0]]);
        assert!((swung(1.3).billow(1.3) - 1.0).abs() < 1e-6);
        assert!((swung(1.3).billow(0.3) - 1.0_f32.cos()).abs() < 1e-6);
        assert_eq!(swung(1.3).flutter(0.7), 0.0);
    }
}
