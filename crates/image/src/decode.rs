//! Reading textures that strangers made: PNG, JPEG, WebP, BMP and TGA with bounded memory.

use std::io::Cursor;

use image::{ColorType, ImageDecoder, ImageFormat, ImageReader};

use crate::{Image, ImageError};

/// What a texture may cost before it is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureLimits {
    /// The longest side, in pixels.
    pub max_side_px: u32,
    /// The most memory that the pixels may take while they are decoded and converted.
    pub max_bytes: u64,
}

impl Default for TextureLimits {
    /// 16384 pixels a side, which every current GPU can hold, and 1 GiB.
    fn default() -> Self {
        Self { max_side_px: 16_384, max_bytes: 1 << 30 }
    }
}

/// The formats that [`decode_texture`] reads, for messages.
const FORMATS: &str = "PNG, JPEG, WebP, BMP or TGA";

/// Decodes a PNG, JPEG, WebP, BMP or TGA to 8-bit RGBA with straight alpha, in the colour space of the file;
/// the first picture of an animation. 16-bit channels are rounded to 8 bits, missing alpha is opaque. The
/// format is recognised by its bytes, but TGA, which has nothing of its own, by a `name` that ends with
/// `.tga`. The name says in messages what the bytes are, such as a file name.
///
/// # Errors
/// [`ImageError::TooLarge`] before anything large is allocated, [`ImageError::TooMuchMemory`], or
/// [`ImageError::Decode`].
pub fn decode_texture(bytes: &[u8], name: &str, limits: TextureLimits) -> Result<Image<[u8; 4]>, ImageError> {
    let decoder = open(bytes, name, limits)?;
    let (width, height) = decoder.dimensions();
    let colour_type = decoder.color_type();

    // Decode straight into place, or into a buffer to convert from.
    let mut image = Image::filled(width, height, [0_u8; 4])?;
    let target = image.as_mut_slice();
    let decoded = if colour_type == ColorType::Rgba8 {
        decoder.read_image(bytemuck::cast_slice_mut(target))
    } else {
        let decoded_bytes = target.len() * usize::from(colour_type.bytes_per_pixel());
        let mut samples = Vec::new();
        samples.try_reserve_exact(decoded_bytes).map_err(|_| ImageError::Size { width, height })?;
        samples.resize(decoded_bytes, 0_u8);
        decoder.read_image(&mut samples).map(|()| convert_to_rgba8(&samples, colour_type, target))
    };
    decoded.map_err(|error| refused(error, name, limits))?;
    // Many programs leave the fourth byte of a TGA at zero and mean nothing by it.
    let texels = image.as_mut_slice();
    if is_tga(name) && texels.iter().all(|texel| texel[3] == 0) {
        texels.iter_mut().for_each(|texel| texel[3] = 255);
    }
    Ok(image)
}

/// Width and height of what [`decode_texture`] would make of the bytes, from their header alone.
///
/// # Errors
/// Those of [`decode_texture`] that the header is enough for.
pub fn texture_size(bytes: &[u8], name: &str, limits: TextureLimits) -> Result<(u32, u32), ImageError> {
    open(bytes, name, limits).map(|decoder| decoder.dimensions())
}

/// Whether a name says that the bytes are TGA, if they are nothing else.
fn is_tga(name: &str) -> bool {
    name.len() >= 4 && name.as_bytes()[name.len() - 4..].eq_ignore_ascii_case(b".tga")
}

fn failed(reason: String, name: &str) -> ImageError {
    ImageError::Decode { what: name.to_owned(), reason, formats: FORMATS }
}

fn refused(error: image::ImageError, name: &str, limits: TextureLimits) -> ImageError {
    match error {
        image::ImageError::Limits(_) => {
            ImageError::TooMuchMemory { what: name.to_owned(), max_bytes: limits.max_bytes }
        }
        other => failed(other.to_string(), name),
    }
}

/// Reads the header, and checks it.
fn open<'b>(
    bytes: &'b [u8],
    name: &str,
    limits: TextureLimits,
) -> Result<impl ImageDecoder + use<'b>, ImageError> {
    let failed = |reason: String| failed(reason, name);

    // The header tells the size.
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| failed(error.to_string()))?;
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP | ImageFormat::Bmp) => {}
        Some(other) => return Err(failed(format!("{other:?} files are not supported"))),
        None if is_tga(name) => reader.set_format(ImageFormat::Tga),
        None => return Err(failed("the bytes are in no known image format".to_owned())),
    }
    // Sides are checked below, so that the message can name them.
    let mut decoder_limits = image::Limits::default();
    decoder_limits.max_alloc = Some(limits.max_bytes);
    reader.limits(decoder_limits);
    let decoder = reader.into_decoder().map_err(|error| refused(error, name, limits))?;
    let (width, height) = decoder.dimensions();
    let colour_type = decoder.color_type();

    // Nothing large is allocated before this check.
    let pixels = u64::from(width) * u64::from(height);
    let decoded_bytes = pixels * u64::from(colour_type.bytes_per_pixel());
    let converted_bytes = if colour_type == ColorType::Rgba8 { 0 } else { 4 * pixels };
    if width.max(height) > limits.max_side_px || decoded_bytes + converted_bytes > limits.max_bytes {
        return Err(ImageError::TooLarge {
            what: name.to_owned(),
            width: width.into(),
            height: height.into(),
            max_side_px: limits.max_side_px,
            max_bytes: limits.max_bytes,
        });
    }
    Ok(decoder)
}

/// Spreads grey, adds opaque alpha and rounds 16 bits (native byte order) to 8.
fn convert_to_rgba8(samples: &[u8], colour_type: ColorType, target: &mut [[u8; 4]]) {
    let channels = usize::from(colour_type.channel_count());
    let bytes_per_channel = usize::from(colour_type.bytes_per_pixel()) / channels;
    let channel = |pixel: &[u8], index: usize| match bytes_per_channel {
        2 => {
            let wide = u16::from_ne_bytes([pixel[2 * index], pixel[2 * index + 1]]);
            ((u32::from(wide) + 128) / 257) as u8
        }
        _ => pixel[index],
    };
    for (rgba, pixel) in target.iter_mut().zip(samples.chunks_exact(channels * bytes_per_channel)) {
        let at = |index| channel(pixel, index);
        *rgba = match channels {
            1 => [at(0), at(0), at(0), 255],
            2 => [at(0), at(0), at(0), at(1)],
            3 => [at(0), at(1), at(2), 255],
            _ => [at(0), at(1), at(2), at(3)],
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Metadata, encode_png};

    fn decode(bytes: &[u8]) -> Result<Image<[u8; 4]>, ImageError> {
        decode_texture(bytes, "leaf texture", TextureLimits::default())
    }

    /// `samples` as a 2×1 PNG of the given kind.
    fn small_png(colour: png::ColorType, depth: png::BitDepth, samples: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(samples).unwrap();
        bytes
    }

    /// A PNG whose header claims a size and whose data end there.
    fn claiming_png(width: u32, height: u32) -> Vec<u8> {
        let mut header = b"IHDR".to_vec();
        header.extend(width.to_be_bytes());
        header.extend(height.to_be_bytes());
        header.extend([8, 6, 0, 0, 0]);
        let crc = header.iter().fold(u32::MAX, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
        });
        let mut bytes = b"\x89PNG\r\n\x1a\n\0\0\0\x0d".to_vec();
        bytes.extend(header);
        bytes.extend((!crc).to_be_bytes());
        bytes.extend(b"\0\0\0\0IDAT\x35\xaf\x06\x1e");
        bytes
    }

    #[test]
    fn grey_palette_alpha_and_sixteen_bits_become_rgba8() {
        use png::BitDepth::{Eight, Sixteen};
        use png::ColorType::{Grayscale, GrayscaleAlpha, Rgb, Rgba};
        let cases: [(_, _, &[u8], [[u8; 4]; 2]); 6] = [
            (Grayscale, Eight, &[7, 200], [[7, 7, 7, 255], [200, 200, 200, 255]]),
            (GrayscaleAlpha, Eight, &[7, 0, 200, 128], [[7, 7, 7, 0], [200, 200, 200, 128]]),
            (Rgb, Eight, &[1, 2, 3, 4, 5, 6], [[1, 2, 3, 255], [4, 5, 6, 255]]),
            (Rgba, Eight, &[1, 2, 3, 4, 5, 6, 7, 8], [[1, 2, 3, 4], [5, 6, 7, 8]]),
            // 0x0180 = 384 is 1.494 steps of 257; 0xff7f rounds down to 254, 0xff80 up to 255.
            (Grayscale, Sixteen, &[0x01, 0x80, 0xff, 0xff], [[1, 1, 1, 255], [255; 4]]),
            (
                GrayscaleAlpha,
                Sixteen,
                &[0, 0, 0xff, 0x7e, 0, 0, 0xff, 0x80],
                [[0, 0, 0, 254], [0, 0, 0, 255]],
            ),
        ];
        for (colour, depth, samples, expected) in cases {
            let image = decode(&small_png(colour, depth, samples)).unwrap();
            assert_eq!(image.as_slice(), expected, "{colour:?} {depth:?}");
        }
    }

    #[test]
    fn jpeg_and_webp_are_read_too() {
        let picture = image::RgbImage::from_fn(16, 8, |x, _| image::Rgb([if x < 8 { 0 } else { 255 }, 0, 0]));
        for format in [ImageFormat::Jpeg, ImageFormat::WebP] {
            let mut bytes = Cursor::new(Vec::new());
            picture.write_to(&mut bytes, format).unwrap();
            let read = decode(bytes.get_ref()).unwrap();
            assert_eq!(read.size(), (16, 8));
            // Eight pixels are a block of JPEG, so that its loss stays small.
            assert!(read[(2, 4)][0] < 10 && read[(13, 4)][0] > 245, "{format:?}");
            assert_eq!(read[(13, 4)][3], 255);
        }
    }

    #[test]
    fn images_that_claim_too_much_are_refused_before_they_are_decoded() {
        let error = |width, height| decode(&claiming_png(width, height)).unwrap_err();
        for (width, height) in [(40_000, 1), (1, 16_385), (16_384, 16_385)] {
            let error = error(width, height);
            assert!(matches!(error, ImageError::TooLarge { .. }), "{width}x{height}: {error}");
            let message = error.to_string();
            assert!(message.contains("leaf texture") && message.contains(&width.to_string()), "{message}");
        }
        assert!(matches!(error(2_000_000_000, 2_000_000_000), ImageError::TooMuchMemory { .. }));
        // The header is enough for the size.
        let size = |width, height| texture_size(&claiming_png(width, height), "t", TextureLimits::default());
        assert_eq!(size(16_384, 1024).unwrap(), (16_384, 1024));
        assert!(matches!(size(40_000, 1), Err(ImageError::TooLarge { .. })));
        // Within the limits it is the missing data that is noticed.
        assert!(matches!(error(16_384, 1024), ImageError::Decode { .. }));
    }

    #[test]
    fn a_jpeg_that_claims_too_much_is_refused() {
        let mut bytes = Cursor::new(Vec::new());
        image::RgbImage::new(16, 8).write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
        let mut bytes = bytes.into_inner();
        // The frame header: marker, length and precision, then height and width.
        let frame_at = bytes.windows(2).position(|window| window == [0xff, 0xc0]).unwrap();
        bytes[frame_at + 5..frame_at + 9].fill(0xff);
        assert!(matches!(decode(&bytes), Err(ImageError::TooLarge { width: 65_535, height: 65_535, .. })));
    }

    #[test]
    fn limits_count_the_memory_of_the_conversion() {
        let rgba = encode_png(&Image::filled(64, 64, [9; 4]).unwrap(), &Metadata::default()).unwrap();
        let within =
            |max_bytes| decode_texture(&rgba, "t", TextureLimits { max_bytes, max_side_px: 64 }).is_ok();
        assert!(within(64 * 64 * 4) && !within(64 * 64 * 4 - 1));
        let side = TextureLimits { max_side_px: 63, ..TextureLimits::default() };
        assert!(matches!(decode_texture(&rgba, "t", side), Err(ImageError::TooLarge { .. })));
        let grey = small_png(png::ColorType::Grayscale, png::BitDepth::Eight, &[1, 2]);
        let within =
            |max_bytes| decode_texture(&grey, "t", TextureLimits { max_bytes, max_side_px: 64 }).is_ok();
        assert!(!within(2 * 4), "the grey samples and their RGBA copy live side by side");
    }

    #[test]
    fn broken_bytes_are_errors_that_name_the_texture() {
        let whole = encode_png(&Image::filled(64, 64, [9, 8, 7, 6]).unwrap(), &Metadata::default()).unwrap();
        let mut damaged = whole.clone();
        let data_at = whole.windows(4).position(|window| window == b"IDAT").unwrap() + 4;
        damaged[data_at + 4] ^= 0xff;
        for bytes in
            [&whole[..whole.len() / 2], &whole[..20], b"", b"no image", b"GIF89a\x01\x00\x01\x00", &damaged]
        {
            let message = decode(bytes).unwrap_err().to_string();
            assert!(
                message.contains("leaf texture") && message.contains("PNG, JPEG, WebP, BMP or TGA"),
                "{message}"
            );
        }
    }
}
