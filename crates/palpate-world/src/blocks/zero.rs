//! Where a slope passes through 0.

/// Looks for the place, at most: each third look halves what is left.
const MOST_LOOKS: usize = 96;
/// Places that are no longer told apart, of a range of about 1.
const SAME_PLACE: f64 = 1e-15;

/// The place between two at which a function rises through 0: false position (Illinois), and halving where that is slow.
/// `low` and `high`: a place and the function's value there, below 0 and above 0. The place that is returned is the last at which
/// the function was asked.
pub(super) fn rising_zero(
    (mut low, mut of_low): (f64, f64),
    (mut high, mut of_high): (f64, f64),
    mut of: impl FnMut(f64) -> f64,
) -> f64 {
    let mut kept = 0_i8;
    let mut here = 0.5 * (low + high);
    let mut of_here = of(here);
    for number in 0..MOST_LOOKS {
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
