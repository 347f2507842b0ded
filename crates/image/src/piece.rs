//! Which part of a picture a file holds.

use std::{fmt, str::FromStr};

use crate::{metadata::Metadata, region::Region};

/// A part of a picture: some of its pixels, some of their samples, or all.
///
/// Files say so in their metadata: `size` is width and height of the picture as in `960x540`, `crop` the
/// region as in `480,0,240,270`, where it is not all of it, and `sample_range` the samples as in `0..16 of
/// 64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Width and height of the whole picture, pixels.
    pub picture: [u32; 2],
    /// Which of its pixels.
    pub region: Region,
    /// Which of the samples that each of them is the mean of; all if none.
    pub samples: Option<SampleRange>,
}

impl Piece {
    /// The key of [`Self::picture`] in metadata.
    pub(crate) const SIZE: &str = "size";
    /// The key of [`Self::region`] in metadata.
    pub(crate) const CROP: &str = "crop";
    /// The key of [`Self::samples`] in metadata.
    pub(crate) const SAMPLE_RANGE: &str = "sample_range";

    /// All of a picture of this width and height.
    #[must_use]
    pub fn whole(picture: [u32; 2]) -> Self {
        Self { picture, region: Region::whole(picture), samples: None }
    }

    /// Whether nothing of the picture is missing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        *self == Self::whole(self.picture)
    }

    /// What metadata say of a picture's size.
    pub(crate) fn size_text([width, height]: [u32; 2]) -> String {
        format!("{width}x{height}")
    }

    /// The metadata of a picture with those that make a file a piece of it.
    #[must_use]
    pub fn described(&self, metadata: Metadata) -> Metadata {
        let mut metadata = metadata.with(Self::SIZE, Self::size_text(self.picture));
        if self.region != Region::whole(self.picture) {
            metadata = metadata.with(Self::CROP, self.region);
        }
        match self.samples {
            Some(samples) => metadata.with(Self::SAMPLE_RANGE, samples),
            None => metadata,
        }
    }
}

/// Samples of a mean, counted from 0. Printed as `16..32 of 64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleRange {
    /// The first.
    pub first: u32,
    /// The one after the last; above `first`.
    pub end: u32,
    /// How many the whole mean has; at least `end`.
    pub of: u32,
}

impl SampleRange {
    /// How many samples they are.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.end - self.first
    }
}

impl fmt::Display for SampleRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first, end, of } = self;
        write!(f, "{first}..{end} of {of}")
    }
}

impl FromStr for SampleRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = || {
            let (range, of) = text.split_once(" of ")?;
            let (first, end) = range.split_once("..")?;
            Some(Self { first: first.parse().ok()?, end: end.parse().ok()?, of: of.parse().ok()? })
        };
        let is_sound = |range: &Self| range.first < range.end && range.end <= range.of;
        parsed().filter(is_sound).ok_or_else(|| format!("'{text}' is no range of samples as 16..32 of 64"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_say_what_is_missing_of_a_picture() {
        let whole = Piece::whole([40, 20]);
        let said = |piece: Piece| piece.described(Metadata::default());
        assert_eq!(said(whole), Metadata::default().with("size", "40x20"));
        let region = Region { left: 3, top: 4, width: 5, height: 6 };
        let samples = Some(SampleRange { first: 8, end: 12, of: 32 });
        let piece = Piece { region, samples, ..whole };
        assert_eq!(said(piece).get("crop"), Some("3,4,5,6"));
        assert_eq!(said(piece).get("sample_range"), Some("8..12 of 32"));
        assert!(whole.is_whole() && !piece.is_whole() && !Piece { samples, ..whole }.is_whole());
    }

    #[test]
    fn sample_ranges_are_read_as_they_are_printed() {
        let range = SampleRange { first: 8, end: 12, of: 32 };
        assert_eq!(range.to_string().parse(), Ok(range));
        for wrong in ["", "8..12", "8..8 of 32", "12..8 of 32", "8..33 of 32", "-1..2 of 3", "a..b of c"] {
            assert!(wrong.parse::<SampleRange>().is_err(), "{wrong} passed");
        }
    }
}
