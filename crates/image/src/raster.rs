//! A rectangle of pixels.

use std::ops::{Index, IndexMut};

use rayon::prelude::*;

use crate::{ImageError, Region};

/// A rectangle of at least one pixel, stored row by row with the top row first.
///
/// `image[(x, y)]` reads and writes a pixel and, like a slice, panics outside; [`Image::get`] and
/// [`Image::get_clamped`] do not.
#[derive(Clone, Debug, PartialEq)]
pub struct Image<T> {
    width: u32,
    height: u32,
    data: Vec<T>,
}

impl<T> Image<T> {
    /// Takes pixels that are already in order: row by row, top row first.
    ///
    /// # Errors
    /// [`ImageError::Size`] if a side is zero, [`ImageError::PixelCount`] if `data` is not `width * height`
    /// long.
    pub fn from_vec(width: u32, height: u32, data: Vec<T>) -> Result<Self, ImageError> {
        if data.len() != pixel_count::<T>(width, height)? {
            return Err(ImageError::PixelCount { width, height, found: data.len() });
        }
        Ok(Self { width, height, data })
    }

    /// Calls `pixel(x, y)` for every pixel, row by row.
    ///
    /// # Errors
    /// [`ImageError::Size`] if a side is zero or memory does not suffice.
    pub fn from_fn(
        width: u32,
        height: u32,
        mut pixel: impl FnMut(u32, u32) -> T,
    ) -> Result<Self, ImageError> {
        let mut data = reserve(width, height)?;
        data.extend((0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)));
        Ok(Self { width, height, data })
    }

    /// Width in pixels, at least 1.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels, at least 1.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// All pixels, row by row, top row first.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.data
    }

    /// All pixels for writing, row by row, top row first.
    #[must_use]
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// Gives up the pixels, row by row, top row first.
    #[must_use]
    pub fn into_vec(self) -> Vec<T> {
        self.data
    }

    /// The pixel in column `x` and row `y`, or `None` outside.
    #[must_use]
    pub fn get(&self, x: u32, y: u32) -> Option<&T> {
        (x < self.width && y < self.height).then(|| &self.data[self.offset(x, y)])
    }

    /// The pixel nearest to column `x` and row `y`, which may lie outside.
    #[must_use]
    #[inline]
    pub fn get_clamped(&self, x: i64, y: i64) -> &T {
        let inside = |at: i64, size: u32| at.clamp(0, i64::from(size) - 1) as u32;
        &self[(inside(x, self.width), inside(y, self.height))]
    }

    /// Writes a pixel; returns whether it lies inside.
    pub fn set(&mut self, x: u32, y: u32, value: T) -> bool {
        let inside = x < self.width && y < self.height;
        if inside {
            self[(x, y)] = value;
        }
        inside
    }

    /// The rows from top to bottom.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[T]> + DoubleEndedIterator {
        self.data.chunks_exact(self.width as usize)
    }

    /// The rows from top to bottom, for writing.
    pub fn rows_mut(&mut self) -> impl ExactSizeIterator<Item = &mut [T]> + DoubleEndedIterator {
        self.data.chunks_exact_mut(self.width as usize)
    }

    /// A new image of the same size with `f` applied to every pixel.
    #[must_use]
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> Image<U> {
        Image { width: self.width, height: self.height, data: self.data.iter().map(f).collect() }
    }

    fn offset(&self, x: u32, y: u32) -> usize {
        assert!(
            x < self.width && y < self.height,
            "pixel ({x}, {y}) lies outside {}x{}",
            self.width,
            self.height
        );
        y as usize * self.width as usize + x as usize
    }
}

impl<T: Clone> Image<T> {
    /// An image of one value.
    ///
    /// # Errors
    /// [`ImageError::Size`] if a side is zero or memory does not suffice.
    pub fn filled(width: u32, height: u32, value: T) -> Result<Self, ImageError> {
        let mut data = reserve(width, height)?;
        data.resize(pixel_count::<T>(width, height)?, value);
        Ok(Self { width, height, data })
    }

    /// A part of the image.
    ///
    /// # Errors
    /// [`ImageError::Size`] if memory does not suffice.
    ///
    /// # Panics
    /// If the region reaches beyond the image.
    pub fn cut(&self, region: Region) -> Result<Self, ImageError> {
        let mut data = reserve(region.width, region.height)?;
        for y in region.top..region.bottom() {
            let (start, last) = (self.offset(region.left, y), self.offset(region.right() - 1, y));
            data.extend_from_slice(&self.data[start..=last]);
        }
        Ok(Self { width: region.width, height: region.height, data })
    }

    /// Puts another image into a part of its size.
    ///
    /// # Panics
    /// If the region reaches beyond the image, or the other image has another size.
    pub fn paste(&mut self, region: Region, part: &Self) {
        assert_eq!([part.width, part.height], region.size(), "a part is as large as its region");
        for (y, row) in (region.top..).zip(part.rows()) {
            let (start, last) = (self.offset(region.left, y), self.offset(region.right() - 1, y));
            self.data[start..=last].clone_from_slice(row);
        }
    }
}

impl<T: Send> Image<T> {
    /// [`Image::from_fn`] on all threads of the current rayon pool; the result does not depend on their
    /// number.
    ///
    /// # Errors
    /// [`ImageError::Size`] if a side is zero or memory does not suffice.
    pub fn par_from_fn(
        width: u32,
        height: u32,
        pixel: impl Fn(u32, u32) -> T + Sync,
    ) -> Result<Self, ImageError> {
        let mut data = reserve(width, height)?;
        let count = pixel_count::<T>(width, height)?;
        let columns = width as usize;
        let at = |index: usize| pixel((index % columns) as u32, (index / columns) as u32);
        (0..count).into_par_iter().with_min_len(columns).map(at).collect_into_vec(&mut data);
        Ok(Self { width, height, data })
    }

    /// The rows from top to bottom, for writing in parallel.
    pub fn par_rows_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [T]> {
        self.data.par_chunks_exact_mut(self.width as usize)
    }
}

impl<T: Sync> Image<T> {
    /// The rows from top to bottom, for reading in parallel.
    pub fn par_rows(&self) -> impl IndexedParallelIterator<Item = &[T]> {
        self.data.par_chunks_exact(self.width as usize)
    }

    /// [`Image::map`] on all threads of the current rayon pool.
    #[must_use]
    pub fn par_map<U: Send>(&self, f: impl Fn(&T) -> U + Sync + Send) -> Image<U> {
        let data = self.data.par_iter().with_min_len(self.width as usize).map(f).collect();
        Image { width: self.width, height: self.height, data }
    }
}

impl<T> Index<(u32, u32)> for Image<T> {
    type Output = T;

    fn index(&self, (x, y): (u32, u32)) -> &T {
        &self.data[self.offset(x, y)]
    }
}

impl<T> IndexMut<(u32, u32)> for Image<T> {
    fn index_mut(&mut self, (x, y): (u32, u32)) -> &mut T {
        let offset = self.offset(x, y);
        &mut self.data[offset]
    }
}

/// Pixels of an image, if their bytes are addressable.
fn pixel_count<T>(width: u32, height: u32) -> Result<usize, ImageError> {
    let error = ImageError::Size { width, height };
    let count = (width as usize).checked_mul(height as usize).filter(|&count| count > 0);
    let addressable = |count: &usize| {
        count.checked_mul(size_of::<T>().max(1)).is_some_and(|bytes| isize::try_from(bytes).is_ok())
    };
    count.filter(addressable).ok_or(error)
}

/// An empty pixel list with room for the whole image.
fn reserve<T>(width: u32, height: u32) -> Result<Vec<T>, ImageError> {
    let mut data = Vec::new();
    data.try_reserve_exact(pixel_count::<T>(width, height)?)
        .map_err(|_| ImageError::Size { width, height })?;
    Ok(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_lie_row_by_row_with_the_top_row_first() {
        let image = Image::from_fn(3, 2, |x, y| 10 * y + x).unwrap();
        assert_eq!(image.as_slice(), [0, 1, 2, 10, 11, 12]);
        assert_eq!(image.rows().nth(1).unwrap(), [10, 11, 12]);
        assert_eq!(image[(2, 1)], 12);
        assert_eq!(image, Image::par_from_fn(3, 2, |x, y| 10 * y + x).unwrap());
        assert_eq!(image.map(|v| v * 2), image.par_map(|v| v * 2));
    }

    #[test]
    fn reading_outside_gives_nothing_or_the_nearest_pixel() {
        let mut image = Image::from_fn(3, 2, |x, y| 10 * y + x).unwrap();
        assert_eq!(image.get(3, 0), None);
        assert_eq!(image.get(0, 2), None);
        assert_eq!(image.get(2, 1), Some(&12));
        assert_eq!(*image.get_clamped(-5, 9), 10);
        assert_eq!(*image.get_clamped(i64::MAX, i64::MIN), 2);
        assert!(image.set(1, 1, 99) && !image.set(3, 1, 7));
        assert_eq!(image[(1, 1)], 99);
    }

    #[test]
    #[should_panic(expected = "lies outside 3x2")]
    fn indexing_past_a_row_does_not_wrap_into_the_next() {
        let image = Image::filled(3, 2, 0_u8).unwrap();
        let _ = image[(3, 0)];
    }

    #[test]
    fn what_is_cut_out_and_pasted_back_is_as_it_was() {
        let image = Image::from_fn(5, 4, |x, y| 10 * y + x).unwrap();
        let region = Region { left: 2, top: 1, width: 3, height: 2 };
        let part = image.cut(region).unwrap();
        assert_eq!((part.size(), part.as_slice()), ((3, 2), &[12, 13, 14, 22, 23, 24][..]));
        let mut other = image.map(|_| 99);
        other.paste(region, &part);
        let expected =
            Image::from_fn(5, 4, |x, y| if x >= 2 && (y == 1 || y == 2) { 10 * y + x } else { 99 });
        assert_eq!(other, expected.unwrap());
        assert_eq!(image.cut(Region::whole([5, 4])).unwrap(), image);
    }

    #[test]
    fn impossible_sizes_are_errors() {
        assert!(matches!(Image::filled(0, 4, 0_u8), Err(ImageError::Size { .. })));
        assert!(matches!(Image::filled(u32::MAX, u32::MAX, [0_f32; 4]), Err(ImageError::Size { .. })));
        assert!(matches!(Image::from_fn(u32::MAX, u32::MAX, |_, _| 0_u64), Err(ImageError::Size { .. })));
        assert!(matches!(Image::from_vec(2, 2, vec![0_u8; 3]), Err(ImageError::PixelCount { found: 3, .. })));
    }

    #[test]
    fn rows_can_be_written_in_parallel() {
        let mut image = Image::filled(4, 8, 0_usize).unwrap();
        image.par_rows_mut().enumerate().for_each(|(y, row)| row.fill(y));
        assert!(image.rows().enumerate().all(|(y, row)| row.iter().all(|&v| v == y)));
        assert_eq!(image.par_rows().map(|row| row[0]).sum::<usize>(), 28);
    }
}
