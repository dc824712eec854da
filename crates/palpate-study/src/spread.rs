//! Spread of a value over seeds, and quantiles.

use serde::Serialize;

use crate::text::short;

/// Spread of a value over the seeds of random numbers. An infinite value is `null` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Spread {
    /// Median over the seeds.
    pub median: f64,
    /// Smallest value of a seed.
    pub least: f64,
    /// Largest value of a seed.
    pub largest: f64,
}

impl Spread {
    /// Returns the spread of one value per seed; `None` without a seed.
    #[must_use]
    pub fn new(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        Some(Self {
            median: quantile(&sorted, 0.5)?,
            least: *sorted.first()?,
            largest: *sorted.last()?,
        })
    }

    /// Returns the spread of each value times a positive factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            median: factor * self.median,
            least: factor * self.least,
            largest: factor * self.largest,
        }
    }

    /// Returns the median with the range: `68.2 (45.1-70.3)`.
    #[must_use]
    pub fn in_short(&self, decimals: usize) -> String {
        let [median, least, largest] =
            [self.median, self.least, self.largest].map(|value| short(value, decimals));
        format!("{median} ({least}-{largest})")
    }
}

/// Returns the value below which a `share` of the `sorted` values lies, interpolated linearly; `None` for an empty
/// slice.
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
    // Equal neighbours, also infinite ones, need no interpolation.
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
