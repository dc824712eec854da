//! Instants at which contact begins and ends within one interval, in bounded work.

use crate::Scalar;

/// Maximum number of Newton steps and bisections for a root. Bisection alone needs one per bit.
const LARGEST_ITERATION_COUNT: usize = 64;

/// Returns the root of `p + w s + c s^2` in `[0, T]` `[s]`, for p <= 0 and a positive value at s = T: the instant at
/// which the gap of a free object closes. It is the only upward crossing, computed without cancellation.
pub(crate) fn entry_instant<S: Scalar>(p: S, w: S, c: S, period: S) -> S {
    let four = S::TWO + S::TWO;
    let root = (w * w - four * c * p).max(S::ZERO).sqrt();
    let instant = if w >= S::ZERO {
        let slope = w + root;
        if slope > S::ZERO {
            -S::TWO * p / slope
        } else {
            S::ZERO
        }
    } else {
        // w < 0 and a positive end value leave only c > 0.
        (root - w) / (S::TWO * c)
    };
    // A quotient of denormals may overflow or be NaN; `max` and `min` drop a NaN.
    period.min(instant.max(S::ZERO))
}

/// Returns the earliest root in `[0, T]` `[s]` of the penetration `g(s) = p + u s - A (1 - cos(w s)) - (v / w) sin(w
/// s)` of an object on a held spring: p > 0 and u are the device's penetration and velocity, A the object's distance to
/// equilibrium, v its velocity, w its natural frequency. Requires g(T) <= 0.
///
/// The turning points of g are known in closed form and g is monotone between them, so the
/// earliest root is bracketed first and then polished by Newton steps that fall back to bisection.
/// However stiff the spring, the search spans a single period of it: g lies in a band of width 2C
/// (C the amplitude) that drifts at u, and the root falls within one spring period after the
/// band's lower edge has crossed zero.
pub(crate) fn release_instant<S: Scalar>(p: S, u: S, a: S, v: S, omega: S, period: S) -> S {
    if omega == S::ZERO {
        // A wall: the device leaves at constant velocity, and g(T) <= 0 < p leaves only u < 0.
        return period.min((-p / u).max(S::ZERO));
    }
    let gap = |s: S| {
        let (sin, cos) = (S::HALF * omega * s).sin_cos();
        let versine = S::TWO * sin * sin;
        let sine = S::TWO * sin * cos;
        (
            p + u * s - a * versine - v * sine / omega,
            u - a * omega * sine - v * (S::ONE - versine),
        )
    };
    let over_omega = v / omega;
    let amplitude = a.hypot(over_omega);
    // g(s) = (p - a) + u s + C cos(w s + phase), so g' = 0 where sin(w s + phase) = u / (C w).
    let level = u / (amplitude * omega);
    let turns = level.abs() < S::ONE;
    if !turns {
        return bracketed_root(gap, S::ZERO, period);
    }
    let centre = p - a;
    let start = if u < S::ZERO && centre > amplitude {
        period.min((centre - amplitude) / -u)
    } else {
        S::ZERO
    };
    let phase = over_omega.atan2(a);
    let turn = level.asin();
    let full = S::TWO * S::PI;
    // Angles of the two turning points of each spring period, the next of each after `start`.
    let here = omega * start + phase;
    let next = |angle: S| {
        let turns = ((here - angle) / full).floor() + S::ONE;
        (angle + turns * full - phase) / omega
    };
    let (one, other) = (next(turn), next(S::PI - turn));
    let mut low = start;
    for high in [one.min(other), one.max(other)] {
        // The comparison is false for a NaN from an overflow, which ends the search at T.
        if high > low && high < period {
            if gap(high).0 <= S::ZERO {
                return bracketed_root(gap, low, high);
            }
            low = high;
        }
    }
    bracketed_root(gap, low, period)
}

/// Returns the root of a function that gives value and slope, positive at `low`, not positive at `high`, and monotone
/// in between.
fn bracketed_root<S: Scalar>(f: impl Fn(S) -> (S, S), mut low: S, mut high: S) -> S {
    let tolerance = S::EPSILON * high;
    let mut at = high;
    for _ in 0..LARGEST_ITERATION_COUNT {
        let (value, slope) = f(at);
        if value > S::ZERO {
            low = at;
        } else {
            high = at;
        }
        let newton = at - value / slope;
        // Also false for a NaN, so a vanishing slope bisects.
        let next = if newton >= low && newton <= high {
            newton
        } else {
            low + S::HALF * (high - low)
        };
        if (next - at).abs() <= tolerance {
            return next;
        }
        at = next;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap(s: f64, p: f64, u: f64, a: f64, v: f64, w: f64) -> f64 {
        p + u * s - a * (1.0 - (w * s).cos()) - v / w * (w * s).sin()
    }

    #[test]
    fn entry_is_the_upward_crossing() {
        // Gap closes, opens, and closes again only when the parabola opens upwards.
        assert_eq!(entry_instant(-1.0, 2.0, 0.0, 1.0), 0.5);
        assert!((entry_instant(-1.0_f64, -1.0, 3.0, 1.0) - 0.767_591_879_243_998).abs() < 1e-14);
        // Touching at the start and moving in: at once.
        assert_eq!(entry_instant(0.0, 1.0, 1.0, 1.0), 0.0);
        // Touching at the start, then separating: at the second zero.
        assert_eq!(entry_instant(0.0, -1.0, 2.0, 1.0), 0.5);
    }

    #[test]
    fn release_is_the_earliest_root_whatever_the_stiffness() {
        // A pseudo-random sweep over slow and very fast springs, against a dense scan.
        let mut seed = 1_u64;
        let mut uniform = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let period = 0.02;
        let mut tried = 0;
        while tried < 2000 {
            let omega = 10f64.powf(0.5 + 3.5 * uniform());
            let p = 1e-3 * uniform() + 1e-9;
            let u = uniform() - 0.7;
            let a = 2e-3 * (uniform() - 0.3);
            let v = 2.0 * (uniform() - 0.5);
            if gap(period, p, u, a, v, omega) > 0.0 {
                continue;
            }
            tried += 1;
            let found = release_instant(p, u, a, v, omega, period);
            let steps = 40_000;
            let first = (1..=steps)
                .map(|k| period * f64::from(k) / f64::from(steps))
                .find(|&s| gap(s, p, u, a, v, omega) <= 0.0)
                // The gap is closed at the period's end.
                .unwrap_or(period);
            let scale = p.abs() + u.abs() * period + a.abs() + v.abs() / omega;
            assert!(
                gap(found, p, u, a, v, omega).abs() < 1e-12 * scale,
                "not a root: omega {omega}, found {found}"
            );
            // The scan can miss a dip between two of its points, but is never too early.
            assert!(
                found <= first + 1e-15
                    && (first - found <= period / f64::from(steps) * 1.001
                        || no_root_before(found, p, u, a, v, omega)),
                "omega {omega}, found {found}, scan {first}"
            );
        }
    }

    fn no_root_before(end: f64, p: f64, u: f64, a: f64, v: f64, w: f64) -> bool {
        (1..100_000).all(|k| gap(end * f64::from(k) / 100_001.0, p, u, a, v, w) > 0.0)
    }

    #[test]
    fn a_wall_is_left_at_constant_velocity() {
        assert_eq!(release_instant(0.5, -1.0, 0.0, 0.0, 0.0, 1.0), 0.5);
    }
}
