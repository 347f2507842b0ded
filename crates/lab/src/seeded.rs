//! One thing measured with several seeds: means, and how sure they are.
//!
//! The figures of single seeds are taken for independent and normal, as Student's interval has it; each is a
//! mean over many pixels already.

use sheer_metrics::statistics::Moments;

/// Probability with which an interval holds the mean over all seeds.
const CONFIDENCE: f64 = 0.95;

/// What was measured of one thing: once, or once with each of several seeds.
#[derive(Clone, Debug)]
pub struct Seeded<R> {
    first: R,
    others: Vec<R>,
    /// Whether the one run stands for all seeds, as nothing in it is random.
    is_once_for_all: bool,
}

/// A figure over seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// None where a seed has none: what equals the reference with one of them has no mean error in decibels.
    pub mean: Option<f64>,
    /// Half of its 95 % confidence interval; none of a single run of what is random, or timed.
    pub half_width: Option<f64>,
}

impl<R> Seeded<R> {
    /// One run for each seed, that of the first seed first; nothing without any.
    #[must_use]
    pub fn of(runs: Vec<R>) -> Option<Self> {
        let mut runs = runs.into_iter();
        Some(Self { first: runs.next()?, others: runs.collect(), is_once_for_all: false })
    }

    /// The one run of something that does not know the seed, beside others that do.
    #[must_use]
    pub fn once_for_all(run: R) -> Self {
        Self { first: run, others: Vec::new(), is_once_for_all: true }
    }

    /// Takes the run of another seed.
    pub fn add(&mut self, run: R) {
        self.others.push(run);
        self.is_once_for_all = false;
    }

    /// That of the first seed.
    #[must_use]
    pub fn first(&self) -> &R {
        &self.first
    }

    /// That of the first seed alone.
    #[must_use]
    pub fn into_first(self) -> R {
        self.first
    }

    /// All of them.
    pub fn runs(&self) -> impl Iterator<Item = &R> {
        std::iter::once(&self.first).chain(&self.others)
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        1 + self.others.len()
    }

    /// Whether there is one run that stands for all seeds.
    #[must_use]
    pub fn is_once_for_all(&self) -> bool {
        self.is_once_for_all
    }

    /// Something of each run.
    pub fn map<'r, T>(&'r self, mut of: impl FnMut(&'r R) -> T) -> Seeded<T> {
        Seeded {
            first: of(&self.first),
            others: self.others.iter().map(of).collect(),
            is_once_for_all: self.is_once_for_all,
        }
    }

    /// Something of each run, or why a run has none.
    ///
    /// # Errors
    /// The first one of `of`.
    pub fn try_map<'r, T, E>(&'r self, mut of: impl FnMut(&'r R) -> Result<T, E>) -> Result<Seeded<T>, E> {
        let first = of(&self.first)?;
        let others = self.others.iter().map(of).collect::<Result<_, _>>()?;
        Ok(Seeded { first, others, is_once_for_all: self.is_once_for_all })
    }

    /// A figure of the runs, which is measured by a clock or not.
    pub fn estimate(&self, is_time: bool, figure: impl Fn(&R) -> Option<f64>) -> Estimate {
        let Some(moments) = self.runs().map(figure).collect::<Option<Moments>>() else {
            return Estimate { mean: None, half_width: None };
        };
        let half_width = if self.is_once_for_all && !is_time {
            Some(0.0)
        } else {
            moments.half_width(CONFIDENCE).filter(|half_width| half_width.is_finite())
        };
        Estimate { mean: Some(moments.mean()), half_width }
    }

    /// The mean of a figure over the runs.
    pub fn mean(&self, figure: impl Fn(&R) -> Option<f64>) -> Option<f64> {
        self.estimate(false, figure).mean
    }
}

#[cfg(test)]
mod tests {
    use sheer_render::{Antialiasing, Settings, Shadow, Stage, backend::Cpu, shadow::SHADOWS};
    use sheer_scene::CameraChoice;

    use super::*;
    use crate::{Clip, Measured, Silent, with_reference};

    const SEEDS: [u32; 3] = [4, 9, 5];

    fn stage(scene: &str) -> Stage {
        Stage::new(sheer_gallery::open(scene).unwrap().scene, &CameraChoice::Default, None).unwrap()
    }

    fn measured(
        stage: &mut Stage,
        settings: Settings,
        methods: &[&str],
        seeds: &[u32],
    ) -> Vec<Seeded<Measured>> {
        let clip = Clip { settings, antialiasing: Antialiasing::TAA, frame_count: 2, keeps_frames: false };
        let methods = methods.iter().map(|method| method.parse().unwrap()).collect();
        let methods = with_reference(methods).unwrap();
        clip.play_beside(&Cpu, stage, (&methods, seeds), None, &[], &Silent).unwrap().0
    }

    #[test]
    fn seeds_differ_where_something_is_random_and_nowhere_else() {
        let settings = Settings { size: [24, 14], ..Settings::default() };
        let mut stage = stage("pane");
        let all = measured(&mut stage, settings, &["std", "weighted"], &SEEDS);
        let counts: Vec<usize> = all.iter().map(Seeded::count).collect();
        assert_eq!(counts, [1, 3, 3]);
        let rms = |row: &Measured| Some(row.rms);
        let [reference, std, weighted] = [0, 1, 2].map(|at| all[at].estimate(false, rms));
        assert_eq!(reference, Estimate { mean: Some(0.0), half_width: Some(0.0) });
        assert!(std.half_width.unwrap() > 0.0 && std.mean.unwrap() > 0.0, "{std:?}");
        assert_eq!(weighted.half_width, Some(0.0));
        assert_eq!(all[0].estimate(true, |row| Some(row.ms_median)).half_width, None, "timed once");
        assert!(all[2].estimate(true, |row| Some(row.ms_median)).half_width.is_some());
        // Each run is that of its seed alone, and the mean theirs.
        let mut sum = 0.0;
        for (run, seed) in all[1].runs().zip(SEEDS) {
            let alone = measured(&mut stage, Settings { seed, ..settings }, &["std"], &[seed]);
            assert_eq!(alone[1].first().rms, run.rms, "{seed}");
            assert_eq!(alone[1].estimate(false, rms).half_width, None);
            sum += run.rms;
        }
        assert!((std.mean.unwrap() - sum / 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_exact_answer_knows_the_seed_where_shadows_say_so_and_nowhere_else() {
        // Smoke shadows the square in parts.
        let mut stage = stage("smoke-square");
        for info in SHADOWS {
            let key = info.parameters.iter().find(|parameter| parameter.key == "resolution");
            let text = key.map_or(info.id.to_owned(), |_| format!("{}:resolution=64", info.id));
            let shadow: Shadow = text.parse().unwrap();
            let mut picture = |seed| {
                let settings = Settings { size: [24, 14], shadow, seed, ..Settings::default() };
                measured(&mut stage, settings, &[], &[seed])[0].first().picture.as_slice().to_vec()
            };
            assert_eq!(picture(1) != picture(2), shadow.is_random(), "{text}");
        }
    }
}
