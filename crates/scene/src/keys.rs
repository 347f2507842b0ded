//! Keyframe evaluation (glTF 2.0, appendix C).

use std::ops::{Add, Mul};

use glam::{Quat, Vec3};

use crate::model::{Interpolation, Keys};

/// A value that can be blended between keys.
pub(crate) trait Blend: Clone {
    /// On the way from `self` to `to`, `s` in [0, 1].
    fn linear(&self, to: &Self, s: f32) -> Self;
    /// Weighted sum of four, for splines.
    fn sum(terms: [(&Self, f32); 4]) -> Self;
}

fn weighted<T: Copy + Mul<f32, Output = T> + Add<Output = T>>([a, b, c, d]: [(&T, f32); 4]) -> T {
    *a.0 * a.1 + *b.0 * b.1 + *c.0 * c.1 + *d.0 * d.1
}

impl Blend for Vec3 {
    fn linear(&self, to: &Self, s: f32) -> Self {
        self.lerp(*to, s)
    }
    fn sum(terms: [(&Self, f32); 4]) -> Self {
        weighted(terms)
    }
}

impl Blend for Quat {
    fn linear(&self, to: &Self, s: f32) -> Self {
        self.slerp(*to, s)
    }
    fn sum(terms: [(&Self, f32); 4]) -> Self {
        let blended = weighted(terms);
        if blended.length_squared() > 0.0 { blended.normalize() } else { Self::IDENTITY }
    }
}

impl Blend for Vec<f32> {
    fn linear(&self, to: &Self, s: f32) -> Self {
        self.iter().zip(to).map(|(a, b)| a + (b - a) * s).collect()
    }
    fn sum([a, b, c, d]: [(&Self, f32); 4]) -> Self {
        let lanes = a.0.iter().zip(b.0).zip(c.0).zip(d.0);
        lanes.map(|(((p, q), r), t)| p * a.1 + q * b.1 + r * c.1 + t * d.1).collect()
    }
}

impl<T> Keys<T> {
    /// Time of the last key.
    pub(crate) fn end_secs(&self) -> f32 {
        self.times_secs.last().copied().unwrap_or(0.0)
    }
}

/// The value at a time; held before the first key and after the last.
pub(crate) fn value_at<T: Blend>(keys: &Keys<T>, time_secs: f32) -> T {
    let next = keys.times_secs.partition_point(|&key| key <= time_secs);
    // Splines keep three entries a key: in-tangent, value, out-tangent.
    let spline = keys.interpolation == Interpolation::CubicSpline;
    let value = |key: usize| &keys.values[if spline { 3 * key + 1 } else { key }];
    let (Some(previous), true) = (next.checked_sub(1), next < keys.times_secs.len()) else {
        return value(next.saturating_sub(1)).clone();
    };
    let span_secs = keys.times_secs[next] - keys.times_secs[previous];
    let s = (time_secs - keys.times_secs[previous]) / span_secs;
    match keys.interpolation {
        Interpolation::Step => value(previous).clone(),
        Interpolation::Linear => value(previous).linear(value(next), s),
        Interpolation::CubicSpline => {
            let (s2, s3) = (s * s, s * s * s);
            T::sum([
                (value(previous), 2.0 * s3 - 3.0 * s2 + 1.0),
                (&keys.values[3 * previous + 2], span_secs * (s3 - 2.0 * s2 + s)),
                (value(next), 3.0 * s2 - 2.0 * s3),
                (&keys.values[3 * next], span_secs * (s3 - s2)),
            ])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(interpolation: Interpolation, values: Vec<Vec3>) -> Keys<Vec3> {
        Keys { times_secs: vec![1.0, 3.0], values, interpolation }
    }

    #[test]
    fn values_are_held_outside_the_keys_and_blended_between() {
        let linear = keys(Interpolation::Linear, vec![Vec3::ZERO, Vec3::splat(4.0)]);
        assert_eq!(value_at(&linear, 0.0), Vec3::ZERO);
        assert_eq!(value_at(&linear, 1.5), Vec3::ONE);
        assert_eq!(value_at(&linear, 9.0), Vec3::splat(4.0));
        let step = Keys { interpolation: Interpolation::Step, ..linear };
        assert_eq!(value_at(&step, 2.9), Vec3::ZERO);
        assert_eq!(value_at(&step, 3.0), Vec3::splat(4.0));
    }

    #[test]
    fn a_spline_with_chord_tangents_is_a_straight_line() {
        let chord = Vec3::splat(2.0);
        let values = vec![Vec3::ZERO, Vec3::ZERO, chord, chord, Vec3::splat(4.0), Vec3::ZERO];
        let spline = keys(Interpolation::CubicSpline, values);
        assert!((value_at(&spline, 1.5) - Vec3::ONE).length() < 1e-6);
        assert_eq!(value_at(&spline, 0.0), Vec3::ZERO);
        assert_eq!(value_at(&spline, 5.0), Vec3::splat(4.0));
    }
}
