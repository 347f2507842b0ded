//! The truncated Hamburger moment problem: how much of a distribution lies in front of a depth, if only its
//! first moments are known.
//!
//! Among all distributions with these moments there is one that has as much as possible at the depth asked
//! for, `z`. Its other points are the zeros of `K(z, ·)`, where `K(x, y) = v(x)ᵀ B⁻¹ v(y)` with `v(x) = (1,
//! x, x², …)` and `B` the Hankel matrix of the moments, and each point `x` has the mass `1 / K(x, x)` (Peters
//! and Klein 2015, *Moment Shadow Mapping*, section 4; the form by masses is that of Gaussian quadrature).
//! What lies in front of `z` is sharply bounded by its mass in front without and with that at `z` itself.

/// The most moments in use.
pub(super) const MOST_MOMENTS: usize = 8;
/// Rows of the Hankel matrix of the most moments.
const MOST_ROWS: usize = MOST_MOMENTS / 2 + 1;
/// Rounding of sums in 32 bits may leave no pivot. One far below the bias of the moments, 5e-7 at least, says
/// that all lies at one depth.
const LEAST_PIVOT: f64 = 1e-10;

/// Moments of a distribution of mass 1, factorised.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    rows: usize,
    /// The triangular factor of `B = L D Lᵀ`, below its diagonal of ones.
    lower: [[f64; MOST_ROWS]; MOST_ROWS],
    /// The inverse of the diagonal of `D`.
    inverse_pivots: [f64; MOST_ROWS],
}

impl Problem {
    pub(super) const EMPTY: Self =
        Self { rows: 0, lower: [[0.0; MOST_ROWS]; MOST_ROWS], inverse_pivots: [0.0; MOST_ROWS] };

    /// The problem of an even number of moments, the first one and so on.
    pub(super) fn new(moments: &[f64]) -> Self {
        let mut problem = Self { rows: moments.len() / 2 + 1, ..Self::EMPTY };
        let hankel = |row: usize, column: usize| match row + column {
            0 => 1.0,
            order => moments[order - 1],
        };
        let mut pivots = [0.0; MOST_ROWS];
        for row in 0..problem.rows {
            for column in 0..=row {
                let lower = &problem.lower;
                let inner = (0..column).map(|k| lower[row][k] * lower[column][k] * pivots[k]).sum::<f64>();
                let rest = hankel(row, column) - inner;
                if column == row {
                    pivots[row] = rest.max(LEAST_PIVOT);
                    problem.inverse_pivots[row] = pivots[row].recip();
                } else {
                    problem.lower[row][column] = rest * problem.inverse_pivots[column];
                }
            }
        }
        problem
    }

    /// The share of the mass in front of `z`, with `overestimation` of what lies at `z` itself: 0 to 1.
    pub(super) fn share_in_front(&self, z: f64, overestimation: f64) -> f64 {
        let y = self.orthogonal(z);
        let kernel = self.kernel(&y);
        let mut roots = Roots::default();
        real_roots(&kernel[..self.rows], &mut roots);
        let in_front = roots.found().iter().filter(|root| **root < z);
        let share = in_front.map(|&root| self.mass(&self.orthogonal(root))).sum::<f64>()
            + overestimation * self.mass(&y);
        share.clamp(0.0, 1.0)
    }

    /// `y` of `L y = v(z)`: the orthogonal polynomials at `z`.
    fn orthogonal(&self, z: f64) -> [f64; MOST_ROWS] {
        let mut y = [0.0; MOST_ROWS];
        let mut power = 1.0;
        for row in 0..self.rows {
            let below = (0..row).map(|k| self.lower[row][k] * y[k]).sum::<f64>();
            y[row] = power - below;
            power *= z;
        }
        y
    }

    /// The most mass that can lie at `z`: `1 / yᵀ D⁻¹ y`.
    fn mass(&self, y: &[f64; MOST_ROWS]) -> f64 {
        (y.iter().zip(&self.inverse_pivots).map(|(y, inverse)| y * y * inverse).sum::<f64>()).recip()
    }

    /// The coefficients of `K(z, ·)` from the constant one up: `c` of `Lᵀ c = D⁻¹ y`.
    fn kernel(&self, y: &[f64; MOST_ROWS]) -> [f64; MOST_ROWS] {
        let mut kernel = [0.0; MOST_ROWS];
        for row in (0..self.rows).rev() {
            let above = (row + 1..self.rows).map(|k| self.lower[k][row] * kernel[k]).sum::<f64>();
            kernel[row] = y[row] * self.inverse_pivots[row] - above;
        }
        kernel
    }
}

/// Real roots, ascending.
#[derive(Clone, Copy, Debug, Default)]
struct Roots {
    roots: [f64; MOST_ROWS],
    len: usize,
}

impl Roots {
    fn found(&self) -> &[f64] {
        &self.roots[..self.len]
    }

    fn push(&mut self, root: f64) {
        self.roots[self.len] = root;
        self.len += 1;
    }
}

/// The real roots of a polynomial, from the constant coefficient up, where it changes its sign.
fn real_roots(coefficients: &[f64], roots: &mut Roots) {
    let Some(degree) = coefficients.iter().rposition(|&coefficient| coefficient != 0.0) else { return };
    let coefficients = &coefficients[..=degree];
    match *coefficients {
        [] | [_] => {}
        [constant, slope] => roots.push(-constant / slope),
        [c, b, a] => quadratic_roots(a, b, c, roots),
        _ => {
            // Between two neighbouring extrema there is one root at most, as there is beyond the outermost
            // ones.
            let mut derivative = [0.0; MOST_ROWS];
            for (index, &coefficient) in coefficients.iter().enumerate().skip(1) {
                derivative[index - 1] = index as f64 * coefficient;
            }
            let mut extrema = Roots::default();
            real_roots(&derivative[..degree], &mut extrema);
            let extrema = extrema.found();
            let (first, last) = match *extrema {
                [] => (0.0, 0.0),
                [first, .., last] | [first @ last] => (first, last),
            };
            let mut push = |ends: Option<[f64; 2]>| {
                if let Some(root) = ends.and_then(|ends| root_between(coefficients, ends)) {
                    roots.push(root);
                }
            };
            push(change_beyond(coefficients, first, -1.0).map(|[near, far]| [far, near]));
            extrema.windows(2).for_each(|pair| push(Some([pair[0], pair[1]])));
            push(change_beyond(coefficients, last, 1.0));
        }
    }
}

/// Two arguments, going up or down from one, between which the polynomial changes its sign. Most roots are
/// within a unit, so it begins small.
fn change_beyond(coefficients: &[f64], from: f64, direction: f64) -> Option<[f64; 2]> {
    let is_negative = |x| value_and_slope(coefficients, x).0 < 0.0;
    let begins_negative = is_negative(from);
    let (mut near, mut step) = (from, 0.125 * direction);
    // To 4^30 / 8: a root beyond is one at infinity, which has no mass.
    for _ in 0..30 {
        let far = from + step;
        if is_negative(far) != begins_negative {
            return Some([near, far]);
        }
        (near, step) = (far, 4.0 * step);
    }
    None
}

fn quadratic_roots(a: f64, b: f64, c: f64, roots: &mut Roots) {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant <= 0.0 {
        return;
    }
    // The sum of two of the same sign: nothing is cancelled out.
    let larger = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (one, other) = (larger / a, c / larger);
    roots.push(one.min(other));
    roots.push(one.max(other));
}

fn value_and_slope(coefficients: &[f64], x: f64) -> (f64, f64) {
    coefficients
        .iter()
        .rev()
        .fold((0.0, 0.0), |(value, slope), coefficient| (value * x + coefficient, slope * x + value))
}

/// Newton's method, with a bisection whenever it would leave the interval or does not halve its step.
fn root_between(coefficients: &[f64], [mut low, mut high]: [f64; 2]) -> Option<f64> {
    // Far below the rounding of 32-bit moments, and Newton's method squares what remains in its last step.
    const PRECISION: f64 = 1e-9;
    // Bisections alone take the widest interval down to that.
    const MOST_STEPS: u32 = 100;
    let low_is_negative = value_and_slope(coefficients, low).0 < 0.0;
    if low_is_negative == (value_and_slope(coefficients, high).0 < 0.0) {
        return None;
    }
    let (mut x, mut last_step) = (0.5 * (low + high), high - low);
    for _ in 0..MOST_STEPS {
        let (value, slope) = value_and_slope(coefficients, x);
        if (value < 0.0) == low_is_negative {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let converges = newton > low && newton < high && 2.0 * (newton - x).abs() < last_step;
        let next = if converges { newton } else { 0.5 * (low + high) };
        last_step = (next - x).abs();
        x = next;
        if last_step <= PRECISION * (1.0 + x.abs()) {
            break;
        }
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use sheer_core::hash::Pcg32;

    use super::*;

    /// Moments of points with masses that add up to 1.
    fn moments_of(points: &[(f64, f64)], order: i32) -> Vec<f64> {
        (1..=order).map(|power| points.iter().map(|(x, mass)| mass * x.powi(power)).sum()).collect()
    }

    fn roots_of(coefficients: &[f64]) -> Vec<f64> {
        let mut roots = Roots::default();
        real_roots(coefficients, &mut roots);
        roots.found().to_vec()
    }

    #[test]
    fn roots_are_found_wherever_they_are() {
        let mut random = Pcg32::new(7, 0);
        for degree in 1..=4 {
            for _ in 0..500 {
                let mut expected: Vec<f64> = (0..degree).map(|_| random.range(-3.0, 3.0).into()).collect();
                expected.sort_by(f64::total_cmp);
                if expected.windows(2).any(|pair| pair[1] - pair[0] < 0.01) {
                    continue;
                }
                let mut coefficients = vec![f64::from(random.range(0.1, 2.0))];
                for root in &expected {
                    let shifted = [&[0.0][..], &coefficients].concat();
                    coefficients.push(0.0);
                    coefficients.iter_mut().zip(&shifted).for_each(|(low, high)| *low = high - root * *low);
                }
                let found = roots_of(&coefficients);
                assert_eq!(found.len(), expected.len(), "{expected:?}: {found:?}");
                let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(worst < 1e-8, "{expected:?}: {found:?}");
            }
        }
        assert!(roots_of(&[1.0, 0.0, 1.0]).is_empty(), "there is no real root");
        assert!(roots_of(&[2.0, 0.0, 0.0, 0.0]).is_empty(), "a constant has none");
        assert_eq!(roots_of(&[-2.0, 1.0, 0.0]), [2.0], "a vanished leading coefficient");
    }

    #[test]
    fn masses_of_the_canonical_distribution_add_up_to_one_and_have_the_moments() {
        let mut random = Pcg32::new(11, 0);
        for order in [4, 6, 8] {
            for _ in 0..200 {
                let points: Vec<(f64, f64)> =
                    (0..20).map(|_| (random.range(-1.0, 1.0).into(), 1.0 / 20.0)).collect();
                let moments = moments_of(&points, order);
                let problem = Problem::new(&moments);
                let z = f64::from(random.range(-1.0, 1.0));
                let with_mass = |x| (x, problem.mass(&problem.orthogonal(x)));
                let mut canonical = vec![with_mass(z)];
                let kernel = problem.kernel(&problem.orthogonal(z));
                canonical.extend(roots_of(&kernel[..problem.rows]).into_iter().map(with_mass));
                assert!((canonical.iter().map(|(_, mass)| mass).sum::<f64>() - 1.0).abs() < 1e-6);
                // One point may lie far outside, where its last moment is cancelled out.
                for (found, expected) in moments_of(&canonical, order - 1).iter().zip(&moments) {
                    assert!((found - expected).abs() < 1e-5 * (1.0 + expected.abs()), "{found} {expected}");
                }
            }
        }
    }

    #[test]
    fn the_bounds_hold_for_any_distribution_and_grow_tighter_with_the_order() {
        let mut random = Pcg32::new(13, 0);
        let mut gaps = [0.0; 3];
        for _ in 0..300 {
            let count = 8 + (random.range(0.0, 20.0) as usize);
            let points: Vec<(f64, f64)> =
                (0..count).map(|_| (random.range(-1.0, 1.0).into(), 1.0 / count as f64)).collect();
            let z = f64::from(random.range(-1.0, 1.0));
            let truth: f64 = points.iter().filter(|(x, _)| *x < z).map(|(_, mass)| mass).sum();
            for (gap, order) in gaps.iter_mut().zip([4, 6, 8]) {
                let problem = Problem::new(&moments_of(&points, order));
                let [low, high] = [0.0, 1.0].map(|share| problem.share_in_front(z, share));
                assert!(low <= truth + 1e-6 && truth <= high + 1e-6, "{order}: {low} {truth} {high}");
                *gap += (high - low) / 300.0;
            }
        }
        assert!(gaps[0] > 1.2 * gaps[1] && gaps[1] > 1.1 * gaps[2], "{gaps:?}");
    }

    #[test]
    fn as_many_points_as_half_the_moments_are_found_exactly() {
        for order in [4, 6, 8] {
            let count = order as usize / 2;
            let points: Vec<(f64, f64)> =
                (0..count).map(|at| (at as f64 * 0.4 - 0.7, 1.0 / count as f64)).collect();
            // A little of something else, as a matrix of few points has no inverse.
            let moments: Vec<f64> = moments_of(&points, order)
                .iter()
                .zip(1..)
                .map(|(moment, power)| moment * (1.0 - 1e-7) + if power % 2 == 0 { 0.5e-7 } else { 0.0 })
                .collect();
            let problem = Problem::new(&moments);
            for (at, (x, mass)) in points.iter().enumerate() {
                let expected = at as f64 * mass + 0.5 * mass;
                let found = problem.share_in_front(*x, 0.5);
                assert!((found - expected).abs() < 1e-3, "{order}, point {at}: {found}, not {expected}");
            }
        }
    }
}
