//! Spatio-temporal blue noise: thresholds from a mask that is blue noise in each frame and in each pixel over
//! the frames, moved elsewhere for each object (Wolfe et al. 2022; STD section 7.2).

use sheer_core::{
    bibliography,
    parameter::Values,
    spatio_temporal::{COUNT, SIDE, spatio_temporal_ranks, value},
};

use super::{
    object_draw::{IDENTITY, ObjectDraw, REHASH, SECOND_DRAW_CONSTANT},
    roulette::HASH,
};
use crate::contract::{MethodInfo, ShaderTable, Site, Tables, Threshold, Visitor};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "stbn",
    title: "thresholds from a mask that is blue noise in space and in time, offset for each object; one shaded fragment a pixel",
    paper: "Wolfe et al., Spatiotemporal Blue Noise Masks, 2022; Brüll, Kern, Grosch (STD), section 7.2",
    works: &[&bibliography::WOLFE_2022, &bibliography::STD],
    bias: "a pixel sees 16 thresholds, then the same again; stacked layers: two places in one mask are not independent",
    parameters: &[HASH, IDENTITY, REHASH],
    // The mask would have to be aligned to multiples of its side, which is far too much to interpolate over.
    alignment_px: 1,
    constants: &[SECOND_DRAW_CONSTANT],
    tables: &[ShaderTable {
        name: "TABLE_RANKS",
        words: || spatio_temporal_ranks().iter().copied().map(u32::from).collect(),
    }],
};

/// Dithering by a spatio-temporal blue noise mask of 64×64 pixels and 16 frames. The paper's has 128×128
/// pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stbn {
    draw: ObjectDraw,
}

impl Stbn {
    pub(super) fn new(values: &Values) -> Self {
        Self { draw: ObjectDraw::new(values) }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }
}

impl Threshold for Stbn {
    #[inline]
    fn threshold(&self, site: &Site, _: &Tables) -> f32 {
        // Not among the tables: those are built for every method, and this one takes longer than all of them.
        let ranks = spatio_temporal_ranks();
        let offset = self.draw.below(site, COUNT);
        let [x, y] = site.pixel;
        let pixel = [x % SIDE + offset % SIDE, y % SIDE + offset / SIDE % SIDE];
        value(ranks, pixel, site.frame.wrapping_add(offset / (SIDE * SIDE)))
    }
}
