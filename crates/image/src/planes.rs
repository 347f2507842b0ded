//! What a rendered frame carries.

use std::iter;

use rayon::prelude::*;

use crate::{Image, ImageError, Region};

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
    /// What lies before the nearest opaque surface, and that surface.
    pub layers: PixelLayers,
}

/// The two layers of a pixel, told apart at the nearest opaque surface on its ray: the *front*, everything
/// transparent before it, and the *back*, that surface or the background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelLayers {
    /// Share of the front in what is seen, `1 - Π (1 - alpha)` over its fragments, 0 to 1.
    pub coverage: f32,
    /// Shares of the red, green and blue of the back that coloured glass in the front absorbs, beyond what
    /// the coverage hides: `1 - coverage - absorbed` of each is seen. 0 without coloured glass. A sample of
    /// the back has not been filtered by it.
    pub absorbed: [f32; 3],
    /// Probability with which the shaded fragment was to be one of the front.
    pub share: f32,
    /// Whether it is one of the front.
    pub is_front: bool,
    /// Motion of the front as [`Pixel::motion`], of the point at the mean of its fragments by their shares of
    /// the pixel.
    pub front_motion: [f32; 2],
    /// Depth of that point as [`Pixel::depth`].
    pub front_depth: f32,
    /// Motion of the back as [`Pixel::motion`].
    pub back_motion: [f32; 2],
    /// Depth of the back as [`Pixel::depth`].
    pub back_depth: f32,
}

impl PixelLayers {
    /// No front before an infinitely distant back.
    pub const EMPTY: Self = Self {
        coverage: 0.0,
        absorbed: [0.0; 3],
        share: 0.0,
        is_front: false,
        front_motion: [0.0; 2],
        front_depth: f32::INFINITY,
        back_motion: [0.0; 2],
        back_depth: f32::INFINITY,
    };
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
        layers: PixelLayers::EMPTY,
    };
}

/// What a rendered frame carries: images of the same size, one for each field of [`Pixel`]; the layers where
/// they were asked for.
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
    /// What lies before the nearest opaque surface, and that surface.
    pub layers: Option<Image<PixelLayers>>,
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
    /// The rows of [`Planes::layers`].
    pub layers: Option<&'a mut [PixelLayers]>,
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
        if let Some(layers) = &mut self.layers {
            layers[at] = pixel.layers;
        }
    }
}

impl Planes {
    /// The instance and primitive of a pixel that sees nothing.
    pub const NO_ID: u32 = u32::MAX;

    /// A frame that sees nothing, without layers.
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
            layers: None,
        })
    }

    /// A frame that sees nothing, with layers.
    ///
    /// # Errors
    /// [`ImageError::Size`] if a side is zero or memory does not suffice.
    pub fn with_layers(width: u32, height: u32) -> Result<Self, ImageError> {
        let layers = Some(Image::filled(width, height, PixelLayers::EMPTY)?);
        Ok(Self { layers, ..Self::new(width, height)? })
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
            layers: self.layers.as_ref().map_or(PixelLayers::EMPTY, |layers| layers[(x, y)]),
        }
    }

    /// Cuts the frame into bands of `rows` rows (at least 1), top first, to be written in parallel.
    pub fn par_bands_mut(&mut self, rows: u32) -> impl IndexedParallelIterator<Item = Band<'_>> {
        let width = self.width();
        let rows = rows.max(1);
        let pixels = width as usize * rows as usize;
        let band_count = self.height().div_ceil(rows) as usize;
        let layers: Vec<_> = match &mut self.layers {
            Some(layers) => layers.as_mut_slice().chunks_mut(pixels).map(Some).collect(),
            None => iter::repeat_with(|| None).take(band_count).collect(),
        };
        self.colour
            .as_mut_slice()
            .par_chunks_mut(pixels)
            .zip(self.depth.as_mut_slice().par_chunks_mut(pixels))
            .zip(self.motion.as_mut_slice().par_chunks_mut(pixels))
            .zip(self.instance.as_mut_slice().par_chunks_mut(pixels))
            .zip(self.primitive.as_mut_slice().par_chunks_mut(pixels))
            .zip(self.transparent.as_mut_slice().par_chunks_mut(pixels))
            .zip(layers)
            .enumerate()
            .map(
                move |(band, ((((((colour, depth), motion), instance), primitive), transparent), layers))| {
                    Band {
                        y: band as u32 * rows,
                        width,
                        colour,
                        depth,
                        motion,
                        instance,
                        primitive,
                        transparent,
                        layers,
                    }
                },
            )
    }

    /// A part of the frame.
    ///
    /// # Errors
    /// [`ImageError::Size`] if memory does not suffice.
    ///
    /// # Panics
    /// If the region reaches beyond the frame.
    pub fn cut(&self, region: Region) -> Result<Self, ImageError> {
        Ok(Self {
            colour: self.colour.cut(region)?,
            depth: self.depth.cut(region)?,
            motion: self.motion.cut(region)?,
            instance: self.instance.cut(region)?,
            primitive: self.primitive.cut(region)?,
            transparent: self.transparent.cut(region)?,
            layers: self.layers.as_ref().map(|layers| layers.cut(region)).transpose()?,
        })
    }

    /// Puts another frame into a part of its size; its layers where both have them.
    ///
    /// # Panics
    /// If the region reaches beyond the frame, or the other frame has another size.
    pub fn paste(&mut self, region: Region, part: &Self) {
        self.colour.paste(region, &part.colour);
        self.depth.paste(region, &part.depth);
        self.motion.paste(region, &part.motion);
        self.instance.paste(region, &part.instance);
        self.primitive.paste(region, &part.primitive);
        self.transparent.paste(region, &part.transparent);
        if let (Some(layers), Some(part)) = (&mut self.layers, &part.layers) {
            layers.paste(region, part);
        }
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
            ("colour plane and layers", self.layers.as_ref().map_or(first, Image::size)),
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
