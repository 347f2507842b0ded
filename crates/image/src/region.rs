//! Rectangles of pixels within a picture.

use std::{fmt, str::FromStr};

/// A rectangle of a picture's pixels, at least one. It is typed and printed as `X,Y,WIDTH,HEIGHT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Region {
    /// Column of the first pixel, from 0.
    pub left: u32,
    /// Row of the first pixel, from 0 at the top.
    pub top: u32,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
}

impl Region {
    /// All pixels of a picture of this width and height.
    #[must_use]
    pub fn whole([width, height]: [u32; 2]) -> Self {
        Self { left: 0, top: 0, width, height }
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The first column to the right of it.
    #[must_use]
    pub fn right(&self) -> u32 {
        self.left + self.width
    }

    /// The first row below it.
    #[must_use]
    pub fn bottom(&self) -> u32 {
        self.top + self.height
    }

    /// How many pixels it has.
    #[must_use]
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Whether it lies within a picture of this width and height.
    #[must_use]
    pub fn is_within(&self, [width, height]: [u32; 2]) -> bool {
        let ends_within =
            |from: u32, length: u32, end: u32| from.checked_add(length).is_some_and(|last| last <= end);
        ends_within(self.left, self.width, width) && ends_within(self.top, self.height, height)
    }

    /// The same with so many more pixels on each side, as far as a picture of this width and height has them.
    #[must_use]
    pub fn grown(&self, margin_px: u32, [width, height]: [u32; 2]) -> Self {
        let (left, top) = (self.left.saturating_sub(margin_px), self.top.saturating_sub(margin_px));
        let right = self.right().saturating_add(margin_px).min(width);
        let bottom = self.bottom().saturating_add(margin_px).min(height);
        Self { left, top, width: right - left, height: bottom - top }
    }

    /// The pixels that it has in common with another one, if there are any.
    #[must_use]
    pub fn overlap(&self, other: &Self) -> Option<Self> {
        let (left, top) = (self.left.max(other.left), self.top.max(other.top));
        let (right, bottom) = (self.right().min(other.right()), self.bottom().min(other.bottom()));
        (left < right && top < bottom).then(|| Self { left, top, width: right - left, height: bottom - top })
    }

    /// The same pixels, counted from the first one of a region that holds them.
    #[must_use]
    pub fn seen_from(&self, outer: &Self) -> Self {
        Self { left: self.left - outer.left, top: self.top - outer.top, ..*self }
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { left, top, width, height } = self;
        write!(f, "{left},{top},{width},{height}")
    }
}

impl FromStr for Region {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        let numbers = numbers.and_then(|numbers| <[u32; 4]>::try_from(numbers).ok());
        numbers
            .filter(|&[.., width, height]| width > 0 && height > 0)
            .map(|[left, top, width, height]| Self { left, top, width, height })
            .ok_or_else(|| {
                "give X,Y,WIDTH,HEIGHT in pixels from the upper left corner, as in 480,0,240,270".to_owned()
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIDDLE: Region = Region { left: 4, top: 3, width: 6, height: 2 };

    #[test]
    fn regions_are_read_as_they_are_printed() {
        assert_eq!(MIDDLE.to_string(), "4,3,6,2");
        assert_eq!(MIDDLE.to_string().parse(), Ok(MIDDLE));
        for wrong in ["", "1,2,3", "1,2,3,4,5", "0,0,0,1", "0,0,1,0", "-1,0,1,1", "0;0;1;1", "0,0,1,1.5"] {
            assert!(wrong.parse::<Region>().is_err(), "{wrong} passed");
        }
    }

    #[test]
    fn a_region_ends_with_its_picture() {
        assert!(MIDDLE.is_within([10, 5]) && !MIDDLE.is_within([9, 5]) && !MIDDLE.is_within([10, 4]));
        assert!(!Region { left: u32::MAX, ..MIDDLE }.is_within([10, 5]));
        assert_eq!(MIDDLE.grown(3, [100, 100]), Region { left: 1, top: 0, width: 12, height: 8 });
        assert_eq!(MIDDLE.grown(u32::MAX, [12, 6]), Region::whole([12, 6]));
    }

    #[test]
    fn overlaps_are_what_both_have() {
        let right = Region { left: 8, top: 0, width: 5, height: 4 };
        assert_eq!(MIDDLE.overlap(&right), Some(Region { left: 8, top: 3, width: 2, height: 1 }));
        assert_eq!(MIDDLE.overlap(&Region { left: 10, ..right }), None);
        let seen = MIDDLE.seen_from(&Region { left: 1, top: 2, width: 20, height: 20 });
        assert_eq!(seen, Region { left: 3, top: 1, ..MIDDLE });
    }
}
