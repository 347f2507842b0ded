//! Damaged images of every format: whatever happens to their bytes, decoding ends with an image or an error,
//! in the memory that it may take.
//!
//! `SHEER_DAMAGE=N` damages N times as many.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by panicking, whether in a test function or on its way there"
)]

use std::{
    env,
    io::Cursor,
    panic::{self, AssertUnwindSafe},
};

use image::{DynamicImage, ImageFormat};
use rayon::prelude::*;
use sheer_core::hash::Pcg32;
use sheer_image::{
    Metadata, Planes, TextureLimits, decode_exr, decode_panorama, decode_texture, encode_exr, texture_size,
};

/// Reads bytes, and says whether there is an image in them.
type Read = fn(&[u8]) -> bool;

/// A small sound image of a format, and who reads it.
struct Row {
    name: &'static str,
    make: fn() -> Vec<u8>,
    read: Read,
}

const ROWS: &[Row] = &[
    Row { name: "PNG, 8 bits", make: || encoded(ImageFormat::Png), read: texture },
    Row { name: "PNG, a bit", make: || png(png::ColorType::Grayscale, png::BitDepth::One, 2), read: texture },
    Row {
        name: "PNG, 16 bits",
        make: || png(png::ColorType::Rgba, png::BitDepth::Sixteen, 128),
        read: texture,
    },
    Row {
        name: "PNG, palette",
        make: || png(png::ColorType::Indexed, png::BitDepth::Four, 8),
        read: texture,
    },
    Row { name: "JPEG", make: || encoded(ImageFormat::Jpeg), read: texture },
    Row { name: "WebP", make: || encoded(ImageFormat::WebP), read: texture },
    Row { name: "BMP", make: || encoded(ImageFormat::Bmp), read: texture },
    Row { name: "TGA", make: || encoded(ImageFormat::Tga), read: |bytes| texture_of(bytes, "image.tga") },
    Row { name: "OpenEXR", make: exr, read: |bytes| decode_exr(bytes, "an image").is_ok() },
    Row { name: "OpenEXR panorama", make: exr, read: panorama },
    Row { name: "Radiance HDR", make: hdr, read: panorama },
];

/// Damaged versions of each.
const ROUNDS: u32 = 3000;

/// What one of them may take.
const LIMITS: TextureLimits = TextureLimits { max_side_px: 4096, max_bytes: 32 << 20 };

fn texture(bytes: &[u8]) -> bool {
    texture_of(bytes, "an image")
}

fn texture_of(bytes: &[u8], name: &str) -> bool {
    let size = texture_size(bytes, name, LIMITS);
    let image = decode_texture(bytes, name, LIMITS);
    // The header alone says what the whole does.
    if let Ok(image) = &image {
        assert_eq!(size.unwrap(), image.size());
    }
    image.is_ok()
}

fn panorama(bytes: &[u8]) -> bool {
    decode_panorama(bytes, "an image", LIMITS).is_ok()
}

/// A panorama in runs and plain bytes.
fn hdr() -> Vec<u8> {
    let texels: Vec<image::Rgb<f32>> =
        (0..16 * 8).map(|at| image::Rgb([at as f32, 0.5, if at > 64 { 9.0 } else { 0.0 }])).collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&texels, 16, 8).unwrap();
    bytes
}

/// A gradient, which no compression makes nothing of.
fn encoded(format: ImageFormat) -> Vec<u8> {
    let picture = image::RgbImage::from_fn(24, 16, |x, y| image::Rgb([(10 * x) as u8, (x * y) as u8, 90]));
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageRgb8(picture).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A PNG of 16 rows of so many bytes.
fn png(colour: png::ColorType, depth: png::BitDepth, row_bytes: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 16, 16);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    if colour == png::ColorType::Indexed {
        encoder.set_palette((0..48).collect::<Vec<u8>>());
        encoder.set_trns((0..16).collect::<Vec<u8>>());
    }
    let samples: Vec<u8> = (0..16 * row_bytes).map(|at| (at * at) as u8).collect();
    encoder.write_header().unwrap().write_image_data(&samples).unwrap();
    bytes
}

fn exr() -> Vec<u8> {
    let mut planes = Planes::new(16, 8).unwrap();
    for (at, colour) in planes.colour.as_mut_slice().iter_mut().enumerate() {
        *colour = [at as f32, 0.5, 1.0 / (1.0 + at as f32), 1.0];
    }
    encode_exr(&planes, &Metadata::default()).unwrap()
}

/// The bytes with damage of one of four kinds.
fn damaged(bytes: &[u8], chance: &mut Pcg32) -> Vec<u8> {
    const WORDS: [u32; 6] = [0, 1, 0x7fff_ffff, 0x8000_0000, u32::MAX, 0x0001_0000];
    let mut place = |count: usize| chance.below(count as u32) as usize;
    let mut damaged = bytes.to_vec();
    match place(4) {
        0 => damaged.truncate(place(bytes.len())),
        1 => {
            let start = place(bytes.len());
            damaged.drain(start..(start + 1 + place(16)).min(bytes.len()));
        }
        2 => {
            // Lengths and sizes are words of either order.
            let (at, word) = (place(bytes.len()), WORDS[place(WORDS.len())]);
            let word = if place(2) == 0 { word.to_le_bytes() } else { word.to_be_bytes() };
            damaged.iter_mut().skip(at).zip(word).for_each(|(byte, new)| *byte = new);
        }
        _ => {
            for _ in 0..=place(4) {
                let at = place(bytes.len());
                damaged[at] ^= 1 << place(8);
            }
        }
    }
    repair_png(&mut damaged);
    damaged
}

/// Sets the checksums of a PNG right: its decoder would look no further than at a wrong one.
fn repair_png(bytes: &mut [u8]) {
    let mut at = 8;
    while bytes.starts_with(b"\x89PNG")
        && let Some(length) = bytes.get(at..at + 4)
    {
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let Some(end) = at.checked_add(8 + length).filter(|end| end + 4 <= bytes.len()) else { break };
        let crc = bytes[at + 4..end].iter().fold(u32::MAX, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
        });
        bytes[end..end + 4].copy_from_slice(&(!crc).to_be_bytes());
        at = end + 4;
    }
}

/// The most memory that this process has had, in bytes, where the system says so.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

#[test]
fn no_damage_makes_a_decoder_panic_or_take_more_than_it_may() {
    let factor: u32 = env::var("SHEER_DAMAGE").ok().map_or(1, |factor| factor.parse().unwrap());
    let mut faults = Vec::new();
    for (number, row) in ROWS.iter().enumerate() {
        let whole = (row.make)();
        assert!((row.read)(&whole), "{}", row.name);
        let attempt = |round: u32| {
            let mut chance = Pcg32::new(2026 + number as u64, u64::from(round));
            let bytes = damaged(&whole, &mut chance);
            panic::catch_unwind(AssertUnwindSafe(|| (row.read)(&bytes))).map_err(|_| round)
        };
        let outcomes: Vec<Result<bool, u32>> = (0..ROUNDS * factor).into_par_iter().map(attempt).collect();
        let read = outcomes.iter().filter(|outcome| **outcome == Ok(true)).count();
        let refused = outcomes.iter().filter(|outcome| **outcome == Ok(false)).count();
        println!("{}: {read} read, {refused} refused", row.name);
        // Both have been exercised.
        assert!(read > 20 && refused > 100, "{}: {read}, {refused}", row.name);
        faults.extend(outcomes.into_iter().filter_map(Result::err).map(|round| (row.name, round)));
    }
    assert!(faults.is_empty(), "it panics: {faults:?}");
    assert!(peak_bytes().is_none_or(|peak| peak < 1_000_000_000), "{:?}", peak_bytes());
}
