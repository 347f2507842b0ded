//! Putting pieces of a picture together again.
//!
//! Crops are copied, so that the picture is the one that would have been rendered whole, to the bit; means of
//! sample ranges are averaged by their numbers of samples in 64 bits, which is nearer to the mean of all
//! samples than the running mean of a whole run. Headers are read first: what does not belong together is
//! refused before the first pixel is decoded, and one piece at a time is in memory.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
    path::{Path, PathBuf},
};

use crate::{
    decode::TextureLimits,
    error::ImageError,
    exr_file::{decode_exr_header, decode_exr_piece},
    metadata::Metadata,
    piece::{Piece, SampleRange},
    planes::Planes,
    raster::Image,
    region::Region,
    tone::DisplayShare,
    whole_file::read_whole,
};

/// Why pieces do not make a picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// A file cannot be read, or the picture does not fit the memory.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// There is nothing to put together.
    #[error("there are no pieces to put together")]
    Nothing,
    /// A file that says nothing of a picture it would be a part of.
    #[error("{} is no piece of a picture: {problem}; pieces are .exr files of `sheer render` with --crop or --sample-range", path.display())]
    NoPiece {
        /// The file.
        path: PathBuf,
        /// What is missing or wrong.
        problem: String,
    },
    /// Two pieces were made in different ways.
    #[error("{} does not belong to {}: its {key} is {found}, that of the other {expected}", path.display(), first.display())]
    Foreign {
        /// The piece that differs.
        path: PathBuf,
        /// The one that it is held against.
        first: PathBuf,
        /// What differs: a key of the metadata.
        key: String,
        /// What the piece has of it.
        found: String,
        /// What the other one has.
        expected: String,
    },
    /// Two pieces have pixels in common.
    #[error("{} and {} overlap: both have the pixels {region}", first.display(), second.display())]
    Overlap {
        /// A piece.
        first: PathBuf,
        /// The other.
        second: PathBuf,
        /// What both have.
        region: Region,
    },
    /// Two pieces have samples in common.
    #[error("{} and {} overlap: both have the samples {}..{} of the pixels {region}", first.display(), second.display(), samples.start, samples.end)]
    SamplesOverlap {
        /// A piece.
        first: PathBuf,
        /// The other.
        second: PathBuf,
        /// The pixels of both.
        region: Region,
        /// What both have.
        samples: Range<u32>,
    },
    /// A frame of a sequence whose number does not follow from those before it.
    #[error("{} does not belong there: it is frame {found}, and after those before it comes {expected}", path.display())]
    OutOfOrder {
        /// A piece of the frame.
        path: PathBuf,
        /// What it says of its number.
        found: String,
        /// The number that it should have.
        expected: u64,
    },
    /// No piece has some of the pixels.
    #[error("no piece has the pixels {region} of the picture of {}x{}: render them with --crop {region}", picture[0], picture[1])]
    Gap {
        /// Some of what is missing.
        region: Region,
        /// Width and height of the picture, pixels.
        picture: [u32; 2],
    },
    /// No piece has some of the samples.
    #[error("no piece has the samples {}..{} of {of} of the pixels {region}: render them with --sample-range {}..{}", samples.start, samples.end, samples.start, samples.end)]
    MissingSamples {
        /// The pixels.
        region: Region,
        /// The first ones that are missing.
        samples: Range<u32>,
        /// How many there are in all.
        of: u32,
    },
}

/// A picture of pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// The picture; everything but the colour is that of the last sample.
    pub planes: Planes,
    /// How much of each pixel is display-referred, as far as the pieces say.
    pub share: DisplayShare,
    /// How it was made.
    pub metadata: Metadata,
}

/// Puts pieces of one picture together, given in any order: crops that cover it, sample ranges that make up
/// the mean of each, or both. Files are read within `limits`, one at a time.
///
/// # Errors
/// [`MergeError`] names the pieces that do not belong together, and what is missing.
pub fn merge(paths: &[PathBuf], limits: TextureLimits) -> Result<Merged, MergeError> {
    let pieces = Header::read_all(paths, limits)?;
    let (first, groups) = sorted(&pieces)?;
    let picture = first.piece.picture;
    let mut whole: Option<(Planes, DisplayShare)> = None;
    for Group { region, members } in groups {
        let (part, part_share) = mean(&members, limits)?;
        if region == Region::whole(picture) {
            whole = Some((part, part_share));
            break;
        }
        let [width, height] = picture;
        let (planes, share) = match &mut whole {
            Some(whole) => whole,
            None => {
                let blank = if part.layers.is_some() { Planes::with_layers } else { Planes::new };
                whole.insert((blank(width, height)?, DisplayShare::Nothing))
            }
        };
        planes.paste(region, &part);
        if let DisplayShare::PerPixel(part) = part_share {
            if *share == DisplayShare::Nothing {
                *share = DisplayShare::PerPixel(Image::filled(width, height, 0.0)?);
            }
            if let DisplayShare::PerPixel(share) = share {
                share.paste(region, &part);
            }
        }
    }
    let (planes, share) = whole.ok_or(MergeError::Nothing)?;
    let metadata = first.metadata.clone().without(Piece::CROP).without(Piece::SAMPLE_RANGE);
    Ok(Merged { planes, share, metadata })
}

/// Finds out whether the pieces of each frame of a sequence make a picture, and whether these belong to one
/// another: made in the same way, of frames that follow one another. No pixel is decoded.
///
/// # Errors
/// [`MergeError`] names the piece that does not belong to the others, and what is missing.
pub fn check_frames(frames: &[Vec<PathBuf>], limits: TextureLimits) -> Result<(), MergeError> {
    let mut first: Option<Header<'_>> = None;
    for (index, paths) in (0..).zip(frames) {
        let mut pieces = Header::read_all(paths, limits)?;
        sorted(&pieces)?;
        let piece = pieces.swap_remove(0);
        match &first {
            Some(first) => piece.follows(first, index)?,
            None => first = Some(piece),
        }
    }
    Ok(())
}

/// The pieces of a picture by their regions, and the one that all others are held against.
fn sorted<'p, 'a>(pieces: &'p [Header<'a>]) -> Result<(&'p Header<'a>, Vec<Group<'p>>), MergeError> {
    let first = pieces.first().ok_or(MergeError::Nothing)?;
    pieces.iter().try_for_each(|piece| piece.belongs_to(first))?;
    Ok((first, regions(pieces, first.piece.picture)?))
}

/// What a file says of itself before its pixels are decoded.
struct Header<'a> {
    path: &'a Path,
    piece: Piece,
    metadata: Metadata,
}

impl<'a> Header<'a> {
    /// Keys in which the pieces of a picture differ: where they lie, and as what the scene, which its hash
    /// tells, was found on the machine that rendered them.
    const OWN_KEYS: [&'static str; 4] = [Piece::CROP, Piece::SAMPLE_RANGE, "scene", "environment"];
    /// The key that is looked at first: all else of another scene may be the same.
    const SCENE_HASH: &'static str = "scene_hash";
    /// The number of a frame.
    const FRAME: &'static str = "frame";
    /// Keys in which the frames of a sequence differ: when they are, from where they are seen, and what has
    /// been added up to them.
    const FRAME_KEYS: [&'static str; 7] =
        [Self::FRAME, "time_secs", "pose", "history", "samples", "jitter.X", "jitter.Y"];

    fn read_all(paths: &'a [PathBuf], limits: TextureLimits) -> Result<Vec<Self>, MergeError> {
        paths.iter().map(|path| Self::read(path, limits)).collect()
    }

    fn read(path: &'a Path, limits: TextureLimits) -> Result<Self, MergeError> {
        let no_piece = |problem: String| MergeError::NoPiece { path: path.to_owned(), problem };
        let bytes = read_file(path, limits)?;
        let (place, metadata) = decode_exr_header(&bytes).map_err(no_piece)?;
        let Some(size) = metadata.get(Piece::SIZE) else {
            return Err(no_piece("its header has no sheer.size".to_owned()));
        };
        let place = place.filter(|&(picture, _)| Piece::size_text(picture) == size);
        let Some((picture, region)) = place else {
            return Err(no_piece(format!("its windows are not those of a picture of {size}")));
        };
        let samples = metadata.get(Piece::SAMPLE_RANGE).map(str::parse::<SampleRange>).transpose();
        let piece = Piece { picture, region, samples: samples.map_err(no_piece)? };
        Ok(Self { path, piece, metadata })
    }

    /// Whether it is a piece of the same picture.
    fn belongs_to(&self, first: &Self) -> Result<(), MergeError> {
        self.agrees_with(first, &[])
    }

    /// Whether it is a piece of the frame that comes so many after the other's.
    fn follows(&self, first: &Self, frames: u64) -> Result<(), MergeError> {
        self.agrees_with(first, &Self::FRAME_KEYS)?;
        let number = |header: &Self| header.metadata.get(Self::FRAME)?.parse::<u64>().ok();
        match number(first).map(|first| first + frames) {
            Some(expected) if number(self) != Some(expected) => {
                let found = self.said(Self::FRAME);
                Err(MergeError::OutOfOrder { path: self.path.to_owned(), found, expected })
            }
            _ => Ok(()),
        }
    }

    /// Whether it was made as another was, but for what these keys tell.
    fn agrees_with(&self, first: &Self, but_for: &[&str]) -> Result<(), MergeError> {
        let keys = self.metadata.entries().chain(first.metadata.entries()).map(|(key, _)| key);
        let is_common = |key: &&str| !Self::OWN_KEYS.contains(key) && !but_for.contains(key);
        let keys: BTreeSet<&str> = keys.filter(is_common).collect();
        let differing = |key: &&str| self.metadata.get(key) != first.metadata.get(key);
        let Some(key) = [Self::SCENE_HASH].into_iter().chain(keys).find(differing) else {
            return Ok(());
        };
        Err(MergeError::Foreign {
            path: self.path.to_owned(),
            first: first.path.to_owned(),
            key: key.to_owned(),
            found: self.said(key),
            expected: first.said(key),
        })
    }

    /// What it says under a key.
    fn said(&self, key: &str) -> String {
        self.metadata.get(key).unwrap_or("not told").to_owned()
    }

    /// Its samples, and how many there are in all; it has all of them if it does not say.
    fn samples(&self) -> SampleRange {
        self.piece.samples.unwrap_or(SampleRange { first: 0, end: 1, of: 1 })
    }
}

fn read_file(path: &Path, limits: TextureLimits) -> Result<Vec<u8>, ImageError> {
    read_whole(path, limits.max_bytes).map_err(|source| ImageError::Read { path: path.to_owned(), source })
}

/// The pieces of a region.
struct Group<'p> {
    region: Region,
    /// At least one, in the order of their samples.
    members: Vec<&'p Header<'p>>,
}

/// The pieces by their regions, which tile the picture, with samples that make up the mean of each.
fn regions<'p>(pieces: &'p [Header<'p>], picture: [u32; 2]) -> Result<Vec<Group<'p>>, MergeError> {
    let mut groups: BTreeMap<[u32; 4], Group<'_>> = BTreeMap::new();
    for piece in pieces {
        let region @ Region { left, top, width, height } = piece.piece.region;
        let group = groups.entry([top, left, height, width]);
        group.or_insert(Group { region, members: Vec::new() }).members.push(piece);
    }
    let mut groups: Vec<Group<'_>> = groups.into_values().collect();
    for (at, Group { region, members }) in groups.iter().enumerate() {
        for other in &groups[at + 1..] {
            if let Some(region) = region.overlap(&other.region) {
                let (first, second) = (members[0].path.to_owned(), other.members[0].path.to_owned());
                return Err(MergeError::Overlap { first, second, region });
            }
        }
    }
    let regions: Vec<Region> = groups.iter().map(|group| group.region).collect();
    let covered: u64 = regions.iter().map(Region::pixel_count).sum();
    if covered < Region::whole(picture).pixel_count() {
        return Err(MergeError::Gap { region: first_gap(&regions, picture), picture });
    }
    for Group { region, members } in &mut groups {
        members.sort_by_key(|piece| (piece.samples().first, piece.samples().end));
        check_samples(*region, members)?;
    }
    Ok(groups)
}

/// Checks that the pieces of a region, in the order of their samples, make up its mean.
fn check_samples(region: Region, members: &[&Header<'_>]) -> Result<(), MergeError> {
    let of = members[0].samples().of;
    let mut end = 0;
    for (at, piece) in members.iter().enumerate() {
        let samples = piece.samples();
        if samples.of != of {
            return Err(MergeError::Foreign {
                path: piece.path.to_owned(),
                first: members[0].path.to_owned(),
                key: "number of samples".to_owned(),
                found: samples.of.to_string(),
                expected: of.to_string(),
            });
        }
        if samples.first < end {
            let (first, second) = (members[at - 1].path.to_owned(), piece.path.to_owned());
            if piece.piece.samples.is_none() {
                return Err(MergeError::Overlap { first, second, region });
            }
            let samples = samples.first..samples.end.min(end);
            return Err(MergeError::SamplesOverlap { first, second, region, samples });
        }
        if samples.first > end {
            return Err(MergeError::MissingSamples { region, samples: end..samples.first, of });
        }
        end = samples.end;
    }
    if end < of { Err(MergeError::MissingSamples { region, samples: end..of, of }) } else { Ok(()) }
}

/// A rectangle that none of the regions covers: the first from the top, as wide and then as high as it can
/// be. There is one.
fn first_gap(regions: &[Region], [width, height]: [u32; 2]) -> Region {
    // Between two edges that follow one another all is covered or nothing.
    let edges = |of: &dyn Fn(&Region) -> [u32; 2], end: u32| -> Vec<u32> {
        let inner = regions.iter().flat_map(of).chain([0, end]);
        inner.collect::<BTreeSet<u32>>().into_iter().collect()
    };
    let columns = edges(&|region| [region.left, region.right()], width);
    let rows = edges(&|region| [region.top, region.bottom()], height);
    let is_open = |x: u32, y: u32| {
        let pixel = Region { left: x, top: y, width: 1, height: 1 };
        regions.iter().all(|region| region.overlap(&pixel).is_none())
    };
    for &[top, below] in rows.array_windows() {
        let open = |pair: &&[u32; 2]| is_open(pair[0], top);
        let mut gaps = columns.array_windows().skip_while(|pair| !open(pair)).take_while(open);
        if let Some(&[left, first_right]) = gaps.next() {
            let right = gaps.last().map_or(first_right, |&[_, right]| right);
            let inside = || columns.iter().copied().filter(|&x| (left..right).contains(&x));
            let further = rows.array_windows().skip_while(|&&[row, _]| row < below);
            let bottom = further
                .take_while(|&&[row, _]| inside().all(|x| is_open(x, row)))
                .last()
                .map_or(below, |&[_, bottom]| bottom);
            return Region { left, top, width: right - left, height: bottom - top };
        }
    }
    Region::whole([width, height])
}

/// The mean of the pieces of a region, weighed by their numbers of samples; a single piece as it is.
fn mean(members: &[&Header<'_>], limits: TextureLimits) -> Result<(Planes, DisplayShare), MergeError> {
    let read = |header: &Header<'_>| {
        decode_exr_piece(&read_file(header.path, limits)?, &header.path.display().to_string(), limits)
    };
    let (last, others) = members.split_last().expect("a region is there for the sake of a piece");
    let (mut planes, share) = read(last)?;
    if others.is_empty() {
        return Ok((planes, share));
    }
    let weight = |header: &Header<'_>| f64::from(header.samples().count());
    let all = f64::from(last.samples().of);
    let mut sums = planes.colour.map(|rgba| rgba.map(|value| f64::from(value) * weight(last)));
    for header in others {
        let (part, _) = read(header)?;
        for (sums, rgba) in sums.as_mut_slice().iter_mut().zip(part.colour.as_slice()) {
            for (sum, &value) in sums.iter_mut().zip(rgba) {
                *sum += f64::from(value) * weight(header);
            }
        }
    }
    planes.colour = sums.map(|sums| sums.map(|sum| (sum / all) as f32));
    Ok((planes, share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PixelLayers, Tone, write_frame};

    const SIZE: [u32; 2] = [12, 7];

    fn frame(brightness: f32) -> Planes {
        let mut planes = Planes::with_layers(SIZE[0], SIZE[1]).unwrap();
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let value = brightness + (y * SIZE[0] + x) as f32;
                planes.colour[(x, y)] = [value, 0.1 * value, 1e-3 * value, 0.5];
                planes.depth[(x, y)] = value;
                planes.motion[(x, y)] = [-value, 0.5];
                planes.instance[(x, y)] = y;
                planes.primitive[(x, y)] = x;
                planes.transparent[(x, y)] = (x + y) % 3 == 0;
                planes.layers.as_mut().unwrap()[(x, y)] =
                    PixelLayers { coverage: 0.25 / value.max(1.0), ..PixelLayers::EMPTY };
            }
        }
        planes
    }

    fn share() -> Image<f32> {
        Image::from_fn(SIZE[0], SIZE[1], |x, y| (x + y) as f32 / 20.0).unwrap()
    }

    fn metadata() -> Metadata {
        Metadata::default().with("scene", "here/pane.glb").with("scene_hash", "12ab").with("seed", 3)
    }

    fn region(left: u32, top: u32, width: u32, height: u32) -> Region {
        Region { left, top, width, height }
    }

    /// Four crops of different sizes that cover the picture.
    fn crops() -> [Region; 4] {
        [region(0, 0, 5, 3), region(5, 0, 7, 4), region(0, 3, 5, 4), region(5, 4, 7, 3)]
    }

    struct Folder(tempfile::TempDir);

    impl Folder {
        fn new() -> Self {
            Self(tempfile::tempdir().unwrap())
        }

        fn write(&self, name: &str, planes: &Planes, piece: Piece, metadata: &Metadata) -> PathBuf {
            let path = self.0.path().join(name);
            let share = DisplayShare::PerPixel(share().cut(piece.region).unwrap());
            let planes = planes.cut(piece.region).unwrap();
            write_frame(&path, &planes, &piece, Tone::default(), &share, metadata).unwrap();
            path
        }

        fn crop(&self, region: Region) -> PathBuf {
            let piece = Piece { region, ..Piece::whole(SIZE) };
            self.write(&format!("{region}.exr"), &frame(1.0), piece, &metadata())
        }

        fn samples(&self, region: Region, first: u32, end: u32) -> PathBuf {
            let samples = Some(SampleRange { first, end, of: 10 });
            let piece = Piece { picture: SIZE, region, samples };
            self.write(&format!("{region}-{first}-{end}.exr"), &frame(first as f32), piece, &metadata())
        }

        fn message(&self, paths: &[PathBuf]) -> String {
            let message = merge(paths, TextureLimits::default()).unwrap_err().to_string();
            message.replace(&format!("{}/", self.0.path().display()), "")
        }
    }

    #[test]
    fn crops_make_the_picture_to_the_bit_in_any_order() {
        let folder = Folder::new();
        let mut paths = crops().map(|region| folder.crop(region));
        paths.rotate_left(3);
        let merged = merge(&paths, TextureLimits::default()).unwrap();
        assert_eq!(merged.planes, frame(1.0));
        assert_eq!(merged.share, DisplayShare::PerPixel(share()));
        assert_eq!(merged.metadata.get("crop"), None);

        // The file is the one that would have been written whole.
        let whole = Piece::whole(SIZE);
        let path = folder.0.path().join("merged.exr");
        let Merged { planes, share, metadata: said } = merged;
        write_frame(&path, &planes, &whole, Tone::default(), &share, &said).unwrap();
        let expected = folder.write("whole.exr", &frame(1.0), whole, &metadata());
        assert_eq!(std::fs::read(path).unwrap(), std::fs::read(&expected).unwrap());
        let alone = merge(&[expected], TextureLimits::default()).unwrap();
        assert_eq!((alone.planes, alone.share), (planes, DisplayShare::Nothing));
    }

    #[test]
    fn sample_ranges_weigh_as_many_samples_as_they_have() {
        let folder = Folder::new();
        let all = Region::whole(SIZE);
        let paths = [(3, 10), (0, 2), (2, 3)].map(|(first, end)| folder.samples(all, first, end));
        let Merged { planes, .. } = merge(&paths, TextureLimits::default()).unwrap();
        // Two of 0, one of 2, seven of 3, which is the last.
        let last = frame(3.0);
        for (rgba, last) in planes.colour.as_slice().iter().zip(last.colour.as_slice()) {
            assert!((rgba[0] - (last[0] - 3.0 + 2.3)).abs() < 1e-5, "{rgba:?} {last:?}");
        }
        assert_eq!(Planes { colour: last.colour.clone(), ..planes }, last);
        // Crops, each of samples of its own.
        let mut paths: Vec<PathBuf> =
            crops()[1..].iter().map(|&region| folder.samples(region, 0, 10)).collect();
        paths.extend([(0, 4), (4, 10)].map(|(first, end)| folder.samples(crops()[0], first, end)));
        let Merged { planes, .. } = merge(&paths, TextureLimits::default()).unwrap();
        assert!((planes.colour[(0, 0)][0] - 2.4).abs() < 1e-6, "{:?}", planes.colour[(0, 0)]);
        assert_eq!(planes.colour[(11, 6)], frame(0.0).colour[(11, 6)]);
    }

    #[test]
    fn overlaps_and_gaps_are_named() {
        let folder = Folder::new();
        let [a, b, c, d] = crops().map(|region| folder.crop(region));
        let message = folder.message(&[a.clone(), b.clone(), d.clone()]);
        assert!(message.contains("no piece has the pixels 0,3,5,4 of the picture of 12x7"), "{message}");
        assert!(message.contains("--crop 0,3,5,4"), "{message}");
        let wide = folder.crop(region(4, 0, 8, 4));
        let message = folder.message(&[a.clone(), wide, c.clone(), d.clone()]);
        assert!(
            message.contains("0,0,5,3.exr and 4,0,8,4.exr overlap: both have the pixels 4,0,1,3"),
            "{message}"
        );
        let message = folder.message(&[a.clone(), b, c, d, a]);
        assert!(message.contains("both have the pixels 0,0,5,3"), "{message}");
        assert!(matches!(merge(&[], TextureLimits::default()), Err(MergeError::Nothing)));

        let all = Region::whole(SIZE);
        let [early, late, middle] =
            [(0, 4), (6, 10), (3, 6)].map(|(first, end)| folder.samples(all, first, end));
        let message = folder.message(&[late.clone(), early.clone()]);
        assert!(
            message.contains("no piece has the samples 4..6 of 10")
                && message.contains("--sample-range 4..6")
        );
        let message = folder.message(&[late.clone(), early.clone(), middle]);
        assert!(message.contains("both have the samples 3..4 of the pixels 0,0,12,7"), "{message}");
        assert!(folder.message(&[early]).contains("the samples 4..10 of 10"));
        assert!(folder.message(&[late]).contains("the samples 0..6 of 10"));
    }

    #[test]
    fn the_first_gap_is_as_large_as_it_can_be() {
        let frame = [region(0, 0, 10, 2), region(0, 2, 3, 6), region(7, 2, 3, 3), region(0, 8, 10, 2)];
        assert_eq!(first_gap(&frame, [10, 10]), region(3, 2, 4, 6));
        assert_eq!(first_gap(&[], [10, 10]), Region::whole([10, 10]));
        assert_eq!(first_gap(&[region(0, 0, 10, 9)], [10, 10]), region(0, 9, 10, 1));
    }

    #[test]
    fn frames_of_a_sequence_belong_together_and_follow_one_another() {
        let folder = Folder::new();
        let [left, right] = [region(0, 0, 6, 7), region(6, 0, 6, 7)];
        let frame_of = |number: u32, seed: u32| {
            let said = metadata().with("frame", number).with("time_secs", 0.5 * number as f32);
            let said = said.with("seed", seed);
            [left, right].map(|region| {
                let piece = Piece { region, ..Piece::whole(SIZE) };
                folder.write(&format!("{region}-{number}-{seed}.exr"), &frame(1.0), piece, &said)
            })
        };
        let [a, b, c, other] = [(4, 0), (5, 0), (6, 0), (6, 1)].map(|(number, seed)| frame_of(number, seed));
        let check = |frames: &[&[PathBuf; 2]]| {
            let frames: Vec<Vec<PathBuf>> = frames.iter().map(|frame| frame.to_vec()).collect();
            check_frames(&frames, TextureLimits::default())
                .map_err(|error| error.to_string().replace(&format!("{}/", folder.0.path().display()), ""))
        };
        assert_eq!(check(&[&a, &b, &c]), Ok(()));
        let message = check(&[&a, &c]).unwrap_err();
        assert!(message.starts_with("0,0,6,7-6-0.exr does not belong there: it is frame 6"), "{message}");
        assert!(message.ends_with("comes 5"), "{message}");
        let message = check(&[&a, &b, &other]).unwrap_err();
        assert!(
            message.starts_with("0,0,6,7-6-1.exr does not belong to 0,0,6,7-4-0.exr: its seed is 1"),
            "{message}"
        );
        let mixed = [b[0].clone(), c[1].clone()];
        let message = check(&[&a, &mixed]).unwrap_err();
        assert!(
            message.contains("6,0,6,7-6-0.exr does not belong to 0,0,6,7-5-0.exr: its frame"),
            "{message}"
        );
        let half = [b[0].clone(), b[0].clone()];
        assert!(check(&[&a, &half]).unwrap_err().contains("no piece has the pixels 6,0,6,7"));
    }

    #[test]
    fn what_does_not_belong_together_is_refused() {
        let folder = Folder::new();
        let [first, second] = [region(0, 0, 6, 7), region(6, 0, 6, 7)];
        let good = folder.crop(first);
        let other = |name: &str, metadata: &Metadata| {
            let piece = Piece { region: second, ..Piece::whole(SIZE) };
            folder.message(&[good.clone(), folder.write(name, &frame(1.0), piece, metadata)])
        };
        let message = other("seed.exr", &metadata().with("seed", 4));
        assert!(message.starts_with("seed.exr does not belong to 0,0,6,7.exr: its seed is 4"), "{message}");
        assert!(message.contains("that of the other 3"), "{message}");
        let message = other("scene.exr", &metadata().with("scene_hash", "77").with("aa", "none"));
        assert!(message.contains("its scene_hash is 77, that of the other 12ab"), "{message}");
        let message = other("unsaid.exr", &metadata().without("seed"));
        assert!(message.contains("its seed is not told"), "{message}");
        // The same file may lie elsewhere on another machine.
        let piece = Piece { region: second, ..Piece::whole(SIZE) };
        let elsewhere = metadata().with("scene", "there/pane.glb");
        let path = folder.write("elsewhere.exr", &frame(1.0), piece, &elsewhere);
        assert!(merge(&[good.clone(), path], TextureLimits::default()).is_ok());

        let larger = Piece { picture: [24, 7], region: second, samples: None };
        let path = folder.write("larger.exr", &frame(1.0), larger, &metadata());
        let message = folder.message(&[good.clone(), path]);
        assert!(message.contains("its size is 24x7, that of the other 12x7"), "{message}");
        let plain = folder.0.path().join("plain.exr");
        crate::write_exr(&plain, &frame(1.0), &Metadata::default()).unwrap();
        let message = folder.message(&[good.clone(), plain]);
        assert!(message.starts_with("plain.exr is no piece of a picture: its header has no"), "{message}");
        std::fs::write(folder.0.path().join("a.png"), "no picture").unwrap();
        let message = folder.message(&[good.clone(), folder.0.path().join("a.png")]);
        assert!(message.starts_with("a.png is no piece of a picture"), "{message}");
        let message = folder.message(&[good, folder.0.path().join("absent.exr")]);
        assert!(message.contains("cannot read absent.exr"), "{message}");
    }
}
