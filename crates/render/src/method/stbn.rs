//! Spatio-temporal blue noise: thresholds from a mask that is blue noise in each frame and in each pixel over the frames, moved elsewhere
//! for each object (Wolfe et al. 2022; STD section 7.2).

use std::array;

use sheer_core::{
    parameter::Values,
    spatio_temporal::{COUNT, SIDE, spatio_temporal_ranks, value},
};

use super::{
    object_draw::{IDENTITY, ObjectDraw, REHASH},
    roulette::HASH,
};
use crate::contract::{MethodInfo, Site, Tables, Threshold, Visitor};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "stbn",
    title: "thresholds from a mask that is blue noise in space and in time, offset for each object; one shaded fragment a pixel",
    paper: "Wolfe et al., Spatiotemporal Blue Noise Masks, 2022; Brüll, Kern, Grosch (STD), section 7.2",
    bias: "a pixel sees 16 thresholds, then the same again; stacked layers: two places in one mask are not independent",
    parameters: &[HASH, IDENTITY, REHASH],
    // The mask would have to be aligned to multiples of its side, which is far too much to interpolate over.
    alignment_px: 1,
};

/// Dithering by a spatio-temporal blue noise mask of 64×64 pixels and 16 frames. The paper's has 128×128 pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stbn {
    draw: ObjectDraw,
}

impl Stbn {
    pub(crate) fn new(values: &Values) -> Self {
        Self { draw: ObjectDraw::new(values) }
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }
}

impl Threshold for Stbn {
    #[inline]
    fn threshold<const N: usize>(&self, site: &Site<N>, _: &Tables) -> [f32; N] {
        // Not among the tables: those are built for every method, and this one takes longer than all of them.
        let ranks = spatio_temporal_ranks();
        array::from_fn(|lane| {
            let place = self.draw.below(site, lane, COUNT);
            let pixel = [site.pixel[0][lane] % SIDE + place % SIDE, site.pixel[1][lane] % SIDE + place / SIDE % SIDE];
            value(ranks, pixel, site.frame.wrapping_add(place / (SIDE * SIDE)))
        })
    }
}
