//! Spatio-temporal dithering: thresholds from 3×3 maps that walk over the screen, one map an object (STD section 3.3, Listing 4).

use ::std::array;

use glam::Vec3;
use sheer_core::{
    hash::{mcguire3, pcg3d},
    parameter::Values,
    threshold_map::threshold_index,
};

use super::roulette::HASH;
use crate::contract::{MethodInfo, Site, Tables, Threshold, Visitor};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "std",
    title: "thresholds dithered over space and time, one map an object; one shaded fragment a pixel",
    paper: "Brüll, Kern, Grosch (STD), section 3.3",
    bias: "stacked layers: their maps are not independent, so they hide one another too much or too little",
    parameters: &[HASH],
    alignment_px: 3,
};

/// Spatio-temporal dithering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Std {
    mcguire: bool,
}

impl Std {
    pub(crate) fn new(values: &Values) -> Self {
        Self { mcguire: values.text("hash") == "mcguire" }
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }

    /// `getRandom3x3Map` of Listing 4: one of `count` by object, geometry and face side.
    #[inline]
    fn map_index(self, [instance, geometry, back]: [u32; 3], seed: u32, count: usize) -> usize {
        if self.mcguire {
            let shifted = instance.wrapping_add(seed) as f32;
            let drawn = mcguire3(Vec3::new(shifted, geometry as f32, back as f32)) * count as f32;
            return (drawn as usize).min(count - 1);
        }
        let [bits, ..] = pcg3d([instance, geometry << 1 | back, seed]);
        // The high half of the product is uniform in 0..count (Lemire 2019).
        (u64::from(bits) * count as u64 >> 32) as usize
    }
}

impl Threshold for Std {
    #[inline]
    fn threshold<const N: usize>(&self, site: &Site<N>, tables: &Tables) -> [f32; N] {
        array::from_fn(|lane| {
            let pixel = [site.pixel[0][lane], site.pixel[1][lane]];
            let object = [site.instance[lane], site.geometry[lane], site.back[lane]];
            let map = &tables.std_maps[self.map_index(object, site.seed, tables.std_maps.len())];
            let stratum = threshold_index(map, pixel, site.frame);
            (f32::from(stratum) + tables.blue_noise_at(pixel)) / 9.0
        })
    }
}
