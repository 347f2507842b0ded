//! DTAA*: the 5×5 map of DTAA with its five thresholds permuted at random for each object (STD sections 2.2
//! and 4).

use sheer_core::{bibliography, parameter::Values};

use super::{
    dtaa,
    object_draw::{IDENTITY, ObjectDraw, REHASH, SECOND_DRAW_CONSTANT},
    roulette::HASH,
    static_noise::{MIDDLE_CONSTANT, NOISE, Noise},
};
use crate::contract::{MethodInfo, ShaderConstant, ShaderTable, Site, Tables, Threshold, Visitor};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "dtaa-unique",
    title: "DTAA with the five thresholds permuted for each object (DTAA*); one shaded fragment a pixel",
    paper: "Brüll, Kern, Grosch (STD), sections 2.2 and 4",
    works: &[&bibliography::STD],
    bias: "stacked layers: two of 120 permutations are not independent, so they hide one another too much or too little",
    parameters: &[HASH, IDENTITY, REHASH, NOISE],
    alignment_px: dtaa::SIDE,
    constants: &[
        dtaa::SIDE_CONSTANT,
        SECOND_DRAW_CONSTANT,
        MIDDLE_CONSTANT,
        ShaderConstant::count("PERMUTATION_COUNT", PERMUTATION_COUNT as u32),
    ],
    tables: &[ShaderTable {
        name: "TABLE_PERMUTATIONS",
        words: || PERMUTATIONS.as_flattened().iter().copied().map(u32::from).collect(),
    }],
};

/// Ways to order five thresholds.
pub(super) const PERMUTATION_COUNT: usize = 120;

/// All of them, one a row.
pub(super) const PERMUTATIONS: [[u8; dtaa::SIDE as usize]; PERMUTATION_COUNT] = permutations();

/// DTAA with a permutation for each object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DtaaUnique {
    draw: ObjectDraw,
    noise: Noise,
}

impl DtaaUnique {
    pub(super) fn new(values: &Values) -> Self {
        Self { draw: ObjectDraw::new(values), noise: Noise::new(values) }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }
}

impl Threshold for DtaaUnique {
    #[inline]
    fn threshold(&self, site: &Site, tables: &Tables) -> f32 {
        let permutation = PERMUTATIONS[self.draw.below(site, PERMUTATION_COUNT as u32) as usize];
        let stratum = permutation[dtaa::stratum(site.pixel, site.frame) as usize];
        dtaa::threshold(u32::from(stratum), self.noise.of_hit(self.draw, site, tables))
    }
}

/// All permutations: the digits of an index, in bases 5 to 2, are the steps of a Fisher-Yates shuffle.
const fn permutations() -> [[u8; dtaa::SIDE as usize]; PERMUTATION_COUNT] {
    let mut all = [[0, 1, 2, 3, 4]; PERMUTATION_COUNT];
    let mut index = 0;
    while index < PERMUTATION_COUNT {
        let (mut digits, mut last) = (index, dtaa::SIDE as usize - 1);
        while last > 0 {
            all[index].swap(last, digits % (last + 1));
            digits /= last + 1;
            last -= 1;
        }
        index += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_of_the_permutations_occurs_once() {
        let mut all = PERMUTATIONS;
        all.sort_unstable();
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]));
        for mut permutation in all {
            permutation.sort_unstable();
            assert_eq!(permutation, [0, 1, 2, 3, 4]);
        }
    }
}
