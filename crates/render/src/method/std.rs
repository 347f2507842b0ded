//! Spatio-temporal dithering: thresholds from 3×3 maps that walk over the screen, one map an object (STD
//! section 3.3, Listing 4).

use sheer_core::{
    bibliography,
    parameter::Values,
    threshold_map::{MAP_COUNT, threshold_index},
};

use super::{
    object_draw::{IDENTITY, ObjectDraw, REHASH, SECOND_DRAW_CONSTANT},
    roulette::HASH,
    static_noise::{MIDDLE_CONSTANT, NOISE, Noise},
};
use crate::contract::{MethodInfo, Site, Tables, Threshold, Visitor};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "std",
    title: "thresholds dithered over space and time, one map an object; one shaded fragment a pixel",
    paper: "Brüll, Kern, Grosch (STD), section 3.3",
    works: &[&bibliography::STD],
    bias: "stacked layers: their maps are not independent, so they hide one another too much or too little",
    parameters: &[HASH, IDENTITY, REHASH, NOISE],
    alignment_px: 3,
    constants: &[SECOND_DRAW_CONSTANT, MIDDLE_CONSTANT],
    tables: &[],
};

/// Spatio-temporal dithering with a map drawn for each object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Std {
    draw: ObjectDraw,
    noise: Noise,
}

impl Std {
    pub(super) fn new(values: &Values) -> Self {
        Self { draw: ObjectDraw::new(values), noise: Noise::new(values) }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }
}

impl Threshold for Std {
    #[inline]
    fn threshold(&self, site: &Site, tables: &Tables) -> f32 {
        let map = &tables.std_maps[self.draw.below(site, MAP_COUNT as u32) as usize];
        let stratum = threshold_index(map, site.pixel, site.frame);
        (f32::from(stratum) + self.noise.of_hit(self.draw, site, tables)) / 9.0
    }
}
