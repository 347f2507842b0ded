//! The blue noise below the strata of dithering methods, which stays where it is for all frames (STD Listings
//! 1 and 4), and who shares it.
//!
//! In the paper all objects share it. An opacity below the share of the noise, 1/9 in STD, passes the least
//! stratum alone and is decided by the noise of its pixel: stacked layers that faint are all there or all
//! not, and the pixel shows the same error for ever. An offset into the noise for each object makes them
//! independent.

use sheer_core::{
    choice,
    parameter::{Choice as _, ParameterInfo, ParameterRange, Values},
};

use super::object_draw::ObjectDraw;
use crate::contract::{BLUE_NOISE_SIDE, ShaderConstant, Site, Tables};

choice! {
    /// Who shares the static blue noise.
    pub(super) enum Noise {
        /// All objects.
        Shared = "shared",
        /// Nobody: each object has an offset of its own.
        Object = "object",
        /// There is none.
        Off = "off",
    }
}

/// The key for it, for methods whose objects draw something for themselves.
pub(super) const NOISE: ParameterInfo = Noise::parameter(
    "noise",
    Noise::Shared,
    "blue noise below the strata: the same for all objects, as in the paper; from an offset of its own for each, so that faint \
     layers do not all vanish from the same pixels; or none",
);

/// The key for it, for methods whose objects have nothing of their own.
pub(super) const NOISE_OF_ALL: ParameterInfo = ParameterInfo {
    range: ParameterRange::Choice(&[Noise::WORDS[Noise::Shared as usize], Noise::WORDS[Noise::Off as usize]]),
    what: "blue noise below the strata, as in the paper; or none: then thresholds are the middles of the strata",
    ..NOISE
};

/// Where in its stratum a threshold lies without noise, as a share.
const MIDDLE: f32 = 0.5;
/// [`MIDDLE`] for the shaders of all methods that take the key.
pub(super) const MIDDLE_CONSTANT: ShaderConstant = ShaderConstant::real("MIDDLE_OF_STRATUM", MIDDLE);

impl Noise {
    pub(super) fn new(values: &Values) -> Self {
        values.choice(NOISE.key)
    }

    /// The noise of a pixel for all objects, in (0, 1).
    #[inline]
    pub(super) fn of_all(self, pixel: [u32; 2], tables: &Tables) -> f32 {
        if self == Self::Off { MIDDLE } else { tables.blue_noise_at(pixel) }
    }

    /// The noise of a hit, in (0, 1), with an object's own draw.
    #[inline]
    pub(super) fn of_hit(self, draw: ObjectDraw, site: &Site, tables: &Tables) -> f32 {
        let mut pixel = site.pixel;
        if self == Self::Object {
            let texel = draw.second_below(site, BLUE_NOISE_SIDE * BLUE_NOISE_SIDE);
            let offset = [texel % BLUE_NOISE_SIDE, texel / BLUE_NOISE_SIDE];
            pixel = [0, 1].map(|axis| pixel[axis] % BLUE_NOISE_SIDE + offset[axis]);
        }
        self.of_all(pixel, tables)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::{
        object_draw::{IDENTITY, REHASH},
        roulette::HASH,
    };

    const KNOWN: &[ParameterInfo] = &[HASH, IDENTITY, REHASH, NOISE];

    /// Noise of the first 64 pixels of a row for two objects.
    fn rows(settings: &str) -> [Vec<f32>; 2] {
        let values = Values::parse(KNOWN, settings).unwrap();
        let (noise, draw, tables) = (Noise::new(&values), ObjectDraw::new(&values), Tables::get());
        [3, 4].map(|instance| {
            let at = |x| {
                let site = Site { pixel: [x, 5], instance, ..Site::default() };
                noise.of_hit(draw, &site, &tables)
            };
            (0..64).map(at).collect()
        })
    }

    #[test]
    fn the_key_says_who_shares_the_noise() {
        let [one, other] = rows("");
        assert_eq!(one, other);
        assert_eq!(one[7], Tables::get().blue_noise_at([7, 5]));
        let [one, other] = rows("noise=off");
        assert!(one.iter().chain(&other).all(|noise| *noise == MIDDLE));
        for hash in ["pcg", "mcguire"] {
            let [one, other] = rows(&format!("noise=object,hash={hash}"));
            assert!(one.iter().zip(&other).filter(|(one, other)| one != other).count() > 60, "{hash}");
            // A row of the tile, from somewhere else on.
            let tables = Tables::get();
            let row = |y| (0..64).map(|x| tables.blue_noise_at([x, y])).collect::<Vec<_>>();
            let is_turned = |row: Vec<f32>| (0..64).any(|by| (0..64).all(|x| row[(x + by) % 64] == one[x]));
            assert!((0..64).map(row).any(is_turned), "{hash}");
        }
    }

    /// How often objects have each pair of quarters of their two draws, 1000 times each on average.
    fn pairs_of_quarters(hash: &str) -> [u32; 16] {
        let draw = ObjectDraw::new(&Values::parse(KNOWN, &format!("hash={hash}")).unwrap());
        let mut counts = [0_u32; 16];
        for instance in 0..16_000 {
            let site = Site { instance, ..Site::default() };
            counts[(4 * draw.below(&site, 4) + draw.second_below(&site, 4)) as usize] += 1;
        }
        counts
    }

    #[test]
    fn maps_and_offsets_into_the_noise_are_drawn_independently() {
        let chi_square = |counts: [u32; 16]| -> f64 {
            counts.iter().map(|&count| (f64::from(count) - 1000.0).powi(2) / 1000.0).sum()
        };
        // 15 degrees of freedom, of which 99.9 % lie below 37.7.
        let found = chi_square(pairs_of_quarters("pcg"));
        assert!(found < 37.7, "{found}");
        // The sine hash is not that uniform, whatever it draws. But no pair is rare, as equal draws would
        // make most.
        let counts = pairs_of_quarters("mcguire");
        assert!(counts.iter().all(|count| (800..1200).contains(count)), "{counts:?}");
        assert!(chi_square(counts) > 37.7, "the sine hash has become as good: test it as the other");
    }
}
