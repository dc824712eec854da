//! Root search for a slope.

/// Maximum number of evaluations: every third one halves the interval.
const MAX_LOOKS: usize = 96;
/// Interval width, relative to a range of about 1, below which the search ends.
const SAME_PLACE: f64 = 1e-15;

/// Returns the position between two at which a function rises through 0, by the Illinois method with bisection if
/// that is slow. `low` and `high` are positions with a negative and a positive function value. The function was last
/// evaluated at the returned position.
pub(super) fn rising_zero(
    (mut low, mut of_low): (f64, f64),
    (mut high, mut of_high): (f64, f64),
    mut of: impl FnMut(f64) -> f64,
) -> f64 {
    let mut kept = 0_i8;
    let mut here = 0.5 * (low + high);
    let mut of_here = of(here);
    for number in 0..MAX_LOOKS {
        if of_here == 0.0 || high - low < SAME_PLACE {
            break;
        }
        if of_here < 0.0 {
            (low, of_low) = (here, of_here);
            of_high *= if kept < 0 { 0.5 } else { 1.0 };
            kept = -1;
        } else {
            (high, of_high) = (here, of_here);
            of_low *= if kept > 0 { 0.5 } else { 1.0 };
            kept = 1;
        }
        let middle = 0.5 * (low + high);
        let crosses = low - of_low * (high - low) / (of_high - of_low);
        let next = if number % 3 == 2 || !(low < crosses && crosses < high) {
            middle
        } else {
            crosses
        };
        if next <= low || next >= high {
            break;
        }
        (here, of_here) = (next, of(next));
    }
    here
}
