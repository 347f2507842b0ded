//! How much of what has gone is still to be seen: the error where surfaces came into view.
//!
//! Temporal anti-aliasing fetches what a surface looked like where it was before. Of a surface that something
//! hid a moment ago there is no history: what is fetched there is the occluder's, and unless it is rejected
//! the occluder trails a ghost. So ghosting is an error of the pixels that were *uncovered* lately. Its sign
//! says of which kind: above 0 the ghosts are brighter than what they cover.

use std::collections::VecDeque;

use rayon::prelude::*;
use sheer_image::{Image, Planes};

use crate::MetricError;
use crate::error::check_sizes;

/// Frames for which an uncovered pixel counts as one. A history that gives each new frame a weight of 0.1
/// keeps 0.43 of a ghost after as many; later it fades into what noise hides.
const FRAMES: usize = 8;
/// Share of its depth by which a part of the same instance has to be nearer to hide another one. An arm
/// before its body is; a floor seen at a grazing angle is not, from one pixel to the next.
const NEARER: f32 = 0.05;
/// Nearer than this to the centre of a pixel, pixels, a point lies in it and in no other: rounding of motion
/// vectors.
const AT_CENTRE_PX: f32 = 1.0 / 64.0;

/// The surfaces of a frame, one a pixel.
#[derive(Clone, Debug)]
struct Surfaces {
    depth: Image<f32>,
    motion: Image<[f32; 2]>,
    instance: Image<u32>,
}

impl Surfaces {
    /// Whether the surface of a pixel is so much nearer than another of the same instance that it hides it.
    fn is_before(&self, pixel: (u32, u32), depth: f32) -> bool {
        self.depth[pixel] < depth * (1.0 - NEARER)
    }
}

/// Takes the surfaces of a clip frame by frame and tells which pixels were uncovered lately.
///
/// A pixel is uncovered if its surface was hidden in one of the 8 frames before. Its motion vectors say where
/// the surface was, from frame to frame; it was hidden there if all pixels around that point (one, two or
/// four: those that bilinear filtering would blend) show something nearer, another instance or a part of the
/// same one. Where one of them shows the surface itself, it was visible, and is followed on from there. One
/// that was not there yet, or outside the picture, was not hidden.
///
/// On the visible side of a straight edge one of the pixels around a point lies on that side, too: edges that
/// merely move with the camera uncover nothing. What came into view between two pixels of a moving surface is
/// missed for that.
///
/// A pixel beside something nearer does not count, as it may hold a part of that: a picture of one sample a
/// pixel, which has no ghosts, would have an error of one sign there.
///
/// The planes hold one surface a pixel, the nearest by whoever makes them: what was uncovered behind a pane
/// does not count.
#[derive(Clone, Debug, Default)]
pub struct Uncovering {
    /// The last frame first.
    earlier: VecDeque<Surfaces>,
}

impl Uncovering {
    /// Frames that have to be [added](Self::add) before the first that is to be judged.
    pub const FRAMES: usize = FRAMES;

    /// A clip without frames.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next frame, sampled at pixel centres, and tells which of its pixels were uncovered.
    ///
    /// # Errors
    /// [`MetricError::SizesDiffer`] if this frame and the last differ in size; [`MetricError::Image`] if
    /// memory does not suffice.
    pub fn add(&mut self, planes: &Planes) -> Result<Image<bool>, MetricError> {
        if let Some(last) = self.earlier.front() {
            check_sizes(&last.depth, &planes.depth)?;
        }
        let now = Surfaces {
            depth: planes.depth.clone(),
            motion: planes.motion.clone(),
            instance: planes.instance.clone(),
        };
        let (width, height) = now.depth.size();
        let uncovered = Image::par_from_fn(width, height, |x, y| {
            self.was_hidden(&now, (x, y)) && !is_beside_nearer(&now, (x, y))
        })?;
        self.earlier.truncate(FRAMES - 1);
        self.earlier.push_front(now);
        Ok(uncovered)
    }

    /// Whether the surface of a pixel was hidden in one of the earlier frames.
    fn was_hidden(&self, now: &Surfaces, pixel: (u32, u32)) -> bool {
        let (mut frame, mut pixel) = (now, pixel);
        let mut point = [pixel.0, pixel.1].map(|coordinate| coordinate as f32 + 0.5);
        for earlier in &self.earlier {
            let motion = frame.motion[pixel];
            point = [point[0] + motion[0], point[1] + motion[1]];
            let (instance, depth) = (frame.instance[pixel], frame.depth[pixel]);
            let around = around(point, earlier.depth.size());
            let is_same =
                |at: &(u32, u32)| earlier.instance[*at] == instance && !earlier.is_before(*at, depth);
            // Of several parts of the instance the one that has moved least along the view.
            let change = |at: &(u32, u32)| match (earlier.depth[*at] - depth).abs() {
                change if change.is_nan() => 0.0, // Both are infinitely far.
                change => change,
            };
            let seen = around.clone().filter(is_same).min_by(|a, b| change(a).total_cmp(&change(b)));
            let Some(seen) = seen else {
                let mut around = around.peekable();
                return around.peek().is_some() && around.all(|at| earlier.depth[at] < depth);
            };
            (frame, pixel) = (earlier, seen);
        }
        false
    }
}

/// Whether one of the eight pixels around shows something nearer, another instance or a part of the same one.
fn is_beside_nearer(now: &Surfaces, (x, y): (u32, u32)) -> bool {
    let (width, height) = now.depth.size();
    let (instance, depth) = (now.instance[(x, y)], now.depth[(x, y)]);
    let span = |at: u32, side: u32| at.saturating_sub(1)..(at + 2).min(side);
    span(y, height)
        .flat_map(|y| span(x, width).map(move |x| (x, y)))
        .any(|at| if now.instance[at] == instance { now.is_before(at, depth) } else { now.depth[at] < depth })
}

/// The pixels of a picture whose centres are next to a point; none if the point lies outside.
fn around(point: [f32; 2], (width, height): (u32, u32)) -> impl Iterator<Item = (u32, u32)> + Clone {
    let span = |coordinate: f32, side: u32| {
        let is_inside = (0.0..side as f32).contains(&coordinate);
        let first = (coordinate - 0.5 + AT_CENTRE_PX).floor();
        let last = (coordinate - 0.5 - AT_CENTRE_PX).ceil();
        let [first, last] = [first, last].map(|at| at.clamp(0.0, side as f32 - 1.0) as u32);
        if is_inside { first.min(last)..first.max(last) + 1 } else { 0..0 }
    };
    let columns = span(point[0], width);
    span(point[1], height).flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

/// Takes a clip in linear light frame by frame and tells its ghosting: the mean of image minus reference over
/// all uncovered pixels of all frames, and over channels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ghosting<const N: usize> {
    sum: f64,
    pixel_count: u64,
}

impl<const N: usize> Ghosting<N> {
    /// A clip without frames.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next frame and which of its pixels were uncovered ([`Uncovering`]).
    ///
    /// # Errors
    /// [`MetricError::SizesDiffer`].
    pub fn add(
        &mut self,
        reference: &Image<[f32; N]>,
        image: &Image<[f32; N]>,
        uncovered: &Image<bool>,
    ) -> Result<(), MetricError> {
        check_sizes(reference, image)?;
        check_sizes(reference, uncovered)?;
        let rows = reference.par_rows().zip(image.par_rows()).zip(uncovered.par_rows());
        let of_rows: Vec<(f64, u64)> = rows
            .map(|((references, values), uncovered)| {
                let pixels = references.iter().zip(values).zip(uncovered);
                let pixels = pixels.filter(|(_, uncovered)| **uncovered);
                pixels.fold((0.0, 0), |(sum, count), ((reference, value), _)| {
                    let errors = value.iter().zip(reference);
                    let error: f64 =
                        errors.map(|(value, reference)| f64::from(*value) - f64::from(*reference)).sum();
                    (sum + error, count + 1)
                })
            })
            .collect();
        self.sum += of_rows.iter().map(|(sum, _)| sum).sum::<f64>();
        self.pixel_count += of_rows.iter().map(|(_, count)| count).sum::<u64>();
        Ok(())
    }

    /// The ghosting of the frames so far; none where nothing was uncovered.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        (self.pixel_count > 0).then(|| self.sum / (self.pixel_count as f64 * N as f64))
    }
}

#[cfg(test)]
mod tests {
    use sheer_image::Pixel;

    use super::*;

    const SIZE: (u32, u32) = (48, 4);
    const WALL: u32 = 1;
    const CARD: u32 = 2;
    /// Of the card, in pixels a frame.
    const SPEED_PX: u32 = 2;
    const CARD_PX: u32 = 6;

    fn planes(pixel: impl Fn(u32) -> Pixel + Sync) -> Planes {
        let mut planes = Planes::new(SIZE.0, SIZE.1).unwrap();
        planes.par_bands_mut(1).for_each(|mut band| {
            (0..SIZE.0).for_each(|x| band.set(x, 0, pixel(x)));
        });
        planes
    }

    fn surface(instance: u32, depth: f32, motion_x: f32) -> Pixel {
        Pixel { instance, depth, motion: [motion_x, 0.0], ..Pixel::EMPTY }
    }

    /// A card goes right before a wall that stands; or behind, or with it as one instance.
    fn with_card(frame: u32, depth: f32, instance: u32) -> Planes {
        let left = frame * SPEED_PX;
        planes(|x| match (left..left + CARD_PX).contains(&x) {
            true => surface(instance, depth, -(SPEED_PX as f32)),
            false => surface(WALL, 10.0, 0.0),
        })
    }

    /// Columns that were uncovered in the last of these frames; they are in all rows or none.
    fn columns(frames: impl IntoIterator<Item = Planes>) -> Vec<u32> {
        let mut uncovering = Uncovering::new();
        let mask = frames.into_iter().map(|planes| uncovering.add(&planes).unwrap()).last().unwrap();
        let columns = (0..SIZE.0).filter(|&x| mask[(x, 0)]).collect();
        assert!((1..SIZE.1).all(|y| (0..SIZE.0).all(|x| mask[(x, y)] == mask[(x, 0)])));
        columns
    }

    #[test]
    fn a_card_uncovers_what_it_left_in_eight_frames() {
        let strip = |frames| columns((0..frames).map(|frame| with_card(frame, 5.0, CARD)));
        assert_eq!(strip(1), [0; 0]);
        // The column beside the card may hold a part of it.
        assert_eq!(strip(4), (0..5).collect::<Vec<_>>());
        // At 26 in the last frame, at 10 eight frames before.
        assert_eq!(strip(14), (10..25).collect::<Vec<_>>());
        // The arm of a body, in front of it.
        assert_eq!(columns((0..14).map(|frame| with_card(frame, 5.0, WALL))), (10..25).collect::<Vec<_>>());
    }

    #[test]
    fn what_appears_or_stands_or_moves_with_the_camera_is_not_uncovered() {
        let none = [0; 0];
        assert_eq!(columns((0..14).map(|_| with_card(6, 5.0, CARD))), none, "it stands but for its vectors");
        // Suddenly there, as a particle.
        let appearing = (0..10).map(|frame| match frame {
            9 => with_card(0, 5.0, CARD),
            _ => planes(|_| surface(WALL, 10.0, 0.0)),
        });
        assert_eq!(columns(appearing), none);
        // All moves alike, by parts of a pixel: the edge between near and far is at 24.3 less 0.3 a frame.
        let panned = |frame: u32| {
            let edge = 24.3 - 0.3 * frame as f32;
            planes(move |x| match x as f32 + 0.5 < edge {
                true => surface(CARD, 5.0, 0.3),
                false => surface(WALL, 10.0, 0.3),
            })
        };
        assert_eq!(columns((0..14).map(panned)), none);
        // The sky, too, where nothing moves before it.
        assert_eq!(columns((0..4).map(|_| planes(|_| Pixel::EMPTY))), none);
    }

    #[test]
    fn ghosting_is_the_error_of_the_trail_alone() {
        let mut uncovering = Uncovering::new();
        let (mut trailing, mut clean) = (Ghosting::new(), Ghosting::new());
        let reference = Image::filled(SIZE.0, SIZE.1, [0.5; 3]).unwrap();
        for frame in 0..14 {
            let mask = uncovering.add(&with_card(frame, 5.0, CARD)).unwrap();
            let left = frame * SPEED_PX;
            // Behind the card its light is left in two of three channels; before it all is off.
            let trail = Image::from_fn(SIZE.0, SIZE.1, |x, _| match x {
                x if x < left => [0.75, 0.75, 0.5],
                _ => [0.0; 3],
            });
            let elsewhere = Image::from_fn(SIZE.0, SIZE.1, |x, _| [if x < left { 0.5 } else { 0.0 }; 3]);
            trailing.add(&reference, &trail.unwrap(), &mask).unwrap();
            clean.add(&reference, &elsewhere.unwrap(), &mask).unwrap();
        }
        assert_eq!(trailing.value(), Some(0.5 / 3.0));
        assert_eq!(clean.value(), Some(0.0));
        assert_eq!(Ghosting::<3>::new().value(), None);
    }

    #[test]
    fn other_sizes_are_refused() {
        let mut uncovering = Uncovering::new();
        uncovering.add(&Planes::new(4, 4).unwrap()).unwrap();
        assert!(matches!(uncovering.add(&Planes::new(5, 4).unwrap()), Err(MetricError::SizesDiffer { .. })));
        let image = Image::filled(4, 4, [0.0]).unwrap();
        let mask = Image::filled(5, 4, true).unwrap();
        assert!(matches!(Ghosting::new().add(&image, &image, &mask), Err(MetricError::SizesDiffer { .. })));
    }
}
