//! PNG (W3C Recommendation, third edition): what a display shows, with straight alpha.

use std::path::Path;

use crate::metadata::SOFTWARE;
use crate::{
    DisplayShare, Image, ImageError, Metadata, TextureLimits, Tone, decode_texture, display, read_whole,
    write_whole,
};

/// Encodes sRGB pixels with straight alpha. The sRGB chunk says so; metadata goes to `tEXt` chunks, or `iTXt`
/// where a text is not ASCII.
///
/// # Errors
/// [`ImageError::MetadataKey`], or [`ImageError::Encode`] for an image beyond PNG's limits.
pub fn encode_png(srgb_straight: &Image<[u8; 4]>, metadata: &Metadata) -> Result<Vec<u8>, ImageError> {
    let texts = metadata.stored()?;
    let encode = || {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, srgb_straight.width(), srgb_straight.height());
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.add_text_chunk("Software".to_owned(), SOFTWARE.to_owned())?;
        for (key, text) in &texts {
            if text.is_ascii() {
                encoder.add_text_chunk(key.clone(), (*text).to_owned())?;
            } else {
                encoder.add_itxt_chunk(key.clone(), (*text).to_owned())?;
            }
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(bytemuck::cast_slice(srgb_straight.as_slice()))?;
        writer.finish()?;
        Ok(bytes)
    };
    encode()
        .map_err(|error: png::EncodingError| ImageError::Encode { format: "PNG", reason: error.to_string() })
}

/// Writes premultiplied linear colour as displayed: see [`display`] and [`encode_png`].
///
/// # Errors
/// Those of [`encode_png`] and [`write_whole`].
pub fn write_png(
    path: &Path,
    colour: &Image<[f32; 4]>,
    tone: Tone,
    share: &DisplayShare,
    metadata: &Metadata,
) -> Result<(), ImageError> {
    write_whole(path, &encode_png(&display(colour, tone, share), metadata)?)
}

/// Reads a PNG as 8-bit RGBA with straight alpha, in the colour space of the file.
///
/// # Errors
/// [`ImageError::Read`], or those of [`decode_texture`] with its default limits.
pub fn read_png(path: &Path) -> Result<Image<[u8; 4]>, ImageError> {
    let bytes =
        read_whole(path, u64::MAX).map_err(|source| ImageError::Read { path: path.to_owned(), source })?;
    decode_texture(&bytes, &path.display().to_string(), TextureLimits::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> Image<[u8; 4]> {
        Image::from_fn(7, 5, |x, y| [(40 * x) as u8, (50 * y) as u8, 7, (255 - x * y) as u8]).unwrap()
    }

    #[test]
    fn pixels_survive_a_round_trip_unchanged() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_whole(&path, &encode_png(&gradient(), &Metadata::default()).unwrap()).unwrap();
        assert_eq!(read_png(&path).unwrap(), gradient());
    }

    #[test]
    fn files_say_that_they_are_srgb_and_how_they_were_made() {
        let metadata = Metadata::default().with("seed", 7).with("scene", "fenêtre");
        let bytes = encode_png(&gradient(), &metadata).unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let info = reader.info();
        assert_eq!(info.srgb, Some(png::SrgbRenderingIntent::Perceptual));
        let latin: Vec<_> = info
            .uncompressed_latin1_text
            .iter()
            .map(|chunk| (chunk.keyword.as_str(), chunk.text.as_str()))
            .collect();
        assert_eq!(latin, [("Software", SOFTWARE), ("sheer.seed", "7")]);
        assert_eq!(info.utf8_text[0].keyword, "sheer.scene");
        assert_eq!(info.utf8_text[0].get_text().unwrap(), "fenêtre");
        assert_eq!(
            bytes,
            encode_png(&gradient(), &metadata).unwrap(),
            "the same picture gives the same bytes"
        );
    }

    #[test]
    fn a_half_transparent_pixel_is_stored_with_straight_alpha() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("half.png");
        let colour = Image::filled(2, 1, [0.5, 0.25, 0.0, 0.5]).unwrap();
        write_png(&path, &colour, Tone::default(), &DisplayShare::Everything, &Metadata::default()).unwrap();
        assert_eq!(read_png(&path).unwrap()[(1, 0)], [255, 188, 0, 128]);
    }

    #[test]
    fn a_missing_file_is_named() {
        let message = read_png(Path::new("no/such.png")).unwrap_err().to_string();
        assert!(message.contains("no/such.png"), "{message}");
    }
}
