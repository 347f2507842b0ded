//! Whether two pictures show the same fragments: how a renderer is held against another that draws the same
//! random numbers.
//!
//! Both decide alike wherever they find the same hits, so they differ where they do not: at the edges of
//! triangles, which only who knows the geometry can tell.

use sheer_image::Planes;

use crate::{MetricError, error::check_sizes};

/// How two pictures of one frame differ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FragmentDifference {
    /// How many pixels a picture has.
    pub pixels: usize,
    /// Columns and rows of the pixels that show another fragment.
    pub others: Vec<(u32, u32)>,
    /// How many pixels show the same fragment in a colour that differs by more than the bound.
    pub colours: usize,
    /// The largest difference of colours among all further ones.
    pub worst: f32,
}

impl FragmentDifference {
    /// Compares instance, primitive and linear premultiplied colour. `colour_bound`: by how much a channel
    /// may differ, as a share of the larger of both values or, below that, of a display's white.
    ///
    /// # Errors
    /// [`MetricError::SizesDiffer`].
    pub fn measure(reference: &Planes, image: &Planes, colour_bound: f32) -> Result<Self, MetricError> {
        check_sizes(&reference.colour, &image.colour)?;
        let (width, height) = reference.colour.size();
        let mut difference = Self { pixels: reference.colour.as_slice().len(), ..Self::default() };
        for at in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            if fragment(reference, at) != fragment(image, at) {
                difference.others.push(at);
                continue;
            }
            let (expected, found) = (reference.colour[at], image.colour[at]);
            let channels: [f32; 4] = std::array::from_fn(|c| {
                let (a, b) = (expected[c], found[c]);
                (a - b).abs() / a.abs().max(b.abs()).max(1.0)
            });
            // What is no number is within no bound.
            if channels.iter().all(|&channel| channel <= colour_bound) {
                difference.worst = channels.into_iter().fold(difference.worst, f32::max);
            } else {
                difference.colours += 1;
            }
        }
        Ok(difference)
    }

    /// Share of pixels that show another fragment, 0 to 1.
    #[must_use]
    pub fn other_share(&self) -> f64 {
        self.others.len() as f64 / self.pixels as f64
    }

    /// Share of pixels that show the same fragment in another colour, 0 to 1.
    #[must_use]
    pub fn colour_share(&self) -> f64 {
        self.colours as f64 / self.pixels as f64
    }
}

fn fragment(planes: &Planes, at: (u32, u32)) -> [u32; 2] {
    [planes.instance[at], planes.primitive[at]]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUND: f32 = 0.01;

    fn picture() -> Planes {
        let mut planes = Planes::new(8, 6).unwrap();
        for at in (0..6).flat_map(|y| (0..8).map(move |x| (x, y))) {
            planes.instance[at] = 0;
            planes.colour[at] = [0.25, 0.5, 3.0, 1.0];
        }
        planes
    }

    fn difference(change: impl FnOnce(&mut Planes)) -> FragmentDifference {
        let mut image = picture();
        change(&mut image);
        FragmentDifference::measure(&picture(), &image, BOUND).unwrap()
    }

    #[test]
    fn equal_pictures_do_not_differ() {
        assert_eq!(difference(|_| ()), FragmentDifference { pixels: 48, ..FragmentDifference::default() });
    }

    #[test]
    fn other_fragments_are_found_whatever_their_colour() {
        let primitive = difference(|image| image.primitive[(3, 2)] = 1);
        assert_eq!((primitive.others.as_slice(), primitive.colours), (&[(3, 2)][..], 0));
        assert!((primitive.other_share() - 1.0 / 48.0).abs() < 1e-12);
        let instance = difference(|image| {
            image.instance[(7, 5)] = 2;
            image.colour[(7, 5)] = [0.0; 4];
        });
        assert_eq!((instance.others.as_slice(), instance.colours), (&[(7, 5)][..], 0));
    }

    #[test]
    fn colours_count_beyond_the_bound_and_what_is_no_number_always() {
        let within = difference(|image| image.colour[(0, 0)][2] = 3.02);
        assert_eq!(within.colours, 0);
        assert!((within.worst - 0.02 / 3.02).abs() < 1e-5, "{within:?}");
        for value in [3.1, f32::NAN, f32::INFINITY] {
            let beyond = difference(|image| image.colour[(0, 0)][2] = value);
            assert_eq!((beyond.colours, beyond.worst), (1, 0.0), "{value}");
            assert!((beyond.colour_share() - 1.0 / 48.0).abs() < 1e-12);
        }
    }

    #[test]
    fn pictures_of_other_sizes_are_refused() {
        let small = Planes::new(4, 6).unwrap();
        assert!(FragmentDifference::measure(&picture(), &small, BOUND).is_err());
    }
}
