//! OpenEXR: linear light with premultiplied alpha, and the other planes of a frame.

use std::io::Cursor;
use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::prelude::{ReadChannels, ReadLayers, WritableImage};

use crate::metadata::{PREFIX, SOFTWARE};
use crate::{
    DisplayShare, Image, ImageError, Metadata, Piece, PixelLayers, Planes, Region, TextureLimits, read_whole,
    write_whole,
};

/// A channel of [`PixelLayers`].
struct LayerChannel {
    name: &'static str,
    get: fn(&PixelLayers) -> f32,
    set: fn(&mut PixelLayers, f32),
}

/// The channels of [`Planes::layers`]; a file has layers if it has the first of them.
const LAYER_CHANNELS: [LayerChannel; 12] = [
    LayerChannel { name: "front.coverage", get: |of| of.coverage, set: |of, to| of.coverage = to },
    LayerChannel { name: "front.absorbed.R", get: |of| of.absorbed[0], set: |of, to| of.absorbed[0] = to },
    LayerChannel { name: "front.absorbed.G", get: |of| of.absorbed[1], set: |of, to| of.absorbed[1] = to },
    LayerChannel { name: "front.absorbed.B", get: |of| of.absorbed[2], set: |of, to| of.absorbed[2] = to },
    LayerChannel { name: "front.share", get: |of| of.share, set: |of, to| of.share = to },
    LayerChannel { name: "front.shaded", get: |of| mask(of.is_front), set: |of, to| of.is_front = to > 0.5 },
    LayerChannel {
        name: "front.motion.X",
        get: |of| of.front_motion[0],
        set: |of, to| of.front_motion[0] = to,
    },
    LayerChannel {
        name: "front.motion.Y",
        get: |of| of.front_motion[1],
        set: |of, to| of.front_motion[1] = to,
    },
    LayerChannel { name: "front.depth.Z", get: |of| of.front_depth, set: |of, to| of.front_depth = to },
    LayerChannel { name: "back.motion.X", get: |of| of.back_motion[0], set: |of, to| of.back_motion[0] = to },
    LayerChannel { name: "back.motion.Y", get: |of| of.back_motion[1], set: |of, to| of.back_motion[1] = to },
    LayerChannel { name: "back.depth.Z", get: |of| of.back_depth, set: |of, to| of.back_depth = to },
];

/// The channel of a [`DisplayShare`].
const SHARE_CHANNEL: &str = "display.share";

/// What a channel has for yes and no.
fn mask(is: bool) -> f32 {
    if is { 1.0 } else { 0.0 }
}

/// Encodes a frame as one scan line part. The same frame gives the same bytes. Its channels are 32-bit float,
/// ids 32-bit unsigned:
///
/// | channels | what | unit |
/// |---|---|---|
/// | `R G B A` | colour, premultiplied by alpha | linear light |
/// | `depth.Z` | distance along the view axis, infinite where nothing is | scene units |
/// | `motion.X motion.Y` | where the surface was in the last frame, minus where it is | pixels, y down |
/// | `instance.ID primitive.ID` | the surface, [`Planes::NO_ID`] where nothing is | |
/// | `transparent.mask` | whether a transparent fragment takes part in the pixel | 0 or 1 |
///
/// and, of a frame with [`Planes::layers`] (see [`PixelLayers`]):
///
/// | channels | what | unit |
/// |---|---|---|
/// | `front.coverage` | share of the front in what is seen | 0 to 1 |
/// | `front.absorbed.R …G …B` | shares of the back that its coloured glass absorbs beyond that | 0 to 1 |
/// | `front.share` | probability with which the shaded fragment was to be one of the front | 0 to 1 |
/// | `front.shaded` | whether it is one of the front | 0 or 1 |
/// | `front.motion.X front.motion.Y` | motion of the front | pixels, y down |
/// | `front.depth.Z` | depth of the front, infinite where there is none | scene units |
/// | `back.motion.X back.motion.Y` | motion of the back | pixels, y down |
/// | `back.depth.Z` | depth of the back, infinite where it is the background | scene units |
///
/// The *front* is everything transparent before the nearest opaque surface, the *back* that surface or the
/// background.
///
/// # Errors
/// [`ImageError::SizesDiffer`], [`ImageError::MetadataKey`] or [`ImageError::Encode`].
pub fn encode_exr(planes: &Planes, metadata: &Metadata) -> Result<Vec<u8>, ImageError> {
    let [width, height] = [planes.width(), planes.height()];
    encode_exr_piece(planes, &Piece::whole([width, height]), &DisplayShare::Nothing, metadata)
}

/// The same of a piece of a picture: the display window is the picture's, the data window that of the piece.
/// What it holds of display-referred light is the channel `display.share` (0 to 1), where there is any.
pub(crate) fn encode_exr_piece(
    planes: &Planes,
    piece: &Piece,
    share: &DisplayShare,
    metadata: &Metadata,
) -> Result<Vec<u8>, ImageError> {
    planes.check_sizes()?;
    let Region { left, top, width, height } = piece.region;
    let (found, expected) = (planes.colour.size(), (width, height));
    if found != expected {
        return Err(ImageError::SizesDiffer { what: "frame and piece", first: found, second: expected });
    }
    let mut attributes = LayerAttributes {
        software_name: Some(Text::from(SOFTWARE)),
        layer_position: Vec2(left as i32, top as i32),
        ..LayerAttributes::default()
    };
    for (key, text) in metadata.stored()? {
        attributes.other.insert(Text::from(key.as_str()), AttributeValue::Text(utf8_text(text)));
    }

    let colour = |channel: usize| {
        FlatSamples::F32(planes.colour.as_slice().iter().map(|rgba_premul| rgba_premul[channel]).collect())
    };
    let motion =
        |axis: usize| FlatSamples::F32(planes.motion.as_slice().iter().map(|motion| motion[axis]).collect());
    let transparent = planes.transparent.as_slice().iter().map(|&is| mask(is)).collect();
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
        ("transparent.mask", FlatSamples::F32(transparent)),
    ];
    let layers = planes.layers.iter().flat_map(|layers| {
        let samples = |get| FlatSamples::F32(layers.as_slice().iter().map(get).collect());
        LAYER_CHANNELS.iter().map(move |&LayerChannel { name, get, .. }| (name, samples(get)))
    });
    let shares = match share {
        DisplayShare::Nothing => None,
        DisplayShare::Everything => Some(vec![1.0; planes.colour.as_slice().len()]),
        DisplayShare::PerPixel(shares) if shares.size() == found => Some(shares.as_slice().to_vec()),
        DisplayShare::PerPixel(shares) => {
            let what = "frame and display share";
            return Err(ImageError::SizesDiffer { what, first: found, second: shares.size() });
        }
    };
    let shares = shares.map(|shares| (SHARE_CHANNEL, FlatSamples::F32(shares)));
    let channels = channels.into_iter().chain(layers).chain(shares);
    let channels = channels.map(|(name, samples)| AnyChannel::new(name, samples));

    let size = Vec2(width as usize, height as usize);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels.collect()));
    let failed = |reason: String| ImageError::Encode { format: "EXR", reason };
    let display = IntegerBounds::from_dimensions(Vec2(piece.picture[0] as usize, piece.picture[1] as usize));
    let mut bytes = Vec::new();
    exr::image::Image::new(ImageAttributes::new(display), layer)
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

/// Puts the attributes of a single-part file in the order of their names. The encoder takes ours from a hash
/// map, so that without this the same frame would give other bytes in each run. `None` if the header does not
/// parse.
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

/// Reads what [`write_exr`] writes. `R`, `G` and `B` are needed; a missing `A` is opaque, other missing
/// channels see nothing; without `front.coverage` there are no layers. Half floats are widened.
///
/// # Errors
/// [`ImageError::Read`], [`ImageError::TooLarge`] above the default [`TextureLimits`], or
/// [`ImageError::Decode`].
pub fn read_exr(path: &Path) -> Result<Planes, ImageError> {
    let bytes =
        read_whole(path, u64::MAX).map_err(|source| ImageError::Read { path: path.to_owned(), source })?;
    decode_exr(&bytes, &path.display().to_string())
}

/// Reads what [`encode_exr`] makes, as [`read_exr`] does. `name` says in messages what the bytes are, such as
/// a file name.
///
/// # Errors
/// [`ImageError::TooLarge`] or [`ImageError::Decode`], as [`read_exr`].
pub fn decode_exr(bytes: &[u8], name: &str) -> Result<Planes, ImageError> {
    Ok(decode_exr_piece(bytes, name, TextureLimits::default())?.0)
}

/// Width and height of a picture, and which of its pixels a part holds.
type Place = ([u32; 2], Region);

/// What the header of a file with a single part says: which rectangle of which picture it holds, if it lies
/// within that, and how it was made.
///
/// # Errors
/// What is wrong with the file.
pub(crate) fn decode_exr_header(bytes: &[u8]) -> Result<(Option<Place>, Metadata), String> {
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| format!("it does not read as OpenEXR ({error})"))?;
    let [header] = meta.headers.as_slice() else {
        return Err(format!("it has {} parts in place of one", meta.headers.len()));
    };
    let mut metadata = Metadata::default();
    let mut stored: Vec<_> = header.own_attributes.other.iter().collect();
    stored.sort_by_key(|(key, _)| key.to_string());
    for (key, value) in stored {
        if let (Some(key), AttributeValue::Text(text)) = (key.to_string().strip_prefix(PREFIX), value) {
            let text: Vec<u8> = text.as_slice().to_vec();
            metadata = metadata.with(key, String::from_utf8_lossy(&text));
        }
    }
    Ok((place_of(header), metadata))
}

/// Where the pixels of a part lie; none if beyond the picture.
fn place_of(header: &Header) -> Option<Place> {
    let IntegerBounds { position: origin, size: display } = header.shared_attributes.display_window;
    let position = header.own_attributes.layer_position;
    let side = |pixels: usize| u32::try_from(pixels).ok();
    let from = |at: i32, origin: i32| u32::try_from(i64::from(at) - i64::from(origin)).ok();
    let picture = [side(display.0)?, side(display.1)?];
    let region = Region {
        left: from(position.0, origin.0)?,
        top: from(position.1, origin.1)?,
        width: side(header.layer_size.0)?,
        height: side(header.layer_size.1)?,
    };
    region.is_within(picture).then_some((picture, region))
}

/// Reads what [`encode_exr_piece`] makes: the frame and its share of display-referred light.
pub(crate) fn decode_exr_piece(
    bytes: &[u8],
    name: &str,
    limits: TextureLimits,
) -> Result<(Planes, DisplayShare), ImageError> {
    let failed = |reason: String| ImageError::Decode {
        what: name.to_owned(),
        reason,
        formats: "OpenEXR with R, G and B",
    };
    check_claimed_size(bytes, name, limits)?;

    let layer = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
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
            Some(channel) => fill(&mut planes.colour, channel, |rgba, value| rgba[index] = value),
            None if name == "A" => {}
            None => return Err(failed(format!("the channel {name} is missing"))),
        }
    }
    if let Some(channel) = find("depth.Z") {
        fill(&mut planes.depth, channel, |depth, value| *depth = value);
    }
    for (axis, name) in ["motion.X", "motion.Y"].into_iter().enumerate() {
        if let Some(channel) = find(name) {
            fill(&mut planes.motion, channel, |motion, value| motion[axis] = value);
        }
    }
    if let Some(channel) = find("transparent.mask") {
        fill(&mut planes.transparent, channel, |is, value| *is = value > 0.5);
    }
    if find(LAYER_CHANNELS[0].name).is_some() {
        let layers = planes.layers.insert(Image::filled(width, height, PixelLayers::EMPTY)?);
        for LayerChannel { name, set, .. } in &LAYER_CHANNELS {
            if let Some(channel) = find(name) {
                fill(layers, channel, set);
            }
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
    let mut share = DisplayShare::Nothing;
    if let Some(channel) = find(SHARE_CHANNEL) {
        let mut shares = Image::filled(width, height, 0.0)?;
        fill(&mut shares, channel, |share, value| *share = value);
        share = DisplayShare::PerPixel(shares);
    }
    Ok((planes, share))
}

/// Sets something of each pixel to the values of a channel.
fn fill<T>(plane: &mut Image<T>, channel: &AnyChannel<FlatSamples>, set: impl Fn(&mut T, f32)) {
    let values = channel.sample_data.values_as_f32();
    plane.as_mut_slice().iter_mut().zip(values).for_each(|(pixel, value)| set(pixel, value));
}

/// Refuses a file whose header claims more pixels than are worth decoding.
pub(crate) fn check_claimed_size(bytes: &[u8], what: &str, limits: TextureLimits) -> Result<(), ImageError> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pixel;

    fn frame() -> Planes {
        let mut planes = Planes::new(5, 3).unwrap();
        for (x, y) in [(0, 0), (4, 0), (2, 2)] {
            let seed = (10 * y + x) as f32;
            planes.colour[(x, y)] = [0.1 + seed, 1e-9, 70_000.0, 0.5];
            planes.depth[(x, y)] = 3.0 + seed;
            planes.motion[(x, y)] = [-1.5, 0.25 * seed];
            planes.instance[(x, y)] = x;
            planes.primitive[(x, y)] = 3_000_000_000 + y;
            planes.transparent[(x, y)] = x > 0;
        }
        planes
    }

    /// The same with layers; no two numbers of a pixel are alike.
    fn layered_frame() -> Planes {
        let mut layers = Image::filled(5, 3, PixelLayers::EMPTY).unwrap();
        for (x, y) in [(0, 0), (4, 0), (2, 2)] {
            let seed = (10 * y + x) as f32;
            layers[(x, y)] = PixelLayers {
                coverage: 0.25,
                absorbed: [0.125, 0.375, 0.625],
                share: 0.75,
                is_front: x > 0,
                front_motion: [-2.5, 3.5 + seed],
                front_depth: 4.5,
                back_motion: [5.5, -6.5 - seed],
                back_depth: 7.5,
            };
        }
        Planes { layers: Some(layers), ..frame() }
    }

    fn header_of(bytes: &[u8]) -> Header {
        let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), true).unwrap();
        assert_eq!(meta.headers.len(), 1, "one part");
        meta.headers[0].clone()
    }

    fn metadata() -> Metadata {
        Metadata::default()
            .with("commit", "0c6fd8b")
            .with("seed", 7)
            .with("scene", "fenêtre")
            .with("method", "std")
    }

    #[test]
    fn a_frame_survives_a_round_trip_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.exr");
        for frame in [frame(), layered_frame()] {
            write_exr(&path, &frame, &metadata()).unwrap();
            assert_eq!(read_exr(&path).unwrap(), frame);
            assert_eq!(read_exr(&path).unwrap().pixel(1, 1), Pixel::EMPTY);
        }
    }

    #[test]
    fn other_readers_see_the_mask_and_the_layers_under_their_names() {
        let bytes = encode_exr(&layered_frame(), &metadata()).unwrap();
        let image = exr::image::read::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(&bytes))
            .unwrap();
        // Of the pixel in column 2 of row 2.
        let at = 2 * 5 + 2;
        for (name, value) in [
            ("transparent.mask", 1.0),
            ("front.coverage", 0.25),
            ("front.share", 0.75),
            ("front.shaded", 1.0),
            ("front.motion.X", -2.5),
            ("front.motion.Y", 25.5),
            ("front.depth.Z", 4.5),
            ("back.motion.X", 5.5),
            ("back.motion.Y", -28.5),
            ("back.depth.Z", 7.5),
        ] {
            let channel = image.layer_data.channel_data.list.iter().find(|channel| channel.name.eq(name));
            let channel = channel.unwrap_or_else(|| panic!("there is no {name}"));
            assert_eq!(channel.sample_data.values_as_f32().nth(at), Some(value), "{name}");
        }
        assert_eq!(header_of(&bytes).channels.list.len(), 10 + LAYER_CHANNELS.len());
    }

    #[test]
    fn other_readers_see_these_channels_types_and_attributes() {
        let bytes = encode_exr(&frame(), &metadata()).unwrap();
        let header = header_of(&bytes);
        let channels: Vec<_> = header
            .channels
            .list
            .iter()
            .map(|channel| (channel.name.to_string(), format!("{:?}", channel.sample_type)))
            .collect();
        let names = [
            "A",
            "B",
            "G",
            "R",
            "depth.Z",
            "instance.ID",
            "motion.X",
            "motion.Y",
            "primitive.ID",
            "transparent.mask",
        ];
        let expected =
            names.map(|name| (name.to_owned(), if name.ends_with("ID") { "U32" } else { "F32" }.to_owned()));
        assert_eq!(channels, expected);
        assert_eq!(header.own_attributes.layer_name, None);
        let attribute = |key: &str| match header.own_attributes.other.get(&Text::from(key)) {
            Some(AttributeValue::Text(text)) => String::from_utf8(text.as_slice().to_vec()).unwrap(),
            other => panic!("{key}: {other:?}"),
        };
        assert_eq!(attribute("sheer.commit"), "0c6fd8b");
        assert_eq!(attribute("sheer.seed"), "7");
        assert_eq!(attribute("sheer.scene"), "fenêtre");
        assert_eq!(attribute("sheer.method"), "std");
    }

    #[test]
    fn the_same_frame_gives_the_same_bytes() {
        let first = encode_exr(&frame(), &metadata()).unwrap();
        assert!((0..20).all(|_| encode_exr(&frame(), &metadata()).unwrap() == first));
        let position = |key: &str| first.windows(key.len()).position(|window| window == key.as_bytes());
        assert!(position("sheer.commit") < position("sheer.method") && position("sheer.seed").is_some());
    }

    #[test]
    fn unfit_frames_and_files_are_errors() {
        let mut uneven = frame();
        uneven.depth = Image::filled(5, 2, 0.0).unwrap();
        assert!(matches!(encode_exr(&uneven, &metadata()), Err(ImageError::SizesDiffer { .. })));

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("broken.exr");
        let whole = encode_exr(&frame(), &metadata()).unwrap();
        for bytes in [&whole[..whole.len() / 2], &whole[..30], b"no image"] {
            std::fs::write(&path, bytes).unwrap();
            let message = read_exr(&path).unwrap_err().to_string();
            assert!(message.contains("broken.exr"), "{message}");
        }
        assert!(read_exr(&folder.path().join("absent.exr")).unwrap_err().to_string().contains("absent.exr"));
    }

    #[test]
    fn a_file_without_colour_says_what_is_missing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grey.exr");
        let channel = AnyChannel::new("Y", FlatSamples::F32(vec![0.5; 4]));
        let channels = AnyChannels::sort([channel].into_iter().collect());
        let layer = Layer::new(Vec2(2, 2), LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
        exr::image::Image::from_layer(layer).write().to_file(&path).unwrap();
        let message = read_exr(&path).unwrap_err().to_string();
        assert!(message.contains("channel R is missing"), "{message}");
    }

    #[test]
    fn a_file_that_claims_too_many_pixels_is_refused() {
        let mut bytes = encode_exr(&frame(), &metadata()).unwrap();
        // The last corner of the data window, inclusive, follows the first one.
        let key = b"dataWindow\0box2i\0";
        let at = bytes.windows(key.len()).position(|window| window == key).unwrap() + key.len() + 4 + 8;
        bytes[at..at + 8].copy_from_slice(&[0x3f, 0x42, 0x0f, 0, 0x3f, 0x42, 0x0f, 0]);
        assert!(matches!(
            check_claimed_size(&bytes, "huge.exr", TextureLimits::default()),
            Err(ImageError::TooLarge { width: 1_000_000, height: 1_000_000, .. })
        ));
    }
}
