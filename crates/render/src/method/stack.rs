//! A fixed number of layers of a pixel, sorted by depth: what the k-buffer and multi-layer alpha blending
//! keep.

use glam::Vec3;

use crate::contract::Fragment;

/// The most layers that can be asked for: on a GPU they are registers, of which a thread has some hundred.
pub(super) const MOST_LAYERS: u32 = 32;

/// A fragment, or several that were merged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer {
    /// Depth of the nearest fragment in it, with its tie-breaker.
    pub(super) sort_key: (f32, u32),
    pub(super) rgb_premul: Vec3,
    pub(super) transmittance: f32,
}

impl Layer {
    /// Nothing, as seen from anywhere.
    pub(super) const CLEAR: Self =
        Self { sort_key: (f32::INFINITY, u32::MAX), rgb_premul: Vec3::ZERO, transmittance: 1.0 };

    pub(super) fn new(fragment: &Fragment<'_>, rgb_straight: Vec3) -> Self {
        Self {
            sort_key: fragment.sort_key(0),
            rgb_premul: fragment.alpha * rgb_straight,
            transmittance: 1.0 - fragment.alpha,
        }
    }

    /// This layer composited over another one as a single layer, which keeps the sort key of the one in
    /// front.
    pub(super) fn over(self, behind: &Self) -> Self {
        Self {
            sort_key: self.sort_key,
            rgb_premul: self.rgb_premul + self.transmittance * behind.rgb_premul,
            transmittance: self.transmittance * behind.transmittance,
        }
    }
}

/// Layers, the nearest first.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    /// One more than may stay: what is too much is seen before it is merged.
    layers: [Layer; MOST_LAYERS as usize + 1],
    len: usize,
}

impl Stack {
    pub(super) const EMPTY: Self = Self { layers: [Layer::CLEAR; MOST_LAYERS as usize + 1], len: 0 };

    pub(super) fn layers(&self) -> &[Layer] {
        &self.layers[..self.len]
    }

    /// Puts a layer where its depth belongs. At most [`MOST_LAYERS`] may be there before.
    pub(super) fn insert(&mut self, layer: Layer) {
        let at = self.layers().partition_point(|other| other.sort_key <= layer.sort_key);
        self.layers.copy_within(at..self.len, at + 1);
        self.layers[at] = layer;
        self.len += 1;
    }

    pub(super) fn take_nearest(&mut self) -> Layer {
        let nearest = self.layers[0];
        self.layers.copy_within(1..self.len, 0);
        self.len -= 1;
        nearest
    }

    /// Merges the two furthest layers.
    pub(super) fn merge_furthest(&mut self) {
        self.len -= 1;
        let [front, behind] = [self.len - 1, self.len].map(|at| self.layers[at]);
        self.layers[self.len - 1] = front.over(&behind);
    }

    /// All layers as one.
    pub(super) fn blended(&self) -> Layer {
        self.layers().iter().fold(Layer::CLEAR, |front, behind| front.over(behind))
    }
}
