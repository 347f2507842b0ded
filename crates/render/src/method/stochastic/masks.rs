//! Which samples a fragment covers by chance.

use sheer_core::{
    choice,
    hash::{pcg2d, pcg3d, pcg4d},
    mask::{
        ALPHA_BITS, CURVE_SIDE, OPAQUE, along_curve, coin_mask, mask_table, quantised_alpha, set_size,
        stratified_threshold,
    },
    parameter::{Switch, Values},
};

use super::pixel::covered;
use crate::contract::{Fragment, PixelSite, Tables};

/// How masks are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Masks {
    samples: u32,
    rounds: u32,
    kind: Kind,
    seed_by: SeedBy,
    reseeds: bool,
    dither: Dither,
}

choice! {
    /// How the samples that a fragment covers are chosen.
    pub(super) enum Kind {
        /// `R = ⌊αS + ξ⌋` samples, a random subset (ST section 3.1).
        Stratified = "stratified",
        /// Each sample flips a coin of its own.
        Naive = "naive",
        /// Stratified over neighbours and layers, too (Laine and Karras 2011).
        LaineKarras = "laine-karras",
        /// Always the first R samples, as alpha-to-coverage has it.
        AlphaToCoverage = "a2c",
    }
}

choice! {
    /// Who draws one mask in a pixel.
    pub(super) enum SeedBy {
        /// Each triangle of each object.
        Primitive = "primitive",
        /// Each object, all its triangles together.
        Object = "object",
        /// All that lies at one depth.
        Depth = "depth",
    }
}

choice! {
    /// Where ξ comes from.
    pub(super) enum Dither {
        /// From a hash of pixel and surface.
        Off = "off",
        /// From a tile of blue noise, moved for each surface.
        Tile = "tile",
    }
}

impl Masks {
    pub(super) fn new(values: &Values) -> Self {
        Self {
            samples: values.count("samples"),
            rounds: values.count("passes"),
            kind: values.choice("masks"),
            seed_by: values.choice("seed-by"),
            reseeds: values.choice::<Switch>("reseed") == Switch::On,
            dither: values.choice("dither"),
        }
    }

    /// Whether the mask of a fragment depends on which ones came before it.
    pub(super) fn depend_on_order(self) -> bool {
        self.kind == Kind::LaineKarras
    }

    /// The mask of a fragment in one of the rounds. `unhidden` are the samples where nothing that came before
    /// is in front of it.
    pub(super) fn mask(self, site: &PixelSite, fragment: &Fragment<'_>, round: u32, unhidden: u64) -> u64 {
        let surface = self.surface(site, fragment);
        match self.kind {
            Kind::LaineKarras => self.laine_karras(site, surface, fragment.alpha, round, unhidden),
            Kind::Naive => {
                let [bits, seed, ..] = in_pixel(site, surface);
                coin_mask(quantised_alpha(fragment.alpha, bits), [seed, round << ALPHA_BITS])
            }
            Kind::Stratified | Kind::AlphaToCoverage => {
                let [bits, xi, odd, seed] = in_pixel(site, surface);
                let alpha = quantised_alpha(fragment.alpha, bits);
                let xi = match self.dither {
                    Dither::Off => xi >> (u32::BITS - ALPHA_BITS),
                    Dither::Tile => tiled_xi(site, surface),
                };
                let size = self.size_in_round(set_size(alpha, self.samples * self.rounds, xi), round, odd);
                if self.kind == Kind::AlphaToCoverage {
                    return u64::MAX.checked_shr(u64::BITS - size).unwrap_or(0);
                }
                mask_table(self.samples).pick(size, pcg2d([seed, round])[0])
            }
        }
    }

    /// A round's part of a subset over the samples of all rounds (ST footnotes 3 and 4): the same for each,
    /// and one more for as many, chosen at random, as are left over.
    fn size_in_round(self, size: u32, round: u32, bits: u32) -> u32 {
        let rounds_with_more = mask_table(self.rounds).pick(size % self.rounds, bits);
        size / self.rounds + (rounds_with_more >> round & 1) as u32
    }

    /// Who draws a mask of its own (ST section 6), in one frame of one run.
    fn surface(self, site: &PixelSite, fragment: &Fragment<'_>) -> u32 {
        let side = fragment.geometry << 1 | u32::from(fragment.is_back);
        let [surface, ..] = match self.seed_by {
            SeedBy::Primitive => pcg3d([fragment.instance, side, fragment.primitive]),
            SeedBy::Object => pcg3d([fragment.instance, side, u32::MAX]),
            SeedBy::Depth => pcg3d([fragment.depth().to_bits(), u32::from(fragment.is_back), u32::MAX]),
        };
        let frame = if self.reseeds { site.frame } else { 0 };
        pcg3d([surface, frame, site.seed])[0]
    }

    /// Laine and Karras 2011: a sample is covered if its threshold is below alpha. Thresholds are stratified
    /// over the samples of the pixel, of its rounds, and of the pixels around it, in this order along one
    /// curve.
    ///
    /// Samples in which the fragment is hidden anyway are passed over, so that what is left is stratified
    /// among itself: layer upon layer if they come front to back. Whether one is covered still has the
    /// probability of alpha whatever came before, so that no order biases the mean. Deviations: samples
    /// follow one another by their distance from the pixel centre, not along the curve; the surface's number
    /// is hashed.
    fn laine_karras(self, site: &PixelSite, surface: u32, alpha: f32, round: u32, unhidden: u64) -> u64 {
        let per_pixel = (self.samples * self.rounds).next_power_of_two();
        let tile = site.pixel.map(|coordinate| coordinate / CURVE_SIDE);
        let [surface, ..] = pcg3d([surface, tile[0], tile[1]]);
        let first = along_curve(site.pixel) * per_pixel + round * self.samples;
        let limit = (f64::from(alpha) * 2.0_f64.powi(32)) as u32;
        let samples = covered(unhidden & (u64::MAX >> (u64::BITS - self.samples)));
        (first..).zip(samples).fold(0, |mask, (index, sample)| {
            mask | u64::from(stratified_threshold(index, surface) < limit) << sample
        })
    }
}

/// Four random numbers of a surface in a pixel.
fn in_pixel(site: &PixelSite, surface: u32) -> [u32; 4] {
    let [x, y] = site.pixel;
    pcg4d([x | y << 16, surface, site.seed, 0])
}

/// ξ from blue noise, for each surface from another part of it: so that neighbours complement one another and
/// surfaces stay uncorrelated.
fn tiled_xi(site: &PixelSite, surface: u32) -> u32 {
    let [x, y] = pcg2d([surface, site.seed]);
    let [column, row] = site.pixel;
    let value = Tables::get().blue_noise_at([column.wrapping_add(x), row.wrapping_add(y)]);
    (value * OPAQUE as f32) as u32
}
