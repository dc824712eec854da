//! Factorised covariance of the observer's state.
//!
//! It is stored as U D U' with U unit upper triangular and D diagonal (Bierman, *Factorization Methods for Discrete
//! Sequential Estimation*, 1977; time update after Thornton). It stays symmetric and positive semidefinite, in single
//! and double precision, however small a sensor's quantum is relative to the motion.

use crate::Scalar;

/// Parts of the state: position, velocity, external acceleration, theta and lambda.
pub(super) const PARTS: usize = 5;
pub(super) const VELOCITY: usize = 1;
pub(super) const MOBILITY: usize = 3;
pub(super) const DAMPING_RATE: usize = 4;

/// Covariance of the state as U D U'.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Covariance<S> {
    /// U above its diagonal of ones: rows 0 to 3, columns 1 to 4.
    pub(super) upper: [[S; PARTS - 1]; PARTS - 1],
    /// D.
    pub(super) diagonal: [S; PARTS],
}

/// Expected innovation of the next sample.
pub(super) struct ExpectedInnovation<S> {
    /// Variance of the innovation `[m^2]`.
    pub variance: S,
    /// Its covariance with position, velocity and external acceleration at the interval's beginning.
    pub cross: [S; 3],
    /// The position's row of the transition times U.
    pub row: [S; PARTS],
}

impl<S: Scalar> Covariance<S> {
    /// Returns the expected innovation of the next sample, from the first row of the transition and the variance
    /// `unseen`, which is in no part of the state.
    #[inline]
    pub(super) fn expected_innovation(
        &self,
        first: &[S; PARTS],
        unseen: S,
    ) -> ExpectedInnovation<S> {
        let [
            [u01, u02, u03, u04],
            [_, u12, u13, u14],
            [_, _, u23, u24],
            [_, _, _, u34],
        ] = self.upper;
        let [d0, d1, d2, d3, d4] = self.diagonal;
        let [_, f1, f2, f3, f4] = *first;
        let w1 = u01 + f1;
        let w2 = u02 + f1 * u12 + f2;
        let w3 = u03 + f1 * u13 + f2 * u23 + f3;
        let w4 = u04 + f1 * u14 + f2 * u24 + f3 * u34 + f4;
        let (v1, v2, v3, v4) = (d1 * w1, d2 * w2, d3 * w3, d4 * w4);
        ExpectedInnovation {
            variance: d0 + v1 * w1 + v2 * w2 + v3 * w3 + v4 * w4 + unseen,
            cross: [
                d0 + u01 * v1 + u02 * v2 + u03 * v3 + u04 * v4,
                v1 + u12 * v2 + u13 * v3 + u14 * v4,
                v2 + u23 * v3 + u24 * v4,
            ],
            row: [S::ONE, w1, w2, w3, w4],
        }
    }

    /// Returns the variance of the sum of the state's parts, each times its entry in `by`.
    pub(super) fn of_sum(&self, by: &[S; PARTS]) -> S {
        let mut sum = S::ZERO;
        for (j, own) in by.iter().enumerate() {
            let mut along = *own;
            for (entry, row) in by.iter().zip(&self.upper).take(j) {
                along += *entry * row[j - 1];
            }
            sum += self.diagonal[j] * along * along;
        }
        sum
    }

    /// Adds `variance` to that of one part of the state, independent of the others (Agee and Turner).
    pub(super) fn widen(&mut self, part: usize, variance: S) {
        let mut left = variance.max(S::ZERO);
        let mut along = [S::ZERO; PARTS];
        along[part] = S::ONE;
        for j in (0..=part).rev() {
            let old = self.diagonal[j];
            let new = old + left * along[j] * along[j];
            // A part without variance contributes nothing.
            if new <= S::ZERO {
                continue;
            }
            self.diagonal[j] = new;
            for i in 0..j {
                let u = self.upper[i][j - 1];
                along[i] -= along[j] * u;
                self.upper[i][j - 1] = u + left * along[j] / new * along[i];
            }
            left = left * old / new;
        }
    }

    /// Time update: the transition times U, D, and the jerk as an additional column, orthogonalised from the last row
    /// upwards. `row` is the first row of that product.
    #[inline]
    pub(super) fn stepped(
        &self,
        transition: &[[S; PARTS]; 3],
        row: &[S; PARTS],
        jerk: [S; 3],
        q: S,
    ) -> Self {
        let [_, [_, u12, u13, u14], [_, _, u23, u24], [_, _, _, u34]] = self.upper;
        let [d0, d1, d2, d3, d4] = self.diagonal;
        let [_, [_, _, f12, f13, f14], [_, _, f22, f23, f24]] = *transition;
        let [_, w01, mut w02, w03, w04] = *row;
        let w12 = u12 + f12;
        let w13 = u13 + f12 * u23 + f13;
        let w14 = u14 + f12 * u24 + f13 * u34 + f14;
        let w23 = f22 * u23 + f23;
        let w24 = f22 * u24 + f23 * u34 + f24;
        let [mut g0, mut g1, g2] = jerk;

        let e2 = d2 * f22 * f22 + q * g2 * g2;
        let c1 = (w12 * d2 * f22 + q * g1 * g2) / e2;
        let c0 = (w02 * d2 * f22 + q * g0 * g2) / e2;
        let left1 = w12 - c1 * f22;
        g1 -= c1 * g2;
        w02 -= c0 * f22;
        g0 -= c0 * g2;

        let e1 = d1 + d2 * left1 * left1 + q * g1 * g1;
        let b0 = (w01 * d1 + w02 * d2 * left1 + q * g0 * g1) / e1;
        let rest0 = w01 - b0;
        let rest1 = w02 - b0 * left1;
        g0 -= b0 * g1;
        let e0 = d0 + rest0 * rest0 * d1 + rest1 * rest1 * d2 + q * g0 * g0;
        let o = S::ZERO;
        Self {
            upper: [
                [b0, c0, w03, w04],
                [o, c1, w13, w14],
                [o, o, w23, w24],
                [o, o, o, u34],
            ],
            diagonal: [e0, e1, e2, d3, d4],
        }
    }

    /// Measurement update (Bierman) for a position of this variance. Returns the new covariance and the change of the
    /// state per unit of innovation.
    #[inline]
    pub(super) fn measured(&self, variance: S) -> (Self, [S; PARTS]) {
        let mut next = *self;
        let v0 = self.diagonal[0];
        let mut alpha = variance + v0;
        next.diagonal[0] = v0 * variance / alpha;
        let mut gain = [v0, S::ZERO, S::ZERO, S::ZERO, S::ZERO];
        next.take_in::<1>(&mut gain, &mut alpha);
        next.take_in::<2>(&mut gain, &mut alpha);
        next.take_in::<3>(&mut gain, &mut alpha);
        next.take_in::<4>(&mut gain, &mut alpha);
        (next, gain.map(|g| g / alpha))
    }

    /// Measurement update for one part of the state.
    #[inline(always)]
    fn take_in<const PART: usize>(&mut self, gain: &mut [S; PARTS], alpha: &mut S) {
        let column: [S; PART] = core::array::from_fn(|i| self.upper[i][PART - 1]);
        let own = column[0];
        let v = self.diagonal[PART] * own;
        let before = *alpha;
        *alpha += v * own;
        self.diagonal[PART] = self.diagonal[PART] * before / *alpha;
        let back = own / before;
        for i in 0..PART {
            self.upper[i][PART - 1] = column[i] - back * gain[i];
            gain[i] += v * column[i];
        }
        gain[PART] = v;
    }

    /// Returns the full matrix.
    pub fn dense(&self) -> [[S; PARTS]; PARTS] {
        let [
            [u01, u02, u03, u04],
            [_, u12, u13, u14],
            [_, _, u23, u24],
            [_, _, _, u34],
        ] = self.upper;
        let [d0, d1, d2, d3, d4] = self.diagonal;
        let [c04, c14, c24, c34] = [u04, u14, u24, u34].map(|u| u * d4);
        let [v0, v1, v2] = [u03, u13, u23].map(|u| u * d3);
        let [c03, c13, c23] = [v0 + u34 * c04, v1 + u34 * c14, v2 + u34 * c24];
        let c33 = d3 + u34 * c34;
        let [w0, w1] = [u02, u12].map(|u| u * d2);
        let [c02, c12] = [w0 + u23 * v0 + u24 * c04, w1 + u23 * v1 + u24 * c14];
        let c22 = d2 + u23 * v2 + u24 * c24;
        let c01 = u01 * d1 + u12 * w0 + u13 * v0 + u14 * c04;
        let c11 = d1 + u12 * w1 + u13 * v1 + u14 * c14;
        let c00 = d0 + u01 * u01 * d1 + u02 * w0 + u03 * v0 + u04 * c04;
        [
            [c00, c01, c02, c03, c04],
            [c01, c11, c12, c13, c14],
            [c02, c12, c22, c23, c24],
            [c03, c13, c23, c33, c34],
            [c04, c14, c24, c34, d4],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some_covariance() -> Covariance<f64> {
        Covariance {
            upper: [
                [0.3, -0.7, 0.2, 1.1],
                [0.0, 0.4, -0.9, 0.6],
                [0.0, 0.0, 1.3, -0.2],
                [0.0, 0.0, 0.0, 0.8],
            ],
            diagonal: [2.0, 0.5, 1.5, 0.7, 3.0],
        }
    }

    #[test]
    fn the_covariance_is_the_product_of_its_factors() {
        let covariance = some_covariance();
        let u = |i: usize, k: usize| match k {
            k if k < i => 0.0,
            k if k == i => 1.0,
            k => covariance.upper[i][k - 1],
        };
        for (i, row) in covariance.dense().iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let sum: f64 = (0..PARTS)
                    .map(|k| u(i, k) * covariance.diagonal[k] * u(j, k))
                    .sum();
                assert!((entry - sum).abs() < 1e-14, "{i} {j}: {entry} {sum}");
            }
        }
    }

    #[test]
    fn the_variance_of_a_sum_is_that_of_the_full_matrix() {
        let covariance = some_covariance();
        let by = [0.7, -1.3, 0.4, 2.1, -0.6];
        let dense = covariance.dense();
        let mut sum = 0.0;
        for (i, row) in dense.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                sum += by[i] * entry * by[j];
            }
        }
        assert!((covariance.of_sum(&by) - sum).abs() < 1e-13 * sum);
    }

    #[test]
    fn doubt_of_one_part_is_no_doubt_of_the_others() {
        let before = some_covariance();
        for part in 0..PARTS {
            let mut after = before;
            after.widen(part, 0.9);
            let (old, new) = (before.dense(), after.dense());
            for i in 0..PARTS {
                for j in 0..PARTS {
                    let more = if i == part && j == part { 0.9 } else { 0.0 };
                    let off = new[i][j] - old[i][j] - more;
                    assert!(off.abs() < 1e-14, "{part}, {i} {j}: off by {off}");
                }
            }
        }
    }
}
