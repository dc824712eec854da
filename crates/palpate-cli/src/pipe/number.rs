//! Numbers in answers and summaries.

use std::fmt::Write;

use palpate_study::text::digits;

/// Magnitude below which a number has an exponent: its decimals would be hundreds of zeros.
const MIN_DECIMAL: f64 = 1e-5;
/// Magnitude from which a number has an exponent.
const MIN_POWER: f64 = 1e16;

/// Appends a finite `number` to a line so that it reads back unchanged: as a decimal, or with an exponent if it is very
/// small or very large. It takes at most 24 characters. Zero has no sign.
pub(crate) fn push(line: &mut String, number: f64) {
    let size = number.abs();
    // Writing to a string cannot fail. Adding 0 normalises -0.
    let _ = if size == 0.0 || (MIN_DECIMAL..MIN_POWER).contains(&size) {
        write!(line, "{}", number + 0.0)
    } else {
        write!(line, "{number:e}")
    };
}

/// Formats an energy `[J]` in mJ. Energies below a picojoule, which are imperceptible and may be round-off, print as
/// such.
pub(crate) fn millijoules(energy: f64) -> String {
    const LEAST: f64 = 1e-12;
    if energy != 0.0 && energy.abs() < LEAST {
        "less than 1e-9 mJ".to_owned()
    } else {
        format!("{} mJ", digits(1e3 * energy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_energy_that_may_be_round_off_has_no_digits() {
        for small in [1.6e-34, -1e-20, 9e-13] {
            assert_eq!(millijoules(small), "less than 1e-9 mJ");
        }
        assert_eq!(millijoules(0.0), "0 mJ");
        assert_eq!(millijoules(-1.234e-3), "-1.23 mJ");
        assert_eq!(millijoules(2e-12), "2.00e-9 mJ");
    }

    #[test]
    fn a_number_reads_back_and_is_short() {
        let of = |number| {
            let mut line = String::new();
            push(&mut line, number);
            line
        };
        assert_eq!(of(-0.0), "0");
        assert_eq!(of(0.25), "0.25");
        assert_eq!(of(1e-5), "0.00001");
        assert_eq!(of(-1.5e-7), "-1.5e-7");
        let mut size = 5e-324;
        while f64::is_finite(size) {
            for number in [
                size,
                -size * (1.0 + f64::EPSILON),
                size * std::f64::consts::FRAC_1_PI,
            ] {
                let text = of(number);
                assert!(text.len() <= 24, "{text}");
                assert_eq!(text.parse::<f64>().unwrap(), number);
            }
            size *= 3.7;
        }
        assert!(of(f64::MAX).len() <= 24);
    }
}
