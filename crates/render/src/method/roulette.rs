//! Russian roulette: a hit is kept with the probability of its alpha (STD section 3.2, Listing 3).

use sheer_core::{
    bibliography, choice,
    hash::{mcguire4, pcg, pcg4d, unit_from_bits},
    parameter::{ParameterInfo, Values},
};

use crate::contract::{MethodInfo, ShaderConstant, Site, Tables, Threshold, Visitor};

choice! {
    /// Where the random numbers of an object or a triangle come from.
    pub(super) enum Hash {
        /// Integer hashes of ids.
        Pcg = "pcg",
        /// The sine hash of the listings (STD appendix).
        McGuire = "mcguire",
    }
}

/// The key for the hash, for all methods that draw random numbers.
pub(super) const HASH: ParameterInfo = Hash::parameter(
    "hash",
    Hash::Pcg,
    "integer hash of ids, the same on every device; or the paper's sine hash",
);

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "roulette",
    title: "each hit is kept with the probability of its alpha; one shaded fragment a pixel",
    paper: "Brüll, Kern, Grosch (STD), section 3.2",
    works: &[&bibliography::STD],
    bias: "none; white noise",
    parameters: &[HASH],
    alignment_px: 1,
    constants: &[
        ShaderConstant::count("MCGUIRE_SEEDS", MCGUIRE_SEEDS),
        ShaderConstant::real("MCGUIRE_SEED_STEP", MCGUIRE_SEED_STEP),
    ],
    tables: &[],
};

/// Seeds that [`mcguire4`] distinguishes: the sine wants small numbers.
const MCGUIRE_SEEDS: u32 = 1024;
/// Frames between two of [`MCGUIRE_SEEDS`]: no whole number, so that no seed shows another one's frames.
const MCGUIRE_SEED_STEP: f32 = 0.618;

/// Russian roulette with one of the hashes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Roulette {
    hash: Hash,
}

impl Roulette {
    pub(super) fn new(values: &Values) -> Self {
        Self { hash: values.choice(HASH.key) }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }
}

impl Threshold for Roulette {
    #[inline]
    fn threshold(&self, site: &Site, _: &Tables) -> f32 {
        match self.hash {
            Hash::McGuire => {
                // The sum stands in for the frame index alone, so that seeds differ.
                let seed = (site.seed % MCGUIRE_SEEDS) as f32 * MCGUIRE_SEED_STEP;
                mcguire4(site.position.extend(site.frame as f32 + seed))
            }
            // Listing 3 hashes the position in the world. Its bits differ from device to device, so the
            // position is given by integers here: the pixel, and which triangle of which object is hit in it.
            // Surfaces at the same depth draw independent numbers.
            Hash::Pcg => {
                let object = pcg(site.geometry ^ site.seed.rotate_left(16)).wrapping_add(site.instance);
                let [x, y] = site.pixel;
                let [.., bits] = pcg4d([x | y << 16, site.frame, object, site.primitive]);
                unit_from_bits(bits)
            }
        }
    }
}
