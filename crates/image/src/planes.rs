//! What a rendered frame carries.

use rayon::prelude::*;

use crate::{Image, ImageError};

/// Everything a renderer knows about one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Linear RGBA, premultiplied.
    pub colour: [f32; 4],
    /// Distance along the view axis in scene units, infinite where nothing is.
    pub depth: f32,
    /// Motion in pixels from this frame to the last: where the surface was, minus where it is.
    pub motion: [f32; 2],
    /// Instance of the surface, [`Planes::NO_ID`] where nothing is.
    pub instance: u32,
    /// Primitive of the surface, [`Planes::NO_ID`] where nothing is.
    pub primitive: u32,
    /// Whether a transparent fragment takes part in the pixel.
    pub transparent: bool,
}

impl Pixel {
    /// A pixel that sees nothing.
    pub const EMPTY: Self = Self {
        colour: [0.0; 4],
        depth: f32::INFINITY,
        motion: [0.0; 2],
        instance: Planes::NO_ID,
        primitive: Planes::NO_ID,
        transparent: false,
    };
}

/// What a rendered frame carries: six images of the same size, one for each field of [`Pixel`].
#[derive(Clone, Debug, PartialEq)]
pub struct Planes {
    /// Linear RGBA, premultiplied.
    pub colour: Image<[f32; 4]>,
    /// Distance along the view axis in scene units, infinite where nothing is.
    pub depth: Image<f32>,
    /// Motion in pixels from this frame to the last: where the surface was, minus where it is.
    pub motion: Image<[f32; 2]>,
    /// Instance of the surface, [`Planes::NO_ID`] where nothing is.
    pub instance: Image<u32>,
    /// Primitive of the surface, [`Planes::NO_ID`] where nothing is.
    pub primitive: Image<u32>,
    /// Whether a transparent fragment takes part in the pixel.
    pub transparent: Image<bool>,
}

/// A few neighbouring rows of all planes, for writing.
#[derive(Debug)]
pub struct Band<'a> {
    /// The first of the rows.
    pub y: u32,
    /// Pixels in a row.
    pub width: u32,
    /// The rows of [`Planes::colour`].
    pub colour: &'a mut [[f32; 4]],
    /// The rows of [`Planes::depth`].
    pub depth: &'a mut [f32],
    /// The rows of [`Planes::motion`].
    pub motion: &'a mut [[f32; 2]],
    /// The rows of [`Planes::instance`].
    pub instance: &'a mut [u32],
    /// The rows of [`Planes::primitive`].
    pub primitive: &'a mut [u32],
    /// The rows of [`Planes::transparent`].
    pub transparent: &'a mut [bool],
}

impl Band<'_> {
    /// Rows in this band: the last one of a frame may have fewer than the others.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.depth.len() as u32 / self.width
    }

    /// Writes the pixel in column `x` of row `row` of this band.
    ///
    /// # Panics
    /// If the pixel lies outside the band.
    pub fn set(&mut self, x: u32, row: u32, pixel: Pixel) {
        assert!(x < self.width, "column {x} lies outside {} columns", self.width);
        let at = row as usize * self.width as usize + x as usize;
        self.colour[at] = pixel.colour;
        self.depth[at] = pixel.depth;
        self.motion[at] = pixel.motion;
        self.instance[at] = pixel.instance;
        self.primitive[at] = pixel.primitive;
        self.transparent[at] = pixel.transparent;
    }
}

impl Planes {
    /// The instance and primitive of a pixel that sees nothing.
    pub const NO_ID: u32 = u32::MAX;

    /// A frame that sees nothing.
    ///
    /// # Errors
    /// [`ImageError::Size`] if a side is zero or memory does not suffice.
    pub fn new(width: u32, height: u32) -> Result<Self, ImageError> {
        Ok(Self {
            colour: Image::filled(width, height, Pixel::EMPTY.colour)?,
            depth: Image::filled(width, height, Pixel::EMPTY.depth)?,
            motion: Image::filled(width, height, Pixel::EMPTY.motion)?,
            instance: Image::filled(width, height, Pixel::EMPTY.instance)?,
            primitive: Image::filled(width, height, Pixel::EMPTY.primitive)?,
            transparent: Image::filled(width, height, Pixel::EMPTY.transparent)?,
        })
    }

    /// Width of all planes, pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.colour.width()
    }

    /// Height of all planes, pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.colour.height()
    }

    /// The pixel in column `x` and row `y` of all planes.
    ///
    /// # Panics
    /// If the pixel lies outside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Pixel {
        Pixel {
            colour: self.colour[(x, y)],
            depth: self.depth[(x, y)],
            motion: self.motion[(x, y)],
            instance: self.instance[(x, y)],
            primitive: self.primitive[(x, y)],
            transparent: self.transparent[(x, y)],
        }
    }

    /// Cuts the frame into bands of `rows` rows (at least 1), top first, to be written in parallel.
    pub fn par_bands_mut(&mut self, rows: u32) -> impl IndexedParallelIterator<Item = Band<'_>> {
        let width = self.width();
        let rows = rows.max(1);
        let pixels = width as usize * rows as usize;
        self.colour
            .as_mut_slice()
            .par_chunks_mut(pixels)
            .zip(self.depth.as_mut_slice().par_chunks_mut(pixels))
            .zip(self.motion.as_mut_slice().par_chunks_mut(pixels))
            .zip(self.instance.as_mut_slice().par_chunks_mut(pixels))
            .zip(self.primitive.as_mut_slice().par_chunks_mut(pixels))
            .zip(self.transparent.as_mut_slice().par_chunks_mut(pixels))
            .enumerate()
            .map(move |(band, (((((colour, depth), motion), instance), primitive), transparent))| Band {
                y: band as u32 * rows,
                width,
                colour,
                depth,
                motion,
                instance,
                primitive,
                transparent,
            })
    }

    /// Checks that no plane was replaced by one of another size.
    ///
    /// # Errors
    /// [`ImageError::SizesDiffer`] naming the plane.
    pub fn check_sizes(&self) -> Result<(), ImageError> {
        let first = self.colour.size();
        let others = [
            ("colour and depth plane", self.depth.size()),
            ("colour and motion plane", self.motion.size()),
            ("colour and instance plane", self.instance.size()),
            ("colour and primitive plane", self.primitive.size()),
            ("colour and transparent plane", self.transparent.size()),
        ];
        match others.into_iter().find(|&(_, second)| second != first) {
            Some((what, second)) => Err(ImageError::SizesDiffer { what, first, second }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_cover_every_pixel_once_and_know_their_place() {
        let mut planes = Planes::new(5, 7).unwrap();
        planes.par_bands_mut(3).for_each(|mut band| {
            for row in 0..band.height() {
                for x in 0..band.width {
                    let id = (band.y + row) * 5 + x;
                    assert_eq!(band.instance[(row * 5 + x) as usize], Planes::NO_ID, "a pixel came up twice");
                    band.set(x, row, Pixel { instance: id, depth: id as f32, ..Pixel::EMPTY });
                }
            }
        });
        let in_order: Vec<u32> = (0..35).collect();
        assert_eq!(planes.instance.as_slice(), in_order);
        assert_eq!(planes.pixel(4, 6), Pixel { instance: 34, depth: 34.0, ..Pixel::EMPTY });
    }

    #[test]
    fn a_plane_of_another_size_is_named() {
        let mut planes = Planes::new(4, 4).unwrap();
        assert!(planes.check_sizes().is_ok());
        planes.motion = Image::filled(4, 3, [0.0; 2]).unwrap();
        let message = planes.check_sizes().unwrap_err().to_string();
        assert!(message.contains("motion") && message.contains("4x3"), "{message}");
    }
}
