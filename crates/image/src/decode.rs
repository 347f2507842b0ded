//! Reading textures that strangers made: PNG, JPEG and WebP with bounded memory.

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
const FORMATS: &str = "PNG, JPEG or WebP";

/// Decodes a PNG, JPEG or WebP to 8-bit RGBA with straight alpha, in the colour space of the file; the first picture of
/// an animation. 16-bit channels are rounded to 8 bits, missing alpha is opaque. The format is told by the bytes.
/// `name` says in messages what the bytes are, such as a file name.
///
/// # Errors
/// [`ImageError::TooLarge`] before anything large is allocated, or [`ImageError::Decode`].
pub fn decode_texture(bytes: &[u8], name: &str, limits: TextureLimits) -> Result<Image<[u8; 4]>, ImageError> {
    let failed = |reason: String| ImageError::Decode { what: name.to_owned(), reason, formats: FORMATS };

    // The header tells the size.
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| failed(error.to_string()))?;
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP) => {}
        Some(other) => return Err(failed(format!("{other:?} files are not supported"))),
        None => return Err(failed("the bytes are in no known image format".to_owned())),
    }
    // Sides are checked below, so that the message can name them.
    let mut decoder_limits = image::Limits::default();
    decoder_limits.max_alloc = Some(limits.max_bytes);
    reader.limits(decoder_limits);
    let decoder = reader.into_decoder().map_err(|error| failed(error.to_string()))?;
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

    // Decode straight into place, or into a buffer to convert from.
    let mut image = Image::filled(width, height, [0_u8; 4])?;
    let target = image.as_mut_slice();
    let decoded = if colour_type == ColorType::Rgba8 {
        decoder.read_image(bytemuck::cast_slice_mut(target))
    } else {
        let mut samples = Vec::new();
        samples.try_reserve_exact(decoded_bytes as usize).map_err(|_| ImageError::Size { width, height })?;
        samples.resize(decoded_bytes as usize, 0_u8);
        decoder.read_image(&mut samples).map(|()| convert_to_rgba8(&samples, colour_type, target))
    };
    decoded.map_err(|error| failed(error.to_string()))?;
    Ok(image)
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
