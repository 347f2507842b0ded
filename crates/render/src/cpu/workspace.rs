//! What the pixels of a task share: memory that is kept from pixel to pixel, and what they leave behind.

use sheer_accel::Hit;
use sheer_core::colour::Premul;
use sheer_scene::CameraRay;

/// A transparent hit of one of a pixel's sample rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleHit {
    pub(super) hit: Hit,
    pub(super) alpha: f32,
    /// Which of the sample rays.
    pub(super) ray: u32,
}

/// A triangle as the pixel sees it: what a [`Fragment`](crate::contract::Fragment) is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gathered {
    /// At the sample nearest to the pixel centre, where the fragment is shaded.
    pub(super) hit: Hit,
    pub(super) alpha: f32,
    pub(super) ray: u32,
    pub(super) coverage: u64,
    pub(super) first_depth: u32,
}

/// What a pixel needs for the time being; kept from pixel to pixel for its memory.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    pub(super) rays: Vec<CameraRay>,
    pub(super) hits: Vec<SampleHit>,
    /// Nearest opaque hit, one a ray.
    pub(super) opaque: Vec<Option<Hit>>,
    pub(super) fragments: Vec<Gathered>,
    /// Depths of all fragments, one for each sample ray.
    pub(super) depths: Vec<f32>,
    /// Hits front to back, for ordered gatherings.
    pub(super) sorted: Vec<(Hit, f32)>,
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

/// A fragment among those nearest to the eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer {
    pub(super) hit: Hit,
    pub(super) alpha: f32,
    /// What is seen through it and everything in front of it.
    pub(super) visibility: f32,
}
