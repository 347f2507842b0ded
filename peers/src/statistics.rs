//! Medians, ratios of turns, slopes.

/// The middle of some values; the mean of both if there are two.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    if sorted.is_empty() {
        f64::NAN
    } else if sorted.len() % 2 == 1 {
        sorted[middle]
    } else {
        0.5 * (sorted[middle - 1] + sorted[middle])
    }
}

/// How many times as long one took as another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ratio {
    pub(crate) median: f64,
    pub(crate) min: f64,
    pub(crate) max: f64,
}

/// The ratios of times of the same turn: what slows the machine down slows both.
pub(crate) fn ratio(slower: &[f64], faster: &[f64]) -> Ratio {
    let ratios: Vec<f64> = slower.iter().zip(faster).map(|(slower, faster)| slower / faster).collect();
    Ratio {
        median: median(&ratios),
        min: ratios.iter().copied().fold(f64::INFINITY, f64::min),
        max: ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    }
}

/// The exponent `s` of the law `y = c * x^s` that fits points best: least squares of the logarithms.
pub(crate) fn exponent(points: &[[f64; 2]]) -> f64 {
    let logarithms: Vec<[f64; 2]> = points.iter().map(|point| point.map(f64::ln)).collect();
    let mean = |axis: usize| logarithms.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64;
    let [x_mean, y_mean] = [mean(0), mean(1)];
    let covariance: f64 = logarithms.iter().map(|[x, y]| (x - x_mean) * (y - y_mean)).sum();
    let variance: f64 = logarithms.iter().map(|[x, _]| (x - x_mean).powi(2)).sum();
    covariance / variance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(&[]).is_nan());
    }

    #[test]
    fn ratios_are_those_of_turns() {
        let ratio = ratio(&[2.0, 40.0, 3.0], &[1.0, 10.0, 1.0]);
        assert_eq!(ratio, Ratio { median: 3.0, min: 2.0, max: 4.0 });
    }

    #[test]
    fn the_exponent_of_a_power_is_found() {
        let points = [1.0, 10.0, 1e3].map(|x: f64| [x, 7.0 * x.powf(0.35)]);
        assert!((exponent(&points) - 0.35).abs() < 1e-12);
    }
}
