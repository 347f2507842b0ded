//! Reading panoramas that strangers made: the light of surroundings, as Radiance HDR or OpenEXR.

use std::{io, io::Cursor, path::Path};

use exr::prelude::{ReadChannels, ReadLayers};
use image::{ImageDecoder as _, codecs::hdr::HdrDecoder};

use crate::{Image, ImageError, TextureLimits, exr_file::check_claimed_size, read_whole};

/// The formats that [`read_panorama`] reads, for messages.
const FORMATS: &str = "Radiance HDR or OpenEXR with R, G and B";
/// Texels brighter than this, infinite ones among them, count as this bright: ten times the sun's disc, if 1
/// is white paper in the sun.
const BRIGHTEST: f32 = 1e6;

/// Reads an equirectangular panorama, linear radiance, top row first; alpha is ignored. The format is
/// recognised by the bytes. What is negative or no number counts as 0.
///
/// # Errors
/// [`ImageError::Read`], also of what is no regular file; [`ImageError::TooLarge`] and
/// [`ImageError::TooMuchMemory`] before anything large is allocated; [`ImageError::Decode`], also if the
/// picture is not twice as wide as it is high.
pub fn read_panorama(path: &Path, limits: TextureLimits) -> Result<Image<[f32; 3]>, ImageError> {
    let what = path.display().to_string();
    let bytes = read_limited(path, limits)?;
    decode_panorama(&bytes, &what, limits)
}

/// Reads a file of no more bytes than a picture may take.
pub(crate) fn read_limited(path: &Path, limits: TextureLimits) -> Result<Vec<u8>, ImageError> {
    let TextureLimits { max_bytes, .. } = limits;
    read_whole(path, max_bytes).map_err(|source| match source.kind() {
        io::ErrorKind::FileTooLarge => {
            ImageError::TooMuchMemory { what: path.display().to_string(), max_bytes }
        }
        _ => ImageError::Read { path: path.to_owned(), source },
    })
}

/// Whether the bytes are those of a Radiance HDR file.
pub(crate) fn is_hdr(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// Whether the bytes are those of an OpenEXR file.
pub(crate) fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

/// Reads a panorama that is in memory already, as [`read_panorama`] does. `what` says in messages what the
/// bytes are, such as a file name.
///
/// # Errors
/// Those of [`read_panorama`] but [`ImageError::Read`].
pub fn decode_panorama(
    bytes: &[u8],
    what: &str,
    limits: TextureLimits,
) -> Result<Image<[f32; 3]>, ImageError> {
    let failed = |reason: String| ImageError::Decode { what: what.to_owned(), reason, formats: FORMATS };
    let mut texels = if is_hdr(bytes) {
        hdr(bytes, what, limits)?
    } else if is_exr(bytes) {
        exr(bytes, what, limits)?
    } else {
        return Err(failed("the bytes are in neither format".to_owned()));
    };
    let (width, height) = texels.size();
    if width != 2 * height {
        return Err(failed(format!(
            "a panorama is twice as wide as it is high, and this one is {width}x{height}"
        )));
    }
    for texel in texels.as_mut_slice() {
        // The comparison is false for what is no number.
        *texel = texel.map(|value| if value > 0.0 { value.min(BRIGHTEST) } else { 0.0 });
    }
    Ok(texels)
}

/// Reads a Radiance HDR file of any shape, linear.
pub(crate) fn hdr(bytes: &[u8], what: &str, limits: TextureLimits) -> Result<Image<[f32; 3]>, ImageError> {
    let failed = |error: image::ImageError| ImageError::Decode {
        what: what.to_owned(),
        reason: error.to_string(),
        formats: FORMATS,
    };
    // Strictly the first line would have to be `#?RADIANCE`, and many programs write `#?RGBE`.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(failed)?;
    let (width, height) = decoder.dimensions();
    let decoded_bytes = decoder.total_bytes();
    if width.max(height) > limits.max_side_px || decoded_bytes > limits.max_bytes {
        return Err(ImageError::TooLarge {
            what: what.to_owned(),
            width: width.into(),
            height: height.into(),
            max_side_px: limits.max_side_px,
            max_bytes: limits.max_bytes,
        });
    }
    let mut texels = Image::filled(width, height, [0.0_f32; 3])?;
    decoder.read_image(bytemuck::cast_slice_mut(texels.as_mut_slice())).map_err(failed)?;
    Ok(texels)
}

fn exr(bytes: &[u8], what: &str, limits: TextureLimits) -> Result<Image<[f32; 3]>, ImageError> {
    check_claimed_size(bytes, what, limits)?;
    let layer = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0_f32; 3]; size.area()]),
            |(width, texels), at, (r, g, b): (f32, f32, f32)| texels[at.y() * *width + at.x()] = [r, g, b],
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| ImageError::Decode {
            what: what.to_owned(),
            reason: error.to_string(),
            formats: FORMATS,
        })?
        .layer_data;
    // The claimed size has been checked, and it fits.
    Image::from_vec(layer.size.0 as u32, layer.size.1 as u32, layer.channel_data.pixels.1)
}

#[cfg(test)]
mod tests {
    use image::ExtendedColorType;
    use sheer_core::hash::Pcg32;

    use super::*;
    use crate::{Metadata, Planes, encode_exr};

    fn decode(bytes: &[u8]) -> Result<Image<[f32; 3]>, ImageError> {
        decode_panorama(bytes, "sky", TextureLimits::default())
    }

    /// Radiance of a picture of 8×4 texels, no two alike, from dark to brighter than a display.
    fn texel(x: u32, y: u32) -> [f32; 3] {
        [0.25 * (x + 1) as f32, 0.5 * (y + 1) as f32, 64.0 * (x + 8 * y) as f32]
    }

    fn hdr_bytes() -> Vec<u8> {
        let texels = Image::from_fn(8, 4, texel).unwrap();
        let mut bytes = Vec::new();
        let encoder = image::codecs::hdr::HdrEncoder::new(&mut bytes);
        let written = image::ImageEncoder::write_image(
            encoder,
            bytemuck::cast_slice(texels.as_slice()),
            8,
            4,
            ExtendedColorType::Rgb32F,
        );
        written.unwrap();
        bytes
    }

    fn exr_bytes(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 3]) -> Vec<u8> {
        let mut planes = Planes::new(width, height).unwrap();
        planes.colour = Image::from_fn(width, height, |x, y| {
            let [r, g, b] = texel(x, y);
            [r, g, b, 1.0]
        })
        .unwrap();
        encode_exr(&planes, &Metadata::default()).unwrap()
    }

    #[test]
    fn both_formats_give_linear_radiance_top_row_first() {
        let from_exr = decode(&exr_bytes(8, 4, texel)).unwrap();
        assert_eq!(from_exr, Image::from_fn(8, 4, texel).unwrap());
        // Radiance has 8 bits of the brightest channel for all three.
        let from_hdr = decode(&hdr_bytes()).unwrap();
        for (read, written) in from_hdr.as_slice().iter().zip(from_exr.as_slice()) {
            let tolerance = written.iter().fold(0.0_f32, |most, &value| most.max(value)) / 128.0;
            assert!(
                read.iter().zip(written).all(|(a, b)| (a - b).abs() <= tolerance),
                "{read:?} {written:?}"
            );
        }
    }

    #[test]
    fn older_programs_sign_their_files_otherwise() {
        let bytes = hdr_bytes();
        let renamed = [b"#?RGBE".as_slice(), &bytes[b"#?RADIANCE".len()..]].concat();
        assert_eq!(decode(&renamed).unwrap(), decode(&bytes).unwrap());
    }

    #[test]
    fn what_is_no_radiance_counts_as_none() {
        let odd = [f32::NAN, -1.0, f32::INFINITY];
        let read = decode(&exr_bytes(2, 1, |_, _| odd)).unwrap();
        assert_eq!(read.as_slice(), [[0.0, 0.0, BRIGHTEST]; 2]);
    }

    #[test]
    fn what_is_no_panorama_is_refused_with_the_reason() {
        let message = |bytes: &[u8]| decode(bytes).unwrap_err().to_string();
        let square = message(&exr_bytes(4, 4, |_, _| [1.0; 3]));
        assert!(
            square.contains("sky") && square.contains("twice as wide") && square.contains("4x4"),
            "{square}"
        );
        let other = message(b"\x89PNG\r\n\x1a\n");
        assert!(other.contains("sky") && other.contains("Radiance HDR or OpenEXR"), "{other}");
        let whole = [hdr_bytes(), exr_bytes(8, 4, texel)];
        for bytes in &whole {
            for end in [3, 12, bytes.len() / 2, bytes.len() - 1] {
                assert!(message(&bytes[..end]).contains("sky"));
            }
        }
    }

    #[test]
    fn claims_are_checked_before_anything_is_allocated() {
        let claiming = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 2000000\n";
        assert!(matches!(decode(claiming), Err(ImageError::TooLarge { width: 2_000_000, .. })));
        let small = TextureLimits { max_bytes: 8 * 4 * 12 - 1, ..TextureLimits::default() };
        let refused = decode_panorama(&hdr_bytes(), "sky", small);
        assert!(matches!(refused, Err(ImageError::TooLarge { .. })), "{refused:?}");
    }

    #[test]
    fn damaged_files_end_in_a_picture_or_an_error() {
        let limits = TextureLimits { max_side_px: 1024, max_bytes: 1 << 24 };
        let mut random = Pcg32::new(1, 2);
        let (mut pictures, mut errors) = (0, 0);
        for whole in [hdr_bytes(), exr_bytes(8, 4, texel)] {
            for _ in 0..2000 {
                let mut bytes = whole.clone();
                for _ in 0..1 + random.next_u32() % 4 {
                    // The header is the smaller part and the one that counts.
                    let end =
                        if random.next_u32().is_multiple_of(2) { bytes.len().min(300) } else { bytes.len() };
                    let at = random.next_u32() as usize % end;
                    bytes[at] = random.next_u32() as u8;
                }
                match decode_panorama(&bytes, "sky", limits) {
                    Ok(texels) => {
                        pictures += 1;
                        assert!(
                            texels
                                .as_slice()
                                .as_flattened()
                                .iter()
                                .all(|value| (0.0..=BRIGHTEST).contains(value))
                        );
                    }
                    Err(error) => {
                        errors += 1;
                        assert!(error.to_string().contains("sky"), "{error}");
                    }
                }
            }
        }
        assert!(pictures > 100 && errors > 100, "{pictures} pictures, {errors} errors");
    }

    #[test]
    fn only_regular_files_are_opened() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| read_panorama(path, TextureLimits::default()).unwrap_err().to_string();
        assert!(message(folder.path()).contains("no regular file"));
        assert!(message(&folder.path().join("absent.hdr")).contains("absent.hdr"));
        let path = folder.path().join("sky.hdr");
        std::fs::write(&path, hdr_bytes()).unwrap();
        assert_eq!(read_panorama(&path, TextureLimits::default()).unwrap().size(), (8, 4));
        let small = TextureLimits { max_bytes: 16, ..TextureLimits::default() };
        assert!(matches!(read_panorama(&path, small), Err(ImageError::TooMuchMemory { .. })));
    }
}
