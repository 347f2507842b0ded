//! Russian roulette: a hit is kept with the probability of its alpha (STD section 3.2, Listing 3).

use glam::Vec4;
use sheer_core::{
    hash::{mcguire4, pcg, pcg4d, unit_from_bits},
    parameter::{ParameterInfo, ParameterRange, Values},
};

use crate::contract::{MethodInfo, Site, Tables, Threshold, Visitor};

/// The choice of hash, for all methods that draw random numbers.
pub(crate) const HASH: ParameterInfo = ParameterInfo {
    key: "hash",
    default: "pcg",
    range: ParameterRange::Choice(&["pcg", "mcguire"]),
    what: "integer hash of ids, the same on every device; or the paper's sine hash",
};

/// Its entry in the table.
pub const INFO: MethodInfo = MethodInfo {
    id: "roulette",
    title: "each hit is kept with the probability of its alpha; one shaded fragment a pixel",
    paper: "Brüll, Kern, Grosch (STD), section 3.2",
    bias: "none; white noise",
    parameters: &[HASH],
    alignment_px: 1,
};

/// Seeds that [`mcguire4`] tells apart, and the distance between two of them in frames: the sine wants small numbers.
pub const MCGUIRE_SEEDS: u32 = 1024;
/// See [`MCGUIRE_SEEDS`]; no whole number, so that no seed shows another one's frames.
pub const MCGUIRE_SEED_STEP: f32 = 0.618;

/// Russian roulette.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    mcguire: bool,
}

impl Roulette {
    pub(crate) fn new(values: &Values) -> Self {
        Self { mcguire: values.text("hash") == "mcguire" }
    }

    pub(crate) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }
}

impl Threshold for Roulette {
    #[inline]
    fn threshold<const N: usize>(&self, site: &Site<N>, _: &Tables) -> [f32; N] {
        if self.mcguire {
            return std::array::from_fn(|lane| {
                let [x, y, z] = [0, 1, 2].map(|axis| site.position[axis][lane]);
                // The sum stands in for the frame index alone, so that seeds differ.
                let seed = (site.seed % MCGUIRE_SEEDS) as f32 * MCGUIRE_SEED_STEP;
                mcguire4(Vec4::new(x, y, z, site.frame as f32 + seed))
            });
        }
        // Listing 3 hashes the position in the world. Its bits differ from device to device, so the position is given by integers here:
        // the pixel, and which triangle of which object is hit in it. Surfaces at the same depth draw independent numbers.
        std::array::from_fn(|lane| {
            let object = pcg(site.geometry[lane] ^ site.seed.rotate_left(16)).wrapping_add(site.instance[lane]);
            let [x, y] = [site.pixel[0][lane], site.pixel[1][lane]];
            let [.., bits] = pcg4d([x | y << 16, site.frame, object, site.primitive[lane]]);
            unit_from_bits(bits)
        })
    }
}
