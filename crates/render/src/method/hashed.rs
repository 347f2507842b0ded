//! Hashed alpha testing: thresholds hashed from where on its object a hit lies, so that the noise sticks to
//! the surface (Wyman and McGuire 2017).
//!
//! Space is cut into cells about as large as a pixel, and each cell draws one number. Cells of exactly a
//! pixel would slide over the surface as the camera nears, so their sizes are powers of two only: the next
//! smaller and the next larger one each give a number, and the two are blended by where the pixel lies
//! between them. A blend of uniform numbers is not uniform; its cumulative distribution function makes it so
//! again.
//!
//! Deviations: cells are hashed as integers, as everywhere in Sheer; the object enters the hash, as equal
//! objects on top of one another would mask each other otherwise; and the frame does, so that the mean over
//! time converges.

use sheer_core::{
    bibliography,
    hash::{BELOW_ONE, pcg3d, pcg4d, unit_from_bits},
    parameter::{ParameterInfo, ParameterRange, Values},
};

use crate::contract::{MethodInfo, ShaderConstant, Site, Tables, Threshold, Visitor};

/// The row of the method in lists and help, and what a GPU needs of it.
pub(super) const INFO: MethodInfo = MethodInfo {
    id: "hashed",
    title: "thresholds hashed from the place on the object, drawn anew each frame; one shaded fragment a pixel",
    paper: "Wyman, McGuire, Hashed Alpha Testing, 2017",
    works: &[&bibliography::WYMAN_MCGUIRE_2017],
    bias: "none; white noise in grains of one to two pixels",
    parameters: &[ParameterInfo {
        key: "scale",
        default: "1",
        range: ParameterRange::Real(0.25, 16.0),
        what: "size of the grains, pixels",
    }],
    alignment_px: 1,
    constants: &[ShaderConstant::real("MAX_LEVEL", MAX_LEVEL)],
    tables: &[],
};

/// Octaves below and above an object unit within which cells are told apart.
const MAX_LEVEL: f32 = 40.0;

/// Hashed alpha testing with grains of a size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hashed {
    scale_px: f32,
}

impl Hashed {
    pub(super) fn new(values: &Values) -> Self {
        Self { scale_px: values.real("scale") }
    }

    pub(super) fn accept<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.threshold(self)
    }

    /// The blend of both cells' numbers, and the weight of the smaller cell.
    #[inline]
    fn blend(self, site: &Site) -> (f32, f32) {
        // Cells in an object unit, as an octave.
        let level = -(site.footprint_in_object * self.scale_px).log2();
        let level = level.clamp(-MAX_LEVEL, MAX_LEVEL);
        let larger = level.floor();
        let [object, ..] = pcg3d([site.instance, site.geometry << 1 | site.back, site.seed]);
        let [larger_draw, smaller_draw] = [larger, larger + 1.0].map(|octave| {
            // Wraps around far away, where a saturating conversion would put all places into one cell.
            let cell = |coordinate: f32| (coordinate * octave.exp2()).floor() as i64 as u32;
            let [x, y, z] = site.position_in_object.to_array().map(cell);
            let [moment, ..] = pcg3d([object, site.frame, octave as i32 as u32]);
            unit_from_bits(pcg4d([x, y, z, moment])[3])
        });
        let weight = level - larger;
        ((1.0 - weight) * larger_draw + weight * smaller_draw, weight)
    }
}

impl Threshold for Hashed {
    fn uses_object_space(&self) -> bool {
        true
    }

    #[inline]
    fn threshold(&self, site: &Site, _: &Tables) -> f32 {
        let (blend, weight) = self.blend(site);
        uniform_from_blend(blend, weight).min(BELOW_ONE)
    }
}

/// The cumulative distribution of `(1 - weight) A + weight B` for uniform A and B, at `blend`. Its density is
/// a trapezoid: it rises over the smaller of both weights, is level, and falls again.
#[inline]
fn uniform_from_blend(blend: f32, weight: f32) -> f32 {
    let ramp = weight.min(1.0 - weight);
    if blend < ramp {
        blend * blend / (2.0 * ramp * (1.0 - ramp))
    } else if blend <= 1.0 - ramp {
        (blend - 0.5 * ramp) / (1.0 - ramp)
    } else {
        let rest = 1.0 - blend;
        1.0 - rest * rest / (2.0 * ramp * (1.0 - ramp))
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use sheer_core::hash::Pcg32;

    use super::*;

    const HASHED: Hashed = Hashed { scale_px: 1.0 };

    /// Far more places than cells would repeat, all seen at one weight between two sizes of cells.
    fn sites(weight: f32) -> impl Iterator<Item = Site> {
        let mut random = Pcg32::new(1, 0);
        (0..1 << 16).map(move |_| Site {
            position_in_object: [(); 3].map(|()| random.range(-1e4, 1e4)).into(),
            footprint_in_object: (-3.0 - weight).exp2(),
            ..Site::default()
        })
    }

    /// Standard deviations by which the chi-square statistic of 256 equally likely bins exceeds its mean.
    fn chi_square_z(values: impl Iterator<Item = f32>) -> f64 {
        let mut counts = [0_u32; 256];
        values.for_each(|value| counts[(value * 256.0) as usize] += 1);
        let expected = f64::from(counts.iter().sum::<u32>()) / 256.0;
        let chi_square: f64 =
            counts.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
        (chi_square - 255.0) / (2.0 * 255.0_f64).sqrt()
    }

    #[test]
    fn thresholds_are_uniform_at_every_distance_and_the_bare_blend_is_not() {
        let tables = Tables::get();
        for weight in [0.0, 0.1, 0.25, 0.5, 0.75, 0.9] {
            let z = chi_square_z(sites(weight).map(|site| HASHED.threshold(&site, &tables)));
            assert!(z.abs() < 4.0, "weight {weight}: z = {z}");
            if weight > 0.0 {
                let z = chi_square_z(sites(weight).map(|site| HASHED.blend(&site).0));
                assert!(z > 20.0, "weight {weight}: z = {z}, the test is blind");
            }
        }
    }

    #[test]
    fn the_correction_is_continuous_and_spans_zero_to_one() {
        for weight in [0.0, 1e-6, 0.1, 0.5, 0.7, 1.0] {
            assert_eq!(uniform_from_blend(0.0, weight), 0.0);
            assert!((uniform_from_blend(1.0, weight) - 1.0).abs() < 1e-6);
            let steps: Vec<f32> =
                (0..=1000).map(|step| uniform_from_blend(step as f32 / 1e3, weight)).collect();
            assert!(steps.windows(2).all(|pair| (0.0..0.003).contains(&(pair[1] - pair[0]))), "{weight}");
        }
    }

    #[test]
    fn within_a_cell_of_both_sizes_the_threshold_is_one_and_the_same() {
        let at = |x: f32, frame| {
            let site = Site {
                position_in_object: Vec3::new(x, 0.3, 0.3),
                footprint_in_object: 0.7,
                frame,
                ..Site::default()
            };
            HASHED.threshold(&site, &Tables::get())
        };
        // Cells of a half and of one unit.
        assert_eq!(at(0.05, 0), at(0.45, 0));
        assert_ne!(at(0.45, 0), at(0.55, 0));
        assert_ne!(at(0.95, 0), at(1.05, 0));
        assert_ne!(at(0.05, 0), at(0.05, 1), "each frame draws anew");
    }

    #[test]
    fn a_footprint_of_any_size_gives_a_threshold() {
        for footprint in [0.0, f32::MIN_POSITIVE, 1e30, f32::MAX, f32::INFINITY] {
            let site = Site { footprint_in_object: footprint, ..Site::default() };
            let threshold = HASHED.threshold(&site, &Tables::get());
            assert!((0.0..1.0).contains(&threshold), "{footprint}: {threshold}");
        }
    }
}
