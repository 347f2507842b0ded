//! Reading finished pictures that other programs made, to hold ours against them.

use std::path::Path;

use glam::Vec3;
use sheer_core::colour::linear_from_srgb;

use crate::{
    DisplayShare, Image, ImageError, TextureLimits, decode_exr, decode_texture,
    panorama::{hdr, is_exr, is_hdr, read_limited},
    unit_from_u8,
};

/// A picture in linear light, and whether that is what it was stored in.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Linear, premultiplied.
    pub colour: Image<[f32; 4]>,
    /// [`DisplayShare::Everything`] of what was stored as a display shows it.
    pub share: DisplayShare,
}

/// Reads a picture: PNG, JPEG and WebP as what a display shows, sRGB with straight alpha; OpenEXR (the first
/// layer with R, G and B) and Radiance HDR as linear light. The format is recognised by the bytes.
///
/// # Errors
/// [`ImageError::Read`], also of what is no regular file; [`ImageError::TooLarge`] and
/// [`ImageError::TooMuchMemory`] before anything large is allocated; [`ImageError::Decode`].
pub fn read_picture(path: &Path, limits: TextureLimits) -> Result<Picture, ImageError> {
    let what = path.display().to_string();
    let bytes = read_limited(path, limits)?;
    decode_picture(&bytes, &what, limits)
}

/// Reads a picture that is in memory already, as [`read_picture`] does. `what` says in messages what the
/// bytes are, such as a file name.
///
/// # Errors
/// Those of [`read_picture`] but [`ImageError::Read`].
pub fn decode_picture(bytes: &[u8], what: &str, limits: TextureLimits) -> Result<Picture, ImageError> {
    if is_hdr(bytes) {
        let colour = hdr(bytes, what, limits)?.par_map(|&[r, g, b]| [r, g, b, 1.0]);
        return Ok(Picture { colour, share: DisplayShare::Nothing });
    }
    if is_exr(bytes) {
        return Ok(Picture { colour: decode_exr(bytes, what)?.colour, share: DisplayShare::Nothing });
    }
    let texels = decode_texture(bytes, what, limits)?;
    let colour = texels.par_map(|&[r, g, b, a]| {
        let alpha = unit_from_u8(a);
        let linear = Vec3::from([r, g, b].map(|value| linear_from_srgb(unit_from_u8(value))));
        (linear * alpha).extend(alpha).to_array()
    });
    Ok(Picture { colour, share: DisplayShare::Everything })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Metadata, Planes, Tone, display, encode_exr, encode_png};

    #[test]
    fn what_was_stored_for_a_display_is_shown_as_it_was() {
        let stored = Image::from_fn(16, 16, |x, y| [(16 * x) as u8, (16 * y) as u8, 128, 255]).unwrap();
        let png = encode_png(&stored, &Metadata::default()).unwrap();
        let Picture { colour, share } = decode_picture(&png, "a", TextureLimits::default()).unwrap();
        assert_eq!(display(&colour, Tone::default(), &share), stored);
    }

    #[test]
    fn linear_light_stays_linear() {
        let mut planes = Planes::new(2, 1).unwrap();
        planes.colour[(1, 0)] = [4.0, 0.5, 0.25, 0.5];
        let exr = encode_exr(&planes, &Metadata::default()).unwrap();
        let Picture { colour, share } = decode_picture(&exr, "a", TextureLimits::default()).unwrap();
        assert_eq!((colour[(1, 0)], share), ([4.0, 0.5, 0.25, 0.5], DisplayShare::Nothing));
        let mut hdr = Vec::new();
        let texels = [image::Rgb([2.0_f32, 0.5, 0.25]); 9];
        image::codecs::hdr::HdrEncoder::new(&mut hdr).encode(&texels, 3, 3).unwrap();
        let Picture { colour, share } = decode_picture(&hdr, "a", TextureLimits::default()).unwrap();
        assert_eq!((colour[(2, 2)], share), ([2.0, 0.5, 0.25, 1.0], DisplayShare::Nothing));
    }

    #[test]
    fn what_is_no_picture_is_refused_by_name() {
        let refused = decode_picture(b"no picture", "a.txt", TextureLimits::default());
        assert!(refused.unwrap_err().to_string().contains("a.txt"));
    }
}
