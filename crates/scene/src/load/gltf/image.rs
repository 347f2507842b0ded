//! Images: where their bytes are, and decoding them side by side.

use std::{
    borrow::Cow,
    collections::BTreeMap,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use rayon::prelude::*;
use sheer_image::{Image, ImageError, TextureLimits, decode_texture};

use super::{document::Document, limits::IMAGE_BYTES, schema::Index, texels::Source};
use crate::SceneError;

/// What becomes of a texture whose image is lost.
const WITHOUT: &str = "drawn without it";

/// The decoded images of a file, and what they take.
pub(super) struct Images {
    decoded: BTreeMap<Index, Arc<Image<[u8; 4]>>>,
    used_bytes: u64,
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
    /// Decodes the images of the given indices, which exist; those that are broken or missing are left out.
    pub(super) fn decode(
        document: &Document<'_>,
        wanted: impl Iterator<Item = Index>,
    ) -> Result<Self, SceneError> {
        let mut wanted: Vec<Index> = wanted.collect();
        wanted.sort_unstable();
        wanted.dedup();
        let mut tasks = Vec::with_capacity(wanted.len());
        for index in wanted {
            tasks.extend(document.salvage(find(document, index), WITHOUT)?);
        }

        // Each decoder is bounded; together they are counted, so that many small files cannot add up to a
        // large one.
        let used_bytes = AtomicU64::new(0);
        let decode_one = |task: &Task<'_>| -> Result<Image<[u8; 4]>, Fault> {
            check_budget(used_bytes.load(Ordering::Relaxed)).map_err(Fault::Limit)?;
            let image = decode_any(&task.bytes)?;
            used_bytes.fetch_add(size_of_val(image.as_slice()) as u64, Ordering::Relaxed);
            Ok(image)
        };
        let results: Vec<Result<_, Fault>> = tasks.par_iter().map(decode_one).collect();
        let mut decoded = BTreeMap::new();
        for (task, image) in tasks.iter().zip(results) {
            let image = image.map_err(|fault| match fault {
                Fault::Broken(problem) => document.fault(place(task.index), problem),
                Fault::Limit(problem) => document.limit(place(task.index), problem),
            });
            if let Some(image) = document.salvage(image, WITHOUT)? {
                decoded.insert(task.index, Arc::new(image));
            }
        }
        Ok(Self { decoded, used_bytes: used_bytes.into_inner() })
    }

    /// Whether the image behind a texture is there.
    pub(super) fn has(&self, source: &Source) -> bool {
        match source {
            Source::File(index) => self.decoded.contains_key(index),
            Source::Computed(_) => true,
        }
    }

    /// The image behind a texture, which is there.
    pub(super) fn of<'s>(&'s self, source: &'s Source) -> &'s Arc<Image<[u8; 4]>> {
        match source {
            Source::File(index) => &self.decoded[index],
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
        check_budget(self.used_bytes)?;
        let image = Image::par_from_fn(width, height, texel).map_err(|error| error.to_string())?;
        Ok(Source::Computed(Arc::new(image)))
    }
}

fn check_budget(used_bytes: u64) -> Result<(), String> {
    if used_bytes > IMAGE_BYTES {
        return Err(format!(
            "the images of the file take more than {} GiB when decoded; scale them down",
            IMAGE_BYTES >> 30
        ));
    }
    Ok(())
}

fn find<'d>(document: &'d Document<'_>, index: Index) -> Result<Task<'d>, SceneError> {
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

/// Decodes by what the bytes are, whatever the file calls them.
fn decode_any(bytes: &[u8]) -> Result<Image<[u8; 4]>, Fault> {
    let limits = TextureLimits::default();
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
