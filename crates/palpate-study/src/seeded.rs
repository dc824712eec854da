//! Methods over several seeds: means with bootstrap intervals, and paired differences.
//!
//! All methods have the same seeds, so a difference between two of them is taken seed by seed.

use std::fmt;

use comfy_table::{Cell, CellAlignment};
use serde::Serialize;

use crate::spread::{Spread, quantile};
use crate::studied::{Outcome, Studied, StudyError};
use crate::suite::Chance;
use crate::sweep::at_each;
use crate::text::{lines, percent, plain_table, wrapped};

/// Confidence of the intervals `[%]`.
pub const CONFIDENCE_PERCENT: f64 = 95.0;

/// Number of resamples of the bootstrap.
const RESAMPLES: usize = 4000;

/// Stream of the resamples, beside the streams of plants and starts.
const BOOTSTRAP: u64 = u64::MAX - 1;

/// Errors of a method with one seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeedScore {
    /// Mean-force error E `[%]`.
    pub mean_force_error: f64,
    /// Force rendering error FRE `[%]`.
    pub force_rendering_error: f64,
    /// Whether the loop diverged or the renderer rejected a sample.
    pub broken: bool,
}

/// Mean of a value over the seeds. An infinite value is `null` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// Lower end of the interval of the mean: percentile bootstrap over the seeds.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Mean {
    /// Returns the mean of one value per seed with its interval; `None` without a seed.
    #[must_use]
    pub fn new(values: &[f64]) -> Option<Self> {
        let count = values.len() as f64;
        if values.is_empty() {
            return None;
        }
        let mean = values.iter().sum::<f64>() / count;
        // The same draws for every value: a difference of two intervals has no noise of the resampling.
        let mut chance = Chance::new(0, BOOTSTRAP);
        let mut means: Vec<f64> = (0..RESAMPLES)
            .map(|_| {
                let drawn = values.iter().map(|_| values[chance.below(values.len())]);
                drawn.sum::<f64>() / count
            })
            .collect();
        means.sort_by(f64::total_cmp);
        let tail = 0.5 - 0.005 * CONFIDENCE_PERCENT;
        Some(Self {
            mean,
            low: quantile(&means, tail)?,
            high: quantile(&means, 1.0 - tail)?,
        })
    }

    /// Returns the mean with its interval: `58.2 (58.0 to 58.3)`.
    fn in_short(self) -> String {
        let [mean, low, high] = [self.mean, self.low, self.high].map(percent);
        format!("{mean} ({low} to {high})")
    }
}

/// A method over the seeds.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SeededMethod {
    /// Name of the method.
    pub method: String,
    /// Mean of the mean-force error E `[%]`; none if a seed has no contact.
    pub mean_force_error_percent: Option<Mean>,
    /// Median and range of E `[%]`.
    pub mean_force_error_over_seeds: Option<Spread>,
    /// Mean of FRE `[%]`; none if a seed has no contact.
    pub force_rendering_error_percent: Option<Mean>,
    /// E minus that of the method with the least mean E, seed by seed `[%]`; none for that method.
    pub more_than_least_percent: Option<Mean>,
    /// Number of seeds with a larger E than that method.
    pub worse_seeds: usize,
    /// Number of seeds with which the loop diverged or the renderer rejected a sample.
    pub broken_seeds: usize,
}

/// Methods over several seeds of a scene.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Seeded {
    /// Number of seeds.
    pub seeds: usize,
    /// The first seed; the others follow it.
    pub first_seed: u64,
    /// Largest change of the start of a device along each axis; none if the starts are those of the scene.
    pub start_range_m: Option<f64>,
    /// Confidence of the intervals.
    pub confidence_percent: f64,
    /// The method with the least mean E; none without contact.
    pub least: Option<String>,
    /// One entry for each method.
    pub methods: Vec<SeededMethod>,
}

impl Seeded {
    /// Creates the report of the scores of `methods`: a list for each seed from `first_seed` on, with an entry for each
    /// method, `None` where the scene has no contact.
    #[must_use]
    pub fn new(
        first_seed: u64,
        start_range_m: Option<f64>,
        methods: &[&str],
        scores: &[Vec<Option<SeedScore>>],
    ) -> Self {
        let of = |method: usize| -> Option<Vec<SeedScore>> {
            scores.iter().map(|seed| seed[method]).collect()
        };
        let errors = |method: usize| -> Option<Vec<f64>> {
            let scores = of(method)?;
            Some(scores.iter().map(|score| score.mean_force_error).collect())
        };
        let means = (0..methods.len())
            .filter_map(|method| Some((method, Mean::new(&errors(method)?)?.mean)));
        let least = means.min_by(|a, b| a.1.total_cmp(&b.1)).map(|it| it.0);
        let of_least = least.and_then(errors);
        let report = |(number, method): (usize, &&str)| {
            let (scores, errors) = (of(number), errors(number));
            let differences: Vec<f64> = match (&errors, &of_least) {
                (Some(errors), Some(of_least)) if least != Some(number) => {
                    errors.iter().zip(of_least).map(|(a, b)| a - b).collect()
                }
                _ => Vec::new(),
            };
            let fre = scores.iter().flatten();
            let fre: Vec<f64> = fre.map(|score| score.force_rendering_error).collect();
            let broken = scores.iter().flatten().filter(|score| score.broken);
            SeededMethod {
                method: (*method).to_owned(),
                mean_force_error_percent: errors.as_deref().and_then(Mean::new),
                mean_force_error_over_seeds: errors.and_then(Spread::new),
                force_rendering_error_percent: Mean::new(&fre),
                more_than_least_percent: Mean::new(&differences),
                worse_seeds: differences.iter().filter(|more| **more > 0.0).count(),
                broken_seeds: broken.count(),
            }
        };
        Self {
            seeds: scores.len(),
            first_seed,
            start_range_m,
            confidence_percent: CONFIDENCE_PERCENT,
            least: least.map(|number| methods[number].to_owned()),
            methods: methods.iter().enumerate().map(report).collect(),
        }
    }
}

impl fmt::Display for Seeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let least = self.least.as_deref().unwrap_or("least");
        let header = [
            "method".to_owned(),
            format!("mean E % ({CONFIDENCE_PERCENT} %)"),
            format!("minus {least} ({CONFIDENCE_PERCENT} %)"),
            "worse".into(),
        ];
        let mut table = plain_table(CellAlignment::Left, &header.each_ref().map(|it| &**it));
        let right = |text: Option<String>| {
            Cell::new(text.unwrap_or_else(|| "-".into())).set_alignment(CellAlignment::Right)
        };
        for of in &self.methods {
            let more = of.more_than_least_percent;
            table.add_row([
                Cell::new(&of.method),
                right(of.mean_force_error_percent.map(Mean::in_short)),
                right(more.map(Mean::in_short)),
                right(more.map(|_| format!("{} of {}", of.worse_seeds, self.seeds))),
            ]);
        }
        writeln!(f, "{}\n", lines(&table))?;
        let starts = self.start_range_m.map_or_else(String::new, |range| {
            format!(
                " Each seed changes the start of each device by up to {range} m along each axis."
            )
        });
        let broken: Vec<_> = (self.methods.iter())
            .filter(|of| of.broken_seeds > 0)
            .map(|of| format!("{} {} of {}", of.method, of.broken_seeds, self.seeds))
            .collect();
        let broken = match broken.len() {
            0 => String::new(),
            _ => format!(" Diverged or refused samples: {}.", broken.join(", ")),
        };
        let words = format!(
            "{} seeds from {} on.{starts} Intervals of the mean: percentile bootstrap over the seeds. The difference \
             to the method with the least mean E is taken seed by seed.{broken}",
            self.seeds, self.first_seed
        );
        writeln!(f, "{}", wrapped(&words))
    }
}

/// Returns the scores of columns on a scene; `None` where the ideal has no contact.
///
/// # Errors
/// The scene or a column cannot be run.
pub fn scores<S: Studied>(
    scene: &S,
    columns: &[S::Column],
) -> Result<Vec<Option<SeedScore>>, StudyError> {
    let score = |outcomes: &Vec<Outcome>| {
        let outcome = &outcomes[0];
        outcome.fidelity.map(|fidelity| SeedScore {
            mean_force_error: fidelity.mean_force_error,
            force_rendering_error: fidelity.force_rendering_error,
            broken: outcome.diverged || outcome.refused > 0,
        })
    };
    Ok(scene.evaluate(columns)?.iter().map(score).collect())
}

/// Evaluates `score` for each seed on the threads of rayon. Calls `done` after each.
///
/// # Errors
/// The first error of a seed.
pub fn over_seeds<R: Send, E: Send>(
    seeds: std::ops::Range<u64>,
    done: impl Fn() + Sync,
    score: impl Fn(u64) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let seeds: Vec<u64> = seeds.collect();
    at_each(&seeds, done, |seed| score(*seed))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn score(error: f64) -> Option<SeedScore> {
        Some(SeedScore {
            mean_force_error: error,
            force_rendering_error: 2.0 * error,
            broken: false,
        })
    }

    #[test]
    fn an_interval_contains_the_mean_and_shrinks_with_the_seeds() {
        let values: Vec<f64> = (0..100).map(|index| f64::from(index % 10)).collect();
        let few = Mean::new(&values[..10]).unwrap();
        let many = Mean::new(&values).unwrap();
        assert_eq!((few.mean, many.mean), (4.5, 4.5));
        // The standard error is 2.87 over the root of the number; 1.96 of them are the interval of a normal mean.
        for (mean, count) in [(few, 10.0_f64), (many, 100.0)] {
            let expected = 1.96 * 2.872 / count.sqrt();
            assert!(
                (0.5 * (mean.high - mean.low) / expected - 1.0).abs() < 0.1,
                "{mean:?}"
            );
        }
        assert_eq!(
            Mean::new(&[3.0; 5]).map(|mean| (mean.low, mean.high)),
            Some((3.0, 3.0))
        );
        assert_eq!(Mean::new(&[]), None);
    }

    /// A method that is worse by the same amount with every seed has a difference without spread.
    #[test]
    fn differences_are_taken_seed_by_seed() {
        let scores: Vec<_> = [1.0, 5.0, 9.0]
            .map(|error| vec![score(error + 0.5), score(error)])
            .to_vec();
        let report = Seeded::new(7, None, &["a", "b"], &scores);
        assert_eq!(report.least.as_deref(), Some("b"));
        let [a, b] = &report.methods[..] else {
            panic!("two methods")
        };
        assert_eq!(a.more_than_least_percent, Mean::new(&[0.5; 3]));
        assert_eq!((a.worse_seeds, b.worse_seeds), (3, 0));
        assert_eq!(b.more_than_least_percent, None);
        assert!(a.mean_force_error_percent.unwrap().low < 2.0);
    }

    #[test]
    fn a_seed_without_contact_leaves_no_mean() {
        let report = Seeded::new(0, None, &["a"], &[vec![score(1.0)], vec![None]]);
        assert_eq!(report.methods[0].mean_force_error_percent, None);
        assert_eq!(report.least, None);
    }
}
