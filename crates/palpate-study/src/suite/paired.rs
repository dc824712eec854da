//! Certainty of a suite's medians, and differences between its columns plant by plant.
//!
//! All columns have the same plants. Intervals are those of the order statistics of a median: exact for any
//! distribution, without resampling.

use serde::Serialize;

use super::Score;
use crate::seeded::CONFIDENCE_PERCENT;
use crate::spread::quantile;

/// Median over the plants with its interval of 95 % confidence. An infinite value is `null` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Median {
    /// The median.
    pub median: f64,
    /// Lower end of the interval; `None` with fewer than 6 plants, whose range has less than 95 % confidence.
    pub low: Option<f64>,
    /// Upper end of the interval, like the lower one.
    pub high: Option<f64>,
}

/// A column against the column with the least median of E, plant by plant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Paired {
    /// E minus that of the column with the least median `[%]`. A plant on which both diverged counts as 0.
    pub difference_percent: Median,
    /// Number of plants with a larger E than that column.
    pub worse_plants: usize,
}

impl Median {
    /// Returns the median of one value per plant; `None` without a plant.
    #[must_use]
    pub fn new(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let rank = lower_rank(values.len());
        Some(Self {
            median: quantile(&values, 0.5)?,
            low: rank.map(|rank| values[rank]),
            high: rank.map(|rank| values[values.len() - 1 - rank]),
        })
    }
}

/// Returns the index of the lower end of the interval among `count` sorted values: k for the largest k with
/// P(X <= k) <= 2.5 % of a binomial distribution with probability 1/2. `None`: fewer than 6 values have no such k.
fn lower_rank(count: usize) -> Option<usize> {
    let outside = 0.5 - 0.005 * CONFIDENCE_PERCENT;
    let n = count as f64;
    let logarithm_of_all = libm::lgamma(n + 1.0) - n * std::f64::consts::LN_2;
    let mut below = 0.0;
    let outside_ranks = (0..count / 2).take_while(|&k| {
        let k = k as f64;
        below += libm::exp(logarithm_of_all - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0));
        below <= outside
    });
    outside_ranks.count().checked_sub(1)
}

/// Returns the comparison of each column under a `condition`, in the order of the columns; `None` for the column with
/// the least median, and without a plant.
pub(super) fn paired(scores: &[Score], columns: usize, condition: usize) -> Vec<Option<Paired>> {
    let errors: Vec<Vec<f64>> = (0..columns)
        .map(|column| {
            let of = |score: &&Score| score.column == column && score.condition == condition;
            scores.iter().filter(of).map(|score| score.error).collect()
        })
        .collect();
    let medians: Vec<Option<f64>> = errors
        .iter()
        .map(|errors| Some(Median::new(errors.clone())?.median))
        .collect();
    let least = (0..columns)
        .filter_map(|column| Some((column, medians[column]?)))
        .min_by(|one, other| one.1.total_cmp(&other.1));
    let Some((least, _)) = least else {
        return vec![None; columns];
    };
    (0..columns)
        .map(|column| {
            if column == least {
                return None;
            }
            let pairs = || errors[column].iter().zip(&errors[least]);
            let differences = pairs().map(
                |(own, of_least)| {
                    if own == of_least { 0.0 } else { own - of_least }
                },
            );
            Some(Paired {
                difference_percent: Median::new(differences.collect())?,
                worse_plants: pairs().filter(|(own, of_least)| own > of_least).count(),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ranks of the tables of the sign test at 95 %, from 1: 2 of 9 values, 6 of 20, 40 of 100.
    #[test]
    fn intervals_have_the_ranks_of_the_sign_test() {
        for (count, rank) in [(9, 2), (20, 6), (100, 40)] {
            assert_eq!(lower_rank(count), Some(rank - 1), "{count}");
        }
        assert_eq!(lower_rank(6), Some(0));
        // The range of five values has 93.75 %.
        assert_eq!([0, 1, 5].map(lower_rank), [None; 3]);
        // 0.5^n underflows, its logarithm does not.
        let rank = lower_rank(10_000).unwrap() as f64;
        assert!((rank - (5000.0 - 98.0)).abs() < 2.0, "{rank}");
    }

    #[test]
    fn a_median_has_the_ends_of_its_interval() {
        let values: Vec<f64> = (1..=9).rev().map(f64::from).collect();
        let median = Median::new(values).unwrap();
        assert_eq!(
            (median.median, median.low, median.high),
            (5.0, Some(2.0), Some(8.0))
        );
        let few = Median::new(vec![1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert_eq!((few.median, few.low, few.high), (3.0, None, None));
        assert_eq!(Median::new(Vec::new()), None);
    }
}
