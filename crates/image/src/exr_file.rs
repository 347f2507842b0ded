//! OpenEXR: linear light with premultiplied alpha, and the other planes of a frame.

use std::io::Cursor;
use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::{ReadChannels, ReadLayers, WritableImage};

use crate::output::SOFTWARE;
use crate::{ImageError, Metadata, Planes, TextureLimits, write_whole};

/// Encodes a frame as one scan line part with the channels `R G B A` (premultiplied linear light), `depth.Z` (scene
/// units, infinite where nothing is), `motion.X motion.Y` (pixels), all 32-bit float, and `instance.ID primitive.ID`,
/// 32-bit unsigned. The mask of transparent pixels is not stored. The same frame gives the same bytes.
///
/// # Errors
/// [`ImageError::SizesDiffer`], [`ImageError::MetadataKey`] or [`ImageError::Encode`].
pub fn encode_exr(planes: &Planes, metadata: &Metadata) -> Result<Vec<u8>, ImageError> {
    planes.check_sizes()?;
    let mut attributes =
        LayerAttributes { software_name: Some(Text::from(SOFTWARE)), ..LayerAttributes::default() };
    for (key, text) in metadata.stored()? {
        attributes.other.insert(Text::from(key.as_str()), AttributeValue::Text(utf8_text(text)));
    }

    let colour = |channel: usize| {
        FlatSamples::F32(planes.colour.as_slice().iter().map(|rgba_premul| rgba_premul[channel]).collect())
    };
    let motion =
        |axis: usize| FlatSamples::F32(planes.motion.as_slice().iter().map(|motion| motion[axis]).collect());
    let channels = [
        ("R", colour(0)),
        ("G", colour(1)),
        ("B", colour(2)),
        ("A", colour(3)),
        ("depth.Z", FlatSamples::F32(planes.depth.as_slice().to_vec())),
        ("motion.X", motion(0)),
        ("motion.Y", motion(1)),
        ("instance.ID", FlatSamples::U32(planes.instance.as_slice().to_vec())),
        ("primitive.ID", FlatSamples::U32(planes.primitive.as_slice().to_vec())),
    ];
    let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples));

    let size = Vec2(planes.width() as usize, planes.height() as usize);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels.collect()));
    let failed = |reason: String| ImageError::Encode { format: "EXR", reason };
    let mut bytes = Vec::new();
    exr::image::Image::from_layer(layer)
        .write()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|error| failed(error.to_string()))?;
    sort_header(&mut bytes).ok_or_else(|| failed("the encoder wrote a broken header".to_owned()))?;
    Ok(bytes)
}

/// Text as the UTF-8 bytes that current OpenEXR readers expect; `Text::from` would drop what is not Latin-1.
fn utf8_text(text: &str) -> Text {
    Text::from_bytes_unchecked(text.bytes().collect())
}

/// Puts the attributes of a single-part file in the order of their names. The encoder takes ours from a hash map, so
/// that without this the same frame would give other bytes in each run. `None` if the header does not parse.
fn sort_header(bytes: &mut [u8]) -> Option<()> {
    const MAGIC_AND_VERSION_BYTES: usize = 8;
    let header = bytes.get(MAGIC_AND_VERSION_BYTES..)?;
    // An attribute: name, NUL, type, NUL, length in 4 bytes, value. A NUL in place of a name ends the list.
    let text_bytes = |from: usize| Some(header.get(from..)?.iter().position(|&byte| byte == 0)? + 1);
    let mut attributes = Vec::new();
    let mut at = 0;
    while *header.get(at)? != 0 {
        let name_end = at + text_bytes(at)?;
        let length_at = name_end + text_bytes(name_end)?;
        let value_at = length_at + 4;
        let length = u32::from_le_bytes(header.get(length_at..value_at)?.try_into().ok()?);
        let end = value_at + length as usize;
        attributes.push(header.get(at..end)?.to_vec());
        at = end;
    }
    attributes.sort();
    bytes[MAGIC_AND_VERSION_BYTES..MAGIC_AND_VERSION_BYTES + at].copy_from_slice(&attributes.concat());
    Some(())
}

/// Writes a frame: see [`encode_exr`].
///
/// # Errors
/// Those of [`encode_exr`] and [`write_whole`].
pub fn write_exr(path: &Path, planes: &Planes, metadata: &Metadata) -> Result<(), ImageError> {
    write_whole(path, &encode_exr(planes, metadata)?)
}

/// Reads what [`write_exr`] writes. `R`, `G` and `B` are needed; a missing `A` is opaque, other missing channels see
/// nothing, and no pixel counts as transparent. Half floats are widened.
///
/// # Errors
/// [`ImageError::Read`], [`ImageError::TooLarge`] above the default [`TextureLimits`], or [`ImageError::Decode`].
pub fn read_exr(path: &Path) -> Result<Planes, ImageError> {
    let bytes = std::fs::read(path).map_err(|source| ImageError::Read { path: path.to_owned(), source })?;
    let what = path.display().to_string();
    let failed = |reason: String| ImageError::Decode {
        what: what.clone(),
        reason,
        formats: "OpenEXR with R, G and B",
    };
    check_claimed_size(&bytes, &what)?;

    let layer = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(&bytes))
        .map_err(|error| failed(error.to_string()))?
        .layer_data;
    let (Ok(width), Ok(height)) = (u32::try_from(layer.size.0), u32::try_from(layer.size.1)) else {
        return Err(failed("its sides do not fit 32 bits".to_owned()));
    };
    let mut planes = Planes::new(width, height)?;
    planes.colour.as_mut_slice().fill([0.0, 0.0, 0.0, 1.0]);

    let find = |name: &str| layer.channel_data.list.iter().find(|channel| channel.name.eq(name));
    for (index, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
        match find(name) {
            Some(channel) => {
                let values = channel.sample_data.values_as_f32();
                planes
                    .colour
                    .as_mut_slice()
                    .iter_mut()
                    .zip(values)
                    .for_each(|(rgba, value)| rgba[index] = value);
            }
            None if name == "A" => {}
            None => return Err(failed(format!("the channel {name} is missing"))),
        }
    }
    if let Some(channel) = find("depth.Z") {
        planes
            .depth
            .as_mut_slice()
            .iter_mut()
            .zip(channel.sample_data.values_as_f32())
            .for_each(|(z, v)| *z = v);
    }
    for (axis, name) in ["motion.X", "motion.Y"].into_iter().enumerate() {
        if let Some(channel) = find(name) {
            let values = channel.sample_data.values_as_f32();
            planes.motion.as_mut_slice().iter_mut().zip(values).for_each(|(motion, v)| motion[axis] = v);
        }
    }
    for (name, plane) in [("instance.ID", &mut planes.instance), ("primitive.ID", &mut planes.primitive)] {
        match find(name).map(|channel| &channel.sample_data) {
            Some(FlatSamples::U32(ids)) => {
                plane.as_mut_slice().iter_mut().zip(ids).for_each(|(id, &value)| *id = value);
            }
            Some(_) => return Err(failed(format!("the channel {name} is not of 32-bit unsigned numbers"))),
            None => {}
        }
    }
    Ok(planes)
}

/// Refuses a file whose header claims more pixels than are worth decoding.
fn check_claimed_size(bytes: &[u8], what: &str) -> Result<(), ImageError> {
    let limits = TextureLimits::default();
    // Unreadable headers are left to the reader, which says what is wrong.
    let Ok(meta) = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false) else { return Ok(()) };
    for header in &meta.headers {
        let (width, height) = (header.layer_size.0 as u64, header.layer_size.1 as u64);
        let channels = header.channels.list.len() as u64;
        let bytes = width.saturating_mul(height).saturating_mul(4 * channels);
        if width.max(height) > limits.max_side_px.into() || bytes > limits.max_bytes {
            return Err(ImageError::TooLarge {
                what: what.to_owned(),
                width,
                height,
                max_side_px: limits.max_side_px,
                max_bytes: limits.max_bytes,
            });
        }
    }
    Ok(())
}
