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
use sheer_image::{Image, TextureLimits, decode_texture};

use super::{
    document::{Document, named},
    limits::IMAGE_BYTES,
    schema::Index,
    texels::Source,
};
use crate::SceneError;

/// The decoded images of a file, and what they take.
pub(super) struct Images {
    decoded: BTreeMap<Index, Arc<Image<[u8; 4]>>>,
    used_bytes: u64,
}

/// An image still to be decoded.
struct Task<'d> {
    index: Index,
    place: String,
    bytes: Cow<'d, [u8]>,
}

impl Images {
    /// Decodes the images of the given indices, which exist.
    pub(super) fn decode(
        document: &Document<'_>,
        wanted: impl Iterator<Item = Index>,
    ) -> Result<Self, SceneError> {
        let mut wanted: Vec<Index> = wanted.collect();
        wanted.sort_unstable();
        wanted.dedup();
        let tasks = wanted.into_iter().map(|index| find(document, index)).collect::<Result<Vec<_>, _>>()?;

        // Each decoder is bounded; together they are counted, so that many small files cannot add up to a
        // large one.
        let used_bytes = AtomicU64::new(0);
        let decode_one = |task: &Task<'_>| -> Result<Image<[u8; 4]>, String> {
            check_budget(used_bytes.load(Ordering::Relaxed))?;
            let image = decode_any(&task.bytes, &task.place)?;
            used_bytes.fetch_add(size_of_val(image.as_slice()) as u64, Ordering::Relaxed);
            Ok(image)
        };
        let results: Vec<Result<_, String>> = tasks.par_iter().map(decode_one).collect();
        let mut decoded = BTreeMap::new();
        for (task, image) in tasks.iter().zip(results) {
            let image = image.map_err(|problem| document.fault(task.place.as_str(), problem))?;
            decoded.insert(task.index, Arc::new(image));
        }
        Ok(Self { decoded, used_bytes: used_bytes.into_inner() })
    }

    /// The image behind a texture.
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
    let file_name = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
    let place = named("image", index, image.name.as_deref().or(file_name));
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => document.read_uri(uri, &place)?.into(),
        (None, Some(view)) => document.view(view, &place)?.0.into(),
        (None, None) => {
            let problem = "it has neither a URI nor a buffer view; export the file again";
            return Err(document.fault(place, problem));
        }
    };
    Ok(Task { index, place, bytes })
}

/// Decodes by what the bytes are, whatever the file calls them.
fn decode_any(bytes: &[u8], name: &str) -> Result<Image<[u8; 4]>, String> {
    let limits = TextureLimits::default();
    #[cfg(feature = "ktx2")]
    if super::ktx2::is_ktx2(bytes) {
        return super::ktx2::decode(bytes, limits);
    }
    decode_texture(bytes, name, limits).map_err(|error| error.to_string())
}
