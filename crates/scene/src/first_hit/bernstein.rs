//! Polynomials of two variables over the unit square in Bézier form.

use std::sync::OnceLock;

/// Degree in each variable.
pub(super) const DEGREE: usize = 8;
/// Number of coefficients along each side.
pub(super) const SIDE: usize = DEGREE + 1;

/// Coefficients, by the first variable s, then the second variable t. The polynomial lies in their convex hull.
pub(super) type Net = [[f64; SIDE]; SIDE];

/// Returns the Chebyshev points of −1…1, at which polynomials are determined.
pub(super) fn nodes() -> [f64; SIDE] {
    std::array::from_fn(|index| -libm::cos(std::f64::consts::PI * (index as f64 + 0.5) / SIDE as f64))
}

/// Returns the Bernstein polynomials at a place in 0…1.
pub(super) fn basis(at: f64) -> [f64; SIDE] {
    let mut values = [0.0; SIDE];
    values[0] = 1.0;
    for degree in 1..SIDE {
        for index in (0..=degree).rev() {
            let from = if index > 0 { values[index - 1] * at } else { 0.0 };
            values[index] = values[index] * (1.0 - at) + from;
        }
    }
    values
}

/// Rounding error of coefficients from values at the nodes, relative to the largest value: the polynomial of the
/// coefficients misses the values by less. A test measures it.
pub(super) const ROUNDING: f64 = 1e-12;

/// Returns the coefficients of the polynomial that has these values at the Chebyshev points.
pub(super) fn interpolated(values: &Net) -> Net {
    static MATRIX: OnceLock<Net> = OnceLock::new();
    let matrix = MATRIX.get_or_init(|| inverse(nodes().map(|node| basis(0.5 + 0.5 * node))));
    let mut half = [[0.0; SIDE]; SIDE];
    for (half, factors) in half.iter_mut().zip(matrix) {
        for (factor, values) in factors.iter().zip(values) {
            half.iter_mut().zip(values).for_each(|(half, value)| *half += factor * value);
        }
    }
    half.map(|row| std::array::from_fn(|index| (0..SIDE).map(|node| matrix[index][node] * row[node]).sum()))
}

/// Inverts a matrix by elimination with pivots.
fn inverse(mut a: Net) -> Net {
    let mut inverse: Net = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for column in 0..SIDE {
        let pivot = (column..SIDE).fold(
            column,
            |best, row| {
                if a[row][column].abs() > a[best][column].abs() { row } else { best }
            },
        );
        a.swap(column, pivot);
        inverse.swap(column, pivot);
        let divisor = a[column][column];
        for matrix in [&mut a, &mut inverse] {
            matrix[column].iter_mut().for_each(|value| *value /= divisor);
        }
        for row in (0..SIDE).filter(|row| *row != column) {
            let factor = a[row][column];
            for matrix in [&mut a, &mut inverse] {
                let from = matrix[column];
                matrix[row].iter_mut().zip(from).for_each(|(value, from)| *value -= factor * from);
            }
        }
    }
    inverse
}

/// Returns the value at a point of the unit square, and the derivatives by s and by t.
pub(super) fn evaluate(net: &Net, [s, t]: [f64; 2]) -> (f64, [f64; 2]) {
    let (by_s, by_t) = (basis(s), basis(t));
    let along = net.map(|row| row.iter().zip(by_t).map(|(value, factor)| value * factor).sum::<f64>());
    let value = along.iter().zip(by_s).map(|(value, factor)| value * factor).sum();
    let lower = |at: f64| {
        // The basis of one degree less.
        let mut values = [0.0; DEGREE];
        values[0] = 1.0;
        for degree in 1..DEGREE {
            for index in (0..=degree).rev() {
                let from = if index > 0 { values[index - 1] * at } else { 0.0 };
                values[index] = values[index] * (1.0 - at) + from;
            }
        }
        values
    };
    let slope = |values: [f64; SIDE], at: f64| -> f64 {
        let factors = lower(at);
        (0..DEGREE).map(|i| DEGREE as f64 * (values[i + 1] - values[i]) * factors[i]).sum()
    };
    let across = std::array::from_fn(|index| (0..SIDE).map(|row| net[row][index] * by_s[row]).sum());
    (value, [slope(along, s), slope(across, t)])
}

/// Returns the two halves along s, or along t.
pub(super) fn halves(net: &Net, along_s: bool) -> [Net; 2] {
    if along_s { halves_along_s(net) } else { halves_along_t(net) }
}

fn halves_along_s(net: &Net) -> [Net; 2] {
    let (mut low, mut high, mut left) = ([[0.0; SIDE]; SIDE], [[0.0; SIDE]; SIDE], *net);
    for step in 0..SIDE {
        low[step] = left[0];
        high[DEGREE - step] = left[DEGREE - step];
        for row in 0..DEGREE - step {
            let next = left[row + 1];
            left[row].iter_mut().zip(next).for_each(|(value, next)| *value = 0.5 * (*value + next));
        }
    }
    [low, high]
}

fn halves_along_t(net: &Net) -> [Net; 2] {
    let (mut low, mut high, mut left) = ([[0.0; SIDE]; SIDE], [[0.0; SIDE]; SIDE], *net);
    for step in 0..SIDE {
        for row in 0..SIDE {
            low[row][step] = left[row][0];
            high[row][DEGREE - step] = left[row][DEGREE - step];
        }
        for row in &mut left {
            for column in 0..DEGREE - step {
                row[column] = 0.5 * (row[column] + row[column + 1]);
            }
        }
    }
    [low, high]
}

/// Returns the least and the greatest coefficient.
pub(super) fn range(net: &Net) -> [f64; 2] {
    let (mut low, mut high) = ([f64::INFINITY; SIDE], [f64::NEG_INFINITY; SIDE]);
    for row in net {
        for column in 0..SIDE {
            low[column] = low[column].min(row[column]);
            high[column] = high[column].max(row[column]);
        }
    }
    [low.into_iter().fold(f64::INFINITY, f64::min), high.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some(net: impl Fn(f64, f64) -> f64) -> Net {
        nodes().map(|s| nodes().map(|t| net(0.5 + 0.5 * s, 0.5 + 0.5 * t)))
    }

    #[test]
    fn polynomials_are_found_from_their_values_within_the_rounding() {
        for case in 0..50 {
            let part = |by: f64| (f64::from(case) * by).fract() - 0.5;
            let of = |s: f64, t: f64| {
                1.0 + part(0.618) * s + part(0.414) * t * t + part(0.732) * libm::pow(s, 8.0) * libm::pow(t, 7.0)
            };
            let net = interpolated(&some(of));
            for (i, s) in nodes().into_iter().enumerate() {
                for (j, t) in nodes().into_iter().enumerate() {
                    let at = [0.5 + 0.5 * s, 0.5 + 0.5 * t];
                    let (value, _) = evaluate(&net, at);
                    assert!((value - of(at[0], at[1])).abs() < 0.1 * ROUNDING, "{i} {j}: {value}");
                }
            }
            let step = 1e-6;
            let (value, slopes) = evaluate(&net, [0.3, 0.7]);
            assert!((value - of(0.3, 0.7)).abs() < ROUNDING);
            let slope = [of(0.3 + step, 0.7) - of(0.3 - step, 0.7), of(0.3, 0.7 + step) - of(0.3, 0.7 - step)];
            assert!((0..2).all(|axis| (slopes[axis] - slope[axis] / (2.0 * step)).abs() < 1e-8));
        }
    }

    #[test]
    fn halves_are_the_same_polynomial() {
        let net = interpolated(&some(|s, t| s * s * s - 0.4 * t + s * t * t));
        for along_s in [true, false] {
            let [low, high] = halves(&net, along_s);
            for at in [[0.2, 0.9], [1.0, 0.5], [0.0, 0.3]] {
                for (half, start) in [(low, 0.0), (high, 0.5)] {
                    let whole = if along_s { [start + at[0] / 2.0, at[1]] } else { [at[0], start + at[1] / 2.0] };
                    let (a, b) = (evaluate(&half, at).0, evaluate(&net, whole).0);
                    assert!((a - b).abs() < 1e-12, "{a} {b}");
                    let [least, most] = range(&half);
                    assert!(least <= a + 1e-12 && a <= most + 1e-12);
                }
            }
        }
    }
}
