//! Keyframe evaluation (glTF 2.0, appendix C).

use std::ops::{Add, Mul};

use glam::{Quat, Vec2, Vec3, Vec4};

use crate::model::{Animation, Interpolation, Keys, Property, Track};

/// A value that an animation can interpolate between its keys.
pub trait Interpolate: Clone {
    /// The value at the share `s`, 0 to 1, of the way from `self` to `to`: straight, or along the great arc
    /// for a rotation.
    fn linear(&self, to: &Self, s: f32) -> Self;
    /// The weighted sum of four values that a cubic spline asks for; a rotation comes back as a unit
    /// quaternion.
    fn sum(terms: [(&Self, f32); 4]) -> Self;
}

fn weighted<T: Copy + Mul<f32, Output = T> + Add<Output = T>>([a, b, c, d]: [(&T, f32); 4]) -> T {
    *a.0 * a.1 + *b.0 * b.1 + *c.0 * c.1 + *d.0 * d.1
}

impl Interpolate for f32 {
    fn linear(&self, to: &Self, s: f32) -> Self {
        self + (to - self) * s
    }
    fn sum(terms: [(&Self, f32); 4]) -> Self {
        weighted(terms)
    }
}

macro_rules! interpolate_vectors {
    ($($vector:ty),*) => {$(
        impl Interpolate for $vector {
            fn linear(&self, to: &Self, s: f32) -> Self {
                self.lerp(*to, s)
            }
            fn sum(terms: [(&Self, f32); 4]) -> Self {
                weighted(terms)
            }
        }
    )*};
}
interpolate_vectors!(Vec2, Vec3, Vec4);

impl Interpolate for Quat {
    fn linear(&self, to: &Self, s: f32) -> Self {
        self.slerp(*to, s)
    }
    fn sum(terms: [(&Self, f32); 4]) -> Self {
        let blended = weighted(terms);
        if blended.length_squared() > 0.0 { blended.normalize() } else { Self::IDENTITY }
    }
}

impl Interpolate for Vec<f32> {
    fn linear(&self, to: &Self, s: f32) -> Self {
        self.iter().zip(to).map(|(a, b)| a + (b - a) * s).collect()
    }
    fn sum([a, b, c, d]: [(&Self, f32); 4]) -> Self {
        let lanes = a.0.iter().zip(b.0).zip(c.0).zip(d.0);
        lanes.map(|(((p, q), r), t)| p * a.1 + q * b.1 + r * c.1 + t * d.1).collect()
    }
}

impl Interpolation {
    /// How many values belong to a key: splines have a tangent before it and one after it.
    #[must_use]
    pub fn values_per_key(self) -> usize {
        if self == Self::CubicSpline { 3 } else { 1 }
    }
}

impl<T> Keys<T> {
    /// What stays as it is.
    #[must_use]
    pub fn constant(value: T) -> Self {
        Self { times_secs: vec![0.0], values: vec![value], interpolation: Interpolation::Step }
    }

    /// The values at the keys, without the tangents of splines.
    pub fn key_values_mut(&mut self) -> impl Iterator<Item = &mut T> {
        let values_per_key = self.interpolation.values_per_key();
        self.values.iter_mut().skip(values_per_key / 2).step_by(values_per_key)
    }

    /// Time of the last key, seconds; 0 without keys.
    #[must_use]
    pub fn end_secs(&self) -> f32 {
        self.times_secs.last().copied().unwrap_or(0.0)
    }
}

impl<T: Interpolate> Keys<T> {
    /// The value at a time; held before the first key and after the last.
    ///
    /// # Panics
    /// Without keys, or with fewer values than the interpolation asks for: neither occurs in a validated
    /// scene.
    #[must_use]
    pub fn value_at(&self, time_secs: f32) -> T {
        let next = self.times_secs.partition_point(|&key| key <= time_secs);
        // Splines keep three entries a key: in-tangent, value, out-tangent.
        let spline = self.interpolation == Interpolation::CubicSpline;
        let value = |key: usize| &self.values[if spline { 3 * key + 1 } else { key }];
        let (Some(previous), true) = (next.checked_sub(1), next < self.times_secs.len()) else {
            return value(next.saturating_sub(1)).clone();
        };
        let span_secs = self.times_secs[next] - self.times_secs[previous];
        let s = (time_secs - self.times_secs[previous]) / span_secs;
        match self.interpolation {
            Interpolation::Step => value(previous).clone(),
            Interpolation::Linear => value(previous).linear(value(next), s),
            Interpolation::CubicSpline => {
                let (s2, s3) = (s * s, s * s * s);
                T::sum([
                    (value(previous), 2.0 * s3 - 3.0 * s2 + 1.0),
                    (&self.values[3 * previous + 2], span_secs * (s3 - 2.0 * s2 + s)),
                    (value(next), 3.0 * s2 - 2.0 * s3),
                    (&self.values[3 * next], span_secs * (s3 - s2)),
                ])
            }
        }
    }
}

impl Track {
    /// Times of the keys, seconds.
    #[must_use]
    pub fn times_secs(&self) -> &[f32] {
        match self {
            Self::Translation(keys) | Self::Scale(keys) => &keys.times_secs,
            Self::Rotation(keys) => &keys.times_secs,
            Self::MorphWeights(keys) => &keys.times_secs,
        }
    }

    /// Time of the last key, seconds; 0 without keys.
    #[must_use]
    pub fn end_secs(&self) -> f32 {
        match self {
            Self::Translation(keys) | Self::Scale(keys) => keys.end_secs(),
            Self::Rotation(keys) => keys.end_secs(),
            Self::MorphWeights(keys) => keys.end_secs(),
        }
    }
}

impl Property {
    /// Time of the last key, seconds; 0 without keys.
    #[must_use]
    pub fn end_secs(&self) -> f32 {
        match self {
            Self::BaseColour { factor, .. } => factor.end_secs(),
            Self::Emissive { factor, strength, .. } => factor.end_secs().max(strength.end_secs()),
            Self::Factor { value, .. } | Self::LightShape { value, .. } | Self::Lens { value, .. } => {
                value.end_secs()
            }
            Self::Transmission { share, .. } => share.end_secs(),
            Self::TextureTransform { offset, rotation_rad, scale, .. } => {
                offset.end_secs().max(rotation_rad.end_secs()).max(scale.end_secs())
            }
            Self::LightIntensity { colour, intensity, .. } => colour.end_secs().max(intensity.end_secs()),
            Self::Visibility { visible, .. } => visible.end_secs(),
        }
    }
}

impl Animation {
    /// Time of the last key of all, seconds: then it starts anew. 0 without keys.
    #[must_use]
    pub fn duration_secs(&self) -> f32 {
        let channels = self.channels.iter().map(|channel| channel.track.end_secs());
        channels.chain(self.properties.iter().map(Property::end_secs)).fold(0.0, f32::max)
    }

    /// The time within the loop.
    pub(crate) fn looped(&self, time_secs: f32) -> f32 {
        let duration_secs = self.duration_secs();
        if duration_secs > 0.0 { time_secs.rem_euclid(duration_secs) } else { time_secs }
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
        assert_eq!(linear.value_at(0.0), Vec3::ZERO);
        assert_eq!(linear.value_at(1.5), Vec3::ONE);
        assert_eq!(linear.value_at(9.0), Vec3::splat(4.0));
        let step = Keys { interpolation: Interpolation::Step, ..linear };
        assert_eq!(step.value_at(2.9), Vec3::ZERO);
        assert_eq!(step.value_at(3.0), Vec3::splat(4.0));
    }

    #[test]
    fn a_spline_with_chord_tangents_is_a_straight_line() {
        let chord = Vec3::splat(2.0);
        let values = vec![Vec3::ZERO, Vec3::ZERO, chord, chord, Vec3::splat(4.0), Vec3::ZERO];
        let spline = keys(Interpolation::CubicSpline, values);
        assert!((spline.value_at(1.5) - Vec3::ONE).length() < 1e-6);
        assert_eq!(spline.value_at(0.0), Vec3::ZERO);
        assert_eq!(spline.value_at(5.0), Vec3::splat(4.0));
    }
}
