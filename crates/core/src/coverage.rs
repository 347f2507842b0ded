//! From the opacity of a material to the coverage that a stochastic method is fed with, where what resolves
//! its frames over time would otherwise show another opacity (STD section 3.2.1).

/// A cubic from wanted opacity to the coverage that shows it: `c0 + c1 α + c2 α² + c3 α³`, clamped to 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    coefficients: [f32; 4],
}

impl Correction {
    /// Coverage is opacity, to the bit.
    pub const NONE: Self = Self { coefficients: [0.0, 1.0, 0.0, 0.0] };
    /// The correction for upscalers that suppress flicker, fitted to DLSS and used for FSR as well (STD Eq.
    /// 5).
    pub const DLSS: Self = Self { coefficients: [0.0113, 1.656, -0.821, 0.156] };

    /// The correction with the coefficients `c0` to `c3`; `None` if one is not finite.
    #[must_use]
    pub fn new(coefficients: [f32; 4]) -> Option<Self> {
        coefficients.iter().all(|coefficient| coefficient.is_finite()).then_some(Self { coefficients })
    }

    /// Least squares through pairs of a displayed opacity and the coverage that displayed it. `None` if fewer
    /// than four displayed opacities differ.
    #[must_use]
    pub fn fit(displayed_and_fed: &[[f64; 2]]) -> Option<Self> {
        // The normal equations, their right side in the last column.
        let mut rows = [[0.0_f64; 5]; 4];
        for &[displayed, fed] in displayed_and_fed {
            let powers = [1.0, displayed, displayed * displayed, displayed.powi(3)];
            for (row, factor) in rows.iter_mut().zip(powers) {
                for (cell, term) in row.iter_mut().zip(powers.into_iter().chain([fed])) {
                    *cell += factor * term;
                }
            }
        }
        let greatest = rows.iter().flatten().fold(0.0_f64, |greatest, cell| greatest.max(cell.abs()));
        for at in 0..4 {
            let pivot = (at..4).max_by(|&a, &b| rows[a][at].abs().total_cmp(&rows[b][at].abs()))?;
            rows.swap(at, pivot);
            let from = rows[at];
            // Rounding leaves this much where an exact sum would be zero.
            if from[at].abs().partial_cmp(&(greatest * 1e-12)) != Some(std::cmp::Ordering::Greater) {
                return None;
            }
            for (_, row) in rows.iter_mut().enumerate().filter(|(other, _)| *other != at) {
                let share = row[at] / from[at];
                for (cell, term) in row.iter_mut().zip(from) {
                    *cell -= share * term;
                }
            }
        }
        Self::new(std::array::from_fn(|at| (rows[at][4] / rows[at][at]) as f32))
    }

    /// The coefficients `c0` to `c3`.
    #[must_use]
    pub fn coefficients(&self) -> [f32; 4] {
        self.coefficients
    }

    /// The coverage, 0 to 1, for a material's opacity, 0 to 1.
    ///
    /// Nothing stays nothing and opaque stays opaque, whatever the cubic says there. This deviates from STD
    /// Eq. 5, where an opacity of 0 has a coverage of 0.0113: invisible surfaces would be seen.
    #[must_use]
    #[inline]
    pub fn coverage(&self, alpha: f32) -> f32 {
        if alpha <= 0.0 || alpha >= 1.0 {
            return alpha;
        }
        let [c0, c1, c2, c3] = self.coefficients;
        (((c3 * alpha + c2) * alpha + c1) * alpha + c0).clamp(0.0, 1.0)
    }
}

impl Default for Correction {
    fn default() -> Self {
        Self::NONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_correction_changes_no_bit() {
        for step in 0..=1000 {
            let alpha = step as f32 / 1000.0;
            assert_eq!(Correction::NONE.coverage(alpha).to_bits(), alpha.to_bits());
        }
    }

    #[test]
    fn equation_5_is_evaluated_inside_and_exact_at_both_ends() {
        let coverage = |alpha| Correction::DLSS.coverage(alpha);
        // 0.0113 + 0.828 - 0.20525 + 0.0195
        assert!((coverage(0.5) - 0.653_55).abs() < 1e-6, "{}", coverage(0.5));
        assert_eq!([coverage(0.0), coverage(1.0)], [0.0, 1.0]);
        let steep = Correction::new([-0.5, 3.0, 0.0, 0.0]).unwrap();
        assert_eq!([steep.coverage(0.1), steep.coverage(0.9)], [0.0, 1.0]);
        assert_eq!(Correction::new([0.0, f32::NAN, 0.0, 0.0]), None);
    }

    #[test]
    fn a_fit_finds_the_cubic_it_was_given() {
        let cubic = |x: f64| 0.0113 + 1.656 * x - 0.821 * x * x + 0.156 * x.powi(3);
        let points: Vec<_> = (1..=10).map(|level| f64::from(level) / 10.0).map(|x| [x, cubic(x)]).collect();
        let fitted = Correction::fit(&points).unwrap().coefficients();
        for (fitted, given) in fitted.into_iter().zip(Correction::DLSS.coefficients()) {
            assert!((fitted - given).abs() < 1e-5, "{fitted} for {given}");
        }
    }

    #[test]
    fn too_few_different_points_have_no_fit() {
        let points = [[0.1, 0.1], [0.5, 0.5], [0.5, 0.6], [1.0, 1.0], [0.1, 0.2]];
        assert_eq!(Correction::fit(&points), None);
        assert_eq!(Correction::fit(&[]), None);
    }
}
