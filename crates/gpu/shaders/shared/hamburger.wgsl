// The truncated Hamburger moment problem: twin of crates/render/src/method/moments/hamburger.rs, in 32 bits,
// as the paper has it.

// Rows of the Hankel matrix: half the moments and one.
const ROWS: u32 = 3u + P_ORDER;
const DEGREE: u32 = ROWS - 1u;
// The published biases leave every pivot above 1.2e-7 (for each order the bias times the last pivot of what
// it moves the moments to). What is below half of that is nothing but rounding.
const LEAST_PIVOT: f32 = 6e-8;
// A root beyond has no mass.
const FURTHEST_ROOT: f32 = 1e6;

// Moments of a distribution of mass 1, factorised.
struct Problem {
    // Of B = L D L^T: below the diagonal, row by row.
    lower: array<f32, ROWS * ROWS>,
    // The inverse of the diagonal of D.
    inverse_pivots: array<f32, ROWS>,
}

var<private> problem: Problem;

// From the zeroth moment, which is 1, and all further ones.
fn factorise(moments: array<f32, 2u * DEGREE + 1u>) {
    var pivots: array<f32, ROWS>;
    var values = moments;
    for (var row = 0u; row < ROWS; row += 1u) {
        for (var column = 0u; column <= row; column += 1u) {
            var rest = values[row + column];
            for (var k = 0u; k < column; k += 1u) {
                rest -= problem.lower[row * ROWS + k] * problem.lower[column * ROWS + k] * pivots[k];
            }
            if column == row {
                pivots[row] = max(rest, LEAST_PIVOT);
                problem.inverse_pivots[row] = 1.0 / pivots[row];
            } else {
                problem.lower[row * ROWS + column] = rest * problem.inverse_pivots[column];
            }
        }
    }
}

// y of L y = v(z): the orthogonal polynomials at z.
fn orthogonal(z: f32) -> array<f32, ROWS> {
    var y: array<f32, ROWS>;
    var power = 1.0;
    for (var row = 0u; row < ROWS; row += 1u) {
        y[row] = power;
        for (var k = 0u; k < row; k += 1u) {
            y[row] -= problem.lower[row * ROWS + k] * y[k];
        }
        power *= z;
    }
    return y;
}

// The most mass that can lie at z: 1 / y^T D^-1 y.
fn mass_of(orthogonal_at_z: array<f32, ROWS>) -> f32 {
    var y = orthogonal_at_z;
    var sum = 0.0;
    for (var row = 0u; row < ROWS; row += 1u) {
        sum += y[row] * y[row] * problem.inverse_pivots[row];
    }
    return 1.0 / sum;
}

// The coefficients of K(z, .) from the constant one up: c of L^T c = D^-1 y.
fn kernel_of(orthogonal_at_z: array<f32, ROWS>) -> array<f32, ROWS> {
    var y = orthogonal_at_z;
    var kernel: array<f32, ROWS>;
    for (var below = 0u; below < ROWS; below += 1u) {
        let row = ROWS - 1u - below;
        kernel[row] = y[row] * problem.inverse_pivots[row];
        for (var k = row + 1u; k < ROWS; k += 1u) {
            kernel[row] -= problem.lower[k * ROWS + row] * kernel[k];
        }
    }
    return kernel;
}

// A polynomial and its degree, from the constant coefficient up.
var<private> polynomial: array<f32, ROWS>;
var<private> polynomial_degree: u32;

// Value and slope of the polynomial.
fn value_and_slope(x: f32) -> vec2f {
    var value = 0.0;
    var slope = 0.0;
    for (var below = 0u; below <= polynomial_degree; below += 1u) {
        slope = slope * x + value;
        value = value * x + polynomial[polynomial_degree - below];
    }
    return vec2f(value, slope);
}

// The real roots of a polynomial, in ascending order.
struct Roots {
    at: array<f32, DEGREE>,
    count: u32,
}

// Of the polynomial, which has degree 2.
fn quadratic_roots() -> Roots {
    var roots: Roots;
    let a = polynomial[2];
    let b = polynomial[1];
    let c = polynomial[0];
    let discriminant = b * b - 4.0 * a * c;
    if discriminant <= 0.0 {
        return roots;
    }
    // The sum of two of the same sign: nothing is cancelled out.
    let larger = -0.5 * (b + select(sqrt(discriminant), -sqrt(discriminant), b < 0.0));
    let other = c / larger;
    // Of a vanishing leading coefficient one root is at infinity.
    let is_finite = abs(larger) < FURTHEST_ROOT * abs(a);
    let one = select(select(-FURTHEST_ROOT, FURTHEST_ROOT, (larger < 0.0) == (a < 0.0)), larger / a, is_finite);
    roots.at[0] = min(one, other);
    roots.at[1] = max(one, other);
    roots.count = 2u;
    return roots;
}

// Newton's method, with a bisection whenever it would leave the interval or does not halve its step. Gives
// the root between two points where the polynomial has different signs.
fn root_between(from_low: f32, from_high: f32) -> f32 {
    // A few units in the last place.
    const PRECISION: f32 = 5e-7;
    // Bisections alone take an interval of FURTHEST_ROOT down to that.
    const MOST_STEPS: u32 = 48u;
    var low = from_low;
    var high = from_high;
    let low_is_negative = value_and_slope(low).x < 0.0;
    var x = 0.5 * (low + high);
    var last_step = high - low;
    for (var step = 0u; step < MOST_STEPS; step += 1u) {
        let at_x = value_and_slope(x);
        if (at_x.x < 0.0) == low_is_negative {
            low = x;
        } else {
            high = x;
        }
        let newton = x - at_x.x / at_x.y;
        let converges = newton > low && newton < high && 2.0 * abs(newton - x) < last_step;
        let next = select(0.5 * (low + high), newton, converges);
        last_step = abs(next - x);
        x = next;
        if last_step <= PRECISION * (1.0 + abs(x)) {
            break;
        }
    }
    return x;
}

fn is_negative(x: f32) -> bool {
    return value_and_slope(x).x < 0.0;
}

// The point, going up or down from one, where the polynomial has the other sign; the first one if there is
// none. Most roots are within a unit, so it begins small.
fn change_beyond(start: f32, direction: f32) -> f32 {
    let begins_negative = is_negative(start);
    var step = 0.125 * direction;
    while abs(step) < FURTHEST_ROOT {
        if is_negative(start + step) != begins_negative {
            return start + step;
        }
        step *= 4.0;
    }
    return start;
}

// Of the polynomial, from the roots of its derivative: between two neighbouring extrema there is one root at
// most, as there is beyond the outermost ones.
fn roots_by_extrema(of_derivative: Roots) -> Roots {
    var extrema = of_derivative;
    var roots: Roots;
    let first = select(0.0, extrema.at[0], extrema.count > 0u);
    let last = select(0.0, extrema.at[max(extrema.count, 1u) - 1u], extrema.count > 0u);
    let lowest = change_beyond(first, -1.0);
    if lowest < first {
        roots.at[0] = root_between(lowest, first);
        roots.count = 1u;
    }
    for (var at = 0u; at + 1u < extrema.count; at += 1u) {
        if is_negative(extrema.at[at]) != is_negative(extrema.at[at + 1u]) {
            roots.at[roots.count] = root_between(extrema.at[at], extrema.at[at + 1u]);
            roots.count += 1u;
        }
    }
    let highest = change_beyond(last, 1.0);
    if highest > last && roots.count < DEGREE {
        roots.at[roots.count] = root_between(last, highest);
        roots.count += 1u;
    }
    return roots;
}

// Makes the polynomial the derivative of a kernel that is left with a degree.
fn take_derivative(kernel: array<f32, ROWS>, degree: u32) {
    var coefficients = kernel;
    polynomial_degree = degree;
    for (var derived = DEGREE; derived > degree; derived -= 1u) {
        for (var power = 1u; power <= derived; power += 1u) {
            coefficients[power - 1u] = f32(power) * coefficients[power];
        }
    }
    polynomial = coefficients;
}

// The real roots of K(z, .), from those of its second last derivative on.
fn real_roots(kernel: array<f32, ROWS>) -> Roots {
    take_derivative(kernel, 2u);
    var roots = quadratic_roots();
    for (var degree = 3u; degree <= DEGREE; degree += 1u) {
        take_derivative(kernel, degree);
        roots = roots_by_extrema(roots);
    }
    return roots;
}

// The share of the mass in front of z, with `overestimation` of what lies at z itself: 0 to 1.
fn share_in_front(z: f32, overestimation: f32) -> f32 {
    let y = orthogonal(z);
    var roots = real_roots(kernel_of(y));
    var share = overestimation * mass_of(y);
    for (var at = 0u; at < roots.count; at += 1u) {
        if roots.at[at] < z {
            share += mass_of(orthogonal(roots.at[at]));
        }
    }
    return clamp(share, 0.0, 1.0);
}
