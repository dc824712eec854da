//! Estimation of the sensor's step from its positions.

/// Largest distance of a position from a whole number of steps, in steps: the rounding of a printed decimal.
const TOLERANCE: f64 = 0.1;
/// Fraction of the changes that have to be whole steps.
const WHOLE: f64 = 0.98;

/// Returns the step of the sensor `[m]`, or `None` if its positions are not on steps.
pub fn quantum(positions: &[f64]) -> Option<f64> {
    let mut changes: Vec<f64> = positions
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|change| *change > 0.0 && change.is_finite())
        .collect();
    if changes.len() < 20 {
        return None;
    }
    changes.sort_by(f64::total_cmp);
    // Differences of equal decimals are not exactly 0.
    let largest = *changes.last()?;
    changes.retain(|change| *change > 1e-9 * largest);
    let mut step = *changes.first()?;
    // The smallest change is a step with an error; a few larger changes improve the estimate.
    let near = changes.iter().filter(|change| **change < 4.5 * step);
    let (sum, count) = near.fold((0.0, 0.0), |(sum, count), change| {
        (sum + change, count + (change / step).round())
    });
    step = sum / count;
    let is_whole = |change: &&f64| {
        let steps = **change / step;
        (steps - steps.round()).abs() < TOLERANCE
    };
    // A change of many steps carries no information if the step is not known to as many digits.
    let model: Vec<&f64> = changes
        .iter()
        .filter(|change| **change < 100.0 * step)
        .collect();
    let whole = model.iter().filter(|change| is_whole(change)).count();
    (model.len() >= 20 && whole as f64 >= WHOLE * model.len() as f64).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(quantum: f64) -> Vec<f64> {
        let x = |i: usize| 0.005 * (i as f64 * 0.01).sin() + 0.0003 * (i as f64 * 0.17).sin();
        (0..4000)
            .map(x)
            .map(|x| {
                if quantum > 0.0 {
                    (x / quantum).round() * quantum
                } else {
                    x
                }
            })
            .collect()
    }

    #[test]
    fn the_step_is_found_and_none_is_invented() {
        for step in [1e-6, 1e-5, 3.7e-5, 1e-4] {
            let found = quantum(&motion(step)).expect("a step");
            assert!((found / step - 1.0).abs() < 1e-3, "{step} {found}");
        }
        assert_eq!(quantum(&motion(0.0)), None);
        assert_eq!(quantum(&[1.0; 100]), None);
    }
}
