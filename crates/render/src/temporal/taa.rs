//! Temporal anti-aliasing after Salvi, *An Excursion in Temporal Supersampling*, GDC 2016: an exponential
//! average of reprojected history, rectified by the mean and variance of the new frame's neighbourhood (STD
//! section 2.1, Eq. 2).

use glam::{UVec2, Vec2, Vec4};
use sheer_core::{
    bibliography,
    parameter::{ParameterInfo, ParameterRange, Values},
};
use sheer_image::{Image, ImageError, Planes, Region};

use super::{
    align::Reprojection,
    jitter::{JITTER_PERIOD, halton},
    layer_history::LayerHistory,
    resample::{Place, rgba_from_ycocga, ycocga_from_rgba},
    technique::{AntialiasingInfo, Past, Technique},
};
use crate::contract::{AlignmentRule, ShaderConstant, ShaderValue};

/// The row of the technique in lists and help, and what a GPU needs of it.
pub(super) const INFO: AntialiasingInfo = AntialiasingInfo {
    id: "taa",
    title: "an exponential average of reprojected history, clipped to the new frame's neighbourhood",
    paper: "Salvi 2016, An Excursion in Temporal Supersampling; Brüll, Kern, Grosch (STD), sections 2.1 and 3.2",
    works: &[&bibliography::SALVI_2016, &bibliography::STD],
    stores: "the average colour",
    time_stands_still: false,
    warm_up_frames: 40,
    parameters: &[
        ParameterInfo {
            key: "weight",
            default: "0.1",
            range: ParameterRange::Real(0.001, 1.0),
            what: "of the new frame, once the history holds as many frames as that takes",
        },
        ParameterInfo {
            key: "radius",
            default: "3",
            range: ParameterRange::Count(1, 8),
            what: "of the neighbourhood that history is clipped to where transparent fragments are, pixels",
        },
        ParameterInfo {
            key: "sigma",
            default: "1",
            range: ParameterRange::Real(0.0, 100.0),
            what: "standard deviations of the neighbourhood that history may lie from its mean",
        },
    ],
    constants: &[
        ShaderConstant::real("LEAST_DEVIATION", LEAST_DEVIATION),
        ShaderConstant::real("DEAD_ZONE", AlignmentRule::DEAD_ZONE),
        // Signed as here: it is a loop bound on both sides of zero.
        ShaderConstant { name: "OPAQUE_RADIUS", value: ShaderValue::I32(OPAQUE_RADIUS as i32) },
    ],
};

/// Radius of the neighbourhood of an opaque surface, pixels: 3×3.
const OPAQUE_RADIUS: i64 = 1;

/// An even neighbourhood has no deviation to divide by: this one instead.
const LEAST_DEVIATION: f32 = 1e-6;

/// Temporal anti-aliasing; the defaults are the constants of STD.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taa {
    /// Weight of the new frame (STD Eq. 2).
    weight: f32,
    /// Radius of the neighbourhood where transparent fragments are, pixels.
    radius: u32,
    /// History is kept within this many standard deviations of the neighbourhood's mean.
    sigmas: f32,
}

impl Taa {
    /// With the constants of STD.
    pub(super) const DEFAULT: Self = Self { weight: 0.1, radius: 3, sigmas: 1.0 };

    pub(super) fn new(values: &Values) -> Self {
        Self { weight: values.real("weight"), radius: values.count("radius"), sigmas: values.real("sigma") }
    }
}

impl Technique for Taa {
    fn jitter(&self, frame: u32) -> Vec2 {
        halton(frame % JITTER_PERIOD + 1)
    }

    /// History is held against the neighbourhood of the new frame alone.
    fn margin_px(&self) -> u32 {
        self.radius.max(OPAQUE_RADIUS as u32)
    }

    fn resolve(
        &self,
        past: &Past,
        current: &mut Planes,
        reprojection: Reprojection,
    ) -> Result<Option<LayerHistory>, ImageError> {
        if past.count > 0 {
            current.colour = self.averaged(current, &past.planes.colour, past.count, reprojection)?;
        }
        Ok(None)
    }

    fn values(&self) -> Vec<String> {
        vec![self.weight.to_string(), self.radius.to_string(), self.sigmas.to_string()]
    }
}

impl Taa {
    /// The new history: `current` blended with `history`, the result of `count` earlier frames.
    fn averaged(
        self,
        current: &Planes,
        history: &Image<[f32; 4]>,
        count: u32,
        reprojection: Reprojection,
    ) -> Result<Image<[f32; 4]>, ImageError> {
        let Region { left, top, width, height } = reprojection.region;
        let ycocga = current.colour.par_map(|&rgba| ycocga_from_rgba(rgba));
        // A young history is a plain mean: the average would take 30 frames to forget the first one.
        let weight = self.weight.max(1.0 / (count as f32 + 1.0));
        Image::par_from_fn(width, height, |x, y| {
            let new = Vec4::from(current.colour[(x, y)]);
            let transparent = current.transparent[(x, y)];
            let motion = Vec2::from(current.motion[(x, y)]);
            // Only where the pattern shows: opaque surfaces would smear for nothing.
            let at = [left + x, top + y];
            let motion = if transparent { reprojection.aligned(motion, at) } else { motion };
            let Some(place) = Place::inside(reprojection.region, UVec2::from(at).as_vec2() + motion) else {
                return new.to_array();
            };
            let old = place.around(history).sharp(|&rgba| rgba.into());
            let radius = if transparent { self.radius.into() } else { OPAQUE_RADIUS };
            let clipped = self.clip(old, &ycocga, [x, y], radius, reprojection.alignment.rule);
            (clipped + (new - clipped) * weight).to_array()
        })
    }

    /// Pulls history into the ellipsoid of the neighbourhood, along the line to its mean: colour and alpha
    /// together, so that neither leaves the other behind. With [`AlignmentRule::DeadZone`] into the box
    /// around the ellipsoid, each channel by itself.
    fn clip(
        self,
        old: Vec4,
        ycocga: &Image<Vec4>,
        [x, y]: [u32; 2],
        radius: i64,
        rule: AlignmentRule,
    ) -> Vec4 {
        let (mut sum, mut squares) = (Vec4::ZERO, Vec4::ZERO);
        for dy in -radius..=radius {
            for dx in -radius..=radius {
                let neighbour = *ycocga.get_clamped(i64::from(x) + dx, i64::from(y) + dy);
                sum += neighbour;
                squares += neighbour * neighbour;
            }
        }
        let count = ((2 * radius + 1) * (2 * radius + 1)) as f32;
        let mean = sum / count;
        let deviation = (squares / count - mean * mean).max(Vec4::ZERO).map(f32::sqrt) * self.sigmas;
        let offset = ycocga_from_rgba(old.to_array()) - mean;
        if rule == AlignmentRule::DeadZone {
            return rgba_from_ycocga(mean + offset.clamp(-deviation, deviation)).into();
        }
        // Length of the offset in standard deviations; an even neighbourhood leaves no room.
        let reach = (offset / deviation.max(Vec4::splat(LEAST_DEVIATION))).length();
        if reach <= 1.0 {
            return old;
        }
        rgba_from_ycocga(mean + offset / reach).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::Alignment;

    fn still(size: [u32; 2]) -> Reprojection {
        let region = Region::whole(size);
        Reprojection { alignment: Alignment::NONE, size, region, frame: 0, seed: 0 }
    }

    fn planes(width: u32, height: u32, colour: impl Fn(u32, u32) -> f32) -> Planes {
        let mut planes = Planes::new(width, height).unwrap();
        planes.colour = Image::from_fn(width, height, |x, y| [colour(x, y); 4]).unwrap();
        planes
    }

    #[test]
    fn an_even_neighbourhood_forgets_wrong_history_at_once() {
        let current = planes(8, 8, |_, _| 0.25);
        let history = Image::filled(8, 8, [1.0; 4]).unwrap();
        let result = Taa::DEFAULT.averaged(&current, &history, 100, still([8; 2])).unwrap();
        assert!((result[(4, 4)][0] - 0.25).abs() < 1e-4);
    }

    #[test]
    fn plausible_history_keeps_nine_tenths() {
        let current = planes(9, 9, |x, y| ((x + y) % 2) as f32);
        let history = Image::filled(9, 9, [0.5; 4]).unwrap();
        let result = Taa::DEFAULT.averaged(&current, &history, 100, still([9; 2])).unwrap();
        assert!((result[(4, 4)][0] - 0.45).abs() < 1e-5, "{:?}", result[(4, 4)]);
    }

    #[test]
    fn the_box_clips_each_channel_by_itself() {
        // Luma varies and chroma does not: a tint of the history takes all of it to the mean of the
        // ellipsoid, in the box the tint alone.
        let current = planes(9, 9, |x, y| ((x + y) % 2) as f32);
        let alignment = Alignment { side_px: 3, rule: AlignmentRule::DeadZone };
        let clipped = |old: [f32; 4]| {
            let history = Image::filled(9, 9, old).unwrap();
            [still([9; 2]), Reprojection { alignment, ..still([9; 2]) }].map(|reprojection| {
                Vec4::from(Taa::DEFAULT.averaged(&current, &history, 100, reprojection).unwrap()[(4, 4)])
            })
        };
        let [ellipsoid, boxed] = clipped([0.6, 0.6, 0.6, 0.5]);
        assert!((ellipsoid - boxed).abs().max_element() < 1e-5, "{ellipsoid} {boxed}");
        let [ellipsoid, boxed] = clipped([0.8, 0.85, 0.8, 0.5]);
        assert!((boxed.y - 0.9 * 0.825).abs() < 1e-4 && (boxed.x - boxed.y).abs() < 1e-4, "{boxed}");
        assert!((ellipsoid.y - 0.9 * 4.0 / 9.0).abs() < 1e-3, "{ellipsoid}");
    }

    #[test]
    fn what_has_gone_takes_its_opacity_with_it() {
        // A red card of opacity 0.5 was here; nothing is now.
        let mut current = planes(9, 9, |_, _| 0.0);
        let history = Image::filled(9, 9, [0.3, 0.0, 0.0, 0.5]).unwrap();
        let result = Taa::DEFAULT.averaged(&current, &history, 100, still([9; 2])).unwrap();
        assert!(Vec4::from(result[(4, 4)]).abs().max_element() < 1e-4, "{:?}", result[(4, 4)]);
        // At its edge colour and opacity go together.
        current.colour =
            Image::from_fn(9, 9, |x, _| if x < 5 { [0.0; 4] } else { [0.3, 0.0, 0.0, 0.5] }).unwrap();
        let result = Taa::DEFAULT.averaged(&current, &history, 100, still([9; 2])).unwrap();
        for pixel in result.as_slice() {
            assert!((pixel[0] - 0.6 * pixel[3]).abs() < 1e-5, "{pixel:?}");
        }
    }

    #[test]
    fn history_follows_motion_and_stops_at_the_edge() {
        let mut current = planes(8, 8, |x, _| x as f32);
        current.motion = Image::filled(8, 8, [-2.0, 0.0]).unwrap();
        current.transparent = Image::filled(8, 8, true).unwrap();
        let history = Image::from_fn(8, 8, |x, _| [x as f32 + 2.0; 4]).unwrap();
        let result = Taa::DEFAULT.averaged(&current, &history, 100, still([8; 2])).unwrap();
        assert!((result[(4, 4)][0] - 4.0).abs() < 1e-4, "what was at 2 is now at 4");
        assert_eq!(result[(1, 4)][0], 1.0, "nothing was seen beyond the edge");
    }
}
