//! KTX 2.0 images: Basis Universal (UASTC and ETC1S, by the `basisu` crate), ASTC, and plain 8-bit texels,
//! with Zstandard supercompression or without.
//!
//! The header is read here whatever the payload is, so that sizes are known to be sane before anything is
//! allocated. Section numbers are those of the KTX File Format Specification, version 2.0.

use std::{borrow::Cow, io::Read};

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use sheer_core::caught_panic;
use sheer_image::{Image, TextureLimits};

/// What every file begins with (KTX 2.0, section 3.1).
const IDENTIFIER: [u8; 12] = *b"\xABKTX 20\xBB\r\n\x1A\n";
/// Bytes before the level index (section 2).
const HEADER_BYTES: usize = 80;
/// Bytes of an entry of the level index.
const LEVEL_BYTES: usize = 24;
/// Levels of the largest image there can be.
const MAX_LEVELS: u32 = 32;
/// Zstandard in section 3.8.
const ZSTANDARD: u32 = 2;

/// Whether the bytes are a KTX 2.0 file.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(&IDENTIFIER)
}

/// Width and height, from the header alone.
pub(super) fn size(bytes: &[u8], limits: TextureLimits) -> Result<(u32, u32), String> {
    Header::read(bytes, limits).map(|header| (header.width, header.height))
}

/// Whether the header of a KTX 2.0 file states more pixels than allowed.
pub(super) fn is_too_large(bytes: &[u8], limits: TextureLimits) -> bool {
    let word =
        |at: usize| bytes.get(at..at + 4).and_then(|word| word.try_into().ok()).map(u32::from_le_bytes);
    let (Some(width), Some(height)) = (word(20), word(24)) else { return false };
    exceeds(width, height, limits)
}

fn exceeds(width: u32, height: u32, limits: TextureLimits) -> bool {
    let pixels = u64::from(width) * u64::from(height);
    width.max(height) > limits.max_side_px || pixels * 4 > limits.max_bytes
}

/// Decodes the largest level. The error says what is wrong and what to do.
pub(super) fn decode(bytes: &[u8], limits: TextureLimits) -> Result<Image<[u8; 4]>, String> {
    let header = Header::read(bytes, limits)?;
    let texels = match Plain::from_vk_format(header.format) {
        Some(plain) => plain.decode(&header, bytes)?,
        None => decode_basis(&header, bytes)?,
    };
    Image::from_vec(header.width, header.height, texels).map_err(|error| error.to_string())
}

/// What is needed of a KTX header.
struct Header {
    /// A `VkFormat`; 0 for Basis Universal.
    format: u32,
    width: u32,
    height: u32,
    supercompression: u32,
    /// Offset and length of the largest level.
    largest: (u64, u64),
}

impl Header {
    fn read(bytes: &[u8], limits: TextureLimits) -> Result<Self, String> {
        let cut_short = || "the KTX2 file is cut short; copy or make it again".to_owned();
        let word = |at: usize| -> Result<u32, String> {
            let word = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
            word.map(u32::from_le_bytes).ok_or_else(cut_short)
        };
        let long =
            |at: usize| -> Result<u64, String> { Ok(u64::from(word(at)?) | u64::from(word(at + 4)?) << 32) };
        let (width, height) = (word(20)?, word(24)?);
        let (depth, layers, faces, levels) = (word(28)?, word(32)?, word(36)?, word(40)?);
        if depth > 1 || layers > 1 || faces != 1 {
            return Err(
                "the KTX2 file is a volume, an array or a cube map; make it a single 2D image".to_owned()
            );
        }
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || exceeds(width, height, limits) {
            return Err(format!(
                "the KTX2 file holds {width}x{height} pixels, above the limit of {} pixels a side and {} bytes: scale it down",
                limits.max_side_px, limits.max_bytes
            ));
        }
        if levels > MAX_LEVELS {
            return Err(format!("the KTX2 file has {levels} levels; make it again"));
        }
        // No level of an 8-bit or block format takes more than four bytes a pixel, blocks rounded up to 12
        // pixels a side.
        let most = u64::from(width.next_multiple_of(12)) * u64::from(height.next_multiple_of(12)) * 4;
        for level in 0..levels.max(1) as usize {
            let at = HEADER_BYTES + level * LEVEL_BYTES;
            if long(at + 16)? > most {
                return Err(format!(
                    "level {level} of the KTX2 file states more bytes than its pixels can take; make it again"
                ));
            }
            let end = long(at)?.checked_add(long(at + 8)?);
            if end.is_none_or(|end| end > bytes.len() as u64) {
                return Err(cut_short());
            }
        }
        Ok(Self {
            format: word(12)?,
            width,
            height,
            supercompression: word(44)?,
            largest: (long(HEADER_BYTES)?, long(HEADER_BYTES + 8)?),
        })
    }

    fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// Texels of whole bytes: the place of red, green, blue and alpha in each, if it has them.
struct Plain {
    bytes: usize,
    channels: [Option<usize>; 4],
}

impl Plain {
    fn from_vk_format(format: u32) -> Option<Self> {
        // UNORM and SRGB of each: the material says how to read them.
        let (bytes, channels) = match format {
            9 | 15 => (1, [Some(0), None, None, None]),
            16 | 22 => (2, [Some(0), Some(1), None, None]),
            23 | 29 => (3, [Some(0), Some(1), Some(2), None]),
            30 | 36 => (3, [Some(2), Some(1), Some(0), None]),
            37 | 43 => (4, [Some(0), Some(1), Some(2), Some(3)]),
            44 | 50 => (4, [Some(2), Some(1), Some(0), Some(3)]),
            _ => return None,
        };
        Some(Self { bytes, channels })
    }

    fn decode(&self, header: &Header, bytes: &[u8]) -> Result<Vec<[u8; 4]>, String> {
        let (offset, length) = header.largest;
        let stored = &bytes[offset as usize..(offset + length) as usize];
        let wanted = header.pixel_count() * self.bytes;
        let data = match header.supercompression {
            0 => Cow::Borrowed(stored),
            ZSTANDARD => Cow::Owned(inflate(stored, wanted)?),
            other => {
                return Err(format!(
                    "the KTX2 file is packed by scheme {other}; pack it with Zstandard or not at all"
                ));
            }
        };
        let data =
            data.get(..wanted).ok_or("the KTX2 file has fewer texels than its size says; make it again")?;
        let texel = |texel: &[u8]| {
            let [red, green, blue, alpha] = self.channels;
            let value = |channel: Option<usize>, missing| channel.map_or(missing, |at| texel[at]);
            [value(red, 0), value(green, 0), value(blue, 0), value(alpha, 255)]
        };
        Ok(data.chunks_exact(self.bytes).map(texel).collect())
    }
}

/// At most `wanted` bytes of a Zstandard frame.
fn inflate(stored: &[u8], wanted: usize) -> Result<Vec<u8>, String> {
    let damaged = |error: &dyn std::fmt::Display| {
        format!("the KTX2 file's Zstandard data is damaged ({error}); make it again")
    };
    let decoder = ruzstd::StreamingDecoder::new(stored).map_err(|error| damaged(&error))?;
    let mut data = Vec::new();
    decoder.take(wanted as u64).read_to_end(&mut data).map_err(|error| damaged(&error))?;
    Ok(data)
}

/// Basis Universal, and the ASTC formats that it knows.
fn decode_basis(header: &Header, bytes: &[u8]) -> Result<Vec<[u8; 4]>, String> {
    // Sizes are checked above; what the decoder trusts beyond them, such as an index into a codebook, must
    // not end the program.
    let attempt = caught_panic::catch(|| {
        let transcoder = Transcoder::new(bytes).ok()?;
        (transcoder.base_dimensions() == (header.width, header.height)).then_some(())?;
        transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).ok()
    });
    let texels = attempt.ok().flatten().filter(|texels| texels.len() == 4 * header.pixel_count());
    let texels = texels.ok_or_else(|| {
        let format = header.format;
        format!("the KTX2 file is damaged or of a format that is not read (VkFormat {format}); use UASTC, ETC1S or 8-bit RGBA")
    })?;
    Ok(texels.as_chunks().0.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of one level.
    fn file(
        format: u32,
        (width, height): (u32, u32),
        supercompression: u32,
        data: &[u8],
        unpacked: u64,
    ) -> Vec<u8> {
        let mut bytes = IDENTIFIER.to_vec();
        for word in [format, 1, width, height, 0, 0, 1, 1, supercompression, 0, 0, 0, 0, 0, 0, 0, 0] {
            bytes.extend(word.to_le_bytes());
        }
        for long in [(HEADER_BYTES + LEVEL_BYTES) as u64, data.len() as u64, unpacked] {
            bytes.extend(long.to_le_bytes());
        }
        bytes.extend(data);
        bytes
    }

    fn texels(bytes: &[u8]) -> Vec<[u8; 4]> {
        decode(bytes, TextureLimits::default()).unwrap().into_vec()
    }

    #[test]
    fn plain_texels_are_spread_to_rgba() {
        assert_eq!(texels(&file(9, (2, 1), 0, &[1, 2], 2)), [[1, 0, 0, 255], [2, 0, 0, 255]]);
        assert_eq!(texels(&file(36, (1, 1), 0, &[1, 2, 3], 3)), [[3, 2, 1, 255]]);
        assert_eq!(texels(&file(37, (1, 1), 0, &[1, 2, 3, 4], 4)), [[1, 2, 3, 4]]);
    }

    #[test]
    fn zstandard_frames_are_unpacked() {
        // A frame of one raw block (RFC 8878, 3.1.1): magic, descriptor with one byte of content size, size,
        // block header, data.
        let frame = [0x28, 0xB5, 0x2F, 0xFD, 0x20, 4, 4 << 3 | 1, 0, 0, 9, 8, 7, 6];
        assert_eq!(texels(&file(37, (1, 1), ZSTANDARD, &frame, 4)), [[9, 8, 7, 6]]);
    }

    #[test]
    fn damaged_and_unknown_files_say_what_to_do() {
        let refused = |bytes: &[u8]| decode(bytes, TextureLimits::default()).unwrap_err();
        let good = file(37, (1, 1), 0, &[1, 2, 3, 4], 4);
        for length in 12..good.len() {
            assert!(refused(&good[..length]).contains("again"), "{length}");
        }
        assert!(refused(&file(37, (1, 1), 0, &[1; 4], u64::MAX)).contains("more bytes"));
        assert!(refused(&file(37, (20_000, 1), 0, &[1; 4], 4)).contains("scale it down"));
        assert!(refused(&file(145, (4, 4), 0, &[0; 16], 16)).contains("UASTC"));
        assert!(refused(&file(37, (1, 1), 3, &[0; 4], 4)).contains("Zstandard"));
    }
}
