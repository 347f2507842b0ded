//! Temporal anti-aliasing after Salvi, *An Excursion in Temporal Supersampling*, GDC 2016: an exponential
//! average of reprojected history, rectified by the mean and variance of the new frame's neighbourhood (STD
//! section 2.1, Eq. 2).

use glam::{Vec2, Vec3, Vec3A, Vec4};
use sheer_core::{bibliography, parameter::Values};
use sheer_image::{Image, ImageError, Planes};

use super::{
    align::Reprojection,
    jitter::halton,
    technique::{AntialiasingInfo, Technique},
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
    parameters: &[],
    constants: &[
        ShaderConstant::real("NEW_FRAME_WEIGHT", NEW_FRAME_WEIGHT),
        ShaderConstant::real("CLIP_SIGMAS", CLIP_SIGMAS),
        ShaderConstant::real("LEAST_DEVIATION", LEAST_DEVIATION),
        ShaderConstant::real("DEAD_ZONE", AlignmentRule::DEAD_ZONE),
        // Signed as here: they are loop bounds on both sides of zero.
        ShaderConstant { name: "OPAQUE_RADIUS", value: ShaderValue::I32(OPAQUE_RADIUS as i32) },
        ShaderConstant { name: "TRANSPARENT_RADIUS", value: ShaderValue::I32(TRANSPARENT_RADIUS as i32) },
    ],
};

/// Samples before the jitter repeats: an exponential average of weight 0.1 forgets in about as many, and 16
/// is coprime to the 9 frames of the STD walk, so that every threshold meets every offset.
const JITTER_PERIOD: u32 = 16;

/// Weight of the new frame (STD Eq. 2).
const NEW_FRAME_WEIGHT: f32 = 0.1;
/// History is kept within this many standard deviations of the neighbourhood's mean.
const CLIP_SIGMAS: f32 = 1.0;
/// Radius of the neighbourhood of an opaque surface, pixels: 3×3.
const OPAQUE_RADIUS: i64 = 1;
/// Radius of the neighbourhood where transparent fragments are, pixels: 7×7 (STD section 3.2).
const TRANSPARENT_RADIUS: i64 = 3;

/// An even neighbourhood has no deviation to divide by: this one instead.
const LEAST_DEVIATION: f32 = 1e-6;

/// Temporal anti-aliasing with the constants of STD.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taa;

impl Taa {
    pub(super) fn new(_: &Values) -> Self {
        Self
    }
}

impl Technique for Taa {
    fn jitter(&self, frame: u32) -> Vec2 {
        halton(frame % JITTER_PERIOD + 1)
    }

    fn resolve(
        &self,
        history: &Planes,
        current: &mut Planes,
        count: u32,
        reprojection: Reprojection,
    ) -> Result<(), ImageError> {
        current.colour = resolve(current, &history.colour, count, reprojection)?;
        Ok(())
    }

    fn values(&self) -> Vec<String> {
        Vec::new()
    }
}

/// The new history: `current` blended with `history`, the result of `count` earlier frames.
fn resolve(
    current: &Planes,
    history: &Image<[f32; 4]>,
    count: u32,
    reprojection: Reprojection,
) -> Result<Image<[f32; 4]>, ImageError> {
    let (width, height) = current.colour.size();
    let ycocg = current.colour.par_map(|[r, g, b, _]| ycocg_from_rgb(Vec3A::new(*r, *g, *b)));
    // A young history is a plain mean: the average would take 30 frames to forget the first one.
    let weight = NEW_FRAME_WEIGHT.max(1.0 / (count as f32 + 1.0));
    Image::par_from_fn(width, height, |x, y| {
        let new = Vec4::from(current.colour[(x, y)]);
        let transparent = current.transparent[(x, y)];
        let motion = Vec2::from(current.motion[(x, y)]);
        // Only where the pattern shows: opaque surfaces would smear for nothing.
        let motion = if transparent { reprojection.aligned(motion, [x, y]) } else { motion };
        let Some(old) = fetch(history, Vec2::new(x as f32, y as f32) + motion) else {
            return new.to_array();
        };
        let radius = if transparent { TRANSPARENT_RADIUS } else { OPAQUE_RADIUS };
        let clipped = clip(old, &ycocg, [x, y], radius, reprojection.alignment.rule);
        (clipped + (new - clipped) * weight).to_array()
    })
}

/// Pulls history into the ellipsoid of the neighbourhood, along the line to its mean; alpha as it is. With
/// [`AlignmentRule::DeadZone`] into the box around the ellipsoid, each channel by itself.
fn clip(old: Vec4, ycocg: &Image<Vec3A>, [x, y]: [u32; 2], radius: i64, rule: AlignmentRule) -> Vec4 {
    let (mut sum, mut squares) = (Vec3A::ZERO, Vec3A::ZERO);
    for dy in -radius..=radius {
        for dx in -radius..=radius {
            let neighbour = *ycocg.get_clamped(i64::from(x) + dx, i64::from(y) + dy);
            sum += neighbour;
            squares += neighbour * neighbour;
        }
    }
    let count = ((2 * radius + 1) * (2 * radius + 1)) as f32;
    let mean = sum / count;
    let deviation = (squares / count - mean * mean).max(Vec3A::ZERO).map(f32::sqrt) * CLIP_SIGMAS;
    let offset = ycocg_from_rgb(Vec3A::from(old.truncate())) - mean;
    if rule == AlignmentRule::DeadZone {
        return Vec3::from(rgb_from_ycocg(mean + offset.clamp(-deviation, deviation))).extend(old.w);
    }
    // Length of the offset in standard deviations; an even neighbourhood leaves no room.
    let reach = (offset / deviation.max(Vec3A::splat(LEAST_DEVIATION))).length();
    if reach <= 1.0 {
        return old;
    }
    Vec3::from(rgb_from_ycocg(mean + offset / reach)).extend(old.w)
}

/// History at a point in pixels (origin at the first pixel's centre); `None` outside the picture.
fn fetch(history: &Image<[f32; 4]>, at: Vec2) -> Option<Vec4> {
    let (width, height) = history.size();
    let inside = at.x > -0.5 && at.y > -0.5 && at.x < width as f32 - 0.5 && at.y < height as f32 - 0.5;
    if !inside {
        return None;
    }
    let low = at.floor();
    let share = at - low;
    let (column, row) = (low.x as i64, low.y as i64);
    let texel = |dx: i64, dy: i64| Vec4::from(*history.get_clamped(column + dx, row + dy));
    if share == Vec2::ZERO {
        return Some(texel(0, 0));
    }
    // Catmull-Rom keeps edges that bilinear lookups would blur a little more in every frame.
    let (wx, wy) = (catmull_rom(share.x), catmull_rom(share.y));
    let mut sum = Vec4::ZERO;
    for (dy, wy) in (-1..).zip(wy) {
        for (dx, wx) in (-1..).zip(wx) {
            sum += texel(dx, dy) * (wx * wy);
        }
    }
    Some(sum.max(Vec4::ZERO))
}

/// Weights of the four samples around a point at `s` between the middle two.
fn catmull_rom(s: f32) -> [f32; 4] {
    let (s2, s3) = (s * s, s * s * s);
    [
        0.5 * (-s3 + 2.0 * s2 - s),
        0.5 * (3.0 * s3 - 5.0 * s2 + 2.0),
        0.5 * (-3.0 * s3 + 4.0 * s2 + s),
        0.5 * (s3 - s2),
    ]
}

fn ycocg_from_rgb(rgb: Vec3A) -> Vec3A {
    let Vec3 { x: r, y: g, z: b } = rgb.into();
    Vec3A::new(0.25 * r + 0.5 * g + 0.25 * b, 0.5 * (r - b), -0.25 * r + 0.5 * g - 0.25 * b)
}

fn rgb_from_ycocg(ycocg: Vec3A) -> Vec3A {
    let Vec3 { x: y, y: co, z: cg } = ycocg.into();
    Vec3A::new(y + co - cg, y + cg, y - co - cg)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::Alignment;

    const STILL: Reprojection = Reprojection { alignment: Alignment::NONE, size: [8, 8], frame: 0, seed: 0 };

    fn planes(width: u32, height: u32, colour: impl Fn(u32, u32) -> f32) -> Planes {
        let mut planes = Planes::new(width, height).unwrap();
        planes.colour = Image::from_fn(width, height, |x, y| [colour(x, y); 4]).unwrap();
        planes
    }

    #[test]
    fn ycocg_round_trips() {
        let rgb = Vec3A::new(0.2, 0.9, 3.0);
        assert!((rgb_from_ycocg(ycocg_from_rgb(rgb)) - rgb).abs().max_element() < 1e-6);
    }

    #[test]
    fn catmull_rom_weights_sum_to_one_and_interpolate() {
        for step in 0..=10 {
            assert!((catmull_rom(step as f32 / 10.0).iter().sum::<f32>() - 1.0).abs() < 1e-6);
        }
        assert_eq!(catmull_rom(0.0), [0.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn an_even_neighbourhood_forgets_wrong_history_at_once() {
        let current = planes(8, 8, |_, _| 0.25);
        let history = Image::filled(8, 8, [1.0; 4]).unwrap();
        let result = resolve(&current, &history, 100, STILL).unwrap();
        assert!((result[(4, 4)][0] - 0.25).abs() < 1e-4);
    }

    #[test]
    fn plausible_history_keeps_nine_tenths() {
        let current = planes(9, 9, |x, y| ((x + y) % 2) as f32);
        let history = Image::filled(9, 9, [0.5; 4]).unwrap();
        let result = resolve(&current, &history, 100, STILL).unwrap();
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
            [STILL, Reprojection { alignment, ..STILL }].map(|reprojection| {
                Vec4::from(resolve(&current, &history, 100, reprojection).unwrap()[(4, 4)])
            })
        };
        let [ellipsoid, boxed] = clipped([0.6, 0.6, 0.6, 1.0]);
        assert!((ellipsoid - boxed).abs().max_element() < 1e-5, "{ellipsoid} {boxed}");
        let [ellipsoid, boxed] = clipped([0.8, 0.85, 0.8, 1.0]);
        assert!((boxed.y - 0.9 * 0.825).abs() < 1e-4 && (boxed.x - boxed.y).abs() < 1e-4, "{boxed}");
        assert!((ellipsoid.y - 0.9 * 4.0 / 9.0).abs() < 1e-3, "{ellipsoid}");
    }

    #[test]
    fn history_follows_motion_and_stops_at_the_edge() {
        let mut current = planes(8, 8, |x, _| x as f32);
        current.motion = Image::filled(8, 8, [-2.0, 0.0]).unwrap();
        current.transparent = Image::filled(8, 8, true).unwrap();
        let history = Image::from_fn(8, 8, |x, _| [x as f32 + 2.0; 4]).unwrap();
        let result = resolve(&current, &history, 100, STILL).unwrap();
        assert!((result[(4, 4)][0] - 4.0).abs() < 1e-4, "what was at 2 is now at 4");
        assert_eq!(result[(1, 4)][0], 1.0, "nothing was seen beyond the edge");
    }
}
