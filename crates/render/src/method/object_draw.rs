//! What an object draws for itself, so that stacked objects do not mask one another: a map, a permutation, an
//! offset into a mask.

use glam::{Vec2, Vec3};
use sheer_core::{
    choice,
    hash::{mcguire2, mcguire3, pcg2d, pcg3d},
    parameter::{ParameterInfo, ParameterRange, Values},
};

use super::roulette::{HASH, Hash};
use crate::contract::{ShaderConstant, Site};

choice! {
    /// Who has thresholds of its own.
    enum Identity {
        /// Front and back of each object, as in STD.
        Face = "face",
        /// Each object, its front and back together.
        Object = "object",
        /// Each triangle of each object.
        Primitive = "primitive",
    }
}

/// The key for who draws. A method that has it in its table takes [`HASH`] and [`REHASH`], too.
pub(super) const IDENTITY: ParameterInfo = Identity::parameter(
    "identity",
    Identity::Face,
    "who has thresholds of its own: front and back of each object, as in the paper; each object; or each triangle",
);

/// The key for how often all objects draw anew.
pub(super) const REHASH: ParameterInfo = ParameterInfo {
    key: "rehash",
    default: "0",
    range: ParameterRange::Count(0, 1_000_000),
    what: "frames after which all draw anew, so that no two objects mask one another for good; 0: never, as in the paper; \
           9: after each cycle of std",
};

/// What the second number that an object draws is hashed with, on top of all that makes the first: small, as
/// the sine hash wants it.
const SECOND_DRAW: u32 = 1;
/// [`SECOND_DRAW`] for the shaders of all methods whose objects draw.
pub(super) const SECOND_DRAW_CONSTANT: ShaderConstant = ShaderConstant::count("SECOND_DRAW", SECOND_DRAW);

/// The draw of `getRandom3x3Map` in STD Listing 4, from any number of choices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ObjectDraw {
    hash: Hash,
    identity: Identity,
    rehash_frames: u32,
}

impl ObjectDraw {
    pub(super) fn new(values: &Values) -> Self {
        Self {
            hash: values.choice(HASH.key),
            identity: values.choice(IDENTITY.key),
            rehash_frames: values.count(REHASH.key),
        }
    }

    /// A number in `0..count`, each equally likely.
    #[inline]
    pub(super) fn below(self, site: &Site, count: u32) -> u32 {
        self.draw(site, count, None)
    }

    /// A second number in `0..count`, independent of the first.
    #[inline]
    pub(super) fn second_below(self, site: &Site, count: u32) -> u32 {
        self.draw(site, count, Some(SECOND_DRAW))
    }

    #[inline]
    fn draw(self, site: &Site, count: u32, further: Option<u32>) -> u32 {
        let &Site { instance, geometry, .. } = site;
        let back = if self.identity == Identity::Face { site.back } else { 0 };
        // Hashed on top of the paper's draw, which stays as it is where neither is asked for.
        let primitive = (self.identity == Identity::Primitive).then_some(site.primitive);
        let cycle = site.frame.checked_div(self.rehash_frames);
        let more = [primitive, cycle, further].into_iter().flatten();
        match self.hash {
            Hash::McGuire => {
                let shifted = instance.wrapping_add(site.seed) as f32;
                let first = mcguire3(Vec3::new(shifted, geometry as f32, back as f32));
                let drawn = more.fold(first, |drawn, number| mcguire2(Vec2::new(drawn, number as f32)));
                ((drawn * count as f32) as u32).min(count - 1)
            }
            Hash::Pcg => {
                let [first, ..] = pcg3d([instance, geometry << 1 | back, site.seed]);
                let bits = more.fold(first, |bits, number| pcg2d([bits, number])[0]);
                // The high half of the product is uniform in 0..count (Lemire 2019).
                ((u64::from(bits) * u64::from(count)) >> 32) as u32
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: &[ParameterInfo] = &[HASH, IDENTITY, REHASH];

    /// 288 maps are drawn from as in STD.
    fn draw(settings: &str, change: impl Fn(&mut Site)) -> u32 {
        let mut site = Site { frame: 4, instance: 7, geometry: 2, primitive: 5, ..Site::default() };
        change(&mut site);
        ObjectDraw::new(&Values::parse(KNOWN, settings).unwrap()).below(&site, 288)
    }

    #[test]
    fn identity_says_what_makes_a_difference() {
        for hash in ["pcg", "mcguire"] {
            for (identity, by_side, by_primitive) in
                [("face", true, false), ("object", false, false), ("primitive", false, true)]
            {
                let settings = format!("hash={hash},identity={identity}");
                let own = draw(&settings, |_| ());
                assert_eq!(own != draw(&settings, |site| site.back = 1), by_side, "{settings}");
                assert_eq!(own != draw(&settings, |site| site.primitive = 6), by_primitive, "{settings}");
                assert_ne!(own, draw(&settings, |site| site.instance = 8), "{settings}");
                assert_ne!(own, draw(&settings, |site| site.geometry = 3), "{settings}");
            }
        }
    }

    #[test]
    fn maps_are_drawn_anew_after_each_cycle_and_not_within_one() {
        for hash in ["pcg", "mcguire"] {
            let at =
                |rehash: u32, frame| draw(&format!("hash={hash},rehash={rehash}"), |site| site.frame = frame);
            assert!((0..100).all(|frame| at(0, frame) == at(0, 0)), "{hash}");
            assert!((9..18).all(|frame| at(9, frame) == at(9, 9)), "{hash}");
            assert_ne!(at(9, 8), at(9, 9), "{hash}");
            assert_ne!(at(9, 17), at(9, 18), "{hash}");
        }
    }

    #[test]
    fn every_choice_is_equally_likely() {
        // Each of 120 choices is expected 1000 times; the variance of the statistic is twice its 119 degrees
        // of freedom.
        for settings in ["", "identity=primitive", "rehash=1"] {
            let draw = ObjectDraw::new(&Values::parse(KNOWN, settings).unwrap());
            let mut counts = [0_u32; 120];
            for number in 0..120_000 {
                let site =
                    Site { instance: number % 1000, primitive: number, frame: number, ..Site::default() };
                let site = if settings.is_empty() { Site { instance: number, ..site } } else { site };
                counts[draw.below(&site, 120) as usize] += 1;
            }
            let chi_square: f64 =
                counts.iter().map(|&count| (f64::from(count) - 1000.0).powi(2) / 1000.0).sum();
            let z = (chi_square - 119.0) / (2.0 * 119.0_f64).sqrt();
            assert!(z.abs() < 4.0, "'{settings}': z = {z}");
        }
    }
}
