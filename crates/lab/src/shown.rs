//! A frame as figures see it.

use sheer_image::{DisplayShare, Image, Tone, display_over_black, u8_from_unit};

/// A frame in linear light and as a display shows it, both over black.
pub(crate) struct Shown {
    /// Linear.
    pub(crate) linear: Image<[f32; 3]>,
    /// sRGB, 0 to 1.
    pub(crate) displayed: Image<[f32; 3]>,
}

impl Shown {
    /// `colour`: linear, premultiplied.
    pub(crate) fn new(colour: &Image<[f32; 4]>, tone: Tone, share: &DisplayShare) -> Self {
        let linear = colour.par_map(|&[r, g, b, _]| [r, g, b]);
        Self { linear, displayed: display_over_black(colour, tone, share) }
    }

    /// What a display shows, 8 bits a channel.
    pub(crate) fn in_bytes(&self) -> Image<[u8; 3]> {
        self.displayed.par_map(|pixel| pixel.map(u8_from_unit))
    }
}
