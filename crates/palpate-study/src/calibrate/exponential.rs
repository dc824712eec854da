//! The exponential of a small matrix. That of `nalgebra` needs its feature `std`.

use nalgebra::DMatrix;

/// Largest norm for which the series is taken.
const SMALL: f64 = 0.5;
/// Terms of the series: the next one is below 1e-16 of the whole.
const TERMS: u32 = 13;

/// The exponential of a square matrix, by scaling, the series of Taylor, and squaring (Moler and Van Loan,
/// *Nineteen dubious ways to compute the exponential of a matrix*, method 3).
pub fn exponential(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let norm = matrix
        .column_iter()
        .map(|column| column.iter().map(|x| x.abs()).sum::<f64>())
        .fold(0.0, f64::max);
    let mut halvings = 0;
    let mut scale = 1.0;
    while norm * scale > SMALL && halvings < 60 {
        halvings += 1;
        scale *= 0.5;
    }
    let small = matrix * scale;
    let mut sum = DMatrix::<f64>::identity(matrix.nrows(), matrix.ncols());
    let mut term = sum.clone();
    for order in 1..=TERMS {
        term = &term * &small / f64::from(order);
        sum += &term;
    }
    for _ in 0..halvings {
        sum = &sum * &sum;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillation_and_a_decay_are_those_of_closed_forms() {
        let mut matrix = DMatrix::<f64>::zeros(3, 3);
        let w = 3.7;
        matrix[(0, 1)] = w;
        matrix[(1, 0)] = -w;
        matrix[(2, 2)] = -250.0;
        let of = exponential(&matrix);
        for (entry, exact) in [
            ((0, 0), w.cos()),
            ((0, 1), w.sin()),
            ((1, 0), -w.sin()),
            ((2, 2), (-250.0_f64).exp()),
            ((0, 2), 0.0),
        ] {
            assert!((of[entry] - exact).abs() < 1e-12, "{entry:?} {}", of[entry]);
        }
    }
}
