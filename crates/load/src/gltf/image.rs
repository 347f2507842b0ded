//! Images: where their bytes are, and decoding them side by side, each once.

use std::{
    borrow::Cow,
    cell::RefCell,
    collections::{BTreeMap, BTreeSet, HashMap},
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use rayon::prelude::*;
use sheer_core::text::MemorySize;
use sheer_image::{Image, ImageError, TextureLimits, decode_texture, texture_size};
use sheer_scene::cost::{DECODING_BYTES, TEXEL_BYTES};

use super::{document::Document, limits::IMAGE_BYTES, schema::Index, texels::Source};
use crate::LoadError;

/// What becomes of textures whose image is lost.
const WITHOUT: &str = "drawn without it";
const REPLACED: &str = "another image of its texture is drawn";

/// The decoded images of a file, and what they take.
pub(super) struct Images {
    decoded: BTreeMap<Index, Arc<Image<[u8; 4]>>>,
    used_bytes: u64,
    /// What they may take together.
    most_bytes: u64,
    /// Means of the channels of images that were asked for, and the least alpha.
    statistics: RefCell<HashMap<*const Image<[u8; 4]>, Statistics>>,
}

/// What materials ask of all texels of an image.
#[derive(Clone, Copy)]
pub(super) struct Statistics {
    /// Of each channel, 0 to 1.
    pub means: [f32; 4],
    /// All texels are opaque.
    pub is_opaque: bool,
}

/// Where the bytes of an image are: images at one place are one image.
#[derive(PartialEq, Eq, Hash)]
enum Place<'d> {
    File(PathBuf),
    Inline(&'d str),
    /// Buffer, offset and length.
    Buffer([usize; 3]),
    /// A buffer view that is compressed.
    View(Index),
}

/// An image still to be decoded.
struct Task<'d> {
    index: Index,
    bytes: Cow<'d, [u8]>,
}

/// Why there is no image: what is wrong and what to do.
enum Fault {
    /// The file is damaged or of no known format.
    Broken(String),
    /// It takes too much memory.
    Limit(String),
}

fn place(index: Index) -> String {
    format!("images[{index}]")
}

impl Images {
    /// Decodes images by their indices, all of which exist. Each of `wanted` is the images that a texture
    /// offers, the best first: another one is decoded where those before it are broken or missing.
    pub(super) fn decode(document: &Document<'_>, wanted: &[&[Index]]) -> Result<Self, LoadError> {
        let mut images = Self {
            decoded: BTreeMap::new(),
            used_bytes: 0,
            most_bytes: IMAGE_BYTES.min(document.memory_left()),
            statistics: RefCell::default(),
        };
        let mut tried = BTreeSet::new();
        for choice in 0.. {
            // Of each texture that has no image yet the next one.
            let mut next: BTreeMap<Index, &'static str> = BTreeMap::new();
            for offered in wanted.iter().filter(|offered| images.first_of(offered).is_none()) {
                if let Some(&index) = offered.get(choice) {
                    let outcome = if offered.len() > choice + 1 { REPLACED } else { WITHOUT };
                    // What is said of an image is said for all.
                    if tried.insert(index) {
                        next.insert(index, outcome);
                    }
                }
            }
            let is_last = wanted.iter().all(|offered| offered.len() <= choice + 1);
            images.add(document, &next)?;
            if is_last {
                break;
            }
        }
        Ok(images)
    }

    /// The first of some images that is there.
    pub(super) fn first_of(&self, offered: &[Index]) -> Option<Index> {
        offered.iter().copied().find(|index| self.decoded.contains_key(index))
    }

    /// Decodes images, with what becomes of those that are broken or missing.
    fn add(
        &mut self,
        document: &Document<'_>,
        wanted: &BTreeMap<Index, &'static str>,
    ) -> Result<(), LoadError> {
        // The first image at each place stands for all that are there.
        let mut first_at = HashMap::new();
        let mut stands_for = Vec::with_capacity(wanted.len());
        for &index in wanted.keys() {
            let first = match place_of(document, index) {
                Some(place) => *first_at.entry(place).or_insert(index),
                None => index,
            };
            stands_for.push((index, first));
        }
        let mut tasks = Vec::new();
        for &(index, _) in stands_for.iter().filter(|(index, first)| index == first) {
            tasks.extend(document.salvage(find(document, index), wanted[&index])?);
        }
        let limits = limits(document);
        check_sizes(document, &tasks, limits)?;

        // Each decoder is bounded; together they are counted, so that many small files cannot add up to a
        // large one.
        let used_bytes = AtomicU64::new(self.used_bytes);
        let decode_one = |task: &Task<'_>| -> Result<Image<[u8; 4]>, Fault> {
            check_budget(used_bytes.load(Ordering::Relaxed), self.most_bytes).map_err(Fault::Limit)?;
            let image = decode_any(&task.bytes, limits)?;
            used_bytes.fetch_add(size_of_val(image.as_slice()) as u64, Ordering::Relaxed);
            Ok(image)
        };
        let results: Vec<Result<_, Fault>> = tasks.par_iter().map(decode_one).collect();
        for (task, image) in tasks.iter().zip(results) {
            let image = image.map_err(|fault| match fault {
                Fault::Broken(problem) => document.fault(place(task.index), problem),
                Fault::Limit(problem) => document.limit(place(task.index), problem),
            });
            if let Some(image) = document.salvage(image, wanted[&task.index])? {
                self.decoded.insert(task.index, Arc::new(image));
            }
        }
        for (index, first) in stands_for {
            if let Some(image) = self.decoded.get(&first).cloned() {
                self.decoded.insert(index, image);
            }
        }
        self.used_bytes = used_bytes.into_inner();
        Ok(())
    }

    /// What is asked of all texels of an image, worked out once.
    pub(super) fn statistics(&self, image: &Arc<Image<[u8; 4]>>) -> Statistics {
        let mut known = self.statistics.borrow_mut();
        *known.entry(Arc::as_ptr(image)).or_insert_with(|| {
            let texels = image.as_slice();
            let add = |sums: [u64; 4], texel: &[u8; 4]| {
                std::array::from_fn(|channel| sums[channel] + u64::from(texel[channel]))
            };
            let sums = texels.iter().fold([0; 4], add);
            Statistics {
                means: sums.map(|sum| sum as f32 / 255.0 / texels.len() as f32),
                is_opaque: sums[3] == 255 * texels.len() as u64,
            }
        })
    }

    /// Whether the image behind a texture is there.
    pub(super) fn has(&self, source: &Source) -> bool {
        match source {
            Source::File(offered) => self.first_of(offered).is_some(),
            Source::Computed(_) => true,
        }
    }

    /// The image behind a texture, which is there.
    pub(super) fn of<'s>(&'s self, source: &'s Source) -> &'s Arc<Image<[u8; 4]>> {
        match source {
            Source::File(offered) => {
                let index = self.first_of(offered).expect("textures without an image have been left out");
                &self.decoded[&index]
            }
            Source::Computed(image) => image,
        }
    }

    /// Computes an image, counted like the decoded ones.
    pub(super) fn make(
        &mut self,
        (width, height): (u32, u32),
        texel: impl Fn(u32, u32) -> [u8; 4] + Sync,
    ) -> Result<Source, String> {
        self.used_bytes += 4 * u64::from(width) * u64::from(height);
        check_budget(self.used_bytes, self.most_bytes)?;
        let image = Image::par_from_fn(width, height, texel).map_err(|error| error.to_string())?;
        Ok(Source::Computed(Arc::new(image)))
    }
}

fn check_budget(used_bytes: u64, most_bytes: u64) -> Result<(), String> {
    if used_bytes > most_bytes {
        let most = MemorySize(most_bytes);
        return Err(format!("the images of the file take more than {most} when decoded; scale them down"));
    }
    Ok(())
}

/// Holds what the images will take against the memory that is left, from their headers alone.
fn check_sizes(document: &Document<'_>, tasks: &[Task<'_>], limits: TextureLimits) -> Result<(), LoadError> {
    let mut all = 0_u64;
    let mut largest: Option<(u64, u32, u32, &Task<'_>)> = None;
    for task in tasks {
        // What has no size is refused when it is decoded.
        let Ok((width, height)) = size_any(&task.bytes, limits) else { continue };
        let texels = u64::from(width) * u64::from(height);
        all = all.saturating_add(texels);
        if largest.is_none_or(|(most, ..)| texels > most) {
            largest = Some((texels, width, height, task));
        }
    }
    let Some((texels, width, height, task)) = largest else { return Ok(()) };
    let at_once = texels.saturating_mul(rayon::current_num_threads() as u64).min(all);
    let bytes = all.saturating_mul(TEXEL_BYTES).saturating_add(at_once.saturating_mul(DECODING_BYTES));
    let left = document.memory_left();
    if bytes > left {
        let [bytes, left] = [bytes, left].map(MemorySize);
        let count = tasks.len();
        let problem = format!(
            "the images take about {bytes} of memory when decoded ({count} in all, this is the largest with {width}x{height} pixels), and {left} are left of the limit; scale them down, or raise --memory-limit"
        );
        return Err(document.limit(place(task.index), problem));
    }
    document.take(all.saturating_mul(TEXEL_BYTES), &place(task.index))
}

/// Where an image is; none where nothing is said of it.
fn place_of<'d>(document: &'d Document<'_>, index: Index) -> Option<Place<'d>> {
    let image = document.root.images.get(index)?;
    if let Some(uri) = &image.uri {
        return Some(document.file_of(uri).map_or(Place::Inline(uri), Place::File));
    }
    let index = image.buffer_view?;
    let view = document.root.buffer_views.get(index)?;
    Some(match view.extensions.meshopt {
        None => Place::Buffer([view.buffer, view.byte_offset, view.byte_length]),
        Some(_) => Place::View(index),
    })
}

fn find<'d>(document: &'d Document<'_>, index: Index) -> Result<Task<'d>, LoadError> {
    let image = &document.root.images[index];
    let place = place(index);
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => document.read_uri(uri, &place)?.into(),
        (None, Some(view)) => document.view(view, &place)?.0.into(),
        (None, None) => {
            let problem = "it has neither a URI nor a buffer view; export the file again";
            return Err(document.fault(place, problem));
        }
    };
    Ok(Task { index, bytes })
}

/// What one image may take: its metadata count as well.
fn limits(document: &Document<'_>) -> TextureLimits {
    let limits = TextureLimits::default();
    TextureLimits { max_bytes: limits.max_bytes.min(document.memory_left()), ..limits }
}

/// Width and height by what the bytes are.
fn size_any(bytes: &[u8], limits: TextureLimits) -> Result<(u32, u32), String> {
    #[cfg(feature = "ktx2")]
    if super::ktx2::is_ktx2(bytes) {
        return super::ktx2::size(bytes, limits);
    }
    texture_size(bytes, "the image", limits).map_err(|error| error.to_string())
}

/// Decodes by what the bytes are, whatever the file calls them.
fn decode_any(bytes: &[u8], limits: TextureLimits) -> Result<Image<[u8; 4]>, Fault> {
    #[cfg(feature = "ktx2")]
    if super::ktx2::is_ktx2(bytes) {
        let is_too_large = super::ktx2::is_too_large(bytes, limits);
        return super::ktx2::decode(bytes, limits).map_err(if is_too_large {
            Fault::Limit
        } else {
            Fault::Broken
        });
    }
    decode_texture(bytes, "the image", limits).map_err(|error| match error {
        ImageError::TooLarge { .. } | ImageError::TooMuchMemory { .. } => Fault::Limit(error.to_string()),
        _ => Fault::Broken(error.to_string()),
    })
}
