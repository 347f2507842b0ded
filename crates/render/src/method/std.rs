//! Spatio-temporal dithering: thresholds from 3×3 maps that walk over the screen, one map an object (STD section 3.3, Listing 4).

use ::std::array;

use sheer_core::{
    parameter::Values,
    threshold_map::{MAP_COUNT, threshold_index},
};

use super::{
    object_draw::{IDENTITY, ObjectDraw, REHASH},
    roulette::HASH,
    static_noise::{NOISE, Noise},
};
use crate::contract::{MethodInfo, Site, Tables, Threshold, Visitor};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "std",
    title: "thresholds dithered over space and time, one map an object; one shaded fragment a pixel",
    paper: "Brüll, Kern, Grosch (STD), section 3.3",
    bias: "stacked layers: their maps are not independent, so they hide one another too much or too little",
    parameters: &[HASH, IDENTITY, REHASH, NOISE],
    alignment_px: 3,
};

/// Spatio-temporal dithering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Std {
    draw: ObjectDraw,
    noise: Noise,
}

impl Std {
    pub(crate) fn new(values: &Values) -> Self {
        Self { draw: ObjectDraw::new(values), noise: Noise::new(values) }
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }
}

impl Threshold for Std {
    #[inline]
    fn threshold<const N: usize>(&self, site: &Site<N>, tables: &Tables) -> [f32; N] {
        array::from_fn(|lane| {
            let pixel = [site.pixel[0][lane], site.pixel[1][lane]];
            let map = &tables.std_maps[self.draw.below(site, lane, MAP_COUNT as u32) as usize];
            let stratum = threshold_index(map, pixel, site.frame);
            (f32::from(stratum) + self.noise.of_hit(self.draw, site, lane, tables)) / 9.0
        })
    }
}
