//! How results are spread over the plants.

use super::{Judged, Trial};

/// What a column did over all plants under one condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Which of the columns.
    pub column: usize,
    /// Which of the conditions of the set.
    pub condition: usize,
    /// Mean-force error E `[%]`: median, 75 %, 90 %, largest.
    pub error: [f64; 4],
    /// FRE over floor: median and 90 %.
    pub error_over_floor: [f64; 2],
    /// Plants on which the loop ran away.
    pub diverged: usize,
    /// Plants on which a limit or a guard changed a force.
    pub held_back: usize,
    /// Share of all samples whose force a limit or a guard changed.
    pub limited: f64,
    /// Largest held force over the largest of the ideal: median and largest.
    pub peak_ratio: [f64; 2],
}

/// Summary of `column` under the `condition` of this place in the set; `None` without a plant. In the
/// paper's set a condition's place is its delay.
#[must_use]
pub fn summary(judged: &[Judged], column: usize, condition: usize) -> Option<Summary> {
    let trials = || {
        judged.iter().flat_map(move |one| {
            let of_column =
                move |trial: &&Trial| trial.column == column && trial.condition == condition;
            one.trials
                .iter()
                .filter(of_column)
                .map(move |trial| (one, trial))
        })
    };
    let sorted = |value: &dyn Fn(&Judged, &Trial) -> f64| {
        let mut values: Vec<f64> = trials().map(|(one, trial)| value(one, trial)).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let errors = sorted(&|_, trial| trial.fidelity.mean_force_error);
    // A floor of 0 is no floor to be over.
    let ratios = sorted(&|_, trial| trial.fidelity.error_over_floor.unwrap_or(f64::INFINITY));
    let peaks = sorted(&|_, trial| trial.force.peak_force / trial.ideal_peak);
    Some(Summary {
        column,
        condition,
        error: [
            quantile(&errors, 0.5)?,
            quantile(&errors, 0.75)?,
            quantile(&errors, 0.9)?,
            quantile(&errors, 1.0)?,
        ],
        error_over_floor: [quantile(&ratios, 0.5)?, quantile(&ratios, 0.9)?],
        diverged: trials().filter(|(_, trial)| trial.diverged).count(),
        held_back: trials().filter(|(_, trial)| trial.limited > 0).count(),
        limited: {
            let sum = |of: fn(&Trial) -> usize| trials().map(|(_, trial)| of(trial)).sum::<usize>();
            sum(|trial| trial.limited) as f64 / sum(|trial| trial.samples) as f64
        },
        peak_ratio: [quantile(&peaks, 0.5)?, quantile(&peaks, 1.0)?],
    })
}

/// The value below which a `share` of the `sorted` values lies, on straight lines between
/// neighbours; `None` of none.
#[must_use]
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an index"
    )]
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    let (low, high) = (sorted[below], sorted[above]);
    // Between infinite neighbours there is no line.
    if low == high {
        Some(low)
    } else {
        Some(low + (high - low) * (place - place.floor()))
    }
}

#[cfg(test)]
mod tests {
    use super::quantile;

    #[test]
    fn quantiles_lie_on_straight_lines_between_neighbours() {
        let values = [1.0, 2.0, 4.0, 8.0, 16.0];
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&values, 0.5), Some(4.0));
        assert_eq!(quantile(&values, 0.75), Some(8.0));
        assert!((quantile(&values, 0.9).unwrap() - 12.8).abs() < 1e-12);
        assert_eq!(quantile(&values, 1.0), Some(16.0));
        assert_eq!(quantile(&[3.0], 0.5), Some(3.0));
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(
            quantile(&[1.0, f64::INFINITY, f64::INFINITY], 0.75),
            Some(f64::INFINITY)
        );
    }
}
