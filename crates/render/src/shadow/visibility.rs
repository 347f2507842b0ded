//! Visibility along one ray of light, true and stochastic: the data of ST Fig. 3.
//!
//! ```
//! use sheer_render::shadow::{Sampling, visibility::Blockers};
//!
//! let blockers = Blockers::random(12, 1);
//! let estimate = blockers.sample(256, Sampling::Stratified, 7);
//! assert!((estimate.at(0.5) - blockers.truth(0.5)).abs() < 0.2);
//! ```

use sheer_core::hash::Pcg32;

use super::mask::{self, Sampling};

/// Samples that share a texel, and so one mask a blocker: the paper's 8× MSAA. More samples are those of
/// several texels, as percentage closer filtering gathers them.
const TEXEL_SAMPLES: u32 = 8;

/// Opacities from which random blockers are drawn: thin enough that a dozen leave some light, thick enough to
/// show steps.
const ALPHAS: [f32; 2] = [0.05, 0.4];

/// Blockers along a ray of light, by depth from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Blockers {
    /// Depth and opacity of each, nearest to the light first.
    sorted: Vec<(f32, f32)>,
}

impl Blockers {
    /// `count` blockers at random depths with random opacities.
    #[must_use]
    pub fn random(count: u32, seed: u32) -> Self {
        let mut random = Pcg32::new(seed.into(), 3);
        let blocker = |_| (random.next_f32(), random.range(ALPHAS[0], ALPHAS[1]));
        Self::new((0..count).map(blocker))
    }

    /// Blockers with these depths and opacities.
    #[must_use]
    pub fn new(blockers: impl IntoIterator<Item = (f32, f32)>) -> Self {
        let mut sorted: Vec<_> = blockers.into_iter().collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { sorted }
    }

    /// Depth and opacity of each, nearest to the light first.
    #[must_use]
    pub fn sorted(&self) -> &[(f32, f32)] {
        &self.sorted
    }

    /// The visibility of what lies at a depth, `Π (1 - alpha)` of the blockers before it (ST Eq. 3).
    #[must_use]
    pub fn truth(&self, depth: f32) -> f32 {
        let before = self.sorted.iter().take_while(|blocker| blocker.0 < depth);
        before.map(|(_, alpha)| 1.0 - alpha).product()
    }

    /// What `samples` samples of a stochastic shadow map know of it. Another seed draws another map.
    #[must_use]
    pub fn sample(&self, samples: u32, sampling: Sampling, seed: u32) -> StochasticVisibility {
        let mut depths = vec![f32::INFINITY; samples as usize];
        for (texel, depths) in depths.chunks_mut(TEXEL_SAMPLES as usize).enumerate() {
            // From the last to the first, so that the nearest remains.
            for (index, &(depth, alpha)) in self.sorted.iter().enumerate().rev() {
                let seed = mask::seed(texel, index as u32, seed);
                let mask = sampling.mask(alpha, depths.len() as u32, seed);
                for (sample, nearest) in depths.iter_mut().enumerate() {
                    if mask >> sample & 1 != 0 {
                        *nearest = depth;
                    }
                }
            }
        }
        depths.sort_by(f32::total_cmp);
        StochasticVisibility { depths }
    }
}

/// A stochastic estimate of a visibility function: a stair that falls by one sample at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct StochasticVisibility {
    depths: Vec<f32>,
}

impl StochasticVisibility {
    /// Share of the samples that nothing before a depth has taken, `count(z ≤ zᵢ) / S` (ST Eq. 4).
    #[must_use]
    pub fn at(&self, depth: f32) -> f32 {
        let before = self.depths.partition_point(|sample| *sample < depth);
        1.0 - before as f32 / self.depths.len() as f32
    }

    /// Depths that the samples keep, ascending; infinite where a sample has kept nothing.
    #[must_use]
    pub fn depths(&self) -> &[f32] {
        &self.depths
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWS: u32 = 4_000;
    const PROBES: [f32; 5] = [0.1, 0.3, 0.5, 0.8, 2.0];

    /// Mean and variance of estimates at a depth.
    fn moments(draw: impl Fn(u32) -> StochasticVisibility, depth: f32) -> (f64, f64) {
        let values: Vec<f64> = (0..DRAWS).map(|seed| draw(seed).at(depth).into()).collect();
        let mean = values.iter().sum::<f64>() / f64::from(DRAWS);
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        (mean, squares / f64::from(DRAWS - 1))
    }

    fn z(blockers: &Blockers, depth: f32, (mean, variance): (f64, f64)) -> f64 {
        (mean - f64::from(blockers.truth(depth))) / (variance / f64::from(DRAWS)).sqrt().max(1e-9)
    }

    #[test]
    fn the_mean_of_stochastic_visibilities_is_the_truth() {
        let blockers = Blockers::random(12, 1);
        for sampling in [Sampling::Naive, Sampling::Stratified] {
            for samples in [1, 8, 32] {
                for depth in PROBES {
                    let z =
                        z(&blockers, depth, moments(|seed| blockers.sample(samples, sampling, seed), depth));
                    // 30 values: 4 standard deviations happen once in 500 runs.
                    assert!(z.abs() < 4.0, "{sampling:?}, {samples} samples, depth {depth}: z {z}");
                }
            }
        }
    }

    #[test]
    fn the_spread_falls_with_the_samples_and_with_strata() {
        let blockers = Blockers::random(12, 1);
        let spread =
            |samples, sampling, depth| moments(|seed| blockers.sample(samples, sampling, seed), depth).1;
        for depth in PROBES {
            let [few, more, many] = [8, 32, 256].map(|samples| spread(samples, Sampling::Stratified, depth));
            // Texels are independent: four times the samples, a quarter of the variance. Its estimate from
            // 4,000 draws is off by 2.3 %.
            assert!(
                (more * 4.0 / few - 1.0).abs() < 0.15 && (many * 32.0 / few - 1.0).abs() < 0.15,
                "{depth}"
            );
            assert!(few < 0.9 * spread(8, Sampling::Naive, depth), "{depth}: strata do not help");
            let truth = f64::from(blockers.truth(depth));
            let binomial = truth * (1.0 - truth) / 8.0;
            assert!(
                (spread(8, Sampling::Naive, depth) / binomial - 1.0).abs() < 0.15,
                "{depth}: naive is binomial"
            );
        }
    }

    #[test]
    fn one_mask_for_all_blockers_is_found_to_be_biased() {
        let blockers = Blockers::random(12, 1);
        let correlated = |seed| {
            let mut depths = [f32::INFINITY; 8];
            for &(depth, alpha) in blockers.sorted().iter().rev() {
                let mask = Sampling::Stratified.mask(alpha, 8, mask::seed(0, 0, seed));
                (0..8).filter(|sample| mask >> sample & 1 != 0).for_each(|sample| depths[sample] = depth);
            }
            depths.sort_by(f32::total_cmp);
            StochasticVisibility { depths: depths.into() }
        };
        assert!(z(&blockers, 2.0, moments(correlated, 2.0)) > 50.0, "the check is blind");
    }

    #[test]
    fn a_visibility_of_one_sample_is_a_step() {
        let blockers = Blockers::new([(0.5, 1.0), (0.2, 0.0)]);
        let estimate = blockers.sample(1, Sampling::Naive, 0);
        assert_eq!([0.3, 0.5, 0.6].map(|depth| estimate.at(depth)), [1.0, 1.0, 0.0]);
        assert_eq!([0.3, 0.5, 0.6].map(|depth| blockers.truth(depth)), [1.0, 1.0, 0.0]);
    }
}
