//! What the pixels of a task share: memory that is kept from pixel to pixel, and what they leave behind.

use sheer_accel::Hit;
use sheer_core::colour::Premul;
use sheer_scene::CameraRay;

/// A transparent hit of one of the sample rays of some pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleHit {
    pub(super) hit: Hit,
    pub(super) alpha: f32,
    /// Which of the pixels.
    pub(super) pixel: u32,
    /// Which of its sample rays.
    pub(super) ray: u32,
}

/// A triangle as the pixel sees it: what a [`Fragment`](crate::contract::Fragment) is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gathered {
    /// At the sample nearest to the pixel centre, where the fragment is shaded.
    pub(super) hit: Hit,
    pub(super) alpha: f32,
    /// Which of the pixel's sample rays.
    pub(super) ray: u32,
    pub(super) coverage: u64,
    pub(super) first_depth: u32,
}

/// What one pixel sees, for unordered gatherings.
#[derive(Debug, Default)]
pub(super) struct PixelFragments {
    /// One a sample.
    pub(super) rays: Vec<CameraRay>,
    /// Nearest opaque hit, one a ray.
    pub(super) opaque: Vec<Option<Hit>>,
    pub(super) fragments: Vec<Gathered>,
    /// Depths of all fragments, one for each sample ray.
    pub(super) depths: Vec<f32>,
}

/// What a tile needs for the time being; kept from tile to tile for its memory.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    /// For unordered gatherings; there may be more elements than pixels.
    pub(super) pixels: Vec<PixelFragments>,
    pub(super) hits: Vec<SampleHit>,
    /// Hits of each ray front to back, for ordered gatherings.
    pub(super) sorted: Vec<Vec<(Hit, f32)>>,
}

/// Where the time of unordered compositing goes, nanoseconds of one thread.
#[derive(Clone, Debug, Default)]
pub(super) struct Nanoseconds {
    /// Finding fragments and what is opaque, for the first pass.
    pub(super) gather: u64,
    /// The passes of the method, one after the other.
    pub(super) passes: Vec<u64>,
    /// Shading the background and putting everything together.
    pub(super) composite: u64,
}

impl Nanoseconds {
    /// The costs of both, added up.
    pub(super) fn plus(mut self, other: &Self) -> Self {
        self.gather += other.gather;
        self.composite += other.composite;
        self.passes.resize(self.passes.len().max(other.passes.len()), 0);
        for (sum, pass) in self.passes.iter_mut().zip(&other.passes) {
            *sum += pass;
        }
        self
    }
}

/// What pixels leave behind beside themselves.
#[derive(Debug, Default)]
pub(super) struct Byproducts {
    pub(super) nanoseconds: Nanoseconds,
    /// Light and total alpha of the fragments of pixels, for a filter.
    pub(super) layer: Vec<([u32; 2], Premul)>,
}

impl Byproducts {
    /// The costs of both, added up.
    pub(super) fn plus(mut self, mut other: Self) -> Self {
        self.layer.append(&mut other.layer);
        Self { nanoseconds: self.nanoseconds.plus(&other.nanoseconds), layer: self.layer }
    }
}

/// The fragments of a ray that are nearest to the eye, as far as they are looked for.
#[derive(Clone, Debug, Default)]
pub(super) struct NearLayers {
    /// Front to back.
    pub(super) layers: Vec<Layer>,
    /// Whether the last of them was enough.
    pub(super) ended: bool,
}

impl NearLayers {
    pub(super) fn clear(&mut self) {
        self.layers.clear();
        self.ended = false;
    }

    /// Adds a hit, unless it lies behind what is `enough`: a predicate of the count of layers and of the
    /// visibility behind them that stays true as the one grows and the other falls. Returns how far there is
    /// to look.
    ///
    /// A hit found late, in front of others, can only lower the visibility behind each of these, rounding
    /// included, so the end known so far is never nearer than the true one: what lies behind it is dropped at
    /// once and bounds the ray, and nothing is lost.
    #[inline]
    pub(super) fn add(&mut self, hit: Hit, alpha: f32, enough: impl Fn(usize, f32) -> bool) -> f32 {
        let Self { layers, ended } = self;
        let index = layers.partition_point(|layer| is_behind(&hit, &layer.hit));
        let is_dropped = *ended && index == layers.len();
        if alpha > 0.0 && !is_dropped {
            let mut visibility = if index == 0 { 1.0 } else { layers[index - 1].visibility };
            let mut count = index;
            layers.insert(index, Layer { hit, alpha, visibility });
            let end = layers[index..].iter_mut().position(|layer| {
                visibility *= 1.0 - layer.alpha;
                layer.visibility = visibility;
                count += 1;
                enough(count, visibility)
            });
            if let Some(end) = end {
                *ended = true;
                layers.truncate(index + end + 1);
            }
        }
        layers.last().filter(|_| *ended).map_or(f32::INFINITY, |layer| layer.hit.t)
    }
}

/// Whether a hit lies behind another in the order of all hits: by depth, then triangle.
pub(super) fn is_behind(hit: &Hit, other: &Hit) -> bool {
    (hit.t, hit.triangle) > (other.t, other.triangle)
}

/// A fragment among those nearest to the eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer {
    pub(super) hit: Hit,
    pub(super) alpha: f32,
    /// What is seen through it and everything in front of it.
    pub(super) visibility: f32,
}
