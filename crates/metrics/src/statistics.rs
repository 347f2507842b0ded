//! Sampling statistics: is a difference more than chance, and how are numbers spread.

use std::f64::consts::{PI, SQRT_2};

/// Mean and variance of numbers that come one at a time (Welford 1962: one pass, no cancellation).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    squares: f64,
}

impl Moments {
    /// Takes the next number.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    /// How many numbers there are.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean of the values, 0 without any.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// The sample variance of the values, 0 for less than two.
    #[must_use]
    pub fn variance(&self) -> f64 {
        if self.count > 1 { self.squares / (self.count - 1) as f64 } else { 0.0 }
    }

    /// Variance of the mean, 0 for less than two numbers.
    #[must_use]
    pub fn variance_of_mean(&self) -> f64 {
        self.variance() / self.count.max(1) as f64
    }

    /// Half of the interval around the mean that holds the true one with probability `confidence` where the
    /// numbers are independent and normal (Student 1908); none for less than two numbers.
    #[must_use]
    pub fn half_width(&self, confidence: f64) -> Option<f64> {
        let degrees = u32::try_from(self.count.checked_sub(1)?).unwrap_or(u32::MAX);
        (degrees > 0).then(|| student_t(1.0 - confidence, degrees) * self.variance_of_mean().sqrt())
    }
}

impl Extend<f64> for Moments {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, values: I) {
        values.into_iter().for_each(|value| self.add(value));
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::default();
        moments.extend(values);
        moments
    }
}

/// A difference in units of its standard error. Nothing differs by nothing: 0 over 0 is 0, anything else over
/// 0 infinite.
#[must_use]
pub fn z_score(difference: f64, standard_error: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference / standard_error }
}

/// The probability that a standard normal number is at least as far from 0 as `z`. 0 for an infinite `z`, NaN
/// for NaN.
#[must_use]
pub fn two_sided_p(z: f64) -> f64 {
    // erfc(|z| / √2), and erfc(x) is Q(1/2, x²).
    upper_gamma_of_half(1, (z / SQRT_2).powi(2))
}

/// The probability that the sum of `degrees` squared standard normal numbers is at least `statistic`.
#[must_use]
pub fn chi_square_p(statistic: f64, degrees: u32) -> f64 {
    upper_gamma_of_half(degrees, statistic / 2.0)
}

/// The standard normal number that is as rare as a chi-square one (Wilson and Hilferty 1931).
#[must_use]
pub fn wilson_hilferty(chi_square: f64, degrees: f64) -> f64 {
    let spread = 2.0 / (9.0 * degrees);
    ((chi_square / degrees).cbrt() - (1.0 - spread)) / spread.sqrt()
}

/// The probability that a number of Student's distribution is at least as far from 0 as `t` (Abramowitz and
/// Stegun 1964, 26.7.3 and 26.7.4). 1 without degrees of freedom: nothing is known then.
#[must_use]
pub fn student_t_p(t: f64, degrees: u32) -> f64 {
    if degrees == 0 {
        return 1.0;
    }
    let angle = (t.abs() / f64::from(degrees).sqrt()).atan();
    let (sine, cosine) = angle.sin_cos();
    // Each term is the one before times cos² and the next fraction: even numbers over odd ones, or the other
    // way round.
    let first = if degrees % 2 == 1 { cosine } else { 1.0 };
    let (mut term, mut sum) = (first, if degrees == 1 { 0.0 } else { first });
    let mut power = degrees % 2 + 2;
    while power < degrees {
        term *= cosine * cosine * f64::from(power - 1) / f64::from(power);
        sum += term;
        power += 2;
    }
    let inside = if degrees % 2 == 1 { (angle + sine * sum) * 2.0 / PI } else { sine * sum };
    (1.0 - inside).clamp(0.0, 1.0)
}

/// The positive `t` with the given [`student_t_p`], in (0, 1]; infinite without degrees of freedom.
#[must_use]
pub fn student_t(probability: f64, degrees: u32) -> f64 {
    if degrees == 0 {
        return f64::INFINITY;
    }
    let mut high = 1.0;
    while student_t_p(high, degrees) > probability && high < f64::MAX / 2.0 {
        high *= 2.0;
    }
    let mut low = 0.0;
    // Each step halves the interval: 60 are more than a double can tell apart.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if student_t_p(middle, degrees) > probability { low = middle } else { high = middle }
    }
    high
}

/// The level at which each of `tests` independent tests has to be held so that all together err with
/// probability `level` (Šidák 1967).
#[must_use]
pub fn sidak(level: f64, tests: u64) -> f64 {
    // 1 - (1 - level)^(1 / tests), without losing the digits of small levels.
    -((-level).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// The probability that the least of `tests` independent probabilities is at most `least` although nothing is
/// wrong: the other way round.
#[must_use]
pub fn sidak_family(least: f64, tests: u64) -> f64 {
    -((-least).ln_1p() * tests.max(1) as f64).exp_m1()
}

/// The positive `z` with the given [`two_sided_p`], in (0, 1]; at most 38, beyond which probabilities are 0.
#[must_use]
pub fn two_sided_z(probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 38.0);
    // Each step halves the interval: 60 are more than a double can tell apart.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if two_sided_p(middle) > probability { low = middle } else { high = middle }
    }
    low
}

/// The `share`-quantile of numbers, 0 the least, 1 the greatest, 0.5 the median, linear in between. NaN
/// without numbers.
#[must_use]
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let rank = share.clamp(0.0, 1.0) * last as f64;
    let (below, above) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
    below + (above - below) * rank.fract()
}

/// The regularised upper incomplete gamma function Q(a, x) for a = `twice_a` / 2 (DLMF section 8.2).
fn upper_gamma_of_half(twice_a: u32, x: f64) -> f64 {
    // Changes beyond this share of a sum are below double precision.
    const PRECISION: f64 = 1e-16;
    let a = f64::from(twice_a) / 2.0;
    if twice_a == 0 || x == f64::INFINITY {
        return 0.0;
    }
    if x <= 0.0 {
        return 1.0;
    }
    // x^a e^-x / Γ(a)
    let scale = (a * x.ln() - x - ln_gamma_of_half(twice_a)).exp();
    if x < a + 1.0 {
        // DLMF 8.7.1: P(a, x) = x^a e^-x / Γ(a) · Σ x^n / (a (a+1) … (a+n)).
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, 1.0);
        while term > sum * PRECISION {
            term *= x / (a + n);
            sum += term;
            n += 1.0;
        }
        return (1.0 - scale * sum).max(0.0);
    }
    // DLMF 8.9.2 in its even form, 1/(x+1-a - 1(1-a)/(x+3-a - 2(2-a)/(x+5-a - …))), evaluated forwards as a
    // product of ratios of successive numerators and denominators (modified Lentz; Thompson and Barnett
    // 1986).
    let mut b = x + 1.0 - a;
    let (mut denominator, mut numerator) = (1.0 / b, f64::MAX);
    let mut fraction = denominator;
    let mut n = 1.0;
    loop {
        let partial = -n * (n - a);
        b += 2.0;
        denominator = 1.0 / (partial * denominator + b);
        numerator = b + partial / numerator;
        let ratio = numerator * denominator;
        fraction *= ratio;
        n += 1.0;
        if (ratio - 1.0).abs() <= PRECISION.max(f64::EPSILON) || ratio.is_nan() {
            return scale * fraction;
        }
    }
}

/// ln Γ(`twice_a` / 2), by Γ(a) = (a-1) Γ(a-1) down to Γ(1) = 1 or Γ(1/2) = √π.
fn ln_gamma_of_half(twice_a: u32) -> f64 {
    let (first, start) = if twice_a.is_multiple_of(2) { (2, 0.0) } else { (1, PI.sqrt().ln()) };
    start + (first..twice_a).step_by(2).map(|twice| (f64::from(twice) / 2.0).ln()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use sheer_core::hash::Pcg32;

    use super::*;

    #[test]
    fn students_distribution_has_its_printed_quantiles() {
        // Two-sided 5 % and 1 % points, from any table.
        for (degrees, five, one) in
            [(1, 12.706, 63.657), (2, 4.303, 9.925), (3, 3.182, 5.841), (4, 2.776, 4.604), (9, 2.262, 3.250)]
        {
            for (quantile, p) in [(five, 0.05), (one, 0.01)] {
                // Tables round to three decimals.
                let around = [quantile + 0.0005, quantile - 0.0005].map(|t| student_t_p(t, degrees));
                assert!(around[0] <= p && p <= around[1], "{degrees}: {around:?}");
                assert_eq!(student_t_p(-quantile, degrees), student_t_p(quantile, degrees));
            }
        }
        // With many degrees it is the normal one.
        assert!((student_t_p(1.96, 10_000) / two_sided_p(1.96) - 1.0).abs() < 1e-3);
        assert_eq!([student_t_p(0.0, 7), student_t_p(9.0, 0)], [1.0, 1.0]);
    }

    #[test]
    fn half_widths_have_their_closed_forms() {
        // With one degree of freedom the distribution is Cauchy's, with two a root (Student 1908).
        for p in [0.01, 0.05, 0.5_f64] {
            let cauchy = (0.5 * PI * (1.0 - p)).tan();
            assert!((student_t(p, 1) / cauchy - 1.0).abs() < 1e-9, "{p}: {}", student_t(p, 1));
            let root = (1.0 - p) * (2.0 / (1.0 - (1.0 - p).powi(2))).sqrt();
            assert!((student_t(p, 2) / root - 1.0).abs() < 1e-9, "{p}: {}", student_t(p, 2));
        }
        assert_eq!(student_t(0.05, 0), f64::INFINITY);
        // 3 and 5: a deviation of √2 over √2 numbers, times tan(0.475 π).
        let half_width = |values: &[f64]| values.iter().copied().collect::<Moments>().half_width(0.95);
        let pair = half_width(&[3.0, 5.0]).unwrap();
        assert!((pair - (0.475 * PI).tan()).abs() < 1e-6, "{pair}");
        let three = half_width(&[1.0, 2.0, 3.0]).unwrap();
        assert!((three - 0.95 * (2.0 / (1.0 - 0.9025_f64)).sqrt() / 3.0_f64.sqrt()).abs() < 1e-9, "{three}");
        // What never varies is certain, and of one number nothing is known.
        assert_eq!([half_width(&[0.1; 7]), half_width(&[0.1]), half_width(&[])], [Some(0.0), None, None]);
    }

    #[test]
    fn intervals_hold_the_true_mean_as_often_as_they_say() {
        const RUNS: u32 = 20_000;
        const SEEDS: u32 = 3;
        let mut random = Pcg32::new(11, 2);
        // Box and Muller 1958.
        let mut normal = || {
            let [u, v] = [(); 2].map(|()| f64::from(random.next_f32()));
            (-2.0 * (1.0 - u).ln()).sqrt() * (2.0 * PI * v).cos()
        };
        let (mut held, mut held_by_normal) = (0, 0);
        for _ in 0..RUNS {
            let moments: Moments = (0..SEEDS).map(|_| 7.0 + 0.5 * normal()).collect();
            let error = (moments.mean() - 7.0).abs();
            held += u32::from(error <= moments.half_width(0.95).unwrap());
            held_by_normal += u32::from(error <= two_sided_z(0.05) * moments.variance_of_mean().sqrt());
        }
        let z = |held: u32| {
            let (share, deviation) = (f64::from(held) / f64::from(RUNS), (0.95_f64 * 0.05).sqrt());
            z_score(share - 0.95, deviation / f64::from(RUNS).sqrt())
        };
        assert!(two_sided_p(z(held)) > 0.001, "{held} of {RUNS}");
        assert!(
            two_sided_p(z(held_by_normal)) < 0.001,
            "three numbers taken for normal pass: {held_by_normal}"
        );
    }

    #[test]
    fn the_normal_number_of_a_chi_square_one_has_its_probability() {
        for chi_square in [14.0, 21.0, 30.0] {
            let z = wilson_hilferty(chi_square, 12.0);
            assert!((two_sided_p(z) / 2.0 / chi_square_p(chi_square, 12) - 1.0).abs() < 0.05);
        }
    }

    #[test]
    fn probabilities_and_normal_numbers_turn_into_each_other() {
        for z in [0.1, 1.96, 4.0, 8.0] {
            assert!((two_sided_z(two_sided_p(z)) - z).abs() < 1e-6, "{z}");
        }
        assert!(two_sided_z(1.0) < 1e-6);
        assert!((sidak_family(sidak(0.05, 1000), 1000) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn tails_agree_with_tables() {
        // R: 2 * pnorm(-z), pchisq(x, k, lower.tail = FALSE).
        for (z, p) in [
            (0.0, 1.0),
            (1.0, 0.317_310_507_862_914),
            (1.959_963_984_540_054, 0.05),
            (-3.0, 0.002_699_796_063_260_19),
            (6.0, 1.973_175_290_075_4e-9),
        ] {
            assert!((two_sided_p(z) / p - 1.0).abs() < 1e-10, "{z}: {}", two_sided_p(z));
        }
        for (x, k, p) in [
            (3.841_458_820_694_124, 1, 0.05),
            (18.307_038_053_275_146, 10, 0.05),
            (124.342_113_404_004, 100, 0.05),
            (2.0, 2, (-1.0_f64).exp()),
        ] {
            assert!((chi_square_p(x, k) / p - 1.0).abs() < 1e-9, "{x}, {k}: {}", chi_square_p(x, k));
        }
        assert_eq!((two_sided_p(f64::INFINITY), chi_square_p(0.0, 5)), (0.0, 1.0));
        assert!(two_sided_p(f64::NAN).is_nan());
    }

    #[test]
    fn large_degrees_approach_the_normal_distribution() {
        // Wilson and Hilferty 1931.
        let degrees = 20_000;
        let k = f64::from(degrees);
        let x = k * (1.0 - 2.0 / (9.0 * k) + 1.5 * (2.0 / (9.0 * k)).sqrt()).powi(3);
        assert!((chi_square_p(x, degrees) - two_sided_p(1.5) / 2.0).abs() < 1e-5);
    }

    #[test]
    fn uniform_numbers_pass_and_a_slight_lean_is_found() {
        let mut random = Pcg32::new(7, 1);
        let numbers: Vec<f64> = (0..20_000).map(|_| f64::from(random.next_f32())).collect();
        let z = |shift: f64| {
            let moments: Moments = numbers.iter().map(|number| number + shift).collect();
            z_score(moments.mean() - 0.5, moments.variance_of_mean().sqrt())
        };
        assert!(two_sided_p(z(0.0)) > 0.001);
        assert!(two_sided_p(z(0.01)) < 0.001, "a bias of 2 % passes");
    }

    #[test]
    fn many_tests_together_err_as_often_as_one() {
        let each = sidak(0.01, 1000);
        assert!(((1.0 - each).powi(1000) - 0.99).abs() < 1e-12);
        assert_eq!(sidak(0.05, 1), sidak(0.05, 0));
        assert!((sidak(0.05, 1) - 0.05).abs() < 1e-15);
        assert!(sidak(1e-12, 10) > 0.0, "small levels vanish");
    }

    #[test]
    fn nothing_over_nothing_is_no_difference_and_anything_else_an_infinite_one() {
        assert_eq!(z_score(0.0, 0.0), 0.0);
        assert_eq!(z_score(0.1, 0.0), f64::INFINITY);
        assert_eq!(z_score(-0.5, 0.25), -2.0);
    }

    #[test]
    fn moments_and_quantiles_of_a_few_numbers() {
        let moments: Moments = [2.0, 4.0, 9.0].into_iter().collect();
        assert_eq!((moments.count(), moments.mean(), moments.variance()), (3, 5.0, 13.0));
        assert_eq!(Moments::default().variance_of_mean(), 0.0);
        let numbers = [9.0, 1.0, 3.0, 5.0];
        assert_eq!([0.0, 0.5, 1.0].map(|share| quantile(&numbers, share)), [1.0, 4.0, 9.0]);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
