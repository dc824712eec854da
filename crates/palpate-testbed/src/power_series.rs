//! Short power series on the unit interval, and where such a series first turns negative.

/// Most coefficients a series has.
pub(crate) const MAX_TERMS: usize = 24;

/// A series that ends where the terms of exp, as far into it, are below this.
const NEGLIGIBLE: f64 = 1e-17;

/// Largest number of halvings of an interval; the remaining curvature is then below round-off.
const MAX_HALVINGS: u32 = 27;

/// Returns the number of coefficients for a span of `radians` ≤ 1 of the fastest rate.
///
/// The first three can all vanish, at a break-away, so the count begins after them.
pub(crate) fn terms(radians: f64) -> usize {
    let (mut count, mut term) = (3, 1.0);
    while term > NEGLIGIBLE && count < MAX_TERMS {
        count += 1;
        term *= radians / (count - 3) as f64;
    }
    count
}

/// c₀ + c₁ s + c₂ s² + …
pub(crate) fn value(coefficients: &[f64], s: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| c + s * sum)
}

/// s (c₀ + c₁ s/2 + c₂ s²/3 + …), the integral from 0.
pub(crate) fn integral(coefficients: &[f64], s: f64) -> f64 {
    let mean = coefficients
        .iter()
        .enumerate()
        .rev()
        .fold(0.0, |sum, (n, c)| c / (n + 1) as f64 + s * sum);
    s * mean
}

/// c₁ + 2 c₂ s + 3 c₃ s² + …
fn slope(coefficients: &[f64], s: f64) -> f64 {
    coefficients
        .iter()
        .enumerate()
        .skip(1)
        .rev()
        .fold(0.0, |sum, (n, c)| n as f64 * c + s * sum)
}

/// First s in `[0, 1]` after which the series is negative, to round-off; `None` if it has none.
///
/// A zero at 0 itself counts only if the series falls from there. Whether a touch counts, two passes
/// closer together than the round-off of the largest coefficient can tell apart, is left open.
pub(crate) fn first_fall(coefficients: &[f64]) -> Option<f64> {
    let leading = coefficients.iter().position(|&c| c != 0.0)?;
    let rest = &coefficients[leading..];
    if rest[0] < 0.0 {
        return Some(0.0);
    }
    if rest[0] > rest[1..].iter().map(|c| c.abs()).sum() {
        return None;
    }
    let curvature = rest
        .iter()
        .enumerate()
        .map(|(n, c)| (n * n.saturating_sub(1)) as f64 * c.abs())
        .sum();
    let search = Search {
        coefficients: rest,
        curvature,
    };
    search.between((0.0, rest[0]), (1.0, value(rest, 1.0)), MAX_HALVINGS)
}

struct Search<'a> {
    coefficients: &'a [f64],
    /// Bound of the second derivative on `[0, 1]`.
    curvature: f64,
}

impl Search<'_> {
    /// First fall between two points (s, value), of which the left value is positive.
    ///
    /// An interval is given up only when the curvature cannot reach zero in it, and a root is
    /// taken only where the slope cannot turn, so that it is the first.
    fn between(&self, left: (f64, f64), right: (f64, f64), halvings: u32) -> Option<f64> {
        let width = right.0 - left.0;
        let middle = left.0 + 0.5 * width;
        if right.1 > 0.0 {
            if halvings == 0 || left.1.min(right.1) > 0.125 * self.curvature * width * width {
                return None;
            }
        } else if halvings == 0
            || slope(self.coefficients, middle) + 0.5 * self.curvature * width < 0.0
        {
            return Some(self.root(left.0, right.0));
        }
        let centre = (middle, value(self.coefficients, middle));
        if centre.1 > 0.0 {
            self.between(left, centre, halvings - 1)
                .or_else(|| self.between(centre, right, halvings - 1))
        } else {
            self.between(left, centre, halvings - 1)
        }
    }

    /// Newton's iteration inside a bracket that halves whenever Newton leaves it.
    fn root(&self, mut above: f64, mut below: f64) -> f64 {
        let mut s = 0.5 * (above + below);
        for _ in 0..100 {
            let here = value(self.coefficients, s);
            if here == 0.0 {
                return s;
            }
            if here > 0.0 {
                above = s;
            } else {
                below = s;
            }
            let newton = s - here / slope(self.coefficients, s);
            let next = if above < newton && newton < below {
                newton
            } else {
                0.5 * (above + below)
            };
            if (next - s).abs() <= f64::EPSILON * s {
                return next;
            }
            s = next;
        }
        s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dip_between_positive_ends_is_found_and_a_touch_is_not_a_pass() {
        // (s - 0.5)² - d²
        for d in [0.3, 1e-2, 1e-5, 1e-7] {
            let found = first_fall(&[0.25 - d * d, -1.0, 1.0]).unwrap();
            let round_off = 1e-15 / d;
            assert!((found - (0.5 - d)).abs() < round_off, "{d}: {found}");
        }
        assert_eq!(first_fall(&[0.25 + 1e-9, -1.0, 1.0]), None);
    }

    #[test]
    fn the_first_of_three_falls_is_taken() {
        // (0.2 - s)(s - 0.3)(s - 0.8) is positive before 0.2 and between 0.3 and 0.8.
        let cubic = [0.2 * 0.24, -0.24 - 0.22, 0.2 + 1.1, -1.0];
        assert!((first_fall(&cubic).unwrap() - 0.2).abs() < 1e-14);
    }

    #[test]
    fn a_zero_at_the_start_counts_only_if_the_series_falls_from_it() {
        assert_eq!(first_fall(&[0.0, -1.0, 2.0]), Some(0.0));
        let found = first_fall(&[0.0, 0.0, 1.0, -4.0]).unwrap();
        assert!((found - 0.25).abs() < 1e-15);
        assert_eq!(first_fall(&[0.0, 0.0, 1.0]), None);
        assert_eq!(first_fall(&[0.0, 0.0]), None);
    }

    #[test]
    fn as_many_terms_as_exp_needs() {
        for radians in [0.0, 1e-3, 0.1, 1.0_f64] {
            let mut coefficients = vec![1.0];
            for n in 1..terms(radians) {
                coefficients.push(coefficients[n - 1] * radians / n as f64);
            }
            assert!((value(&coefficients, 1.0) - radians.exp()).abs() < 1e-15);
        }
        assert!(terms(1.0) < MAX_TERMS);
    }
}
