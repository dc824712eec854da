//! Bracketing root finder by Ridders' method.

/// Rounds; each at least halves what is left.
const ROUNDS: usize = 60;
/// Where two places are the same, relative to the larger of them and 1.
const SAME: f64 = 4e-16;

/// The place from `low` to `high` at which a function falls through 0, or the end at which it is nearest to that (C.
/// Ridders, 1979).
pub(super) fn falls_through_zero(of: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut of_low, mut of_high) = (of(low), of(high));
    if of_low <= 0.0 {
        return low;
    }
    if of_high >= 0.0 {
        return high;
    }
    let same = SAME * low.abs().max(high.abs()).max(1.0);
    let mut last = f64::NAN;
    for _ in 0..ROUNDS {
        let middle = 0.5 * (low + high);
        let of_middle = of(middle);
        let root = (of_middle * of_middle - of_low * of_high).sqrt();
        let next = middle + (middle - low) * of_middle / root;
        let mut look = |place: f64, value: f64| {
            let is_within = low < place && place < high;
            if is_within && value > 0.0 {
                (low, of_low) = (place, value);
            } else if is_within && value < 0.0 {
                (high, of_high) = (place, value);
            }
            is_within && value == 0.0
        };
        if look(middle, of_middle) {
            return middle;
        }
        if look(next, of(next)) {
            return next;
        }
        // At a jump of the function the iteration may repeat a point that is not the root.
        if (next - last).abs() <= same {
            for place in [next - 2.0 * same, next + 2.0 * same] {
                look(place, of(place));
            }
        }
        if high - low <= 4.0 * same {
            return next.max(low).min(high);
        }
        last = next;
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::falls_through_zero;

    #[test]
    fn a_root_is_found_to_round_off_where_the_function_is_steep_flat_or_jumps() {
        let cosine = falls_through_zero(f64::cos, 0.0, 3.0);
        assert!((cosine - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        let cube = falls_through_zero(|x| (0.3 - x).powi(3), 0.0, 1.0);
        assert!((cube - 0.3).abs() < 1e-9);
        for (inside, outside) in [(1e-2, 1e-12), (1e-12, 1e-2)] {
            let jump = |x: f64| {
                let size = if (x - 0.7).abs() < 1e-3 {
                    inside
                } else {
                    outside
                };
                if x < 0.7003 { size } else { -size }
            };
            assert!((falls_through_zero(jump, 0.0, 1.0) - 0.7003).abs() < 1e-14);
        }
        assert_eq!(
            falls_through_zero(|x| -1.0 - x, 0.0, 1.0).to_bits(),
            0.0_f64.to_bits()
        );
        assert_eq!(
            falls_through_zero(|x| 2.0 - x, 0.0, 1.0).to_bits(),
            1.0_f64.to_bits()
        );
    }
}
